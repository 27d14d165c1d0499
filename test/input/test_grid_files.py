# SPDX-License-Identifier: BSD-3-Clause
"""VTK, and so ParaView, reads files of fields on the grid number by number, in one to three dimensions.

Would catch extents, an order of axes or a type that readers interpret differently, and images without thickness, which
older readers do not accept.
"""

import subprocess
import sys

import pytest

import case

DECK = """&run dimension = '{dimension}' /
&grid lo = 0 0 0  hi = 1 {y} 1  dx = 0.0625 /
&time t_end = 1e-5 /
&material name = 'metal'  density = 2700  young = 70e9  poisson = 0.3 /
&region name = 'block'  shape = 'box'  lo = 0.125 0.25 {low}  hi = 0.75 0.5 0.5 /
&body name = 'one'  region = 'block'  material = 'metal'  velocity = {speed} 0 0 /
&output name = 'g'  kind = 'grid'  count = 2  precision = '{precision}' /
"""


class TestGridFiles:
    """Runs of a few steps."""

    def test_all_dimensions(self, options, sheet):
        """The last scene has a single layer of cells across z."""
        for name, dimension, y, low in [("box", "3d", 1, 0.25), ("plane", "plane_strain", 0.5, 0.25),
                                        ("ring", "axisymmetric", 0, 0.25), ("bar", "1d", 0.1, 0.25),
                                        ("sheet", "3d", 1, 0.4375)]:
            with sheet.part(name):
                run = case.Case(options, name, DECK.format(
                    dimension=dimension, y=y, low=low, precision="double" if name == "box" else "single",
                    speed=0 if dimension == "axisymmetric" else 30))
                run.run("--quiet")
                answer = subprocess.run(
                    [sys.executable, "-m", "scree_post", "check", run.path("_g.hdf.series")],
                    cwd=case.ROOT / "python/src", text=True, capture_output=True)
                if answer.returncode == 77:
                    pytest.skip("the package vtk is not installed")
                assert answer.returncode == 0, answer.stdout + answer.stderr
                assert "3 grids" in answer.stdout

    def test_refused_sizes(self, options):
        """Would catch a grid that fills a disk without a request: more than 1e9 cells need --force or a region."""
        big = DECK.format(dimension="3d", y=1, low=0.25, precision="single", speed=0).replace(
            "dx = 0.0625", "dx = 0.0009765625").replace("hi = 0.75 0.5 0.5", "hi = 0.13 0.26 0.26")
        run = case.Case(options, "big", big).run("--check", expect=2)
        assert "would write up to 1.07374e9 cells per output time" in run.output
        where = big.replace("kind = 'grid'", "kind = 'grid'  region = 'block'")
        case.Case(options, "bounded", where).run("--check", "--no-estimate")
