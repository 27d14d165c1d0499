# SPDX-License-Identifier: BSD-3-Clause
"""Prints the content of a file: fields, units, ranges, bodies, times and origin.

The file is a snapshot, a series, a checkpoint, a history or another table, or a folder of results.
For a series the last snapshot is shown unless --time selects another one. All numbers are in SI,
also those of files in other units (output_units of the deck).
"""
from __future__ import annotations

import argparse
import os
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from scree import units as units_of
from scree.drawing.quantity import quantity
from scree.errors import EXIT_USAGE, ScreeError, decoded, readable
from scree.files import history, is_grid, open_file, series, snapshot, text

from ..progress import Progress

if TYPE_CHECKING:
    from scree.arrays import Array
    from scree.files import Snapshot

SUMMARY = "fields, units, ranges, bodies, times and origin of a file"
EXAMPLES = ("info out/two_discs",
            "info out/two_discs/two_discs_p.hdf.series --time 2",
            "info out/two_discs/two_discs_chk_0001.h5",
            "info out/two_discs/two_discs_p_000003.hdf --deck")
ORIGIN = ("title", "case", "dimension", "symmetry", "version", "git", "compiler")


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """The options."""
    add = parser.add_argument
    add("source", metavar="FILE", help="snapshot, series, checkpoint, history or folder")
    add("--time", type=quantity, metavar="T", help="snapshot of a series nearest to this time")
    add("--all", action="store_true", help="ranges over all snapshots of a series")
    add("--deck", action="store_true", help="print only the deck that is stored in the file")


def line(name: str, value: Any) -> None:
    """A line of the description."""
    if str(value).strip():
        print(f"{name:<12} {value}")


def ranges(fields: Mapping[str, Sequence[Array]], units: Mapping[str, str]) -> None:
    """A table of fields: unit, components, least, greatest and mean value."""
    width = max([len(name) for name in fields] + [5])
    print(f"{'field':<{width}}  {'unit':<8} {'parts':>5} {'least':>12} {'greatest':>12} "
          f"{'mean':>12}")
    for name, parts in fields.items():
        parts = [values for values in parts if len(values)]
        unit = units.get(name, "1")
        if not parts:
            print(f"{name:<{width}}  {unit:<8} {'':>5} no particles")
            continue
        count = parts[0].shape[1] if parts[0].ndim == 2 else 1
        least = min(float(np.nanmin(values)) for values in parts)
        most = max(float(np.nanmax(values)) for values in parts)
        mean = sum(float(values.sum(dtype="f8")) for values in parts) / sum(v.size for v in parts)
        wrong = sum(int((~np.isfinite(values)).sum()) for values in parts)
        print(f"{name:<{width}}  {unit:<8} {count:>5} {least:>12.5g} {most:>12.5g} {mean:>12.5g}"
              + (f"  {wrong} not a number" if wrong else ""))


def bodies(snap: Snapshot) -> None:
    """A table of bodies."""
    if not snap.bodies or len(snap.points) == 0:
        return
    rows, mass = snap.body_rows(), snap.fields.get("mass")
    velocity = snap.fields.get("velocity")
    print(f"{'body':<12} {'particles':>9} {'mass [kg]':>13}  mean velocity [m/s]")
    for row in np.unique(rows):
        pick = rows == row
        heavy = f"{mass[pick].sum(dtype='f8'):13.6e}" if mass is not None else f"{'':>13}"
        mean = ""
        if mass is not None and velocity is not None:
            mean = "  ".join(f"{value:.5g}" for value in np.average(
                velocity[pick].astype("f8"), axis=0, weights=mass[pick].astype("f8")))
        print(f"{snap.body_name(row):<12} {int(pick.sum()):>9} {heavy}  {mean}")


def describe_snapshot(snap: Snapshot, others: Sequence[Snapshot] = ()) -> None:
    """The full description of one snapshot; ranges also over `others`."""
    for name in ORIGIN:
        line(name, snap.provenance.get(name, ""))
    line("step", snap.provenance.get("step", ""))
    line("time", f"{snap.time:.9g} s")
    line("particles", len(snap.points))
    bodies(snap)
    every = [snap, *others]
    fields = {"position": [one.points for one in every]}
    for name in snap.fields:
        fields[name] = [one.fields[name] for one in every if name in one.fields]
    ranges(fields, {"position": "m", **snap.units})


def span_text(times: Array) -> str:
    """The time span of a series in words."""
    return f"{times[0]:.6g} to {times[-1]:.6g} s" + (
        f", about every {np.median(np.diff(times)):.4g} s" if len(times) > 1 else "")


def nearest(times: Array, wanted: float | None) -> int:
    """Row of the time nearest to the requested one, by default the last."""
    return -1 if wanted is None else int(np.argmin(np.abs(times - wanted)))


def describe_series(path: str, arguments: argparse.Namespace) -> None:
    """Times, and one snapshot."""
    frames = series(path)
    times = np.array([time for time, _ in frames])
    print(f"{path}: {len(frames)} snapshots")
    line("times", span_text(times))
    row = nearest(times, arguments.time)
    others = []
    if arguments.all:
        with Progress(len(frames), "reading") as progress:
            for number, (_, file) in enumerate(frames):
                if number != row % len(frames):
                    others.append(snapshot(file))
                progress.step()
    describe_snapshot(snapshot(frames[row][1]), others)


def describe_checkpoint(path: str) -> None:
    """State, fields and ranges of a checkpoint."""
    with open_file(path) as handle:
        print(f"{path}: checkpoint")
        for name in ("case", "version", "step", "time"):
            if name in handle.attrs:
                value = text(handle.attrs[name])
                line(name, f"{value:.9g} s" if name == "time" else value)
        for name, group in handle["particles"].items():
            count = len(group["identity"]) if "identity" in group else 0
            print(f"material {name}: {count} particles")
            fields = {key: [units_of.data_si(group[key])] for key in group}
            units = {key: units_of.data_unit(group[key]) for key in group}
            ranges(fields, units)


def describe_history(path: str) -> None:
    """Lines and ranges of the columns."""
    table = history(path, may_be_empty=True)
    kind = "history" if path.endswith("_history.csv") else "table"
    lines = len(table["time"]) if table else 0
    print(f"{path}: {kind} of {lines} lines")
    if lines == 0:
        return
    width = max(len(name) for name in table.order)
    print(f"{'column':<{width}}  {'unit':<9} {'first':>13} {'last':>13} {'least':>13} "
          f"{'greatest':>13}")
    zero = [name for name in table.order if not table[name].any()]
    for name in table.order:
        values = table[name]
        if name in zero:
            continue
        print(f"{name:<{width}}  {table.units[name]:<9} {values[0]:>13.6g} {values[-1]:>13.6g} "
              f"{values.min():>13.6g} {values.max():>13.6g}")
    if zero:
        print(f"always zero: {', '.join(zero)}")


def describe_grids(path: str, arguments: argparse.Namespace) -> None:
    """Times of a series of grids, and ranges of one of them or of a single file."""
    if path.endswith(".series"):
        frames = series(path)
        times = np.array([time for time, _ in frames])
        print(f"{path}: {len(frames)} grids")
        line("times", span_text(times))
        path = frames[nearest(times, arguments.time)][1]
    else:
        print(f"{path}: grid")
    with open_file(path) as handle:
        group, record = handle["VTKHDF"], handle["provenance"].attrs
        for name in (*ORIGIN, "step"):
            line(name, text(record[name]) if name in record else "")
        line("time", f"{units_of.time_si(handle) or 0.0:.9g} s")
        extent = [int(edge) for edge in group.attrs["WholeExtent"]]
        line("points", " x ".join(str(extent[2 * k + 1] - extent[2 * k] + 1) for k in range(3)))
        for name in ("Origin", "Spacing"):
            edges = units_of.shifted(group.attrs[name][...], units_of.data_exponent(group))
            line(name.lower(), " ".join(f"{value:.6g}" for value in edges) + " m")
        data = group["PointData"]
        ranges({name: [flat(units_of.data_si(data[name]))] for name in data},
               {name: units_of.data_unit(data[name]) for name in data})


def flat(values: Array) -> Array:
    """Values on a grid as rows of points, components last."""
    return values.reshape(-1, values.shape[3]) if values.ndim == 4 else values.reshape(-1)


def kind_of(path: str) -> str:
    """Kind of a file: series, snapshot, checkpoint or history."""
    if path.endswith(".series"):
        return "series"
    if path.endswith(".csv"):
        return "history"
    try:
        with open_file(path) as handle:
            if "particles" in handle and "state" in handle:
                return "checkpoint"
    except ScreeError as error:
        raise ScreeError(f"cannot open {path}: neither series, history, snapshot nor checkpoint, or "
                        "truncated") from error
    return "grid" if is_grid(path) else "snapshot"


def deck_of(path: str) -> str:
    """The deck in a file."""
    kind = kind_of(path)
    if kind == "series":
        path, kind = series(path)[-1][1], "snapshot"
    if kind == "history":
        raise ScreeError(f"{path}: a history contains no deck; use a snapshot", EXIT_USAGE)
    with open_file(path) as handle:
        name = "deck" if kind == "checkpoint" else "provenance/deck"
        if name not in handle:
            raise ScreeError(f"{path} contains no deck")
        return decoded(bytes(handle[name][...]))


def first_of(path: str) -> str:
    """The first file that a series lists, without opening it as a snapshot."""
    return series(path)[0][1]


def describe(path: str, arguments: argparse.Namespace) -> None:
    """A file of any kind."""
    kind = kind_of(readable(path))
    if kind == "grid" or (kind == "series" and is_grid(first_of(path))):
        describe_grids(path, arguments)
    elif kind == "series":
        describe_series(path, arguments)
    elif kind == "history":
        describe_history(path)
    elif kind == "checkpoint":
        describe_checkpoint(path)
    else:
        snap = snapshot(path)
        print(f"{path}: snapshot")
        describe_snapshot(snap)


def in_folder(path: str) -> tuple[list[str], list[str]]:
    """Series, histories and checkpoints of a folder."""
    names = sorted(os.listdir(path), key=lambda name: (name.endswith(".csv"), name))
    found = [os.path.join(path, name) for name in names
             if name.endswith((".hdf.series", "_history.csv"))]
    if not found:
        raise ScreeError(f"{path}: no series (*.hdf.series) and no history (*_history.csv) in this "
                        "folder")
    kept = [name for name in names if "_chk_" in name and name.endswith(".h5")]
    return found, kept


def run(arguments: argparse.Namespace) -> int:
    """Describe a file or folder."""
    path = arguments.source
    if os.path.isdir(path):
        found, kept = in_folder(path)
        if arguments.deck:
            found = [name for name in found if name.endswith(".series")][:1] or found[:1]
    else:
        found, kept = [readable(path)], []
    if arguments.deck:
        print(deck_of(found[0]).rstrip("\n"))
        return 0
    for number, name in enumerate(found):
        if number:
            print()
        describe(name, arguments)
    if kept:
        print(f"\n{path}: checkpoints {', '.join(kept)}")
    return 0
