# SPDX-License-Identifier: BSD-3-Clause
"""A film of a series: the particles at all times, coloured by a field.

Window and colours are the same for all frames. An .mp4 is written with ffmpeg, a .gif without;
with --out NAME.png the frames become pictures NAME_000000.png and so on.
"""
from __future__ import annotations

import argparse
from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING

from scree.drawing import view_options
from scree.drawing.quantity import quantity
from scree.drawing.view import to_pixels
from scree.errors import EXIT_USAGE, ScreeError
from scree.files import beside, series, series_file

from .. import film
from ..progress import Progress

if TYPE_CHECKING:
    from scree.arrays import Array
    from scree.files import Moment, beside

SUMMARY = "a film of all times, .mp4 or .gif"
EXAMPLES = ("movie out/two_discs --colour pressure --out discs.mp4",
            "movie out/debris_cloud --colour velocity.z --range 0 7km/s --from 2us --out cloud.gif",
            "movie out/debris_cloud_3d --turn 90 --hide-failed --out turning.mp4")


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """The options."""
    add = parser.add_argument
    add("source", metavar="SERIES", help="CASE_p.hdf.series or out/CASE")
    add("--out", metavar="FILE", help="film (.mp4, .gif) or .png for numbered pictures; default "
        "CASE_FIELD.mp4 beside the series")
    add("--from", type=quantity, dest="begin", metavar="T", help="first time, such as 2us")
    add("--to", type=quantity, dest="end", metavar="T", help="last time")
    add("--every", type=int, default=1, metavar="N", help="every n-th snapshot (1)")
    add("--rate", type=int, default=10, help="pictures a second (10)")
    add("--quality", type=int, default=film.CLEAR, metavar="Q",
        help=f".mp4: from 0, the best, to 51, the smallest file ({film.CLEAR})")
    add("--turn", type=float, default=0.0, metavar="DEG", help="3-D: turn the camera over the film")
    view_options.add_arguments(parser)
    parser.set_defaults(dpi=100)


def choose(frames: Sequence[Moment], arguments: argparse.Namespace) -> Sequence[Moment]:
    """The snapshots of the film."""
    if arguments.every < 1 or arguments.rate < 1:
        raise ScreeError("--every and --rate must be above 0", EXIT_USAGE)
    if not 0 <= arguments.quality <= 51:
        raise ScreeError("--quality must be from 0 to 51", EXIT_USAGE)
    times = [time for time, _ in frames]
    begin = times[0] if arguments.begin is None else arguments.begin
    end = times[-1] if arguments.end is None else arguments.end
    slack = 1.0e-9 * max(abs(times[0]), abs(times[-1]))
    frames = [(time, file) for time, file in frames if begin - slack <= time <= end + slack]
    if not frames:
        raise ScreeError(f"no snapshot from {begin:g} to {end:g} s; the series has {times[0]:g} to "
                        f"{times[-1]:g} s", EXIT_USAGE)
    return frames[::arguments.every]


def run(arguments: argparse.Namespace) -> int:
    """Read, draw, encode."""
    source = series_file(arguments.source)
    frames = choose(series(source), arguments)
    view_options.settle_colour(arguments, frames[-1][1])
    out = arguments.out or beside(source, f"_{arguments.colour.replace('.', '_')}.mp4")
    film.check_film(out)
    page = view_options.pages(arguments, view_options.sample(frames))

    def drawn() -> Iterator[Array]:
        with Progress(len(frames), "drawing") as progress:
            for number, (_, file) in enumerate(frames):
                share = number / max(1, len(frames) - 1)
                yield to_pixels(page.draw(view_options.read(file, arguments), share), arguments.dpi)
                progress.step()

    written = film.encode(drawn(), out, arguments.rate, arguments.quality)
    print(f"wrote {written[0]}" + (f" to {written[-1]}" if len(written) > 1 else "")
          + f", {len(frames)} pages from {frames[0][0]:.6g} to {frames[-1][0]:.6g} s")
    return 0
