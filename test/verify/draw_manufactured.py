# SPDX-License-Identifier: BSD-3-Clause
"""Draw the figures of doc/theory/verification.md.

    python test/verify/draw_manufactured.py --scree build/bin/scree --work FOLDER [--only WORD]

runs the series of test/support/manufactured.py, prints their errors and orders, and writes
doc/theory/figures/manufactured_*.png: error against cells, a line for each method, with slopes.
"""

import argparse
import math
import sys

import matplotlib
import matplotlib.ticker
from matplotlib import pyplot

import _support
import case
import manufactured

matplotlib.use("Agg")

FOLDER = _support.HERE.parents[1] / "doc" / "theory" / "figures"
STYLE = {"font.size": 8, "axes.grid": True, "grid.alpha": 0.3, "lines.linewidth": 1.2, "lines.markersize": 4,
         "legend.fontsize": 7, "axes.axisbelow": True}
MARKS = "osv^D<>ph*X"
BASES = ("linear", "gimp", "cpgimp", "quadratic", "cubic")
DUAL = (("ddmp", "ddmp", ""), ("ddmp, control", "ddmp", manufactured.CONTROL))


def plain(bases, words=manufactured.PLAIN):
    """Name, method and keys of the plain method with several node functions."""
    return tuple((basis, "mpm", f"basis='{basis}'  {words}") for basis in bases)


def draw(axes, title, lines, slope=2.0):
    """One picture: all lines, and a guide below them."""
    for line, mark in zip(lines, MARKS):
        axes.loglog(line.cells, [error if math.isfinite(error) else math.nan for error in line.errors],
                    marker=mark, label=line.name, color="black" if line.name == "ddmp" else None)
    cells = lines[0].cells
    low = 0.6 * min(line.errors[0] for line in lines)
    axes.loglog(cells, [low * (cells[0] / number) ** slope for number in cells], "--", color="grey",
                linewidth=0.8, label=f"order {slope:g}")
    axes.set(title=title, xlabel="cells in a unit of length", ylabel="error / greatest displacement")
    axes.set_xticks(cells, [str(number) for number in cells])
    axes.xaxis.set_minor_locator(matplotlib.ticker.NullLocator())
    axes.legend()


def save(name, figure):
    """Write a figure."""
    figure.tight_layout()
    figure.savefig(FOLDER / f"manufactured_{name}.png", dpi=110)
    pyplot.close(figure)


def line_figure(options):
    """Waves on a line: large and small amplitude."""
    figure, axes = pyplot.subplots(1, 3, figsize=(10.5, 3.8))
    cells = (8, 16, 32, 64, 128, 256)
    draw(axes[0], "A = 0.1, 4 particles a cell", [manufactured.waves(options, *kind, may_fail=True, cells=cells)
                                                  for kind in DUAL + plain(BASES)])
    draw(axes[1], "A = 0.1, 2 particles a cell", [manufactured.waves(options, *kind, may_fail=True, cells=cells, ppc=2)
                                                  for kind in DUAL + plain(BASES)])
    draw(axes[2], "A = 1e-4, 4 particles a cell", [
        manufactured.waves(options, *kind, may_fail=True, cells=cells[:5], amplitude=1.0e-4)
        for kind in DUAL + plain(BASES)])
    save("line", figure)


def cube_figure(options):
    """Waves in the plane and in the cube."""
    figure, axes = pyplot.subplots(1, 2, figsize=(7.4, 3.6))
    kinds = DUAL + plain(("linear", "quadratic", "cpdi"), "")
    draw(axes[0], "plane, A = 0.05, 2 x 2 particles", [
        manufactured.waves(options, *kind, may_fail=True, cells=(6, 12, 24, 48), ppc=2, amplitude=0.05,
                           dimension="plane_strain") for kind in kinds])
    draw(axes[1], "cube, A = 0.05, 2 x 2 x 2 particles", [
        manufactured.waves(options, *kind, may_fail=True, cells=(6, 12, 24), ppc=2, amplitude=0.05, dimension="3d",
                           end=manufactured.PERIOD / 6, cfl=0.4) for kind in kinds])
    save("cube", figure)


def vortex_figure(options):
    """The ring: a middle twist to and back, a large one to its greatest."""
    figure, axes = pyplot.subplots(1, 2, figsize=(7.4, 3.8))
    for place, twist, end in zip(axes, (0.3, 1.0), (1.0, 0.5)):
        kinds = DUAL + tuple((f"ddmp, control, {name}", "ddmp", f"{manufactured.CONTROL} transfer='{name}'")
                             for name in ("aflip", "apic"))
        kinds += plain(("quadratic", "cpdi"), "")
        kinds += (("quadratic, aflip", "mpm", f"basis='quadratic' {manufactured.AFFINE}"),
                  ("cpdi, aflip", "mpm", f"basis='cpdi' {manufactured.AFFINE}"))
        draw(place, f"twist {twist:g}, t = {end:g}", [
            manufactured.vortex(options, *kind, may_fail=True, twist=twist, end=end, ppc=4, cells=(10, 20, 40),
                                body="packing='cut'") for kind in kinds])
        place.set_ylim(1.0e-3, 2.0)
    save("vortex", figure)


def main():
    """All figures, or those with a word in their names."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n", 1)[0])
    parser.add_argument("--only", default="", help="part of the name of a figure")
    known, sys.argv[1:] = parser.parse_known_args()
    options = case.arguments()
    pyplot.rcParams.update(STYLE)
    FOLDER.mkdir(exist_ok=True)
    for function in (line_figure, cube_figure, vortex_figure):
        if known.only in function.__name__:
            function(options)


if __name__ == "__main__":
    main()
