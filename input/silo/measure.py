# SPDX-License-Identifier: BSD-3-Clause
"""Beads that runs out of a silo: rate against the width of the outlet and the height of the filling, and a fluid.

    python input/silo/measure.py --scree build/bin/scree
"""
import sys
from pathlib import Path

import numpy as np

sys.path[:0] = [str(Path(__file__).resolve().parents[2] / folder) for folder in ("scripts", "python/src")]
from scree_post import panel           # noqa: E402
from scree_scene import Study, Table  # noqa: E402

GRAVITY, DENSITY, WIDTH, HEIGHT = 9.81, 1477.0, 0.1, 0.3     # of the deck: half the silo, height of the filling
CELL, FINE = 0.00625, 0.005
# name: what it is, outlet [m], cell [m]
RUNS = {"narrow": ("beads", 0.0375, CELL), "middle": ("beads", 0.0625, CELL), "wide": ("beads", 0.0875, CELL),
        "fluid": ("fluid", 0.0625, CELL), "narrow_fine": ("beads", 0.04, FINE), "middle_fine": ("beads", 0.06, FINE),
        "wide_fine": ("beads", 0.08, FINE), "narrow_guess": ("30 degrees", 0.0375, CELL),
        "middle_guess": ("30 degrees", 0.0625, CELL), "wide_guess": ("30 degrees", 0.0875, CELL)}
# what the scene assumed before a cell of spheres was measured
GUESS = {"material.friction_angle": 30, **{f"boundary[{n}].friction": 0.4 for n in (2, 3, 4)}}
EARLY, LATE = (0.1, 0.25), (0.3, 0.5)                        # parts of the filling that have left


def opening(outlet, cell):
    """Values of the deck for an outlet: its last node is half a cell beyond the edge of the gate."""
    edge = 0.5 * (outlet - cell)
    return {"region[floor].lo": f"{edge:.7f},0,-1", "region[gate].hi": f"{edge:.7f},1,1"}


CASES = {
    "narrow": ("scene.nml", {"time.t_end": 1.1, **opening(0.0375, CELL)}),
    "middle": ("scene.nml", {}),
    "wide": ("scene.nml", {"time.t_end": 0.6, **opening(0.0875, CELL)}),
    "fluid": ("fluid.nml", {}),
    "narrow_fine": ("scene.nml", {"grid.dx": FINE, "time.t_end": 1.1, **opening(0.04, FINE)}),
    "middle_fine": ("scene.nml", {"grid.dx": FINE, **opening(0.06, FINE)}),
    "wide_fine": ("scene.nml", {"grid.dx": FINE, "time.t_end": 0.65, **opening(0.08, FINE)}),
    "narrow_guess": ("scene.nml", {"time.t_end": 1.1, **opening(0.0375, CELL), **GUESS}),
    "middle_guess": ("scene.nml", GUESS),
    "wide_guess": ("scene.nml", {"time.t_end": 0.6, **opening(0.0875, CELL), **GUESS}),
}


def rate(run, window):
    """Rate of the whole silo while the part that has left grows from one value to another [kg/(m s)], or None."""
    history = run.history
    gone = history["lost_mass"] / history["mass"][0]
    if gone[-1] < window[1]:
        return None
    times = [np.interp(part, gone, history["time"]) for part in window]
    return 2.0 * (window[1] - window[0]) * history["mass"][0] / (times[1] - times[0])


def tables(runs):
    """Rates, and the law through those of the three widths."""
    table = Table(["material", "outlet D [mm]", "cell [mm]", "rate W [kg/(m s)]", "W / (rho sqrt(g) D^1.5)",
                   "later / earlier rate"])
    guess = Table(["outlet D [mm]", "W, 30 degrees and walls of 0.4", "W, measured friction", "ratio"])
    for name in runs:
        matter, outlet, cell = RUNS[name]
        early, late = rate(runs[name], EARLY), rate(runs[name], LATE)
        if matter == "30 degrees":
            now = runs.get(name.removesuffix("_guess"))
            if now:
                now = rate(now, EARLY)
                guess.rows.append([f"{1000 * outlet:g}", f"{early:.1f}", f"{now:.1f}", f"{now / early:.2f}"])
            continue
        table.rows.append([matter, f"{1000 * outlet:g}", f"{1000 * cell:g}", f"{early:.1f}",
                           f"{early / (DENSITY * GRAVITY ** 0.5 * outlet ** 1.5):.3f}",
                           f"{late / early:.2f}" if late else "-"])
    kinds = [("beads", CELL), ("beads", FINE), ("30 degrees", CELL)]
    laws = [law(runs, *kind) for kind in kinds]
    fit = Table(["law of the three widths", *(f"{matter}, cells of {1000 * cell:g} mm" for matter, cell in kinds)])
    for row, (title, form) in enumerate((("C", ".2f"), ("k [cells]", ".2f"), ("greatest difference from it [%]", ".1f"),
                                         ("exponent of a law without k", ".2f"))):
        fit.rows.append([title, *(f"{one[row]:{form}}" if one else "" for one in laws)])
    return [table, guess, fit]


def law(runs, matter, cell):
    """C, k [cells] and the worst difference [%] of W = C rho sqrt(g) (D - k)^1.5, and the exponent if k were 0.

    Power 2/3 of W is a straight line in D. None if not all widths were run with this cell [m].
    """
    names = [name for name, (kind, _, size) in RUNS.items() if kind == matter and size == cell]
    if not set(names) <= set(runs):
        return None
    outlets = np.array([RUNS[name][1] for name in names])
    rates = np.array([rate(runs[name], EARLY) for name in names]) / (DENSITY * GRAVITY ** 0.5)
    slope, start = np.polyfit(outlets, rates ** (2.0 / 3.0), 1)
    worst = np.abs((slope * outlets + start) ** 1.5 / rates - 1.0).max()
    return slope ** 1.5, -start / slope / cell, 100.0 * worst, np.polyfit(np.log(outlets), np.log(rates), 1)[0]


def draw(runs, plot):
    """The beads at three times, coloured by speed, and what has left over time."""
    if not {"middle", "narrow", "wide", "fluid"} <= set(runs):
        return None
    figure, panels = plot.subplots(1, 5, figsize=(10.5, 4.4), width_ratios=(1, 1, 1, 1, 2.6), layout="constrained")
    for axes, (name, moment) in zip(panels, (("middle", 0.2), ("middle", 0.5), ("middle", 0.85), ("fluid", 0.85))):
        snap = runs[name].near(moment)
        speed = np.linalg.norm(snap.fields["velocity"], axis=1)
        shown = panel.particles(axes, snap, speed, low=0.0, high=0.8, sides=(-1, 1), factor=1.0)
        axes.plot([-WIDTH, -0.03125], [0, 0], "k", [0.03125, WIDTH], [0, 0], "k", lw=2)
        panel.window(axes, (-WIDTH, WIDTH, -0.01, HEIGHT + 0.02), title=f"{RUNS[name][0]}\n{moment - 0.15:.2f} s")
        axes.set_xticks([])
        if axes is not panels[0]:
            axes.set_yticks([])
    panels[0].set_ylabel("height [m]")
    figure.colorbar(shown, ax=panels[:4], label="speed [m/s]", location="bottom", shrink=0.5, pad=0.02)
    for name, colour in (("narrow", "#56b4e9"), ("middle", "#0072b2"), ("wide", "#009e73"), ("fluid", "#d55e00")):
        history = runs[name].history
        panels[-1].plot(history["time"] - 0.15, history["lost_mass"] / history["mass"][0], color=colour,
                        label=f"{RUNS[name][0]}, {1000 * RUNS[name][1]:g} mm")
    panels[-1].set(xlabel="time since the gate opened [s]", ylabel="discharged fraction of the filling", xlim=(0, None),
                   ylim=(0, 1.45), yticks=np.linspace(0, 1, 6))
    panels[-1].legend(frameon=False)
    return figure


if __name__ == "__main__":
    Study(__file__, CASES, tables, {"picture.png": draw}).main()
