# SPDX-License-Identifier: BSD-3-Clause
"""The field `fragment` of particles: the row numbers of the table of that time, the same bytes for any ranks and
threads.

Would catch a particle that has the number of a neighbouring fragment, numbers in another order than in the table, such
as that of the cells or of the ranks, numbers that depend on which particles are written instead of which are counted,
another velocity limit than that of the table, a number for a particle that belongs to no fragment, and a file that
viewers do not read.
"""

import csv
import itertools

import h5py
import numpy as np
import pytest

import case

# Three bodies fly apart; their cells are in the order in which the bodies are listed here, their masses in the opposite
# order. Tiles are six cells wide.
HEAD = """&run dimension = '3d' /
&grid lo = 0 0 0  hi = 2 1 1  dx = 0.0625 /
&time t_end = 1  max_steps = {steps} /
&material name = 'metal'  density = 2700  young = 70e6  poisson = 0.3 {metal} /
&material name = 'wood'  density = 500  young = 10e6  poisson = 0.3 /
{effects}
"""
BODY = """&region name = '{0}'  shape = 'box'  lo = {1}  hi = {2} /
&body name = '{0}'  region = '{0}'  material = '{3}'  ppc = 1 2 1  velocity = {4} /
"""
THREE = [("small", "0.125 0.5 0.125", "0.25 0.625 0.25", "metal", "-5 0 0"),
         ("light", "0.375 0.25 0.25", "0.9375 0.75 0.5", "wood", "0 5 0"),
         ("heavy", "1.0 0.125 0.375", "1.6875 0.875 0.875", "metal", "9 0 2")]
TABLE = "&output name = 'b'  kind = 'fragments'  every = 6  {} /\n"
POINTS = "&output name = 'p'  kind = '{}'  every = 6  fields = 'identity', 'mass', 'body', 'fragment'  {} /\n"


def deck(bodies, streams, steps=12, metal="", effects=""):
    """A deck of some boxes."""
    return HEAD.format(steps=steps, metal=metal, effects=effects) \
        + "".join(BODY.format(*body) for body in bodies) + streams


def table(run, ending="_fragments.csv"):
    """Rows of the table as dictionaries of numbers, one list for each time."""
    with open(run.path(ending), newline="", encoding="utf-8") as lines:
        rows = [{name.split(" [")[0]: float(value) for name, value in row.items()} for row in csv.DictReader(lines)]
    return [list(group) for _, group in itertools.groupby(rows, key=lambda row: row["step"])]


class TestFragmentField:
    """Each test uses the files of its own runs."""

    def agree(self, run, stream="p"):
        """For each number of the table, the particles agree with its row in count, mass and least identity; returns the
        numbers."""
        times, snaps = table(run), [snap for _, snap in run.snapshots(stream)]
        assert len(times) == len(snaps)
        for rows, snap in zip(times, snaps):
            number = snap.fields["fragment"]
            assert set(number) - {0} == {row["fragment"] for row in rows}
            for row in rows:
                mine = number == row["fragment"]
                assert mine.sum() == row["particles"]
                assert abs(snap.fields["mass"][mine].sum(dtype="f8") / row["mass"] - 1.0) <= 0.5e-5
                assert snap.fields["identity"][mine].min() == row["identity"]
        return [snap.fields["fragment"] for snap in snaps]

    def test_bodies_that_fly_apart(self, options):
        """Each body is one fragment, the heaviest is number 1, and the body numbers of the deck identify them."""
        run = case.Case(options, "apart", deck(THREE, TABLE.format("") + POINTS.format("particles", ""))).run("--quiet")
        numbers = self.agree(run)
        assert len(numbers) == 3
        for number, (_, snap) in zip(numbers, run.snapshots()):
            for body, wanted in [(1, 3), (2, 2), (3, 1)]:
                assert set(number[snap.fields["body"] == body]) == {wanted}

    def test_same_bytes(self, options, sheet):
        """Any ranks and threads, and a restart from a checkpoint."""
        text = deck(THREE, TABLE.format("velocity_cut = 3") + POINTS.format("particles", ""))
        one = case.Case(options, "one", text).run("--quiet")
        wanted = {path.name: path.read_bytes() for path in one.folder.glob("one_p_0*.hdf")}
        assert len(wanted) == 3
        for ranks, threads in [(3, 1), (2, 1), (1, 2)]:
            run = case.Case(options, f"one_{ranks}_{threads}", text, ranks, threads)
            run.name = "one"
            run.run("--quiet")
            for name, content in wanted.items():
                with sheet.part(ranks, threads=threads, file=name):
                    assert (run.folder / name).read_bytes() == content
        again = case.Case(options, "again", text.replace("max_steps = 12", "max_steps = 7"))
        again.name = "one"
        again.run("--quiet")
        again.run("--quiet", "--restart", "--set", "time.max_steps=12")
        found = [snap.fields["fragment"] for _, snap in again.snapshots()]
        for one_of, (_, snap) in zip([found[0], found[1], found[-1]], one.snapshots()):
            assert np.array_equal(one_of, snap.fields["fragment"])

    def test_it_costs_nothing_unasked(self, options):
        """Without the field the file contains only the other fields; with it the state of the run is the same."""
        with_it = case.Case(options, "with", deck(THREE, POINTS.format("particles", ""))).run("--quiet")
        without = case.Case(options, "without", deck(THREE, POINTS.format("particles", "").replace(
            ", 'fragment'", ""))).run("--quiet")
        assert with_it.summary["digest"] == without.summary["digest"]
        assert set(with_it.snapshots()[0][1].fields) - set(without.snapshots()[0][1].fields) == {"fragment"}
        for _, snap in with_it.snapshots():               # no table: all material, separated by gaps
            assert set(snap.fields["fragment"]) == {1, 2, 3}

    def test_the_table_defines(self, options):
        """Touching bodies are separated by velocity_cut of the table; bodies that the table excludes have 0."""
        pair = [("one", "0.25 0.25 0.25", "0.5 0.5 0.5", "metal", "3 0 0"),
                ("two", "0.5 0.25 0.25", "0.625 0.5 0.5", "metal", "0 4 0"),
                ("far", "1.5 0.25 0.25", "1.75 0.75 0.75", "metal", "0 0 0")]
        for key, wanted in [("velocity_cut = 4.9", {1: {2}, 2: {3}, 3: {1}}),
                            ("velocity_cut = 5.1", {1: {2}, 2: {2}, 3: {1}}),
                            ("bodies = 'one' 'far'", {1: {2}, 2: {0}, 3: {1}})]:
            streams = TABLE.format(key) + TABLE.format("").replace("'b'", "'other'")
            run = case.Case(options, f"defined_{len(key)}_{key[-2]}",
                            deck(pair, POINTS.format("particles", "") + streams, 0), 2).run("--quiet")
            number, = self.agree(run)
            body = run.snapshots()[0][1].fields["body"]
            assert {row: set(number[body == row]) for row in (1, 2, 3)} == wanted, key

    def test_failed_matter_has_none(self, options):
        """Where the table counts intact material alone, failed particles have 0, and some have failed."""
        bodies = [("bar", "0.25 0.4375 0.4375", "1.75 0.5625 0.5625", "metal", "0 0 0  spin = 0 0 80")]
        run = case.Case(options, "intact", deck(
            bodies, TABLE.format("matter = 'intact'") + POINTS.format("particles", "").replace(
                "'body'", "'failed'"), 60, "damage_model = 'principal_stress'  failure_stress = 3e5",
            "&effects damage = T /"), 2).run("--quiet", "--set", "output[b].every=60", "--set", "output[p].every=60")
        self.agree(run)
        snap = run.snapshots()[-1][1]
        failed = snap.fields["failed"] == 1
        assert failed.sum() > 0
        assert np.array_equal(failed, snap.fields["fragment"] == 0)
        assert snap.fields["fragment"].max() > 1

    def test_a_part_is_written(self, options):
        """Slices, strides, bodies and regions of the stream select rows; the numbers are those of all particles."""
        where = "&region name = 'left'  shape = 'box'  lo = 0 0 0  hi = 1 1 1 /\n"
        parts = ["stride = 3", "bodies = 'light' 'small'", "region = 'left'"]
        streams = TABLE.format("") + POINTS.format("particles", "") + "".join(
            POINTS.format("particles", part).replace("'p'", f"'q{n}'") for n, part in enumerate(parts)) \
            + POINTS.format("slice", "axis = 'z'  at = 0.44").replace("'p'", "'s'") + where
        run = case.Case(options, "parts", deck(THREE, streams, 6), 2).run("--quiet")
        whole = run.snapshots()[-1][1]
        number = dict(zip(whole.fields["identity"], whole.fields["fragment"]))
        for stream in ("q0_p", "q1_p", "q2_p", "s"):
            part = run.snapshots(stream)[-1][1]
            assert 0 < len(part.points) < len(whole.points), stream
            assert [number[identity] for identity in part.fields["identity"]] == list(part.fields["fragment"]), stream

    def test_viewers(self, options):
        """The numbers are 32-bit integers, named in the file, and VTK reads them; grids have no mean of them."""
        run = case.Case(options, "viewed", deck(THREE, POINTS.format("particles", ""), 0)).run("--quiet")
        path = run.path("_p_000000.hdf")
        with h5py.File(path) as file:
            field = file["VTKHDF/PointData/fragment"]
            assert field.dtype == np.dtype("i4")
            assert field.attrs["units"].decode().strip() == "1"
            wanted = field[:]
        answer = case.Case(options, "grid", deck(THREE, POINTS.format("grid", ""), 0)).run("--check", expect=2).output
        assert "has no mean" in answer
        try:
            from vtkmodules.util.numpy_support import vtk_to_numpy
            from vtkmodules.vtkIOHDF import vtkHDFReader
        except ImportError:
            pytest.skip("the package vtk is not installed")
        reader = vtkHDFReader()
        reader.SetFileName(str(path))
        reader.Update()
        data = reader.GetOutputDataObject(0)
        assert np.array_equal(vtk_to_numpy(data.GetPointData().GetArray("fragment")), wanted)
