# SPDX-License-Identifier: BSD-3-Clause
"""Plots histories: the whole ledger of a run, or chosen columns of one or several runs.

Without --y the page holds energies, momenta, masses and their errors. With --y there is a panel
for each unit among the columns; several histories are drawn into the same panels.
"""
from __future__ import annotations

import argparse
import os
from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from scree.drawing import look
from scree.errors import EXIT_USAGE, ScreeError, unknown
from scree.files import history, history_file

from .. import ledger_page

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from scree.arrays import Array
    from scree.files import History

SUMMARY = "columns of histories against time or each other"
EXAMPLES = ("plot out/two_discs/two_discs_history.csv",
            "plot out/two_discs --y kinetic,internal",
            "plot out/two_discs out/coarse --y energy_error --log --out errors.png")
QUANTITY = {"J": "energy", "kg": "mass", "s": "time", "m": "length", "m/s": "velocity",
            "kg m/s": "momentum", "N s": "impulse", "kg m2/s": "angular momentum"}
DASHES = ("-", (0, (5, 2)), (0, (1, 1.2)), (0, (5, 2, 1, 2)))


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """The options."""
    add = parser.add_argument
    add("histories", metavar="HISTORY", nargs="+", help="CASE_history.csv or out/CASE")
    add("--y", metavar="A,B", help="columns to draw; default: a page with the ledger")
    add("--x", metavar="A", default="time", help="column along the page (time)")
    add("--log", action="store_true", help="sizes of the columns on a logarithmic scale")
    add("--log-x", action="store_true", help="the same along the page")
    add("--out", metavar="PNG", help="picture (.png, .pdf, .svg); default beside the history")
    add("--title", help="default: the name of the case")
    add("--dpi", type=int, default=150, help="pixels per inch of the picture (150)")


def case_of(path: str) -> str:
    """Name of the case of a history."""
    return os.path.splitext(os.path.basename(path))[0].removesuffix("_history")


def column(table: History, name: str, path: str) -> Array:
    """A column, or an error that names those there are."""
    if name not in table:
        raise unknown("column", name, table.order, path)
    return table[name]


def groups(tables: Sequence[History], names: Sequence[str], paths: Sequence[str]) -> dict[str, list[str]]:
    """Columns by unit, in the order of the command line."""
    found: dict[str, list[str]] = {}
    for name in names:
        for table, path in zip(tables, paths):
            column(table, name, path)
        found.setdefault(tables[0].units[name], []).append(name)
    return found


def largest(tables: Sequence[History], names: Sequence[str]) -> float:
    """Largest finite size of columns of several histories."""
    return max(ledger_page.largest(table, names) for table in tables)


def draw_panel(axes: Axes, tables: Sequence[History], paths: Sequence[str], names: Sequence[str],
               arguments: argparse.Namespace, factor_x: float) -> None:
    """Columns of one unit of all histories."""
    unit = tables[0].units[names[0]]
    size = largest(tables, names)
    factor, label = (1.0, unit) if arguments.log else look.label_unit(size, unit)
    for run, (table, path) in enumerate(zip(tables, paths)):
        for number, name in enumerate(names):
            tint = number if len(names) > 1 or len(tables) == 1 else run
            dash = DASHES[run % len(DASHES)] if len(names) > 1 or len(tables) == 1 else "-"
            text = look.words(name) if len(tables) == 1 else f"{case_of(path)}: {look.words(name)}"
            values = factor * table[name]
            if arguments.log:
                values = np.where(values != 0.0, np.abs(values), np.nan)
            axes.plot(factor_x * table[arguments.x], values, color=look.COLOURS[tint % 7],
                      linestyle=dash, linewidth=1.6, label=text)
    if arguments.log:
        axes.set_yscale("log")
    if arguments.log_x:
        axes.set_xscale("log")
    head = look.words(names[0]) if len(names) == 1 else QUANTITY.get(unit, "value")
    if arguments.log and any(table[name].min() < 0.0 for table in tables for name in names):
        head = f"size of {head}"
    axes.set_ylabel(look.with_unit(head, label))
    axes.grid(color="#dddddd", linewidth=0.6)
    axes.set_axisbelow(True)
    axes.spines[["top", "right"]].set_visible(False)
    axes.margins(x=0.0)
    if len(names) * len(tables) > 1:
        axes.legend(loc="center left", bbox_to_anchor=(1.01, 0.5), borderaxespad=0.0)


def chosen_columns(tables: Sequence[History], paths: Sequence[str], arguments: argparse.Namespace) -> Figure:
    """The figure of chosen columns, a panel for each unit."""
    names = [name.strip() for name in arguments.y.split(",") if name.strip()]
    if not names:
        raise ScreeError("--y names no column", EXIT_USAGE)
    for table, path in zip(tables, paths):
        column(table, arguments.x, path)
    panels = groups(tables, names, paths)
    if arguments.log and not any(np.any(t[name] != 0.0) for t in tables for name in names):
        raise ScreeError("--log: all these columns are zero", EXIT_USAGE)
    plot = look.pyplot()
    figure: Figure
    figure, grid = plot.subplots(len(panels), 1, figsize=(8.0, 3.4 * len(panels) + 0.6),
                                 squeeze=False, layout="constrained", sharex=True)
    factor, unit = look.label_unit(largest(tables, [arguments.x]), tables[0].units[arguments.x])
    for axes, columns in zip(grid.ravel(), panels.values()):
        draw_panel(axes, tables, paths, columns, arguments, factor)
    grid.ravel()[-1].set_xlabel(look.with_unit(look.words(arguments.x), unit))
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
        figure = chosen_columns(tables, paths, arguments)
    for table, path in zip(tables, paths):
        say(table, path, len(paths) == 1)
    look.save(figure, out, arguments.dpi)
    print(f"wrote {out}")
    return 0
