# SPDX-License-Identifier: BSD-3-Clause
"""Bodies with an initial stress from their weight (initial_stress = 'lithostatic').

Would catch a weight that omits a layer, or includes material above a gap or outside the grid, a stress along the wrong
direction or with the wrong sign, pressures that are lost in the first step because the density does not agree with
them, and a column that moves under a weight that it should support.
"""

import numpy as np

import case

DECK = """&run dimension = '{dimension}'  {method} /
&grid lo = 0 0 0  hi = {width} {width} 10  dx = 0.5 /
&time t_end = {end}  max_steps = {steps} /
&effects gravity = {gravity}  gravity_vector = {vector}
/
&boundary face = 'all'  type = 'slip' /
&boundary face = 'zhi'  type = 'outflow' /
&material name = 'soil'  density = 2000  shear = 1e7  {model} /
&material name = 'clay'  density = 1000  shear = 1e7  {model} /
&region name = 'low'  shape = 'box'  lo = 0 0 0  hi = {width} {width} 4 /
&region name = 'top'  shape = 'box'  lo = 0 0 {above}  hi = {width} {width} {end_of_top} /
&body name = 'low'  region = 'low'  material = 'soil'  initial_stress = '{stress}'  {more} /
&body name = 'top'  region = 'top'  material = 'clay'  initial_stress = '{stress_of_top}'  {more} /
&output name = 'p'  kind = 'particles'  precision = 'double'  count = 1  fields = 'default' 'stress' /
&output name = 'h'  kind = 'history'  every = 1 /
"""
SCENE = {"dimension": "plane_strain", "method": "", "end": 1, "steps": 0, "gravity": ".true.", "vector": "0 0 -10",
         "model": "bulk = 2e7", "above": 4, "end_of_top": 6, "stress": "lithostatic", "stress_of_top": "lithostatic",
         "more": "", "width": 2}


class TestLithostatic:
    """Two layers in a box, 4 m of soil under 2 m of clay."""

    def run_of(self, options, name, ranks=1, flags=("--quiet",), expect=0, **scene):
        """A run, by default of zero steps."""
        return case.Case(options, name, DECK.format(**{**SCENE, **scene}), ranks).run(*flags, expect=expect)

    def first(self, run):
        """Heights and stresses at the start."""
        snapshot = run.snapshots()[0][1]
        return snapshot.points, snapshot.fields["stress"], snapshot.fields

    def weight(self, z, density=(2000, 1000)):
        """Weight of the material above a height."""
        return 10 * (density[0] * np.maximum(4 - z, 0) + density[1] * (6 - np.maximum(z, 4)))

    def test_stress_at_the_start(self, options, sheet):
        """The weight of both layers along gravity and k0 times it across, in plane, 3-D and axisymmetric scenes."""
        for dimension in ("plane_strain", "3d", "axisymmetric"):
            with sheet.part(dimension):
                points, stress, fields = self.first(self.run_of(options, "start", dimension=dimension, more="k0 = 0.4"))
                wanted = self.weight(points[:, 2])
                assert wanted.max() > 9.5e4
                assert np.abs(stress[:, 2] + wanted).max() < 1e-6
                assert np.abs(stress[:, :2] + 0.4 * wanted[:, None]).max() < 1e-6
                assert np.abs(stress[:, 3:]).max() == 0.0
                # density that gives the pressure
                density = fields["mass"] / fields["volume"]
                strain = density / np.where(points[:, 2] < 4, 2000, 1000) - 1
                assert np.abs(2e7 * strain - 0.6 * wanted).max() < 0.005 * wanted.max()

    def test_oblique(self, options):
        """Inclined gravity: the stress along it is the weight along the path to the free surface or to a boundary."""
        points, stress, _ = self.first(self.run_of(options, "oblique", vector="6 0 -8", more="k0 = 0", end_of_top=9,
                                                   width=8))
        along = np.array([0.6, 0, -0.8])
        tensor = np.zeros((len(points), 3, 3))
        for k, (i, j) in enumerate([(0, 0), (1, 1), (2, 2), (0, 1), (1, 2), (0, 2)]):
            tensor[:, i, j] = tensor[:, j, i] = stress[:, k]
        x, z = points[:, 0], points[:, 2]
        out = np.minimum(x / 0.6, (9 - z) / 0.8)                # length of the path to the surface
        soil = np.clip(np.minimum((4 - z) / 0.8, out), 0, None)
        wanted = 10 * (2000 * soil + 1000 * (out - soil))
        assert np.abs(np.einsum("i,nij,j->n", along, tensor, along) + wanted).max() < 1e-3
        across = np.array([0.8, 0, 0.6])
        assert np.abs(np.einsum("i,nij,j->n", across, tensor, across)).max() < 1e-6

    def test_gaps_and_fresh_bodies(self, options):
        """Material above a gap adds no weight below it, nor does a body without initial stress."""
        points, stress, _ = self.first(self.run_of(options, "gap", above=5, end_of_top=7))
        low = points[:, 2] < 4
        assert np.abs(stress[low, 2] + 2e4 * (4 - points[low, 2])).max() < 1e-6
        assert np.abs(stress[~low, 2] + 1e4 * (7 - points[~low, 2])).max() < 1e-6
        points, stress, _ = self.first(self.run_of(options, "fresh", stress_of_top="zero"))
        assert np.abs(stress[low, 2] + 2e4 * (4 - points[low, 2])).max() < 1e-6
        assert np.abs(stress[~low]).max() == 0.0
        # cut at the boundary of the grid
        points, stress, _ = self.first(self.run_of(options, "high", end_of_top=12))
        assert abs(-stress[:, 2].max() - (1e4 * 0.125)) <= 0.5e-3

    def test_it_stays_at_rest(self, options, sheet):
        """Without initial stress the column falls; with it the column is at rest, for any model of the pressure."""
        for model, more in [("bulk = 2e7", {}), ("bulk = 2e7", {"gravity": ".true.  eos = .false."}),
                            ("eos_model = 'mie_gruneisen'  mg_c0 = 100  mg_s = 1.5  mg_gamma = 1", {}),
                            ("bulk = 2e7  strength_model = 'drucker_prager'  friction_angle = 35  cohesion = 1e3",
                             {"method": "method = 'mpm'"})]:
            with sheet.part(model, **more):
                speeds = []
                for ratio in ("", "k0 = 0.5", "k0 = 0.7"):
                    stress = "lithostatic" if ratio else "zero"
                    run = self.run_of(options, "rest", steps=120, model=model, stress=stress, stress_of_top=stress,
                                      **{"more": ratio, **more})
                    speeds.append(np.sqrt(2 * run.history["kinetic"].max() / run.history["mass"][0]))
                assert speeds[0] > 0.1
                assert max(speeds[1:]) < 0.01 * speeds[0]       # 0.0013 to 0.0030

    def test_clay(self, options, sheet):
        """Clay gets the density and the preconsolidation of its stress, so that it stays at rest; 1 and 2 ranks."""
        keys = "strength_model = 'cam_clay'  mcc_m = 1  mcc_lambda = 0.02  mcc_kappa = 0.004  mcc_v0 = 2  mcc_p0 = 5e4 "
        for more, ratio, least, steps in (("mcc_ocr = 1.5", 1.5, 0.0, 0), ("mcc_pc = 7e4", 1.0, 7.0e4, 60)):
            with sheet.part(more):
                scene = {"model": f"{keys} {more}", "more": "k0 = 0.6", "steps": steps}
                run = self.run_of(options, "clay", **scene)
                points, stress, fields = self.first(run)
                wanted = self.weight(points[:, 2])
                p, q = wanted * 2.2 / 3, wanted * 0.4
                assert np.abs(stress[:, 2] + wanted).max() < 1e-6
                consolidated = np.maximum(least, ratio * (p + q**2 / p))
                specific = 2 - 0.004 * np.log(p / 5e4) - 0.016 * np.log(consolidated / max(ratio * 5e4, least))
                density = np.where(points[:, 2] < 4, 2000, 1000) * 2 / specific
                assert np.abs(fields["mass"] / fields["volume"] / density - 1).max() < 1e-9
        # the weight is that of the density of the deck, which differs by 1 %; clay without stress falls at 0.1 m/s
        assert np.sqrt(2 * run.history["kinetic"].max() / run.history["mass"][0]) < 0.005
        assert self.run_of(options, "clay_ranks", 2, **scene).summary["digest"] == run.summary["digest"]

    def test_ranks_and_packings(self, options):
        """The same for any ranks; randomly placed particles have the stress of their own heights."""
        one = self.run_of(options, "one", steps=5)
        for ranks in (2, 3):
            assert self.run_of(options, "ranks", ranks, steps=5).summary["digest"] == one.summary["digest"]
        points, stress, _ = self.first(self.run_of(options, "disks", more="packing = 'poisson_disk'"))
        assert np.abs(stress[:, 2] + self.weight(points[:, 2])).max() < 1e-3

    def test_refused(self, options, sheet):
        """Each refusal states what to write instead."""
        for name, scene, message in [
                ("still", {"gravity": ".false.  !"}, "write &effects gravity = .true."),
                ("none", {"vector": "0 0 0"}, "needs gravity along a direction of the scene"),
                ("whole", {"model": "bulk = 2e7  strength_model = 'neo_hookean'",
                           "gravity": ".true.  eos = .false."}, "from its deformation alone"),
                ("ratio", {"stress": "zero", "more": "k0 = 1"}, "k0")]:
            with sheet.part(name):
                said = self.run_of(options, name, flags=("--check",), expect=2, **scene).output
                assert message in said
