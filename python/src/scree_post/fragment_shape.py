# SPDX-License-Identifier: BSD-3-Clause
"""Shape and rotation of fragments, from sums over their particles."""
from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from scree.arrays import Array

SMALL = 1.0e-6           # moments of inertia below this share of that of the particles themselves are zero


def sums(labels: Array, values: Array, count: int) -> Array:
    """Sum of `values` (n, ...) over the particles of each of `count` fragments."""
    flat = values.reshape(len(values), -1)
    return np.stack([np.bincount(labels, column, minlength=count) for column in flat.T], axis=1).reshape(
        count, *values.shape[1:])


def principal_axes(labels: Array, points: Array, weight: Array, width: Array, axes: Sequence[int], count: int
                   ) -> tuple[Array, Array]:
    """Lengths (count, 3) [m], the longest first, and directions (count, 3, 3) of the principal axes of fragments.

    They are those of an ellipsoid with the same second moments, in two dimensions of an ellipse and in one of a
    segment; lengths along axes that the model lacks are 0. Particles are cubes of their width. direction[:, k] is that
    of axis k, with a positive largest component.
    """
    heavy = np.maximum(sums(labels, weight, count), 1.0e-300)
    centre = sums(labels, weight[:, None] * points, count) / heavy[:, None]
    arm = points - centre[labels]
    lacking = [axis for axis in range(3) if axis not in axes]
    arm[:, lacking] = 0.0
    moments = sums(labels, weight[:, None, None] * arm[:, :, None] * arm[:, None, :], count)
    own = sums(labels, weight * width ** 2 / 12.0, count)
    for axis in axes:
        moments[:, axis, axis] += own
    values, vectors = np.linalg.eigh(moments / heavy[:, None, None])
    length = 2.0 * np.sqrt((len(axes) + 2.0) * np.maximum(values[:, ::-1], 0.0))
    direction = np.swapaxes(vectors[:, :, ::-1], 1, 2)
    most = np.take_along_axis(direction, np.abs(direction).argmax(axis=2)[:, :, None], axis=2)
    return length, direction * np.where(most < 0.0, -1.0, 1.0) + 0.0     # no -0 in the table


def spins(labels: Array, arm: Array, velocity: Array, mass: Array, width: Array, count: int) -> Array:
    """Angular velocity of fragments (count, 3) [rad/s]: angular momentum over inertia, both about the centre of mass.

    arm, velocity  of particles (n, 3), relative to their fragment

    A rigid rotation is exact. Particles are points here, as their own rotation is not in the files, so the spin about
    an axis through all particles of a fragment is unknown, and 0: the three components of a single particle.
    """
    momentum = sums(labels, mass[:, None] * np.cross(arm, velocity), count)
    moments = sums(labels, mass[:, None, None] * arm[:, :, None] * arm[:, None, :], count)
    inertia = np.trace(moments, axis1=1, axis2=2)[:, None, None] * np.eye(3) - moments
    values, vectors = np.linalg.eigh(inertia)
    least = SMALL * sums(labels, mass * width ** 2, count)[:, None]
    inverse = np.where(values > least, 1.0 / np.where(values > least, values, 1.0), 0.0)
    spin: Array = np.einsum("nij,nj,nkj,nk->ni", vectors, inverse, vectors, momentum)
    return spin
