# SPDX-License-Identifier: BSD-3-Clause
"""Grids, slices, profiles and fragments: their values for bodies with known results, the same bytes for any ranks and
threads, and files that a restart continues.

Would catch material that is counted twice or not at all, a fragment cut at a face of a tile, at a border of ranks or at
a periodic boundary, two fragments joined to one, sums that depend on the rank that computes them, and rows that occur
twice after a restart.
"""

import csv
import itertools

import h5py
import numpy as np
import pytest

import case

DX = 1.0 / 32
# Tiles are six cells wide: the first body crosses faces of tiles and, with two or three ranks, borders of ranks.
HEAD = """&run dimension = '3d' /
&grid lo = 0 0 0  hi = 2 1 1  dx = 0.03125 /
&time t_end = 1e-4  max_steps = {steps} /
&material name = 'metal'  density = 2700  young = 70e9  poisson = 0.3 /
"""
BODY = """&region name = '{0}'  shape = 'box'  lo = {1}  hi = {2} /
&body name = '{0}'  region = '{0}'  material = 'metal'  ppc = 1 2 1  velocity = {3} /
"""
STREAMS = """&output name = 'h'  kind = 'history'  every = 4 /
&output name = 'p'  kind = 'particles'  every = 4  precision = 'double' /
&output name = 'g'  kind = 'grid'  every = 4  precision = 'double' /
&output name = 's'  kind = 'slice'  every = 4  axis = 'z'  at = 0.5 /
&output name = 'f'  kind = 'profile'  every = 4  bins = 50 /
&output name = 'b'  kind = 'fragments'  every = 4 /
"""
THREE = [("long", "0.0625 0.25 0.25", "0.9375 0.75 0.5", "5 0 0"),
         ("cube", "1.0625 0.5 0.5", "1.1875 0.625 0.625", "0 3 0"),
         ("slab", "1.5 0.125 0.75", "1.6875 0.875 0.8125", "0 0 -4")]


def deck(bodies, streams=STREAMS, steps=8, more=""):
    """A deck of some boxes."""
    return HEAD.format(steps=steps) + "".join(BODY.format(*body) for body in bodies) + more + streams


def box_of(body):
    """Lower and upper corner of a body."""
    return [np.array([float(word) for word in text.split()]) for text in body[1:3]]


def mass_of(body):
    """Mass of a body, whose faces are cell faces [kg]."""
    lower, upper = box_of(body)
    return 2700.0 * np.prod(upper - lower)


def table(run, ending):
    """Rows of a table as dictionaries of numbers, by step."""
    with open(run.path(ending), newline="", encoding="utf-8") as lines:
        rows = [{name.split(" [")[0]: float(value) for name, value in row.items()}
                for row in csv.DictReader(lines)]
    return {step: list(group) for step, group in itertools.groupby(rows, key=lambda row: int(row["step"]))}


class TestMatterOutputs:
    """One run, whose outputs all tests use."""

    @pytest.fixture(autouse=True, scope="class")
    @classmethod
    def made(cls, file_options):
        cls.one = case.Case(file_options, "three", deck(THREE)).run("--quiet")
        cls.kept = {path.name: path.read_bytes() for path in cls.one.folder.iterdir()
                    if path.suffix in (".hdf", ".csv", ".series")}

    def test_same_bytes(self, options, sheet):
        """Any ranks and threads; all files of all streams exist."""
        assert len(self.kept) == 3 * 3 + 3 + 3 + 1          # the last one has the walls
        for ranks, threads in [(2, 1), (3, 1), (1, 2)]:
            run = case.Case(options, f"three_{ranks}_{threads}", deck(THREE), ranks, threads)
            run.name = "three"
            run.run("--quiet")
            for name, wanted in self.kept.items():
                with sheet.part(ranks, threads=threads, file=name):
                    assert (run.folder / name).read_bytes() == wanted

    def test_fragments_are_the_bodies(self):
        """Number, order, mass, volume, centre, velocity, energy, corners, of three bodies that fly apart."""
        rows = table(self.one, "_fragments.csv")
        assert sorted(rows) == [0, 4, 8]
        heaviest = sorted(THREE, key=mass_of, reverse=True)
        for body, row in zip(heaviest, rows[0]):
            lower, upper = box_of(body)
            velocity = np.array([float(word) for word in body[3].split()])
            assert abs(row["mass"] / mass_of(body) - 1.0) <= 0.5e-12
            assert abs(row["volume"] * 2700.0 / mass_of(body) - 1.0) <= 0.5e-12
            assert row["particles"] == round(2 * np.prod(upper - lower) / DX**3)
            assert abs(row["kinetic"] / (0.5 * mass_of(body) * velocity @ velocity) - 1.0) <= 0.5e-12
            for k, axis in enumerate("xyz"):
                assert abs(row[f"centre_{axis}"] - (0.5 * (lower + upper)[k])) <= 0.5e-12
                assert abs(row[f"velocity_{axis}"] - velocity[k]) <= 0.5e-12
                half = DX / (4 if axis == "y" else 2)
                assert abs(row[f"lower_{axis}"] - (lower[k] + half)) <= 0.5e-12
                assert abs(row[f"upper_{axis}"] - (upper[k] - half)) <= 0.5e-12
        for step in rows:
            assert [row["fragment"] for row in rows[step]] == [1, 2, 3]
            total = sum(row["mass"] for row in rows[step])
            assert abs(total / sum(map(mass_of, THREE)) - 1.0) <= 0.5e-12

    def test_profile(self):
        """Sums over the bins are those of the bodies; a mean is that of the material in the bin."""
        rows = table(self.one, "_profile.csv")
        assert [len(rows[step]) for step in rows] == [50] * 3
        history = self.one.history
        for step, bins in rows.items():
            assert abs(sum(row["mass"] for row in bins) / sum(map(mass_of, THREE)) - 1.0) <= 0.5e-12
            at = list(history["step"]).index(step)
            momentum = sum(row["mass"] * row["velocity_x"] for row in bins)
            assert abs(momentum / history["momentum_x"][at] - 1.0) <= 0.5e-10
        inside = [row for row in rows[0] if 0.1 < row["position"] < 0.9]
        assert len(inside) > 15
        assert all(row["velocity_x"] == 5.0 for row in inside)
        assert all(abs(row["density"] / 2700.0 - 1.0) < 1e-12 for row in inside)
        assert all(row["mass"] == 0.0 for row in rows[0] if row["position"] > 1.75)

    def test_grid(self):
        """The image contains all mass, no more cells than are needed, and the velocity of each body."""
        series = sorted(self.one.folder.glob("three_g_0*.hdf"))
        assert len(series) == 3
        for path in series:
            with h5py.File(path) as file:
                image = file["VTKHDF"]
                density = image["PointData/density"][:]
                extent = image.attrs["WholeExtent"]
                assert density.shape == tuple(extent[5::-2] + 1)
                assert abs(density.sum() * DX**3 / sum(map(mass_of, THREE)) - 1.0) <= 0.5e-12
                assert np.allclose(density, 2700.0 * image["PointData/volume_fraction"][:], rtol=1e-3)
                if path == series[0]:
                    assert density.shape == (18, 24, 52)
                    assert np.allclose(image.attrs["Origin"], [0.0625 + DX / 2, 0.125 + DX / 2, 0.25 + DX / 2])
                    velocity = image["PointData/velocity"][:]
                    assert {5.0, 0.0} == set(velocity[..., 0].ravel())
                    assert {-4.0, 0.0} == set(velocity[..., 2].ravel())

    def test_slice(self):
        """Only particles within half a cell of the plane, and at least one."""
        _, whole = self.one.snapshots()[-1]
        _, cut = self.one.snapshots("s")[-1]
        off = whole.points[:, 2] - 0.5
        near = (off >= -DX / 2) & (off < DX / 2)
        assert near.sum() > 100
        assert sorted(whole.fields["identity"][near]) == sorted(cut.fields["identity"])

    def test_restart(self, options):
        """Tables are truncated and continued, and so are files and series."""
        run = case.Case(options, "again", deck(THREE, steps=5))
        run.name = "three"
        run.run("--quiet")
        cut = run.path("_fragments.csv").read_text(encoding="utf-8")
        run.path("_fragments.csv").write_text(cut + cut.splitlines()[-1].replace(",5,", ",7,") + "\n",
                                              encoding="utf-8")
        run.run("--quiet", "--restart", "--set", "time.max_steps=8")
        for ending in ("_profile.csv", "_fragments.csv"):
            seen, wanted = table(run, ending), table(self.one, ending)
            assert sorted(seen) == [0, 4, 5, 8]
            for step in wanted:
                assert seen[step] == wanted[step]
        assert len(list(run.folder.glob("three_g_0*.hdf"))) == 4
        assert run.path("_g.hdf.series").read_text(encoding="utf-8").count("time") == 4


class TestFragments:
    """Connected cells, at the first step."""

    def masses(self, options, name, bodies, ranks=1, key="", more=""):
        stream = f"&output name = 'b'  kind = 'fragments'  every = 1  {key} /\n"
        run = case.Case(options, name, deck(bodies, stream, 0, more), ranks).run("--quiet")
        return [(row["mass"], row) for row in table(run, "_fragments.csv")[0]]

    def test_touching(self, options, sheet):
        """Cells that share a face, an edge or a corner are connected, and those one cell apart are not, for any
        position of the faces of tiles and any ranks."""
        for shift in range(6, 12):                   # all positions in a tile of six cells
            first = ("one", "0.0625 0.0625 0.0625", f"{shift * DX + 0.0625} 0.25 0.25", "0 0 0")
            edge = shift * DX + 0.0625
            for gap, pieces in [(0, 1), (1, 2)]:
                start = edge + gap * DX
                other = ("two", f"{start} {0.25 + gap * DX} 0.25", f"{start + 0.25} 0.75 0.5", "0 0 0")
                found = self.masses(options, f"touch_{shift}_{gap}", [first, other], ranks=1 + shift % 3)
                with sheet.part(shift, gap=gap):
                    assert len(found) == pieces

    def test_periodic(self, options):
        """A body across a periodic boundary is one fragment whose centre is that of the body, not of the box."""
        faces = "&boundary face = 'xlo' type = 'periodic' /\n&boundary face = 'xhi' type = 'periodic' /\n"
        parts = [("one", "0 0.25 0.25", "0.125 0.5 0.5", "0 0 7"), ("two", "1.75 0.25 0.25", "2 0.5 0.5", "0 0 7")]
        closed = self.masses(options, "round", parts, ranks=2, more=faces)
        assert len(closed) == 1
        row = closed[0][1]
        assert abs(row["centre_x"] % 2.0 - 1.9375) <= 0.5e-12
        assert abs(row["upper_x"] - row["lower_x"] - (0.375 - DX)) <= 0.5e-12
        assert abs(row["angular_momentum_y"]) < 1e-9 * row["mass"]
        assert len(self.masses(options, "open", parts)) == 2

    def test_velocity_cut(self, options):
        """Touching bodies are separated where their velocities differ by more than the limit, and only there."""
        parts = [("one", "0.25 0.25 0.25", "0.5 0.5 0.5", "3 0 0"), ("two", "0.5 0.25 0.25", "0.625 0.5 0.5", "0 4 0")]
        for limit, pieces in [(4.99, 2), (5.01, 1)]:
            assert len(self.masses(options, f"cut_{pieces}", parts, 2, f"velocity_cut = {limit}")) == pieces

    def test_only_some(self, options):
        """Selection by bodies and regions; the rest has no mass here."""
        found = self.masses(options, "some", THREE, 1, "bodies = 'cube' 'slab'")
        assert [round(mass / mass_of(body), 9) for (mass, _), body in zip(found, [THREE[2], THREE[1]])] == [1.0, 1.0]
        where = "&region name = 'left'  shape = 'box'  lo = 0 0 0  hi = 0.5 1 1 /\n"
        found = self.masses(options, "where", THREE, 2, "region = 'left'", where)
        assert abs(found[0][0] / mass_of(THREE[0]) - (0.4375 / 0.875)) <= 0.5e-12
        assert len(found) == 1

    def test_spin(self, options):
        """Angular momentum about its own centre, for a body that rotates and flies far from the origin."""
        bodies = [("one", "1.5 0.5 0.5", "1.75 0.75 0.75", "1000 0 0  spin = 0 0 20")]
        mass, row = self.masses(options, "spin", bodies)[0]
        # sum over lattice points of x and y: edge^2 (1 - 1/n^2)/12 with 8 and 16 points
        inertia = mass * 0.25**2 / 12.0 * ((1 - 1 / 8**2) + (1 - 1 / 16**2))
        assert abs(row["angular_momentum_z"] / (20.0 * inertia) - 1.0) <= 0.5e-9
