# SPDX-License-Identifier: BSD-3-Clause
"""Estimates the discretization error of a result of a deck and the cost of a smaller error.

The command runs the deck with three or more cell sizes. Three of them determine the observed order
of convergence, the value extrapolated to zero cell size (L. F. Richardson 1911) and a bound of the
error of the finest run (grid convergence index: P. J. Roache, J. Fluids Eng. 116 (1994) 405; I. B.
Celik and others, ibid. 130 (2008) 078001). A quantity is one of:

  NAME            a column of the history, its last row; NAME:max, NAME:min, NAME:mean, NAME:at=TIME
  TABLE.COLUMN    the same of CASE_TABLE.csv, such as gauge.velocity_x:max; of tables with several
                  rows for each time fragments[1].mass, or fragments.mass:mean of the last time
  PATH            a number in the summary, such as ledger.energy_error
  length, width, radius, front_z, ...   of the particles of the last snapshot
"""
from __future__ import annotations

import argparse
import csv
import math
import re
import warnings
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from scree.convergence import SAFE, cost_law
from scree.drawing import look
from scree.drawing.quantity import quantity as number_with_unit
from scree.program import jobs_for, threads_of_a_run
from scree.refinement import MassWarning, accuracy

if TYPE_CHECKING:
    from scree.convergence import Verdict
    from scree.refinement import Accuracy

SUMMARY = "discretization error of a result of a deck, and the cost of a smaller error"
EXAMPLES = ("accuracy input/taylor_copper/scene.nml --quantity length radius --factors 4,2,1",
            "accuracy input/two_discs/scene.nml --quantity length --factors 4,2,1")


def tolerance_of(text: str, verdict: Verdict, fine: float) -> float:
    """The tolerance as a number in SI; 1% is of the extrapolated value."""
    if not text.endswith("%"):
        return number_with_unit(text)
    base = fine if verdict.limit is None else verdict.limit
    return 0.01 * float(text[:-1]) * abs(base)


def sentence(verdict: Verdict, unit: str, fine: float, causes: Sequence[str]) -> str:
    """The results of the convergence analysis in words; causes are those in the deck of a missing order."""
    why = "".join(f"\n  {cause}" for cause in causes)
    share = f" ({100.0 * verdict.error / abs(verdict.limit):.2g} %)" if verdict.limit else ""
    bound = f"error of the finest run below {verdict.error:.3g}{unit}{share}, safety factor {verdict.safety:g}"
    if verdict.kind == "does not change":
        return f"the last two runs agree to round-off: {bound}; no order can be observed"
    if verdict.kind == "oscillating":
        return (f"oscillating: values go up and down with the cells, so there is no order and no extrapolated value; "
                f"{bound} times the range{why}")
    if verdict.kind == "not converging":
        return (f"not converging: changes grow as cells get smaller (order {verdict.order:.2f}), "
                f"so there is no extrapolated value, and the finest value {fine:.6g}{unit} has no error bound"
                + (why or "; finer or coarser cells, more particles a cell or another method may show why"))
    belief = "" if verdict.safety == SAFE else ", which is not as expected"
    return f"monotone, order {verdict.order:.2f}{belief}; extrapolated value {verdict.limit:.8g}{unit}; {bound}"


def plan_text(found: Accuracy, quantity: str, text: str) -> str:
    """The cost of a tolerance."""
    verdict, fine, dimensions = found.verdicts[quantity], found.table.iloc[-1], len(found.grid.axes)
    target = tolerance_of(text, verdict, fine[quantity])
    plan = found.cost(quantity, target)
    if plan is None:
        return f"{text} cannot be planned: there is no order"
    size, seconds = plan
    smaller = fine["cell_size"] / size
    factor, unit = look.readable_unit(max(found.sizes), "m")
    if verdict.error <= target:
        return f"{text} is met by cells of {factor * found.sizes[-1]:.4g} {unit}: {seconds:.3g} core-seconds"
    if seconds > 1.0e15:
        return f"{text} is out of reach at order {verdict.order:.2f}"
    power = cost_law(found.sizes, found.table["core_seconds"].tolist(), dimensions)[1]
    return (f"{text} needs cells of about {factor * size:.3g} {unit}, {smaller:.1f} times smaller: "
            f"{seconds:.3g} core-seconds (cost as h^-{dimensions + 1}, {power:.1f} measured)")


def print_table(options: argparse.Namespace, method: str | None, quantity: str, found: Accuracy) -> None:
    """Print the table of one quantity and method, and the results in words."""
    unit = found.units[quantity]
    unit = f" {unit}" if unit and unit != "1" else ""
    print(f"\n{quantity}{unit and f' [{unit.strip()}]'}{', ' + method if method else ''}")
    factor, length = look.readable_unit(max(found.sizes), "m")
    print(f"  {f'cells [{length}]':>10} {'particles':>10} {'steps':>8} {'core-seconds':>13} {'value':>18}"
          f" {'change':>10}")
    changes = found.table[quantity].diff()
    for size, row, change, value in zip(found.sizes, found.table.itertuples(), changes, found.table[quantity]):
        print(f"  {factor * size:10.4g} {row.particles:10d} {row.steps:8d} {row.core_seconds:13.4g}"
              f" {value:18.10g} {'' if math.isnan(change) else f'{change:.2e}':>10}")
    print("  " + sentence(found.verdicts[quantity], unit, value, found.causes))
    print("  " + plan_text(found, quantity, options.tolerance))


def write_table(path: str, results: Mapping[str | None, Accuracy]) -> None:
    """Write all runs and results as comma separated values."""
    with open(path, "w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(["quantity", "unit", "method", "cell_size", "factor", "particles", "steps",
                         "core_seconds", "value", "kind", "order", "extrapolated", "error_bound"])
        for method, found in results.items():
            for quantity, verdict in found.verdicts.items():
                for _, row in found.table.iterrows():
                    writer.writerow([quantity, found.units[quantity], method or "", f"{row['cell_size']:.12g}",
                                     f"{row['factor']:.12g}", int(row["particles"]), int(row["steps"]),
                                     repr(float(row["core_seconds"])), repr(float(row[quantity])), verdict.kind,
                                     repr(verdict.order), "" if verdict.limit is None else repr(verdict.limit),
                                     repr(verdict.error)])


def numbers(text: str) -> list[float]:
    """Positive numbers between commas, without duplicates."""
    try:
        found = [float(word) for word in text.split(",")]
    except ValueError:
        found = []
    if len(set(found)) < 3 or min(found) <= 0.0 or not all(map(math.isfinite, found)):
        raise argparse.ArgumentTypeError(
            "at least three different numbers above zero, such as 2,1.4,1, are needed")
    return found


def change(text: str) -> tuple[str, str]:
    """A pair of name and value from GROUP.KEY=VALUE."""
    name, sign, value = text.partition("=")
    if not sign or not re.fullmatch(r"\w+(\[[^]]*\])?\.\w+", name.strip()):
        raise argparse.ArgumentTypeError(f"'{text}' is not of the form GROUP.KEY=VALUE")
    return name.strip(), value.strip()


def tolerance(text: str) -> str:
    """A tolerance: a number, or a percentage."""
    try:
        if (float(text[:-1]) if text.endswith("%") else number_with_unit(text)) > 0.0:
            return text
    except (ValueError, argparse.ArgumentTypeError):
        pass
    raise argparse.ArgumentTypeError(f"'{text}' is not like 1% (of the value), 0.002 (in SI) or 2mm")


def percentile(text: str) -> float:
    """A percentage of the mass above 50 and up to 100."""
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not 50.0 < value <= 100.0:
        raise argparse.ArgumentTypeError(f"'{text}' is not a number above 50 and up to 100")
    return value


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """The options."""
    parser.add_argument("deck", metavar="DECK")
    parser.add_argument("--quantity", nargs="+", required=True, metavar="NAME", help="see above")
    parser.add_argument("--factors", type=numbers, default=[2.0, 1.4, 1.0],
                        help="cell sizes relative to the deck (2,1.4,1)")
    parser.add_argument("--methods", help="methods to run, such as ddmp,mpm; default: that of the deck")
    parser.add_argument("--tolerance", type=tolerance, default="1%", help="target (1%%)")
    parser.add_argument("--set", dest="settings", type=change, action="append", default=[],
                        metavar="G.K=VALUE", help="set a key, as in scree")
    parser.add_argument("--body", help="only particles of this body")
    parser.add_argument("--percentile", type=percentile, default=100.0,
                        help="extents omit the rest of the mass on each side (100)")
    parser.add_argument("--scree", metavar="PROGRAM",
                        help="the program; default build/bin/scree or in the path")
    parser.add_argument("--work", type=Path, help="folder for the runs (out/accuracy_DECK)")
    parser.add_argument("--csv", metavar="FILE", help="write the table to this file, in SI")
    parser.add_argument("--plot", metavar="FILE", help="plot values and errors to this file")


def run(options: argparse.Namespace) -> int:
    """Run, evaluate, print."""
    threads = threads_of_a_run()
    results = {}
    for method in options.methods.split(",") if options.methods else [None]:
        settings = {**dict(options.settings), **({"run.method": method} if method else {})}
        with warnings.catch_warnings(record=True) as notes:
            warnings.simplefilter("always", MassWarning)
            found = accuracy(options.deck, options.quantity, factors=options.factors, set=settings, body=options.body,
                             percentile=options.percentile, outdir=options.work, threads=threads,
                             jobs=jobs_for(threads), label=method or "", program=options.scree)
        for note in notes:
            print(f"note: {note.message}")
        results[method] = found
        for quantity in options.quantity:
            print_table(options, method, quantity, found)
    if options.csv:
        write_table(options.csv, results)
    if options.plot:
        figure = found.plot({method or "deck": result for method, result in results.items()})
        look.save(figure, options.plot, 110)
    return 0
