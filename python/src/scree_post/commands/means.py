# SPDX-License-Identifier: BSD-3-Clause
"""Means over time of a steady state, with standard errors.

For a table (history, gauge, forces): mean and standard error of each column; a difference between
both halves of more than three errors and 5 % of the mean is marked as a drift. For a series of
grids: FIELD and FIELD_error for each field in each cell, in an image for ParaView. Errors are from
block averaging, the greatest over all block lengths (H. Flyvbjerg, H. G. Petersen, J. Chem. Phys.
91 (1989) 461). Sums since the start, such as impulses, have no mean; use forces instead.
"""
from __future__ import annotations

import argparse
import os
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from scree.drawing.quantity import quantity
from scree.errors import EXIT_USAGE, ScreeError, readable
from scree.files import history, is_grid, open_file, series
from scree.quantities import NUMBERED

from ..grains.statistics import drift, drifts, mean_error
from ..progress import Progress

if TYPE_CHECKING:
    from scree.arrays import Array
    from scree.files import Moment

SUMMARY = "means over time with errors, of tables and of fields on the grid"
EXAMPLES = ("means out/two_discs/two_discs_history.csv --from 1s",
            "means out/two_discs/two_discs_history.csv --columns kinetic,internal --out means.csv")
FEWEST = 4               # fewest rows for a mean


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """The options."""
    add = parser.add_argument
    add("source", metavar="TABLE_OR_SERIES", help="CASE_history.csv, CASE_gauge.csv, ... or CASE_g.hdf.series")
    add("--from", dest="begin", type=quantity, metavar="T", default=0.0, help="first time, such as 2ms (0)")
    add("--to", dest="end", type=quantity, metavar="T", default=float("inf"), help="last time (all)")
    add("--columns", metavar="X,Y", help="only these columns of a table")
    add("--row", type=int, metavar="N", help="bin or fragment of a table with several rows for each time")
    add("--out", metavar="FILE",
        help="table as CSV; for grids the image, default CASE_g_mean.hdf in the folder of the series")


def of_table(arguments: argparse.Namespace) -> int:
    """Print the means of the columns of a table; rows (name, unit, mean, error, drift) are
    written on request."""
    table = history(arguments.source)
    time = table["time"]
    inside = (time >= arguments.begin) & (time <= arguments.end)
    numbered = next((name for name in NUMBERED if name in table), "")
    if bool(numbered) != (arguments.row is not None):
        raise ScreeError(f"{arguments.source} has several rows for each time: choose one by its {numbered}, --row 1"
                         if numbered else f"{arguments.source} has one row for each time; omit --row", EXIT_USAGE)
    if numbered:
        inside &= table[numbered] == arguments.row
    if inside.sum() < FEWEST:
        raise ScreeError(f"{arguments.source}: {inside.sum()} rows between the times, a mean needs {FEWEST}")
    names = [name for name in table.order if name not in ("time", "step", "dt")]
    if arguments.columns:
        names = [name.strip() for name in arguments.columns.split(",")]
        for name in names:
            if name not in table:
                raise ScreeError(f"{arguments.source} has no column {name}; there are {', '.join(table.order)}")
    width = max(len(name) for name in names)
    print(f"{inside.sum()} rows from {time[inside][0]:g} to {time[inside][-1]:g} s")
    rows = ["column,unit,mean,error,drift"]
    for name in names:
        values = table[name][inside]
        change = drift(values)[0]
        mark = "  drifts" if drifts(values) else ""
        print(f"{name:<{width}}  {values.mean():14.6e} +- {mean_error(values):9.2e} {table.units[name]}{mark}")
        rows.append(f"{name},{table.units[name]},{values.mean():.17g},{mean_error(values):.17g},{change:.17g}")
    if arguments.out:
        Path(arguments.out).write_text("\n".join(rows) + "\n", encoding="utf-8")
    return 0


def box_of(handle: Any) -> tuple[Array, Array]:
    """Twice the first point of an image along each axis in cells, and its shape as (z, y, x)."""
    head = handle["VTKHDF"].attrs
    first = np.rint(np.array(head["Origin"]) / np.array(head["Spacing"]) * 2.0).astype(int)
    extent = np.array(head["WholeExtent"]).reshape(3, 2)
    return first, (extent[:, 1] - extent[:, 0] + 1)[::-1]


def of_grids(arguments: argparse.Namespace, frames: Sequence[Moment]) -> int:
    """Mean and error of each field in each cell; a cell without material counts as 0."""
    frames = [(time, path) for time, path in frames if arguments.begin <= time <= arguments.end]
    if len(frames) < FEWEST:
        raise ScreeError(f"{arguments.source}: {len(frames)} grids between the times, a mean needs {FEWEST}")
    boxes = []
    for _, path in frames:
        with open_file(path) as handle:
            boxes.append(box_of(handle))
    low = np.min([first for first, _ in boxes], axis=0)
    high = np.max([first + 2 * (shape[::-1] - 1) for first, shape in boxes], axis=0)
    shape = ((high - low) // 2 + 1)[::-1]
    with open_file(frames[-1][1]) as handle:
        fields = {name: data.shape[3:] for name, data in handle["VTKHDF/PointData"].items()}
        head = dict(handle["VTKHDF"].attrs)
    stack = {name: np.zeros((len(frames), *shape, *more), dtype="f4") for name, more in fields.items()}
    with Progress(len(frames), "grids") as progress:
        for row, ((_, path), (first, size)) in enumerate(zip(frames, boxes)):
            start = ((first - low) // 2)[::-1]
            place: tuple[Any, ...] = tuple(slice(a, a + n) for a, n in zip(start, size))
            with open_file(path) as handle:
                for name in fields:
                    stack[name][(row, *place)] = handle["VTKHDF/PointData"][name][...]
            progress.step()
    out = arguments.out or arguments.source.replace(".hdf.series", "") + "_mean.hdf"
    head["Origin"] = np.array(head["Spacing"]) * low / 2.0
    head["WholeExtent"] = np.array([[0, n - 1] for n in shape[::-1]], dtype="i4").ravel()
    write_image(out, head, stack)
    print(f"{out}: {', '.join(fields)} and their errors, of {len(frames)} grids")
    return 0


def write_image(path: str, head: Mapping[str, Any], stack: Mapping[str, Array]) -> None:
    """The image: means and errors."""
    import h5py
    with h5py.File(path, "w") as handle:
        group = handle.create_group("VTKHDF")
        for name, value in head.items():
            group.attrs[name] = value
        data = group.create_group("PointData")
        for name, values in stack.items():
            flat = values.reshape(len(values), -1).astype("f8")
            data[name] = values.mean(axis=0, dtype="f8")
            errors = np.array([mean_error(column) for column in flat.T])
            data[f"{name}_error"] = errors.reshape(values.shape[1:])


def run(arguments: argparse.Namespace) -> int:
    """Means of a table or of grids."""
    source = readable(arguments.source) if not os.path.isdir(arguments.source) else arguments.source
    if str(source).endswith(".csv"):
        return of_table(arguments)
    frames = series(arguments.source)
    if not is_grid(frames[-1][1]):
        raise ScreeError(f"{arguments.source} is neither a table nor a series of grids (CASE_g.hdf.series)")
    return of_grids(arguments, frames)
