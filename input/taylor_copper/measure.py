# SPDX-License-Identifier: BSD-3-Clause
"""Copper bars on a wall: sizes, strain and books by method and cells, against experiment and finite elements.

    python input/taylor_copper/measure.py --scree build/bin/scree
"""
import math
import sys
from pathlib import Path

import numpy as np

ROOT = Path(__file__).resolve().parents[2]
sys.path[:0] = [str(ROOT / "scripts"), str(ROOT / "python/src"), str(ROOT / "test/support")]
import scree_post                      # noqa: E402
import taylor                          # noqa: E402
from scree_post import panel           # noqa: E402
from scree_scene import Study, Table   # noqa: E402

METHODS = {"mpm": ("plain", {"run.method": "mpm"}),
           "gimp": ("GIMP", {"run.method": "mpm", "method.basis": "gimp"}),
           "ddmp": ("DDMP", {"run.method": "ddmp"}),
           "bbar": ("DDMP, bbar", {"run.method": "ddmp", "method.antilock": "bbar"})}
#: Deck, bar, and cells on the radius with their size [mm].
BARS = {"scene": (taylor.MEASURED, {3: 1.27, 6: 0.635, 12: 0.3175}), "classic": (taylor.CLASSIC, {4: 0.8, 8: 0.4})}
#: Length, diameter of the foot, waist by finite elements [mm].
ELEMENTS = (16.20, 13.39, 10.17)
#: Length, radius of the foot [mm], greatest plastic strain.
CODES = {"finite elements": ("21.44 to 21.48", "7.17 to 7.20", "3.22 to 3.31"),
         "other codes": ("21.26 to 21.66", "6.97 to 7.24", "2.47 to 3.25")}
HEIGHTS = np.linspace(5.0e-4, 1.5e-2, 300)                     # at which profiles are compared [m]
WAIST = 0.2 * taylor.MEASURED.length                           # height of the waist [mm]


def shape(run, bar):
    """Length, greatest radius of the foot, diameter a fifth of the first length above the wall, and outline [m]."""
    series = run.series
    return taylor.measure(bar, *(scree_post.snapshot(series[place][1]) for place in (0, -1)))


def kinetic_left(run):
    """Kinetic energy at the end over that at the start."""
    kinetic = run.history["kinetic"]
    return kinetic[-1] / kinetic[0]


def of_bar(runs, bar):
    """Title of the method, cells on the radius, and run, of all runs of a bar."""
    for name, (title, _) in METHODS.items():
        for cells in BARS[bar][1]:
            if f"{bar}_{name}_{cells}" in runs:
                yield title, cells, runs[f"{bar}_{name}_{cells}"]


def measured(runs):
    """Sizes of the measured bar."""
    table = Table(["bar of the experiment", "cells on the radius", "length [mm]", "foot [mm]", "waist [mm]",
                   "mean error", "kinetic energy left", "error of energy", "of momentum"])
    table.rows.append(["experiment", "", *taylor.EXPERIMENT, "", "", "", ""])
    length, foot, waist = ELEMENTS
    off = taylor.difference({"length": 1e-3 * length, "foot": 5e-4 * foot, "waist": 1e-3 * waist})
    table.rows.append(["finite elements", "", *(f"{size:.2f}" for size in ELEMENTS), f"{100 * off:.1f} %", "", "", ""])
    for title, cells, run in of_bar(runs, "scene"):
        found = shape(run, taylor.MEASURED)
        table.rows.append([title, cells, f"{1e3 * found['length']:.2f}", f"{2e3 * found['foot']:.2f}",
                           f"{1e3 * found['waist']:.2f}", f"{100 * taylor.difference(found):.1f} %",
                           f"{kinetic_left(run):.0e}", f"{run.error('energy_error'):.0e}",
                           f"{run.error('momentum_error'):.0e}"])
    return table


def radii(run):
    """Radius of the measured bar at the heights [m]."""
    side = shape(run, taylor.MEASURED)["shape"]["side"]
    return np.interp(HEIGHTS, side[:, 1], side[:, 0])


def converged(runs):
    """How much the profile changes when cells are halved, and the order that two halvings tell."""
    table = Table(["profile of the bar, rms change [mm]", "from 3 to 6 cells", "from 6 to 12", "order"])
    for name, (title, _) in METHODS.items():
        names = [f"scene_{name}_{cells}" for cells in BARS["scene"][1]]
        if set(names) <= set(runs):
            profiles = [radii(runs[one]) for one in names]
            first, last = (1e3 * np.sqrt(np.mean((fine - coarse) ** 2)) for coarse, fine in zip(profiles, profiles[1:]))
            table.rows.append([title, f"{first:.3f}", f"{last:.3f}", f"{math.log2(first / last):.1f}"])
    return table


def classic(runs):
    """Sizes and strain of the bar that codes are compared by."""
    table = Table(["classic bar", "cells on the radius", "length [mm]", "radius of the foot [mm]",
                   "greatest plastic strain", "kinetic energy left", "error of energy"])
    table.rows += [[title, "", *values, "", ""] for title, values in CODES.items()]
    for title, cells, run in of_bar(runs, "classic"):
        found = shape(run, taylor.CLASSIC)
        table.rows.append([title, cells, f"{1e3 * found['length']:.2f}", f"{1e3 * found['foot']:.2f}",
                           f"{run.last_snapshot().fields['plastic_strain'].max():.2f}", f"{kinetic_left(run):.0e}",
                           f"{100 * run.error('energy_error'):.1f} %"])
    return table


def tables(runs):
    """Both bars, and how the first converges."""
    return [measured(runs), converged(runs), classic(runs)]


def draw(runs, plot):
    """The measured bar every 20 us by plastic strain, and its profile at the end by method and cells."""
    names = ("scene_ddmp_3", "scene_ddmp_6", "scene_ddmp_12", "scene_bbar_3")
    if not set(names) <= set(runs):
        return None
    figure, (left, right) = plot.subplots(1, 2, figsize=(10.5, 3.8), width_ratios=(2.2, 1.0), layout="constrained")
    for number, (time, file) in enumerate(runs["scene_ddmp_12"].series):
        snap = scree_post.snapshot(file)
        shown = panel.particles(left, snap, snap.fields["plastic_strain"], low=0.0, high=1.2, sides=(-1, 1),
                                along=17.0 * number)
        left.text(17.0 * number, 1e3 * snap.points[:, 2].max() + 0.6, f"{1e6 * time:.0f} µs", ha="center")
    left.set(aspect="equal", xlim=(-9.0, 17.0 * number + 9.0), ylim=(-0.5, 28.5), ylabel="z [mm]", xticks=[])
    figure.colorbar(shown, ax=left, label="plastic strain", shrink=0.7)
    for name, style, label in zip(names, (":", "--", "-", "-."),
                                  ("DDMP, 3 cells", "6 cells", "12 cells", "bbar, 3 cells")):
        found = shape(runs[name], taylor.MEASURED)["shape"]
        outline = np.concatenate([found["foot"], found["side"], found["rear"][::-1]])
        right.plot(1e3 * outline[:, 0], 1e3 * outline[:, 1], style, lw=1.3, label=label,
                   color="#d55e00" if "bbar" in name else "#0072b2")
    length, foot, waist = taylor.EXPERIMENT
    right.plot([0.5 * foot, 0.5 * waist, 0.0], [0.0, WAIST, length], "ko", ms=6, clip_on=False, label="experiment")
    right.set(xlim=(0, 7.2), ylim=(0, 18), xlabel="r [mm]", ylabel="z [mm]")
    right.legend(fontsize=9, loc="center left")
    return figure


CASES = {f"{bar}_{name}_{cells}": (deck.deck, {**method, "grid.dx": size})
         for bar, (deck, sizes) in BARS.items() for name, (_, method) in METHODS.items()
         for cells, size in sizes.items()}

if __name__ == "__main__":
    Study(__file__, CASES, tables, {"picture.png": draw}, as_it_stands="scene_ddmp_12").main()
