# SPDX-License-Identifier: BSD-3-Clause
"""The page of a radiograph: film, areal density and particles, one column for each time."""
from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any, cast

import numpy as np

from . import look

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from matplotlib.transforms import Bbox

    from ..arrays import Array
    from .areal_density import Frame

# Of each body: intact and failed; colours of Okabe and Ito (2008) and paler ones.
TINTS = (("#d55e00", "#f2b48a"), ("#0072b2", "#8fc1e3"), ("#009e73", "#99d8c7"), ("#cc79a7", "#ebc9dc"),
         ("#e69f00", "#f5d999"), ("#444444", "#b5b5b5"))


def exposure(frame: Frame) -> float:
    """Absorption [m2/kg], rounded to 1, 2, 5, at which a quarter of the cloud reduces the light to half or less."""
    seen = frame.sigma[frame.sigma > 1.0e-3 * frame.sigma.max()] if frame.sigma.max() > 0.0 else []
    if len(seen) == 0:
        return 1.0
    wanted = math.log(2.0) / float(np.quantile(seen, 0.75))
    decade = 10.0 ** math.floor(math.log10(wanted))
    return min(
        (step * decade for step in (1.0, 2.0, 5.0, 10.0)), key=lambda mu: abs(math.log(mu / wanted))
    )


def density_range(sigma: Array, factor: float) -> tuple[float, float]:
    """Three decades of areal density; thin material seen edge-on, such as the sheet, may exceed them."""
    seen = sigma[sigma > 1.0e-4 * sigma.max()] if sigma.max() > 0.0 else np.ones(1)
    top = scale_bar(5.0 * factor * float(np.quantile(seen, 0.95)))
    return 1.0e-3 * top, top


def shown_box(frames: Sequence[Frame], floor: float, view: Sequence[float] | None) -> tuple[list[tuple[float, float]],
              tuple[float, float]]:
    """Horizontal range of each frame and common vertical range that contain material [m]."""
    ranges, low, high = [], math.inf, -math.inf
    for frame in frames:
        left, right, bottom, top = frame.box
        rows, columns = np.nonzero(frame.sigma > floor)
        if len(rows):
            right = left + (columns.max() + 1) * frame.pixel
            left += columns.min() * frame.pixel
            top = bottom + (rows.max() + 1) * frame.pixel
            bottom += rows.min() * frame.pixel
        ranges.append((left, right))
        low, high = min(low, bottom), max(high, top)
    margin = 0.03 * max(high - low, max(right - left for left, right in ranges))
    ranges = [(left - margin, right + margin) for left, right in ranges]
    if view:
        return [(view[0], view[1])] * len(frames), (view[2], view[3])
    return ranges, (low - margin, high + margin)


class Picture:
    """Positions of the panels on a page: a column per frame, or three kinds side by side for one frame."""

    def __init__(self, frames: Sequence[Frame], title: str, options: Mapping[str, Any],
                 common: dict[str, Any] | None = None) -> None:
        self.plot = look.pyplot()
        self.frames, self.title, self.options = frames, title, options
        self.mu = options["mu"] or exposure(frames[-1])
        self.unit, self.factor = (
            ("g/cm²", 0.1) if options["unit"] == "g/cm2" else ("kg/m²", 1.0)
        )
        self.range = common["range"] if common else density_range(frames[-1].sigma, self.factor)
        floor = self.range[0] / self.factor
        self.spans: list[tuple[float, float]]
        self.height: tuple[float, float]
        self.spans, self.height = common["box"] if common else shown_box(frames, floor, options["view"])
        self.spans = self.spans[:1] * len(frames) if common else self.spans
        self.mu = common["mu"] if common else self.mu
        self.metres, self.length = look.scaled(max(np.abs(self.height).max(), 1.0e-9), "m")
        self.lone = len(frames) == 1
        self.flip = options["towards"] < 0.0

    def common(self) -> dict[str, Any]:
        """Data that all frames of a film share."""
        box = [(min(a for a, _ in self.spans), max(b for _, b in self.spans))]
        return {"range": self.range, "box": (box, self.height), "mu": self.mu}

    def draw(self) -> Figure:
        """The figure."""
        tall = self.height[1] - self.height[0]
        spans = self.spans * 3 if self.lone else list(self.spans)
        left, gap, right = 0.85, 0.62 if self.lone else 0.16, 0.35 if self.lone else 1.15
        top, bottom, between = 1.05 if self.lone else 1.25, 1.25 if self.lone else 1.0, 0.46
        rows = 1 if self.lone else 3
        width = 14.0
        room = width - left - right - gap * (len(spans) - 1)
        least = 0.55 * max(b - a for a, b in spans)      # narrow frames need space for their title
        spans = [(a, b) if b - a >= least else ((a + b - least) / 2, (a + b + least) / 2)
                 for a, b in spans]
        self.shortest = min(b - a for a, b in spans)
        scale = min(room / sum(b - a for a, b in spans), 16.0 / rows / tall)
        used = left + right + gap * (len(spans) - 1) + scale * sum(b - a for a, b in spans)
        page = max(used, 7.5)
        high = top + bottom + rows * scale * tall + (rows - 1) * between
        figure: Figure = self.plot.figure(figsize=(page, high))
        x, panels = left + 0.5 * (page - used), []
        for number, span in enumerate(spans):
            wide = scale * (span[1] - span[0])
            for row in range(rows):
                y = bottom + (rows - 1 - row) * (scale * tall + between)
                axes = figure.add_axes((x / page, y / high, wide / page, scale * tall / high))
                kind = number if self.lone else row
                frame = self.frames[0] if self.lone else self.frames[number]
                self.panel(axes, kind, frame, span, scale)
                self.dress(axes, kind, number, row == rows - 1)
                panels.append((kind, axes))
            x += wide + gap
        self.titles(figure, [axes for kind, axes in panels if kind == 0], page, high)
        self.headings(figure, panels, page, high)
        return figure

    def panel(self, axes: Axes, kind: int, frame: Frame, span: tuple[float, float], scale: float) -> None:
        """One picture of one frame."""
        k = self.metres
        left, right, bottom, top = (k * edge for edge in frame.box)
        extent = left, right, bottom, top
        ground = self.plot.get_cmap("gray")(1.03 / 1.06), self.plot.get_cmap("inferno")(0.0), "white"
        axes.set_facecolor(ground[kind])
        if kind == 0:
            axes.imshow(np.exp(-self.mu * frame.sigma), extent=extent, origin="lower", cmap="gray",
                        vmin=-0.03, vmax=1.03, interpolation="antialiased", aspect="auto")
        elif kind == 1:
            from matplotlib.colors import LogNorm
            shown = np.maximum(frame.sigma * self.factor, self.range[0])
            self.density = axes.imshow(shown, extent=extent, origin="lower", cmap="inferno",
                                       norm=LogNorm(*self.range), aspect="auto",
                                       interpolation="antialiased")
        else:
            self.scatter(axes, frame, scale)
        ends = (span[1], span[0]) if self.flip else span
        axes.set_xlim(k * ends[0], k * ends[1])
        axes.set_ylim(k * self.height[0], k * self.height[1])

    def scatter(self, axes: Axes, frame: Frame, scale: float) -> None:
        """Particles as dots of their own size, failed ones drawn below the intact ones."""
        from matplotlib.collections import EllipseCollection
        spot = frame.dots
        least = 0.45 / 72.0 / scale                      # never thinner than half a point
        for failed in (True, False):
            for body in np.unique(spot["body"]):
                pick = (spot["body"] == body) & (spot["failed"] == failed)
                wide = self.metres * np.clip(1.3 * spot["size"][pick], least, None)
                place = self.metres * np.stack([spot["along"][pick], spot["across"][pick]], axis=1)
                axes.add_collection(
                    EllipseCollection(
                        wide,
                        wide,
                        np.zeros(len(wide)),
                        units="xy",
                        offsets=place,
                        offset_transform=axes.transData,
                        facecolors=TINTS[body % len(TINTS)][int(failed)],
                        linewidths=0.0,
                        antialiaseds=False,
                        rasterized=True,
                    )
                )

    def dress(self, axes: Axes, kind: int, number: int, lowest: bool) -> None:
        """Ticks, labels and scale bar of a panel."""
        from matplotlib.ticker import MaxNLocator
        axes.yaxis.set_major_locator(MaxNLocator(7, steps=[1, 2, 2.5, 5, 10]))
        wide = axes.get_position().width * cast("Figure", axes.figure).get_figwidth()
        axes.xaxis.set_major_locator(
            MaxNLocator(max(2, int(wide / 0.6)), steps=[1, 2, 5, 10], prune="upper"))
        vertical = self.frames[0].vertical
        if number == 0:
            axes.set_ylabel(f"{vertical} [{self.length}]")
        else:
            axes.tick_params(labelleft=self.lone)
        if lowest:
            axes.set_xlabel(f"z [{self.length}]")
        else:
            axes.tick_params(labelbottom=False)
        if kind < 2:
            self.scale_bar(axes, ("black", "white")[kind], self.frames[0 if self.lone else number])

    def scale_bar(self, axes: Axes, ink: str, frame: Frame) -> None:
        """Scale bar, of the same length on the page, at the emptiest position of the picture."""
        span = abs(axes.get_xlim()[1] - axes.get_xlim()[0])
        wide, tall = (side * page for side, page in zip(axes.get_position().size,
                                                        cast("Figure", axes.figure).get_size_inches()))
        length = scale_bar((0.2 if self.lone else 0.35) * self.metres * self.shortest)
        bar, best = length / span, (math.inf, 0.0, 0.0)
        need = max(bar, 0.6 / wide)                      # the words may be longer than the bar
        for level in (0.06, 1.0 - 0.3 / tall - 0.02):
            for start in np.linspace(0.96 - need, 0.04, 12):
                ends = [axes.get_xlim()[0] + share * (axes.get_xlim()[1] - axes.get_xlim()[0])
                        for share in (start, start + need)]
                under = mass_under(frame, sorted(end / self.metres for end in ends),
                                   [(edge * (self.height[1] - self.height[0]) + self.height[0])
                                    for edge in (level - 0.02, level + 0.3 / tall)])
                if under < 0.9 * best[0]:
                    best = under, start, level
        level, start = best[2], best[1] + 0.5 * (need - bar)
        axes.plot([start, start + bar], [level, level], transform=axes.transAxes, color=ink,
                  linewidth=2.5, solid_capstyle="butt")
        axes.text(start + 0.5 * bar, level + 0.05 / tall, f"{length:g} {self.length}", ha="center",
                  va="bottom", color=ink, transform=axes.transAxes, fontsize=10)

    def titles(self, figure: Figure, axes: Sequence[Axes], page: float, high: float) -> None:
        """Title of the page, time and speed of the leading edge above each frame."""
        figure.text(0.5, 1.0 - 0.16 / high, self.title, ha="center", va="top", fontsize=14,
                    fontweight="bold")
        latest = max(abs(frame.time) for frame in self.frames)
        factor, unit = look.scaled(latest, "s")
        for panel, frame in zip(axes, self.frames):
            place = panel.get_position()
            x = 0.5 if self.lone else 0.5 * (place.x0 + place.x1)
            k, label = look.scaled(abs(frame.speed), "m/s")
            edge = (f"leading edge {k * abs(frame.speed):.2f} {label}"
                    if math.isfinite(frame.speed) and frame.speed != 0.0 else "")
            gap = "     " if self.lone else "\n"
            figure.text(
                x,
                place.y1 + (0.34 if self.lone else 0.36) / high,
                f"t = {factor * frame.time:.2f} {unit}{gap}{edge}",
                ha="center",
                va="bottom",
                fontsize=11,
                linespacing=1.25,
            )

    def headings(self, figure: Figure, panels: Sequence[tuple[int, Axes]], page: float, high: float) -> None:
        """Name of each row (or of each panel of a single frame), colour bar and legend."""
        mu = f"transmission exp(-µΣ), µ = {self.mu:g} m²/kg"
        words = (("Film: " if self.lone else "Radiograph: ") + mu,
                 f"Areal density Σ [{self.unit}]", "Particles by body")
        firsts = [next(axes for kind, axes in panels if kind == wanted) for wanted in range(3)]
        for axes, line in zip(firsts, words):
            place = axes.get_position()
            figure.text(
                place.x0,
                place.y1 + 0.07 / high,
                line,
                ha="left",
                va="bottom",
                fontsize=10.5,
                color="#222222",
            )
        place = [axes for kind, axes in panels if kind == 1][-1].get_position()
        if self.lone:
            slot = figure.add_axes((place.x0, 0.42 / high, place.x1 - place.x0, 0.13 / high))
            figure.colorbar(self.density, cax=slot, orientation="horizontal", extend="both")
        else:
            slot = figure.add_axes((place.x1 + 0.16 / page, place.y0, 0.16 / page, place.height))
            figure.colorbar(self.density, cax=slot, extend="both")
            slot.set_ylabel(f"Σ [{self.unit}]")
        self.legend(figure, next(axes for kind, axes in panels if kind == 2).get_position(), high)

    def legend(self, figure: Figure, place: Bbox, high: float) -> None:
        """Colours of the bodies, below the lowest row."""
        from matplotlib.patches import Patch
        seen = sorted(
            {
                (int(b), bool(f))
                for frame in self.frames
                for b, f in {*zip(frame.dots["body"].tolist(), frame.dots["failed"].tolist())}
            }
        )
        names = self.frames[0].names
        patches = []
        for body, failed in seen:
            name = names[body] if 0 <= body < len(names) and names[body] else f"body {body + 1}"
            patches.append(Patch(color=TINTS[body % len(TINTS)][int(failed)],
                                 label=name + (", failed" if failed else "")))
        if patches:
            centre = 0.5 * (place.x0 + place.x1) if self.lone else 0.5
            figure.legend(handles=patches, loc="lower center", bbox_to_anchor=(centre, 0.06 / high),
                          ncol=2 if self.lone else min(len(patches), 6), columnspacing=1.5,
                          handlelength=1.0, handleheight=1.0, borderaxespad=0.0)


def mass_under(frame: Frame, along: Sequence[float], across: Sequence[float]) -> float:
    """Mass in a rectangle of the image [kg], with a margin around it."""
    room = 0.02 * (frame.box[1] - frame.box[0])
    first = [max(0, int((low - room - edge) / frame.pixel))
             for low, edge in ((along[0], frame.box[0]), (across[0], frame.box[2]))]
    last = [max(0, int((high + room - edge) / frame.pixel) + 1)
            for high, edge in ((along[1], frame.box[0]), (across[1], frame.box[2]))]
    return float(frame.sigma[first[1]:last[1], first[0]:last[0]].sum()) * frame.pixel ** 2


def scale_bar(longest: float) -> float:
    """Longest of 1, 2, 5 times a power of ten that does not exceed a length."""
    decade = 10.0 ** math.floor(math.log10(longest))
    return max(
        step * decade for step in (1.0, 2.0, 5.0) if step * decade <= longest * (1.0 + 1.0e-9)
    )
