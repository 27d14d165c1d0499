# SPDX-License-Identifier: BSD-3-Clause
"""A run that starts from a snapshot follows the run that wrote it, unchanged or scaled and rotated.

Would catch a first step in which the forces act for half a step too little, a first step of another length, fields that
are lost, and vectors and tensors that are not rotated or scaled with the positions.
"""

import numpy as np

import case

DECK = """&run dimension = '{dimension}'  {method} /
&grid lo = 0 0 0  hi = {size} {wide} {size}  dx = {dx} /
&time t_end = 1  max_steps = {steps}  {time} /
{more}
&material name = 'metal'  {material} /
&region name = 'solid'  {shape} /
&body name = 'one'  region = 'solid'  material = 'metal'  {body} /
&output name = 'p'  kind = 'particles'  precision = '{precision}'  every = {every}  fields = {fields} /
&output name = 'h'  kind = 'history'  every = 1 /
"""
FALL = "&effects gravity = .true. /\n&boundary face = 'zlo'  type = 'slip' /\n"
SCENE = {"dimension": "3d", "method": "", "size": 1, "wide": 1, "dx": 0.125, "time": "", "precision": "double",
         "fields": "'state'", "more": FALL, "material": "density = 1000  bulk = 1e9  shear = 5e8",
         "shape": "shape = 'sphere'  centre = 0.5 0.5 0.32  radius = 0.3", "body": "velocity = 1 2 -30  spin = 0 0 50"}
ALUMINIUM = """density = 2785  eos_model = 'mie_gruneisen'  mg_c0 = 5328  mg_s = 1.338  mg_gamma = 2  shear = 28.6e9
  strength_model = 'johnson_cook'  jc_a = 2.65e8  jc_b = 4.26e8  jc_n = 0.34  jc_c = 0.015  jc_m = 1
  t_ref = 293  t_melt = 775  specific_heat = 875
  damage_model = 'johnson_cook'  jcd = 0.13 0.13 -1.5 0.011 0  spall = 1.2e9"""
HEAT = "&effects damage = .true.  thermal = .true.  melting = .true. /\n"
QUANTITIES = ("points", "velocity", "stress", "volume")


def table(snapshot, origin=None):
    """Values by quantity, in the order of identities, or in that of the rows from which they were read."""
    identity = snapshot.fields["identity"]
    if origin is not None:
        identity = origin.fields["identity"][identity - 1]
    order = np.argsort(identity)
    return {name: values[order] for name, values in [("points", snapshot.points), *snapshot.fields.items()]}


class TestGoingOn:
    """Pairs of runs."""

    def run_of(self, options, name, steps, **scene):
        """A run with a snapshot after each half of its steps."""
        run = case.Case(options, name, DECK.format(steps=steps, **{**SCENE, "every": 30, **scene}))
        return run.run("--quiet")

    def pair(self, options, first, placing="", **second):
        """A run of 60 steps, and one that starts from its state after half of them: end of the whole run, its half, and
        end of the second run."""
        whole = self.run_of(options, "whole", 60, **first)
        shape = f"shape = 'points'  file = '{whole.path('_p_000001.hdf')}'  {placing}"
        body = "packing = 'file'  initial_stress = 'file'"
        rest = self.run_of(options, "rest", 30, **{**first, "shape": shape, "body": body, **second})
        return [whole.snapshots()[n][1] for n in (2, 1)] + [rest.snapshots()[n][1] for n in (1, 0)]

    def difference(self, found, wanted):
        """Greatest difference over the greatest value, of each quantity."""
        result = {}
        for name in QUANTITIES:
            scale = np.abs(wanted[name]).max()
            assert scale > 0.0, name
            result[name] = np.abs(found[name] - wanted[name]).max() / scale
        return result

    def follows(self, pair, limit):
        """The second run ends as the whole run within a limit, and the state has changed much since the half."""
        whole, half, rest, _ = pair
        found, wanted = table(rest, half), table(whole)
        for name, difference in self.difference(found, wanted).items():
            assert difference < limit, name
        before = table(half)
        assert self.difference(before, wanted)["velocity"] > 1e-3
        assert self.difference(before, wanted)["stress"] > 1e-2
        # an error of half a step of force would be far above the limit
        assert (
            abs(rest.provenance["time"] - (whole.provenance["time"] - half.provenance["time"]))
            <= limit * whole.provenance["time"]
        )

    def test_methods(self, options, sheet):
        """To rounding with each order of update; the step length changes, so the length of the first step matters."""
        for method in ("ddmp", "mpm"):
            for update in ("usl", "usf", "musl", "usavg"):
                if (method, update) in (("mpm", "usl"), ("mpm", "usavg")):
                    continue
                with sheet.part(f"{method} {update}"):
                    more = f"&method stress_update = '{update}' /\n" + FALL
                    self.follows(self.pair(options, {"method": f"method = '{method}'", "more": more}), 1e-12)
        for how in ("basis = 'gimp'", "basis = 'cpdi'", "basis = 'quadratic'  transfer = 'aflip'"):
            with sheet.part(how):
                self.follows(self.pair(options, {"method": "method = 'mpm'", "more": f"&method {how} /\n" + FALL}),
                             1e-12)
        self.follows(self.pair(options, {"more": "&method paper = .true. /\n" + FALL}), 1e-12)

    def test_precision(self, options):
        """Fields in single precision: agreement to single precision."""
        self.follows(self.pair(options, {"precision": "single"}), 1e-5)

    def test_matter(self, options):
        """Material with energy, temperature, plastic strain and damage; large deformation with another law."""
        hot = {"material": ALUMINIUM, "more": HEAT + "&boundary face = 'zlo'  type = 'slip' /\n",
               "body": "velocity = 0 0 -900  temperature = 300"}
        pair = self.pair(options, hot)
        self.follows(pair, 1e-11)
        for name in ("plastic_strain", "temperature", "energy", "damage"):
            assert np.abs(pair[0].fields[name]).max() > 0.0, name
            found, wanted = table(pair[2], pair[1])[name], table(pair[0])[name]
            assert np.abs(found - wanted).max() < 1e-11 * np.abs(wanted).max(), name
        rubber = "density = 1000  bulk = 1e9  shear = 5e8  strength_model = 'neo_hookean'"
        self.follows(self.pair(options, {"material": rubber}), 1e-12)

    def test_turned(self, options, sheet):
        """Rotated by a right angle, translated by tiles, and twice as large with cells and times twice as large, the
        run is the same: vectors, tensors, boxes and times are transformed. usavg averages rotations over tiles, so both
        grids consist of whole tiles."""
        ball = {"shape": "shape = 'sphere'  centre = 0.5 0.5 0.5  radius = 0.3", "more": "",
                "body": "velocity = 1 2 -30  spin = 20 30 500"}
        turn = np.array([[0, -1, 0], [1, 0, 0], [0, 0, 1.0]])          # 90 degrees about z
        rubber = "density = 1000  bulk = 1e9  shear = 5e8  strength_model = 'neo_hookean'"
        for name, how in [("ddmp", {}), ("law", {"material": rubber}),
                          ("gimp", {"method": "method = 'mpm'", "more": "&method basis = 'cpgimp' /"}),
                          ("cpdi", {"method": "method = 'mpm'", "more": "&method basis = 'cpdi' /"}),
                          ("aflip", {"method": "method = 'mpm'",
                                     "more": "&method basis = 'quadratic'  transfer = 'aflip' /"})]:
            with sheet.part(name):
                first = {**ball, "size": 1.5, "wide": 1.5, **how}
                whole, half, rest, _ = self.pair(options, first, "scale = 2  rotate = 0 0 90  translate = 3 1.5 0",
                                                 size=3, wide=4.5, dx=0.25)
                found, wanted = table(rest, half), table(whole)
                assert np.abs(wanted["stress"][:, 3:]).max() > 1e4
                wanted["points"] = 2 * wanted["points"] @ turn.T + [3, 1.5, 0]
                wanted["velocity"] = wanted["velocity"] @ turn.T
                xx, yy, zz, xy, yz, xz = wanted["stress"].T
                wanted["stress"] = np.column_stack([yy, xx, zz, -xy, xz, -yz])
                wanted["volume"] *= 8
                for quantity, difference in self.difference(found, wanted).items():
                    assert difference < 1e-10, quantity
                assert abs(2 * (whole.provenance["time"] - half.provenance["time"]) - rest.provenance["time"]) <= 1e-12

    def test_turned_fields(self, options):
        """Any angles: each field against its rotation by matrices in this test, in the order x, y, z of the angles."""
        law = "density = 1000  bulk = 1e9  shear = 5e8  strength_model = 'neo_hookean'"
        angles = np.radians([20, -35, 50])
        turn = np.eye(3)
        for k, angle in enumerate(angles):
            one, (i, j) = np.eye(3), [(1, 2), (2, 0), (0, 1)][k]
            one[i, i] = one[j, j] = np.cos(angle)
            one[j, i], one[i, j] = np.sin(angle), -np.sin(angle)
            turn = one @ turn
        for how in ({}, {"method": "method = 'mpm'", "more": "&method basis = 'cpdi'  transfer = 'aflip' /"}):
            first = {"material": law, "shape": "shape = 'sphere'  centre = 0 0 0  radius = 0.3", "more": "", "size": 1,
                     "body": "velocity = 1 2 -30  spin = 20 30 500", **how}
            deck_lo = "lo = -1 -1 -1"
            whole = case.Case(options, "turned", DECK.format(steps=30, **{**SCENE, "every": 30, **first})
                              .replace("lo = 0 0 0", deck_lo)).run("--quiet")
            file = whole.path("_p_000001.hdf")
            placing = "scale = 1.5  rotate = 20 -35 50  translate = 0.1 0.2 -0.1"
            run = case.Case(options, "rest", DECK.format(steps=0, **{
                **SCENE, "every": 30, **first, "shape": f"shape = 'points'  file = '{file}'  {placing}",
                "body": "packing = 'file'  initial_stress = 'file'"}).replace("lo = 0 0 0", deck_lo)).run("--quiet")
            before = whole.snapshots()[1][1]
            found, old = table(run.snapshots()[0][1], before), table(before)
            wanted = {"points": 1.5 * old["points"] @ turn.T + [0.1, 0.2, -0.1], "velocity": old["velocity"] @ turn.T,
                      "mass": 1.5**3 * old["mass"], "volume": 1.5**3 * old["volume"]}
            if "spin" in old:
                wanted["spin"] = old["spin"] @ turn.T / 1.5
            xx, yy, zz, xy, yz, xz = old["stress"].T
            full = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]]).transpose(2, 0, 1)
            full = turn @ full @ turn.T
            wanted["stress"] = np.column_stack([full[:, i, j] for i, j in ((0, 0), (1, 1), (2, 2), (0, 1), (1, 2),
                                                                           (0, 2))])
            for name, factor in (("deformation_gradient", 1), ("ahead", 1), ("affine", 1 / 1.5)):
                if name in old:         # columns of the matrix one after another
                    full = turn @ old[name].reshape(-1, 3, 3).transpose(0, 2, 1) @ turn.T
                    wanted[name] = factor * full.transpose(0, 2, 1).reshape(-1, 9)
            if "domain" in old:         # edges one after another
                wanted["domain"] = 1.5 * (old["domain"].reshape(-1, 3, 3) @ turn.T).reshape(-1, 9)
            assert {"spin", "ahead"} <= set(wanted) if not how else "domain" in wanted
            for name, values in wanted.items():
                assert np.abs(found[name] - values).max() < 1e-13 * np.abs(values).max(), name
            assert np.abs(old["stress"][:, 3:]).max() > 1e3

    def test_plane_and_rings(self, options):
        """In a plane scene points are rotated within the plane and masses grow with the square of the factor, because
        the depth is constant; masses of rings grow with the cube."""
        for dimension, placing, power in (("plane_strain", "scale = 2  rotate = 0 90 0  translate = 0 0 2.5", 2),
                                          ("axisymmetric", "scale = 2", 3)):
            first = {"dimension": dimension, "more": "", "size": 1.25, "body": "velocity = 1 0 -30  spin = 0 500 0",
                     "shape": "shape = 'sphere'  centre = 0.5 0.5 0.5  radius = 0.3"}
            if power == 3:
                first.update(more="&boundary face = 'zlo'  type = 'slip' /", body="velocity = 0 0 -30",
                             shape="shape = 'sphere'  centre = 0 0 0.32  radius = 0.3")
            whole, half, rest, begin = self.pair(options, first, placing, size=2.5, dx=0.25)
            found, wanted = table(rest, half), table(whole)
            turn = np.array([[0, 0, 1], [0, 1, 0], [-1, 0, 0.0]]) if power == 2 else np.eye(3)
            wanted["velocity"] = wanted["velocity"] @ turn.T
            middle = 0.5 if power == 2 else 0.0
            wanted["points"] = 2 * wanted["points"] @ turn.T + [0, 0, 2.5 if power == 2 else 0]
            wanted["points"][:, 1] = middle
            wanted["volume"] *= 2**power
            if power == 2:
                wanted["stress"] = wanted["stress"][:, [2, 1, 0, 4, 3, 5]] * [1, 1, 1, 1, -1, -1]
            assert np.abs(wanted["stress"]).max() > 1e4
            assert abs(begin.fields["mass"].sum() / half.fields["mass"].sum() - (2**power)) <= 0.5e-7
            for quantity, difference in self.difference(found, wanted).items():
                assert difference < 1e-10, f"{dimension} {quantity}"

    def test_told(self, options):
        """Fields that cannot be rotated, and an effect that is off, are reported; times of the first step are
        multiplied by the factor."""
        boxes = {"method": "method = 'mpm'", "more": "&method basis = 'gimp' /", "body": "velocity = 0 0 -30"}
        half = self.run_of(options, "half", 30, **boxes)
        file = half.path("_p_000001.hdf")
        shape = f"shape = 'points'  file = '{file}'  rotate = 0 0 30  translate = 0.4 0 0"
        run = case.Case(options, "boxes", DECK.format(steps=0, **{**SCENE, "every": 30, **boxes, "shape": shape,
                                                                 "body": "packing = 'file'"}))
        run.run("--check", "--no-estimate")
        assert "so 'extent' of" in run.output
        shape = f"shape = 'points'  file = '{file}'"
        for paper, expected in ((".false.", False), (".true.", True)):
            run = case.Case(options, "paper", DECK.format(steps=0, **{
                **SCENE, "every": 30, "more": f"&method paper = {paper} /", "shape": shape,
                "body": "packing = 'file'"}))
            run.run("--check", "--no-estimate")
            assert (" s earlier than the positions, but the first step" in run.output) == expected, run.output
        first = self.run_of(options, "first", 0, **boxes)
        assert first.snapshots()[0][1].provenance["velocity_lag"] == 0.0
        clock = half.snapshots()[1][1].provenance
        assert clock["velocity_lag"] == 0.5 * clock["dt"]
        assert clock["dt_next"] > 0.0
