# SPDX-License-Identifier: BSD-3-Clause
"""Pieces of connected particles: neighbours by distance or by cells, and what holds together."""
import itertools

import numpy as np

MOST_PAIRS = 4000000     # that are looked at in one go


def half_stencil(axes):
    """Offsets of neighbouring cells, one of each pair of opposite ones, the cell itself first."""
    offsets = list(itertools.product((-1, 0, 1), repeat=axes))
    return [offset for offset in offsets if offset >= (0,) * axes]


def cell_numbers(points, width):
    """A whole number for the cell of each point, and what one step along each axis adds to it."""
    cells = np.floor((points - points.min(axis=0)) / width).astype(np.int64) + 1
    room = [int(cells[:, axis].max()) + 2 for axis in range(points.shape[1])]
    steps = np.cumprod([1] + room[:-1], dtype=np.int64)
    return cells @ steps, steps


def runs_of(starts, counts):
    """Concatenation of the ranges start, start + 1, ... of these lengths."""
    ends = np.cumsum(counts)
    return np.arange(ends[-1] if len(ends) else 0) - np.repeat(ends - counts - starts, counts)


def close_pairs(points, reach, factor):
    """Yields arrays (one, other) of pairs whose distance is at most the mean of their reaches.

    points  (n, axes) [m];  reach  (n) [m], times `factor`
    """
    if len(points) < 2:
        return
    reach = factor * reach
    number, steps = cell_numbers(points, float(reach.max()))
    order = np.argsort(number, kind="stable")
    ordered = number[order]
    for offset in half_stencil(points.shape[1]):
        wanted = ordered + int(np.dot(offset, steps))
        first = np.searchsorted(ordered, wanted, side="left")
        last = np.searchsorted(ordered, wanted, side="right")
        if not any(offset):
            first = np.arange(1, len(ordered) + 1)       # each pair of one cell once
        counts = np.maximum(last - first, 0)
        total, begin = np.cumsum(counts), 0
        while begin < len(order):
            done = total[begin - 1] if begin else 0
            end = max(begin + 1, int(np.searchsorted(total, done + MOST_PAIRS, side="right")))
            part = slice(begin, end)
            one = order[np.repeat(np.arange(begin, min(end, len(order))), counts[part])]
            other = order[runs_of(first[part], counts[part])]
            apart = ((points[one] - points[other]) ** 2).sum(axis=1)
            near = apart <= (0.5 * (reach[one] + reach[other])) ** 2
            yield one[near], other[near]
            begin = end


def touching_cells(points, width):
    """Yields arrays (one, other) that tie points of the same cell and of touching cells."""
    if len(points) == 0:
        return
    number, steps = cell_numbers(points, width)
    cells, first, inverse = np.unique(number, return_index=True, return_inverse=True)
    yield np.arange(len(points)), first[inverse.ravel()]
    for offset in half_stencil(points.shape[1])[1:]:
        wanted = cells + int(np.dot(offset, steps))
        place = np.minimum(np.searchsorted(cells, wanted), len(cells) - 1)
        there = cells[place] == wanted
        yield first[there], first[place[there]]


def connected(count, pairs):
    """Number of the piece of each of `count` particles, from arrays of tied pairs."""
    parent = np.arange(count)
    for one, other in pairs:
        while len(one):
            one, other = parent[one], parent[other]
            apart = one != other
            one, other = one[apart], other[apart]
            np.minimum.at(parent, np.maximum(one, other), np.minimum(one, other))
            while True:                                  # everybody points to the root of all
                above = parent[parent]
                if np.array_equal(above, parent):
                    break
                parent = above
    return np.unique(parent, return_inverse=True)[1].ravel()


def with_ghosts(points, reach, box, axes):
    """Points with copies beyond periodic faces, and the row of the point each is a copy of.

    axes  positions of the periodic axes among the columns, with the axis of the box: [(0, 0)]
    """
    rows = np.arange(len(points))
    for column, axis in axes:
        near = points[:, column] < box.low[axis] + reach
        copies = points[near].copy()
        copies[:, column] += box.high[axis] - box.low[axis]
        points = np.concatenate([points, copies])
        rows = np.concatenate([rows, rows[near]])
    return points, rows


def find_pieces(points, reach, factor=None, cell=None, box=None, periodic=()):
    """Number of the piece of each point: neighbours within factor * reach, or of touching cells."""
    if len(points) == 0:
        return np.zeros(0, np.int64)
    far = cell if cell is not None else factor * float(reach.max())
    spread, rows = with_ghosts(points, 2.0 * far, box, periodic)
    if cell is not None:
        pairs = touching_cells(spread, cell)
    else:
        pairs = close_pairs(spread, reach[rows], factor)
    ghosts = np.arange(len(points), len(rows))
    tied = itertools.chain(pairs, [(ghosts, rows[ghosts])])
    labels = connected(len(spread), tied)[:len(points)]
    return np.unique(labels, return_inverse=True)[1].ravel()
