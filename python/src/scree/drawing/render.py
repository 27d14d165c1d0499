# SPDX-License-Identifier: BSD-3-Clause
"""Shaded pictures of spheres in parallel projection, computed with numpy alone: without display and OpenGL.

A depth buffer finds the foremost sphere in each pixel. Light comes from the upper left of the viewer; a second depth
buffer, from the direction of the light, gives shadows. Pixels that are deeper than their surroundings are darkened,
which shows the depth of a cloud (T. Luft, C. Colditz and O. Deussen, ACM Trans. Graph. 25 (2006) 1206).
"""
from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    from ..arrays import Array, Bools
    from .view import Window

LEAST = 0.8              # smallest radius of a sphere [pixels]
LIGHT = np.array([-0.45, 0.55, 0.70]) / np.linalg.norm([-0.45, 0.55, 0.70])   # right, up, towards the viewer
AMBIENT, DIFFUSE, SHINE = 0.50, 0.62, 0.10
SHADOW = 0.45            # fraction of the light that a shadow removes
DARKEST = 0.45           # greatest fraction of the colour that depth darkening removes
GRAIN = 1.3              # radius of a sphere in the buffer of the light [pixels]
MOST_LIGHT = 3000        # pixels along a side of that buffer


@dataclass
class Balls:
    """Spheres in the directions right, up and towards the viewer, with one unit of length."""

    right: Array                                       # (n)
    up: Array                                          # (n)
    near: Array                                        # (n), larger is nearer to the viewer
    radius: Array                                      # (n)
    tint: Array                                        # (n, 3) red, green, blue from 0 to 1


@dataclass
class Skin:
    """A surface that is drawn instead of the spheres inside it (surface.cast)."""

    loose: Bools                                       # (n) spheres that are drawn
    near: Array                                        # (height, width), larger is nearer, -inf where there is none
    look: Array                                        # (m, 6) normal and colour of its pixels, row by row


def disc_offsets(reach: int) -> list[tuple[int, int]]:
    """Pairs of integers within a square around a pixel, without the corners that no sphere reaches."""
    steps = range(-reach, reach + 1)
    return [(i, j) for i in steps for j in steps
            if max(abs(i) - 1, 0) ** 2 + max(abs(j) - 1, 0) ** 2 < (reach + 1) ** 2]


def put(depth: Array, owner: Array, number: int, column: float, row: float, near: float, radius: float) -> None:
    """Draw one sphere into depth and owner (height, width): what `splat` does with few large spheres."""
    high, wide = depth.shape
    reach = math.ceil(radius)
    columns = slice(max(math.floor(column) - reach, 0), min(math.floor(column) + reach + 1, wide))
    rows = slice(max(math.floor(row) - reach, 0), min(math.floor(row) + reach + 1, high))
    apart = (np.arange(columns.start, columns.stop) + 0.5 - column) ** 2 \
        + (np.arange(rows.start, rows.stop)[:, None] + 0.5 - row) ** 2
    height = near + np.sqrt(np.maximum(radius ** 2 - apart, 0.0))
    front = (apart < radius ** 2) & (height > depth[rows, columns])
    depth[rows, columns][front] = height[front]
    owner[rows, columns][front] = number


def splat(column: Array, row: Array, near: Array, radius: Array, shape: tuple[int, int]) -> tuple[Array, Array]:
    """Depth and index of the foremost sphere in each pixel of an image (height, width); -inf and -1 where there is
    none.

    Positions and radii are in pixels, rows count downwards.
    """
    high, wide = shape
    depth, owner = np.full(high * wide, -np.inf), np.full(high * wide, -1, np.int32)
    reach = np.ceil(radius).astype(int)
    for size in np.unique(reach):
        chosen = np.flatnonzero((reach == size) & (column > -size) & (column < wide + size)
                                & (row > -size) & (row < high + size))
        if not len(chosen):
            continue
        offsets = disc_offsets(int(size))
        if len(chosen) < len(offsets):                   # a loop over the fewer of spheres and pixels of one
            for number in chosen:
                put(depth.reshape(shape), owner.reshape(shape), int(number), column[number], row[number], near[number],
                    radius[number])
            continue
        c, r, z, squared = column[chosen], row[chosen], near[chosen], radius[chosen] ** 2
        c0, r0 = np.floor(c).astype(int), np.floor(r).astype(int)
        for i, j in offsets:
            apart = (c0 + i + 0.5 - c) ** 2 + (r0 + j + 0.5 - r) ** 2
            inside = ((apart < squared) & (c0 + i >= 0) & (c0 + i < wide) & (r0 + j >= 0) & (r0 + j < high))
            rows = np.flatnonzero(inside)
            pixel = (r0[rows] + j) * wide + c0[rows] + i
            height = z[rows] + np.sqrt(squared[rows] - apart[rows])
            front = height > depth[pixel]
            rows, pixel, height = rows[front], pixel[front], height[front]
            np.maximum.at(depth, pixel, height)
            won = height == depth[pixel]
            owner[pixel[won]] = chosen[rows[won]]
    return depth.reshape(shape), owner.reshape(shape)


def box_mean(image: Array, reach: int) -> Array:
    """Mean over a square of 2 reach + 1 pixels, edges repeated."""
    for axis in (0, 1):
        padded = np.pad(image, [(reach + 1, reach) if k == axis else (0, 0) for k in (0, 1)], mode="edge")
        total = np.cumsum(padded, axis=axis, dtype="f8")
        count = image.shape[axis]
        ends = (slice(2 * reach + 1, 2 * reach + 1 + count), slice(0, count))
        image = ((total[ends[0]] - total[ends[1]]) if axis == 0 else (total[:, ends[0]] - total[:, ends[1]]))
        image = image / (2 * reach + 1)
    return image


def depth_shade(depth: Array, drawn: Bools, reach: int, scale: float) -> Array:
    """Factor of the colour, below 1 where a pixel is deeper than the mean of its surroundings."""
    if not drawn.any():
        return np.ones(depth.shape)
    level = np.where(drawn, depth, depth[drawn].min() - scale)
    behind = np.zeros(depth.shape)
    for size, weight in ((reach, 0.6), (4 * reach, 0.4)):
        mean = box_mean(box_mean(level, size), size)
        behind += weight * np.clip((mean - level) / scale, 0.0, 1.0)
    return 1.0 - DARKEST * behind


def light_axes() -> tuple[Array, Array, Array]:
    """Two directions normal to the light, and the direction of the light, in right, up and near."""
    across = np.cross([0.0, 1.0, 0.0], LIGHT)
    across /= np.linalg.norm(across)
    return across, np.cross(LIGHT, across), LIGHT


def lit_share(balls: Balls, points: Array) -> Array:
    """Fraction of the light that reaches points (m, 3), 0 in a full shadow."""
    axes = light_axes()
    centres = np.stack([balls.right, balls.up, balls.near], axis=1)
    seen = [centres @ axis for axis in axes]
    typical = float(np.median(balls.radius))
    low = [float((side - balls.radius).min()) for side in seen[:2]]
    span = max(float((side + balls.radius).max()) - edge for side, edge in zip(seen[:2], low))
    pixel = max(typical / GRAIN, span / MOST_LIGHT)
    high, wide = (int((float((side + balls.radius).max()) - edge) / pixel) + 2
                  for side, edge in zip(seen[1::-1], low[::-1]))
    buffer, _ = splat((seen[0] - low[0]) / pixel, (seen[1] - low[1]) / pixel, seen[2] / pixel,
                      np.maximum(balls.radius / pixel, LEAST), (high, wide))
    place = [(points @ axes[k] - low[k]) / pixel for k in (0, 1)]
    height, share = (points @ axes[2]) / pixel, np.zeros(len(points))
    for i, j in ((0, 0), (1, 0), (-1, 0), (0, 1), (0, -1)):
        column = np.clip(np.floor(place[0]).astype(int) + i, 0, wide - 1)
        row = np.clip(np.floor(place[1]).astype(int) + j, 0, high - 1)
        share += buffer[row, column] <= height + 2.0 + typical / pixel
    return share / 5.0


class Image:
    """An image of spheres, with a surface or without: the window is left, right, bottom, top in their unit."""

    def __init__(self, wide: int, high: int, window: Window, balls: Balls, skin: Skin | None = None) -> None:
        self.shape, self.window = (high, wide), window
        self.pixel = (window[1] - window[0]) / wide
        left, top = window[0], window[3]
        column, row = (balls.right - left) / self.pixel, (top - balls.up) / self.pixel
        radius = np.maximum(balls.radius / self.pixel, LEAST)
        rows = np.flatnonzero(skin.loose) if skin else np.arange(len(radius))
        self.depth, owner = splat(column[rows], row[rows], balls.near[rows] / self.pixel, radius[rows], self.shape)
        look = np.zeros((high, wide, 6))               # normal and colour
        pixel_row, pixel_column = np.nonzero(owner >= 0)
        ball = rows[owner[owner >= 0]]
        right = (pixel_column + 0.5 - column[ball]) / radius[ball]
        up = (row[ball] - pixel_row - 0.5) / radius[ball]
        near = np.sqrt(np.maximum(1.0 - right ** 2 - up ** 2, 0.0))
        look[pixel_row, pixel_column] = np.hstack([np.stack([right, up, near], axis=1), balls.tint[ball]])
        if skin:
            front = skin.near / self.pixel > self.depth
            look[front] = skin.look[front[skin.near > -np.inf]]
            self.depth = np.where(front, skin.near / self.pixel, self.depth)
        self.drawn = self.depth > -np.inf
        self.colour = np.ones((high, wide, 3))
        if self.drawn.any():
            self.colour[self.drawn] = self.shaded(balls, *look[self.drawn].T)

    def shaded(self, balls: Balls, right: Array, up: Array, near: Array, *tint: Array) -> Array:
        """Colours (m, 3) of the drawn pixels from their normals and colours."""
        pixel_row, pixel_column = np.nonzero(self.drawn)
        facing = np.maximum(right * LIGHT[0] + up * LIGHT[1] + near * LIGHT[2], 0.0)
        points = np.stack([self.window[0] + (pixel_column + 0.5) * self.pixel,
                           self.window[3] - (pixel_row + 0.5) * self.pixel,
                           self.depth[self.drawn] * self.pixel], axis=1)
        light = facing * (1.0 - SHADOW * (1.0 - lit_share(balls, points)))
        across = max(self.shape) / 400.0
        scale = 0.08 * min(self.shape)
        shade = depth_shade(self.depth, self.drawn, max(2, int(2.0 * across)), scale)[self.drawn]
        half = LIGHT + np.array([0.0, 0.0, 1.0])
        half /= np.linalg.norm(half)
        shine = SHINE * np.maximum(right * half[0] + up * half[1] + near * half[2], 0.0) ** 24
        lit = np.stack(tint, axis=1) * ((AMBIENT + DIFFUSE * light) * shade)[:, None]
        return np.asarray(np.clip(lit + shine[:, None], 0.0, 1.0))

    def place(self, points: Array) -> Array:
        """Column, row and depth in pixels of points (m, 3) in right, up and near."""
        return np.stack([(points[..., 0] - self.window[0]) / self.pixel,
                         (self.window[3] - points[..., 1]) / self.pixel, points[..., 2] / self.pixel], axis=-1)

    def facet(self, corners: Array, tint: Any, opacity: float) -> None:
        """Blend a plane convex polygon with corners (n, 3) over the image behind it."""
        spots = self.place(corners)
        for second in range(1, len(spots) - 1):
            self.triangle(spots[[0, second, second + 1]], np.asarray(tint), opacity)

    def triangle(self, spots: Array, tint: Any, opacity: float) -> None:
        """Blend a triangle with corners (3, 3) in pixels."""
        high, wide = self.shape
        first = np.maximum(np.floor(spots[:, :2].min(axis=0)).astype(int), 0)
        last = np.minimum(np.ceil(spots[:, :2].max(axis=0)).astype(int), (wide, high))
        if (last <= first).any():
            return
        column, row = np.meshgrid(np.arange(first[0], last[0]) + 0.5, np.arange(first[1], last[1]) + 0.5)
        one, two = spots[1, :2] - spots[0, :2], spots[2, :2] - spots[0, :2]
        area = one[0] * two[1] - one[1] * two[0]
        if abs(area) < 1.0e-9:
            return
        b = ((column - spots[0, 0]) * two[1] - (row - spots[0, 1]) * two[0]) / area
        c = ((row - spots[0, 1]) * one[0] - (column - spots[0, 0]) * one[1]) / area
        near = spots[0, 2] + b * (spots[1, 2] - spots[0, 2]) + c * (spots[2, 2] - spots[0, 2])
        part = slice(first[1], last[1]), slice(first[0], last[0])
        seen = (b >= 0.0) & (c >= 0.0) & (b + c < 1.0) & (near > self.depth[part])
        self.colour[part] = np.where(seen[..., None], (1.0 - opacity) * self.colour[part] + opacity * tint,
                                     self.colour[part])

    def line(self, start: Array, end: Array, tint: Sequence[float], width: float = 2.0) -> None:
        """A line between two points, hidden where spheres are in front of it."""
        spots = self.place(np.array([start, end]))
        count = int(2.0 * np.abs(spots[1, :2] - spots[0, :2]).max()) + 2
        if count > 20 * max(self.shape):
            return
        way = spots[0] + np.linspace(0.0, 1.0, count)[:, None] * (spots[1] - spots[0])
        reach = int(np.ceil(0.5 * width))
        for i in range(-reach, reach):
            for j in range(-reach, reach):
                column, row = np.floor(way[:, 0] + i + 0.5).astype(int), np.floor(way[:, 1] + j + 0.5).astype(int)
                held = (column >= 0) & (column < self.shape[1]) & (row >= 0) & (row < self.shape[0])
                column, row, near = column[held], row[held], way[held, 2]
                seen = near > self.depth[row, column]
                self.colour[row[seen], column[seen]] = tint

    def halved(self, factor: int) -> Array:
        """Bytes (height, width, 3) of the image, means over squares of `factor` pixels."""
        high, wide = (factor * (side // factor) for side in self.shape)
        blocks = self.colour[:high, :wide].reshape(high // factor, factor, wide // factor, factor, 3)
        return np.asarray(255.0 * blocks.mean(axis=(1, 3)) + 0.5).astype("u1")
