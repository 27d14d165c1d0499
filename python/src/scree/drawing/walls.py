# SPDX-License-Identifier: BSD-3-Clause
"""Walls of a run: boundaries of the box with their types, and rigid regions, from CASE_walls.hdf."""
from __future__ import annotations

import os
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np

from .. import files
from .. import units as units_of
from ..files import text
from .box import mirror_plane
from .shape import mirror_faces

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from ..arrays import Array
    from ..files import Snapshot
    from .view import Options

# Colour and dash pattern of a boundary by its type; rigid regions have the colour of their type too.
STYLES: dict[str, tuple[str, Any]] = {"outflow": ("#9a9a9a", (0, (1, 2))), "symmetry": ("#0072b2", (0, (6, 2, 1, 2))),
          "slip": ("#111111", "-"), "stick": ("#8c510a", "-"), "friction": ("#b3311b", "-"),
          "periodic": ("#009e73", (0, (5, 2))), "velocity": ("#cc79a7", "-"),
          "absorbing": ("#e69f00", (0, (4, 2)))}
BODY = "#c9c9c9"                                         # interior of rigid regions


@dataclass
class Wall:
    """A boundary of the box, a part of one, or a rigid region."""

    name: str                                            # of the boundary or the region
    kind: str                                            # type of boundary
    face: int                                            # 1 to 6, 0 = rigid region
    begin: float                                         # start of the time interval [s]
    end: float                                           # end of the time interval [s]
    cells: list[Array] = field(default_factory=list)            # corners (n, 3) of each facet [m]
    times: Array | None = None                                 # of the shifts [s]
    shifts: Array | None = None                                # (time, 3) [m]
    path: Array | None = None                                  # (time, 8) Of a body: time, centre, quaternion

    def acts(self, time: float) -> bool:
        """True if it acts at a time."""
        return self.begin <= time < self.end

    def shift(self, time: float) -> Array:
        """Displacement since the start [m]."""
        if self.times is None or self.shifts is None:
            return np.zeros(3)
        times, shifts = self.times, self.shifts
        return np.array([np.interp(time, times, shifts[:, k]) for k in range(3)])

    def placed(self, pieces: Array, time: float) -> Array:
        """Facets at a time, from those at the start: displaced, or displaced and turned as a rigid body."""
        if self.path is None:
            return pieces + self.shift(time)
        table = self.path
        row = int(np.clip(np.searchsorted(table[:, 0], time, side="right") - 1, 0, len(table) - 1))
        following = min(row + 1, len(table) - 1)
        length = table[following, 0] - table[row, 0]
        part = float(np.clip((time - table[row, 0]) / length, 0.0, 1.0)) if length > 0.0 else 0.0
        first, second = table[row, 4:], table[following, 4:]
        if first @ second < 0.0:
            second = -second
        centre = (1.0 - part) * table[row, 1:4] + part * table[following, 1:4]
        turn = (1.0 - part) * first + part * second
        a, b, c, d = turn / np.linalg.norm(turn)
        matrix = ((a * a + b * b - c * c - d * d, 2 * (b * c - a * d), 2 * (b * d + a * c)),
                  (2 * (b * c + a * d), a * a - b * b + c * c - d * d, 2 * (c * d - a * b)),
                  (2 * (b * d - a * c), 2 * (c * d + a * b), a * a - b * b - c * c + d * d))
        x, y, z = (pieces[..., k] - table[0, 1 + k] for k in range(3))
        # written out: equal corners of two facets keep equal bits
        return np.stack([centre[k] + matrix[k][0] * x + matrix[k][1] * y + matrix[k][2] * z for k in range(3)], axis=-1)

    @property
    def label(self) -> str:
        """Description in words."""
        return f"{self.name}: {self.kind}"


def walls_file(snap: Snapshot) -> str:
    """The file of walls of the run of a snapshot, or an empty text."""
    case = snap.provenance.get("case", "")
    path = os.path.join(os.path.dirname(snap.file) or ".", f"{case}_walls.hdf")
    return path if case and os.path.exists(path) else ""


def read_walls(path: str) -> list[Wall]:
    """All walls of a file."""
    with files.open_file(path) as handle:
        group, table = handle["VTKHDF"], handle["walls"]
        points = units_of.data_si(group["Points"]).astype("f8")
        offsets, owner = group["Offsets"][...], group["CellData/wall"][...]
        begin, end = (units_of.data_si(table[name]) for name in ("begin", "end"))
        walls = [Wall(str(text(name)), str(text(kind)), int(face), float(first), float(last))
                 for name, kind, face, first, last in zip(
                     table["name"][...].tolist(), table["type"][...].tolist(),
                     table["face"][...], begin, end)]
        for cell, number in enumerate(owner):
            walls[number - 1].cells.append(points[offsets[cell]:offsets[cell + 1]])
        if "time" in table:
            times = units_of.data_si(table["time"])
            shifts = units_of.data_si(table["shift"]).reshape(len(times), len(walls), 3)
            for number, wall in enumerate(walls):
                if wall.face == 0:
                    wall.times, wall.shifts = times, shifts[:, number]
    return walls


def walls_of(snap: Snapshot) -> list[Wall]:
    """The walls of the run of a snapshot; none if the run wrote no such file."""
    path = walls_file(snap)
    if not path:
        return []
    walls = read_walls(path)
    table = path.removesuffix("_walls.hdf") + "_rigid.csv"
    if os.path.exists(table):
        add_paths(walls, files.history(table, may_be_empty=True))
    return walls


def add_paths(walls: Sequence[Wall], table: files.History) -> None:
    """Give rigid bodies their paths from the table of `kind = 'rigid'`."""
    for wall in walls:
        names = [wall.name + ending for ending in ("_x", "_y", "_z", "_turn_1", "_turn_x", "_turn_y", "_turn_z")]
        if wall.face == 0 and all(name in table for name in names) and len(table["time"]):
            wall.path = np.stack([table["time"], *(table[name] for name in names)], axis=1)


def images(pieces: Array, snap: Snapshot) -> Array:
    """Facets (m, n, 3) with their images at the mirror planes of a model."""
    for axis, face in mirror_faces(snap):
        plane = mirror_plane(snap, axis, face) or 0.0
        turned = pieces.copy()
        turned[..., axis] = 2.0 * plane - turned[..., axis]
        pieces = np.concatenate([pieces, turned])
    if snap.dimension == "axisymmetric":
        pieces = np.concatenate([pieces, pieces * (-1.0, 1.0, 1.0)])
    return pieces


def at_time(wall: Wall, snap: Snapshot, mirror: bool, time: float) -> Array:
    """Facets (m, n, 3) of a wall at a time [m]; none while it does not act."""
    if not wall.cells or not wall.acts(time):
        return np.zeros((0, 2, 3))
    pieces = wall.placed(np.stack(wall.cells), time)
    return images(pieces, snap) if mirror else pieces


def is_seen(wall: Wall, mirror: bool) -> bool:
    """True if a picture of a run shows a wall. Open boundaries are not shown, nor are planes of symmetry, which are
    inside of the completed model."""
    return wall.kind != "outflow" and not (mirror and wall.kind == "symmetry" and wall.face)


def outlines(segments: Array) -> list[Array]:
    """Closed lines (n, 2) from segments (m, 2, 2) whose ends agree to the last bit."""
    ends: dict[tuple[float, ...], list[int]] = {}
    for row, pair in enumerate(segments):
        for point in pair:
            ends.setdefault(tuple(point), []).append(row)
    unused, loops = set(range(len(segments))), []
    while unused:
        row = unused.pop()
        start, here = (tuple(point) for point in segments[row])
        loop = [start, here]
        while here != start:
            following = next((other for other in ends[here] if other in unused), None)
            if following is None:
                break
            unused.discard(following)
            first, last = (tuple(point) for point in segments[following])
            here = last if first == here else first
            loop.append(here)
        loops.append(np.array(loop))
    return loops


def draw_plane(axes: Axes, walls: Sequence[Wall], snap: Snapshot, options: Options, metres: float,
               everything: bool = False) -> list[Wall]:
    """Draw walls in the plane of a run: rigid regions filled, boundaries as lines by their type.

    Boundaries through which material passes are drawn with `everything` only.
    """
    from matplotlib.collections import LineCollection
    from matplotlib.patches import PathPatch
    from matplotlib.path import Path
    drawn = []
    for wall in walls:
        colour, dash = STYLES.get(wall.kind, STYLES["slip"])
        pieces = at_time(wall, snap, options.mirror, snap.time)[:, :, [0, 2]] * metres
        if not len(pieces) or (not everything and not is_seen(wall, options.mirror)):
            continue
        drawn.append(wall)
        if wall.face == 0:
            loops = [loop for loop in outlines(pieces) if len(loop) > 3]
            if not loops:
                continue
            codes = np.concatenate([[Path.MOVETO] + [Path.LINETO] * (len(loop) - 1)
                                    for loop in loops])
            axes.add_patch(PathPatch(Path(np.concatenate(loops), codes), facecolor=BODY,
                                     edgecolor=colour, linewidth=1.2, hatch="////", zorder=0.9))
        else:
            thin = wall.kind in ("symmetry", "outflow", "periodic", "absorbing")
            axes.add_collection(LineCollection(list(pieces), colors=colour, linestyles=[dash],
                                               linewidths=1.2 if thin else 2.4, zorder=2.5))
    return drawn
