# SPDX-License-Identifier: BSD-3-Clause
"""Surfaces of solids and heaps: the contour where particles fill half of the space.

The volume of the particles is put on a grid of half their width and smoothed over about a particle. A particle that
the surface does not reach is *loose*; loose particles are drawn one by one, so that no mass is left out. In two
dimensions contourpy, a part of matplotlib, finds the contour; in three, rays parallel to the line of sight.
"""
from __future__ import annotations

import itertools
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from ..errors import modules

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from ..arrays import Array, Bools
    from .view import Window

HALF = 0.5               # fraction of the space that is filled at the surface
FINE = 0.5               # pitch of the grid over the median width of the particles
SMOOTH = 0.8             # standard deviation of the smoothing over that width
MOST = {2: 4.0e6, 3: 4.0e7}    # cells of the grid; the pitch grows with more
MOST_PARTS = {2: 40, 3: 12}    # along an edge of a particle
FEW = 6                  # particles whose colours are mixed at a place
BLOCK = 2                # pixels along a side of the squares with one colour in space, as a pixel of the page


class Filling:
    """The filled fraction of space on a grid of points, the first axis in the order of the coordinates."""

    def __init__(self, middle: Array, edges: Array, size: Array) -> None:
        """From centres (n, d), edge vectors (n, d, d) and widths (n) of particles, all in one unit of length."""
        axes = middle.shape[1]
        width = float(np.median(size))
        reach = 3.0 * width
        low, high = middle.min(axis=0) - reach, middle.max(axis=0) + reach
        self.pitch = max(FINE * width, float(np.prod(high - low) / MOST[axes]) ** (1.0 / axes))
        self.low = low
        shape = np.ceil((high - low) / self.pitch).astype(int)
        total = np.zeros(int(np.prod(shape)), np.float32)
        volume = np.abs(np.linalg.det(edges)) / self.pitch ** axes
        parts = np.clip(np.ceil(np.abs(edges).sum(axis=1).max(axis=1) / self.pitch), 1, MOST_PARTS[axes]).astype(int)
        for number in np.unique(parts):
            rows = np.flatnonzero(parts == number)
            for steps in itertools.product((np.arange(number) + 0.5) / number - 0.5, repeat=axes):
                place = middle[rows] + np.einsum("k,nkj->nj", steps, edges[rows])
                cell = np.floor((place - low) / self.pitch).astype(int)
                held = ((cell >= 0) & (cell < shape)).all(axis=1)
                total += np.bincount(np.ravel_multi_index(tuple(cell[held].T), tuple(shape)),
                                     volume[rows][held] / number ** axes, len(total)).astype(np.float32)
        (ndimage,) = modules("scipy.ndimage")
        spread = max(SMOOTH * width / self.pitch, SMOOTH)
        self.share = ndimage.gaussian_filter(total.reshape(shape), spread, mode="constant")

    def at(self, places: Array) -> Array:
        """The filled fraction at places (m, d)."""
        (ndimage,) = modules("scipy.ndimage")
        return np.asarray(ndimage.map_coordinates(self.share, ((places - self.low) / self.pitch - 0.5).T, order=1))

    def loose(self, places: Array, size: Array) -> Bools:
        """Particles (n) at places (n, d) whose squares or cubes the surface does not reach."""
        (ndimage,) = modules("scipy.ndimage")
        reach = max(int(0.5 * float(np.median(size)) / self.pitch + 0.5), 1)
        widest = ndimage.maximum_filter(self.share, 2 * reach + 1, mode="constant")
        cell = np.clip(np.floor((places - self.low) / self.pitch).astype(int), 0, np.array(widest.shape) - 1)
        return np.asarray(widest[tuple(cell.T)] < HALF)

    def nodes(self, axis: int) -> Array:
        """Coordinates of the points of the grid along an axis."""
        return np.asarray(self.low[axis] + (np.arange(self.share.shape[axis]) + 0.5) * self.pitch)


def mixed(points: Array, values: Array, places: Array) -> Array:
    """Values (n, k) of particles at other places: means over the nearest ones, or the nearest where they are flags."""
    (spatial,) = modules("scipy.spatial")
    few = 1 if len(np.unique(values[:, 0])) <= 2 else min(FEW, len(points))
    far, rows = spatial.cKDTree(points).query(places, few)
    if few == 1:
        return np.asarray(values[rows])
    weight = 1.0 / np.maximum(far, 1.0e-300) ** 2
    return np.asarray((weight[..., None] * values[rows]).sum(axis=1) / weight.sum(axis=1)[:, None])


def outline(filling: Filling) -> Any:
    """The filled part of a plane as a path of matplotlib, in the unit of the grid; None if nothing is filled."""
    contourpy, path = modules("contourpy", "matplotlib.path")
    made = contourpy.contour_generator(filling.nodes(0), filling.nodes(1), filling.share.T, fill_type="OuterCode")
    points, codes = made.filled(HALF, 2.0 * float(filling.share.max()) + 1.0)
    return path.Path(np.concatenate(points), np.concatenate(codes)) if points else None


def draw(axes: Axes, middle: Array, edges: Array, size: Array, tints: Array, factor: float = 1.0e3) -> Bools:
    """Draw the surface of particles in a plane; returns the loose particles, which the caller draws.

    middle  centres (n, 2), with edge vectors (n, 2, 2) and widths (n) [m]
    tints   red, green, blue (n, 3) from 0 to 1
    factor  from metres to the unit of the axes (mm)
    """
    from matplotlib.patches import PathPatch
    filling = Filling(middle, edges, size)
    found = outline(filling)
    if found is None:
        return np.ones(len(size), bool)
    fine = 0.5 * filling.pitch                           # of the colours
    across, up = ((np.arange(2 * count) + 0.5) * fine for count in filling.share.shape)
    places = filling.low + np.stack(np.meshgrid(across, up), axis=-1).reshape(-1, 2)
    image = np.clip(mixed(middle, tints, places).reshape(len(up), len(across), 3), 0.0, 1.0)
    (left, bottom), step = factor * filling.low, factor * fine
    window = axes.axis()
    shown = axes.imshow(image, extent=(left, left + step * len(across), bottom, bottom + step * len(up)),
                        origin="lower", interpolation="bilinear", zorder=1.1)
    border = PathPatch(type(found)(factor * found.vertices, found.codes), facecolor="none", edgecolor="#222222",
                       linewidth=0.5, zorder=1.2)
    axes.add_patch(border)
    shown.set_clip_path(border)
    axes.axis(window)
    return filling.loose(middle, size)


def crowded(points: Array, size: Array) -> Bools:
    """Particles in blocks of three particles a side that are filled to a third, or beside them: all that can be in a
    surface."""
    width = 3.0 * float(np.median(size))
    cell = np.floor((points - points.min(axis=0)) / width).astype(np.int64) + 1
    span = cell.max(axis=0) + 2
    stride = np.array([span[1] * span[2], span[2], 1])
    keys, own = np.unique(cell @ stride, return_inverse=True)
    dense = keys[np.bincount(own.ravel(), size ** 3) > width ** 3 / 3.0]
    beside = np.isin(keys, (dense[:, None] + np.array(list(itertools.product((-1, 0, 1), repeat=3))) @ stride).ravel())
    return np.asarray(beside[own.ravel()])


def cast(seen: Array, size: Array, tint: Array, window: Window, shape: Sequence[int]) -> tuple[Bools, Array, Array]:
    """The surface of particles in space, as it is seen in an image of height and width `shape`.

    seen    positions (n, 3) to the right, up and towards the viewer; the window is in the same unit
    tint    values (n, k) that are drawn

    Returns the loose particles (n), the distance towards the viewer of each pixel (height, width), -inf where there is
    none, and for each pixel of the surface, row by row, its normal and values (m, 3 + k).
    """
    high, wide = shape
    near, loose = np.full(high * wide, -np.inf), np.ones(len(seen), bool)
    some = np.flatnonzero(crowded(seen, size)) if len(seen) else np.zeros(0, int)
    if not len(some):
        return loose, near.reshape(high, wide), np.zeros((0, 3 + tint.shape[1]))
    filling = Filling(seen[some], size[some, None, None] * np.eye(3), size[some])
    loose[some] = filling.loose(seen[some], size[some])
    pixel = (window[1] - window[0]) / wide
    hit = strike(filling, window, pixel, wide, near)
    right, up = window[0] + (hit % wide + 0.5) * pixel, window[3] - (hit // wide + 0.5) * pixel
    places = np.stack([right, up, near[hit]], axis=1)
    slope = np.stack([filling.at(places - step) - filling.at(places + step)
                      for step in 1.5 * filling.pitch * np.eye(3)], axis=1)
    slope /= np.maximum(np.linalg.norm(slope, axis=1), 1.0e-30)[:, None]
    within = some[~loose[some]]
    # one colour for the pixels of a block that are equally far, since a particle is wider
    layer = np.floor((near[hit] - filling.low[2]) / filling.pitch).astype(np.int64)
    keys = (layer * high + hit // wide // BLOCK) * wide + hit % wide // BLOCK
    _, first, block = np.unique(keys, return_index=True, return_inverse=True)
    colour = mixed(seen[within], tint[within], places[first])[block.ravel()]
    return loose, near.reshape(high, wide), np.hstack([slope, colour])


def strike(filling: Filling, window: Window, pixel: float, wide: int, near: Array) -> Array:
    """Follow the rays of all pixels away from the viewer until they meet the surface; writes their places in `near`
    and returns the pixels that do, ascending."""
    high = len(near) // wide
    ends = [(np.array([nodes[0], nodes[-1]]) - edge) / step for nodes, edge, step in
            ((filling.nodes(0), window[0], pixel), (filling.nodes(1), window[3], -pixel))]
    columns, rows = (np.arange(max(int(np.ceil(end.min() - 0.5)), 0), min(int(np.floor(end.max() - 0.5)) + 1, most))
                     for end, most in zip(ends, (wide, high)))
    left = (rows[:, None] * wide + columns[None, :]).ravel()
    place = [(window[0] + (left % wide + 0.5) * pixel - filling.nodes(0)[0]) / filling.pitch,
             (window[3] - (left // wide + 0.5) * pixel - filling.nodes(1)[0]) / filling.pitch]
    first = [np.clip(np.floor(one).astype(int), 0, count - 2) for one, count in zip(place, filling.share.shape)]
    part = [(one - base).astype(np.float32) for one, base in zip(place, first)]
    across = filling.share.shape[1]
    corner = first[0] * across + first[1]
    planes, depth = np.ascontiguousarray(np.moveaxis(filling.share, 2, 0)), filling.nodes(2)

    def level(number: int, rows: Any) -> Array:
        """The filled fraction on a plane across the line of sight at the rays `rows`."""
        flat, at, a, b = planes[number].ravel(), corner[rows], part[0][rows], part[1][rows]
        return np.asarray((1.0 - a) * ((1.0 - b) * flat[at] + b * flat[at + 1])
                          + a * ((1.0 - b) * flat[at + across] + b * flat[at + across + 1]))

    def reached(filled: Array) -> Bools:
        """Squares of the plane with a corner that is filled, as an array for `corner`."""
        some = filled >= HALF
        some[:-1] |= some[1:]
        some[:, :-1] |= some[:, 1:]
        return np.asarray(some.ravel())

    alive = np.flatnonzero(reached(planes.max(axis=0))[corner])
    for number in range(len(depth) - 1, -1, -1):
        tried = np.flatnonzero(reached(planes[number])[corner[alive]])    # a mean of less is less
        if not len(tried):
            continue
        now = level(number, alive[tried])
        met = tried[now >= HALF]
        ray = alive[met]
        before = level(number + 1, ray) if number + 1 < len(depth) else np.zeros(len(ray), np.float32)
        share = (HALF - before) / (now[now >= HALF] - before)
        near[left[ray]] = depth[number] + (1.0 - share) * filling.pitch
        alive = np.delete(alive, met)
        if not len(alive):
            break
    return np.flatnonzero(near > -np.inf)
