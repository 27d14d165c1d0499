# SPDX-License-Identifier: BSD-3-Clause
"""Regions below a raster of heights: bodies and layers of known volume, walls, and broken files.

Would catch heights in the wrong rows, a layer that does not lie on the ground, a wall whose surface or normal is that
of the cells of the raster and not of the interpolated surface, ranks with different ground, and a raster that does not
fit the grid but is accepted.
"""

import subprocess
import sys

import numpy as np
import pytest

import case

HEAD = """&run dimension = '{dimension}' /
&grid lo = 0 0 0  hi = {size}  dx = {dx} /
&time {time} /
&material name = 'sand'  density = 1000  young = 1e6  poisson = 0.25 /
"""
PIECE = HEAD + """&region name = 'piece'  shape = 'terrain'  {keys} /
&body name = 'one'  region = 'piece'  material = 'sand'  packing = 'cut' /
"""
# The block is above a slope of tangent 0.47 (the normal of the half-space), which has no node on its surface.
SLIDE = HEAD.replace(
    "0.25 /", "0.25  strength_model = 'drucker_prager'  friction_angle = 35  cohesion = 1e5 /") + """
&effects gravity = .true. /
&boundary face = 'ylo'  type = 'slip' /
&boundary face = 'yhi'  type = 'slip' /
&region name = 'slope'  {slope} /
&boundary region = 'slope'  type = 'friction'  friction = {friction} /
&region name = 'block'  shape = 'box'  lo = -0.15 0 0  hi = 0.15 1 0.1  rotate = 0 25.173516 0  translate = 0.4 0 1.05 /
&body name = 'block'  region = 'block'  material = 'sand'  packing = 'cut' /
&output name = 'h'  kind = 'history'  count = 4 /
"""
SLOPE, TOP = 0.47, 1.213
SCENE = {"dimension": "3d", "size": "2 2 2", "dx": 0.125, "time": "t_end = 1  max_steps = 0"}


def grid_text(values, edge, corner=(0.0, 0.0), **more):
    """An ESRI ASCII grid of values[j, i], the first row in the south."""
    header = {"ncols": values.shape[1], "nrows": values.shape[0], "xllcorner": corner[0], "yllcorner": corner[1],
              "cellsize": edge, "NODATA_value": -9999, **more}
    lines = [f"{key} {value}" for key, value in header.items()]
    return "\n".join([*lines, *(" ".join(repr(float(z)) for z in row) for row in values[::-1]), ""])


def middles(cells, edge):
    """Coordinates of the middles of cells, x and y."""
    return np.meshgrid(*[(np.arange(number) + 0.5) * edge for number in cells])


def run_of(options, name, deck, files, ranks=1, flags=("--quiet",), expect=0):
    """Run a deck with rasters beside it."""
    run = case.Case(options, name, deck, ranks)
    for path, text in files.items():
        (run.folder / path).write_text(text, encoding="utf-8")
    return run.run(*flags, expect=expect)


def mass_of(run):
    """Mass of the material."""
    return run.history["mass"][-1]


def test_volume_of_ground(options):
    """A plane that is inclined along x and y, in map coordinates: its mean height times the area."""
    x, y = middles((10, 9), 0.25)
    text = grid_text(1500 + 0.4 + 0.3 * x + 0.2 * y, 0.25, (7000, 500))
    run = run_of(options, "ground", PIECE.format(**SCENE, keys="file = 'a.asc'  translate = -7000 -500 -1500"),
                 {"a.asc": text})
    assert abs(mass_of(run) / (1000 * 4 * (0.4 + 0.3 + 0.2)) - 1) < 2.0e-3


@pytest.mark.parametrize("rotate", ["", "rotate = 0 0 90  translate = 2 0 0"])
def test_volume_of_a_layer(options, sheet, rotate):
    """A paraboloid on a slope: its volume is half of the cylinder around it, less what the bilinear surface cuts off,
    which falls with the square of the cells of the raster. It is not symmetric, so that exchanged rows are seen."""
    errors = []
    for number in (10, 20):
        x, y = middles((number, number), 2 / number)
        thickness = np.maximum(0.5 - ((x - 0.7) ** 2 + (y - 1.1) ** 2) / 0.72, 0.0)
        files = {"a.asc": grid_text(0.2 + 0.5 * x - 0.1 * y, 2 / number), "b.asc": grid_text(thickness, 2 / number)}
        run = run_of(options, "layer", PIECE.format(**SCENE, keys=f"file = 'a.asc'  thickness_file = 'b.asc' {rotate}"),
                     files)
        errors.append(mass_of(run) / (1000 * 0.5 * 0.5 * np.pi * 0.36) - 1)
        if number == 20 and not rotate:
            points = run.snapshots()[-1][1].points
            assert np.all(np.abs(points[:, :2].mean(axis=0) - [0.7, 1.1]) < 0.01)
    sheet.below("error of the volume, raster of 20 cells", abs(errors[1]), 0.03)
    sheet.require(abs(errors[1]) < 0.5 * abs(errors[0]), "it falls with the cells")


def slide(options, name, slope, friction, files=None, ranks=1):
    """A block that slides on a slope."""
    scene = {"dimension": "3d", "size": "1.5 0.2 1.3", "dx": 0.05, "time": "t_end = 0.2"}
    return run_of(options, name, SLIDE.format(**scene, slope=slope, friction=friction), files or {}, ranks)


@pytest.mark.parametrize("friction", [0.0, 0.25])
def test_slides_as_on_a_plane(options, sheet, friction):
    """On the raster of a plane a block moves as on the half-space, and with the acceleration of Coulomb's law; on two
    ranks with the same bits. The normals are found to 1e-9; where friction begins or ends, the difference grows."""
    x, _ = middles((16, 2), 0.1)
    files = {"a.asc": grid_text(TOP - SLOPE * x, 0.1)}
    plane = slide(options, "plane", f"shape = 'halfspace'  centre = 0 0 {TOP}  normal = {SLOPE} 0 1", friction)
    raster = slide(options, "raster", "shape = 'terrain'  file = 'a.asc'", friction, files)
    wanted, found = ([run.history[f"momentum_{axis}"][-1] for axis in "xz"] for run in (plane, raster))
    weight = mass_of(raster) * 9.80665
    sheet.below("difference of momenta", float(np.abs(np.subtract(found, wanted)).max()) / weight, 1.0e-5)
    angle = np.arctan(SLOPE)
    speed = np.hypot(*found) / mass_of(raster) / 0.2
    exact = 9.80665 * (np.sin(angle) - friction * np.cos(angle))
    sheet.below("error of the acceleration", abs(speed / exact - 1), 0.02)
    if friction:
        other = slide(options, "ranks", "shape = 'terrain'  file = 'a.asc'", friction, files, 2)
        assert other.summary["digest"] == raster.summary["digest"]


def test_profile(options):
    """A plane scene takes the row of a raster, or a section of it."""
    x, y = middles((8, 8), 0.25)
    scene = {**SCENE, "dimension": "plane_strain", "size": "2 1 2", "dx": 0.0625}
    digests = []
    for values, keys in ((0.4 + 0.3 * x + 0.2 * y, "section = 0.9"), ((0.4 + 0.3 * x + 0.2 * 0.9)[:1], "")):
        run = run_of(options, "profile", PIECE.format(**scene, keys=f"file = 'a.asc'  {keys}"),
                     {"a.asc": grid_text(values, 0.25)})
        assert abs(mass_of(run) / (1000 * 2 * (0.4 + 0.3 + 0.18)) - 1) < 2.0e-3
        digests.append(round(mass_of(run), 6))
    assert digests[0] == digests[1]


def test_wrong_input(options, sheet):
    """Each is refused with file, key and remedy; nothing crashes."""
    good = grid_text(np.full((8, 8), 1.0), 0.25)
    layer = "thickness_file = 'b.asc'"
    for name, files, keys, message in [
            ("gone", {"b.asc": good}, "", "a.asc': No such file"),
            ("format", {"a.asc": "II*"}, "", "cannot read the raster of"),
            ("count", {"a.asc": good[:-5] + "\n"}, "", "make 64 values, but there are 63"),
            ("edge", {"a.asc": good.replace("cellsize 0.25", "cellsize 0")}, "", "cellsize = 0.0 must be above 0"),
            ("small", {"a.asc": good.replace("cellsize 0.25", "cellsize 0.2")}, "",
             "there is no ground at x = 1.6 to 2, y = 1.6 to 2"),
            ("empty", {"a.asc": good.replace("1.0", "-9999")}, "", "cells of the raster in the grid are without data"),
            ("high", {"a.asc": good.replace("1.0", "1500")}, "", "are all above it: it has z = 0 to 2 of the raster"),
            ("centre", {"a.asc": good}, "rotate_about = 'centre'", "a terrain has no centre to rotate about"),
            ("layer", {"a.asc": good}, layer, "b.asc': No such file"),
            ("bare", {"a.asc": good, "b.asc": good.replace("yllcorner 0.0", "yllcorner 0.5")}, layer,
             "16 cells with a thickness have no ground, the first at x = 0.125, y = 2.125"),
            ("thin", {"a.asc": good, "b.asc": good.replace("1.0", "0")}, layer, "no cell has a thickness above 0"),
            ("other", {"a.asc": good}, "centre = 1 1 1", "centre given but shape = 'terrain' does not use it")]:
        with sheet.part(name):
            said = run_of(options, name, PIECE.format(**SCENE, keys=f"file = 'a.asc'  {keys}"), files,
                          flags=("--check",), expect=2).output
            assert message in said
            assert ".nml:" in said


def test_missing_cells_are_told(options):
    """Cells without data in the grid are a warning, and there is no material in a layer on a cell without thickness."""
    values = np.full((8, 8), 1.0)
    values[2, 5] = -9999
    run = run_of(options, "gap", PIECE.format(**SCENE, keys="file = 'a.asc'"), {"a.asc": grid_text(values, 0.25)})
    assert "1 cells of the raster in the grid have no data, the first in row 6, column 6 at x = 1.375, y = 0.625" \
        in run.path(".log").read_text(encoding="utf-8")
    assert abs(mass_of(run) / (1000 * (4 - 0.25)) - 1) < 1.0e-6


def test_geotiff(options):
    """A GeoTIFF becomes the means of a crop, cells without data stay so, and degrees are refused."""
    rasterio = pytest.importorskip("rasterio")
    from rasterio.transform import from_origin
    x, y = middles((40, 30), 2.0)
    heights = (1000 + 0.5 * x + 0.25 * y).astype("f4")
    heights[:4, :4] = -32768
    path = options.work / "dem.tif"
    profile = {"driver": "GTiff", "width": 40, "height": 30, "count": 1, "dtype": "float32", "nodata": -32768}
    for code, expect in ((25832, 0), (4326, 2)):
        with rasterio.open(path, "w", crs=rasterio.CRS.from_epsg(code), transform=from_origin(700000, 60, 2, 2),
                           **profile) as target:
            target.write(heights[::-1], 1)
        words = [sys.executable, "-m", "scree_post", "terrain", str(path), "--crop", "700000", "0", "700048", "40",
                 "--cell", "4", "--out", str(options.work / "dem.asc")]
        answer = subprocess.run(words, capture_output=True, text=True, check=False)
        assert answer.returncode == expect, answer.stderr
        assert ("gdalwarp" if expect else "translate = -700000 0 -1003") in answer.stdout + answer.stderr
    lines = (options.work / "dem.asc").read_text().splitlines()
    found = np.loadtxt(lines[6:])[::-1]
    x, y = middles((12, 10), 4.0)
    wanted = 1000 + 0.5 * x + 0.25 * y
    wanted[:2, :2] = -9999
    assert np.allclose(found, wanted, atol=1e-3)
    run = run_of(options, "map", PIECE.format(**{**SCENE, "size": "40 32 40", "dx": 4},
                                              keys="file = 'a.asc'  translate = -700000 0 -990"),
                 {"a.asc": "\n".join(lines)}, flags=("--check",))
    assert "4 cells of the raster in the grid have no data, the first in row 9, column 1" in run.output
