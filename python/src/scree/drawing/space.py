# SPDX-License-Identifier: BSD-3-Clause
"""Pages of a run in three dimensions: shaded spheres drawn by `render`, scale bar and axes by matplotlib.

The projection is parallel, so that the scale bar is valid everywhere and all particles are drawn to scale.
"""
from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from . import colour as colours
from . import look, render, surface
from .radiograph_page import scale_bar
from .view import matter
from .walls import STYLES, at_time, is_seen, walls_of

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from ..arrays import Array
    from ..files import Snapshot
    from .view import Matter, Options, Window

ABOVE, BELOW = 0.65, 0.65                                # margins above and below the picture [inch]
SHARP = 2                # pixels of the image per pixel of the page, along each side
SPREAD = 1.15            # of spheres over the spacing of particles
MOVING = 0.05            # fraction of the greatest speed above which a particle counts as moving
# if all particles extend this many times farther than the moving ones, the moving ones define the window
FARTHER = 2.0
WALL = 0.25              # opacity of rigid regions
LINE = 0.012             # width of edges [inch]


def basis(azimuth: float, elevation: float, up: int = 2) -> tuple[Array, Array, Array]:
    """Unit vectors to the right, up and towards the camera; `up` is the axis that points up at elevation 0."""
    turn, lift = math.radians(azimuth), math.radians(elevation)
    towards = np.array([math.cos(lift) * math.cos(turn), math.cos(lift) * math.sin(turn),
                        math.sin(lift)])
    right = np.array([-math.sin(turn), math.cos(turn), 0.0])
    place = [(axis - up + 2) % 3 for axis in range(3)]    # with x up: x, y, z are the third, first and second
    return right[place], np.cross(towards, right)[place], towards[place]


class SpacePage:
    """Pages of a run in three dimensions, all with the same window and colours."""

    def __init__(self, snaps: Sequence[Snapshot], options: Options) -> None:
        self.options = options
        self.plot = look.pyplot()
        self.walls = walls_of(snaps[-1]) if options.walls else []
        self.box = self.window([matter(snap, options) for snap in snaps])
        self.metres, self.unit = look.scaled(max(self.box[1] - self.box[0],
                                                 self.box[3] - self.box[2]), "m")

    def camera(self, share: float) -> tuple[Array, Array, Array]:
        """Directions of the camera after this fraction of a film."""
        azimuth, elevation = self.options.camera
        return basis(azimuth + share * self.options.turn, elevation, self.options.up)

    def window(self, parts: Sequence[Matter]) -> Window:
        """Left, right, bottom, top of a window that contains all particles of these times at any rotation [m]."""
        if self.options.view:
            return self.options.view
        ends = [[math.inf, -math.inf], [math.inf, -math.inf]]
        shares = np.linspace(0.0, 1.0, 13) if self.options.turn else [0.0]
        for part in framed(parts):
            half = 0.5 * part.size
            for share in shares if len(half) else []:
                for pair, direction in zip(ends, self.camera(share)):
                    along = part.points @ direction
                    pair[0] = min(pair[0], float((along - half).min()))
                    pair[1] = max(pair[1], float((along + half).max()))
        if ends[0][0] > ends[0][1]:
            return -1.0, 1.0, -1.0, 1.0
        pad = 0.03 * max(high - low for low, high in ends)
        (left, right), (bottom, top) = [(0.5 * (low + high) - reach, 0.5 * (low + high) + reach) for low, high in ends
                                        for reach in [(0.5 * (high - low) + pad) / self.options.zoom]]
        return left, right, bottom, top

    def shape(self) -> tuple[float, float]:
        """Width and height of the picture inside the page [inch]."""
        across, tall = self.box[1] - self.box[0], self.box[3] - self.box[2]
        room = self.options.wide - 1.9
        scale = min(room / across, 7.5 / tall)
        return max(scale * across, 1.0), max(scale * tall, 1.0)

    def add_walls(self, image: render.Image, snap: Snapshot, axes: Array) -> None:
        """Rigid regions as transparent surfaces, closed boundaries as their edges."""
        rgb = self.plot.matplotlib.colors.to_rgb
        for wall in self.walls:
            pieces = at_time(wall, snap, self.options.mirror, snap.time)
            if not len(pieces) or not is_seen(wall, self.options.mirror):
                continue
            tint = rgb(STYLES.get(wall.kind, STYLES["slip"])[0])
            turned = pieces @ axes.T
            if wall.face == 0:
                for piece in turned[np.argsort(turned[..., 2].mean(axis=1))]:
                    image.facet(piece, tint, WALL)
            else:
                for start, end in outer_edges(turned):
                    image.line(start, end, tint, SHARP * LINE * self.options.dpi)

    def balls(self, part: Matter, share: float, snap: Snapshot) -> Array:
        """The picture of the spheres as bytes (height, width, 3)."""
        wide, high = (int(SHARP * self.options.dpi * side) for side in self.shape())
        axes = np.stack(self.camera(share))
        seen = part.points @ axes.T
        tints = colours.paint(self.options.colour, part.values)[:, :3]
        skin = render.Skin(*surface.cast(seen, part.size, tints, self.box, (high, wide))
                           ) if self.options.surface else None
        image = render.Image(wide, high, self.box, render.Balls(
            seen[:, 0], seen[:, 1], seen[:, 2], 0.5 * SPREAD * part.size, tints), skin)
        self.add_walls(image, snap, axes)
        return image.halved(SHARP)

    def draw(self, snap: Snapshot, share: float = 0.0) -> Figure:
        """The figure of one time."""
        part = matter(snap, self.options)
        image = self.balls(part, share, snap)
        wide, high = self.shape()
        page = (wide + 1.9, high + ABOVE + BELOW)
        figure: Figure = self.plot.figure(figsize=page)
        axes = figure.add_axes((0.15 / page[0], BELOW / page[1], wide / page[0], high / page[1]))
        k, box = self.metres, self.box
        left, right, bottom, top = (k * edge for edge in box)
        axes.imshow(image, extent=(left, right, bottom, top), interpolation="antialiased",
                    aspect="equal")
        axes.set_axis_off()
        self.scale(axes, high)
        self.triad(figure, page, share)
        slot = figure.add_axes(((wide + 0.2) / page[0], BELOW / page[1], 1.6 / page[0],
                                high / page[1]))
        slot.set_axis_off()
        self.colour_bar(figure, slot, page, wide, high)
        figure.text(0.15 / page[0], 1.0 - 0.1 / page[1], self.heading(part.time), va="top",
                    ha="left", fontsize=11, linespacing=1.4)
        return figure

    def heading(self, time: float) -> str:
        """Title and time."""
        factor, unit = self.options.clock
        head = f"{self.options.title}\n" if self.options.title else ""
        return f"{head}t = {factor * time:.4g} {unit}"

    def colour_bar(self, figure: Figure, slot: Axes, page: tuple[float, float], wide: float, high: float) -> None:
        """Colour bar, or the names of bodies."""
        if self.options.colour.names:
            colours.legend(figure, slot, self.options.colour)
            named = slot.get_legend()
            if named is not None:
                named.set_bbox_to_anchor((0.0, 1.0))
            return
        tall = min(high, 4.0)
        bar = figure.add_axes(((wide + 0.3) / page[0], (BELOW + 0.5 * (high - tall)) / page[1],
                               0.16 / page[0], tall / page[1]))
        colours.legend(figure, None, self.options.colour, bar)

    def scale(self, axes: Axes, high: float) -> None:
        """Scale bar below the picture."""
        k, box = self.metres, self.box
        length = scale_bar(0.25 * k * (box[1] - box[0]))
        left = k * box[0] + 0.03 * k * (box[1] - box[0])
        level = k * (box[2] - 0.3 * (box[3] - box[2]) / high)
        axes.plot([left, left + length], [level, level], color="black", linewidth=2.5,
                  solid_capstyle="butt", clip_on=False)
        axes.text(left + length, level, f"  {length:g} {self.unit}", ha="left", va="center", fontsize=10)
        axes.set_xlim(k * box[0], k * box[1])
        axes.set_ylim(k * box[2], k * box[3])

    def triad(self, figure: Figure, page: tuple[float, float], share: float) -> None:
        """The directions x, y, z, at the lower right."""
        side = 0.9
        axes = figure.add_axes((1.0 - side / page[0], 0.05 / page[1], side / page[0],
                                side / page[1]))
        right, up, towards = self.camera(share)
        for axis in np.argsort(towards):                 # those that point to the viewer on top
            x, y = right[axis], up[axis]
            axes.annotate("", (x, y), (0.0, 0.0), arrowprops={
                "arrowstyle": "-|>", "color": look.COLOURS[axis], "linewidth": 1.8,
                "shrinkA": 0, "shrinkB": 0})
            if math.hypot(x, y) > 0.2:
                axes.text(1.25 * x, 1.25 * y, "xyz"[axis], ha="center", va="center", fontsize=10)
        axes.set_xlim(-1.4, 1.4)
        axes.set_ylim(-1.4, 1.4)
        axes.set_axis_off()


def framed(parts: Sequence[Matter]) -> Sequence[Matter]:
    """Particles that define the window: the moving ones, where all others extend much farther."""
    moving = [part.rows(part.speed > MOVING * part.speed.max()) if len(part.size) and part.speed is not None
              and part.speed.max() > 0.0 else part for part in parts]
    spans = [np.ptp(np.concatenate([part.points for part in some]), axis=0) if any(len(part.size) for part in some)
             else np.zeros(3) for some in (moving, parts)]
    return moving if spans[1].max() > FARTHER * spans[0].max() > 0.0 else parts


def outer_edges(pieces: Array) -> list[tuple[Array, Array]]:
    """Edges of plane facets (m, n, 3) that belong to one facet only."""
    found: dict[Any, list[tuple[Array, Array]]] = {}
    for piece in pieces:
        for start, end in zip(piece, np.roll(piece, -1, axis=0)):
            key = tuple(sorted((tuple(np.round(start, 9)), tuple(np.round(end, 9)))))
            found.setdefault(key, []).append((start, end))
    return [ends[0] for ends in found.values() if len(ends) == 1]
