# SPDX-License-Identifier: BSD-3-Clause
"""Films from frames: .gif by Pillow, .mp4 by ffmpeg, or numbered pictures."""
from __future__ import annotations

import os
import shutil
import subprocess
import tempfile
from collections.abc import Iterable, Iterator
from typing import TYPE_CHECKING, Any

import numpy as np

from scree.errors import EXIT_USAGE, ScreeError, modules

if TYPE_CHECKING:
    from scree.arrays import Array

ENDINGS = (".mp4", ".gif", ".png")
CLEAR = 18               # quality of an .mp4: 0 is lossless, 51 is worst
CHUNK = 4096             # number of colours that are compared with a palette at a time
EXACT = 32               # most frequent colours of a .gif, which are kept unchanged


def check_film(path: str, option: str = "--out") -> None:
    """Refuse a film that cannot be written before any frame is drawn."""
    ending = os.path.splitext(path)[1].lower()
    if ending not in ENDINGS:
        raise ScreeError(f"{option} {path}: write an .mp4, a .gif, or .png for numbered pictures",
                        EXIT_USAGE)
    folder = os.path.dirname(path) or "."
    if not os.path.isdir(folder):
        raise ScreeError(f"cannot write {path}: no folder {folder}")
    if ending == ".mp4":
        encoder()


def encoder() -> str:
    """The ffmpeg program: of the system, or of the package imageio-ffmpeg."""
    program = shutil.which("ffmpeg")
    if program is None:
        try:
            import imageio_ffmpeg
            program = imageio_ffmpeg.get_ffmpeg_exe()
        except (ImportError, RuntimeError) as error:
            raise ScreeError(
                "a film in .mp4 needs ffmpeg or the Python package imageio-ffmpeg, and neither is "
                "installed; write a .gif, or .png for numbered pictures", EXIT_USAGE) from error
    return program


def even(page: Array) -> Array:
    """The colours of a frame, with an even number of rows and columns as codecs require."""
    height, width = (2 * (side // 2) for side in page.shape[:2])
    return np.ascontiguousarray(page[:height, :width, :3])


def encode(pages: Iterable[Array], path: str, rate: int, quality: int = CLEAR) -> list[str]:
    """Write frames (height, width, 3 or 4) of bytes, all of one size, as a film.

    `quality` is that of an .mp4, from 0, the best, to 51. Returns the files written. A film gets its name when it is
    complete.
    """
    stem, ending = os.path.splitext(path)
    part = f"{stem}.part{ending}"
    try:
        if ending.lower() == ".png":
            return numbered(pages, stem)
        if ending.lower() == ".gif":
            encode_gif(pages, part, rate)
        else:
            encode_mp4(pages, part, rate, quality)
        os.replace(part, path)
    except OSError as error:
        raise ScreeError(f"cannot write {path}: {error.strerror or error}") from error
    finally:
        if os.path.exists(part):
            os.remove(part)
    return [path]


def encode_gif(pages: Iterable[Array], path: str, rate: int) -> None:
    """All frames with one palette, so that no colour changes from frame to frame.

    The palette depends on all frames, so they are kept in a file until the last one is drawn.
    """
    (image,) = modules("PIL.Image")
    seen: Array = np.zeros(0, "u4")
    counts: Array = np.zeros(0)
    shape: tuple[int, ...] = ()
    with tempfile.TemporaryFile() as store:
        pages_drawn = 0
        for page in pages:
            page = even(page)
            shape = page.shape
            store.write(page.tobytes())
            found, number = np.unique(packed_colours(page), return_counts=True)
            seen, row = np.unique(np.concatenate([seen, found]), return_inverse=True)
            counts = np.bincount(row.ravel(), np.concatenate([counts, number]))
            pages_drawn += 1
        palette = shared_palette(image, seen, counts)
        entry = nearest_entries(seen, palette)
        store.seek(0)

        def stills() -> Iterator[Any]:
            for _ in range(pages_drawn):
                page = np.frombuffer(store.read(int(np.prod(shape))), "u1").reshape(shape)
                still = image.fromarray(entry[np.searchsorted(seen, packed_colours(page))], "P")
                still.putpalette(palette.ravel().tolist())
                yield still

        images = stills()
        next(images).save(path, save_all=True, append_images=images, duration=int(1000 / rate),
                          loop=0, optimize=False, disposal=1)


def packed_colours(page: Array) -> Array:
    """An integer for the colour of each pixel."""
    page = page.astype("u4")
    return page[..., 0] << 16 | page[..., 1] << 8 | page[..., 2]


def unpacked(seen: Array) -> Array:
    """Colours (n, 3) of integers."""
    return np.stack([seen >> 16, seen >> 8 & 255, seen & 255], axis=1).astype("i4")


def nearest_entries(seen: Array, palette: Array) -> Array:
    """The entry of a palette (256, 3) that is nearest to each colour."""
    found = np.zeros(len(seen), "u1")
    for begin in range(0, len(seen), CHUNK):
        part = unpacked(seen[begin:begin + CHUNK])
        apart = ((part[:, None] - palette[None].astype("i4")) ** 2).sum(axis=2)
        found[begin:begin + CHUNK] = apart.argmin(axis=1)
    return found


def shared_palette(image: Any, seen: Array, counts: Array) -> Array:
    """A palette (256, 3) for packed colours: the most frequent ones unchanged, such as the white of the background, the
    others such that rare colours, as those of the colour bar, have entries too."""
    colours = unpacked(seen).astype("u1")
    exact = colours[np.argsort(-counts, kind="stable")[:EXACT]]
    others = image.fromarray(colours[None]).quantize(256 - EXACT, image.Quantize.MAXCOVERAGE)
    others = np.array(others.getpalette() or [], "u1").reshape(-1, 3)[:256 - EXACT]
    palette = np.concatenate([exact, others])
    return np.concatenate([palette, np.repeat(palette[:1], 256 - len(palette), axis=0)])


def numbered(pages: Iterable[Array], stem: str) -> list[str]:
    """Write frames as STEM_000000.png and so on."""
    (image,) = modules("PIL.Image")
    names = []
    for number, page in enumerate(pages):
        names.append(f"{stem}_{number:06d}.png")
        image.fromarray(even(page)).save(names[-1])
    return names


def encode_mp4(pages: Iterable[Array], path: str, rate: int, quality: int = CLEAR) -> None:
    """Send frames to ffmpeg."""
    pages = iter(pages)
    first = even(next(pages))
    height, width = first.shape[:2]
    command = [encoder(), "-y", "-loglevel", "error", "-f", "rawvideo", "-pix_fmt", "rgb24",
               "-s", f"{width}x{height}", "-r", str(rate), "-i", "-", "-pix_fmt", "yuv420p",
               "-crf", str(quality), path]
    with subprocess.Popen(command, stdin=subprocess.PIPE, stderr=subprocess.PIPE) as process:
        assert process.stdin is not None
        try:
            process.stdin.write(first.tobytes())
            for page in pages:
                process.stdin.write(even(page).tobytes())
        except BrokenPipeError:                          # the error of ffmpeg is reported below
            pass
        said = process.communicate()[1].decode("utf-8", "replace").strip()
    if process.returncode != 0:
        raise ScreeError(f"ffmpeg could not write {path}: {said[-200:]}")
