# SPDX-License-Identifier: BSD-3-Clause
"""One number from the results of a run: a column, a number of the summary, an extent.

    value_of(run, "kinetic:max")                  # a column of the history
    value_of(run, "ledger.energy_error")          # a place in the summary
    value_of(run, "front_z", body="sphere", percentile=99.0)

Extents are those of the centres of particles, weighted by mass if a percentile excludes some of it. The outermost
centres are half a particle inside of the surface, which is an error of first order in the cell size; with a percentile
below 100 there is no such error.
"""
from __future__ import annotations

import argparse
import math
from typing import TYPE_CHECKING, Any

from .drawing.quantity import quantity as number_with_unit
from .errors import EXIT_USAGE, ScreeError
from .results import SERIES, Run
from .snapshot import AXES, Snapshot
from .units import summary_unit

if TYPE_CHECKING:
    import numpy as np
    import pandas
    from numpy.typing import NDArray

EXTENTS = ("length", "width", "radius", *(f"{side}_{axis}" for side in ("front", "back", "extent") for axis in AXES))


def history_of(run: Run) -> pandas.DataFrame | None:
    """The first history, or None if the deck requests none."""
    return run.history if run.history_name else None


def last_snapshot(run: Run) -> Snapshot | None:
    """The last snapshot of the first series, or None."""
    files = run.summary.get("files", {})
    name = next((str(files[key]) for key in sorted(files) if key.startswith("particles")), None)
    return run.series[name[len(run.case) + 1:-len(SERIES)]][-1] if name else None


def numbers(run: Run) -> dict[str, float]:
    """Numbers of the summary by their key paths, without clocks and counts."""
    return {f"{group}.{key}": number for group in ("extremes", "exact", "ledger")
            for key, number in (run.summary.get(group) or {}).items() if isinstance(number, (int, float))}


def value_of(run: Run, quantity: str, body: str | None = None, percentile: float = 100.0) -> float:
    """The number of a quantity in SI. The error for an unknown quantity lists the valid ones."""
    name, _, how = quantity.partition(":")
    if name in EXTENTS:
        return extent(run, name, body, percentile)
    table = history_of(run)
    if name in numbers(run):
        value = numbers(run)[name]
    elif table is not None and name in table:
        value = pick(table, name, how)
    else:
        raise ScreeError(f"there is no quantity '{quantity}'. {choices(run)}", EXIT_USAGE)
    if not math.isfinite(value):
        raise ScreeError(f"{quantity} of {run.case} is not a finite number")
    return value


def choices(run: Run) -> str:
    """The valid quantities, as a sentence."""
    table = history_of(run)
    columns = ", ".join(name for name in table.columns if name not in ("time", "step")) if table is not None \
        else "none, as the deck asks for no history (&output kind='history')"
    snaps = ", ".join(EXTENTS) if any(key.startswith("particles") for key in run.summary.get("files", {})) else \
        "none, as the deck writes no particles (&output kind='particles')"
    return (f"There are columns of the history: {columns}; numbers of the summary: {', '.join(numbers(run))}; "
            f"extents: {snaps}")


def unit_of(run: Run, quantity: str) -> str:
    """Unit of a quantity, empty if it is not known."""
    name = quantity.partition(":")[0]
    if name in EXTENTS:
        return "m"
    if name in numbers(run):
        return summary_unit(name)
    table = history_of(run)
    return str(table.attrs["units"].get(name, "")) if table is not None else ""


def extent(run: Run, name: str, body: str | None, percentile: float) -> float:
    """An extent of the particles of the last snapshot [m]."""
    import numpy as np
    snap = last_snapshot(run)
    if snap is None:
        raise ScreeError(f"{name} needs snapshots, and the deck writes none: add &output name='p' kind='particles'",
                         EXIT_USAGE)
    if body and body not in snap.bodies:
        raise ScreeError(f"there is no body '{body}'; there are: {', '.join(snap.bodies) or 'none'}", EXIT_USAGE)
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


def pick(table: pandas.DataFrame, name: str, how: str) -> float:
    """One number of a column: its last, greatest or least value, or that at a time."""
    values = table[name]
    if how in ("", "last"):
        return float(values.iloc[-1])
    if how in ("max", "min"):
        return float(values.agg(how))
    if how.startswith("at="):
        import numpy as np
        try:
            when = number_with_unit(how[3:])
        except argparse.ArgumentTypeError:
            when = math.nan
        begin, end = float(table["time"].iloc[0]), float(table["time"].iloc[-1])
        if not begin <= when <= end:
            raise ScreeError(f"{name}:{how}: the history goes from {begin:g} to {end:g} s", EXIT_USAGE)
        return float(np.interp(when, table["time"].to_numpy(), values.to_numpy()))
    raise ScreeError(f"'{name}:{how}': after the colon write last, max, min or at=TIME such as at=5us", EXIT_USAGE)
