# SPDX-License-Identifier: BSD-3-Clause
# tiers: smoke
"""Prisms of polygons, in plane and 3-D scenes, and invalid polygons.

Would catch coordinates of the polygon in the wrong order, an edge that is crossed twice or not at all at a corner,
adjacent prisms that share particles or omit some, an end that is included twice, and a polygon that crosses itself and
is accepted.
"""

import numpy as np

import case

DECK = """&run dimension = '{dimension}' /
&grid lo = 0 0 0  hi = 1 1 1  dx = {dx} /
&time t_end = 1  max_steps = 0 /
&material name = 'metal'  density = 1000  bulk = 1e9  shear = 1e9 /
&region name = 'solid'  shape = 'prism'  {shape} /
&body name = 'one'  region = 'solid'  material = 'metal'  {packing} /
"""
TRIANGLE = "polygon = 0 0  0.75 0  0 0.5"
HOOK = np.array([(0.1, 0.2), (0.9, 0.15), (0.8, 0.7), (0.6, 0.4), (0.3, 0.85), (0.15, 0.6)])


def text(corners):
    """Numbers of a deck."""
    return "polygon = " + "  ".join(f"{a!r} {b!r}" for a, b in corners.tolist())


def area(corners):
    """Area of a polygon."""
    a, b = corners, np.roll(corners, -1, axis=0)
    return abs((a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]).sum()) / 2


class TestPrisms:
    """Particles of the first state."""

    def run_of(self, options, name, shape, dimension="plane_strain", dx=0.03125, packing="", flags=("--quiet",),
               expect=0):
        """A run of zero steps."""
        deck = DECK.format(dimension=dimension, dx=dx, shape=shape, packing=packing)
        return case.Case(options, name, deck).run(*flags, expect=expect)

    def points(self, run):
        """Positions."""
        return {tuple(point) for point in run.snapshots()[-1][1].points}

    def test_the_area(self, options, sheet):
        """Sites cut at the edges have the area of the polygon; whole sites approximately so; for both orientations."""
        for name, corners in [("hook", HOOK), ("back", HOOK[::-1]), ("closed", np.append(HOOK, HOOK[:1], axis=0))]:
            with sheet.part(name):
                run = self.run_of(options, name, text(corners))
                assert abs(len(self.points(run)) / 64**2 / area(HOOK) - 1) < 0.005
                run = self.run_of(options, name, text(corners), packing="packing = 'cut'")
                mass = run.snapshots()[-1][1].fields["mass"].sum() / 1000
                assert abs(mass / area(HOOK) - 1) < 0.001

    def test_on_the_lattice(self, options):
        """Edges through lattice points: two halves of a rectangle together have all of its particles."""
        shift = "  translate = 0.015625 0 0.015625"
        wanted = self.run_of(options, "whole", "polygon = 0 0  0.75 0  0.75 0.5  0 0.5" + shift)
        lower = self.run_of(options, "lower", TRIANGLE + shift)
        upper = self.run_of(options, "upper", "polygon = 0.75 0  0.75 0.5  0 0.5" + shift)
        assert len(self.points(wanted)) == 48 * 32
        assert len(self.points(lower)) + len(self.points(upper)) == 48 * 32
        assert self.points(lower) | self.points(upper) == self.points(wanted)
        assert min(len(self.points(lower)), len(self.points(upper))) > 750

    def test_axes_in_space(self, options):
        """The coordinates of the polygon are those other than the axis, in order; the upper end is excluded."""
        for axis, order in [(0, (1, 2)), (1, (0, 2)), (2, (0, 1))]:
            direction = [int(k == axis) for k in range(3)]
            shape = f"{TRIANGLE}  axis = {direction[0]} {direction[1]} {direction[2]}  span = 0.125 0.5"
            found = np.array(sorted(self.points(self.run_of(options, "axis", shape, "3d", 0.125))))
            assert found[:, axis].min() == 0.15625
            assert found[:, axis].max() == 0.46875
            a, b = found[:, order[0]], found[:, order[1]]
            assert (a / 0.75 + b / 0.5 < 1 + 1e-9).all()
            line = (np.arange(16) + 0.5) / 16
            inside = (line[:, None] / 0.75 + line[None, :] / 0.5 < 1).sum()
            assert abs(len(found) / 6 - inside) < 3
            assert len(found) > 200

    def test_scaled_and_turned(self, options):
        """A rotation about the axis and a scale factor: the area is that of the transformed polygon."""
        shape = text(HOOK) + "  scale = 0.7  rotate = 0 30 0  translate = 0 0 0.35"
        run = self.run_of(options, "turned", shape, packing="packing = 'cut'")
        mass = run.snapshots()[-1][1].fields["mass"].sum() / 1000
        assert abs(mass / (0.49 * area(HOOK)) - 1) < 0.002

    def test_refused(self, options, sheet):
        """Each refusal has its line, and states what to write instead."""
        for name, shape, dimension, message in [
                ("odd", "polygon = 0 0  1 0  1", "plane_strain", "polygon has 5 numbers, but each corner needs two"),
                ("two", "polygon = 0 0  1 0", "plane_strain", "a polygon needs at least three corners"),
                ("bow", "polygon = 0 0  1 1  1 0  0 1", "plane_strain",
                 "the edges of the polygon after corners 1 and 3 cross or touch"),
                ("flat", "polygon = 0 0  0.5 0.5  1 1", "plane_strain", "the polygon has no area"),
                ("span", TRIANGLE, "3d", "in 3-D a prism needs span"),
                ("ends", TRIANGLE + "  span = 0.5 0.5", "3d", "the end of span must be above its start"),
                ("wide", TRIANGLE + "  span = 0 1", "plane_strain", "remove span"),
                ("axis", TRIANGLE + "  axis = 1 1 0  span = 0 1", "3d", "must be a coordinate axis"),
                ("plane", TRIANGLE + "  axis = 0 0 1", "plane_strain", "remove axis"),
                ("line", TRIANGLE, "1d", "a 1-D scene has no plane for a polygon; use a box"),
                ("none", "", "plane_strain", "polygon")]:
            with sheet.part(name):
                said = self.run_of(options, name, shape, dimension, flags=("--check",), expect=2).output
                assert message in said
                assert ".nml:5: error" in said
