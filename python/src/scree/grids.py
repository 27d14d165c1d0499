# SPDX-License-Identifier: BSD-3-Clause
"""The grid of a deck, with larger or smaller cells."""
from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Any

from .echo import groups
from .errors import DeckError

AXES: dict[str, tuple[int, ...]] = {"3d": (0, 1, 2), "plane_strain": (0, 2), "axisymmetric": (0, 2), "1d": (0,)}


@dataclass(frozen=True)
class Grid:
    """Cells of a deck, whose size can be changed equally in all directions."""

    cells: tuple[int, ...]               # along x, y, z
    key: str                             # dx or cells: the key that the deck gives
    axes: tuple[int, ...]                # directions with more than one cell
    spacing: float                       # edge of a cell [m]

    @property
    def common(self) -> int:
        """Greatest number of equal parts with whole cells into which all directions can be divided."""
        return math.gcd(*(self.cells[axis] for axis in self.axes))

    def parts(self, factor: float) -> int:
        """Number of these parts for cells that are `factor` times as large."""
        return max(1, round(self.common / factor))

    def size(self, parts: int) -> float:
        """Edge of a cell [m]."""
        return self.spacing * self.common / parts

    def setting(self, parts: int) -> dict[str, Any]:
        """Value of `set` of scree.run for these cells; with its unit, since the deck may be in another system."""
        if self.key == "dx":
            return {"grid.dx": f"{self.size(parts)!r} m"}
        return {"grid.cells": tuple(count * parts // self.common if axis in self.axes else count
                                    for axis, count in enumerate(self.cells))}


def grid_of(echo: str) -> Grid:
    """The grid of a deck from its echo."""
    (run,), (grid,) = groups(echo, "run"), groups(echo, "grid")
    axes = AXES[run["dimension"]]
    spans = [high - low for low, high in zip(grid["lo"], grid["hi"])]
    key = "dx" if "dx" in grid else "cells"
    cells = [int(count) for count in grid["cells"]] if key == "cells" else \
        [max(1, round(span / grid["dx"])) if axis in axes else 1 for axis, span in enumerate(spans)]
    return Grid(tuple(cells), key, axes, grid["dx"] if key == "dx" else spans[axes[0]] / cells[axes[0]])


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
