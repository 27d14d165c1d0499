# SPDX-License-Identifier: BSD-3-Clause
"""Writes the ESRI ASCII grid of shape = 'terrain' from a raster such as a GeoTIFF.

The raster is cropped, and its cells are averaged. Coordinates are those of the map, in lengths and
not in degrees. The printed translate of the region moves the lower corner of the grid to x = y = 0.
Cells without data are written as -9999.
"""
from __future__ import annotations

import argparse
import math
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from scree.errors import EXIT_USAGE, FileProblem, ScreeError

if TYPE_CHECKING:
    from scree.arrays import Array

SUMMARY = "a raster of heights (GeoTIFF) as an ESRI ASCII grid, for shape = 'terrain'"
EXAMPLES = ("terrain dem.tif --crop 702300 5180500 703100 5180900 --cell 5 --out heights.asc",
            "terrain dem.asc --cell 10 --out coarse.asc")
NO_DATA = -9999.0
ROUND_OFF = 1.0e-6


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """The options."""
    add = parser.add_argument
    add("raster", type=Path, metavar="FILE", help="a raster of any format of GDAL")
    add("--crop", type=float, nargs=4, metavar=("X0", "Y0", "X1", "Y1"), help="corners in coordinates of the map (all)")
    add("--cell", type=float, metavar="EDGE", help="edge of the cells, at least that of the raster (the same)")
    add("--band", type=int, default=1, metavar="N", help="band of the file (1)")
    add("--out", type=Path, metavar="FILE", help="the grid (name of the raster with .asc)")


def grid_of(source: Any, arguments: argparse.Namespace) -> tuple[Array, float, float, float]:
    """Heights, the northern row first, the lower corner, and the edge of a cell."""
    from rasterio.enums import Resampling
    from rasterio.windows import from_bounds
    name = arguments.raster
    if source.crs is not None and source.crs.is_geographic:
        raise ScreeError(f"{name} has degrees as coordinates; convert it first, for example with "
                         "gdalwarp -t_srs EPSG:25832", EXIT_USAGE)
    if source.transform.b or source.transform.d or source.transform.a <= 0 or source.transform.e >= 0:
        raise ScreeError(f"{name} is rotated or mirrored against the map; convert it first with gdalwarp", EXIT_USAGE)
    if not 1 <= arguments.band <= source.count:
        raise ScreeError(f"--band {arguments.band}: {name} has {source.count}", EXIT_USAGE)
    least = max(source.transform.a, -source.transform.e)
    edge = least if arguments.cell is None else arguments.cell
    if not edge >= least * (1.0 - ROUND_OFF):
        raise ScreeError(f"--cell {edge:g}: the cells of {name} have {least:g}; finer ones have no more information",
                         EXIT_USAGE)
    left, bottom, right, top = source.bounds
    x0, y0, x1, y1 = arguments.crop or (left, bottom, right, top)
    slack = ROUND_OFF * edge
    if not (left - slack <= x0 < x1 <= right + slack and bottom - slack <= y0 < y1 <= top + slack):
        raise ScreeError(f"--crop must be within {name}, which has x = {left:.12g} to {right:.12g} and "
                         f"y = {bottom:.12g} to {top:.12g}", EXIT_USAGE)
    columns, rows = (math.floor(length / edge + ROUND_OFF) for length in (x1 - x0, y1 - y0))
    if min(columns, rows) < 1:
        raise ScreeError(f"--cell {edge:g} is larger than the crop", EXIT_USAGE)
    window = from_bounds(x0, y0, x0 + columns * edge, y0 + rows * edge, source.transform)
    heights = source.read(arguments.band, window=window, out_shape=(rows, columns), masked=True, out_dtype="float64",
                          resampling=Resampling.average)
    return np.ma.filled(heights, NO_DATA), x0, y0, edge


def run(arguments: argparse.Namespace) -> None:
    """Read the raster and write the grid."""
    try:
        import rasterio
    except ImportError as error:
        raise ScreeError("scree-post terrain needs the Python package rasterio: pip install rasterio; or convert with "
                         "gdal_translate -of AAIGrid", EXIT_USAGE) from error
    try:
        with rasterio.open(arguments.raster) as source:
            heights, x, y, edge = grid_of(source, arguments)
    except rasterio.errors.RasterioError as error:
        raise FileProblem(f"cannot read {arguments.raster}: {error}") from error
    out = arguments.out or arguments.raster.with_suffix(".asc")
    if out.exists() and arguments.raster.exists() and out.samefile(arguments.raster):
        raise ScreeError(f"{out} is the raster itself; give --out", EXIT_USAGE)
    header = "\n".join([f"ncols {heights.shape[1]}", f"nrows {heights.shape[0]}", f"xllcorner {x:.15g}",
                        f"yllcorner {y:.15g}", f"cellsize {edge:.15g}", f"NODATA_value {NO_DATA:g}"])
    try:
        np.savetxt(out, heights, fmt="%.9g", header=header, comments="")
    except OSError as error:
        raise FileProblem(f"cannot write {out}: {error.strerror}") from error
    known = heights[heights != NO_DATA]
    if known.size == 0:
        raise FileProblem(f"{out}: no cell of the crop has data")
    print(f"{out}: {heights.shape[1]} x {heights.shape[0]} cells of {edge:g}, heights {known.min():.6g} to "
          f"{known.max():.6g}, {heights.size - known.size} without data")
    shift = (0.0 - x, 0.0 - y, 0.0 - math.floor(known.min()))
    print("region: translate = " + " ".join(f"{length:.12g}" for length in shift))
