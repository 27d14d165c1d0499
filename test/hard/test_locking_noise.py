# SPDX-License-Identifier: BSD-3-Clause
"""Material that keeps its volume locks with few cells: the remedy that messages name lowers loads and noise.

Would catch: an advice that does not help, warning R116 without `antilock = 'bbar'` where it applies or with it in a
deck that has it, and a `bbar` that no longer lowers the noise.

A rough strip footing on clay without friction: the mean pressure is (2 + pi) c (L. Prandtl, Nachr. Ges. Wiss.
Goettingen (1920) 74). The edge of the foot lies on nodes, so its half width is between 0.5 m and half a cell more,
12.5 %. Rubber and von Mises: a block of 20 x 10 cells under a stamp of 8 cells; the limit of the noise is that of
trust: unresolved pressures as large as the shear stress.
"""
# tiers: full, long
# timeout: 300
# timeout long: 1200

import math

import pytest

import case

CLAY = """&run  dimension='plane_strain' /
&grid  lo=0,0,-2  hi=3,1,0.5  dx=0.125 /
&time  t_end=1.6 /
&method  {words} /
&effects  artificial_viscosity=.false. /
&material  name='clay'  density=2000  young=10 MPa  poisson=0.49  strength_model='mohr_coulomb'  friction_angle={phi}
    cohesion=10 kPa /
&region  name='soil'  shape='box'  lo=0,0,-2  hi=3,1,0 /
&body  name='soil'  region='soil'  material='clay' /
&boundary  face='xlo'  type='symmetry' /
&boundary  face='xhi'  type='slip' /
&boundary  face='zlo'  type='stick' /
&region  name='foot'  shape='box'  lo=-1,0,0  hi=0.5,1,0.4 /
&boundary  region='foot'  type='stick'  table='push.csv' /
&output  name='f'  kind='forces'  dt=0.02  walls='foot' /
&checkpoint  at_end=.false. /
"""
PUSH = "t,vx,vy,vz\n0,0,0,0\n0.5,0,0,-0.04\n100,0,0,-0.04\n"
BLOCK = """&run  dimension='plane_strain' /
&grid  lo=0,0,0  hi=1.6,1,1.2  dx=0.05 /
&time  t_end=0.5 /
&method  {words} /
&effects  artificial_viscosity=.false. /
&material  name='m'  density=1000  young=1e6  {material} /
&region  name='r'  shape='box'  lo=0.3,0,0  hi=1.3,1,0.5 /
&body  name='b'  region='r'  material='m' /
&boundary  face='zlo'  type='stick' /
&region  name='stamp'  shape='box'  lo=0.6,0,0.5  hi=1,1,0.9 /
&boundary  region='stamp'  type='stick'  velocity=0,0,-{speed} /
&output  name='h'  kind='history'  every=50  fields='default','noise' /
&checkpoint  at_end=.false. /
"""
RUBBER, METAL = "poisson=0.49", "poisson=0.3  strength_model='von_mises'  yield=1e4"
BBAR = "antilock='bbar'"
NAMED = "antilock = 'bbar'"
OTHERS = ("transfer='pic'", "stress_update='usavg'", "quadrature='control'")


def warned(run):
    """Warnings of noise in the log."""
    return [line for line in run.path(".log").read_text().splitlines() if "pressures of neighbouring particles" in line]


def footing(options, name, words):
    """Mean pressure under the foot over the cohesion at the end of the push, and the run."""
    run = case.Case(options, name, CLAY.format(words=words, phi=0))
    (run.folder / "push.csv").write_text(PUSH, encoding="ascii")
    run.run("-q")
    table = case.post().history(str(run.path("_forces.csv")))
    late = table["time"] > 1.2
    return float(abs(table["foot_force_z"][late].mean()) / 0.5 / 1.0e4), run


def test_footing(options, sheet):
    """Pressure and noise with and without the remedy that the warning names."""
    exact = 2.0 + math.pi
    locked, run = footing(options, "default", "")
    sheet.above("footing, default: pressure over the exact one", locked / exact, 1.5)
    sheet.require(run.summary["trust"]["noise"]["verdict"] == "bad", "footing, default: noise is bad")
    sheet.require(len(warned(run)) == 1 and NAMED in warned(run)[0], f"footing: the remedy is named: {warned(run)}")
    cured, run = footing(options, "bbar", BBAR)
    sheet.near("footing, bbar: pressure over the cohesion", cured, exact, 0.125)
    sheet.require(run.summary["trust"]["noise"]["verdict"] == "ok", f"footing, bbar: {run.summary['trust']}")


@pytest.mark.parametrize("material, speed", [(RUBBER, 0.1), (METAL, 0.2)], ids=["rubber", "metal"])
def test_blocks(options, sheet, material, speed):
    """Noise with and without the remedy, and that other keys do not help."""
    noise = {}
    for n, words in enumerate(("", BBAR, *OTHERS)):
        run = case.Case(options, f"block_{n}", BLOCK.format(words=words, material=material, speed=speed)).run("-q")
        noise[words] = run.summary["trust"]["noise"]["value"]
        sheet.require(any(NAMED in line for line in warned(run)) == (words != BBAR), f"{words}: {warned(run)}")
    # above 1 the verdict of trust is no longer ok: the advice is for a remedy that reaches it
    sheet.below("bbar: noise", noise[BBAR], 1.0)
    for words in ("", *OTHERS):
        sheet.above(f"{words or 'default'}: noise", noise[words], 1.0)
