# SPDX-License-Identifier: BSD-3-Clause
"""Units of the numbers in files: this module converts every number that is read to SI.

With `output_units` of a deck, snapshots, grids, slices and tables are in the units of another system. Data sets have
the attributes `unitSI` (the value of their unit in SI) and `unitNameSI`; tables have the unit in the heading of a
column. Systems differ from SI by powers of ten only, so a number is multiplied or divided by an exact power of ten and
is rounded once.
"""
from __future__ import annotations

import json
import math
import re
from typing import Any, Callable, TypeVar

from .errors import FileProblem, ScreeError, decoded

Powers = tuple[float, ...]
Numbers = TypeVar("Numbers")                             # a number or an array of numpy

# Name: decimal exponent and powers of length, time, mass, temperature.
SYMBOLS: dict[str, tuple[int, Powers]] = {"m": (0, (1, 0, 0, 0)), "s": (0, (0, 1, 0, 0)), "kg": (0, (0, 0, 1, 0)),
           "K": (0, (0, 0, 0, 1)), "N": (0, (1, -2, 1, 0)), "J": (0, (2, -2, 1, 0)),
           "W": (0, (2, -3, 1, 0)), "Pa": (0, (-1, -2, 1, 0)), "deg": (0, (0, 0, 0, 0)),
           "cm": (-2, (1, 0, 0, 0)), "mm": (-3, (1, 0, 0, 0)), "ms": (-3, (0, 1, 0, 0)),
           "us": (-6, (0, 1, 0, 0)), "g": (-3, (0, 0, 1, 0)), "mg": (-6, (0, 0, 1, 0))}
SI_SYMBOLS = ("m", "s", "kg", "K", "N", "J", "W", "Pa", "deg")
# Preferred names in SI, by powers of length, time, mass, temperature.
NAMES = ("m", "m2", "m3", "s", "kg", "K", "m/s", "m/s2", "1/s", "kg/m3", "Pa", "N", "J", "J/kg", "W",
         "kg m/s", "kg m2/s", "J/(kg K)", "W/(m K)", "J/m2", "N/m")
# Columns whose name of the SI unit does not follow from its powers alone.
BY_COLUMN = ((re.compile(r"torque_impulse_[xyz]"), "N m s"), (re.compile(r"(\w+_)?impulse_[xyz]"), "N s"))
# Numbers of CASE.summary.json, which is always in SI.
SUMMARY = ((r"(time|dt|wall_s|processor_s)", "s"),
           (r"(torque_impulse)_[xyz]", "N m s"), (r"impulse_[xyz]", "N s"),
           (r"(lost_|removed_|rigid_)?angular_momentum_[xyz]", "kg m2/s"),
           (r"(lost_|removed_|rigid_)?momentum_[xyz]", "kg m/s"),
           (r"(lost_|removed_|failed_|retired_)?mass", "kg"),
           (r"(kinetic|internal|viscous|plastic|dissipated|damped|total|potential|external_work"
            r"|lost_energy|removed_energy|rigid_kinetic)", "J"),
           (r"(greatest_)?displacement(_error)?", "m"), (r"velocity_error", "m/s"),
           (r"stress_error|pressure_(min|max)", "Pa"), (r"density_(min|max)", "kg/m3"),
           (r"speed_max", "m/s"))


def parse(label: str) -> tuple[int, Powers] | None:
    """Decimal exponent to SI and powers of a unit such as mg/(mm us2), or None if it is unknown."""
    exponent, powers, side = 0.0, [0.0] * 4, 1
    for slash, symbol, power in re.findall(r"(/)|([^\W\d_]+)(\d+\.?\d*)?", label):
        if slash:
            side = -1
            continue
        if symbol not in SYMBOLS:
            return None
        decimal, parts = SYMBOLS[symbol]
        count = side * (float(power) if power else 1.0)
        exponent += count * decimal
        powers = [old + count * part for old, part in zip(powers, parts)]
    if exponent != round(exponent):
        return None
    return int(exponent), tuple(powers)


def powers_of(name: str) -> Powers | None:
    """Powers of a unit, or None if it is unknown."""
    found = parse(name)
    return found[1] if found else None


def is_si(label: str) -> bool:
    """Whether all symbols of a unit are those of SI."""
    return all(symbol in SI_SYMBOLS for symbol in re.findall(r"[^\W\d_]+", label))


def built(powers: Powers) -> str:
    """A unit of SI from its powers."""
    above: list[str] = []
    below: list[str] = []
    for place in (2, 0, 1, 3):
        power = powers[place]
        if power:
            size = abs(power)
            word = ("m", "s", "kg", "K")[place] + ("" if size == 1 else f"{size:g}")
            (above if power > 0 else below).append(word)
    label = " ".join(above) or "1"
    if len(below) > 1:
        return f"{label}/({' '.join(below)})"
    return f"{label}/{below[0]}" if below else label


def si_unit(label: str, column: str = "") -> tuple[str, int]:
    """SI unit for a unit, and the decimal exponent of the conversion."""
    if is_si(label):
        return label, 0
    found = parse(label)
    if found is None:                                    # a unit of another program: number and unit are not changed
        return label, 0
    exponent, powers = found
    for pattern, name in BY_COLUMN:
        if pattern.fullmatch(column) and powers_of(name) == powers:
            return name, exponent
    for name in NAMES:
        if powers_of(name) == powers:
            return name, exponent
    return built(powers), exponent


def shifted(values: Numbers, exponent: int) -> Numbers:
    """Numbers times a power of ten, rounded once."""
    if exponent == 0:
        return values
    numbers: Any = values
    result: Numbers = numbers * 10.0 ** exponent if exponent > 0 else numbers / 10.0 ** -exponent
    return result


def exponent_of(factor: float) -> int:
    """The decimal exponent of a power of ten in a file."""
    if not (factor > 0.0 and math.isfinite(factor)):
        raise FileProblem(f"unitSI = {factor} is not a factor between units")
    exponent = round(math.log10(factor))
    if abs(factor / 10.0 ** exponent - 1.0) > 1.0e-9:
        raise FileProblem(f"unitSI = {factor} is not a power of ten")
    return exponent


def plain(value: Any) -> str:
    """A string from an attribute."""
    if hasattr(value, "tolist"):
        value = value.tolist()
    return decoded(value).strip("\0 ") if isinstance(value, bytes) else str(value)


def data_exponent(data: Any) -> int:
    """Decimal exponent of the conversion to SI of a data set, or of a group with `unitSI`."""
    return exponent_of(float(data.attrs.get("unitSI", 1.0)))


def data_unit(data: Any) -> str:
    """Unit of SI of a data set."""
    return plain(data.attrs.get("unitNameSI", data.attrs.get("units", "1")))


def data_si(data: Any) -> Any:
    """Numbers of a data set in SI."""
    return shifted(data[...], data_exponent(data))


def raw_time(handle: Any) -> float | None:
    """The time in a file of particles or of the grid, in the unit of the file, or None."""
    group = handle["VTKHDF"]
    if "FieldData/TimeValue" in group:
        values = group["FieldData/TimeValue"][...].ravel()
        return float(values[0]) if len(values) else None
    return float(group.attrs["Time"]) if "Time" in group.attrs else None


def raw_time_unit(handle: Any) -> str:
    """The unit of the time in a file of particles."""
    data = handle["VTKHDF"].get("FieldData/TimeValue")
    return "s" if data is None else plain(data.attrs.get("units", "s"))


def time_exponent(handle: Any) -> int | None:
    """Decimal exponent of the times of a file, or None where it cannot be determined.

    A file of the grid has its time in SI in /provenance and in its own unit in /VTKHDF: for time zero both are the
    same, and the exponent is not known.
    """
    group = handle["VTKHDF"]
    if "FieldData/TimeValue" in group:
        return data_exponent(group["FieldData/TimeValue"])
    own = raw_time(handle)
    known = handle["provenance"].attrs.get("time") if "provenance" in handle else None
    if own is None or known is None:
        return 0
    return exponent_of(float(known) / own) if own != 0.0 and float(known) != 0.0 else None


def time_si(handle: Any) -> float | None:
    """Time of a file [s], or None."""
    own = raw_time(handle)
    return None if own is None else float(shifted(own, time_exponent(handle) or 0))


def series_exponent(files: list[str], opened: Callable[[str], Any]) -> int:
    """Decimal exponent of the times that a series lists: that of its files, of which the last ones are tried first.

    opened  opens a file, raises ScreeError or OSError if it cannot
    """
    for file in reversed(files):
        try:
            with opened(file) as handle:
                exponent = time_exponent(handle)
        except (OSError, KeyError, ScreeError):
            continue
        if exponent is not None:
            return exponent
    return 0


def summary_unit(name: str) -> str:
    """Unit of a number of CASE.summary.json, empty if it has none."""
    name = name.rpartition(".")[2]
    for pattern, unit in SUMMARY:
        if re.fullmatch(pattern, name):
            return unit
    return ""


def times_in(entries: str) -> list[tuple[float, str]]:
    """Pairs (time as it is written, name) of the entries of a .series file."""
    found = json.loads(entries)["files"]
    return [(float(entry["time"]), entry["name"]) for entry in found]
