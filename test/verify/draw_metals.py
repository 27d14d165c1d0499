# SPDX-License-Identifier: BSD-3-Clause
"""Draw the figures of doc/theory/verification_metals.md.

    python test/verify/draw_metals.py --scree build/bin/scree --work FOLDER [--only WORD]

runs the problems of test/support/taylor.py and of the tests of shocks, and writes doc/theory/figures/metals_*.png.
"""

import argparse
import sys

import matplotlib
import numpy as np
from matplotlib import pyplot

import _support
import case
import taylor
import test_flyer
import test_precursor
import test_taylor

matplotlib.use("Agg")

STYLE = {"font.size": 8, "axes.grid": True, "grid.alpha": 0.3, "lines.linewidth": 1.2, "figure.dpi": 100,
         "legend.fontsize": 7, "axes.axisbelow": True}


def bars(options):
    """The measured bar at five times with its plastic strain; dimensions of the classic bar for several cell sizes."""
    figure, (left, right) = pyplot.subplots(1, 2, figsize=(9.5, 2.9), width_ratios=(2.2, 1.0))
    result = taylor.strike(options, "picture", taylor.MEASURED)
    for number, snap in enumerate(result["snapshots"]):
        r, z = 1e3 * snap.points[:, 0], 1e3 * snap.points[:, 2]
        for sign in (-1.0, 1.0):
            shown = left.scatter(17.0 * number + sign * r, z, c=snap.fields["plastic_strain"], s=1.2, vmin=0.0,
                                 vmax=1.2, cmap="viridis", linewidths=0)
        left.text(17.0 * number, z.max() + 0.7, f"{20 * number} us", ha="center")
    edge = 17.0 * 4
    length, foot, waist = taylor.EXPERIMENT
    left.plot([edge - 0.5 * foot] * 2 + [edge + 0.5 * foot] * 2, [0.6, 0.0, 0.0, 0.6], "r-", lw=1.5)
    left.plot([edge - 0.5 * waist, edge + 0.5 * waist], [0.2 * taylor.MEASURED.length] * 2, "r|", ms=8, mew=1.5)
    left.plot([edge - 4.0, edge + 4.0], [length, length], "r-", lw=1.5, label="measured length, foot and waist")
    left.set_aspect("equal")
    left.set(ylim=(-0.5, 28.5), ylabel="z [mm]", xticks=[])
    left.legend(loc="upper right", fontsize=6)
    figure.colorbar(shown, ax=left, label="plastic strain", shrink=0.55)
    for name in test_taylor.METHODS:
        method, words = test_taylor.METHODS[name]
        cells = (0.8, 0.4, 0.2)
        found = [taylor.strike(options, "curve", taylor.CLASSIC, h, words, method, timeout=600) for h in cells]
        right.plot(cells, [1e3 * run["foot"] for run in found], "o-", ms=3, label=name)
    right.axhspan(7.167, 7.200, color="k", alpha=0.2, label="finite elements")
    right.set(xlabel="cells [mm]", ylabel="radius of the foot, classic bar [mm]", xscale="log",
              xticks=(0.2, 0.4, 0.8), xticklabels=("0.2", "0.4", "0.8"))
    right.minorticks_off()
    right.legend()
    _support.save(figure, "metals_bars")


def waves(options):
    """Stress of precursor and plastic shock in three metals; free surfaces in flyer impact and spall; waves at a jump
    of impedance."""
    figure, (left, middle, right) = pyplot.subplots(1, 3, figsize=(9.5, 2.9))
    tools = case.post()
    for metal, speed, name in ((test_precursor.AL_2024, 400, "Al-2024, 400 m/s"),
                               (test_precursor.BE, 100, "Be, 100 m/s"), (test_precursor.CU, 20, "Cu, 20 m/s")):
        test_precursor.strike(options, metal, speed, test_precursor.SMOOTH)
        start = options.work / f"solid_{metal.name}_{speed}" / f"solid_{metal.name}_{speed}_p.hdf.series"
        time, file = tools.series(str(start))[2]
        snap = tools.snapshot(file)
        ahead, after = metal.precursor(), metal.plastic(speed)
        order = np.argsort(snap.points[:, 0])
        line, = left.plot(1e3 * snap.points[order, 0], -snap.fields["stress"][order, 0] / after["stress"], label=name)
        fronts = [1e3 * time * (wave["speed"] - speed) for wave in (after, ahead)]
        level = ahead["stress"] / after["stress"]
        left.plot([0.0, fronts[0], fronts[0], fronts[1], fronts[1], 40.0], [1.0, 1.0, level, level, 0.0, 0.0], "--",
                  color=line.get_color(), lw=0.8)
    left.set(xlabel="x [mm]", ylabel="stress / stress of the plastic wave", ylim=(-0.05, 1.2))
    left.legend()
    result = test_flyer.flyer(options, 40)
    middle.plot(result["time"], result["surface"], label="flyer, no strength")
    middle.plot([0, 2, 2, 4, 4, 6], [0, 0, 1, 1, 0, 0], "k:", lw=0.8)
    for cells in (40, 80):
        result = test_flyer.spall(options, cells, 0.6)
        middle.plot(result["time"], result["surface"], label=f"pulse that breaks, {cells} cells")
    middle.axhline(0.4, color="r", lw=0.8, ls=":")
    middle.set(xlabel="time c/h", ylabel="velocity of the free surface / V", xlim=(1.5, 5.5))
    middle.legend(fontsize=6)
    for ratio in (1.0e6, 10.0, 1.0e-6):
        test_flyer.contrast(options, ratio)
        name = f"contrast_{ratio:g}_100_ddmp"
        snap = tools.snapshot(tools.series(str(options.work / name / f"{name}_p.hdf.series"))[-1][1])
        order = np.argsort(snap.points[:, 0])
        right.plot(1e3 * snap.points[order, 0], -snap.fields["stress"][order, 0] / (2703.0 * 6400.0 * 5.0),
                   label=f"Z2/Z1 = {ratio:g}")
        right.plot([6.0, 9.99], [2.0 * ratio / (1.0 + ratio)] * 2, "k--", lw=0.8)
    right.set(xlabel="x [mm]", ylabel="stress / stress of the incoming wave", xlim=(0.0, 15.0), ylim=(-0.2, 2.4))
    right.legend(fontsize=6)
    _support.save(figure, "metals_waves")


def main():
    """All figures, or those whose names contain a word."""
    parser = argparse.ArgumentParser(add_help=False)
    parser.add_argument("--only", default="")
    only, rest = parser.parse_known_args()
    sys.argv[1:] = rest
    options = case.arguments()
    np.seterr(all="ignore")
    pyplot.rcParams.update(STYLE)
    for name, draw in (("bars", bars), ("waves", waves)):
        if only.only in name:
            draw(options)


if __name__ == "__main__":
    main()
