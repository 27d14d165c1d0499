# SPDX-License-Identifier: BSD-3-Clause
"""Compares two runs: the greatest and the root mean square difference of every field.

Snapshots at the same time are compared, with particles matched by identity. Histories are compared
line by line, or with --interpolate at the times of the first one. Relative differences are relative
to the greatest magnitude of the field in A at all times. The exit code is 1 if a relative
difference exceeds --tolerance (default 0), or if particles, times or fields of one run are missing
in the other.
"""
from __future__ import annotations

import argparse
import math
import os
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from scree.errors import EXIT_DIFFERENT, EXIT_USAGE, ScreeError, unknown
from scree.files import history, history_file, series, series_file, snapshot

from ..progress import Progress

if TYPE_CHECKING:
    from scree.arrays import Array
    from scree.files import Moment, Snapshot

SUMMARY = "differences of two runs, particle by particle"
EXAMPLES = ("compare out/two_discs out/again",
            "compare out/two_discs out/again --fields velocity,pressure --tolerance 1e-6",
            "compare out/two_discs/two_discs_history.csv out/coarse/coarse_history.csv "
            "--interpolate")
MOST_LINES = 12          # lines about data missing on one side


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """The options."""
    add = parser.add_argument
    add("a", metavar="A", help="series, snapshot, folder or history")
    add("b", metavar="B", help="the same of another run")
    add("--fields", metavar="X,Y", help="only these fields (position: coordinates) or columns")
    add("--tolerance", type=float, default=0.0, metavar="R",
        help="greatest relative difference that is accepted (0: equal numbers)")
    add("--time-tolerance", type=float, default=1.0e-6, metavar="R",
        help="times count as equal within this fraction of the whole time (1e-6)")
    add("--interpolate", action="store_true", help="histories: interpolate to the times of A")

# by name: differences, units; missing data
Differences = tuple[dict[str, "Field"], dict[str, str], list[str]]


class Field:
    """Differences of one field over all times."""

    def __init__(self) -> None:
        self.greatest, self.squares, self.count, self.scale = 0.0, 0.0, 0, 0.0
        self.time = math.nan                             # of the greatest difference [s]

    def add(self, one: Any, two: Any, time: float) -> None:
        """Add the numbers of one time; two NaN are the same."""
        one, two = np.asarray(one, "f8"), np.asarray(two, "f8")
        if not one.size:
            return
        both = np.isnan(one) & np.isnan(two) | (one == two)
        with np.errstate(invalid="ignore", over="ignore"):
            off = np.where(both, 0.0, np.abs(one - two))
        off = np.where(np.isnan(off), np.inf, off)
        finite = np.abs(one[np.isfinite(one)])
        self.scale = max(self.scale, float(finite.max()) if finite.size else 0.0)
        if float(off.max()) > self.greatest or self.count == 0:
            self.greatest, self.time = float(off.max()), time
        self.squares += float((off ** 2).sum())
        self.count += off.size

    @property
    def mean(self) -> float:
        """Root mean square difference."""
        return math.sqrt(self.squares / self.count) if self.count else 0.0

    def relative(self, size: float) -> float:
        """A difference over the greatest magnitude of the field."""
        if size == 0.0:
            return 0.0
        return size / self.scale if self.scale > 0.0 else math.inf


def print_table(fields: Mapping[str, Field], units: Mapping[str, str], missing: list[str]) -> None:
    """The differences, and the data missing on one side."""
    width = max([len(name) for name in fields] + [5])
    print(f"{'field':<{width}}  {'unit':<9} {'greatest':>12} {'relative':>10} {'rms':>12} "
          f"{'relative':>10}  at time [s]")
    for name, one in fields.items():
        print(f"{name:<{width}}  {units.get(name, '1'):<9} {one.greatest:12.5e} "
              f"{one.relative(one.greatest):10.3e} {one.mean:12.5e} {one.relative(one.mean):10.3e}"
              f"  {one.time:.6g}")
    for sentence in missing[:MOST_LINES]:
        print(f"DIFFERENT {sentence}")
    if len(missing) > MOST_LINES:
        print(f"DIFFERENT and {len(missing) - MOST_LINES} more like these")


def pair_times(frames_a: Sequence[Moment], frames_b: Sequence[Moment],
               tolerance: float) -> tuple[list[tuple[str, str]], list[str]]:
    """Pairs of files of the same time, and sentences about times of one side only."""
    times_b = np.array([time for time, _ in frames_b])
    span = max(abs(frames_a[-1][0]), abs(frames_b[-1][0]))
    pairs, missing, used = [], [], set()
    for time, file in frames_a:
        row = int(np.argmin(np.abs(times_b - time)))
        if abs(times_b[row] - time) <= tolerance * span:
            pairs.append((file, frames_b[row][1]))
            used.add(row)
        else:
            missing.append(f"B has no snapshot at {time:.9g} s")
    missing += [f"A has no snapshot at {time:.9g} s" for row, (time, _) in enumerate(frames_b)
                if row not in used]
    return pairs, missing


def matched(one: Snapshot, two: Snapshot, missing: list[str]) -> tuple[Array, Array]:
    """Rows of the particles that are in both snapshots, in the same order."""
    if "identity" not in one.fields or "identity" not in two.fields:
        if len(one.points) != len(two.points):
            raise ScreeError(f"{one.file}: {len(one.points)} and {len(two.points)} particles and no "
                            "field identity to match them by; write it with &output fields")
        rows = np.arange(len(one.points))
        return rows, rows
    _, rows_a, rows_b = np.intersect1d(one.fields["identity"], two.fields["identity"],
                                       assume_unique=True, return_indices=True)
    for name, snap, rows in (("A", one, rows_a), ("B", two, rows_b)):
        lone = len(snap.points) - len(rows)
        if lone:
            missing.append(f"{lone} particles at {snap.time:.9g} s are in {name} only")
    return rows_a, rows_b


def wanted_names(names: list[str] | None, there: list[str], path: str) -> list[str]:
    """The requested names, all by default."""
    if names is None:
        return there
    for name in names:
        if name not in there:
            raise unknown("field", name, there, path)
    return names


def compare_series(arguments: argparse.Namespace, names: list[str] | None) -> Differences:
    """Fields, units and sentences of two series."""
    frames_a, frames_b = series(arguments.a), series(arguments.b)
    pairs, missing = pair_times(frames_a, frames_b, arguments.time_tolerance)
    if not pairs:
        raise ScreeError(f"{arguments.a} and {arguments.b} have no time in common; "
                        "see --time-tolerance", EXIT_USAGE)
    fields: dict[str, Field] = {}
    units, particles = {"position": "m"}, 0
    with Progress(len(pairs), "comparing") as progress:
        for file_a, file_b in pairs:
            one, two = snapshot(file_a), snapshot(file_b)
            rows_a, rows_b = matched(one, two, missing)
            particles += len(rows_a)
            sides = [{"position": snap.points, **snap.fields} for snap in (one, two)]
            there = [name for name in sides[0] if name != "identity"]
            for name in wanted_names(names, there, file_a):
                left, right = sides[0][name], sides[1].get(name)
                units.setdefault(name, one.units.get(name, "1"))
                if right is None or right.shape[1:] != left.shape[1:]:
                    missing.append(f"field {name} at {one.time:.9g} s is not the same kind in B")
                    continue
                fields.setdefault(name, Field()).add(left[rows_a], right[rows_b], one.time)
            if names is None:
                missing += [f"field {name} at {one.time:.9g} s is in B only" for name in sides[1]
                            if name not in sides[0]]
            progress.step()
    print(f"{len(pairs)} times, {particles} pairs of particles")
    return fields, units, missing


def compare_histories(arguments: argparse.Namespace, names: list[str] | None) -> Differences:
    """Columns, units and sentences of two histories."""
    one, two = history(arguments.a), history(arguments.b)
    time, other = one["time"], two["time"]
    columns = [name for name in one.order if name not in ("time", "step", "dt")]
    columns = wanted_names(names, columns if names is None else one.order, arguments.a)
    missing: list[str] = []
    fields: dict[str, Field] = {}
    if arguments.interpolate:
        keep = (time >= other[0]) & (time <= other[-1])
        rows = np.flatnonzero(keep)
    else:
        span = max(abs(time[-1]), abs(other[-1]))
        same = len(time) == len(other) and np.all(
            np.abs(time - other) <= arguments.time_tolerance * span)
        if not same:
            raise ScreeError(f"{arguments.a} and {arguments.b} have lines of different times; "
                            "use --interpolate", EXIT_USAGE)
        rows = np.arange(len(time))
    if len(rows) == 0:
        raise ScreeError(f"{arguments.a} and {arguments.b} have no time in common", EXIT_USAGE)
    for name in columns:
        if name not in two:
            missing.append(f"column {name} is in A only")
            continue
        values = np.interp(time[rows], other, two[name]) if arguments.interpolate else two[name]
        field = fields.setdefault(name, Field())
        for row, here, there in zip(rows, one[name][rows], values):
            field.add([here], [there], float(time[row]))
    if names is None:
        missing += [f"column {name} is in B only" for name in two.order if name not in one]
    print(f"{len(rows)} lines")
    return fields, one.units, missing


def is_history(path: str) -> bool:
    """True if a path is a history: a .csv, or a folder without particles."""
    if not os.path.isdir(path):
        return path.endswith(".csv")
    return not any(name.endswith("_p.hdf.series") for name in os.listdir(path))


def run(arguments: argparse.Namespace) -> int:
    """Read both, compare, print."""
    if not arguments.tolerance >= 0.0 or not arguments.time_tolerance >= 0.0:
        raise ScreeError("tolerances must not be below 0", EXIT_USAGE)
    names = arguments.fields.split(",") if arguments.fields else None
    kinds = [is_history(path) for path in (arguments.a, arguments.b)]
    if kinds[0] != kinds[1]:
        raise ScreeError("a history can only be compared with a history", EXIT_USAGE)
    find = history_file if kinds[0] else series_file
    arguments.a, arguments.b = find(arguments.a), find(arguments.b)
    work = compare_histories if kinds[0] else compare_series
    fields, units, missing = work(arguments, names)
    print_table(fields, units, missing)
    worst = max((one.relative(one.greatest) for one in fields.values()), default=0.0)
    if missing or worst > arguments.tolerance:
        print(f"different: greatest relative difference {worst:.3e}, tolerance "
              f"{arguments.tolerance:g}" + (f"; {len(missing)} things missing" if missing else ""))
        return EXIT_DIFFERENT
    print(f"the same within {arguments.tolerance:g}: greatest relative difference {worst:.3e}")
    return 0
