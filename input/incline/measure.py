# SPDX-License-Identifier: BSD-3-Clause
"""Profiles of a layer of beads on slopes of several angles, against that of Bagnold.

    python input/incline/measure.py --scree build/bin/scree [--only 24]
"""
import math
import sys
from pathlib import Path

import numpy as np

ROOT = Path(__file__).resolve().parents[2]
sys.path[:0] = [str(ROOT / "scripts"), str(ROOT / "python/src"), str(ROOT / "test/support")]
import flows                           # noqa: E402
import scree_post                      # noqa: E402
from scree_scene import Study, Table   # noqa: E402

ANGLES = {22: 6.0, 24: 3.5, 26: 4.0}   # [degrees]: time until nothing changes any more [s]
HEIGHT = 0.01                          # of the layer [m]
#: What is changed on the slope of 24 degrees, and how.
OTHERS = {"soft": ("bulk modulus of 300 times the weight", {"material.bulk": 43262.0, "material.shear": 19900.0}),
          "flip": ("`flip = 0.999`", {"method.flip": 0.999})}
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


def errors(run, angle):
    """The worst of the particles over the speed of the surface, and the error of the mean speed [%]."""
    place, speed = profile(run.last_snapshot())
    exact = flows.bagnold(place, angle, HEIGHT)
    worst = np.abs(speed - exact).max() / flows.bagnold(HEIGHT, angle, HEIGHT)
    return [f"{100 * worst:.1f} %", f"{100 * (speed.mean() / exact.mean() - 1):+.1f} %"]


def on_slopes(runs):
    """Those of the runs in which nothing but the slope differs, by slope [degrees]."""
    return {int(name): run for name, run in runs.items() if name not in OTHERS}


def tables(runs):
    """Speed of the surface, errors of speed and friction; what the choices make of them."""
    table = Table(["slope", "surface of the exact flow [m/s]", "highest particle [m/s]", "exact there [m/s]",
                   "worst particle / surface", "mean speed", "shear over normal stress", "tan"])
    for angle, run in on_slopes(runs).items():
        snap = run.last_snapshot()
        place, speed = profile(snap)
        exact, stress = flows.bagnold(place, angle, HEIGHT), snap.fields["stress"].mean(axis=0)
        surface = float(flows.bagnold(HEIGHT, angle, HEIGHT))
        table.rows.append([angle, f"{surface:.4f}", f"{speed[-1]:.4f}", f"{exact[-1]:.4f}",
                           *errors(run, angle),
                           f"{abs(stress[5] / stress[2]):.4f}", f"{math.tan(math.radians(angle)):.4f}"])
    other = Table(["24 degrees with", "worst particle / surface", "mean speed"])
    other.rows = [[title, *errors(runs[name], 24)] for name, (title, _) in OTHERS.items() if name in runs]
    return [table, other]


def draw(runs, plot):
    """Profiles at the end, and those of one slope on the way there."""
    figure, panels = plot.subplots(1, 2, figsize=(9.6, 4.2), layout="constrained")
    heights = np.linspace(0.0, HEIGHT, 100)
    for angle, run in on_slopes(runs).items():
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
        panel.legend(fontsize=9)
    return figure


CASES = {str(angle): ("scene.nml", settings(angle, end)) for angle, end in ANGLES.items()}
CASES.update({name: ("scene.nml", values) for name, (_, values) in OTHERS.items()})

if __name__ == "__main__":
    Study(__file__, CASES, tables, {"picture.png": draw}, as_it_stands="24").main()
