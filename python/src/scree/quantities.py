# SPDX-License-Identifier: BSD-3-Clause
"""One number from the results of a run: a column of a table, a number of the summary, an extent.

    value_of(run, "kinetic:max")                  # a column of the history
    value_of(run, "gauge.velocity_x:at=5us")      # of the table CASE_gauge.csv
    value_of(run, "fragments[1].mass")            # of the heaviest fragment
    value_of(run, "ledger.energy_error")          # a place in the summary
    value_of(run, "front_z", body="sphere", percentile=99.0)

Extents are those of the centres of particles, weighted by mass if a percentile excludes some of it. The outermost
centres are half a particle inside of the surface, which is an error of first order in the cell size; with a percentile
below 100 there is no such error.
"""
from __future__ import annotations

import argparse
import math
import os
import re
import tempfile
from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING, Any

from .drawing.quantity import quantity as number_with_unit
from .errors import EXIT_USAGE, FileProblem, ScreeError, nearest
from .launch import run as run_deck
from .results import SERIES, Run
from .snapshot import AXES, Snapshot
from .units import summary_unit

if TYPE_CHECKING:
    import numpy as np
    import pandas
    from numpy.typing import NDArray

EXTENTS = ("length", "width", "radius", *(f"{side}_{axis}" for side in ("front", "back", "extent") for axis in AXES))
OVER = ("max", "min", "mean")            # numbers of several rows
NUMBERED = ("fragment", "bin")           # columns that number the rows of one time


def last_snapshot(run: Run) -> Snapshot | None:
    """The last snapshot of the first series, or None."""
    files = run.summary.get("files", {})
    name = next((str(files[key]) for key in sorted(files) if key.startswith("particles")), None)
    return run.series[name[len(run.case) + 1:-len(SERIES)]][-1] if name else None


def numbers(run: Run) -> dict[str, float]:
    """Numbers of the summary by their key paths, such as ledger.energy_error, and by their keys alone."""
    ledger = run.summary.get("ledger") or {}
    found: dict[str, Any] = {**ledger.get("end", {})}
    for name, group in (("ledger", ledger), *((key, run.summary.get(key) or {}) for key in ("exact", "extremes"))):
        found |= {**group, **{f"{name}.{key}": number for key, number in group.items()}}
    found |= run.summary
    return {key: number for key, number in found.items()
            if isinstance(number, (int, float)) and not isinstance(number, bool)}


def split(quantity: str) -> tuple[str, str]:
    """The name of a quantity, and what follows the colon; `.max` is the same as `:max`."""
    name, colon, how = quantity.partition(":")
    base, _, last = name.rpartition(".")
    return (base, last) if not colon and base and last in OVER else (name, how)


def column_of(run: Run, name: str) -> tuple[str, str, str] | None:
    """Table, number of the row in brackets, and column of a name such as fragments[1].mass; None if there is none."""
    for table in run.tables:
        found = re.fullmatch(rf"{re.escape(table)}(?:\[(\d+)\])?\.(.+)", name)
        if found and found.group(2) in run.tables[table]:
            return table, found.group(1) or "", found.group(2)
    history = run.history_name
    return (history, "", name) if history and name in run.tables[history] else None


def check(run: Run, quantity: str, body: str | None = None) -> None:
    """Raise an error for a quantity that a run of this deck does not have; that run may have no step."""
    name, how = split(quantity)
    place = column_of(run, name)
    if body and (snap := last_snapshot(run)) is not None and body not in snap.bodies:
        raise ScreeError(f"no body '{body}'{nearest(body, snap.bodies)}", EXIT_USAGE)
    if name in EXTENTS and not how:
        if last_snapshot(run) is None:
            raise ScreeError(f"{name} needs snapshots, and the deck writes none: add &output name='p' "
                             "kind='particles'", EXIT_USAGE)
    elif place is None and (name not in numbers(run) or how):
        raise ScreeError(f"there is no quantity '{quantity}'{choices(run, name)}", EXIT_USAGE)
    elif place is not None and (how or name not in numbers(run)):
        check_rows(run, quantity, place, how)


def check_rows(run: Run, quantity: str, place: tuple[str, str, str], how: str) -> None:
    """Raise an error for a column with a wrong number of the row, or a wrong word after the colon."""
    table, row, _ = place
    numbered = next((name for name in NUMBERED if name in run.tables[table]), "")
    if row and not numbered:
        raise ScreeError(f"{quantity}: the table {table} has one row for each time; omit [{row}]", EXIT_USAGE)
    if numbered and not row and how not in OVER:
        raise ScreeError(f"{quantity}: the table {table} has several rows for each time; choose one by its number in "
                         f"the column {numbered}, as in {table}[1].{place[2]}, or write :max, :min or :mean for a "
                         "number of all rows of the last time", EXIT_USAGE)
    if how.startswith("at="):
        end = float(run.deck["time"]["t_end"])
        if not 0.0 <= time_of(how) <= end * (1.0 + 1.0e-9):
            raise ScreeError(f"{quantity}: write a time from 0 to t_end = {end:g} s, such as at=5us", EXIT_USAGE)
    elif how not in ("", "last", *OVER):
        raise ScreeError(f"'{quantity}': after the colon write last, max, min, mean or at=TIME such as at=5us",
                         EXIT_USAGE)


def time_of(how: str) -> float:
    """The time of at=TIME [s], NaN if it is none."""
    try:
        return number_with_unit(how[3:])
    except argparse.ArgumentTypeError:
        return math.nan


def check_quantities(deck: str | os.PathLike[str], quantities: Iterable[str], settings: Mapping[str, Any],
                     base: str | os.PathLike[str], body: str | None = None, **options: Any) -> None:
    """Raise an error for quantities that runs of a deck would not have, before the first of them: a run without a step
    shows the tables, the columns and the numbers. Its files are for a moment in the folder `base` of the study."""
    chosen = list(quantities)
    if not chosen:
        return
    try:
        os.makedirs(base, exist_ok=True)
    except OSError as error:
        raise FileProblem(f"cannot make {os.fspath(base)}: {error.strerror}") from error
    with tempfile.TemporaryDirectory(prefix="names_", dir=base) as folder:
        run = run_deck(deck, {**settings, "time.max_steps": 0, "checkpoint.at_end": False}, outdir=folder,
                       progress=False, **{key: value for key, value in options.items() if key != "_children"})
        for quantity in chosen:
            check(run, quantity, body)


def value_of(run: Run, quantity: str, body: str | None = None, percentile: float = 100.0) -> float:
    """The number of a quantity in SI. The error for an unknown quantity lists the valid ones."""
    check(run, quantity, body)
    name, how = split(quantity)
    if name in EXTENTS:
        return extent(run, name, body, percentile)
    if name in numbers(run) and not how:
        value = float(numbers(run)[name])
    else:
        place = column_of(run, name)
        assert place is not None
        value = pick(run.tables[place[0]], quantity, place, how)
    if not math.isfinite(value):
        raise ScreeError(f"{quantity} of {run.case} is not a finite number")
    return value


def choices(run: Run, name: str) -> str:
    """The closest quantity, and all valid ones, as sentences."""
    tables = {table: [column for column in run.tables[table].columns if column not in ("time", "step")]
              for table in run.tables}
    history = tables.pop(run.history_name, []) if run.history_name else []
    columns = [f"{table}.{column}" for table, names in tables.items() for column in names]
    particles = any(key.startswith("particles") for key in run.summary.get("files", {}))
    extents = list(EXTENTS) if particles else []
    near = next((f"; did you mean '{column}'?" for column in columns if column.partition(".")[2] == name),
                nearest(name, [*history, *columns, *numbers(run), *extents]).partition(" (there are")[0])
    return (f"{near or '.'} There are columns of the history: "
            + (", ".join(history) or "none, as the deck asks for no history (&output kind='history')")
            + "".join(f"; of {table}: {', '.join(f'{table}.{column}' for column in names)}"
                      for table, names in tables.items())
            + "; numbers of the summary: " + ", ".join(key for key in numbers(run) if key not in history)
            + "; extents: "
            + (", ".join(extents) or "none, as the deck writes no particles (&output kind='particles')"))


def unit_of(run: Run, quantity: str) -> str:
    """Unit of a quantity, empty if it is not known."""
    name, how = split(quantity)
    if name in EXTENTS:
        return "m"
    place = column_of(run, name)
    if place is None or (name in numbers(run) and not how):
        return summary_unit(name)
    return str(run.tables[place[0]].attrs["units"].get(place[2], ""))


def extent(run: Run, name: str, body: str | None, percentile: float) -> float:
    """An extent of the particles of the last snapshot [m]."""
    import numpy as np
    snap = last_snapshot(run)
    assert snap is not None
    chosen = snap.body(body) if body else np.ones(len(snap), dtype=bool)
    if not chosen.any():
        raise ScreeError(f"{snap.file} holds no particles of {body or 'any body'}")
    weight = snap["mass"][chosen] if percentile < 100.0 else None
    points = snap.points[chosen]
    kind, _, axis = name.partition("_")
    if name == "length":
        kind, axis = "extent", "x" if snap.dimension == "1d" else "z"
    elif name == "width":
        if snap.dimension == "axisymmetric":
            return 2.0 * quantile(points[:, 0], weight, percentile)
        kind, axis = "extent", "x"
    elif name == "radius":
        across = points[:, 1] if snap.dimension == "3d" else 0.0 * points[:, 0]
        return quantile(np.hypot(points[:, 0], across), weight, percentile)
    places = points[:, AXES[axis]]
    high = quantile(places, weight, percentile)
    low = -quantile(-places, weight, percentile)
    return {"front": high, "back": low, "extent": high - low}[kind]


def quantile(places: NDArray[np.float64], weight: NDArray[Any] | None, percentile: float) -> float:
    """The position below which a percentage of the mass is; half of a particle is on each side of its centre."""
    import numpy as np
    if weight is None:
        return float(places.max())
    order = np.argsort(places, kind="stable")
    mass = np.cumsum(weight[order]) - 0.5 * weight[order]
    return float(np.interp(0.01 * percentile * weight.sum(), mass, places[order]))


def pick(table: pandas.DataFrame, quantity: str, place: tuple[str, str, str], how: str) -> float:
    """One number of a column: its last, greatest, least or mean value, or that at a time. Without a number of the row,
    values of a table with several rows for each time are those of the last time."""
    import numpy as np
    name, row, column = place
    numbered = next((key for key in NUMBERED if key in table), "")
    if numbered and not row:
        table = table[table["time"] == table["time"].max()]
    elif numbered:
        table = table[table[numbered] == int(row)]
    if table.empty:
        raise ScreeError(f"{quantity}: the table {name} has no {numbered or 'row'} {row}".rstrip(), EXIT_USAGE)
    values = table[column]
    if how in OVER:
        return float(values.agg(how))
    if not how.startswith("at="):
        return float(values.iloc[-1])
    when, begin, end = time_of(how), float(table["time"].iloc[0]), float(table["time"].iloc[-1])
    if not begin <= when <= end:
        raise ScreeError(f"{quantity}: the table goes from {begin:g} to {end:g} s", EXIT_USAGE)
    return float(np.interp(when, table["time"].to_numpy(), values.to_numpy()))
