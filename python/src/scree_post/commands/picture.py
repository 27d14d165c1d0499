# SPDX-License-Identifier: BSD-3-Clause
"""Draws the particles of one time.

Runs in one and two dimensions are drawn in their plane (axisymmetric ones with both halves), runs
in three dimensions as spheres. Mirror images of models with mirror planes are included.
"""
from __future__ import annotations

import argparse

from scree.drawing import look, page, view_options
from scree.drawing.quantity import quantity
from scree.files import beside, series, series_file

SUMMARY = "the particles of one time, coloured by a field"
EXAMPLES = ("picture out/two_discs --colour pressure --time 2",
            "picture out/debris_cloud --colour body --time 3us --view -15mm 15mm -10mm 25mm",
            "picture out/debris_cloud_3d --colour damage --keep 'y>0' --camera -70,15")


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """The options."""
    parser.add_argument("source", metavar="SERIES_OR_SNAPSHOT",
                        help="CASE_p.hdf.series, CASE_p_000012.hdf or out/CASE")
    parser.add_argument("--time", "--at", type=quantity, metavar="T",
                        help="nearest snapshot, in s or with a unit: 5us; default the last")
    parser.add_argument("--out", metavar="PNG",
                        help="picture (.png, .pdf, .svg); default CASE_FIELD.png beside the series")
    view_options.add_arguments(parser)


def run(arguments: argparse.Namespace) -> int:
    """Read, draw, write."""
    source = series_file(arguments.source)
    frames = series(source)
    file = page.nearest(frames, arguments.time)
    view_options.settle_colour(arguments, file)
    out = arguments.out or beside(source, f"_{arguments.colour.replace('.', '_')}.png")
    look.check_picture(out)
    figure, snap = page.picture(file, arguments)
    look.save(figure, out, arguments.dpi)
    print(f"wrote {out}, {len(snap.points)} particles at t = {snap.time:.6g} s")
    return 0
