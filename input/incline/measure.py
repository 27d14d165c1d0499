# SPDX-License-Identifier: BSD-3-Clause
"""Profiles of a layer of beads on slopes of several angles, against that of Bagnold.

    python input/incline/measure.py --scree build/bin/scree [--only 24]
"""
import math
import sys
from pathlib import Path

import numpy as np

ROOT = Path(__file__).resolve().parents[2]
sys.path[:0] = [str(ROOT / "scripts"), str(ROOT / "test/support")]
import flows                           # noqa: E402
import scree_post                      # noqa: E402
from scree_scene import Study, Table   # noqa: E402

ANGLES = {22: 6.0, 24: 4.0, 26: 4.0}   # [degrees]: time until nothing changes any more [s]
HEIGHT = 0.01                          # of the layer [m]
COLOURS = {22: "#0072b2", 24: "#009e73", 26: "#d55e00"}


def settings(angle, end):
    """The slope as a direction of gravity."""
    slope = math.radians(angle)
    return {"effects.gravity_vector": f"{flows.GRAVITY * math.sin(slope):.9g},0,{-flows.GRAVITY * math.cos(slope):.9g}",
            "time.t_end": end}


def profile(snap):
    """Heights [m] and speeds along the slope [m/s], from the base up."""
    order = np.argsort(snap.points[:, 2])
    return snap.points[order, 2], snap.fields["velocity"][order, 0]


def tables(runs):
    """Speed of the surface, errors of speed and friction."""
    table = Table(["slope", "surface of the exact flow [m/s]", "highest particle [m/s]", "exact there [m/s]",
                   "worst particle / surface", "mean speed", "shear over normal stress", "tan"])
    for name, run in runs.items():
        angle, snap = int(name), run.last_snapshot()
        place, speed = profile(snap)
        exact, stress = flows.bagnold(place, angle, HEIGHT), snap.fields["stress"].mean(axis=0)
        surface = float(flows.bagnold(HEIGHT, angle, HEIGHT))
        table.rows.append([angle, f"{surface:.4f}", f"{speed[-1]:.4f}", f"{exact[-1]:.4f}",
                           f"{np.abs(speed - exact).max() / surface:.1%}", f"{speed.mean() / exact.mean() - 1.0:+.1%}",
                           f"{abs(stress[5] / stress[2]):.4f}", f"{math.tan(math.radians(angle)):.4f}"])
    return [table]


def draw(runs, plot):
    """Profiles at the end, and those of one slope on the way there."""
    figure, panels = plot.subplots(1, 2, figsize=(9.5, 3.8), layout="constrained")
    heights = np.linspace(0.0, HEIGHT, 100)
    for name, run in runs.items():
        angle = int(name)
        place, speed = profile(run.last_snapshot())
        panels[0].plot(flows.bagnold(heights, angle, HEIGHT), 1e3 * heights, color=COLOURS[angle], linewidth=1.2)
        panels[0].plot(speed, 1e3 * place, "o", color=COLOURS[angle], markersize=3.5, label=f"{angle} degrees")
    if "24" in runs:
        series = runs["24"].series
        for time, file in series[:10]:
            place, speed = profile(scree_post.snapshot(file))
            panels[1].plot(speed, 1e3 * place, color=plot.get_cmap("viridis")(time / series[9][0]),
                           label=f"{time:.2f} s" if file in (series[1][1], series[4][1], series[9][1]) else None)
    for panel, title in zip(panels, ("at the end; lines: steady flow of the law", "24 degrees, from rest")):
        panel.set(title=title, xlabel="speed along the slope [m/s]", ylabel="height above the base [mm]")
        panel.legend(fontsize=8)
    return figure


CASES = {str(angle): ("scene.nml", settings(angle, end)) for angle, end in ANGLES.items()}

if __name__ == "__main__":
    Study(__file__, CASES, tables, {"picture.png": draw}).main()
