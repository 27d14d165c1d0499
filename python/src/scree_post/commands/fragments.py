# SPDX-License-Identifier: BSD-3-Clause
"""Finds fragments: connected particles that have not failed.

Particles are neighbours if their distance is at most --reach times the mean of their widths (1.5
connects the particles of a lattice along edges and face diagonals), or with --cell if they are in
the same or in adjacent cells. The table has one line per fragment, the heaviest first. In
axisymmetry fragments are rings. Models are completed at mirror planes: a fragment across the plane
is counted once, with its full mass, any other fragment once on each side. Fragments continue across
periodic boundaries.
"""
from __future__ import annotations

import argparse
import os
from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from scree.drawing import look
from scree.drawing.quantity import quantity
from scree.errors import EXIT_USAGE, ScreeError
from scree.files import beside, nearest, series, series_file, snapshot

from ..fragment_table import COLUMNS, fragments_of
from ..progress import Progress

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from scree.files import Moment, beside, nearest

    from ..fragment_table import Fragments

SUMMARY = "connected intact particles: table, masses, cumulative numbers"
EXAMPLES = ("fragments out/debris_cloud",
            "fragments out/debris_cloud --time 5us 10us --reach 2",
            "fragments out/debris_cloud_3d --all --cell 0.4mm --table pieces.csv")
FIELDS = ("mass", "volume", "velocity", "body", "failed", "damage")
SHOWN = 10               # lines of the table on the screen


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """The options."""
    add = parser.add_argument
    add("source", metavar="SERIES_OR_SNAPSHOT",
        help="CASE_p.hdf.series, CASE_p_000012.hdf or out/CASE")
    which = parser.add_mutually_exclusive_group()
    which.add_argument("--time", type=quantity, nargs="+", metavar="T",
                       help="nearest snapshots, in s or with a unit; default the last")
    which.add_argument("--all", action="store_true", help="all snapshots")
    how = parser.add_mutually_exclusive_group()
    how.add_argument("--reach", type=float, default=1.5, metavar="F",
                     help="neighbours are within F times the mean of their widths (1.5)")
    how.add_argument("--cell", type=quantity, metavar="L",
                     help="neighbours are in the same or adjacent cells of this width, such as 1mm")
    add("--least", type=int, default=1, metavar="N",
        help="omit fragments of fewer particles")
    add("--no-mirror", action="store_true", help="do not complete the model at mirror planes")
    add("--table", metavar="CSV", help="table; default CASE_pieces.csv in the folder of the series")
    add("--out", metavar="PNG", help="picture; default CASE_pieces.png in the folder of the series")
    add("--dpi", type=int, default=150, help="pixels per inch of the picture (150)")


def chosen(frames: Sequence[Moment], arguments: argparse.Namespace) -> Sequence[Moment]:
    """The requested snapshots."""
    if arguments.all:
        return frames
    return nearest(frames, arguments.time or [frames[-1][0]])


def write_table(path: str, found: Sequence[Fragments]) -> None:
    """The table as comma separated values; lines that begin with # describe it."""
    try:
        with open(path + ".part", "w", encoding="utf-8") as handle:
            handle.write(f"# {found[-1].note}\n" + ",".join(COLUMNS) + "\n")
            for one in found:
                for row in one.rows:
                    handle.write(",".join(f"{value:.9g}" for value in row) + "\n")
        os.replace(path + ".part", path)
    except OSError as error:
        raise ScreeError(f"cannot write {path}: {error.strerror or error}") from error


def say(one: Fragments) -> None:
    """The heaviest fragments, and the distribution of the mass."""
    masses = one.masses
    lone = sum(row[2] == 1 for row in one.rows)
    print(f"t = {one.time:.6g} s: {len(masses)} fragments, {lone} of them single particles")
    print(f"mass {one.total:.6e} kg: fragments {masses.sum():.6e}, failed {one.failed:.6e}, "
          f"left out {max(0.0, one.total - one.failed - masses.sum()):.6e}")
    if len(masses):
        print(f"{'':>4} {'particles':>9} {'mass [kg]':>12} {'size [m]':>11} {'x [m]':>11} "
              f"{'z [m]':>11} {'speed [m/s]':>12}")
    for row in one.rows[:SHOWN]:
        speed = float(np.linalg.norm(row[9:12]))
        print(f"{row[1]:4d} {row[2]:9d} {row[3]:12.5e} {row[5]:11.4e} {row[6]:11.4e} "
              f"{row[8]:11.4e} {speed:12.4f}")
    if len(masses) > SHOWN:
        print(f" ... {len(masses) - SHOWN} more in the table")


def picture(found: Sequence[Fragments], title: str) -> Figure:
    """Histogram of masses and cumulative numbers at the times."""
    plot = look.pyplot()
    figure: Figure
    figure, (left, right) = plot.subplots(1, 2, figsize=(11.0, 4.6), layout="constrained")
    every = np.concatenate([one.masses for one in found])
    factor, unit = look.scaled(float(every.max()), "kg")
    ends = np.log10(factor * every.min()), np.log10(factor * every.max())
    bins = np.logspace(ends[0] - 0.1, ends[1] + 0.1, 4 + int(8 * (ends[1] - ends[0])))
    clock, second = look.scaled(max(abs(one.time) for one in found), "s")
    for number, one in enumerate(found):
        if not len(one.masses):
            continue
        tint = look.COLOURS[number % len(look.COLOURS)] if len(found) <= len(look.COLOURS) else \
            plot.get_cmap("viridis")(number / len(found))
        text = f"t = {clock * one.time:.4g} {second}"
        left.hist(factor * one.masses, bins, histtype="stepfilled" if len(found) == 1 else "step",
                  color=tint, linewidth=1.5, label=text)
        ordered = np.sort(factor * one.masses)
        right.step(ordered, np.arange(len(ordered), 0, -1), where="pre", color=tint, label=text)
    for axes, words in ((left, "fragments in a class"), (right, "fragments at least as heavy")):
        axes.set_xscale("log")
        axes.set_yscale("log" if axes is right else "linear")
        axes.set_xlabel(f"mass [{unit}]")
        axes.set_ylabel(f"number of {words}")
        axes.grid(color="#dddddd", linewidth=0.6)
        axes.set_axisbelow(True)
        axes.spines[["top", "right"]].set_visible(False)
    right.set_ylim(bottom=0.8)
    left.yaxis.get_major_locator().set_params(integer=True)
    right.legend(loc="upper right", fontsize=9)
    figure.suptitle(title, fontsize=11)
    return figure


def check_arguments(arguments: argparse.Namespace) -> None:
    """Checks that the parser cannot do."""
    if not (np.isfinite(arguments.reach) and arguments.reach > 0.0):
        raise ScreeError("--reach must be above 0", EXIT_USAGE)
    if arguments.cell is not None and not arguments.cell > 0.0:
        raise ScreeError("--cell must be above 0", EXIT_USAGE)
    if arguments.least < 1:
        raise ScreeError("--least must be above 0", EXIT_USAGE)


def run(arguments: argparse.Namespace) -> int:
    """Read, find, write."""
    check_arguments(arguments)
    source = series_file(arguments.source)
    frames = chosen(series(source), arguments)
    out = arguments.out or beside(source, "_pieces.png")
    path = arguments.table or beside(source, "_pieces.csv")
    look.check_picture(out)
    found, title = [], ""
    with Progress(len(frames), "searching") as progress:
        for _, file in frames:
            snap = snapshot(file, FIELDS)
            title = snap.title
            found.append(fragments_of(snap, arguments.reach, arguments.cell,
                                      not arguments.no_mirror))
            found[-1].rows = [row for row in found[-1].rows if row[2] >= arguments.least]
            progress.step()
    for one in found:
        say(one)
    print(found[-1].note)
    write_table(path, found)
    print(f"wrote {path}")
    if any(one.rows for one in found):
        look.save(picture(found, title), out, arguments.dpi)
        print(f"wrote {out}")
    return 0
