# SPDX-License-Identifier: BSD-3-Clause
"""An elastic column on a wall bounces under suddenly applied gravity.

Would catch: gravity of the wrong size or applied twice at nodes that tiles share, a wall that moves
or loses momentum, balances without the work of gravity or the impulse of the wall, a wrong wave speed.

L = 10 m, E = 1 MPa, nu = 0, rho = 1000 kg/m3, g = 0.1 m/s2 along x, 40 cells, 3 particles a cell.
Closed solution (linear, uniaxial, c2 = E/rho): the mean velocity is -g t + g c t2/(2 L) up to 2 L/c and has the period
4 L/c; the top moves between 0 and -rho g L2/E. Limits 1 %, error of the momentum balance 1e-12, error of the energy
balance 1 % of the work of gravity.
"""

import numpy as np
import pytest

import case

LENGTH, YOUNG, DENSITY, GRAVITY, CELLS = 10.0, 1.0e6, 1000.0, 0.1, 40
SPEED = np.sqrt(YOUNG / DENSITY)
PERIOD = 4.0 * LENGTH / SPEED

DECK = """
&run  dimension='1d'  method='{method}' /
&grid  lo=0,0,0  hi=11,1,1  dx=0.25 /
&time  t_end={end!r} /
&effects  gravity=.true.  gravity_vector=-0.1,0,0  artificial_viscosity=.false. /
&material  name='m'  density=1000  young=1.0e6  poisson=0 /
&region  name='column'  shape='box'  lo=0,0,0  hi=10,1,1 /
&body  name='column'  region='column'  material='m'  ppc=3,1,1 /
&boundary  face='xlo'  type='{wall}' /
&output  name='p'  kind='particles'  count=120  precision='double'  fields='velocity','stress' /
&output  name='h'  kind='history'  every=1 /
&checkpoint  at_end=.false. /
"""


@pytest.mark.parametrize("method, wall", [
    ("ddmp", "slip"),
    ("ddmp", "symmetry"),
    ("mpm", "stick"),
])
def test_bounce(options, sheet, method, wall):
    """Three periods."""
    name = f"{method}_{wall}"
    deck = DECK.format(method=method, wall=wall, end=float(3.0 * PERIOD))
    run = case.Case(options, name, deck).run("-q")
    table = run.history
    time, velocity = table["time"], table["momentum_x"] / table["mass"]
    phase = np.mod(time, PERIOD)
    phase = np.where(phase > PERIOD / 2.0, PERIOD - phase, phase)
    sign = np.where(np.mod(time, PERIOD) > PERIOD / 2.0, -1.0, 1.0)
    exact = sign * (-GRAVITY * phase + 0.5 * GRAVITY * SPEED / LENGTH * phase ** 2)
    scale = GRAVITY * LENGTH / (2.0 * SPEED)     # greatest mean speed
    last = np.flatnonzero((velocity[:-1] > 0.0) & (velocity[1:] <= 0.0))[-1]
    share = velocity[last] / (velocity[last] - velocity[last + 1])
    cross = time[last] + share * (time[last + 1] - time[last])
    tops = np.array([snap.points[:, 0].max() for _, snap in run.snapshots()])
    fall = tops - tops[0]
    ledger = run.summary["ledger"]
    sheet.require(len(tops) == 121 and run.summary["particles"] == 3 * CELLS,
                  f"{name}: all is there")
    sheet.near(f"{name}: period [s]", cross / round(cross / PERIOD), PERIOD, 0.01)
    sheet.above(f"{name}: periods", cross / PERIOD, 1.9)
    sheet.below(f"{name}: rms error of the mean velocity",
                float(np.sqrt(((velocity - exact) ** 2).mean()) / scale), 0.01)
    sheet.near(f"{name}: greatest fall of the top [m]", -fall.min(),
               DENSITY * GRAVITY * LENGTH ** 2 / YOUNG, 0.01)
    sheet.near(f"{name}: mean fall of the top [m]", -fall[:-1].mean(),
               DENSITY * GRAVITY * LENGTH ** 2 / (2.0 * YOUNG), 0.01)
    sheet.below(f"{name}: momentum in the books", ledger["momentum_error"], 1.0e-12)
    books = table["kinetic"] + table["internal"] - table["external_work"]
    sheet.below(f"{name}: energy in the books",
                np.abs(books).max() / table["external_work"].max(), 0.01)
