# SPDX-License-Identifier: BSD-3-Clause
"""The fragments of a snapshot: connected groups of particles that have not failed, as a table."""
from __future__ import annotations

import math
from collections.abc import Collection, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np

from scree.drawing.box import box_of, thickness
from scree.drawing.shape import images, mirror_faces, particle_size
from scree.drawing.view import failed_of
from scree.errors import EXIT_USAGE, ScreeError

from .fragment_bonds import Bonds, ancestors, bonded_pieces, bonds_of
from .fragment_shape import principal_axes, spins
from .pieces import find_pieces

if TYPE_CHECKING:
    from scree.arrays import Array
    from scree.drawing.box import Box
    from scree.files import Snapshot

COLUMNS = ("time [s]", "fragment", "particles", "mass [kg]", "volume [m3]", "size [m]",
           "centre_x [m]", "centre_y [m]", "centre_z [m]", "velocity_x [m/s]", "velocity_y [m/s]",
           "velocity_z [m/s]", "body", "spin_x [rad/s]", "spin_y [rad/s]", "spin_z [rad/s]", "axis_1 [m]", "axis_2 [m]",
           "axis_3 [m]", "long_x", "long_y", "long_z", "short_x", "short_y", "short_z", "temperature [K]")
FIELDS = ("mass", "volume", "velocity", "body", "failed", "damage", "identity", "temperature")   # that are read
COUNTS = ("time [s]", "fragments", "resolved", "largest [kg]", "failed [kg]", "unresolved [kg]", "absent [kg]",
          "mass [kg]")
RESOLVED = 8             # particles of a resolved fragment: two along each of three edges


@dataclass
class Fragments:
    """All fragments of a time, the heaviest first."""

    time: float                                          # [s]
    rows: list[tuple[Any, ...]] = field(default_factory=list)             # values of COLUMNS
    failed: float = 0.0                                  # mass of failed particles, "fines" [kg]
    absent: float = 0.0                                  # mass of intact particles without ancestor in the reference
    particle: float = 0.0                                # mass of the heaviest particle [kg]
    copies: int = 1                                      # mirror images of the model, with itself
    total: float = 0.0                                   # mass of all particles [kg]
    note: str = ""                                       # definition of a fragment in this run

    @property
    def masses(self) -> Array:
        """Mass of each fragment [kg]."""
        return np.array([row[3] for row in self.rows])

    def counts(self, particles: int) -> tuple[float, ...]:
        """Values of COUNTS; fragments of at least this number of particles are resolved."""
        small = [row[3] for row in self.rows if row[2] < particles]
        return (self.time, len(self.rows), len(self.rows) - len(small), float(self.masses.max(initial=0.0)),
                self.failed, float(sum(small)), self.absent, self.total)


def note_of(snap: Snapshot, mirror: bool, periodic: Collection[int], bonds: Bonds | None) -> str:
    """Definition of a fragment, as a sentence."""
    text = {"axisymmetric": "axisymmetric: a fragment is a ring around the axis; its mass is that "
            "of the whole ring, centre_x its radius, size the diameter of its cross-section",
            "1d": "one dimension: a fragment is a part of a bar; axis_1 is its length, size the diameter of a "
            "sphere of its volume",
            "plane_strain": "plane strain: a fragment is a prism as thick as the box; size is the "
            "diameter of its cross-section"}.get(
                snap.dimension, "a fragment is a piece in space; size is the diameter of a sphere "
                "of its volume")
    faces = mirror_faces(snap)
    if faces:
        names = " ".join("xyz"[axis] + face for axis, face in faces)
        text += (f"; the model is completed at its mirror planes {names}" if mirror else
                 f"; the model is not completed at its mirror planes {names}")
    if periodic:
        text += f"; periodic along {' '.join('xyz'[axis] for axis in sorted(periodic))}"
    if bonds is not None:
        text += (f"; particles are connected by bonds between neighbours of one body at {bonds.time:g} s, cut at "
                 f"{bonds.stretch:g} times their distance there")
    return text


def plane_axes(snap: Snapshot) -> tuple[int, ...]:
    """Axes along which particles can be separated."""
    return {"3d": (0, 1, 2), "1d": (0,)}.get(snap.dimension, (0, 2))


def periodic_axes(snap: Snapshot) -> tuple[Box, list[int]]:
    """The box, and its periodic axes along which particles can be separated."""
    box = box_of(snap)
    around = box.periodic & set(plane_axes(snap)) if box.low is not None and box.high is not None else set()
    if around and any(axis in around for axis, _ in mirror_faces(snap)):
        raise ScreeError(f"{snap.file}: an axis is periodic and has a mirror plane")
    return box, sorted(around)


def reference_bonds(snap: Snapshot, factor: float, stretch: float, mirror: bool = True) -> Bonds:
    """The bonds of a reference snapshot, for fragments_of with the same `factor` and `mirror`."""
    return bonds_of(snap, plane_axes(snap), periodic_axes(snap), factor, stretch, mirror)


def fragments_of(snap: Snapshot, factor: float = 1.5, cell: float | None = None, mirror: bool = True,
                 bonds: Bonds | None = None) -> Fragments:
    """The fragments of a snapshot.

    factor  particles are neighbours within this many times the mean of their widths
    cell    if given, particles of the same and of touching cells of this width [m] are neighbours
    bonds   if given, particles are connected by these bonds alone
    """
    snap.need("mass", "volume", "velocity", *(() if bonds is None else ("identity",)))
    positions, rows, signs = images(snap) if mirror else (
        snap.points, np.arange(len(snap.points)), np.ones((len(snap.points), 3)))
    mass = snap.fields["mass"].astype("f8")[rows]
    failed = failed_of(snap)[rows]
    width = particle_size(snap)[rows]
    good = ~failed & np.isfinite(positions).all(axis=1)
    axes, (box, around) = plane_axes(snap), periodic_axes(snap)
    copies = len(rows) // max(1, len(snap.points))
    found = Fragments(snap.time, failed=float(mass[failed].sum()), total=float(mass.sum()),
                      particle=float(mass.max(initial=0.0)), copies=max(1, copies),
                      note=note_of(snap, mirror, around, bonds))
    owner = np.zeros(0, int)
    if bonds is not None:
        row = ancestors(bonds, snap.fields["identity"])
        image = np.repeat(np.arange(copies), len(snap.points)) * len(bonds.rows)
        owner = np.where(row[rows] < 0, -1, row[rows] + image)
        found.absent = float(mass[good & (owner < 0)].sum())
        good &= owner >= 0
    periodic = [(axes.index(axis), axis) for axis in around]
    pick = np.flatnonzero(good)
    if len(pick) == 0:
        return found
    if bonds is not None:
        labels = bonded_pieces(bonds, owner[pick], positions[pick][:, axes], (box, periodic))
    elif width[pick].max() <= 0.0 and cell is None:
        raise ScreeError(f"{snap.file}: particles without volume have no neighbours; use --cell",
                        EXIT_USAGE)
    else:
        labels = find_pieces(positions[pick][:, axes], width[pick], factor, cell, box, periodic)
    found.rows = table(snap, labels, positions[pick], signs[pick], rows[pick], (box, around))
    return found


def unwrapped(points: Array, labels: Array, first: Array, box: Box, around: Sequence[int]) -> Array:
    """Positions of fragments across a periodic boundary, moved to the side of their first particle."""
    points = points.copy()
    for axis in around:
        length = box.side(axis)[1] - box.side(axis)[0]
        off = points[:, axis] - points[first[labels], axis]
        points[:, axis] -= length * np.round(off / length)
    return points


def table(snap: Snapshot, labels: Array, points: Array, signs: Array, rows: Array,
          wrap: tuple[Box, Sequence[int]]) -> list[tuple[Any, ...]]:
    """A row of COLUMNS for each fragment, the heaviest first."""
    box, around = wrap
    mass = snap.fields["mass"].astype("f8")[rows]
    volume = snap.fields["volume"].astype("f8")[rows]
    velocity = snap.fields["velocity"].astype("f8")[rows] * signs
    count = int(labels.max()) + 1
    first = np.unique(labels, return_index=True)[1]
    points = unwrapped(points, labels, first, box, around)

    def total(values: Array) -> Array:
        return np.bincount(labels, values, minlength=count)

    heavy = np.maximum(total(mass), 1.0e-300)
    centre = np.stack([total(mass * points[:, k]) / heavy for k in range(3)], axis=1)
    middle = centre.copy()
    for axis in around:                                  # back into the box
        low, high = box.side(axis)
        centre[:, axis] = low + (centre[:, axis] - low) % (high - low)
    speed = np.stack([total(mass * velocity[:, k]) / heavy for k in range(3)], axis=1)
    ring = snap.dimension == "axisymmetric"
    width = particle_size(snap)[rows]
    spin = spins(labels, points - middle[labels], velocity - speed[labels], mass, width, count)
    spin = 0.0 + spin * {"3d": (1.0, 1.0, 1.0), "axisymmetric": (0.0, 0.0, 0.0), "1d": (0.0, 0.0, 0.0)}.get(
        snap.dimension, (0.0, 1.0, 0.0))                 # rings and slabs do not rotate
    length, direction = principal_axes(labels, points, mass / np.maximum(points[:, 0], 1.0e-300) if ring else mass,
                                       width, plane_axes(snap), count)
    warm = np.full(count, np.nan)
    if "temperature" in snap.fields:
        warm = total(mass * snap.fields["temperature"][rows]) / heavy
    number, space = np.bincount(labels, minlength=count), total(volume)
    size = diameter(snap, space, total(volume / np.maximum(points[:, 0], 1.0e-300)))
    shortest = len(plane_axes(snap)) - 1
    body = main_body(snap.body_rows()[rows], mass, labels, count) + snap.first_body
    # Bits of sums may differ between equal mirror images: order by rounded mass, then by position.
    order = np.lexsort((centre[:, 0].round(9), centre[:, 2].round(9),
                        -np.array([float(f"{value:.9e}") for value in heavy])))
    return [(snap.time, place + 1, int(number[row]), float(heavy[row]),
             float(space[row]), float(size[row]),
             *map(float, centre[row]), *map(float, speed[row]), int(body[row]), *map(float, spin[row]),
             *map(float, length[row]), *map(float, direction[row, 0]), *map(float, direction[row, shortest]),
             float(warm[row]))
            for place, row in enumerate(order)]


def diameter(snap: Snapshot, volume: Array, volume_over_radius: Array) -> Array:
    """Diameter of a sphere of the same volume or of a circle of the same cross-section [m]."""
    if snap.dimension == "axisymmetric":
        return 2.0 * np.sqrt(volume_over_radius / (2.0 * math.pi) / math.pi)
    if snap.dimension == "plane_strain":
        return 2.0 * np.sqrt(volume / thickness(snap) / math.pi)
    return np.asarray(np.cbrt(6.0 * volume / math.pi))


def main_body(bodies: Array, mass: Array, labels: Array, count: int) -> Array:
    """Row of the body to which most of the mass of each fragment belongs."""
    kinds = int(bodies.max()) + 1
    share = np.bincount(labels * kinds + bodies, mass, minlength=count * kinds)
    return np.asarray(share.reshape(count, kinds).argmax(axis=1))
