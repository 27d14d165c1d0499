# SPDX-License-Identifier: BSD-3-Clause
"""Areal density of a snapshot along a line of sight.

The mass of every particle is distributed by a tent function as wide as its current size, or over the gaps between
particles that moved apart (see `smear`). The tent is integrated exactly over the pixels, so the mass in the image is
that of the particles to round-off. In axisymmetry the mass is first distributed in (r, z), and every thin annulus is
then projected exactly (Abel transform of a uniform annulus, integrated over the pixels), so there is no noise from
caustics. 3-D models are mirrored at their planes of symmetry.
"""
from __future__ import annotations

import dataclasses
import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from ..errors import EXIT_USAGE, ScreeError, unknown
from .shape import images, particle_size, slice_depth
from .smear import smeared

if TYPE_CHECKING:
    from ..arrays import Array
    from ..files import Snapshot
    from .view import Window

MOVING = 0.05            # material faster than this fraction of the greatest speed counts as flying
LEADING = 1.0e-3         # fraction of the flying mass ahead of the leading edge
MOST_DOTS = 200000       # greatest number of particles of a snapshot that are drawn individually
LARGEST_IMAGE = 40000000 # pixels


@dataclass
class Frame:
    """The radiograph of one snapshot and the data that are drawn with it."""

    time: float            # [s]
    sigma: Array         # areal density (vertical, horizontal) [kg/m2]
    box: Window            # left, right, bottom, top of the image [m]
    pixel: float           # [m]
    mass: float            # of the particles and their mirror images [kg]
    front: float           # position of the leading edge [m]
    speed: float           # of the leading edge [m/s]
    dots: dict[str, Array]            # particles of the lowest row
    names: list[str]           # of the bodies
    vertical: str          # name of the vertical axis

    @property
    def mass_error(self) -> float:
        """Relative difference between the mass in the image and that of the particles."""
        image = float(self.sigma.sum()) * self.pixel ** 2
        return abs(image - self.mass) / self.mass if self.mass > 0.0 else 0.0


def tent_moments(u: Array) -> tuple[Array, Array]:
    """Integrals from -1 to u of the tent K(t) = 1 - |t| and of t K(t)."""
    u = np.clip(u, -1.0, 1.0)
    total = np.where(u < 0.0, 0.5 * (1.0 + u) ** 2, 1.0 - 0.5 * (1.0 - u) ** 2)
    first = np.where(u < 0.0, u ** 2 / 2 + u ** 3 / 3, u ** 2 / 2 - u ** 3 / 3) - 1.0 / 6.0
    return total, first


def tent_weights(position: Array, half: Array, low: float, pixel: float, count: int, radial: bool) -> tuple[Array,
                 Array]:
    """First pixel, and fractions in the pixels under each tent; `radial` weights the tent by radius."""
    first = np.floor((position - half - low) / pixel).astype(np.int64)
    index = first[:, None] + np.arange(count + 1)
    total, moment = tent_moments((low + index * pixel - position[:, None]) / half[:, None])
    weight = np.diff(total, axis=1)
    index = index[:, :-1]
    if radial:  # low is 0 here; parts beyond the axis are folded back
        weight = position[:, None] * weight + half[:, None] * np.diff(moment, axis=1)
        weight = np.where(index < 0, -weight, weight)
        weight /= weight.sum(axis=1, keepdims=True)
        index = np.where(index < 0, -1 - index, index)
    return index, weight


def deposit(points: Sequence[Array], mass: Array, half: Array, low: Sequence[float], pixel: Sequence[float],
            shape: tuple[int, int], radial: bool = False) -> Array:
    """Spread particles over an image: mass in every pixel of an array of this shape [kg].

    points  (horizontal, vertical) positions; with `radial` the vertical one is the radius
    half    half width of the tent of each particle
    """
    image = np.zeros(shape[0] * shape[1])
    if len(mass) == 0:
        return image.reshape(shape)
    foot = [np.ceil(2.0 * half / pixel[d]).astype(np.int64) + 1 for d in (0, 1)]
    order = np.argsort(foot[0], kind="stable")
    begin = 0
    while begin < len(order):  # groups of particles of about the same size
        span = max(foot[0][order[begin]], 4)
        end = begin + int(np.searchsorted(foot[0][order[begin:]], 1.5 * span, side="right"))
        end = min(max(end, begin + 1), begin + max(1, int(2.0e6 / (1.5 * span) ** 2)))
        chosen = order[begin:end]
        (column, across), (row, along) = (
            tent_weights(points[d][chosen], half[chosen], low[d], pixel[d],
                         int(foot[d][chosen].max()), radial and d == 1) for d in (0, 1))
        # The tent of a small particle in a group of larger ones is continued with weights of zero.
        column, row = np.minimum(column, shape[1] - 1), np.minimum(row, shape[0] - 1)
        flat = row[:, :, None] * shape[1] + column[:, None, :]
        share = mass[chosen][:, None, None] * along[:, :, None] * across[:, None, :]
        image += np.bincount(flat.ravel(), share.ravel(), minlength=image.size)
        begin = end
    return image.reshape(shape)


def annulus_projection(radius_edges: Array, edges: Array) -> Array:
    """Fraction of the mass of each uniform annulus that projects onto each pixel (annulus, pixel).

    Integral of the Abel transform of a ring, m / (pi sqrt(r2 - x2)), over annulus and pixel: the fraction of a disc of
    radius r between the axis and x = u r is (asin u + u sqrt(1 - u2)) / pi.
    """
    outer = radius_edges[:, None]
    u = np.clip(edges[None, :] / np.where(outer > 0.0, outer, 1.0), -1.0, 1.0)
    disc = outer ** 2 * (np.arcsin(u) + u * np.sqrt(1.0 - u * u)) / math.pi
    ring = np.diff(disc, axis=0) / np.diff(radius_edges ** 2)[:, None]
    return np.diff(ring, axis=1)


def checked(snap: Snapshot) -> tuple[Array, Array]:
    """Mass and velocity of a snapshot; an error if it lacks the fields for a radiograph."""
    if snap.dimension == "1d":
        raise ScreeError(
            f"{snap.file}: a one-dimensional run has no radiograph", EXIT_USAGE
        )
    snap.need("mass", "volume", "velocity")
    if not (np.isfinite(snap.fields["mass"]).all() and np.isfinite(snap.points).all()):
        raise ScreeError(f"{snap.file}: mass or position is not a number in some particles")
    return snap.fields["mass"].astype("f8"), snap.fields["velocity"].astype("f8")


def leading_edge(position: Array, mass: Array, speed: Array, towards: float) -> tuple[float, float]:
    """Position and mean speed of the foremost flying material along the direction of flight."""
    if len(mass) == 0 or mass.sum() <= 0.0:
        return math.nan, math.nan
    ahead = speed * towards
    flying = ahead > MOVING * ahead.max() if ahead.max() > 0.0 else np.ones(len(mass), bool)
    order = np.argsort(-(position * towards)[flying], kind="stable")
    ordered = mass[flying][order]
    last = int(np.searchsorted(np.cumsum(ordered), LEADING * ordered.sum())) + 1
    front = order[:last]
    mean = np.average(speed[flying][front], weights=ordered[:last])
    return float(position[flying][front[-1]]), float(mean)


SMEARS = ("spacing", "volume")


def parts_of(snap: Snapshot, positions: Array, size: Array, smear: str) -> tuple[Array, Array, Array, Array]:
    """Rows, positions, mass fractions and half widths of the parts of particles to be drawn, see `smear`."""
    rows = np.arange(len(size))
    if smear == "volume" or len(size) == 0:
        return rows, positions, np.ones(len(size)), size
    plane = [0, 1, 2] if snap.dimension == "3d" else [0, 2]
    failed = snap.fields.get("failed")                   # separated intact material has the corresponding volume
    loose = np.ones(len(size), bool) if failed is None else failed >= 0.5
    rows, offsets, share, half = smeared(positions[:, plane], size, loose)
    moved = positions[rows]
    moved[:, plane] += offsets
    if snap.dimension == "axisymmetric":                 # parts beyond the axis are on the other side
        moved[:, 0] = np.abs(moved[:, 0])
    return rows, moved, share, half


def radiograph(snap: Snapshot, pixel: float, sight: str = "y", towards: float = 1.0, smear: str = "spacing") -> Frame:
    """The radiograph of a snapshot, line of sight along x or y, z to the right.

    With `smear` "volume" the width of every particle follows from its volume; with "spacing" separated particles are
    spread over the gaps between them.
    """
    if smear not in SMEARS:
        raise unknown("value of smear", smear, SMEARS)
    mass, velocity = checked(snap)
    round_model = snap.dimension == "axisymmetric"
    if snap.dimension == "plane_strain" and sight == "x":
        raise ScreeError("plane strain is seen along y only: --axis y", EXIT_USAGE)
    side = 1 if sight == "x" and not round_model else 0
    size = particle_size(snap)
    if round_model and (snap.points[:, 0] < 0.0).any():
        raise ScreeError(f"{snap.file}: axisymmetric particles at a negative radius")
    part, places, share, half = parts_of(snap, snap.points, size, smear)
    positions, rows, _ = images(snap)
    drawn, whose, _ = images(dataclasses.replace(snap, points=places))
    spread = (mass[part] * share)[whose]
    mass, size = mass[rows], size[rows]
    # Tents are not widened to a pixel: they are integrated over the pixels, and tents as wide as the spacing of the
    # particles add up to a uniform density, while wider ones do not.
    half = np.maximum(half[whose], 1.0e-3 * pixel)
    along, across = drawn[:, 2], drawn[:, side]
    reach = float(half.max()) if len(half) else pixel
    left, right = grid_range(along - half, along + half, pixel)
    low, high = grid_range(across - half, across + half, pixel)
    if round_model:
        high = grid_range(across, across + reach, pixel)[1]
        low = -high
    shape = (high - low, right - left)
    if shape[0] * shape[1] > LARGEST_IMAGE:
        raise ScreeError(f"--pixel {pixel * 1.0e3:g}: {shape[1]} x {shape[0]} pixels are too many",
                        EXIT_USAGE)
    if round_model:
        rings = deposit((along, across), spread, half, (left * pixel, 0.0), (pixel, 0.5 * pixel),
                        (2 * high, shape[1]), radial=True)
        share = annulus_projection(
            0.5 * pixel * np.arange(2 * high + 1), pixel * np.arange(high + 1)
        )
        right_half = share.T @ rings
        image = np.concatenate([right_half[::-1], right_half])
    else:
        image = deposit(
            (along, across), spread, half, (left * pixel, low * pixel), (pixel, pixel), shape
        )
    front, speed = leading_edge(positions[:, 2], mass, velocity[rows, 2], towards)
    return Frame(
        time=snap.time,
        sigma=image / pixel**2,
        pixel=pixel,
        mass=float(mass.sum()),
        box=(left * pixel, right * pixel, low * pixel, high * pixel),
        front=front,
        speed=speed,
        dots=dots(snap, positions, size, rows, side),
        names=[body.get("name", "") for body in snap.bodies],
        vertical="r" if round_model else "xy"[side],
    )


def grid_range(lows: Array, highs: Array, pixel: float) -> tuple[int, int]:
    """First and last pixel edge, counted from 0, around all tents."""
    if len(lows) == 0:
        return 0, 1
    return math.floor(lows.min() / pixel) - 1, math.ceil(highs.max() / pixel) + 1


def dots(snap: Snapshot, positions: Array, size: Array, rows: Array, side: int) -> dict[str, Array]:
    """Particles of the lowest row: those of a meridional slice, mirrored in r in axisymmetry."""
    across, along = positions[:, side], positions[:, 2]
    if snap.dimension == "3d" and len(size):
        depth = positions[:, 1 - side]
        thickness = np.maximum(1.01 * size, 1.5 * np.median(size))
        keep = np.abs(depth - slice_depth(snap, 1 - side, depth)) <= thickness
    else:
        keep = np.ones(len(across), bool)
    chosen = np.flatnonzero(keep)
    if len(chosen) > MOST_DOTS:                          # the same selection in every call
        chosen = np.sort(np.random.default_rng(1).choice(chosen, MOST_DOTS, replace=False))
    source = rows[chosen]
    failed = snap.fields.get("failed", snap.fields.get("damage", np.zeros(len(snap.points))))
    found = {"along": along[chosen], "across": across[chosen], "size": size[chosen],
             "body": snap.body_rows()[source], "failed": failed[source] >= 0.999}
    if snap.dimension == "axisymmetric":
        found = {name: np.concatenate([values, -values if name == "across" else values])
                 for name, values in found.items()}
    return found
