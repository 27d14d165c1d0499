# SPDX-License-Identifier: BSD-3-Clause
"""Run-out of a landslide with and without a barrier, and the force on the barrier.

    python input/terrain/measure.py --scree build/bin/scree
"""
import sys
from pathlib import Path

import numpy as np
import pandas as pd

HERE = Path(__file__).resolve().parent
sys.path[:0] = [str(HERE.parents[1] / folder) for folder in ("scripts", "python/src")]
import scree_post                      # noqa: E402
from scree_scene import Study, Table   # noqa: E402

FRICTION, SHIFT, CELL, HEADER = 0.3, (702000.0, 5180000.0, 1450.0), 4.0, 6   # of the deck and the rasters
BARRIER = (200.0, -40.0, 12.0, 80.0)   # corner and edges in the plan [m]
SHOWN = (4.0, 12.0, 26.0)              # times of the picture [s]


def centre(snap):
    """Centre of mass [m]."""
    return np.average(snap.points, axis=0, weights=snap.fields["mass"])


def walls(run):
    """Times [s] and forces along x on the barrier [N]."""
    rows = pd.read_csv(run.folder / run.file_of("forces"))
    return rows["time [s]"].to_numpy(), rows["barrier_force_x [N]"].to_numpy()


def ratio(run):
    """Drop of the centre of mass over its distance."""
    first, last = (centre(scree_post.snapshot(run.series[n][1])) for n in (0, -1))
    return (first[2] - last[2]) / (last[0] - first[0])


def tables(runs):
    """Where the material stops, and what the barrier gets."""
    table = Table(["run", "distance of the centre [m]", "drop [m]", "drop / distance", "behind the barrier",
                   "greatest force [MN]", "at [s]"])
    for name, run in runs.items():
        first, snap = scree_post.snapshot(run.series[0][1]), run.last_snapshot()
        way = centre(snap) - centre(first)
        mass = snap.fields["mass"]
        passed = mass[snap.points[:, 0] > BARRIER[0] + BARRIER[2]].sum() / mass.sum()
        time, force = walls(run)
        most = int(np.argmax(force))
        there = name == "barrier"
        table.rows.append([name, f"{way[0]:.0f}", f"{-way[2]:.0f}", f"{-way[2] / way[0]:.3f}", f"{100 * passed:.0f} %",
                           f"{1e-6 * force[most]:.1f}" if there else "-", f"{time[most]:.1f}" if there else "-"])
    return [table]


def numbers(runs):
    """Mass of the slide, and the ratio without a barrier over the friction."""
    mass = scree_post.snapshot(runs["free"].series[0][1]).fields["mass"].sum()
    return {"mass": f"{1e-6 * mass:.1f}", "over": f"{100 * (ratio(runs['free']) / FRICTION - 1):.0f}"}


def draw(runs, plot):
    """Plans at three times, and the force on the barrier."""
    heights = np.loadtxt(HERE / "heights.asc", skiprows=HEADER)[::-1] - SHIFT[2]
    east = (np.arange(heights.shape[1]) - 0.5) * CELL
    north = (np.arange(heights.shape[0]) + 0.5 - 0.5 * heights.shape[0]) * CELL
    figure, panels = plot.subplots(2, 2, figsize=(10.0, 5.2), layout="constrained")
    run = runs["barrier"]
    for axes, moment in zip(panels.flat, SHOWN):
        snap = run.near(moment)
        order = np.argsort(snap.points[:, 2])
        speed = np.linalg.norm(snap.fields["velocity"], axis=1)[order]
        lines = axes.contour(east, north, heights, levels=np.arange(0, 130, 10), colors="0.6", linewidths=0.7)
        axes.clabel(lines, fontsize=7)
        shown = axes.scatter(snap.points[order, 0], snap.points[order, 1], c=speed, s=5, vmin=0, vmax=15)
        axes.add_patch(plot.Rectangle(BARRIER[:2], *BARRIER[2:], facecolor="#d55e00", alpha=0.7))
        axes.set(aspect="equal", xlim=(0, 360), ylim=(-60, 60), title=f"{snap.time:.0f} s", xlabel="x [m]",
                 ylabel="y [m]")
    figure.colorbar(shown, ax=panels[:, 0], label="speed [m/s]", location="left", shrink=0.7)
    time, force = walls(run)
    panels[1, 1].plot(time, 1e-6 * force, color="#d55e00")
    panels[1, 1].set(xlabel="time [s]", ylabel="force on the barrier [MN]", title="along x")
    return figure


CASES = {"barrier": ("scene.nml", {}), "free": ("scene.nml", {"region[barrier].translate": "0,0,-200"})}

if __name__ == "__main__":
    Study(__file__, CASES, tables, {"picture.png": draw}, numbers={"README.md": numbers}, as_it_stands="barrier").main()
