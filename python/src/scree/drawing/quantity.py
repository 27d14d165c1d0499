# SPDX-License-Identifier: BSD-3-Clause
"""Numbers with units on the command line: 5us, 10mm, 1.2GPa; without a unit they are in SI."""
from __future__ import annotations

import argparse
import math
import re
from collections.abc import Callable

PREFIXES = {"n": 1.0e-9, "u": 1.0e-6, "µ": 1.0e-6, "m": 1.0e-3, "c": 1.0e-2, "k": 1.0e3,
            "M": 1.0e6, "G": 1.0e9}
UNITS = ("s", "m", "Pa", "m/s", "K", "J", "g")


def factor(unit: str) -> float | None:
    """SI value of a unit such as mm or km/s, or None."""
    if unit == "":
        return 1.0
    for name in UNITS:
        scale = 1.0e-3 if name == "g" else 1.0           # the unit of mass is the kilogram
        if unit == name:
            return scale
        if unit[1:] == name and unit[0] in PREFIXES:
            return scale * PREFIXES[unit[0]]
    return None


def in_unit(unit: str) -> Callable[[str], float]:
    """A reader like `quantity` for which numbers without a unit are in a given unit such as us."""
    scale = factor(unit) or 1.0

    def read(text: str) -> float:
        try:
            return float(text) * scale
        except ValueError:
            return quantity(text)
    return read


def quantity(text: str) -> float:
    """The SI value of a number with or without a unit, for argparse."""
    found = re.fullmatch(r"([-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?)\s*(\S*)", text.strip())
    scale = factor(found.group(2)) if found else None
    if found is None or scale is None or not math.isfinite(float(found.group(1))):
        raise argparse.ArgumentTypeError(
            f"'{text}' is not a number with a unit, such as 5us, 10mm, 1.2GPa (or in SI: 5e-6)")
    return scale * float(found.group(1))
