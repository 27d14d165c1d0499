# SPDX-License-Identifier: BSD-3-Clause
"""The page of a preview: bodies, walls, boundaries with their types, and cells of a scene."""
from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from scree.drawing import colour as colours
from scree.drawing import look, render
from scree.drawing.box import Edges, box_of
from scree.drawing.space import SpacePage
from scree.drawing.view import Options, PlanePage, matter
from scree.drawing.walls import STYLES, draw_plane, walls_of
from scree.errors import ScreeError

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from scree.arrays import Array
    from scree.drawing.colour import Colour
    from scree.drawing.view import Matter, Window
    from scree.drawing.walls import Wall
    from scree.files import Snapshot

MOST_LINES = 80          # grid lines along a side; if there are more, only every n-th is drawn
MARGIN = 0.06            # of the page around the box
FRAME = 0.012            # width of the edges of the box in space [inch]


def options_for(snap: Snapshot, by: str | None, view: Window | tuple[()], title: str, dpi: int,
                camera: tuple[float, float]) -> Options:
    """Options for drawing a scene: without mirror images, because a preview shows the computed domain."""
    if by is None:
        by = "body" if "body" in snap.fields else "material"
    return Options(colour=colours.colour_for(by, [snap]), mirror=False, view=view, title=title,
                   dpi=dpi, camera=camera)


def edges_of(snap: Snapshot) -> Edges:
    """Corners of the box [m]."""
    box = box_of(snap)
    if box.low is None or box.high is None or box.cell is None:
        raise ScreeError(f"{snap.file}: the file does not contain the box of the run")
    return Edges(box.low, box.high, box.cell)


def count_text(snap: Snapshot) -> str:
    """Cells and particles in words."""
    box = edges_of(snap)
    axes = {"1d": (0,), "3d": (0, 1, 2)}.get(snap.dimension, (0, 2))
    cells = " x ".join(f"{(box.high[k] - box.low[k]) / box.cell:.0f}" for k in axes)
    k, unit = look.scaled(box.cell, "m")
    return f"{cells} cells of {k * box.cell:.4g} {unit}, {len(snap.points)} particles drawn"


def draw(snap: Snapshot, options: Options) -> Figure:
    """The figure of a scene."""
    return {"1d": draw_line, "3d": draw_space}.get(snap.dimension, draw_plane_page)(snap, options)


def heading(snap: Snapshot, options: Options) -> str:
    """Title, and numbers of cells and particles."""
    return (f"{options.title}\n" if options.title else "") + count_text(snap)


def wall_handles(drawn: Sequence[Wall]) -> list[Any]:
    """A line of the legend for each wall; walls of one boundary and type have one line."""
    from matplotlib.lines import Line2D
    from matplotlib.patches import Patch
    handles: list[Any] = []
    seen: dict[tuple[str, bool], list[str]] = {}
    for wall in drawn:
        names = seen.setdefault((wall.kind, wall.face == 0), [])
        if wall.name not in names:
            names.append(wall.name)
    for (kind, rigid), names in seen.items():
        colour, dash = STYLES.get(kind, STYLES["slip"])
        label = f"{kind}: {', '.join(names)}"
        if rigid:
            handles.append(Patch(facecolor="#c9c9c9", edgecolor=colour, hatch="////", label=label))
        else:
            handles.append(Line2D([], [], color=colour, linestyle=dash, linewidth=2.0, label=label))
    return handles


def body_handles(colour: Colour, snap: Snapshot) -> list[Any]:
    """A line of the legend for each body or material, with its material."""
    from matplotlib.patches import Patch
    handles = []
    for row, name in enumerate(colour.names):
        label = name
        if colour.name == "body" and row < len(snap.bodies) and snap.materials:
            number = int(snap.bodies[row].get("material", 0))
            if 0 < number <= len(snap.materials) and snap.materials[number - 1] != name:
                label += f" ({snap.materials[number - 1]})"
        handles.append(Patch(color=colours.tints_of(colour)[row % len(look.COLOURS)], label=label))
    return handles


def legend(figure: Figure, snap: Snapshot, options: Options, drawn: Sequence[Wall]) -> None:
    """Bodies, then walls, right of the page."""
    handles = body_handles(options.colour, snap) + wall_handles(drawn)
    figure.axes[0].legend(handles=handles, loc="upper left", bbox_to_anchor=(1.02, 1.0),
                          handlelength=2.0, borderaxespad=0.0)


def thinning(longest: float, cell: float) -> int:
    """Number of cells between two lines, for the longest side of the box [m]."""
    every = 1
    while longest / cell / every > MOST_LINES:
        every *= 2
    return every


def grid_lines(low: float, high: float, cell: float, every: int) -> Array:
    """Positions of the cell faces along a side [m] that are drawn."""
    count = max(1, round((high - low) / cell))
    return low + cell * np.arange(0, count + 1, every)


def draw_plane_page(snap: Snapshot, options: Options) -> Figure:
    """A scene in a plane."""
    box = edges_of(snap)
    low, high = box.low[[0, 2]], box.high[[0, 2]]
    pad = MARGIN * float(max(high - low))
    view = options.view or (low[0] - pad, high[0] + pad, low[1] - pad, high[1] + pad)
    page = PlanePage(snap, options, view)
    wide, tall = page.shape()
    figure: Figure
    figure, axes = page.plot.subplots(figsize=(wide + 2.2, tall), layout="constrained")
    k = page.metres
    page.dots(figure, axes, matter(snap, options))
    every = thinning(max(high - low), box.cell)
    lines = [grid_lines(a, b, box.cell, every) for a, b in zip(low, high)]
    axes.vlines(k * lines[0], k * low[1], k * high[1], color="#888888", linewidth=0.25, zorder=2.2)
    axes.hlines(k * lines[1], k * low[0], k * high[0], color="#888888", linewidth=0.25, zorder=2.2)
    drawn = draw_plane(axes, walls_of(snap), snap, options, k, everything=True)
    legend(figure, snap, options, drawn)
    note = f", a line every {every} cells" if every > 1 else ""
    axes.set_title(heading(snap, options) + note, fontsize=11)
    return figure


def draw_line(snap: Snapshot, options: Options) -> Figure:
    """A scene along a line: a row for each body."""
    box, plot = edges_of(snap), look.pyplot()
    k, unit = look.scaled(float(max(abs(box.low[0]), abs(box.high[0]))), "m")
    figure: Figure
    figure, axes = plot.subplots(figsize=(options.wide + 2.2, 3.2), layout="constrained")
    part = matter(snap, options)
    tints = colours.paint(options.colour, part.values)
    axes.bar(k * part.points[:, 0], 0.8, width=k * part.size, bottom=-0.4, color=tints)
    every = thinning(float(box.high[0] - box.low[0]), box.cell)
    lines = grid_lines(float(box.low[0]), float(box.high[0]), box.cell, every)
    axes.vlines(k * lines, -0.55, 0.55, color="#888888", linewidth=0.4)
    drawn = []
    for wall in walls_of(snap):
        colour, dash = STYLES.get(wall.kind, STYLES["slip"])
        for piece in wall.cells:
            axes.axvline(k * piece[0, 0], color=colour, linestyle=dash, linewidth=2.0)
        drawn.append(wall)
    pad = MARGIN * float(box.high[0] - box.low[0])
    axes.set_xlim(k * (box.low[0] - pad), k * (box.high[0] + pad))
    axes.set_ylim(-1.0, 1.0)
    axes.set_yticks([])
    axes.set_xlabel(f"x [{unit}]")
    legend(figure, snap, options, drawn)
    note = f", a line every {every} cells" if every > 1 else ""
    axes.set_title(heading(snap, options) + note, fontsize=11)
    return figure


class ScenePage(SpacePage):
    """A scene in 3-D: the window contains the whole box, the heading has the numbers of cells and particles."""

    def window(self, parts: Sequence[Matter]) -> Window:
        """Left, right, bottom, top around all corners of the box [m]."""
        if self.options.view:
            return self.options.view
        corners = np.array([[self.ends[i][0], self.ends[j][1], self.ends[k][2]]
                            for i in (0, 1) for j in (0, 1) for k in (0, 1)])
        right, up, _ = self.camera(0.0)
        ends = [(float((corners @ way).min()), float((corners @ way).max())) for way in (right, up)]
        pad = MARGIN * max(high - low for low, high in ends)
        return (ends[0][0] - pad, ends[0][1] + pad, ends[1][0] - pad, ends[1][1] + pad)

    def __init__(self, snap: Snapshot, options: Options) -> None:
        box = edges_of(snap)
        self.ends, self.snap = (box.low, box.high), snap
        super().__init__([snap], options)

    def heading(self, _time: float) -> str:
        """Title, and numbers of cells and particles."""
        return heading(self.snap, self.options)

    def add_walls(self, image: render.Image, snap: Snapshot, axes: Array) -> None:
        """Rigid regions and closed boundaries, and the edges of the box."""
        super().add_walls(image, snap, axes)
        corners = np.array([[self.ends[i][0], self.ends[j][1], self.ends[k][2]]
                            for i in (0, 1) for j in (0, 1) for k in (0, 1)]) @ axes.T
        for one in range(8):
            for bit in (1, 2, 4):
                if not one & bit:
                    image.line(corners[one], corners[one | bit], (0.6, 0.6, 0.6), FRAME * self.options.dpi)


def draw_space(snap: Snapshot, options: Options) -> Figure:
    """A scene in 3-D, with labels of the boundaries."""
    page = ScenePage(snap, options)
    figure = page.draw(snap)
    for axes in figure.axes:
        named = axes.get_legend()
        if named is not None:
            named.remove()
    handles = body_handles(options.colour, snap) + wall_handles(page.walls)
    place = figure.axes[0].get_position()
    figure.set_size_inches(figure.get_figwidth() + 1.6, figure.get_figheight())
    scale = (figure.get_figwidth() - 1.6) / figure.get_figwidth()
    for axes in figure.axes:
        spot = axes.get_position()
        axes.set_position((spot.x0 * scale, spot.y0, spot.width * scale, spot.height))
    for line in figure.texts:
        line.set_x(line.get_position()[0] * scale)
    figure.legend(handles=handles, loc="upper left", borderaxespad=0.0, handlelength=1.6,
                  bbox_to_anchor=(place.x1 * scale + 0.01, place.y1))
    return figure
