# SPDX-License-Identifier: BSD-3-Clause
"""Bodies that are repeated, have a velocity by speed and direction, are rotated about their centres, or have velocities
by formulas.

Would catch a copy that differs from the same body written by hand, a direction that is not normalised, a rotation about
the wrong point, velocities of a formula at other positions or in other units, or that depend on ranks, and bodies that
the echo repeats again.
"""

import numpy as np

import case

DECK = """&run dimension = 'plane_strain'  {method} /
&units system = '{units}' /
&grid lo = 0 0 0  hi = 20 mm, 1 mm, 20 mm  dx = 0.5 mm /
&time t_end = 1 us /
&material name = 'al'  density = 2.7 g/cm3  young = 70 GPa  poisson = 0.3 /
{bodies}
&output name = 'p'  kind = 'particles'  precision = 'double'  count = 1  fields = 'default'{fields} /
"""
BOX = "&region name = '{0}'  shape = 'box'  lo = 2 mm, 0, 2 mm  hi = 6 mm, 1 mm, 3 mm  {1} /\n"
BODY = "&body name = '{0}'  region = '{0}'  material = 'al'  {1} /\n"


class TestBodies:
    """Bricks in a box."""

    def run_of(self, options, name, bodies, ranks=1, expect=0, units="mm-us-mg", method="", fields=""):
        """A run with some bodies."""
        deck = DECK.format(bodies=bodies, units=units, method=method, fields=fields)
        return case.Case(options, name, deck, ranks).run("--quiet", expect=expect)

    def test_repeated(self, options):
        """A lattice of repeated bricks against the same bricks written by hand, and its echo."""
        run = self.run_of(options, "repeated", BOX.format("a", "translate = 0, 0, 0.25") + BODY.format(
            "a", "velocity = 0 0 -1  repeat = 2, 1, 3  repeat_step = 7, 0, 5"))
        written = ""
        for k in range(3):
            for i in range(2):
                name = f"a_{i + 1}_{k + 1}"
                written += BOX.format(name, f"translate = {7 * i}, 0, {0.25 + 5 * k}") + BODY.format(
                    name, "velocity = 0 0 -1")
        assert run.summary["digest"] == self.run_of(options, "written", written).summary["digest"]
        echo = run.path(".echo.nml").read_text(encoding="utf-8")
        again = case.Case(options, "echo", echo).run("--quiet")
        assert run.summary["digest"] == again.summary["digest"]

    def test_speed_and_direction(self, options):
        """A speed with a direction of any length, against the velocity."""
        speed = self.run_of(options, "speed", BOX.format("a", "") + BODY.format(
            "a", "speed = 5 km/s  direction = 30, 0, -40"))
        velocity = self.run_of(options, "velocity", BOX.format("a", "") + BODY.format("a", "velocity = 3, 0, -4"))
        assert velocity.summary["steps"] > 1
        assert speed.summary["digest"] == velocity.summary["digest"]

    def test_rotation_about_the_centre(self, options):
        """A rotated brick keeps its centre, also when it is scaled and translated; rotated about the origin it leaves
        the box."""
        run = self.run_of(options, "turned", BOX.format(
            "a", "scale = 1.5  rotate = 0 90 0  rotate_about = 'centre'  translate = 2, 0, 3") + BODY.format("a", ""))
        points = run.snapshots()[0][1].points * 1e3
        # 1.5 (4, 2.5) + (2, 3), and 1.5 x 1 times 4 x 1.5 around it, in whole sites of 0.25
        assert np.abs(points.mean(axis=0)[[0, 2]] - [8, 6.75]).max() < 1e-12
        assert np.abs(np.ptp(points, axis=0)[[0, 2]] - [1.25, 5.75]).max() < 1e-12
        lost = self.run_of(options, "lost", BOX.format("a", "rotate = 0 90 0") + BODY.format("a", ""), expect=2)
        assert "lies outside of the grid" in lost.output
        none = self.run_of(options, "none", "&region name = 'a'  shape = 'halfspace'  centre = 5 0 5  normal = 0 0 1  "
                           "rotate_about = 'centre' /\n" + BODY.format("a", ""), expect=2)
        assert "a halfspace has no centre to rotate about" in none.output

    def test_formula(self, options):
        """Velocities at the particles, in two systems of units, on two ranks, and the linear velocity fields of
        APIC."""
        body = BOX.format("a", "") + BODY.format("a", "{}")
        mine = body.format("velocity = 0.1 0 0  velocity_formula = '{1/4}*(x - 4)', '7', '-0.2*z + sin(x)'")
        run = self.run_of(options, "formula", "&define b = 1 /\n" + mine)
        first = run.snapshots()[0][1]
        x, z = first.points[:, 0] * 1e3, first.points[:, 2] * 1e3
        wanted = np.stack([0.1 + (x - 4) / 4, 0 * x, -0.2 * z + np.sin(x)], axis=1) * 1e3
        assert np.ptp(wanted[:, 0]) > 500.0
        assert np.abs(first.fields["velocity"] - wanted).max() < 1e-9
        two = self.run_of(options, "ranks", mine, ranks=2)
        assert run.summary["digest"] == two.summary["digest"]
        formula = "'(1/4*(x*1e3 - 4))*1e3', '7', '(-0.2*z*1e3 + sin(x*1e3))*1e3'"
        plain = self.run_of(options, "plain", body.format(f"velocity = 100 0 0  velocity_formula = {formula}"),
                            units="si").snapshots()[0][1]
        assert np.abs(plain.fields["velocity"] - wanted).max() < 1e-9

    def test_formula_turns_as_spin_does(self, options, sheet):
        """A rotation by formula about the centre of mass gives the state of the key `spin`, also for APIC."""
        omega = 0.002
        for method in ("method = 'ddmp'", "/\n&method transfer = 'apic'"):
            with sheet.part(method):
                states = []
                for name, motion in (("spin", f"spin = 0, {omega}/us, 0"),
                                     ("turn", f"velocity_formula = '{omega}*(z - 2.5)', '0', '-{omega}*(x - 4)'")):
                    run = self.run_of(options, name, BOX.format("a", "") + BODY.format("a", motion), method=method)
                    states.append(run.snapshots()[-1][1].fields["velocity"])
                scale = 1e6 * omega * 2e-3
                assert np.abs(states[0]).max() > 0.5 * scale
                assert np.abs(states[0] - states[1]).max() < 1e-9 * scale

    def test_formula_without_a_value(self, options):
        """The offending particle is reported with its position, also if it is on another rank."""
        for ranks in (1, 2):
            run = self.run_of(options, "hole", BOX.format("a", "") + BODY.format(
                "a", "velocity_formula = 'sqrt(x - 4)', '0', '0'"), ranks=ranks, expect=2)
            assert "&body 'a': velocity_formula: " in run.output
