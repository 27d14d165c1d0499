# SPDX-License-Identifier: BSD-3-Clause
"""Runs of manufactured solutions on successively finer grids, and the convergence of their errors.

    import manufactured
    line = manufactured.waves(options, "default", "ddmp", amplitude=0.1, cells=(18, 31, 55, 115))
    line.errors                        # greatest in time, one for each of line.cells
    line.order()                       # by least squares; line.order(18, 55) over some of at least four grids

The error is the root mean square of the displacement error of all particles at a time, its greatest
value in the run, over the greatest displacement of the solution. A run that fails is a failed test; with `may_fail` its
error is infinite.

`dispersion` is the closed error of schemes of second order. A wave exp(i k x) of particles reaches the nodes through
the functions, whose transform is sinc(k h/2)**(p + 1) for splines of degree p; once when nodes take velocities, once
when particles take accelerations, and twice, for strain and force, through their gradients, where images of k above the
lattice contribute too. With lumped masses and particles as dense as points of an integral this gives (w/(c k))2 = 1 - 2
kappa (k h)2 with kappa = 1/8, 1/4, 1/3 for p = 1, 2, 3. The dual gradient is averaged over the nodes of a cell, with a
weight that decreases from 1 at its faces, for strain and force: up to (k h)2/3 more, so kappa is between 1/8 and 7/24
for linear functions. Boxes of particles of a width of h/4 (gimp, cpgimp, cpdi) add 0.004 to kappa.
"""

import math

import case
import convergence
import measured

WAVES = """
&run  dimension='{dimension}'  method='{method}' /
&grid  lo=0,0,0  hi=1,1,1  dx={spacing} /
&time  t_end={end}  cfl={cfl} /
&method  {words} /
&effects  artificial_viscosity=.false. /
&material  name='rubber'  density=1  young=1.0e4  poisson={poisson}  strength_model='neo_hookean' /
&region  name='cube'  shape='box'  lo=0,0,0  hi=1,1,1 /
&body  name='cube'  region='cube'  material='rubber'  ppc={ppc} /
&boundary  face='all'  type='symmetry' /
&exact  solution='axis_aligned'  amplitude={amplitude} /
&output  name='h'  kind='history'  every={every} /
&checkpoint  at_end=.false. /
"""

VORTEX = """
&run  dimension='plane_strain'  method='{method}' /
&grid  lo=-1.5,0,-1.5  hi=1.5,1,1.5  dx={spacing} /
&time  t_end={end}  cfl={cfl}  dt_min={least} /
&method  {words} /
&effects  artificial_viscosity=.false. /
&material  name='rubber'  density=1000  young=1000  poisson=0.3  strength_model='neo_hookean' /
&region  name='outer'  shape='cylinder'  axis=0,1,0  centre=0,0.5,0  radius=1.25  height=4 /
&region  name='inner'  shape='cylinder'  axis=0,1,0  centre=0,0.5,0  radius=0.75  height=4 /
&region  name='ring'  shape='difference'  of='outer','inner' /
&body  name='ring'  region='ring'  material='rubber'  ppc={ppc}  {body} /
&exact  solution='vortex'  frequency=0.5  twist={twist} /
&output  name='h'  kind='history'  every=4 /
&checkpoint  at_end=.false. /
"""

PERIOD = 0.02                          # of the waves: 2 L/c with L = 1 m, c = 100 m/s [s]
CONTROL = "quadrature='control'"
# One method like the default of the dual domain method for all others: no damping, stress updated at the end of the
# step.
PLAIN = "stress_update='usl'  flip=1"
AFFINE = "stress_update='usl'  transfer='aflip'"
KAPPA = {"linear": 1 / 8, "gimp": 1 / 8, "cpgimp": 1 / 8, "cpdi": 1 / 8, "quadratic": 1 / 4, "cubic": 1 / 3,
         "ddmp": 7 / 24}
PPC = {"1d": "{0},1,1", "plane_strain": "{0},1,{0}", "3d": "{0},{0},{0}"}


def dispersion(basis, cells, angle=math.pi, amplitude=0.0):
    """Closed error of the displacement of a wave sin(pi X) after a given phase angle, over its amplitude.

    The wave lags by kappa (pi h)2 of its phase; root mean square over a line. With a large amplitude the cells are
    stretched: the wavelength is reduced by at most the factor 1 + pi A.
    """
    return KAPPA[basis] * (math.pi / cells * (1.0 + math.pi * amplitude)) ** 2 * angle / math.sqrt(2.0)


def forced(basis, cells, angle, stiffness=1.0, amplitude=0.0):
    """Bounds of the errors of displacement and velocity in planes and in 3-D, over the amplitudes of both.

    There the body force maintains the motion, and the error is that of an oscillator whose stiffness, `stiffness` times
    that of the wave, has a relative error of 2 kappa (pi h)2, driven by the whole displacement at all times.
    """
    off = 2.0 * KAPPA[basis] * (math.pi / cells * (1.0 + math.pi * amplitude)) ** 2 * stiffness / math.sqrt(2.0)
    root = math.sqrt(stiffness)
    swung = min(root * angle, math.pi)
    return off / stiffness * (1.0 - math.cos(swung)), off / root * math.sin(min(swung, 0.5 * math.pi))


class Series:
    """Errors of one method on successively finer grids; a run that failed, where it may, has an infinite error."""

    def __init__(self, name):
        self.name, self.cells, self.errors, self.seconds, self.steps = name, [], [], [], []

    def add(self, cells, run):
        """Take the greatest error of a run."""
        self.cells.append(cells)
        error, seconds, steps = math.inf, math.nan, 0
        if run.code == 0:
            summary = run.summary
            error = run.history["displacement_error"].max() / summary["exact"]["greatest_displacement"]
            seconds, steps = summary["wall_s"], summary["steps"]
        self.errors.append(error if math.isfinite(error) else math.inf)
        self.seconds.append(seconds)
        self.steps.append(steps)

    def error(self, cells):
        """The error on one of the grids."""
        return self.errors[self.cells.index(cells)]

    def order(self, coarse=0, fine=math.inf):
        """Observed order by least squares over all grids from one to another."""
        return convergence.order(*zip(*((cells, error) for cells, error in zip(self.cells, self.errors)
                                        if coarse <= cells <= fine)))

    def show(self):
        """Record and print errors and order."""
        measured.record(self.name, dict(zip(self.cells, self.errors)))
        line = [f"{error:.2e}" if math.isfinite(error) else "failed" for error in self.errors]
        if len(self.cells) >= convergence.LEAST:
            measured.record(self.name, {"order": self.order()})
            line.append(f"order {self.order():.2f}")
        print(f"         {self.name:<26} " + "  ".join(line), flush=True)
        return self


def waves(options, name, method="ddmp", words="", amplitude=0.1, cells=(18, 31, 55, 115), ppc=4,
          dimension="1d", end=0.5 * PERIOD, cfl=0.2, may_fail=False):
    """Waves along the axes of a cube whose faces do not move along their normals."""
    series = Series(name)
    poisson = 0.0 if dimension == "1d" else 0.3
    for number in cells:
        deck = WAVES.format(dimension=dimension, method=method, spacing=f"{1.0 / number:.17g}", end=end,
                            cfl=cfl, words=words, poisson=poisson, amplitude=amplitude,
                            ppc=PPC[dimension].format(ppc), every=4 if dimension == "1d" else 1)
        label = "".join(sign if sign.isalnum() else "_" for sign in f"{name}_{amplitude:g}_{ppc}")
        run = case.Case(options, f"waves_{dimension}_{label}_{number}", deck)
        series.add(number, run.run("-q", expect=None if may_fail else 0, timeout=3000))
    series.name += f" {dimension} {amplitude:g} {ppc}"
    return series.show()


def vortex(options, name, method="ddmp", words="", twist=0.1, cells=(10, 12, 14, 18), ppc=3, end=1.0, cfl=0.4,
           body="", may_fail=False):
    """A ring whose circles rotate back and forth; cells per unit of length, half of them across its width."""
    series = Series(name)
    for number in cells:
        deck = VORTEX.format(method=method, spacing=f"{1.0 / number:.17g}", end=end, cfl=cfl, words=words,
                             twist=twist, least=f"{0.008 * cfl / number:.17g}",
                             ppc=PPC["plane_strain"].format(ppc), body=body)
        label = "".join(sign if sign.isalnum() else "_" for sign in f"{name}_{twist:g}_{ppc}")
        run = case.Case(options, f"vortex_{label}_{number}", deck)
        series.add(number, run.run("-q", expect=None if may_fail else 0, timeout=3000))
    series.name += f" twist {twist:g} {ppc}"
    return series.show()
