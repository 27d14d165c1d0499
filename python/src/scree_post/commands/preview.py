# SPDX-License-Identifier: BSD-3-Clause
"""Draws a scene before it runs: bodies, walls, boundaries with their types, and cells.

`scree --preview DECK` writes the first state into OUTDIR_preview and calls this command. It also
accepts the results of a run and then draws its first snapshot. Mirror images are not drawn: the
picture shows the computed domain.
"""
from __future__ import annotations

import argparse
import os

from scree.drawing import look
from scree.drawing.quantity import quantity
from scree.drawing.view import check_view
from scree.drawing.view_options import camera
from scree.errors import EXIT_USAGE, ScreeError
from scree.files import series, series_file, snapshot

from .. import preview_page

SUMMARY = "a scene before it runs: bodies, walls, boundaries, cells"
EXAMPLES = ("preview out/two_discs",
            "preview out/debris_cloud --by material --out bodies.png")
FIELDS = ("body", "material", "mass", "volume")


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """The options."""
    add = parser.add_argument
    add("source", metavar="FOLDER", help="OUTDIR_preview, out/CASE, a series or a snapshot")
    add("--by", choices=("body", "material"),
        help="what colours stand for; default bodies, materials where there is one body")
    add("--out", metavar="PNG", help="picture (.png, .pdf, .svg); default CASE_preview.png there")
    add("--view", type=quantity, nargs=4, metavar=("LEFT", "RIGHT", "BOTTOM", "TOP"),
        help="part to show, in m or with a unit: --view -10mm 10mm 0 30mm")
    add("--camera", metavar="FROM", default="corner",
        help="3-D: x, y, z, corner, or azimuth,elevation in degrees (corner: -60,20)")
    add("--title", help="default: the title of the run; '' for none")
    add("--dpi", type=int, default=100, help="pixels per inch (100)")


def run(arguments: argparse.Namespace) -> int:
    """Read the first state, draw it."""
    if not arguments.dpi > 0:
        raise ScreeError("--dpi must be above 0", EXIT_USAGE)
    check_view(arguments.view)
    source = series_file(arguments.source)
    file = series(source)[0][1]
    snap = snapshot(file, FIELDS)
    case = str(snap.provenance.get("case", "scene"))
    out = arguments.out or os.path.join(os.path.dirname(source) or ".", f"{case}_preview.png")
    look.check_picture(out)
    title = arguments.title
    if title is None:
        title = snap.title
    options = preview_page.options_for(snap, arguments.by, tuple(arguments.view or ()), title,
                                       arguments.dpi, camera(arguments.camera))
    look.save(preview_page.draw(snap, options), out, arguments.dpi)
    print(f"wrote {out}: {preview_page.count_text(snap)}")
    return 0
