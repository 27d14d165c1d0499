# SPDX-License-Identifier: BSD-3-Clause
"""Spreads particles that moved apart over the gaps between them, for pictures of areal density.

A particle of failed material keeps its volume while its neighbours move away, so a uniform cloud of debris would appear
as dots, and as stripes where each particle is a ring. The directions and lengths of the spacing are found from the
neighbouring particles, in blocks of cells that contain enough of them. A particle that is as wide as the spacing keeps
its width; any other is spread over a third of the block, and along a row of particles in the direction of the row only.
"""
from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from ..arrays import Array

ENOUGH = {2: 80, 3: 40}  # particles in a block that are enough to find the spacing
LEVELS = 10              # sizes of blocks, each twice the previous one
APART = 1.5              # spacing over width above which a particle is spread
FARTHEST = 60.0          # greatest spacing over width
# fraction of the extent of a block over which a particle is spread, since debris is not uniform
SHARE = 1.0 / 3.0
MOST_PARTS = 16          # of a particle along a row, or over a sheet


def block_moments(places: Array, width: float) -> tuple[Array, Array]:
    """Count, mean and covariance of the particles in the block of 3 cells a side around the cell of each particle."""
    axes = places.shape[1]
    cell = np.floor(places / width).astype(np.int64)
    cell -= cell.min(axis=0) - 1
    span = cell.max(axis=0) + 2
    stride = np.concatenate([[1], np.cumprod(span[:-1])])
    keys, own = np.unique(cell @ stride, return_inverse=True)
    centre = places.mean(axis=0)
    local = (places - centre) / width
    pairs = [(i, j) for i in range(axes) for j in range(i, axes)]
    columns = [np.ones(len(places)), *local.T, *(local[:, i] * local[:, j] for i, j in pairs)]
    sums = np.stack([np.bincount(own.ravel(), column, len(keys)) for column in columns], axis=1)
    total = np.zeros_like(sums)
    steps = np.stack(np.meshgrid(*[[-1, 0, 1]] * axes, indexing="ij"), axis=-1).reshape(-1, axes) @ stride
    for step in steps:
        row = np.minimum(np.searchsorted(keys, keys + step), len(keys) - 1)
        total += np.where((keys[row] == keys + step)[:, None], sums[row], 0.0)
    count = total[:, 0]
    mean = total[:, 1:1 + axes] / count[:, None]
    spread = np.zeros((len(keys), axes, axes))
    for column, (i, j) in enumerate(pairs, 1 + axes):
        spread[:, i, j] = spread[:, j, i] = total[:, column] / count - mean[:, i] * mean[:, j]
    return count[own.ravel()], width ** 2 * spread[own.ravel()]


def spacing(places: Array, size: Array) -> tuple[Array, Array]:
    """Lengths (n, d) to spread each particle over, the largest first, and their directions (n, d, d) in columns.

    places  positions (n, d) with d = 2 or 3 [m]
    size    widths (n) [m]
    """
    count, axes = places.shape
    found, ways = np.repeat(size[:, None], axes, axis=1), np.tile(np.eye(axes), (count, 1, 1))
    if count < ENOUGH[axes]:
        return found, ways
    left, width = np.arange(count), max(float(np.quantile(size, 0.1)), 1.0e-300)
    for _ in range(LEVELS):
        number, spread = block_moments(places, width)
        ready = number[left] >= ENOUGH[axes]
        rows = left[ready]
        if len(rows):
            value, way = np.linalg.eigh(spread[rows])
            extent = np.sqrt(12.0 * np.maximum(value[:, ::-1], 0.0))
            found[rows], ways[rows] = shares(extent, number[rows], size[rows]), way[:, :, ::-1]
        left, width = left[~ready], 2.0 * width
        if not len(left):
            break
    return found, ways


def shares(extent: Array, number: Array, size: Array) -> Array:
    """Lengths (n, d) over which particles are spread if a given number of them fills a box of these extents (n, d), the
    largest first [m]."""
    found = np.empty_like(extent)
    open_axes = np.full(len(size), extent.shape[1])
    product = np.cumprod(np.maximum(extent, size[:, None]), axis=1)
    for axes in range(extent.shape[1], 0, -1):           # thin directions contain one layer of particles
        even = (product[:, axes - 1] / number) ** (1.0 / axes)
        thin = (open_axes == axes) & (axes > 1) & (even > np.maximum(extent[:, axes - 1], size))
        rest = (open_axes == axes) & ~thin
        found[rest, :axes] = even[rest, None]
        found[thin, axes - 1] = np.maximum(extent[thin, axes - 1], size[thin])
        open_axes[thin] -= 1
    found = np.where(found > APART * size[:, None], np.maximum(found, SHARE * extent), found)
    return np.clip(found, size[:, None], FARTHEST * size[:, None])


def smeared(places: Array, size: Array, loose: Array | bool = True) -> tuple[Array, Array, Array, Array]:
    """Rows, offsets (m, d) [m], mass fractions and half widths [m] of the parts over which particles are spread.

    `loose` marks the particles (n) that may be spread. The fractions of a particle add up to 1 and its parts are
    symmetric about it, so mass and centre of mass are conserved.
    """
    axes = places.shape[1]
    found, ways = spacing(places, size)
    apart = loose & (found[:, 0] > APART * size)
    least = np.maximum(found[:, -1], found[:, 0] / MOST_PARTS)
    if axes == 3:
        least = np.maximum(least, np.sqrt(found[:, 0] * found[:, 1] / MOST_PARTS))
    half = np.where(apart, least, size)
    parts = np.where(apart[:, None], np.clip(np.ceil(found / half[:, None] - 1.0e-9), 1, MOST_PARTS), 1).astype(int)
    listed: list[Array] = []
    offsets: list[Array] = []
    share: list[Array] = []
    for kind in np.unique(parts, axis=0):
        chosen = np.flatnonzero((parts == kind).all(axis=1))
        steps = [(np.arange(n) + 0.5) / n - 0.5 for n in kind]
        grid = np.stack([side.ravel() for side in np.meshgrid(*steps, indexing="ij")], axis=1)
        # tents overlap, so parts are distributed over twice the spacing less the width of a part
        reach = 2.0 * np.maximum(found[chosen] - half[chosen, None], 0.0) * (kind / np.maximum(kind - 1, 1))
        local = grid[None] * reach[:, None, :]
        listed.append(np.repeat(chosen, len(grid)))
        offsets.append(np.einsum("nij,nmj->nmi", ways[chosen], local).reshape(-1, axes))
        share.append(np.full(len(chosen) * len(grid), 1.0 / len(grid)))
    rows = np.concatenate(listed)
    return rows, np.concatenate(offsets), np.concatenate(share), half[rows]
