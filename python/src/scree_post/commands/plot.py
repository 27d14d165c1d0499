# SPDX-License-Identifier: BSD-3-Clause
"""Plots histories: the whole ledger of a run, or chosen columns of one or several runs.

Without --y the page shows energies, momenta, masses and their errors. With --y there is one panel
for each unit of the columns; several histories are drawn in the same panels.
"""
from __future__ import annotations

import argparse
import os
from collections.abc import Sequence
from typing import TYPE_CHECKING

from scree import plot
from scree.drawing import look
from scree.errors import EXIT_USAGE, ScreeError, unknown
from scree.files import history, history_file
from scree.quantities import NUMBERED
from scree.results import read_table

from .. import ledger_page

if TYPE_CHECKING:
    import pandas
    from matplotlib.figure import Figure

    from scree.files import History

MOST = 6                 # curves of a table with several rows for each time
SUMMARY = "columns of histories against time or each other"
EXAMPLES = ("plot out/two_discs/two_discs_history.csv",
            "plot out/two_discs --y kinetic,internal",
            "plot out/two_discs out/coarse --y energy_error --log --out errors.png")


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """The options."""
    add = parser.add_argument
    add("histories", metavar="HISTORY", nargs="+", help="CASE_history.csv or out/CASE")
    add("--y", metavar="A,B", help="columns to plot; default: a page with the ledger")
    add("--x", metavar="A", default="time", help="column of the horizontal axis (time)")
    add("--log", action="store_true", help="absolute values on a logarithmic scale")
    add("--log-x", action="store_true", help="logarithmic horizontal axis")
    add("--out", metavar="PNG", help="picture (.png, .pdf, .svg); default: in the folder of the history")
    add("--title", help="default: the name of the case")
    add("--dpi", type=int, default=150, help="pixels per inch of the picture (150)")


def case_of(path: str) -> str:
    """Name of the case of a history."""
    return os.path.splitext(os.path.basename(path))[0].removesuffix("_history")


def curves(name: str, table: pandas.DataFrame, across: str, alone: bool) -> dict[str, pandas.DataFrame]:
    """The table itself; one with several rows for each time is divided into a curve for each of the first rows over
    time, or for some of its times over another column. A table that is drawn alone needs no name."""
    numbered = next((key for key in NUMBERED if key in table), "")
    if not numbered:
        return {name: table}
    first = "" if alone else f"{name}, "
    if across == "time":
        return {f"{first}{numbered} {number}": table[table[numbered] == number]
                for number in sorted(set(table[numbered].astype(int))) if number <= MOST}
    times = sorted(set(table["time"]))
    chosen = [times[place * (len(times) - 1) // max(min(MOST, len(times)) - 1, 1)]
              for place in range(min(MOST, len(times)))]
    factor, unit = look.scaled(max(times), "s")
    return {f"{first}{factor * time:.4g} {unit}": table[table["time"] == time] for time in chosen}


def chosen_columns(paths: Sequence[str], arguments: argparse.Namespace) -> Figure:
    """The figure of chosen columns, a panel for each unit."""
    names = [name.strip() for name in arguments.y.split(",") if name.strip()]
    if not names:
        raise ScreeError("--y names no column", EXIT_USAGE)
    tables: dict[str, pandas.DataFrame] = {}
    for path in paths:
        table = read_table(path)
        for name in (arguments.x, *names):
            if name not in table:
                raise unknown("column", name, table.columns, path)
        tables |= curves(case_of(path) if case_of(path) not in tables else path, table, arguments.x, len(paths) == 1)
    if arguments.log and not any(table[name].any() for table in tables.values() for name in names):
        raise ScreeError("--log: all these columns are zero", EXIT_USAGE)
    look.pyplot()                                        # fonts and colours of the common style
    figure = plot.columns_of(tables, names, x=arguments.x, log=arguments.log, log_x=arguments.log_x)
    title = arguments.title or (look.words(case_of(paths[0])) if len(paths) == 1 else "")
    if title:
        figure.suptitle(title, fontweight="bold", fontsize=14)
    return figure


def say(table: History, path: str, lone: bool) -> None:
    """The state of the ledger at the end."""
    head = "" if lone else f"{case_of(path)}: "
    print(f"{head}{len(table['time'])} lines, time {table['time'][0]:.6g} to "
          f"{table['time'][-1]:.6g} s")
    for name, (_, text) in ledger_page.ERRORS.items():
        if name in table:
            print(f"{head}largest relative error of {text}: {abs(table[name]).max():.2e}, at the "
                  f"end {abs(table[name][-1]):.2e}")


def run(arguments: argparse.Namespace) -> int:
    """Read, plot, and print the state of the ledger at the end."""
    paths = [history_file(path) for path in arguments.histories]
    tables = [history(path) for path in paths]
    for table, path in zip(tables, paths):
        if "time" not in table:
            raise ScreeError(f"{path} has no column 'time [s]'")
    if arguments.y is None and len(paths) > 1:
        raise ScreeError("several histories need --y, the columns to compare", EXIT_USAGE)
    out = arguments.out or os.path.splitext(paths[0])[0] + ".png"
    look.check_picture(out)
    if arguments.y is None:
        title = arguments.title or look.words(case_of(paths[0]))
        figure = ledger_page.picture(tables[0], title)
    else:
        figure = chosen_columns(paths, arguments)
    for table, path in zip(tables, paths):
        say(table, path, len(paths) == 1)
    look.save(figure, out, arguments.dpi)
    print(f"wrote {out}")
    return 0
