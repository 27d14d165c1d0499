# SPDX-License-Identifier: BSD-3-Clause
"""Synthetic flash radiographs of a run.

A flash X-ray shows the areal density along a line of sight. Three rows are drawn for each frame:
the film (transmission exp(-mu * areal density)), the areal density on a log scale, and the
particles by body, with failed material in a lighter colour. The flight direction is to the right.
Particles of an axisymmetric run are rings, seen from the side; 3-D models are completed at mirror
planes.
"""
from __future__ import annotations

import argparse
import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any

from scree.drawing import look, page
from scree.drawing.areal_density import SMEARS
from scree.drawing.quantity import in_unit
from scree.drawing.radiograph_page import Picture
from scree.drawing.view import to_pixels
from scree.errors import EXIT_DEFECT, EXIT_USAGE, ScreeError
from scree.files import beside, nearest, series, series_file, snapshot

from .. import film
from ..progress import Progress

if TYPE_CHECKING:
    from scree.arrays import Array
    from scree.drawing.areal_density import Frame
    from scree.files import Moment, beside, nearest

SUMMARY = "simulated flash X-ray image, as picture and film"
EXAMPLES = ("radiograph out/debris_cloud",
            "radiograph out/debris_cloud --time 5 10 20",
            "radiograph out/debris_cloud --last --unit g/cm2 --movie cloud.gif")


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """The options."""
    add = parser.add_argument
    add("source", metavar="SERIES_OR_SNAPSHOT",
        help="CASE_p.hdf.series, CASE_p_000012.hdf or out/CASE")
    add("--out", metavar="PNG",
        help="picture (.png, .pdf, .svg); default CASE_radiograph.png in the folder of the series")
    which = parser.add_mutually_exclusive_group()
    which.add_argument("--time", type=in_unit("us"), nargs="+", metavar="T",
                       help="nearest snapshots, in us or with a unit: 5us, 2ms")
    which.add_argument("--last", action="store_true", help="the last snapshot only")
    which.add_argument("--frames", type=int, default=4, metavar="N", help="number of frames (4)")
    add("--axis", choices=("x", "y"), default="y", help="line of sight (y); 3-D only")
    add("--pixel", type=in_unit("mm"), metavar="L",
        help="size of a pixel, in mm or with a unit; default: 700 pixels across the cloud")
    add("--mu", type=float, metavar="MU", help="absorption [m2/kg]; default: chosen for contrast")
    add("--smear", choices=SMEARS, default="spacing", help="spread particles that moved apart over "
        "the gaps between them (spacing), or draw each as wide as its volume (volume)")
    add("--unit", choices=("kg/m2", "g/cm2"), default="kg/m2",
        help="unit of the areal density (kg/m2)")
    add("--view", type=in_unit("mm"), nargs=4, metavar=("ZLO", "ZHI", "VLO", "VHI"),
        help="part to show, in mm or with a unit")
    add("--title", help="default: the title of the run")
    add("--dpi", type=int, default=150, help="pixels per inch of the picture (150)")
    add("--movie", metavar="FILE", help="write a film of all snapshots too, .gif or .mp4")
    add("--rate", type=int, default=10, help="frames per second of the film (10)")


def check_arguments(arguments: argparse.Namespace) -> None:
    """Checks that the parser cannot do."""
    for name in ("pixel", "mu", "frames", "dpi", "rate"):
        value = getattr(arguments, name)
        if value is not None and not (math.isfinite(value) and value > 0):
            raise ScreeError(f"--{name} must be above 0", EXIT_USAGE)
    view = arguments.view
    if view and not (view[0] < view[1] and view[2] < view[3]):
        raise ScreeError("--view needs ZLO < ZHI and VLO < VHI", EXIT_USAGE)
    if arguments.movie:
        film.check_film(arguments.movie, "--movie")


def choose(frames: Sequence[Moment], arguments: argparse.Namespace) -> Sequence[Moment]:
    """The requested snapshots: by time, the last, or a number of them evenly spaced in time."""
    if arguments.last:
        return frames[-1:]
    wanted = arguments.time
    if wanted is None:
        count = arguments.frames
        begin, end = frames[0][0], frames[-1][0]
        wanted = [begin + (end - begin) * k / count for k in range(1, count + 1)]
    return nearest(frames, wanted)


def movie(frames: Sequence[Moment], make: Callable[[str], Frame], title: str, options: Mapping[str, Any],
          arguments: argparse.Namespace) -> None:
    """A film of all snapshots, each frame with the ranges of the last one."""
    ends = Picture([make(frames[0][1]), make(frames[-1][1])], title, options).common()

    def pages() -> Iterator[Array]:
        with Progress(len(frames), "drawing") as progress:
            for _, file in frames:
                figure = Picture([make(file)], title, options, ends).draw()
                yield to_pixels(figure, 100)
                progress.step()

    for path in film.encode(pages(), arguments.movie, arguments.rate):
        print(f"wrote {path}")


def table(frames: Sequence[Frame]) -> None:
    """The drawn frames, and the mass in the picture compared with that of the particles."""
    clock, second = look.scaled(max(abs(frame.time) for frame in frames), "s")
    metres, length = look.scaled(max((abs(frame.front) for frame in frames
                                      if math.isfinite(frame.front)), default=0.0), "m")
    print(f"{f'time [{second}]':>10} {f'front [{length}]':>11} {'speed [m/s]':>12} "
          f"{'particles [kg]':>15} {'image [kg]':>13} {'difference':>11}")
    for frame in frames:
        print(f"{clock * frame.time:10.3f} {metres * frame.front:11.3f} {frame.speed:12.1f} "
              f"{frame.mass:15.8e} "
              f"{frame.sigma.sum() * frame.pixel ** 2:13.6e} {frame.mass_error:11.1e}")


def run(arguments: argparse.Namespace) -> int:
    """Read, project, draw, and print a table of what was drawn."""
    check_arguments(arguments)
    source = series_file(arguments.source)
    out = arguments.out or beside(source, "_radiograph.png")
    frames = series(source)
    last = snapshot(frames[-1][1], page.RADIOGRAPH_FIELDS)
    pixel = arguments.pixel or page.default_pixel(last)
    options = {"mu": arguments.mu, "unit": arguments.unit, "towards": page.flight(last),
               "view": arguments.view}
    title = arguments.title or last.title

    def make(file: str) -> Frame:
        return page.radiograph(file, pixel, arguments.axis, options["towards"], arguments.smear)

    look.check_picture(out)
    chosen = [make(file) for _, file in choose(frames, arguments)]
    table(chosen)
    look.save(Picture(chosen, title, options).draw(), out, arguments.dpi)
    print(f"wrote {out}")
    if arguments.movie:
        movie(frames, make, title, options, arguments)
    worst = max(frame.mass_error for frame in chosen)
    if worst > 1.0e-6:
        raise ScreeError(f"the mass in the image differs from that of the particles by {worst:.1e}", EXIT_DEFECT)
    return 0
