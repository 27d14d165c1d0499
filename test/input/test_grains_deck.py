# SPDX-License-Identifier: BSD-3-Clause
"""A granular deck with the usual output fields for grains, and the meaning of these fields.

Would catch a deck of this kind that is refused: grains without an equation of state, cohesion of 0, mirror planes at
both sides of a plane scene; a column that does not come to rest, spreads like a fluid, or does not spread; a surface
height that is a mean over particles, a velocity that is a speed or an unweighted mean, an inertial number with another
rate or pressure, strain that is a shear strain and not the equivalent one, a run-out that a single grain determines,
and columns that were not requested.
"""

import re

import numpy as np
import pytest

import case
import flows

DECK = """! Collapse of a dry granular column on a rough base, plane strain, SI units, about a minute on a laptop.
&run
  title = 'granular column, aspect ratio 2, mu(I) rheology'
  case  = 'column_a2'
  dimension = 'plane_strain'        ! x-z plane, one cell in y
/
&grid
  lo = 0.0, 0.0, 0.0                ! m
  hi = 0.60, 0.0025, 0.15
  dx = 0.0025
/
&time
  t_end = 1.0                       ! s
  cfl   = 0.4
  stop_when = 'at_rest'   stop_value = 1.0e-4    ! kinetic / released potential energy
/
&method
  transfer = 'apic'
  antilock = 'bbar'
/
&effects
  gravity = .true.
  eos = .false.
  artificial_viscosity = .false.
  gravity_vector = 0.0, 0.0, -9.81
/
&material
  name = 'beads'
  density = 1500.0                  ! bulk, kg/m3
  young = 1.0e7   poisson = 0.3     ! softened on purpose: limits the sound speed to about 95 m/s
  strength_model = 'mu_i'
  mu_s = 0.38   mu_2 = 0.64   mu_i0 = 0.279
  grain_diameter = 2.0e-3   grain_density = 2500.0
  cohesion = 0.0
/
&region  name = 'column'  shape = 'box'  lo = 0.0, 0.0, 0.0  hi = 0.05, 0.0025, 0.10  /
&body
  name = 'grains'   region = 'column'   material = 'beads'
  ppc = 3, 1, 3
  initial_stress = 'lithostatic'   k0 = 0.5
/
&boundary  face = 'xlo'  type = 'symmetry'  /
&boundary  face = 'xhi'  type = 'outflow'   /
&boundary  face = 'ylo'  type = 'symmetry'  /
&boundary  face = 'yhi'  type = 'symmetry'  /
&boundary  face = 'zlo'  type = 'friction'   friction = 0.5  /
&boundary  face = 'zhi'  type = 'outflow'   /
&output
  name = 'flow'  kind = 'particles'  count = 50
  fields = 'velocity', 'pressure', 'inertial_number', 'equivalent_strain'
/
&output
  name = 'shape'  kind = 'profile'  axis = 'x'  bins = 240  dt = 0.01
  fields = 'surface_height', 'depth_mean_velocity'
/
&output
  name = 'budget'  kind = 'history'  every = 50
  fields = 'kinetic', 'potential', 'dissipated', 'runout', 'height'
/
"""
COARSE = ("--quiet", "--set", "grid.dx=0.005", "--set", "material.young=1e6")
SMALL = ("--set", "grid.dx=0.01", "--set", "material.young=1e6")
BLOCK = """&run dimension = '{dimension}' /
&grid lo = 0 0 1  hi = 4 2 5  dx = 0.5 /
&time t_end = 1  max_steps = {steps} /
&method transfer = 'pic' /
&effects gravity = {gravity}  artificial_viscosity = .false.  eos = .false. /
&material name = 'sand'  density = 2000  bulk = 1e8  shear = 5e7  strength_model = 'mu_i'
  mu_s = 0.4  mu_2 = 0.6  mu_i0 = 0.3  grain_diameter = 1e-3  grain_density = 2500 /
&region name = 'low'   shape = 'box'  lo = 1 0 1.5  hi = 2 2 2.5 /
&region name = 'high'  shape = 'box'  lo = 2 0 1.5  hi = 3 2 4 /
&body name = 'low'   region = 'low'   material = 'sand'  velocity = {low} /
&body name = 'high'  region = 'high'  material = 'sand'  velocity = {high} /
&output name = 'a'  kind = 'profile'  axis = '{axis}'  bins = 8  dt = 1
  fields = 'surface_height', 'depth_mean_velocity', 'velocity' /
&output name = 'b'  kind = 'history'  every = 1
  fields = 'front_x', 'tail_x', 'front_z', 'tail_z', 'height', 'runout', 'mass' {more} /
"""


def table(run, ending="_profile.csv"):
    """Columns of a table by their names without units."""
    return case.post().history(str(run.path(ending)))


def columns(run, ending):
    """The heading of a table."""
    return run.path(ending).read_text(encoding="utf-8").split("\n")[0]


class TestColumn:
    """The deck as provided, and its run with coarser and softer cells, which ends at rest."""

    @pytest.fixture(autouse=True, scope="class")
    @classmethod
    def made(cls, file_options):
        cls.run_ = case.Case(file_options, "column_a2", DECK).run(*COARSE)

    def test_check(self, options):
        run = case.Case(options, "check", DECK).run("--check", "--no-estimate")
        assert "0 errors, 0 warnings" in run.output
        assert re.search(r"equivalent_strain +8 bytes +output", run.output)
        assert re.search(r"inertial_number +8 bytes +output", run.output)
        assert "eos" not in run.output
        rest = re.sub(", 'inertial_number', 'equivalent_strain'", "", DECK)
        output = case.Case(options, "less", rest).run("--check", "--no-estimate", *SMALL).output
        assert not re.search("equivalent_strain|inertial_number", output)

    def test_columns(self):
        assert columns(self.run_, "_profile.csv") == (
            "time [s],step,bin,position [m],particles,mass [kg],"
            "volume [m3],surface_height [m],depth_mean_velocity [m/s]"
        )
        assert columns(self.run_, "_history.csv") == (
            "time [s],step,kinetic [J],potential [J],dissipated [J],runout [m],height [m]"
        )
        fields = self.run_.snapshots()[-1][1].fields
        assert sorted(fields) == ["equivalent_strain", "inertial_number", "pressure", "velocity"]

    def test_rest(self):
        """The column comes to rest with a run-out as measured for columns of grains, and its energy loss is
        recorded."""
        assert "kinetic energy below" in self.run_.summary["reason"]
        assert self.run_.summary["time"] > 0.2
        history = table(self.run_, "_history.csv")
        mass = 1500 * 0.05 * 0.0025 * 0.1
        assert abs(history["potential"][0] / (mass * 9.81 * 0.05) - 1.0) <= 2e-3
        assert abs(history["runout"][0] - (0.99 * 0.05)) <= 1e-6
        assert abs(history["height"][0] - 0.1) <= 1e-6
        # 1.2 and 1.9 a**(2/3) of the measured columns is 2.4 to 3.0 half widths for a = 2
        assert history["runout"][-1] / 0.05 - 1.0 > 2.0
        assert history["runout"][-1] / 0.05 - 1.0 < 4.0
        assert history["height"][-1] / 0.05 > 0.8
        assert history["height"][-1] / 0.05 < 1.4
        assert np.all(np.diff(history["dissipated"]) >= 0.0)
        assert history["dissipated"][-1] < history["potential"][0] - history["potential"][-1]
        assert history["dissipated"][-1] > 0.5 * (history["potential"][0] - history["potential"][-1])

    def test_profile(self):
        """At the end the surface descends outwards, and the front moved with the mean velocity over its depth."""
        profile = table(self.run_)
        last = profile["time"] == profile["time"].max()
        height = profile["surface_height"][last]
        filled = profile["particles"][last] > 0
        assert abs(height.max() - table(self.run_, "_history.csv")["height"][-1]) <= 1e-12
        assert height[~filled].max() == 0.0
        smooth = np.convolve(height, np.ones(20) / 20, mode="valid")
        assert np.diff(smooth).max() < 1e-3
        middle = np.abs(profile["time"] - 0.15) < 0.006
        assert profile["depth_mean_velocity"][middle].max() > 0.2

    def test_strain(self):
        """Material that has slid is strained by more than 1, the core hardly; nothing flows at the end."""
        snapshot = self.run_.snapshots()[-1][1]
        strain, number = snapshot.fields["equivalent_strain"], snapshot.fields["inertial_number"]
        assert strain.max() > 1.0
        assert strain.min() < 0.1
        assert number.min() >= 0.0
        flow = max(np.median(s.fields["inertial_number"]) for time, s in self.run_.snapshots() if time < 0.2)
        assert flow > 0.05
        assert np.median(number) < 0.1 * flow

    def test_bits(self, options):
        """Two ranks write the same tables."""
        short = ("--quiet", *SMALL, "--set", "time.t_end=0.05")
        one = case.Case(options, "one", DECK).run(*short)
        two = case.Case(options, "two", DECK, ranks=2).run(*short)
        for ending in ("_profile.csv", "_history.csv"):
            assert one.path(ending).read_bytes() == two.path(ending).read_bytes()
        assert one.summary["digest"] == two.summary["digest"]


class TestMeaning:
    """Fields of scenes with known values."""

    def block(self, options, name, expect=0, flags=("--quiet",), **words):
        words = {"dimension": "3d", "steps": 0, "gravity": ".false.", "low": "0 0 0", "high": "0 0 0", "more": "",
                 "axis": "x", **words}
        return case.Case(options, name, BLOCK.format(**words)).run(*flags, expect=expect)

    def test_surface(self, options, sheet):
        """Blocks of 1 m and 2.5 m whose lower ends are at 1.5 m; without material the height is that of the floor, 1
        m."""
        for dimension in ("3d", "plane_strain", "axisymmetric"):
            with sheet.part(dimension):
                run = self.block(options, "surface_" + dimension, dimension=dimension)
                height = table(run)["surface_height"][:8]
                assert np.abs(height - [1, 1, 2.5, 2.5, 4, 4, 1, 1]).max() < 2e-3
                assert abs(table(run, "_history.csv")["height"][0] - 4.0) <= 2e-3

    def test_ends(self, options):
        history = table(self.block(options, "ends"), "_history.csv")
        assert [history[name][0] for name in ("tail_x", "front_x", "tail_z", "front_z")] == [1.125, 2.875, 1.625, 3.875]
        # 99 % of 3.5 m2 is on the left of 3 m minus 1 % of it over the height of 2.5 m
        assert abs(history["runout"][0] - (3.0 - 0.035 / 2.5)) <= 1e-12

    def test_velocity(self, options):
        """A moving block has its velocity along the axis, not its speed, and a bin with two blocks their mean by
        mass."""
        run = self.block(options, "velocity", low="3 0 -1", high="-0.5 0 2", steps=1)
        profile = table(run)
        mean = profile["depth_mean_velocity"]
        assert np.abs(mean[:8] - [0, 0, 3, 3, -0.5, -0.5, 0, 0]).max() < 1e-12
        assert np.array_equal(mean, profile["velocity_x"])

    def test_potential(self, options):
        history = table(self.block(options, "potential", gravity=".true.", more="'potential'"), "_history.csv")
        energy = 2000 * 2 * 9.80665 * (1 * 1 * 2.0 + 1 * 2.5 * 2.75)
        assert abs(history["potential"][0] / energy - 1.0) <= 1e-12

    def test_refused(self, options, sheet):
        for more, said in (("'potential'", "output field 'potential' needs &effects gravity = .true."),
                           ("'front'", "output field 'front' is unknown in a history"),
                           ("'velocity_error'", "output field 'velocity_error' needs &exact"),
                           ("'front_y'", "output field 'front_y' is along a direction that the scene does not have")):
            with sheet.part(more):
                run = self.block(options, "refused", expect=2, more=more, dimension="plane_strain")
                assert said in run.output
        run = self.block(options, "axis_z", expect=2, axis="z")
        assert "surface_height is a height along z" in run.output

    def test_inertial_number(self, options):
        """Steady flow down a slope of 24 degrees has the same inertial number at all depths, at any pressure."""
        slope, layers, height, cell = np.radians(24.0), 20, 0.01, 0.001
        tangent = np.tan(slope)
        wanted = flows.I0 * (tangent - flows.MU_S) / (flows.MU_2 - tangent)
        bulk = 1000 * flows.DENSITY * flows.GRAVITY * height
        deck = flows.INCLINE.format(
            method="ddmp", words="flip=0.9999", spacing=cell, top=14 * cell, end=0.1,
            along=float(flows.GRAVITY * np.sin(slope)), down=float(-flows.GRAVITY * np.cos(slope)),
            density=flows.DENSITY, bulk=bulk, shear=0.46 * bulk, mu_s=float(flows.MU_S), mu_2=float(flows.MU_2),
            i0=flows.I0, diameter=flows.DIAMETER, grain_density=flows.GRAIN_DENSITY)
        deck = deck.replace("&effects ", "&effects  eos=.false. ")
        for n in range(layers):
            low, high = n * height / layers, (n + 1) * height / layers
            deck += (f"&region name='r{n}' shape='box' lo=0,0,{low!r} hi={cell!r},1,{high!r} /\n"
                     f"&body name='b{n}' region='r{n}' material='beads' ppc=2,1,2 "
                     f"velocity={float(flows.bagnold(0.5 * (low + high), 24.0, height))!r},0,0 /\n")
        deck += ("&output name='p' kind='profile' axis='z' bins=14 dt=0.1 fields='velocity','pressure',"
                 "'inertial_number','equivalent_strain' /\n")
        profile = table(case.Case(options, "incline", deck).run("--quiet"))
        first, last = (profile["time"] == when for when in (0.0, profile["time"].max()))
        number = profile["inertial_number"][last][1:8]
        assert np.abs(number / wanted - 1.0).max() < 0.05
        # that of the formula, with the velocities and pressures of the same layers
        shear = np.gradient(profile["velocity_x"][last], cell)[1:8]
        formula = shear * flows.DIAMETER * np.sqrt(flows.GRAIN_DENSITY / profile["pressure"][last][1:8])
        assert np.abs(number / formula - 1.0).max() < 0.01
        # the strain is that of the initial velocity, because the flow hardly changes
        rate = np.gradient(profile["velocity_x"][first], cell)[1:8]
        strain = profile["equivalent_strain"][last][1:8]
        assert np.abs(strain / (0.1 * rate / np.sqrt(3.0)) - 1.0).max() < 0.05


class TestWithout:
    """Grains without an equation of state behave as with the linear one; boundaries across a plane scene."""

    def test_same_bits(self, options):
        """Would catch another pressure than that of the linear equation of state, and a cohesion of 0 that has an
        effect."""
        short = ("--quiet", *SMALL, "--set", "time.t_end=0.05")
        off = case.Case(options, "off", DECK).run(*short)
        linear = case.Case(options, "linear", DECK.replace("eos = .false.", "eos = .true.").replace(
            "cohesion = 0.0", "")).run(*short)
        assert off.summary["digest"] == linear.summary["digest"]
        assert "eos" in linear.summary["timers"]
        assert "eos" not in off.summary["timers"]

    def test_cohesion(self, options):
        """With a cohesion of half its weight over the height the column does not collapse."""
        run = case.Case(options, "stands", DECK).run(*COARSE, "--set", "material.cohesion=800",
                                                     "--set", "time.t_end=0.12")
        assert table(run, "_history.csv")["runout"][-1] < 0.055

    def test_faces(self, options, sheet):
        for words, fine in (("'slip'", True), ("'stick'", False), ("'symmetry' t_on = 0.1", False),
                            ("'symmetry' temperature = 300", False), ("'periodic'", False)):
            deck = DECK.replace("face = 'ylo'  type = 'symmetry'", f"face = 'ylo'  type = {words}")
            with sheet.part(words):
                run = case.Case(options, "faces", deck).run("--check", "--no-estimate", *SMALL,
                                                         expect=0 if fine else 2)
                if not fine:
                    assert "dimension = 'plane_strain' has no face ylo" in run.output
