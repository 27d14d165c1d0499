# SPDX-License-Identifier: BSD-3-Clause
"""Writes the rasters of the scene: heights of a hillside with a gully that opens to a fan, and the depth of a release.

    python input/terrain/make_terrain.py

Coordinates are those of a map, in metres; the deck moves (702000, 5180000, 1450) to the origin.
"""
from pathlib import Path

import numpy as np

EAST, NORTH, LEVEL, CELL = 702000.0, 5180000.0, 1450.0, 4.0
COLUMNS, ROWS = 92, 32


def height(x, y):
    """A hill that flattens out, a gully that ends at x = 200 m, and undulations of 0.8 m [m]."""
    gully = 0.004 / (1.0 + np.exp((x - 200.0) / 25.0))
    return 100.0 * np.exp(-x / 120.0) + gully * y**2 + 0.8 * np.sin(x / 19.0 + 0.3) * np.cos(y / 23.0)


def release(x, y):
    """A cap of 9 m in the upper part of the gully [m]."""
    return 9.0 * np.maximum(1.0 - ((x - 48.0) / 32.0) ** 2 - (y / 24.0) ** 2, 0.0)


def write(name, values):
    """A raster with the northern row first."""
    header = "\n".join([f"ncols {COLUMNS}", f"nrows {ROWS}", f"xllcorner {EAST - CELL:.1f}",
                        f"yllcorner {NORTH - 0.5 * ROWS * CELL:.1f}", f"cellsize {CELL:g}", "NODATA_value -9999"])
    np.savetxt(Path(__file__).parent / name, values[::-1], fmt="%.2f", header=header, comments="")


if __name__ == "__main__":
    places = np.meshgrid((np.arange(COLUMNS) - 0.5) * CELL, (np.arange(ROWS) + 0.5 - 0.5 * ROWS) * CELL)
    write("heights.asc", LEVEL + height(*places))
    write("thickness.asc", release(*places))
