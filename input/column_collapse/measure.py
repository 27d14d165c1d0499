# SPDX-License-Identifier: BSD-3-Clause
"""Run-out and height of columns that collapse, plane and round, by their aspect ratio.

    python input/column_collapse/measure.py --scree build/bin/scree [--only plane_2]
"""
import math
import sys
from pathlib import Path

import numpy as np

ROOT = Path(__file__).resolve().parents[2]
sys.path[:0] = [str(ROOT / "scripts"), str(ROOT / "python/src"), str(ROOT / "test/support")]
import flows                           # noqa: E402
import scree_post                      # noqa: E402
from scree.drawing import look     # noqa: E402
from scree_post import panel     # noqa: E402
from scree_scene import Study, Table   # noqa: E402

ASPECTS = (0.5, 1.0, 2.0, 4.0)
KINDS = {"plane": False, "round": True}                # is it axisymmetric?
LAYER = 0.025                                          # thickness of the layers that are drawn [m]
COLOURS = {"plane": "#0072b2", "round": "#d55e00"}


def settings(kind, aspect):
    """What differs from the deck, whose column is plane and twice as high as half of it is wide."""
    height, spacing = aspect * flows.HALF_WIDTH, flows.HALF_WIDTH / flows.COLUMN_CELLS[aspect]
    reach = flows.HALF_WIDTH * (1.0 + 2.5 * flows.runout_laws(aspect, KINDS[kind])[0])
    bulk = 100.0 * 1500.0 * flows.GRAVITY * height     # a hundred times the weight on the base
    wide, high = (spacing * math.ceil(length / spacing) for length in (reach, 1.1 * height + 2.0 * spacing))
    values = {"grid.hi": f"{wide:.15g},1,{high:.15g}", "grid.dx": f"{spacing:.15g}", "material.bulk": f"{bulk:.15g}",
              "material.shear": f"{0.46 * bulk:.15g}", "region.hi": f"{flows.HALF_WIDTH},1,{height:.15g}",
              "time.t_end": f"{5.25 * math.sqrt(height / flows.GRAVITY):.15g}", "output[sand].count": 40}
    if KINDS[kind]:
        values["run.dimension"] = "axisymmetric"
    return values


CASES = {f"{kind}_{aspect:g}": ("scene.nml", settings(kind, aspect)) for kind in KINDS for aspect in ASPECTS}
# the friction of a cell of spheres, input/grain_cell/spheres.nml
SPHERES = {"material.friction_angle": 23.4}
CASES |= {f"{kind}_{aspect:g}_spheres": ("scene.nml", {**settings(kind, aspect), **SPHERES})
          for kind in KINDS for aspect in (1.0, 2.0, 4.0)}


def split(name):
    """Kind and aspect ratio of a case."""
    kind, aspect = name.split("_")[:2]
    return kind, float(aspect)


def of_sand(runs):
    """The runs with the friction of the deck."""
    return {name: run for name, run in runs.items() if not name.endswith("_spheres")}


def fronts(run, aspect, axisymmetric):
    """Times over sqrt(H/g) and run-outs over the half width."""
    unit = math.sqrt(aspect * flows.HALF_WIDTH / flows.GRAVITY)
    found = [(time / unit, flows.front(scree_post.snapshot(file), aspect, axisymmetric)) for time, file in run.series]
    return np.array(found).T


def top(run):
    """Height of the deposit in the middle over the half width."""
    snap = run.last_snapshot()
    return snap.points[snap.points[:, 0] < 0.2 * flows.HALF_WIDTH, 2].max() / flows.HALF_WIDTH


def measured(aspect, axisymmetric):
    """The measured run-out as text, or the laws on both sides where none was found."""
    return " to ".join(dict.fromkeys(f"{law:.2f}" for law in flows.runout_laws(aspect, axisymmetric)))


def tables(runs):
    """Run-out, height and time by aspect ratio, and what they are with the friction of spheres."""
    spheres = Table(["column", "a", "run-out, 23.4 degrees", "continuum", "beads", "height, 23.4 degrees", "continuum",
                     "beads"])
    for name, run in runs.items():
        if name.endswith("_spheres"):
            kind, aspect = split(name)
            run_out, height = flows.continuum(aspect)
            others = [(run_out, flows.beads_runout(aspect)), (height, flows.measured_height(aspect))]
            texts = [["", ""] if KINDS[kind] else [f"{value:.2f}" for value in pair] for pair in others]
            spheres.rows.append([kind, f"{aspect:g}", f"{fronts(run, aspect, KINDS[kind])[1][-1]:.2f}", *texts[0],
                                 f"{top(run):.2f}", *texts[1]])
    table = Table(["column", "a", "run-out", "measured", "height", "measured", "time over sqrt(H/g)", "measured",
                   "energy error"])
    for name, run in of_sand(runs).items():
        kind, aspect = split(name)
        time, place = fronts(run, aspect, KINDS[kind])
        before = np.flatnonzero(place < 0.97 * place[-1])[-1]
        arrived = np.interp(0.97 * place[-1], place[before:before + 2], time[before:before + 2])
        table.rows.append([kind, f"{aspect:g}", f"{place[-1]:.2f}", measured(aspect, KINDS[kind]),
                           f"{top(run):.2f}", f"{flows.measured_height(aspect, KINDS[kind]):.2f}", f"{arrived:.1f}",
                           "3.0" if KINDS[kind] else "3.3", f"{run.error('energy_error'):.3f}"])
    return [table, spheres]


def numbers(runs):
    """The run-out that is farthest off what was measured, and the heights of plane deposits; with the friction of
    spheres the run-outs of plane columns, and run-outs and heights over those of the continuum, less 1."""
    worst, heights, beside = 0.0, [], []
    for name, run in runs.items():
        kind, aspect = split(name)
        found = fronts(run, aspect, KINDS[kind])[1][-1]
        if name.endswith("_spheres"):
            if not KINDS[kind]:
                run_out, height = flows.continuum(aspect)
                beside.append((found, found / run_out - 1.0, top(run) / height - 1.0))
            continue
        least, most = flows.runout_laws(aspect, KINDS[kind])
        worst = max(worst, 1.0 - found / least, found / most - 1.0)
        if aspect >= 1.0 and not KINDS[kind]:
            heights.append(top(run) / flows.measured_height(aspect) - 1.0)
    places, *columns = zip(*beside)
    texts = [", ".join(f"{100.0 * value:+.0f}" for value in column) for column in columns]
    return {"worst": f"{100.0 * worst:.0f}", "heights": f"+{100.0 * min(heights):.0f} to +{100.0 * max(heights):.0f}",
            "spheres_runout": ", ".join(f"{place:.2f}" for place in places),
            "continuum_runout": texts[0], "continuum_height": texts[1]}


def draw(runs, plot):
    """Run-out by aspect ratio beside the measured laws and the continuum, and the deposits."""
    figure, panels = plot.subplots(1, 3, figsize=(10.5, 3.9), width_ratios=(1.0, 1.1, 1.1), layout="constrained")
    line = np.geomspace(0.4, 5.0, 400)
    panels[0].plot(line, [flows.continuum(aspect)[0] for aspect in line], "k--", linewidth=1.0,
                   label="plane, continuum, mu(I)")
    for kind, axisymmetric in KINDS.items():
        least, law = np.array([flows.runout_laws(aspect, axisymmetric) for aspect in line]).T
        law[least < law] = np.nan      # no law there
        panels[0].fill_between(line, 0.85 * law, 1.15 * law, color=COLOURS[kind], alpha=0.15, linewidth=0)
        panels[0].plot(line, law, color=COLOURS[kind], linewidth=1.2, label=f"{kind}, measured")
    for name, run in of_sand(runs).items():
        kind, aspect = split(name)
        panels[0].plot(aspect, fronts(run, aspect, KINDS[kind])[1][-1], "os"[KINDS[kind]], color=COLOURS[kind])
        middle, thick = flows.thickness(run.last_snapshot(), aspect, KINDS[kind])
        panels[1 + KINDS[kind]].plot(middle, thick, label=f"a = {aspect:g}", linewidth=1.4)
    for aspect in (1.0, 2.0, 4.0):
        if f"plane_{aspect:g}_spheres" in runs:
            panels[0].plot(aspect, fronts(runs[f"plane_{aspect:g}_spheres"], aspect, False)[1][-1], "o", mfc="none",
                           color="k", label="plane, 23.4 degrees" if aspect == 1.0 else None)
    panels[0].set(xscale="log", yscale="log", xlabel="height over half width, a", ylabel="run-out over half width")
    for axis, ticks in ((panels[0].xaxis, ASPECTS), (panels[0].yaxis, (0.5, 1.0, 2.0, 4.0, 8.0))):
        axis.set_ticks(ticks, labels=[f"{tick:g}" for tick in ticks])
        axis.set_ticks([], minor=True)
    panels[0].legend(fontsize=8)
    for panel, kind in zip(panels[1:], KINDS):
        panel.set(title=f"deposits, {kind}", xlabel="distance over half width", ylabel="thickness over half width",
                  xlim=(0, 6.5), ylim=(0, 1.7))
        panel.legend(fontsize=9)
    return figure


def draw_stages(runs, plot):
    """The column of the deck at four times, in layers that lay flat at the start."""
    if "plane_2" not in runs:
        return None
    run = runs["plane_2"]
    begin = run.near(0.0)
    order = np.argsort(begin.fields["identity"])
    whose, height = begin.fields["identity"][order], begin.points[order, 2]
    figure, panels = plot.subplots(2, 2, figsize=(9.6, 4.7), sharex=True, sharey=True, layout="constrained")
    for axes, moment in zip(panels.flat, (0.0, 0.15, 0.3, 0.75)):
        snap = run.near(moment)
        layer = np.floor(height[np.searchsorted(whose, snap.fields["identity"])] / LAYER) % 2
        panel.particles(axes, snap, layer, low=-0.4, high=1.3, colours=look.SOOT, factor=100.0)
        for law in flows.runout_laws(2.0):
            axes.axvline(100 * flows.HALF_WIDTH * (1.0 + law), color="k", linestyle=":")
        panel.window(axes, (0.0, 50.0, 0.0, 22.0))
        axes.text(0.97, 0.92, f"{snap.time:.2f} s", ha="right", va="top", transform=axes.transAxes)
    for axes in panels[:, 0]:
        axes.set_ylabel("z [cm]")
    for axes in panels[1]:
        axes.set_xlabel("x [cm]")
    return figure


if __name__ == "__main__":
    Study(__file__, CASES, tables, {"stages.png": draw_stages, "runout.png": draw}, numbers={"README.md": numbers},
          as_it_stands="plane_2").main()
