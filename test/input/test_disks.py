# SPDX-License-Identifier: BSD-3-Clause
"""Particles at random positions with a least distance (packing = 'poisson_disk').

Would catch particles closer than the least distance, above all where blocks of cells meet and across periodic
boundaries, particles that depend on ranks, threads or tiles, a pattern that repeats or ignores the seed, a mass other
than that of the lattice, and far more or fewer particles than ppc specifies.
"""

import numpy as np

import case

DECK = """&run dimension = '{dimension}'  seed = {seed} /
&grid lo = 0 0 0  hi = {hi} {hi} {hi}  dx = 0.0625  {grid} /
&time t_end = 1  max_steps = 0 /
&material name = 'metal'  density = 1000  bulk = 1e9  shear = 1e9 /
{faces}
&region name = 'solid'  {shape} /
&body name = 'one'  region = 'solid'  material = 'metal'  packing = '{packing}'  ppc = {ppc} /
&output name = 'p'  kind = 'particles'  precision = 'double'  fields = 'default'  count = 1 /
"""
BOX = "shape = 'box'  lo = -1 -1 -1  hi = 99 99 99"
BALL = "shape = 'sphere'  centre = 0.5 0.5 0.5  radius = 0.4"
WALLS = "&boundary face = 'all'  type = 'periodic' /"


def least(points, bound):
    """Least distance between two particles, if it is below a bound."""
    points = points[np.argsort(points[:, 0])]
    best, step = bound, 1
    while True:
        off = points[step:] - points[:-step]
        near = off[:, 0] < bound
        if not near.any():
            return best
        best = min(best, np.sqrt((off[near]**2).sum(axis=1)).min())
        step += 1


class TestDisks:
    """Particles of the first state."""

    def run_of(self, options, name, shape, dimension="3d", hi=1, seed=1, ranks=1, packing="poisson_disk", ppc="2 2 2",
               faces="",
               grid="", flags=(), threads=1):
        """A run of zero steps."""
        deck = DECK.format(dimension=dimension, hi=hi, shape=shape, seed=seed, packing=packing, ppc=ppc, faces=faces,
                           grid=grid)
        return case.Case(options, name, deck, ranks, threads).run(*flags)

    def told(self, run):
        """Least distance that the program reports."""
        return float(run.output.split("points at least ")[1].split()[0])

    def test_distance_number_and_mass(self, options, sheet):
        """In each kind of scene: no distance below the reported one, about ppc particles per cell, the mass of the
        lattice."""
        for dimension, directions, hi, share in [("3d", 3, 1, 0.8), ("plane_strain", 2, 2, 0.75), ("1d", 1, 16, 0.7),
                                                 ("axisymmetric", 2, 2, 0.75)]:
            with sheet.part(dimension):
                run = self.run_of(options, dimension, BOX, dimension, hi)
                first = run.snapshots()[-1][1]
                sites = (hi / 0.03125)**directions
                assert abs(len(first.points) / sites - 1) < 0.03
                promised = self.told(run)
                assert promised > share * 0.03125
                assert least(first.points, 1.1 * promised) >= promised * (1 - 1e-5)
                assert least(first.points, 1.1 * promised) < promised * 1.02
                mass = first.fields["mass"].sum()
                volume = {"3d": 1, "1d": hi**3, "axisymmetric": np.pi * hi**3}.get(dimension, hi**3)
                assert abs(mass / (1000 * volume) - 1.0) <= 0.5e-12
        lattice = self.run_of(options, "lattice", BALL, packing="lattice").snapshots()[-1][1].fields["mass"].sum()
        random = self.run_of(options, "ball", BALL).snapshots()[-1][1]
        assert abs(random.fields["mass"].sum() / lattice - 1.0) <= 0.5e-12
        assert np.linalg.norm(random.points - 0.5, axis=1).max() < 0.4
        assert abs(random.fields["mass"].max() / random.fields["mass"].min() - 1.0) <= 0.5e-12

    def test_periodic(self, options):
        """Also across periodic boundaries, for any number of cells."""
        for hi in (0.625, 0.8125, 1.6875):        # 10, 13 and 27 cells
            run = self.run_of(options, "periodic", BOX, "plane_strain", hi, faces=WALLS)
            points = run.snapshots()[-1][1].points[:, [0, 2]]
            images = np.concatenate([points + hi * np.array([x, z]) for x in (0, 1) for z in (0, 1)])
            assert len(points) > 300
            assert least(images, 0.03) >= self.told(run) * (1 - 1e-5)

    def test_ranks_threads_tiles_seed(self, options):
        """The same for any ranks, threads and tiles; another seed or another body gives other positions."""
        one = self.run_of(options, "one", BALL)
        for how in ({"ranks": 2}, {"ranks": 3}, {"threads": 2}, {"grid": "block = 5"}):
            other = self.run_of(options, "other", BALL, **how)
            assert other.summary["digest"] == one.summary["digest"], how
        assert self.run_of(options, "seed", BALL, seed=2).summary["digest"] != one.summary["digest"]
        points = one.snapshots()[-1][1].points
        assert len(points) > 5000
        assert np.abs(points.mean(axis=0) - 0.5).max() < 0.003

    def test_blocks_differ(self, options):
        """Two adjacent blocks have the same particles only near their faces."""
        points = self.run_of(options, "blocks", BOX, "plane_strain", 1.25).snapshots()[-1][1].points[:, [0, 2]]
        local = [np.round(points[(points[:, 0] // 0.625 == k) & (points[:, 1] < 0.625)] - [0.625 * k, 0], 9)
                 for k in (0, 1)]
        same = {tuple(p) for p in local[0]} & {tuple(p) for p in local[1]}
        assert len(local[0]) > 300
        assert len(same) > 20
        assert len(same) < 0.25 * len(local[0])

    def test_no_lattice_is_left(self, options):
        """Positions within cells are uniformly distributed."""
        points = self.run_of(options, "even", BOX, "plane_strain", 4).snapshots()[-1][1].points[:, [0, 2]]
        counts = np.histogram2d(*((points / 0.0625) % 1).T, bins=4)[0].ravel()
        assert np.abs(counts / counts.mean() - 1).max() < 0.12
