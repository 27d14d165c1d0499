# SPDX-License-Identifier: BSD-3-Clause
"""Results of `scree-post accuracy` for a deck with known solution and order.

Would catch: a wrong order from unequal ratios of cells, an extrapolation to the wrong side, a bound below the true
error, a predicted cell size with which the error exceeds the tolerance, cells that do not fit the grid, a quantity from
the wrong row, columns of another run, a failure that is not reported.

The bar of `&exact bar_mode`, held at one end, L = 25 m, E = 100 Pa, rho = 1 kg/m3, u' = v0 sin(pi X/2L) cos(w t).
At w t = 0.3 pi the stored energy is E L/4 (a pi/2L sin(w t))^2 with a = v0/w: second order. The outermost particle
lies h/4 inside of the end, at L - h/4 + a sin(w t): first order. For artificial numbers f = f0 + c h^p, order and limit
must be recovered to round-off for any ratio of the cells.
"""

import csv
import math
import subprocess
import sys

import case
from scree import convergence as scree_accuracy

DECK = """
&run  dimension='1d' /
&grid  lo=0,0,0  hi=30,1,1  {size} /
&time  t_end=1.5  cfl=0.2 /
&method  flip=1 /
&effects  artificial_viscosity=.false. /
&material  name='bar'  density=1  young=100  poisson=0 /
&region  name='bar'  shape='box'  lo=0,0,0  hi=25,1,1 /
&body  name='bar'  region='bar'  material='bar'  ppc=2,1,1 /
&boundary  face='xlo'  type='symmetry' /
&exact  solution='bar_mode'  bar_length=25  ends='fixed_free'  mode_speed=0.0001 /
&output  name='h'  kind='history'  count=20 /
&output  name='p'  kind='particles'  count=1  precision='double' /
"""
TURN = math.pi * 10.0 / 50.0           # w [1/s]
STRETCH = 0.0001 / TURN                  # a [m]
ENERGY = 100.0 * 25.0 / 4.0 * (STRETCH * math.pi / 50.0 * math.sin(1.5 * TURN)) ** 2
FRONT = 25.0 + STRETCH * math.sin(1.5 * TURN)


def tool(options, *words):
    """Exit code, output, and errors."""
    answer = subprocess.run([sys.executable, "-m", "scree_post", "accuracy", *map(str, words),
                             "--scree", options.scree, "--work", options.work / "runs"], cwd=options.work,
                            env={**case.os.environ, "OMP_NUM_THREADS": "1",
                                 "PYTHONPATH": str(case.ROOT / "python/src")}, capture_output=True, text=True)
    return answer.returncode, answer.stdout, answer.stderr


def table(path):
    """Rows of a table by quantity."""
    found = {}
    with open(path, newline="", encoding="utf-8") as file:
        for row in csv.DictReader(file):
            found.setdefault((row["quantity"], row["method"]), []).append(row)
    return found


def test_numbers(sheet):
    """Artificial numbers."""
    for order in (0.7, 1.0, 2.0, 2.4):
        for sizes in ((2.0, 1.4, 1.0), (4.0, 2.0, 1.0), (3.0, 2.7, 0.9)):
            verdict = scree_accuracy.judge(sizes, [5.0 - 0.3 * size ** order for size in sizes])
            sheet.near(f"order {order}, cells of {sizes}", verdict.order, order, 1.0e-9)
            sheet.near(f"limit of order {order}", verdict.limit, 5.0, 1.0e-9)
            sheet.near("bound over 1.25 times the true error", verdict.error / 1.25 / 0.3, sizes[2] ** order, 1e-9)
    for values, kind in (((1.0, 1.2, 1.1), "oscillating"), ((1.0, 1.1, 1.3), "not converging"),
                         ((1.0, 1.1, 1.1), "does not change")):
        verdict = scree_accuracy.judge((2.0, 1.4, 1.0), values)
        sheet.require(verdict.kind == kind, f"{values} is {verdict.kind}, not {kind}")
    sheet.require(scree_accuracy.judge((4.0, 2.0, 1.0), (1.0 + 64.0 ** 2, 1.0 + 64.0, 2.0)).safety == 3.0,
                  "an order of 6 is not believed")


def bar_deck(options):
    """The deck of a bar."""
    deck = options.work / "bar.nml"
    deck.write_text(DECK.format(size="dx=0.5"), encoding="ascii")
    return deck


def test_bar(options, sheet):
    """Two quantities by two methods on four grids."""
    deck = bar_deck(options)
    code, text, _ = tool(options, deck, "--quantity", "internal", "front_x", "--factors", "2,1,0.5", "--methods",
                         "ddmp,mpm", "--csv", "bar.csv", "--plot", "bar.png", "--tolerance", "0.02%")
    sheet.require(code == 0, f"the tool ends with {code}: {text}")
    found = table(options.work / "bar.csv")
    sheet.require(len(found) == 4 and all(len(rows) == 3 for rows in found.values()), "rows of all runs")
    for method in ("ddmp", "mpm"):
        rows = found["internal", method]
        fine = rows[-1]
        sheet.near(f"{method}: order of the energy", float(fine["order"]), 2.0, 0.12)
        sheet.near(f"{method}: extrapolated energy [J]", float(fine["extrapolated"]), ENERGY, 1.0e-4)
        error = abs(float(fine["value"]) - ENERGY)
        sheet.below(f"{method}: error of the finest over its bound", error / float(fine["error_bound"]), 1.0)
        sheet.above(f"{method}: the same", error / float(fine["error_bound"]), 0.5)
        fine = found["front_x", method][-1]
        sheet.near(f"{method}: order of the front", float(fine["order"]), 1.0, 0.01)
        sheet.near(f"{method}: extrapolated front less 25 m", float(fine["extrapolated"]) - 25.0, FRONT - 25.0, 0.01)
        sheet.require([int(row["particles"]) for row in rows] == [50, 100, 200], "particles of the three grids")
        sheet.require(all(float(row["core_seconds"]) > 0.0 for row in rows), "core-seconds are measured")
    sheet.require("core-seconds" in text and "monotone" in text, "the table is printed")
    sheet.above("picture [B]", (options.work / "bar.png").stat().st_size, 10000)


def test_forecast(options, sheet):
    """With the predicted cell size the error is within the tolerance."""
    deck = bar_deck(options)
    _, text, _ = tool(options, deck, "--quantity", "internal", "--factors", "4,2,1", "--tolerance", "0.01%",
                      "--csv", "coarse.csv")
    sheet.require("0.01% needs cells of about" in text, f"a forecast: {text}")
    size = float(text.split("needs cells of about ")[1].split()[0])
    cells = 6 * math.ceil(5.0 / size)      # so that the end of the bar is a cell face
    run = case.Case(options, "foretold", DECK.format(size=f"cells={cells},1,1")).run("-q")
    sheet.below("error of the foretold cells over the tolerance", abs(run.history["internal"][-1] / ENERGY - 1.0)
                / 1.0e-4, 1.0)
    sheet.above("size of the cells [m]", size, 0.1)


def test_other_words(options, sheet):
    """`cells` instead of `dx`, settings, greatest values and times."""
    deck = options.work / "cells.nml"
    deck.write_text(DECK.format(size="cells=60,1,1"), encoding="ascii")
    code, text, _ = tool(options, deck, "--quantity", "internal:at=1.2", "kinetic:max", "exact.velocity_error",
                         "--factors", "3,1.5,1", "--set", "time.t_end=1.6", "--csv", "cells.csv")
    sheet.require(code == 0, text)
    rows = table(options.work / "cells.csv")["kinetic:max", ""]
    sheet.require([float(row["cell_size"]) for row in rows] == [1.5, 0.75, 0.5], "cells of the factors")
    sheet.near("greatest kinetic energy [J]", float(rows[-1]["value"]), 25.0 / 4.0 * 1.0e-8, 0.01)
    fine = table(options.work / "cells.csv")["internal:at=1.2", ""][-1]
    turned = math.sin(1.2 * TURN) / math.sin(1.5 * TURN)
    sheet.near("stored energy at a time [J]", float(fine["value"]), ENERGY * turned ** 2, 0.01)


def test_complaints(options, sheet):
    """Requests that are not possible are reported."""
    deck = bar_deck(options)
    for words, code, told in (
            (("--quantity", "heat"), 2, "There are columns of the history: dt, mass"),
            (("--quantity", "internal", "--factors", "2,1"), 2, "at least three different numbers"),
            (("--quantity", "internal", "--factors", "1,1.001,1.002"), 2, "name three of these"),
            (("--quantity", "internal:at=9"), 2, "write a time from 0 to t_end = 1.5 s"),
            (("--quantity", "internal:median"), 2, "after the colon write last, max, min"),
            (("--quantity", "width", "--body", "wing"), 2, "no body 'wing' (there are: bar)"),
            (("--quantity", "internal", "--methods", "fem"), 2, "method = fem is none of"),
            (("--quantity", "internal", "--tolerance", "good"), 2, "is not like 1%"),
            (("--quantity", "internal", "--set", "dx=1"), 2, "is not of the form GROUP.KEY=VALUE"),
            (("--quantity", "internal", "--set", "time.dt_min=1"), 4, "ended with exit code 4")):
        seen, text, errors = tool(options, deck, *words)
        sheet.require(seen == code and told in errors.replace("\n", " "),
                      f"{' '.join(words)}: exit code {seen}, {errors[-300:]}")
        sheet.require("Traceback" not in errors, f"{' '.join(words)} is an error of the user")
    _, text, _ = tool(options, deck, "--quantity", "internal", "--factors", "2,1.4,1")
    sheet.require("the mass of the bodies differs" in text, f"other bodies on other grids: {text[:300]}")
    code, _, errors = tool(options, options.work / "none.nml", "--quantity", "internal")
    sheet.require(code == 3 and "no such file" in errors, errors)
