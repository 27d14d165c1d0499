# SPDX-License-Identifier: BSD-3-Clause
"""Synthetic flash radiographs of a Scree run.

The areal density along a line of sight is what a flash X-ray shows. Three rows are drawn for each
frame: the film (transmission exp(-mu * areal density)), the areal density on a log scale, and the
particles by body, failed matter in a lighter tint. Flight is to the right.
"""
import argparse
import math
import os
import shutil
import subprocess
import sys

sys.dont_write_bytecode = True

import scree_post                                        # noqa: E402
from scree_post import PostError                         # noqa: E402

try:
    import numpy as np
    from scree_image import radiograph, checked
except ImportError:
    scree_post.run(lambda: scree_post.modules("numpy"), "radiograph.py")

FIELDS = ("mass", "volume", "velocity", "body", "failed", "damage")
TINTS = (("#b3311b", "#f0a36b"), ("#1f5a93", "#8fc1e3"), ("#2f7d3b", "#a8d8a0"),
         ("#6a4098", "#c8b0dd"), ("#7a5a12", "#dcc07a"), ("#444444", "#b5b5b5"))


# --- the picture ------------------------------------------------------------------------------

def exposure(frame):
    """Absorption [m2/kg], rounded to 1, 2, 5, at which a quarter of the cloud halves the light."""
    seen = frame.sigma[frame.sigma > 1.0e-3 * frame.sigma.max()] if frame.sigma.max() > 0.0 else []
    if len(seen) == 0:
        return 1.0
    wanted = math.log(2.0) / float(np.quantile(seen, 0.75))
    decade = 10.0 ** math.floor(math.log10(wanted))
    return min(
        (step * decade for step in (1.0, 2.0, 5.0, 10.0)), key=lambda mu: abs(math.log(mu / wanted))
    )


def density_range(sigma, factor):
    """Three decades of areal density; what is seen edge-on, such as the sheet, may lie above."""
    seen = sigma[sigma > 1.0e-4 * sigma.max()] if sigma.max() > 0.0 else np.ones(1)
    top = scale_bar(5.0 * factor * float(np.quantile(seen, 0.95)))
    return 1.0e-3 * top, top


def shown_box(frames, floor, view):
    """Horizontal range of each frame and common vertical range, where anything is seen [m]."""
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
    """Places panels on a page: a column per frame, or three kinds side by side for one frame."""

    def __init__(self, frames, title, options, common=None):
        self.plot = scree_post.pyplot()
        self.frames, self.title, self.options = frames, title, options
        self.mu = options["mu"] or exposure(frames[-1])
        self.unit, self.factor = (
            ("g/cm$^2$", 0.1) if options["unit"] == "g/cm2" else ("kg/m$^2$", 1.0)
        )
        self.range = common["range"] if common else density_range(frames[-1].sigma, self.factor)
        floor = self.range[0] / self.factor
        self.spans, self.height = (
            common["box"] if common else shown_box(frames, floor, options["view"])
        )
        self.spans = self.spans[:1] * len(frames) if common else self.spans
        self.mu = common["mu"] if common else self.mu
        self.metres, self.length = scree_post.scaled(max(np.abs(self.height).max(), 1.0e-9), "m")
        self.lone = len(frames) == 1
        self.flip = options["towards"] < 0.0

    def common(self):
        """What all frames of a film share."""
        box = [(min(a for a, _ in self.spans), max(b for _, b in self.spans))]
        return {"range": self.range, "box": (box, self.height), "mu": self.mu}

    def draw(self):
        """The figure."""
        tall = self.height[1] - self.height[0]
        spans = self.spans * 3 if self.lone else list(self.spans)
        left, gap, right = 0.85, 0.62 if self.lone else 0.16, 0.35 if self.lone else 1.15
        top, bottom, between = 1.05 if self.lone else 1.25, 1.25 if self.lone else 1.0, 0.46
        rows = 1 if self.lone else 3
        width = 14.0
        room = width - left - right - gap * (len(spans) - 1)
        least = 0.55 * max(b - a for a, b in spans)      # narrow frames keep room for their title
        spans = [(a, b) if b - a >= least else ((a + b - least) / 2, (a + b + least) / 2)
                 for a, b in spans]
        self.shortest = min(b - a for a, b in spans)
        scale = min(room / sum(b - a for a, b in spans), 16.0 / rows / tall)
        used = left + right + gap * (len(spans) - 1) + scale * sum(b - a for a, b in spans)
        page = max(used, 7.5)
        high = top + bottom + rows * scale * tall + (rows - 1) * between
        figure = self.plot.figure(figsize=(page, high))
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

    def panel(self, axes, kind, frame, span, scale):
        """One picture of one frame."""
        k = self.metres
        extent = [k * edge for edge in frame.box]
        ends = self.plot.get_cmap("gray")(1.03 / 1.06), self.plot.get_cmap("inferno")(0.0), "white"
        axes.set_facecolor(ends[kind])
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

    def scatter(self, axes, frame, scale):
        """Particles as dots of their own size, failed ones below the intact ones."""
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

    def dress(self, axes, kind, number, lowest):
        """Ticks, labels and scale bar of a panel."""
        from matplotlib.ticker import MaxNLocator
        axes.yaxis.set_major_locator(MaxNLocator(7, steps=[1, 2, 2.5, 5, 10]))
        wide = axes.get_position().width * axes.figure.get_figwidth()
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

    def scale_bar(self, axes, ink, frame):
        """Scale bar, of one length on the page, where the picture is emptiest."""
        span = abs(axes.get_xlim()[1] - axes.get_xlim()[0])
        wide, tall = (side * page for side, page in zip(axes.get_position().size,
                                                        axes.figure.get_size_inches()))
        length = scale_bar((0.2 if self.lone else 0.35) * self.metres * self.shortest)
        bar, best = length / span, None
        need = max(bar, 0.6 / wide)                      # the words may be longer than the bar
        for level in (0.06, 1.0 - 0.3 / tall - 0.02):
            for start in np.linspace(0.96 - need, 0.04, 12):
                ends = [axes.get_xlim()[0] + share * (axes.get_xlim()[1] - axes.get_xlim()[0])
                        for share in (start, start + need)]
                under = mass_under(frame, sorted(end / self.metres for end in ends),
                                   [(edge * (self.height[1] - self.height[0]) + self.height[0])
                                    for edge in (level - 0.02, level + 0.3 / tall)])
                if best is None or under < 0.9 * best[0]:
                    best = under, start, level
        level, start = best[2], best[1] + 0.5 * (need - bar)
        axes.plot([start, start + bar], [level, level], transform=axes.transAxes, color=ink,
                  linewidth=2.5, solid_capstyle="butt")
        axes.text(start + 0.5 * bar, level + 0.05 / tall, f"{length:g} {self.length}", ha="center",
                  va="bottom", color=ink, transform=axes.transAxes, fontsize=10)

    def titles(self, figure, axes, page, high):
        """Title of the page, time and speed of the leading edge above each frame."""
        figure.text(0.5, 1.0 - 0.16 / high, self.title, ha="center", va="top", fontsize=14,
                    fontweight="bold")
        latest = max(abs(frame.time) for frame in self.frames)
        factor, unit = scree_post.scaled(latest, "s")
        for panel, frame in zip(axes, self.frames):
            place = panel.get_position()
            x = 0.5 if self.lone else 0.5 * (place.x0 + place.x1)
            k, label = scree_post.scaled(abs(frame.speed), "m/s")
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

    def headings(self, figure, panels, page, high):
        """Name of each row (or of each panel of a lone frame), colour bar and legend."""
        mu = f"transmission exp(−µΣ), µ = {self.mu:g} m$^2$/kg"
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
        self.legend(figure, [axes for kind, axes in panels if kind == 2][0].get_position(), high)

    def legend(self, figure, place, high):
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


def mass_under(frame, along, across):
    """Mass in a rectangle of the image [kg], with some room around it."""
    room = 0.02 * (frame.box[1] - frame.box[0])
    first = [max(0, int((low - room - edge) / frame.pixel))
             for low, edge in ((along[0], frame.box[0]), (across[0], frame.box[2]))]
    last = [max(0, int((high + room - edge) / frame.pixel) + 1)
            for high, edge in ((along[1], frame.box[0]), (across[1], frame.box[2]))]
    return float(frame.sigma[first[1]:last[1], first[0]:last[0]].sum()) * frame.pixel ** 2


def scale_bar(longest):
    """Longest of 1, 2, 5 times a power of ten that is not longer."""
    decade = 10.0 ** math.floor(math.log10(longest))
    return max(
        step * decade for step in (1.0, 2.0, 5.0) if step * decade <= longest * (1.0 + 1.0e-9)
    )


# --- from the command line --------------------------------------------------------------------

def choose(frames, arguments):
    """The snapshots asked for: by time, the last, or a number of them spread evenly over time."""
    times = np.array([time for time, _ in frames])
    if arguments.last:
        return frames[-1:]
    wanted = arguments.time
    if wanted is None:
        count = arguments.frames
        wanted = [
            1.0e6 * (times[0] + (times[-1] - times[0]) * k / count) for k in range(1, count + 1)
        ]
    nearest = {int(np.argmin(np.abs(times - 1.0e-6 * time))) for time in wanted}
    return [frames[index] for index in sorted(nearest)]


def flight(snap):
    """+1 if the matter flies towards larger z, -1 if its momentum points the other way."""
    mass, velocity = checked(snap)
    momentum = mass * velocity[:, 2]
    return -1.0 if momentum.sum() < -0.01 * np.abs(momentum).sum() else 1.0


def default_pixel(snap):
    """A pixel [m] of which about 700 cover the longer side of the cloud, rounded to two digits."""
    if len(snap.points) == 0:
        return 1.0e-3
    extent = float(np.ptp(snap.points, axis=0).max()) or 1.0e-3
    return float(f"{extent / 700.0:.1e}")


def encode(pages, path, rate):
    """Write pictures as a film: .gif by Pillow, .mp4 by ffmpeg."""
    ending = os.path.splitext(path)[1].lower()
    if ending == ".gif":
        (image,) = scree_post.modules("PIL.Image")
        stills = [image.fromarray(page[..., :3]).quantize(256) for page in pages]
        try:
            stills[0].save(
                path, save_all=True, append_images=stills[1:], duration=int(1000 / rate), loop=0
            )
        except OSError as error:
            raise PostError(f"cannot write {path}: {error.strerror or error}") from error
        return
    program = encoder()
    first = next(pages)
    height, width = (2 * (side // 2) for side in first.shape[:2])
    command = [program, "-y", "-loglevel", "error", "-f", "rawvideo", "-pix_fmt", "rgb24", "-s",
               f"{width}x{height}", "-r", str(rate), "-i", "-", "-pix_fmt", "yuv420p", path]
    with subprocess.Popen(command, stdin=subprocess.PIPE) as process:
        for page in [first, *pages]:
            process.stdin.write(np.ascontiguousarray(page[:height, :width, :3]).tobytes())
        process.stdin.close()
    if process.returncode != 0:
        raise PostError(f"ffmpeg could not write {path}")


def encoder():
    """The ffmpeg program: of the system, or of the package imageio-ffmpeg."""
    try:
        import imageio_ffmpeg
        return shutil.which("ffmpeg") or imageio_ffmpeg.get_ffmpeg_exe()
    except ImportError:
        pass
    program = shutil.which("ffmpeg")
    if program is None:
        raise PostError("a film in .mp4 needs ffmpeg, which is not installed; write a .gif",
                        scree_post.EXIT_USAGE)
    return program


def movie(frames, make, title, options, arguments):
    """A film of all snapshots, each page in the ranges of the last one."""
    ends = Picture([make(frames[0][1]), make(frames[-1][1])], title, options).common()

    def pages():
        for _, file in frames:
            figure = Picture([make(file)], title, options, ends).draw()
            figure.set_dpi(100)
            figure.canvas.draw()
            yield np.asarray(figure.canvas.buffer_rgba()).copy()
            scree_post.pyplot().close(figure)

    encode(pages(), arguments.movie, arguments.rate)
    print(f"wrote {arguments.movie}")


def parser():
    """The command line."""
    result = argparse.ArgumentParser(
        prog="radiograph.py",
        description=__doc__.split("\n\n")[0],
        epilog="Exit codes: 0 done, 2 command line wrong, 3 file problem.",
    )
    add = result.add_argument
    add(
        "source",
        metavar="SERIES_OR_SNAPSHOT",
        help="CASE_p.hdf.series, CASE_p_000012.hdf or out/CASE",
    )
    add(
        "--out",
        metavar="PNG",
        help="picture (.png, .pdf, .svg); default CASE_radiograph.png beside it",
    )
    which = result.add_mutually_exclusive_group()
    which.add_argument("--time", type=float, nargs="+", metavar="T", help="nearest snapshots [us]")
    which.add_argument("--last", action="store_true", help="the last snapshot only")
    which.add_argument("--frames", type=int, default=4, metavar="N", help="number of frames (4)")
    add("--axis", choices=("x", "y"), default="y", help="line of sight (y); 3-D only")
    add(
        "--pixel",
        type=float,
        metavar="MM",
        help="size of a pixel [mm]; default: 700 over the cloud",
    )
    add("--mu", type=float, metavar="MU", help="absorption [m2/kg]; default: chosen for contrast")
    add("--unit", choices=("kg/m2", "g/cm2"), default="kg/m2", help="of the areal density (kg/m2)")
    add(
        "--view",
        type=float,
        nargs=4,
        metavar=("ZLO", "ZHI", "VLO", "VHI"),
        help="part to show [mm]",
    )
    add("--title", help="default: the title of the run")
    add("--dpi", type=int, default=150, help="pixels per inch of the picture (150)")
    add("--movie", metavar="FILE", help="also a film of all snapshots, .gif or .mp4")
    add("--rate", type=int, default=10, help="pictures a second of the film (10)")
    return result


def checked_arguments():
    """The command line, with what argparse cannot check."""
    command = parser()
    arguments = command.parse_args()
    for name in ("pixel", "mu", "frames", "dpi", "rate"):
        value = getattr(arguments, name)
        if value is not None and not (math.isfinite(value) and value > 0):
            command.error(f"--{name} must be above 0")
    if arguments.movie and os.path.splitext(arguments.movie)[1].lower() not in (".gif", ".mp4"):
        command.error(f"--movie {arguments.movie}: write a .gif or .mp4")
    view = arguments.view
    if view and not (view[0] < view[1] and view[2] < view[3]):
        command.error("--view wants ZLO < ZHI and VLO < VHI")
    return arguments


def main():
    """Read, project, draw, and print a table of what was drawn."""
    arguments = checked_arguments()
    source = scree_post.series_file(arguments.source)
    frames = scree_post.series(source)
    last = scree_post.snapshot(frames[-1][1], FIELDS)
    pixel = 1.0e-3 * arguments.pixel if arguments.pixel else default_pixel(last)
    options = {"mu": arguments.mu, "unit": arguments.unit, "towards": flight(last),
               "view": [1.0e-3 * edge for edge in arguments.view] if arguments.view else None}
    title = arguments.title or str(
        last.provenance.get("title") or last.provenance.get("case") or ""
    )

    def make(file):
        snap = scree_post.snapshot(file, FIELDS)
        return radiograph(snap, pixel, arguments.axis, options["towards"])

    chosen = [make(file) for _, file in choose(frames, arguments)]
    print(f"{'time [us]':>10} {'front [mm]':>11} {'speed [m/s]':>12} {'particles [kg]':>15} "
          f"{'image [kg]':>13} {'difference':>11}")
    for frame in chosen:
        print(
            f"{1e6 * frame.time:10.3f} {1e3 * frame.front:11.3f} {frame.speed:12.1f} "
            f"{frame.mass:15.8e} "
            f"{frame.sigma.sum() * frame.pixel ** 2:13.6e} {frame.mass_error:11.1e}"
        )
    stem = os.path.basename(source).removesuffix(".series").removesuffix(".hdf").removesuffix("_p")
    out = arguments.out or os.path.join(os.path.dirname(source) or ".", f"{stem}_radiograph.png")
    scree_post.save(Picture(chosen, title, options).draw(), out, arguments.dpi)
    print(f"wrote {out}")
    if arguments.movie:
        movie(frames, make, title, options, arguments)
    worst = max(frame.mass_error for frame in chosen)
    if worst > 1.0e-6:
        raise PostError(f"the image misses the mass of the particles by {worst:.1e}", 5)
    return 0


if __name__ == "__main__":
    scree_post.run(main, "radiograph.py")
