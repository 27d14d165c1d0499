# SPDX-License-Identifier: BSD-3-Clause
"""One number out of what a run has written: a column, a number of the summary, an extent.

    written = scree_post.written.Written("out/case", "case")
    written.value("kinetic:max")                  # a column of the history
    written.value("ledger.energy_error")          # a place in the summary
    written.value("front_z", body="sphere", percentile=99.0)

Extents are those of the centres of particles, weighted by mass if a percentile leaves some of it
out. The outermost centres lie half a particle inside of the surface, which is an error of first
order in the size of cells; a percentile below 100 has it not.
"""
import argparse
import json
import math
from pathlib import Path

import scree_post

from .errors import PostError
from .quantity import quantity as number_with_unit
from scree.units import summary_unit

AXES = {"x": 0, "y": 1, "z": 2}
EXTENTS = ("length", "width", "radius", *(f"{side}_{axis}" for side in ("front", "back", "extent")
                                          for axis in AXES))


class Written:
    """The files of a case."""

    def __init__(self, folder, case):
        self.folder, self.case = Path(folder), case
        self._summary = None

    @property
    def summary(self):
        """What CASE.summary.json holds."""
        if self._summary is None:
            path = self.folder / f"{self.case}.summary.json"
            try:
                self._summary = json.loads(path.read_text(encoding="utf-8"))
            except (OSError, ValueError) as error:
                raise PostError(f"cannot read {path}: {error}") from error
        return self._summary

    @property
    def history(self):
        """The first history, or None if the deck asks for none."""
        files = self.summary.get("files", {})
        name = next((files[key] for key in sorted(files) if key.startswith("history")), None)
        return scree_post.history(str(self.folder / name)) if name else None

    @property
    def series(self):
        """Times [s] and files of the first series of particles, or None."""
        files = self.summary.get("files", {})
        name = next((files[key] for key in sorted(files) if key.startswith("particles")), None)
        return scree_post.series(str(self.folder / name)) if name else None

    def last_snapshot(self):
        """The last snapshot of the first series, or None."""
        series = self.series
        return scree_post.snapshot(series[-1][1]) if series else None

    def value(self, quantity, body=None, percentile=100.0):
        """The number of a quantity. An error lists what there is."""
        name, _, how = quantity.partition(":")
        if name in EXTENTS:
            return self.extent(name, body, percentile)
        if "." in name or name in self.numbers():
            if name in self.numbers():
                return self.finite(quantity, self.numbers()[name])
        table = self.history
        if table is not None and name in table:
            return self.finite(quantity, pick(table, name, how))
        raise PostError(f"there is no quantity '{quantity}'. {self.choices()}",
                        scree_post.EXIT_USAGE)

    def finite(self, quantity, value):
        """The number itself if it is one."""
        if not math.isfinite(value):
            raise PostError(f"{quantity} of {self.case} is not a finite number")
        return value

    def choices(self):
        """What may be asked for, as a sentence."""
        table = self.history
        columns = ", ".join(name for name in table.order if name not in ("time", "step")) if table \
            else "none, as the deck asks for no history (&output kind='history')"
        snaps = ", ".join(EXTENTS) if any(key.startswith("particles") for key in
                                          self.summary.get("files", {})) else \
            "none, as the deck writes no particles (&output kind='particles')"
        return (f"There are columns of the history: {columns}; numbers of the summary: "
                f"{', '.join(self.numbers())}; extents: {snaps}")

    def numbers(self):
        """Numbers of the summary by their places, without clocks and counts."""
        found = {}
        for name, value in self.summary.items():
            if name in ("extremes", "exact"):
                found.update({f"{name}.{key}": number for key, number in value.items()
                              if isinstance(number, (int, float))})
            elif name == "ledger":
                found.update({f"ledger.{key}": number for key, number in value.items()
                              if isinstance(number, (int, float))})
        return found

    def unit(self, quantity):
        """Unit of a quantity, empty if it is not written down."""
        name = quantity.partition(":")[0]
        if name in EXTENTS:
            return "m"
        if name in self.numbers():
            return summary_unit(name)
        table = self.history
        return table.units.get(name, "") if table is not None else ""

    def extent(self, name, body, percentile):
        """An extent of the particles of the last snapshot [m]."""
        (np,) = scree_post.modules("numpy")
        snap = self.last_snapshot()
        if snap is None:
            raise PostError(f"{name} needs snapshots, and the deck writes none: add &output "
                            "name='p' kind='particles'", scree_post.EXIT_USAGE)
        chosen = np.ones(len(snap.points), dtype=bool)
        if body:
            names = [entry.get("name") for entry in snap.bodies]
            if body not in names:
                raise PostError(f"there is no body '{body}'; there are: "
                                f"{', '.join(map(str, names)) or 'none'}", scree_post.EXIT_USAGE)
            if len(names) > 1:
                (number,) = snap.need("body")
                chosen = number == names.index(body) + snap.first_body
        if not chosen.any():
            raise PostError(f"{snap.file} holds no particles of {body or 'any body'}")
        weight = None
        if percentile < 100.0:
            weight = snap.need("mass")[0][chosen]
        points = snap.points[chosen]
        kind, _, axis = name.partition("_")
        if name == "length":
            kind, axis = "extent", "x" if snap.dimension == "1d" else "z"
        elif name == "width":
            if snap.dimension == "axisymmetric":
                return 2.0 * quantile(points[:, 0], weight, percentile)
            kind, axis = "extent", "x"
        elif name == "radius":
            return quantile(np.hypot(points[:, 0], points[:, 1] if snap.dimension == "3d"
                                     else 0.0 * points[:, 0]), weight, percentile)
        places = points[:, AXES[axis]]
        high = quantile(places, weight, percentile)
        low = -quantile(-places, weight, percentile)
        return {"front": high, "back": low, "extent": high - low}[kind]


def quantile(places, weight, percentile):
    """The place below which a percentage of the mass lies; half of a particle lies on each side of
    its centre."""
    (np,) = scree_post.modules("numpy")
    if weight is None:
        return float(places.max())
    order = np.argsort(places, kind="stable")
    mass = np.cumsum(weight[order]) - 0.5 * weight[order]
    return float(np.interp(0.01 * percentile * weight.sum(), mass, places[order]))


def pick(table, name, how):
    """One number of a column: its last, greatest, least, or that at a time."""
    values = table[name]
    if how in ("", "last"):
        return float(values[-1])
    if how == "max":
        return float(values.max())
    if how == "min":
        return float(values.min())
    if how.startswith("at="):
        try:
            when = number_with_unit(how[3:])
        except argparse.ArgumentTypeError:
            when = math.nan
        begin, end = float(table["time"][0]), float(table["time"][-1])
        if not begin <= when <= end:
            raise PostError(f"{name}:{how}: the history goes from {begin:g} to {end:g} s",
                            scree_post.EXIT_USAGE)
        (np,) = scree_post.modules("numpy")
        return float(np.interp(when, table["time"], values))
    raise PostError(f"'{name}:{how}': after the colon stands last, max, min or at=TIME such as at=5us",
                    scree_post.EXIT_USAGE)
