# SPDX-License-Identifier: BSD-3-Clause
"""Depth of a ball in a bed of beads against the speed of impact.

    python input/sand_impact/measure.py --scree build/bin/scree
"""
import sys
from pathlib import Path

import numpy as np

sys.path[:0] = [str(Path(__file__).resolve().parents[2] / folder) for folder in ("scripts", "python/src")]
import scree_post                      # noqa: E402
from scree.drawing import look     # noqa: E402
from scree_post import panel     # noqa: E402
from scree_scene import Study, Table   # noqa: E402

SPEEDS = (1.0, 2.0, 3.0)               # [m/s]
CONES = {"plane_strain": "inside", "compression": "outside"}
DIAMETER, BALL, BED, FRICTION, GRAVITY = 0.0254, 7700.0, 1520.0, 0.45, 9.81   # of the deck
BODY = 2                               # the ball in the field body


def fit(speed):
    """Depth by Uehara, Ambroso, Ojha and Durian, whose height of fall includes the depth itself [m]."""
    depth = 0.0
    for _ in range(100):
        height = speed ** 2 / (2.0 * GRAVITY) + depth
        depth = 0.14 / FRICTION * np.sqrt(BALL / BED) * DIAMETER ** (2 / 3) * height ** (1 / 3)
    return depth


def path(run):
    """Times [s], places of the lowest particle [m] and speeds of the ball [m/s]."""
    found = []
    for time, file in run.series:
        snap = scree_post.snapshot(file, ("body", "velocity", "mass"))
        ball = snap.fields["body"] == BODY
        found.append((time, snap.points[ball, 2].min(), np.average(snap.fields["velocity"][ball, 2],
                                                                   weights=snap.fields["mass"][ball])))
    return np.array(found).T


def tables(runs):
    """Depth by speed."""
    table = Table(["cone", "speed [m/s]", "depth [mm]", "fit [mm]", "depth / fit", "stops after [ms]"])
    for name, run in runs.items():
        cone, speed = name.rsplit("_", 1)
        time, low, velocity = path(run)
        stop = time[np.nonzero(velocity > -0.02 * float(speed))[0][0]]
        table.rows.append([CONES[cone], speed, f"{-1e3 * low.min():.1f}", f"{1e3 * fit(float(speed)):.1f}",
                           f"{-low.min() / fit(float(speed)):.2f}", f"{1e3 * stop:.0f}"])
    return [table]


def numbers(runs):
    """How far the inner cone is off the fit, and what the outer one does."""
    speeds = {speed: -path(runs[f"plane_strain_{speed}"])[1].min() for speed in SPEEDS}
    worst = max(abs(depth / fit(speed) - 1.0) for speed, depth in speeds.items())
    outer = -path(runs["compression_2.0"])[1].min() / speeds[2.0]
    return {"worst": f"{100 * worst:.0f}", "outer": f"{outer:.2f}"}


def draw(runs, plot):
    """The bed at three times, and the way of the ball."""
    figure, panels = plot.subplots(1, 4, figsize=(10.5, 3.8), width_ratios=(1, 1, 1, 1.2), layout="constrained")
    run = runs["plane_strain_2.0"]
    for axes, moment in zip(panels, (0.0, 0.012, 0.05)):
        snap = run.near(moment)
        ball = snap.fields["body"] == BODY
        speed = np.linalg.norm(snap.fields["velocity"], axis=1)
        shown = panel.particles(axes, snap, speed, low=0.0, high=1.0, colours=look.SOOT, rows=~ball, sides=(-1, 1))
        panel.particles(axes, snap, "#d55e00", rows=ball, sides=(-1, 1))
        panel.window(axes, (-75, 75, -100, 35), "r [mm]", title=f"{1e3 * snap.time:.0f} ms")
    panels[0].set_ylabel("z [mm]")
    for axes in panels[1:3]:
        axes.set_yticklabels([])
    figure.colorbar(shown, ax=panels[:3], label="speed of the beads [m/s]",
                    location="bottom", shrink=0.6)
    for speed, colour in zip(SPEEDS, ("#0072b2", "#009e73", "#e69f00")):
        time, low, _ = path(runs[f"plane_strain_{speed}"])
        panels[3].plot(1e3 * time, 1e3 * low, color=colour, label=f"{speed:.0f} m/s")
        panels[3].axhline(-1e3 * fit(speed), color=colour, ls=":")
    panels[3].set(xlabel="time [ms]", ylabel="lowest point of the ball [mm]")
    panels[3].set_title("dotted: fit of measurements")
    panels[3].legend(loc="upper right")
    return figure


CASES = {f"{cone}_{speed}": ("scene.nml", {"body[ball].velocity": f"0,0,{-speed}", "material[beads].dp_cone": cone})
         for cone in CONES for speed in (SPEEDS if cone == "plane_strain" else SPEEDS[1:2])}

if __name__ == "__main__":
    Study(__file__, CASES, tables, {"picture.png": draw}, numbers={"README.md": numbers},
          as_it_stands="plane_strain_2.0").main()
