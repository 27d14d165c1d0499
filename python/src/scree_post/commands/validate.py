# SPDX-License-Identifier: BSD-3-Clause
"""Compares Scree with experiments: runs decks and prints prediction, measurement and verdict.

Without a name the rows are listed. A name is that of a row, or of a family for all of its rows.
Each row runs on two grids; `cells` is the difference of their predictions. The verdict is `within`
if the prediction deviates by at most 5 %, or by the error of the measurement if that is larger,
`outside` if it deviates by more, and `not comparable` if the grids differ by more than that or
conditions of the experiment are not known. With --set inputs of a row are changed: the result is a
prediction. Rows are in folders of input/validation, which scree_post/validation.py describes.
"""
from __future__ import annotations

import argparse
import math
from pathlib import Path

from scree.drawing import look
from scree.errors import EXIT_USAGE, FileProblem, ScreeError
from scree.program import jobs_for, threads_of_a_run

from .. import validation

PAGE = Path(__file__).resolve().parents[4] / "doc/theory/validation.md"
SUMMARY = "compare with experiments: prediction, measurement, verdict"
EXAMPLES = ("validate", "validate taylor_cu_130 --set speed=210 --set length=23.47 --cells 4")


def change(text: str) -> tuple[str, str]:
    """A pair of name and value from NAME=VALUE."""
    name, sign, value = text.partition("=")
    if not sign or not name.strip() or not value.strip():
        raise argparse.ArgumentTypeError(f"'{text}' is not of the form NAME=VALUE")
    return name.strip(), value.strip()


def number(text: str) -> int:
    """A number of cells."""
    if not text.isdigit() or int(text) < 2:
        raise argparse.ArgumentTypeError(f"'{text}' is not an integer above 1")
    return int(text)


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """The options."""
    add = parser.add_argument
    add("names", nargs="*", metavar="NAME", help="rows or families")
    add("--set", dest="settings", type=change, action="append", default=[], metavar="NAME=VALUE",
        help="another input of one row: a number in the unit of the list, a number with a unit, or a key of the deck")
    add("--cells", type=number, metavar="N", help="cells instead of those of the family")
    add("--scree", "--program", dest="scree", metavar="PROGRAM",
        help="the program; default build/bin/scree or in the path")
    add("--jobs", type=int, metavar="N", help="number of simultaneous runs; default: as many as cores")
    add("--outdir", type=Path, default=Path("out/validation"), help="folder of the runs (out/validation)")
    add("--write", nargs="?", type=Path, const=PAGE, metavar="PAGE",
        help="renew results.csv, the tables and the figure of the page doc/theory/validation.md, or of another page, "
        "which has its own results.csv beside it; without a name the page only")


def show_list(known: dict[str, validation.Family]) -> None:
    """Print all rows."""
    cost = {row["name"]: row["seconds"] for row in validation.read_results(validation.place() / "results.csv")
            if float(row["seconds"])}
    for family in known.values():
        print(f"{family.name}: {family.title}")
        inputs = ", ".join(look.with_unit(name, unit) for name, unit in family.units.items())
        print(f"  inputs for --set: {inputs}; cells = {family.cells}")
        for shot in family.shots.values():
            quantities = ", ".join(look.with_unit(*family.quantities[name]) for name in shot.measured)
            print(f"  {shot.name:<24} {shot.what}; {quantities}; {cost.get(shot.name, '?')} s")


def show(results: list[validation.Result], known: dict[str, validation.Family]) -> None:
    """Print the results."""
    print(f"{'row':<24} {'quantity':<34} {'prediction':>11} {'cells':>9} {'measured':>10} {'error':>7} "
          f"{'deviation':>10}  verdict")
    for result in results:
        words = look.with_unit(*known[result.family].quantities[result.quantity])
        there = not math.isnan(result.measured)
        error = "-" if result.error is None else f"{result.error:g} %"
        print(f"{result.name:<24} {words:<34} {result.prediction:>11.5g} {result.cells_error:>+9.2g} "
              f"{f'{result.measured:.5g}' if there else '-':>10} {error:>7} "
              f"{f'{result.deviation:+.1f} %' if there else '-':>10}  {result.verdict}"
              + (f": {result.blocked}" if result.blocked else ""))
    seconds = sum(result.seconds for result in results)
    print(f"{seconds:.3g} s of processor time")


def write(path: Path, results: list[validation.Result], known: dict[str, validation.Family]) -> None:
    """Renew results.csv, the page, those of its subjects and the figure."""
    table = (validation.place() if path == PAGE else path.parent) / "results.csv"
    rows = validation.renewed(validation.read_results(table), results, known)
    text = validation.page_rows(known, rows, path.stem).join(validation.parts_of(path))
    figure = path.parent / "figures" / f"{path.stem}.png"
    try:
        figure.parent.mkdir(exist_ok=True)
        validation.write_results(table, rows)
        for name, page in {path.name: text, **validation.subject_pages(known, rows, path.stem)}.items():
            (path.parent / name).write_text(page, encoding="utf-8")
    except OSError as error:
        raise FileProblem(f"cannot write {error.filename}: {error.strerror}") from error
    look.save(validation.picture(known, rows), str(figure), 100)
    look.make_small(figure)
    print(f"wrote {table}, {path}, {figure}")


def run(options: argparse.Namespace) -> int:
    """List, run, print, write."""
    known = validation.families()
    shots = validation.choose(known, options.names)
    if options.settings and len(options.names) != 1:
        raise ScreeError("--set needs the name of one row or family", EXIT_USAGE)
    if options.settings and options.write is not None:
        raise ScreeError("--write needs measured rows, without --set", EXIT_USAGE)
    if options.jobs is not None and options.jobs < 1:
        raise ScreeError("--jobs must be above 0", EXIT_USAGE)
    if options.write is not None:
        validation.parts_of(options.write)               # an error before the runs
    if not shots:
        if options.write is None:
            show_list(known)
        else:
            write(options.write, [], known)
        return 0
    if options.settings:
        family, shot = shots[0]
        shots = [(family, validation.changed(family, shot, dict(options.settings)))]
        print(f"{shot.what}, with " + ", ".join(f"{name} = {value}" for name, value in shots[0][1].inputs.items()))
    threads = threads_of_a_run()
    results, failed = validation.compute(shots, program=options.scree, outdir=options.outdir, threads=threads,
                                         jobs=options.jobs or jobs_for(threads), cells=options.cells)
    if results:
        show(results, known)
        if options.write is not None:
            write(options.write, results, known)
    if failed:                                           # the rows of the other runs are kept
        raise failed[0]
    return 0
