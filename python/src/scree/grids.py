# SPDX-License-Identifier: BSD-3-Clause
"""The grid of a deck, with larger or smaller cells."""
from __future__ import annotations

import math
import os
import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from .errors import DeckError, readable
from .units import deck_length

PREFIXES = {"": 0, "p": -12, "n": -9, "u": -6, "m": -3, "c": -2, "k": 3, "M": 6, "G": 9, "T": 12}
EXPONENTS = {"m": 0, "cm": -2, "mm": -3}                 # of the units of length of the systems
# A text in quotes, a comment, or a number with the unit after it.
WITH_UNIT = re.compile(r"'[^'\n]*'|\"[^\"\n]*\"|![^\n]*|"
                       r"(?P<number>(?<![\w.])[-+]?(?:\d+\.?\d*|\.\d+)(?:[eEdD][-+]?\d+)?)"
                       r"[ \t]*(?P<unit>[A-Za-z][\w/*.]*(?:\([^)\n]*\))?)(?!\w)(?!\s*[=(\[%])")
AXES: dict[str, tuple[int, ...]] = {"3d": (0, 1, 2), "plane_strain": (0, 2), "axisymmetric": (0, 2), "1d": (0,)}


@dataclass(frozen=True)
class Grid:
    """Cells of a deck, whose size can be changed equally in all directions."""

    cells: tuple[int, ...]               # along x, y, z
    key: str                             # dx or cells: the key that the deck gives
    axes: tuple[int, ...]                # directions with more than one cell
    spacing: float                       # edge of a cell, in the unit of the deck
    unit: str = "m"                      # of lengths in the deck

    @property
    def common(self) -> int:
        """Greatest number of equal parts with whole cells into which all directions can be divided."""
        return math.gcd(*(self.cells[axis] for axis in self.axes))

    def parts(self, factor: float) -> int:
        """Number of these parts for cells that are `factor` times as large."""
        return max(1, round(self.common / factor))

    def size(self, parts: int) -> float:
        """Edge of a cell, in the unit of the deck."""
        return self.spacing * self.common / parts

    def setting(self, parts: int) -> dict[str, Any]:
        """Value of `set` of scree.run for these cells."""
        if self.key == "dx":
            return {"grid.dx": self.size(parts)}
        return {"grid.cells": tuple(count * parts // self.common if axis in self.axes else count
                                    for axis, count in enumerate(self.cells))}


def without_units(text: str) -> str:
    """A deck with its lengths in the unit of its system, and without units after other numbers.

    f90nml reads all of a deck except these units.
    """
    system = re.search(r"^[^!]*\bsystem\s*=\s*'([\w-]+)'", text, re.M)
    own = EXPONENTS[deck_length(system.group(1) if system else "si")]

    def plain(found: re.Match[str]) -> str:
        if found.group("number") is None:                # a text or a comment
            return found.group()
        prefix, unit = found.group("unit")[:-1], found.group("unit")[-1:]
        if unit != "m" or prefix not in PREFIXES:
            return found.group("number")
        return repr(float(found.group("number").lower().replace("d", "e")) * 10.0 ** (PREFIXES[prefix] - own))

    return WITH_UNIT.sub(plain, text)


def groups(deck: str) -> list[dict[str, Any]]:
    """The groups of a deck and of the files that it includes."""
    import f90nml
    try:
        read = f90nml.reads(without_units(Path(readable(deck)).read_text(encoding="utf-8")))
    except (ValueError, UnicodeDecodeError, StopIteration, AssertionError) as error:
        raise DeckError(f"{deck} is not a deck: {error}") from error
    found = [{name: value for name, value in read.items() if isinstance(value, dict)}]
    more = read.get("include", [])
    for entry in more if isinstance(more, list) else [more]:
        found += groups(os.path.join(os.path.dirname(deck), entry["file"]))
    return found


def value_of(text: Any) -> Any:
    """A value of --set as a number, a list of numbers, or text without quotes."""
    if not isinstance(text, str):
        return text
    try:
        found = [float(word) for word in text.split(",")]
    except ValueError:
        return text.strip("'\"")
    return found if len(found) > 1 else found[0]


def read_grid(deck: str, settings: Mapping[str, Any]) -> Grid:
    """The grid of a deck, including changes by settings."""
    found: dict[str, Any] = {}
    for read in groups(deck):
        for group in ("run", "units", "grid"):
            found.update({f"{group}.{key}": value for key, value in read.get(group, {}).items()})
    found.update({name: value_of(value) for name, value in settings.items()})
    for key in ("lo", "hi"):
        if len(found.get(f"grid.{key}", ())) != 3:
            raise DeckError(f"{deck}: &grid {key} must be three numbers")
    key = "dx" if "grid.dx" in found else "cells"
    dimension = found.get("run.dimension", "3d")
    if dimension not in AXES or f"grid.{key}" not in found:
        raise DeckError(f"{deck}: &grid needs dx or cells, and &run a known dimension; try 'scree --check {deck}'")
    axes = AXES[dimension]
    spans = [high - low for low, high in zip(found["grid.lo"], found["grid.hi"])]
    if key == "cells":
        cells = [int(count) for count in found["grid.cells"]]
    else:
        cells = [max(1, round(span / found["grid.dx"])) if axis in axes else 1 for axis, span in enumerate(spans)]
    return Grid(tuple(cells), key, axes, spans[axes[0]] / cells[axes[0]], deck_length(found.get("units.system", "si")))


def choose_parts(grid: Grid, factors: Iterable[float]) -> Sequence[int]:
    """Numbers of parts for cells of given sizes relative to those of the deck, coarse first."""
    factors = list(factors)
    chosen = {grid.parts(factor) for factor in factors}
    if len(chosen) < 3 or len(chosen) < len({*factors}):
        near = {grid.parts(factor) for factor in (3.0, 2.5, 2.0, 1.7, 1.4, 1.2, 1.0, 0.7, 0.5, 0.3)}
        fitting = ", ".join(f"{grid.common / parts:.4g}" for parts in sorted(near))
        raise DeckError(
            f"the factors {','.join(f'{factor:g}' for factor in factors)} do not give as many different grids, and at "
            f"least three: {' x '.join(map(str, grid.cells))} cells have {grid.common} as greatest common divisor, so "
            f"cells may be larger by {fitting}; name three of these, or change &grid hi")
    return sorted(chosen)
