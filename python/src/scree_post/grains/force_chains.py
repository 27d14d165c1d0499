# SPDX-License-Identifier: BSD-3-Clause
"""Grains as circles and contact forces as lines, with the edges of the periodic cell."""
from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from scree import units as units_of
from scree.drawing import look
from scree.errors import ScreeError
from scree.files import open_file

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from scree.arrays import Array

WIDEST = 5.0             # line of the greatest forces [points]


def read_pair(grains: str, contacts: str) -> tuple[Array, Array, Array, Array, Array, Array, float]:
    """Positions, radii and numbers of contacts of grains; ends and normal forces of contacts; edges."""
    with open_file(grains) as handle:
        data = handle.get("VTKHDF/PointData", {})
        if "radius" not in data or "VTKHDF/FieldData/edges" not in handle:
            raise ScreeError(f"{grains} is not a file of grains: it has no radius or no edges")
        places = units_of.data_si(handle["VTKHDF/Points"])
        radii, touched = units_of.data_si(data["radius"]), units_of.data_si(data["contacts"])
        edges = units_of.data_si(handle["VTKHDF/FieldData/edges"])
        time = float(np.ravel(units_of.data_si(handle["VTKHDF/FieldData/TimeValue"]))[0])
    with open_file(contacts) as handle:
        ends = units_of.data_si(handle["VTKHDF/Points"]).reshape(-1, 2, 3)
        force = units_of.data_si(handle["VTKHDF/CellData/normal_force"])
    return places, radii, touched, edges, ends, force, time


def wrapped(places: Array, edges: Array) -> Array:
    """Positions in the cell."""
    inverse = np.linalg.inv(edges)
    share = places @ inverse
    return (share - np.floor(share)) @ edges


def draw_chains(axes: Axes, grains: str, contacts: str) -> float:
    """Draw a cell of discs, or the spheres near the middle plane, viewed along z. The result is the time [s]."""
    from matplotlib.collections import EllipseCollection, LineCollection
    places, radii, touched, edges, ends, force, time = read_pair(grains, contacts)
    scale, unit = look.scaled(float(np.abs(edges[0]).max()), "m")
    places = wrapped(places, edges)
    flat = not np.any(np.abs(places[:, 2] - places[0, 2]) > 0.0)
    if not flat:
        middle = 0.5 * edges[2, 2]
        near = np.abs(places[:, 2] - middle) < 1.5 * radii.mean()
        places, radii, touched = places[near], radii[near], touched[near]
        near = np.abs(ends[:, :, 2].mean(axis=1) - middle) < 1.5 * radii.mean()
        ends, force = ends[near], force[near]
    held = touched >= (2 if flat else 3)
    for chosen, tint in ((held, "#d9dde1"), (~held, "#f3f4f5")):
        if chosen.any():
            size = 2.0 * scale * radii[chosen]
            axes.add_collection(EllipseCollection(size, size, np.zeros(len(size)), units="xy", facecolors=tint,
                                                  edgecolors="#b5bbc1", linewidths=0.4,
                                                  offsets=scale * places[chosen, :2], offset_transform=axes.transData))
    if len(force):
        order = np.argsort(force)
        share = np.clip(force[order] / max(np.quantile(force, 0.99), 1.0e-300), 0.0, 1.0)
        axes.add_collection(LineCollection(list(scale * ends[order][:, :, :2]), linewidths=WIDEST * share,
                                           colors=look.COLOURS[1], capstyle="round"))
    corner = np.array([[0.0, 0.0], edges[0, :2], edges[0, :2] + edges[1, :2], edges[1, :2], [0.0, 0.0]])
    axes.plot(*(scale * corner).T, color=look.COLOURS[6], linewidth=1.2)
    axes.set_aspect("equal")
    axes.autoscale_view()
    axes.set(xlabel=f"x [{unit}]", ylabel=f"y [{unit}]")
    axes.spines[["top", "right"]].set_visible(False)
    return time


def picture(grains: str, contacts: str, title: str) -> Figure:
    """A page with a cell."""
    figure: Figure
    figure, axes = look.pyplot().subplots(figsize=(7.2, 6.4), layout="constrained")
    time = draw_chains(axes, grains, contacts)
    factor, unit = look.scaled(time, "s")
    axes.set_title(f"{title}, t = {factor * time:.4g} {unit}; width of lines: normal force")
    return figure
