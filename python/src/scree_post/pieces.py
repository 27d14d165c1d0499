# SPDX-License-Identifier: BSD-3-Clause
"""Groups of connected particles: neighbours by distance or by cells, and connected components."""
from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from scree.drawing.box import Box

if TYPE_CHECKING:
    from scree.arrays import Array


def close_pairs(points: Array, reach: Array, factor: float) -> Array:
    """Pairs (n, 2) whose distance is at most `factor` times the mean of their reaches.

    points  (n, axes) [m];  reach  (n) [m]
    """
    from scipy.spatial import cKDTree
    pairs = cKDTree(points).query_pairs(factor * float(reach.max()), output_type="ndarray")
    one, other = pairs.T
    distance = np.linalg.norm(points[one] - points[other], axis=1)
    return np.asarray(pairs[distance <= 0.5 * factor * (reach[one] + reach[other])])


def touching_cells(points: Array, width: float) -> Array:
    """Pairs (n, 2) that connect points of the same cell and of cells that touch, including those at corners."""
    from scipy.spatial import cKDTree
    cells = np.floor((points - points.min(axis=0)) / width)
    different, first, inverse = np.unique(cells, axis=0, return_index=True, return_inverse=True)
    neighbours = cKDTree(different).query_pairs(1.5, p=np.inf, output_type="ndarray")
    return np.concatenate([np.stack([np.arange(len(points)), first[inverse.ravel()]], axis=1), first[neighbours]])


def with_ghosts(points: Array, reach: float, box: Box, axes: Sequence[tuple[int, int]]) -> tuple[Array, Array]:
    """Points with copies beyond periodic boundaries, and for each the row of the original point.

    axes  positions of the periodic axes among the columns, with the axis of the box: [(0, 0)]
    """
    rows = np.arange(len(points))
    for column, axis in axes:
        low, high = box.side(axis)
        near = points[:, column] < low + reach
        copies = points[near].copy()
        copies[:, column] += high - low
        points = np.concatenate([points, copies])
        rows = np.concatenate([rows, rows[near]])
    return points, rows


def find_pieces(points: Array, reach: Array, factor: float = 1.5, cell: float | None = None,
                box: Box | None = None, periodic: Sequence[tuple[int, int]] = ()) -> Array:
    """Index of the group of each point: neighbours within factor * reach, or in touching cells.

    Groups are numbered in the order of their first points.
    """
    if len(points) == 0:
        return np.zeros(0, np.int64)
    far = cell if cell is not None else factor * float(reach.max())
    spread, rows = with_ghosts(points, 2.0 * far, box or Box(), periodic)
    pairs = touching_cells(spread, cell) if cell is not None else close_pairs(spread, reach[rows], factor)
    one, other = rows[pairs].T                           # a copy is the same particle
    return connected(one, other, len(points))


def connected(one: Array, other: Array, count: int) -> Array:
    """Index of the connected group of each of `count` points, from pairs of their rows."""
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components
    links = coo_array((np.ones(len(one), bool), (one, other)), shape=(count, count))
    return np.asarray(connected_components(links, directed=False)[1])
