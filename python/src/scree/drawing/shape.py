# SPDX-License-Identifier: BSD-3-Clause
"""Sizes of particles, mirror images at planes of symmetry, and slices of a model."""
from __future__ import annotations

import math
from collections.abc import Callable
from typing import TYPE_CHECKING

import numpy as np

from ..errors import ScreeError
from .box import mirror_plane, thickness

if TYPE_CHECKING:
    from ..arrays import Array
    from ..files import Snapshot

MOST_STRETCH = 16.0      # square of the longest edge over the area; longer particles are drawn as squares


def widths(dimension: str, volume: Array, radius: Array, thickness: Callable[[int], float]) -> Array:
    """Width of particles in the plane of the model [m] from their volumes [m3].

    `thickness` gives the size of the model along an axis that its plane lacks, 1 for y and 2 for z [m].
    """
    volume = np.maximum(np.where(np.isfinite(volume), volume, 0.0).astype("f8"), 0.0)
    size: Array
    if dimension == "axisymmetric":
        size = np.sqrt(volume / (2.0 * math.pi * np.maximum(radius, 1.0e-300)))
    elif dimension == "plane_strain":
        size = np.sqrt(volume / thickness(1))
    elif dimension == "1d":
        size = volume / (thickness(1) * thickness(2))
    else:
        size = np.cbrt(volume)
    return size


def particle_size(snap: Snapshot) -> Array:
    """Current width of each particle in the plane of the model [m]."""
    return widths(snap.dimension, snap.fields["volume"], snap.points[:, 0], lambda axis: thickness(snap, axis))


def plane_edges(snap: Snapshot, size: Array) -> Array:
    """Edges (n, 2, 2) of each particle in the plane of a run in two dimensions [m].

    Squares of the particle's volume; where the file has the deformation gradient (xx, yx, zx, xy, yy, zy, xz, yz, zz),
    the parallelogram of the same area into which it deforms a square.
    """
    edges = np.zeros((len(size), 2, 2))
    edges[:, 0, 0] = edges[:, 1, 1] = size
    gradient = snap.fields.get("deformation_gradient")
    if gradient is None or gradient.ndim != 2 or gradient.shape[1] != 9:
        return edges
    parts = np.stack([gradient[:, [0, 2]], gradient[:, [6, 8]]], axis=1).astype("f8")
    area = parts[:, 0, 0] * parts[:, 1, 1] - parts[:, 0, 1] * parts[:, 1, 0]
    longest = np.abs(parts).max(axis=(1, 2))
    with np.errstate(invalid="ignore", divide="ignore"):
        usable = np.isfinite(area) & (area > 0.0) & (longest ** 2 < MOST_STRETCH * area)
        scaled = size[:, None, None] * parts / np.sqrt(area)[:, None, None]
    return np.where(usable[:, None, None], scaled, edges)


def images(snap: Snapshot) -> tuple[Array, Array, Array]:
    """All particles with their mirror images at the planes of symmetry.

    Returns positions (m, 3) [m], the rows of their original particles (m), and the signs (m, 3) that convert a vector
    of the particle to that of its image.
    """
    positions, rows = snap.points, np.arange(len(snap.points))
    signs = np.ones((len(rows), 3))
    for axis, face in mirror_faces(snap):
        plane = mirror_plane(snap, axis, face)
        if plane is None and face == "hi":
            raise ScreeError(f"{snap.file}: symmetry at {'xyz'[axis]}hi, "
                            "and the file does not contain its position")
        image, turned = positions.copy(), signs.copy()
        image[:, axis] = 2.0 * (plane or 0.0) - image[:, axis]
        turned[:, axis] *= -1.0
        positions, signs = np.concatenate([positions, image]), np.concatenate([signs, turned])
        rows = np.concatenate([rows, rows])
    return positions, rows, signs


def mirror_faces(snap: Snapshot) -> list[tuple[int, str]]:
    """Pairs (axis, "lo" or "hi") of the mirror planes of a model."""
    found = []
    for face in snap.symmetry:
        if face[:1] not in "xyz" or face[1:] not in ("lo", "hi"):
            raise ScreeError(f"{snap.file}: unknown symmetry face '{face}' in /provenance")
        axis = "xyz".index(face[0])
        if (snap.dimension != "3d" and axis == 1) or (snap.dimension == "axisymmetric" and axis == 0):
            continue  # not a direction of this model, or its axis
        found.append((axis, face[1:]))
    return found


def slice_depth(snap: Snapshot, axis: int, depth: Array) -> float:
    """Position of the slice along the line of sight: a plane of symmetry, or the middle of the material."""
    for mirror, face in mirror_faces(snap):
        if mirror == axis:
            return mirror_plane(snap, axis, face) or 0.0
    mass = snap.fields["mass"]
    return float(np.average(depth[:len(mass)], weights=mass))
