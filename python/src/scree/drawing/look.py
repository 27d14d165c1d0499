# SPDX-License-Identifier: BSD-3-Clause
"""The common style of all pictures: fonts, colours, readable units, saving."""
from __future__ import annotations

import math
import os
from typing import TYPE_CHECKING, Any

from ..errors import EXIT_USAGE, ScreeError, modules

if TYPE_CHECKING:
    from matplotlib.figure import Figure

# Colours that can be distinguished with any colour vision (Okabe and Ito 2008).
COLOURS = ("#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9", "#444444")
SEQUENTIAL, SIGNED = "viridis", "coolwarm"               # colour maps of sizes, and of numbers of both signs
HEAT, SOOT = "magma", "cividis"                          # further maps of magnitudes, for a second field on a page
LARGEST = 250000         # bytes up to which a picture keeps all its colours
RAISED = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")
ENDINGS = (".png", ".pdf", ".svg", ".jpg", ".tif")


def pyplot() -> Any:
    """Matplotlib with the common style of all pictures."""
    (plot,) = modules("matplotlib.pyplot")
    plot.rcParams.update({
        "font.family": "DejaVu Sans", "font.size": 11, "axes.titlesize": 11, "axes.labelsize": 11,
        "axes.linewidth": 0.8, "xtick.labelsize": 10, "ytick.labelsize": 10, "legend.fontsize": 10,
        "xtick.direction": "out", "ytick.direction": "out", "legend.frameon": False,
        "axes.prop_cycle": plot.cycler(color=COLOURS), "image.cmap": SEQUENTIAL,
        "figure.constrained_layout.w_pad": 0.06, "figure.constrained_layout.h_pad": 0.06,
        "savefig.facecolor": "white", "mathtext.default": "regular", "svg.fonttype": "none"})
    return plot


def words(name: str) -> str:
    """A column or field name as a label."""
    return name.replace("_", " ")


def check_picture(path: str, option: str = "--out") -> None:
    """Refuse a picture of an unknown format or in a folder that does not exist, before any work is done."""
    if os.path.splitext(path)[1].lower() not in ENDINGS:
        raise ScreeError(f"{option} {path}: write a .png, .pdf, .svg, .jpg or .tif", EXIT_USAGE)
    folder = os.path.dirname(path) or "."
    if not os.path.isdir(folder):
        raise ScreeError(f"cannot write {path}: no folder {folder}")


def with_unit(label: str, unit: str) -> str:
    """An axis label: words and unit in brackets, if there is one."""
    return f"{label} [{unit}]" if unit and unit != "1" else label


STEPS: dict[str, tuple[tuple[float, float, str], ...]] = {   # least size, factor, label
    "s": ((1.0, 1.0, "s"), (1.0e-3, 1.0e3, "ms"), (1.0e-6, 1.0e6, "µs"), (0.0, 1.0e9, "ns")),
    "m": ((0.5, 1.0, "m"), (5.0e-4, 1.0e3, "mm"), (0.0, 1.0e6, "µm")),
    "J": ((1.0e6, 1.0e-6, "MJ"), (1.0e3, 1.0e-3, "kJ"), (1.0, 1.0, "J"), (0.0, 1.0e3, "mJ")),
    "N": ((1.0e6, 1.0e-6, "MN"), (1.0e3, 1.0e-3, "kN"), (1.0, 1.0, "N"), (0.0, 1.0e3, "mN")),
    "W": ((1.0e6, 1.0e-6, "MW"), (1.0e3, 1.0e-3, "kW"), (1.0, 1.0, "W"), (0.0, 1.0e3, "mW")),
    "Pa": ((1.0e9, 1.0e-9, "GPa"), (1.0e6, 1.0e-6, "MPa"), (1.0e3, 1.0e-3, "kPa"), (0.0, 1.0, "Pa")),
    "kg": ((1.0, 1.0, "kg"), (1.0e-3, 1.0e3, "g"), (0.0, 1.0e6, "mg")),
    "m/s": ((1.0e3, 1.0e-3, "km/s"), (0.0, 1.0, "m/s")),
    "K": ((0.0, 1.0, "K"),),
}


def scaled(largest: float, unit: str) -> tuple[float, str]:
    """Factor and label that make numbers of this magnitude readable, such as (1e6, "µs"); other units are unchanged."""
    steps = STEPS.get(unit, ((0.0, 1.0, unit),))
    return next(((factor, label) for bound, factor, label in steps if largest >= bound), steps[-1][1:])


def readable_unit(size: float, unit: str) -> tuple[float, str]:
    """Factor and unit for an axis whose largest number has this magnitude: (1e-6, "MPa"), or (1e-6, "10⁶ 1/s")."""
    if not (size > 0.0 and math.isfinite(size)) or unit == "":
        return 1.0, unit
    if unit in STEPS:
        return scaled(size, unit)
    exponent = 3 * math.floor(math.log10(size) / 3.0 + 1.0e-9)
    if exponent in (0, 3):
        return 1.0, unit
    return 10.0 ** -exponent, "10" + str(exponent).translate(RAISED) + ("" if unit == "1" else f" {unit}")


def plain_texts(figure: Figure) -> Figure:
    """The same figure, in which titles, labels and legends are shown as they are written: matplotlib would take what is
    between two dollar signs as a formula. Labels of ticks are formulas of matplotlib and remain so."""
    (texts,) = modules("matplotlib.text")
    for text in figure.findobj(texts.Text):
        if "$" in text.get_text() and r"\mathdefault" not in text.get_text():
            text.set_parse_math(False)
    return figure


def save(figure: Figure, path: str, dpi: float) -> None:
    """Write a picture under a temporary name, then rename it, so that no incomplete picture remains."""
    stem, ending = os.path.splitext(path)
    check_picture(path)
    part = f"{stem}.part{ending}"
    try:
        plain_texts(figure).savefig(part, dpi=dpi)
        os.replace(part, path)
    except OSError as error:
        if os.path.exists(part):
            os.remove(part)
        raise ScreeError(f"cannot write {path}: {error.strerror or error}") from error
    finally:
        pyplot().close(figure)


def make_small(path: str | os.PathLike[str], largest: int = LARGEST, dither: bool = False) -> None:
    """Reduce a picture whose file has more bytes than that to 256 colours; other colours are dithered."""
    (image,) = modules("PIL.Image")
    if os.path.getsize(path) > largest:
        with image.open(path) as page:
            page = page.convert("RGB")
            palette = page.quantize(256, image.Quantize.MAXCOVERAGE)
            few = page.quantize(palette=palette,
                                dither=image.Dither.FLOYDSTEINBERG if dither else image.Dither.NONE)
            entries = few.getpalette()
            lightest = max(range(0, len(entries), 3), key=lambda first: sum(entries[first:first + 3]))
            entries[lightest:lightest + 3] = [255, 255, 255]
            white = page.convert("L").point(lambda level: 255 * (level == 255))
            # the background of the page is exactly white
            few.paste(lightest // 3, mask=white)
            few.putpalette(entries)
        few.save(path, optimize=True)
