# SPDX-License-Identifier: BSD-3-Clause
"""Bodies made of the points of a file: a text table, or a snapshot of another run.

Would catch columns in the wrong order or unit, points that are lost, duplicated or of another material, identities that
depend on ranks, fields that are assigned to other particles, a run that does not continue the other run, and invalid
tables that are accepted.
"""

import numpy as np

import case

DECK = """&run dimension = '{dimension}'  {method} /
&units system = '{system}' /
&grid lo = 0 0 0  hi = {hi} {hi} {hi}  dx = {dx} /
&time t_end = 1  max_steps = {steps}  {time} /
&material name = 'metal'  density = {density}  bulk = {bulk}  shear = {shear} /
&region name = 'solid'  {shape} /
&body name = 'one'  region = 'solid'  material = 'metal'  {body} /
{more}
&output name = 'p'  kind = 'particles'  precision = 'double'  count = 1
  fields = 'default' 'stress' 'viscous_pressure' {fields} /
&output name = 'h'  kind = 'history'  every = 1 /
"""
SCENE = {"dimension": "3d", "system": "si", "hi": 1, "dx": 0.125, "steps": 0, "time": "", "density": 1000, "bulk": 1e9,
         "shear": 5e8, "more": "", "method": "", "fields": "", "body": "packing = 'file'"}
OTHER = "&material name = 'other'  density = 2000  bulk = 1e9  shear = 5e8 /\n"


def table(points, **columns):
    """A text table."""
    values = np.column_stack([points, *columns.values()])
    names = ",".join(["x,y,z", *columns])
    return "\n".join([names, *(",".join(repr(float(x)) for x in row) for row in values), ""])


class TestPoints:
    """Runs of points."""

    def run_of(self, options, name, shape="shape = 'points'  file = 'a.csv'", text="", ranks=1, flags=("--quiet",),
               expect=0,
               **scene):
        """A run, by default of zero steps."""
        run = case.Case(options, name, DECK.format(shape=shape, **{**SCENE, **scene}), ranks)
        (run.folder / "a.csv").write_text(text, encoding="utf-8")
        return run.run(*flags, expect=expect)

    def lattice(self, options, **scene):
        """A ball of lattice particles, and these particles."""
        shape = "shape = 'sphere'  centre = 0.5 0.5 0.5  radius = 0.4"
        run = self.run_of(options, f"lattice_{len(scene)}", shape, body="velocity = 1 2 3  spin = 0 0 50", **scene)
        return run, run.snapshots()[-1][1]

    def state(self, run, origin=None):
        """State of the particles, in the order of their identities, or of those of the rows from which they were
        read."""
        last = run.snapshots()[-1][1]
        identity = last.fields["identity"]
        if origin is not None:
            identity = origin.fields["identity"][identity - 1]
        values = np.column_stack([last.points] + [last.fields[k].reshape(len(last.points), -1) for k in
                                                  ("velocity", "mass", "volume", "stress", "pressure")])
        return values[np.argsort(identity)]

    def near(self, found, wanted, share):
        """Numbers agree to a fraction of the greatest value in their column."""
        scale = np.maximum(np.abs(wanted).max(axis=0), 1e-300)
        assert (np.abs(found - wanted) / scale).max() < share

    def test_a_table_of_the_lattice(self, options):
        """A table with the sites of a lattice gives the same result as the lattice, at the start and after steps, for
        any ranks."""
        lattice, first = self.lattice(options, steps=20)
        at_start = self.lattice(options)[1]
        order = np.argsort(at_start.fields["identity"])
        text = table(at_start.points[order], volume=at_start.fields["volume"][order])
        body = "packing = 'file'  velocity = 1 2 3  spin = 0 0 50"
        one = self.run_of(options, "table", text=text, steps=20, body=body)
        assert len(first.points) > 1000
        assert np.abs(first.points - at_start.points).max() > 0
        assert np.array_equal(self.state(one), self.state(lattice))
        for ranks in (2, 3):
            other = self.run_of(options, "ranks", text=text, steps=20, body=body, ranks=ranks)
            assert other.summary["digest"] == one.summary["digest"]
        for kind in ("gimp", "cpdi"):
            how = {"more": f"&method basis = '{kind}' /", "method": "method = 'mpm'", "steps": 20}
            plain = self.lattice(options, **how)[0]
            run = self.run_of(options, kind, text=text, body=body, **how)
            self.near(self.state(run), self.state(plain), 1e-9)

    def test_columns(self, options):
        """Any order of columns, comments, empty lines and line ends; velocities and volumes in units of the deck."""
        rows = np.array([(30, 40, 50, 0.1, 1, 2, 3), (35, 40, 50, 0.2, 4, 5, 6), (60, 70, 80, 0.3, 7, 8, 9)])
        order = [3, 2, 0, 1, 6, 5, 4]
        head = np.array(["x", "y", "z", "volume", "vx", "vy", "vz"])[order]
        lines = ["# from elsewhere", "", " , ".join(head)] + [",".join(str(x) for x in row[order]) for row in rows]
        scene = {"system": "cgs", "hi": 100, "dx": 12.5, "density": 1, "bulk": 1e10, "shear": 5e9}
        run = self.run_of(options, "columns", text="\r\n".join(lines) + "\r\n\r\n",
                          body="packing = 'file' velocity = 100 0 0",
                          **scene)
        last = run.snapshots()[-1][1]
        by = np.argsort(last.fields["identity"])
        assert np.allclose(last.points[by], rows[:, :3] / 100)
        assert np.allclose(last.fields["velocity"][by], rows[:, 4:] / 100 + [1, 0, 0])
        assert np.allclose(last.fields["mass"][by], rows[:, 3] / 1000)
        assert np.allclose(last.fields["volume"][by], rows[:, 3] / 1e6)
        run = self.run_of(options, "key",
                          "shape = 'points'  file = 'a.csv'  point_volume = 0.001  translate = 0.1 0.2 0.3",
                          "x,y,z\n0.1,0.2,0.3\n0.5,0.5,0.5\n")
        last = run.snapshots()[-1][1]
        assert np.allclose(np.sort(last.points[:, 0]), [0.2, 0.6])
        assert np.allclose(last.fields["volume"], 0.001)

    def test_materials(self, options):
        """Each body uses the points of its own material; identities of bodies do not overlap."""
        text = "x,y,z,volume,material\n" + "".join(f"{k / 20},0.5,0.5,{k}e-5,{('metal', 'other')[k % 2]}\n"
                                                   for k in range(1, 20))
        run = self.run_of(options, "materials", text=text,
                          more=OTHER + "&body name = 'two'  region = 'solid'  material = 'other'  packing = 'file' /")
        last = run.snapshots()[-1][1]
        assert len(set(last.fields["identity"])) == 19
        k = np.rint(20 * last.points[:, 0])
        assert np.array_equal(last.fields["body"], 1 + k % 2)
        assert np.allclose(last.fields["mass"], k * 1e-5 * np.where(k % 2, 2000, 1000))

    def test_plane_and_rings(self, options):
        """In a plane scene y is ignored; the volume of a ring is that of the whole ring, and its position the centroid,
        which is not the middle of its box."""
        for dimension in ("plane_strain", "axisymmetric"):
            shape = "shape = 'sphere'  centre = 0.5 0.5 0.5  radius = 0.5"
            how = {"more": "&method basis = 'gimp' /\n&boundary face = 'zlo'  type = 'slip' /",
                   "method": "method = 'mpm'", "steps": 10, "dimension": dimension}
            plain = self.run_of(options, "plain", shape, body="velocity = 0 0 -9", **how)
            first = self.run_of(options, "first", shape, dimension=dimension, body="").snapshots()[-1][1]
            order = np.argsort(first.fields["identity"])
            text = table((first.points + [0, 0.123, 0])[order], volume=first.fields["volume"][order])
            run = self.run_of(options, "plane", text=text, body="packing = 'file'  velocity = 0 0 -9", **how)
            self.near(self.state(run), self.state(plain), 1e-9)

    def test_going_on_from_a_snapshot(self, options):
        """A run from the last snapshot of another run has its mass, momentum and energy, and ends in the same state as
        that run would."""
        ball = {"shape": "shape = 'sphere'  centre = 0.5 0.5 0.4  radius = 0.3", "time": "dt_fixed = 2e-5",
                "fields": "'spin' 'ahead'"}
        fall = {"body": "velocity = 1 2 -30  spin = 0 0 50", **ball}
        whole = self.run_of(options, "whole", **{**fall, "steps": 60})
        half = self.run_of(options, "half", **{**fall, "steps": 30})
        shape = f"shape = 'points'  file = '{half.path('_p_000001.hdf')}'"
        stress = "packing = 'file'  initial_stress = 'file'"
        rest = self.run_of(options, "rest", shape, body=stress, steps=30, time="dt_fixed = 2e-5",
                           fields="'spin' 'ahead'")
        before, after = half.history, rest.history
        for column in ("mass", "momentum_x", "momentum_y", "momentum_z", "kinetic", "internal"):
            scale = np.abs(before[column]).max()
            assert scale > 1e-6, column
            assert abs(after[column][0] - before[column][-1]) < 1e-9 * scale, column
        middle, start = half.snapshots()[-1][1], rest.snapshots()[0][1]
        self.near(self.state(rest, middle), self.state(whole), 1e-9)
        for field in ("spin", "ahead", "stress", "velocity", "mass", "volume"):
            row = start.fields["identity"] - 1
            assert np.array_equal(start.fields[field], middle.fields[field][row]), field
            assert np.abs(start.fields[field]).max() > 0.0
        assert np.abs(self.state(half)[:, 8:14]).max() > 1e4
        # without the predicted strain the first step strains once, not by half a step more
        lacks = self.run_of(options, "lacks_first", **{**fall, "fields": "'spin'", "steps": 30})
        lacks = self.run_of(options, "lacks", f"shape = 'points'  file = '{lacks.path('_p_000001.hdf')}'", body=stress,
                            steps=1, time="dt_fixed = 2e-5", fields="'spin'")
        next_one = self.state(self.run_of(options, "next", **{**fall, "steps": 31}))[:, 7]
        change = np.abs(next_one - self.state(half)[:, 7]).max()
        assert 0.0 < np.abs(self.state(lacks, middle)[:, 7] - next_one).max() < 0.25 * change
        two = self.run_of(options, "other", shape, body=stress, steps=30, time="dt_fixed = 2e-5", ranks=2,
                          fields="'spin'")
        assert two.summary["digest"] == rest.summary["digest"]
        still = self.run_of(options, "still", shape, body="packing = 'file'")
        stress = self.state(still)[:, 8:14]       # the deviator starts from 0; the pressure follows from the density
        assert np.abs(stress[:, 3:]).max() == 0.0
        assert np.abs(stress[:, :3] - stress[:, :1]).max() < 1e-6
        assert np.abs(stress[:, 0]).max() > 1e4
        keeps = "packing = 'file'  initial_stress = 'file'"
        paper = {"more": "&method paper = .true. /", "fields": ""}      # velocities at the times of the steps
        whole = self.run_of(options, "whole", **{**fall, **paper, "steps": 60})
        half = self.run_of(options, "half", **{**fall, **paper, "steps": 30})
        rest = self.run_of(options, "rest", shape, body=keeps, time="dt_fixed = 2e-5", **{**paper, "steps": 30})
        self.near(self.state(rest, half.snapshots()[-1][1]), self.state(whole), 1e-9)

    def test_one_body_of_a_snapshot(self, options):
        """`from_body` selects one of two bodies of a material; units of the snapshot have no effect."""
        more = ("&region name = 'there'  shape = 'box'  lo = 0.75 0.75 0.75  hi = 1 1 1 /\n"
                "&body name = 'two'  region = 'there'  material = 'metal'  velocity = 5 0 0 /\n")
        first = self.run_of(options, "first", "shape = 'box'  lo = 0 0 0  hi = 0.25 0.5 0.5", body="", more=more)
        file = first.path("_p_000000.hdf")
        run = self.run_of(options, "picked", f"shape = 'points'  file = '{file}'  from_body = 'two'")
        assert run.summary["particles"] == 64
        assert np.all(run.snapshots()[-1][1].fields["velocity"] == [5, 0, 0])
        run = self.run_of(options, "both", f"shape = 'points'  file = '{file}'")
        assert run.summary["particles"] == 64 + 256
        said = self.run_of(options, "nobody", f"shape = 'points'  file = '{file}'  from_body = 'three'",
                           expect=2).output
        assert "no point of body 'three' and of its material; its bodies are: one, two" in said
        cgs = self.run_of(options, "cgs", "shape = 'box'  lo = 0 0 0  hi = 25 50 50", body="", system="cgs", hi=100,
                          dx=12.5,
                          density=1, bulk=1e10, shear=5e9)
        text = cgs.deck.read_text(encoding="utf-8").replace("system = 'cgs'", "system = 'cgs'  output_units = 'deck'")
        cgs.deck.write_text(text, encoding="utf-8")
        cgs.run("--quiet", "--force")
        run = self.run_of(options, "units", f"shape = 'points'  file = '{cgs.path('_p_000000.hdf')}'")
        plain = self.run_of(options, "plain", "shape = 'box'  lo = 0 0 0  hi = 0.25 0.5 0.5", body="")
        self.near(self.state(run, cgs.snapshots()[0][1]), self.state(plain), 1e-12)

    def test_check_tells(self, options):
        """Number of points in the output of --check."""
        first = self.lattice(options)[0]
        said = self.run_of(options, "told", f"shape = 'points'  file = '{first.path('_p_000000.hdf')}'",
                           flags=("--check", "--no-estimate")).output
        assert f"particles  {first.summary['particles']} in 1 bodies" in said

    def test_refused(self, options, sheet):
        """Each refusal has its line in the table, and states what to write instead."""
        good = "x,y,z,volume\n0.1,0.2,0.3,1e-4\n0.5,0.5,0.5,1e-4\n"
        points = "shape = 'points'  file = 'a.csv'"
        for name, shape, text, scene, message in [
                ("outside", points, good + "0.5,1.5,0.5,1e-4\n", {},
                 "line 4 of '{}': the point (0.5 1.5 0.5) lies outside of the grid"),
                ("twice", points, good + "# a word\n0.1,0.2,0.3,2e-4\n", {},
                 "line 2 and line 5 of '{}': two points at (0.1 0.2 0.3)"),
                ("volume", points, "x,y,z\n0.1,0.2,0.3\n", {}, "the file has no volumes; add a column or field volume"),
                ("volumes", points + "  point_volume = 1", good, {}, "remove point_volume"),
                ("none", points, good + "0.2,0.2,0.2,0\n", {}, "line 4: the volume of a point must be above 0"),
                ("nan", points, good + "0.2,nan,0.2,1\n", {}, "line 4: y = 'nan' is not a number"),
                ("word", points, good + "0.2,,0.2,1\n", {}, "line 4: y = '' is not a number"),
                ("more", points, good + "0.2,0.2,0.2,1,1\n", {},
                 "line 4: expected 4 columns as in the first line, not 5"),
                ("column", points, good.replace("volume", "volum"), {},
                 "line 1: unknown column 'volum'; there are x, y, z, volume, vx, vy, vz, material; did you mean"),
                ("same", points, good.replace("volume", "x"), {}, "line 1: the column 'x' is there twice"),
                ("head", points, good.replace("z,", "vx,"), {}, "line 1: the first line must name the columns x, y, z"),
                ("part", points, "x,y,z,vx\n0,0,0,0\n", {}, "line 1: a velocity needs all of vx, vy, vz"),
                ("numbers", points, "0.1,0.2,0.3,1e-4\n", {}, "line 1: unknown column '0.1'"),
                ("empty", points, "", {}, "it has no points"),
                ("only", points, "x,y,z,volume\n", {}, "it has no points"),
                ("material", points, "x,y,z,volume,material\n0,0,0,1,wood\n", {},
                 "has no point of material 'metal'; there are: wood"),
                ("large", points, good + "0.2,1e999,0.2,1\n", {}, "line 4: y = '1e999' is not a number"),
                ("turned", points + "  rotate = 0 20 90", good, {"dimension": "plane_strain"},
                 "this rotation moves points out of the plane or line"),
                ("rings", points + "  rotate = 0 180 0", good, {"dimension": "axisymmetric"},
                 "points are rings around the axis, which cannot be rotated"),
                ("scaled", points + "  scale = 2.5", good, {}, "the point (1.25 1.25 1.25) lies outside of the grid"),
                ("wall", points, good, {"more": "&boundary region = 'solid'  type = 'slip' /"},
                 "'solid' is a list of points, which has no interior"),
                ("lattice", points, good, {"body": ""}, "its region is a list of points; write packing = 'file'"),
                ("box", "shape = 'box'  lo = 0 0 0  hi = 1 1 1", good, {}, "needs a region of shape = 'points'"),
                ("set", points, good, {"more": "&region name = 'b'  shape = 'union'  of = 'solid' /"},
                 "'solid' is a list of points, which has no interior"),
                ("output", points, good,
                 {"more": "&output name = 'o'  kind = 'particles'  count = 1  region = 'solid' /"},
                 "'solid' is a list of points, which has no interior"),
                ("stress", points, good, {"body": "packing = 'file'  initial_stress = 'file'"}, "has no field stress"),
                ("fresh", "shape = 'box'  lo = 0 0 0  hi = 1 1 1", good, {"body": "initial_stress = 'file'"},
                 "needs packing = 'file' and a snapshot"),
                ("file", "shape = 'points'  file = 'b.csv'", good, {}, "b.csv': No such file"),
                ("hdf", "shape = 'points'  file = 'b.hdf'", good, {}, "b.hdf': No such file")]:
            with sheet.part(name):
                run = self.run_of(options, name, shape, text, flags=("--check",), expect=2, **scene)
                assert message.format(run.folder / "a.csv") in run.output
                assert ": error: &" in run.output
