# SPDX-License-Identifier: BSD-3-Clause
"""Pages of particles: common parts of picture and movie."""
from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, ClassVar

import numpy as np

from ..errors import EXIT_USAGE, ScreeError, unknown
from . import colour as colours
from . import look, surface
from .shape import images, particle_size, plane_edges
from .walls import draw_plane, walls_of

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from ..arrays import Array, Bools
    from ..files import Snapshot
    from .colour import Colour

LEAST_DOT = 0.4          # smallest width of a particle on the page [points]
SPREAD = 1.02            # of drawn particles over their width, so that there are no gaps between them
BELOW = 1.15             # of a layer below, for neighbours that moved apart by less than their width


Window = tuple[float, float, float, float]              # left, right, bottom, top [m]


@dataclass
class Options:
    """Options for drawing particles; lengths in m."""

    colour: Colour
    mirror: bool = True
    bodies: tuple[str, ...] = ()                                 # names; all if empty
    hide_failed: bool = False
    view: Window | tuple[()] = ()                                  # left, right, bottom, top
    title: str = ""
    dpi: int = 150
    wide: float = 9.0                                    # of the page [inch]
    camera: tuple[float, float] = (-60.0, 20.0)                        # azimuth, elevation [deg]; 3-D only
    up: int = 2                                          # axis that points up; 3-D only
    turn: float = 0.0                                    # of the camera over a film [deg]
    zoom: float = 1.0
    keep: tuple[int, float, float] | tuple[()] = ()                                   # axis, sign, position; 3-D only
    clock: tuple[float, str] = (1.0, "s")                            # factor and unit of the time
    walls: bool = True                                   # draw rigid regions and closed boundaries
    surface: bool = False                                # of solids and heaps, instead of their particles


@dataclass
class Matter:
    """Particles to be drawn, including mirror images."""

    time: float                                          # [s]
    points: Array                                      # (n, 3) [m]
    size: Array                                        # (n) [m]
    values: Array                                      # (n) values for the colours [SI]
    edges: Array | None = None                                 # (n, 2, 2) in two dimensions, see shape
    speed: Array | None = None                                 # (n) [m/s], None where the file holds no velocity

    def rows(self, chosen: Bools) -> Matter:
        """A subset of the particles."""
        return Matter(self.time, self.points[chosen], self.size[chosen], self.values[chosen],
                      None if self.edges is None else self.edges[chosen],
                      None if self.speed is None else self.speed[chosen])


def fields_for(name: str, hide_failed: bool = False) -> set[str]:
    """Fields that a picture needs."""
    return {colours.field_of(name)[0], "body", "volume", "mass", "deformation_gradient"} | (
        {"fragment"} if name == "fragment_size" else {"velocity"} if name == "speed" else set()) | (
        {"failed", "damage"} if hide_failed else set())


def failed_of(snap: Snapshot) -> Bools:
    """True for each particle that has failed."""
    mark = snap.fields.get("failed", snap.fields.get("damage"))
    return np.zeros(len(snap.points), bool) if mark is None else np.asarray(mark) >= 0.999


def chosen_rows(snap: Snapshot, options: Options) -> Bools:
    """Particles of the requested bodies."""
    keep = np.ones(len(snap.points), bool)
    if options.bodies:
        names = [snap.body_name(row) for row in range(max(1, len(snap.bodies)))]
        for name in options.bodies:
            if name not in names:
                raise unknown("body", name, names, snap.file)
        keep &= np.isin(snap.body_rows(), [names.index(name) for name in options.bodies])
    if options.hide_failed:
        if "failed" not in snap.fields and "damage" not in snap.fields:
            snap.need("failed")
        keep &= ~failed_of(snap)
    return keep


def matter(snap: Snapshot, options: Options) -> Matter:
    """The particles of a snapshot that are to be drawn."""
    snap.need("volume")
    keep = chosen_rows(snap, options)
    values = colours.values_of(snap, options.colour.name)
    size = particle_size(snap)
    points, rows = snap.points, np.arange(len(snap.points))
    signs = np.ones((len(rows), 3))
    if options.mirror:
        points, rows, signs = images(snap)
    pick = keep[rows] & np.isfinite(points).all(axis=1)
    if options.keep:
        axis, sign, place = options.keep
        pick &= sign * (points[:, axis] - place) >= 0.0
    points, rows, signs = points[pick], rows[pick], signs[pick]
    edges = None
    if snap.dimension in ("plane_strain", "axisymmetric"):
        edges = plane_edges(snap, size)[rows] * signs[:, None, [0, 2]]
    if snap.dimension == "axisymmetric" and options.mirror:
        points = np.concatenate([points, points * (-1.0, 1.0, 1.0)])
        rows = np.concatenate([rows, rows])
        edges = None if edges is None else np.concatenate([edges, edges * (-1.0, 1.0)])
    velocity = snap.fields.get("velocity")
    speed = None if velocity is None else np.linalg.norm(velocity[rows], axis=1)
    return Matter(snap.time, points, size[rows], values[rows], edges, speed)


def bounds(parts: Sequence[Matter], plane: tuple[int, int] = (0, 2)) -> Window:
    """Left, right, bottom, top around all particles, with a margin [m]."""
    ends = []
    for axis in plane:
        low = [(part.points[:, axis] - 0.5 * part.size).min() for part in parts if len(part.size)]
        high = [(part.points[:, axis] + 0.5 * part.size).max() for part in parts if len(part.size)]
        ends += [min(low), max(high)] if low else [-1.0, 1.0]
    pad = 0.03 * max(ends[1] - ends[0], ends[3] - ends[2])
    return ends[0] - pad, ends[1] + pad, ends[2] - pad, ends[3] + pad


def check_view(view: Sequence[float] | None) -> None:
    """Refuse a window whose ends are in the wrong order."""
    if view and not (view[0] < view[1] and view[2] < view[3]):
        raise ScreeError("--view needs LEFT < RIGHT and BOTTOM < TOP", EXIT_USAGE)


class PlanePage:
    """Pages of a run in one or two dimensions, all with the same axes and colours."""

    names: ClassVar[dict[str, tuple[str, str]]] = {"axisymmetric": ("r", "z"), "plane_strain": ("x", "z"),
                                                   "1d": ("x", "z")}

    def __init__(self, snap: Snapshot, options: Options, box: Window) -> None:
        self.options, self.dimension = options, snap.dimension
        self.walls = walls_of(snap) if options.walls else []
        self.box = options.view or box
        self.metres, self.unit = look.scaled(max(abs(edge) for edge in self.box), "m")
        self.plot = look.pyplot()

    def shape(self) -> tuple[float, float]:
        """Width and height of the page [inch]."""
        across, tall = self.box[1] - self.box[0], self.box[3] - self.box[2]
        if self.dimension == "1d":
            return self.options.wide, 3.0
        room = self.options.wide - 2.4                   # without labels and colour bar
        high = room * tall / across
        if high > 9.0:
            return max(9.0 * across / tall + 2.4, 4.5), 10.2
        return self.options.wide, max(high, 1.6) + 1.2

    def draw(self, snap: Snapshot, _share: float = 0.0) -> Figure:
        """The figure of one time."""
        part = matter(snap, self.options)
        figure: Figure
        figure, axes = self.plot.subplots(figsize=self.shape(), layout="constrained")
        if self.dimension == "1d":
            self.line(axes, part)
        else:
            self.dots(figure, axes, part)
            draw_plane(axes, self.walls, snap, self.options, self.metres)
            colours.legend(figure, axes, self.options.colour)
        factor, unit = self.options.clock
        head = f"{self.options.title}\n" if self.options.title else ""
        axes.set_title(f"{head}t = {factor * part.time:.4g} {unit}", fontsize=11)
        return figure

    def dots(self, figure: Figure, axes: Axes, part: Matter) -> None:
        """Particles as large as their volume: squares, or deformed squares."""
        from matplotlib.collections import PolyCollection
        k, box = self.metres, self.box
        if self.options.surface and len(part.size):
            part = part.rows(self.surface(axes, part))
        wide, _ = figure.get_size_inches()
        least = LEAST_DOT / 72.0 / wide * (box[1] - box[0])
        middle = part.points[:, [0, 2]]
        edges = np.zeros((0, 2, 2)) if part.edges is None else part.edges
        tints = colours.paint(self.options.colour, part.values)
        for layer, spread in ((0.95, BELOW), (1.0, SPREAD)):
            grown = np.maximum(spread, least / np.maximum(part.size, 1.0e-300))
            one, two = (0.5 * grown[:, None] * edges[:, row] for row in (0, 1))
            corners = np.stack([middle - one - two, middle + one - two, middle + one + two,
                                middle - one + two], axis=1)
            axes.add_collection(PolyCollection(list(k * corners), facecolors=tints, linewidths=0.0,
                                               antialiaseds=False, rasterized=True, zorder=layer))
        axes.set_xlim(k * box[0], k * box[1])
        axes.set_ylim(k * box[2], k * box[3])
        axes.set_aspect("equal")
        axes.set_facecolor("#f4f4f4")
        names = self.names[self.dimension]
        axes.set_xlabel(f"{names[0]} [{self.unit}]")
        axes.set_ylabel(f"{names[1]} [{self.unit}]")

    def surface(self, axes: Axes, part: Matter) -> Bools:
        """Draw the surface of what is filled; returns the loose particles, which are outside."""
        edges = part.size[:, None, None] * np.eye(2) if part.edges is None else part.edges
        tints = colours.paint(self.options.colour, part.values)[:, :3]
        return surface.draw(axes, part.points[:, [0, 2]], edges, part.size, tints, self.metres)

    def line(self, axes: Axes, part: Matter) -> None:
        """A run in one dimension: the field along x."""
        colour = self.options.colour
        axes.plot(self.metres * part.points[:, 0], colour.factor * part.values, ".",
                  color=look.COLOURS[0], markersize=3)
        axes.set_xlim(self.metres * self.box[0], self.metres * self.box[1])
        pad = 0.03 * (colour.high - colour.low)
        axes.set_ylim(colour.low - pad, colour.high + pad)
        axes.set_xlabel(f"x [{self.unit}]")
        axes.set_ylabel(look.with_unit(colour.label, colour.unit))
        axes.grid(color="#dddddd", linewidth=0.6)


def to_pixels(figure: Figure, dpi: float) -> Array:
    """The picture of a figure as bytes (height, width, 4)."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    figure.set_dpi(dpi)
    canvas = FigureCanvasAgg(figure)
    look.plain_texts(figure)
    canvas.draw()  # type: ignore[no-untyped-call]
    pixels = np.asarray(canvas.buffer_rgba()).copy()  # type: ignore[no-untyped-call]
    look.pyplot().close(figure)
    return pixels
