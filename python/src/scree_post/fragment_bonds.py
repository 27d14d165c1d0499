# SPDX-License-Identifier: BSD-3-Clause
"""Fragments by bonds: particles that were neighbours in the first snapshot, and are not yet separated."""
from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from scree.drawing.shape import images, particle_size
from scree.errors import FileProblem

from .pieces import close_pairs, connected, with_ghosts

if TYPE_CHECKING:
    from scree.arrays import Array
    from scree.drawing.box import Box
    from scree.files import Snapshot

# Ids of split particles (doc/theory/splitting.md): the lower bits are the original particle, the upper ones the place
# in the tree of halves, 0 for the original.
ROOT_BITS = 40
STRETCH = 2.0            # two particles per cell along an edge are then a cell apart, and do not always share a node


@dataclass
class Bonds:
    """Pairs of neighbours in the reference snapshot. Mirror images of n particles are further n rows each."""

    time: float                                          # of the reference [s]
    stretch: float                                       # of the distance, at which a bond is cut
    identity: Array                                      # (n) in the reference, ascending
    rows: Array                                          # (n) rows of the reference with these identities
    width: Array                                         # (m n) widths of the particles and their images [m]
    pairs: Array                                         # (k, 2) rows of neighbours
    length: Array                                        # (k) their distance [m]


def parents(identity: Array) -> Array:
    """Id of the particle that was split into this half; an original particle is its own."""
    place = identity >> ROOT_BITS
    return np.where(place > 3, (identity & ((1 << ROOT_BITS) - 1)) + ((place >> 1) << ROOT_BITS),
                    identity & ((1 << ROOT_BITS) - 1))


def ancestors(bonds: Bonds, identity: Array) -> Array:
    """Row in the reference of each particle, or of the particle of which it is a part; -1 if there is none."""
    found, current = np.full(len(identity), -1), identity.astype("i8")
    if len(bonds.identity) == 0:
        return found
    while True:
        at = np.minimum(np.searchsorted(bonds.identity, current), len(bonds.identity) - 1)
        found = np.where((found < 0) & (bonds.identity[at] == current), bonds.rows[at], found)
        if not ((found < 0) & (current >> ROOT_BITS > 0)).any():
            return found
        current = parents(current)


def bonds_of(snap: Snapshot, axes: Sequence[int], wrap: tuple[Box, Sequence[int]], factor: float, stretch: float,
             mirror: bool) -> Bonds:
    """The bonds of a reference snapshot: pairs of particles of one body within `factor` times the mean of their widths.

    axes  along which particles can be separated;  wrap  the box and its periodic axes
    """
    (identity,) = snap.need("identity", "volume")[:1]
    points, rows, _ = images(snap) if mirror else (snap.points, np.arange(len(snap.points)), None)
    width = particle_size(snap)[rows]
    order = np.argsort(identity, kind="stable")
    ordered = identity[order].astype("i8")
    if (np.diff(ordered) == 0).any():
        raise FileProblem(f"{snap.file}: two particles have the same identity; bonds cannot be followed")
    pairs, length = np.zeros((0, 2), int), np.zeros(0)
    if len(points) > 1 and width.max() > 0.0:
        box, around = wrap
        plane = points[:, axes]
        spread, origin = with_ghosts(plane, 2.0 * factor * float(width.max()), box,
                                     [(list(axes).index(axis), axis) for axis in around])
        near = close_pairs(spread, width[origin], factor)
        length = np.linalg.norm(spread[near[:, 0]] - spread[near[:, 1]], axis=1)
        pairs = np.sort(origin[near], axis=1)            # a copy is the same particle
        body = snap.body_rows()[rows]
        keep = (pairs[:, 0] != pairs[:, 1]) & (body[pairs[:, 0]] == body[pairs[:, 1]])
        pairs, length = pairs[keep], length[keep]
        if around:                                       # a pair may be found on both sides of the box: the shorter one
            by_length = np.argsort(length, kind="stable")
            _, first = np.unique(pairs[by_length, 0] * len(points) + pairs[by_length, 1], return_index=True)
            pairs, length = pairs[by_length[first]], length[by_length[first]]
    return Bonds(snap.time, stretch, ordered, order, width, pairs, length)


def bonded_pieces(bonds: Bonds, owner: Array, points: Array, wrap: tuple[Box, Sequence[tuple[int, int]]]) -> Array:
    """Index of the group of each particle: connected by bonds that hold.

    owner   (n) row in the reference, with images;  points  (n, axes) [m]
    wrap    the box, and its periodic axes with their columns, as for find_pieces

    The parts of a split particle have all of its bonds, and are bonded to each other within its width in the reference.
    """
    if len(owner) == 0:
        return np.zeros(0, np.int64)
    count = len(bonds.width)
    from scipy.sparse import coo_array
    reach = coo_array((np.concatenate([bonds.length, bonds.width]),
                       (np.concatenate([bonds.pairs[:, 0], np.arange(count)]),
                        np.concatenate([bonds.pairs[:, 1], np.arange(count)]))), shape=(count, count)).tocsr()
    parts = coo_array((np.ones(len(owner)), (np.arange(len(owner)), owner)), shape=(len(owner), count)).tocsr()
    links = (parts @ reach @ parts.T).tocoo()            # a particle has one owner: each entry is one product
    off = points[links.row] - points[links.col]
    box, around = wrap
    for column, axis in around:
        side = box.side(axis)[1] - box.side(axis)[0]
        off[:, column] -= side * np.round(off[:, column] / side)
    hold = np.linalg.norm(off, axis=1) <= bonds.stretch * links.data
    return connected(links.row[hold], links.col[hold], len(owner))
