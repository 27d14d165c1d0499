# SPDX-License-Identifier: BSD-3-Clause
"""Regions of voxels: the particles in them, translated and rotated, and broken files.

Would catch axes or edges of voxels in the wrong order, an origin that is taken for the centre of a voxel, numbers read
with the wrong sign or width, bits of the mask that are written and read differently, ranks with different
solids, and a broken file that is accepted.
"""

import h5py
import numpy as np

import case

DECK = """&run dimension = '{dimension}' /
&units system = '{system}' /
&grid lo = 0 0 0  hi = {size} {size} {size}  dx = {dx} /
&time t_end = 1  max_steps = 0 /
&material name = 'metal'  density = 1  bulk = 1  shear = 1 /
&region name = 'solid'  {shape} /
&body name = 'one'  region = 'solid'  material = 'metal' /
"""


class TestVoxels:
    """Particles of the first state."""

    def run_of(self, options, name, files, more="", ranks=1, flags=("--quiet",), expect=0, file=None, **scene):
        """A run of zero steps. `files` are bytes, or data sets with their attributes, by name."""
        scene = {"dimension": "3d", "system": "si", "size": 1, "dx": 0.0625, **scene}
        shape = f"shape = 'voxel'  file = '{file or next(iter(files))}'  {more}"
        run = case.Case(options, name, DECK.format(shape=shape, **scene), ranks)
        for path, content in files.items():
            if isinstance(content, bytes):
                (run.folder / path).write_bytes(content)
                continue
            with h5py.File(run.folder / path, "w") as target:
                for key, (voxels, attributes) in content.items():
                    target.create_dataset(key, data=voxels, compression="gzip").attrs.update(attributes)
        return run.run(*flags, expect=expect)

    def points(self, run):
        """Positions, sorted."""
        points = run.snapshots()[-1][1].points
        return points[np.lexsort(points.T)]

    def box_of(self, options, lo, hi, **scene):
        """Particles of a box, sorted."""
        scene = {"dimension": "3d", "system": "si", "size": 1, "dx": 0.0625, **scene}
        shape = "shape = 'box'  lo = {} {} {}  hi = {} {} {}".format(*lo, *hi)
        return self.points(case.Case(options, "box", DECK.format(shape=shape, **scene)).run("--quiet"))

    def block(self):
        """Voxels of different numbers along each axis: a block of twos in ones in threes, [z, y, x]."""
        voxels = np.full((5, 7, 9), 3, dtype="u2")
        voxels[1:4, 1:6, 1:8] = 1
        voxels[2:4, 1:3, 4:7] = 2
        return voxels

    def test_a_block_is_exact(self, options, sheet):
        """Values, edges of different lengths, an origin: the particles of a box, for any type and format."""
        wanted = self.box_of(options, (0.0625 + 4 * 0.125, 0.125 + 0.0625, 2 * 0.1875),
                             (0.0625 + 7 * 0.125, 0.3125, 0.75))
        where = {"spacing": [0.125, 0.0625, 0.1875], "origin": [0.0625, 0.125, 0.0]}
        more = "voxel_value = 2"
        first = self.run_of(options, "block", {"block.h5": {"voxels": (self.block(), where)}}, more)
        assert len(wanted) > 200
        assert np.array_equal(self.points(first), wanted)
        for kind in ("i1", "u1", "<i2", ">u2", "i4", ">u4", "f4", ">f8"):
            with sheet.part(kind):
                run = self.run_of(options, "kind", {"a.h5": {"voxels": (self.block().astype(kind), where)}}, more)
                assert run.summary["digest"] == first.summary["digest"]
        signed = np.where(self.block() == 2, -2, 3).astype("i2")
        run = self.run_of(options, "signed", {"a.h5": {"/deep/er": (signed.astype("f4"), where)}},
                          "voxel_value = -2  dataset = '/deep/er'")
        assert run.summary["digest"] == first.summary["digest"]
        for ranks in (2, 3):
            run = self.run_of(options, "ranks", {"block.h5": {"voxels": (self.block(), where)}}, more, ranks)
            assert run.summary["digest"] == first.summary["digest"]

    def test_parts_share_no_point(self, options):
        """One body per value: together they have every particle of the box of voxels once, also when rotated."""
        for turn in ("", "rotate = 0 0 30"):
            counts = []
            for value in (1, 2, 3):
                where = {"spacing": 0.09, "origin": [0.01, -0.33, 0.03]}
                run = self.run_of(options, "part", {"block.h5": {"voxels": (self.block(), where)}},
                                  f"voxel_value = {value}  {turn}  translate = 0.1 0.4 0.1")
                counts.append({tuple(point) for point in self.points(run)})
            whole = self.run_of(options, "whole", {"block.h5": {"voxels": (np.ones((5, 7, 9), "u1"), where)}},
                                f"{turn}  translate = 0.1 0.4 0.1")
            assert min(len(part) for part in counts) > 20
            assert sum(len(part) for part in counts) == len(self.points(whole))
            assert len(set.union(*counts)) == len(self.points(whole))

    def test_transformations(self, options):
        """The order is scale, rotate, translate; lengths of the file are in the unit of the deck; without attributes
        voxels are cubes of one unit at the origin."""
        wanted = self.box_of(options, (0.25, 0.375, 0.25), (0.5, 0.75, 0.625))
        voxels = np.zeros((5, 4, 3), dtype="u1")            # rotated by -90 degrees about z it is y, -x, z
        voxels[2:5, 2:4, 0:3] = 1
        run = self.run_of(options, "moved", {"a.h5": {"voxels": (voxels, {})}},
                          "scale = 0.125  rotate = 0 0 -90  translate = 0 0.75 0")
        assert np.array_equal(self.points(run), wanted)
        run = self.run_of(options, "cgs", {"a.h5": {"voxels": (voxels, {"spacing": [1, 1, 1]})}},
                          "scale = 12.5  rotate = 0 0 -90  translate = 0 75 0", system="cgs", size=100, dx=6.25)
        assert np.allclose(self.points(run), wanted)

    def test_a_sphere_converges(self, options):
        """The mass of a sphere of voxels converges to that of a sphere, and equals the mass of its voxels."""
        off = []
        for n in (8, 16, 32, 64):
            line = (np.arange(n) + 0.5) / n - 0.5
            z, y, x = np.meshgrid(line, line, line, indexing="ij")
            voxels = (x**2 + y**2 + z**2 < 0.16).astype("u1")
            run = self.run_of(options, "sphere", {"a.h5": {"voxels": (voxels, {"spacing": 1 / n})}}, dx=0.03125)
            mass = len(self.points(run)) / 64**3
            assert abs(mass - (voxels.sum() / n**3)) <= 0.5e-9
            off.append(abs(mass / (4 / 3 * np.pi * 0.064) - 1))
        assert off[-1] < 0.003
        assert off[-1] < 0.3 * off[0]

    def test_plane(self, options):
        """Data of two dimensions are in the plane of x and z; data of three dimensions need one layer along y."""
        wanted = self.box_of(options, (0.25, 0, 0.5), (0.5, 1, 0.625), dimension="plane_strain")
        plane = np.zeros((8, 8), dtype="i4")
        plane[4:5, 2:4] = 1
        scene = {"dimension": "plane_strain"}
        run = self.run_of(options, "plane", {"a.h5": {"voxels": (plane, {"spacing": [0.125, 0.125]})}}, **scene)
        assert np.array_equal(self.points(run), wanted)
        run = self.run_of(options, "layer", {"a.h5": {"voxels": (plane[:, None, :], {"spacing": 0.125})}}, **scene)
        assert np.array_equal(self.points(run), wanted)
        said = self.run_of(options, "deep", {"a.h5": {"voxels": (np.ones((4, 4, 4)), {})}}, expect=2,
                           flags=("--check",),
                           **scene).output
        assert "the scene has no direction y, but there are 4 voxels along it; write one layer" in said
        said = self.run_of(options, "thin", {"a.h5": {"voxels": (plane, {})}}, expect=2, flags=("--check",)).output
        assert "the voxels have 2 directions, the scene 3" in said

    def test_broken_files(self, options, sheet):
        """Each is refused with the error and its position; nothing crashes."""
        voxels = self.block()
        for name, files, more, message in [
                ("value", {"a.h5": {"voxels": (voxels, {})}}, "voxel_value = 7",
                 "no voxel has the value 7; there are 3, 1, 2"),
                ("dataset", {"a.h5": {"other": (voxels, {})}}, "", "has no data set '/voxels'"),
                ("spacing", {"a.h5": {"voxels": (voxels, {"spacing": [1, 2]})}}, "",
                 "must have one number or one a direction"),
                ("edge", {"a.h5": {"voxels": (voxels, {"spacing": [1.0, 0.0, 1.0]})}}, "",
                 "the edges of a voxel must be above 0"),
                ("nan", {"a.h5": {"voxels": (voxels, {"origin": [1.0, float("nan"), 1.0]})}}, "",
                 "its spacing or origin is not a number"),
                ("numbers", {"a.h5": {"voxels": (np.full((2, 2, 2), np.nan), {})}}, "",
                 "no voxel has the value 1; there are only values that are not finite"),
                ("four", {"a.h5": {"voxels": (np.ones((2, 2, 2, 2)), {})}}, "", "must have one to three dimensions"),
                ("text", {"a.h5": b"not at all"}, "", "not an HDF5 file, or truncated"),
                ("gone", {"b.h5": b""}, "", "a.h5': No such file")]:
            with sheet.part(name):
                file = "a.h5" if name == "gone" else None
                said = self.run_of(options, name, files, more, flags=("--check",), expect=2, file=file).output
                assert message in said
                assert ".nml:6: error" in said
