# SPDX-License-Identifier: BSD-3-Clause
"""The box of a run: its corners, cells and boundaries, from the echo of the deck in a snapshot."""
from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np

from ..echo import groups
from ..errors import FileProblem

if TYPE_CHECKING:
    from ..arrays import Array
    from ..files import Snapshot

@dataclass
class Box:
    """Corners and boundaries; None where the file lacks the information."""

    low: Array | None = None                                   # lower corner (3) [m]
    high: Array | None = None                                  # upper corner (3) [m]
    cell: float | None = None                                   # size of a cell [m]
    periodic: set[int] = field(default_factory=set)      # axes, such as {0}

    def side(self, axis: int) -> tuple[float, float]:
        """Both ends along an axis [m]."""
        if self.low is None or self.high is None:
            raise FileProblem("the file does not contain the box of the run")
        return float(self.low[axis]), float(self.high[axis])


@dataclass
class Edges:
    """Corners and cells of a box for which both are known."""

    low: Array                                           # lower corner (3) [m]
    high: Array                                          # upper corner (3) [m]
    cell: float                                          # size of a cell [m]


def box_of(snap: Snapshot) -> Box:
    """The box of a snapshot. Attributes grid_lo and grid_hi of /provenance have priority over the echo."""
    box = Box()
    for grid in groups(snap.echo, "grid"):
        box.low, box.high = (np.array(grid[key], float) if key in grid else None for key in ("lo", "hi"))
        if "dx" in grid:
            box.cell = float(grid["dx"])
        elif "cells" in grid and box.low is not None and box.high is not None:
            box.cell = float((box.high[0] - box.low[0]) / grid["cells"][0])
    for boundary in groups(snap.echo, "boundary"):
        face = str(boundary.get("face", ""))
        if boundary.get("type") == "periodic":
            box.periodic |= {0, 1, 2} if face == "all" else {"xyz".index(face[0])} if face[:1] in {*"xyz"} else set()
    for name, key in (("low", "grid_lo"), ("high", "grid_hi")):
        if key in snap.provenance:
            setattr(box, name, np.ravel(snap.provenance[key]).astype(float))
    return box


def mirror_plane(snap: Snapshot, axis: int, face: str) -> float | None:
    """Position of a plane of symmetry [m]; None where the file lacks the information."""
    corner = box_of(snap).low if face == "lo" else box_of(snap).high
    return None if corner is None else float(corner[axis])


def thickness(snap: Snapshot, axis: int = 1) -> float:
    """Thickness of a run along a direction that its scene lacks [m]."""
    if axis == 1 and "thickness" in snap.provenance:
        return float(snap.provenance["thickness"])
    box = box_of(snap)
    if box.low is None or box.high is None or not box.high[axis] > box.low[axis]:
        return 1.0
    return float(box.high[axis] - box.low[axis])
