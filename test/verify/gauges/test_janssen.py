# SPDX-License-Identifier: BSD-3-Clause
"""Load cells below and beside a silo whose walls rise slowly: the law of H. A. Janssen (Z. VDI 39 (1895) 1045).

Would catch a force that is assigned to the wrong wall, walls whose friction is not that of the deck, and forces of a
steady state whose means are not those of equilibrium. In a plane silo of width W and filling H the floor supports rho g
W/(2 mu K) (1 - exp(-2 mu K H/W)) on its area; K is the normal stress on the walls over the mean vertical stress. The
walls rise, so that their friction is fully mobilised; next to the smooth floor it is not quite, so that the floor
supports a few percent more.
"""
# tiers: full, long
# timeout: 300
# timeout long: 900

import numpy as np

import case
import tier

DENSITY, WIDTH, HEIGHT, FRICTION = 1500.0, 0.1, 0.4, 0.3
SILO = f"""
&run  dimension='plane_strain' /
&grid  lo=-0.025,0,0  hi=0.125,1,0.45  dx={tier.choose(full=0.0125, long=0.00625)} /
&time  t_end=1.5 /
&effects  gravity=.true.  gravity_vector=0,0,-9.81  artificial_viscosity=.false.  damping=5 /
&material  name='sand'  density={DENSITY}  bulk=3e5  shear=1.5e5  strength_model='drucker_prager'  friction_angle=30 /
&region  name='fill'   shape='box'  lo=0,0,0  hi={WIDTH},1,{HEIGHT} /
&body  name='b'  region='fill'  material='sand' /
&region  name='left'   shape='box'  lo=-0.025,0,-1  hi=0,1,1 /
&region  name='right'  shape='box'  lo={WIDTH},0,-1  hi=0.125,1,1 /
&boundary  region='left'   type='friction'  friction={FRICTION}  velocity=0,0,0.01 /
&boundary  region='right'  type='friction'  friction={FRICTION}  velocity=0,0,0.01 /
&boundary  face='zlo'  type='slip' /
&output  name='f'  kind='forces'  dt=0.05 /
&output  name='m'  kind='gauge'  gauge='mean'  dt=0.05  fields='stress' /
"""


def table(run, name):
    """Means of the columns over the last second of the run."""
    rows = np.genfromtxt(run.path(f"_{name}.csv"), delimiter=",", names=True, deletechars="", replace_space=" ")
    late = rows["time [s]"] > 0.5
    return {column: rows[column][late].mean() for column in rows.dtype.names}


def test_janssen(options, sheet):
    run = case.Case(options, "janssen", SILO).run("-q")
    forces, stress = table(run, "forces"), table(run, "gauge")
    floor = -forces["zlo_force_z [N]"]
    walls = -(forces["left_force_z [N]"] + forces["right_force_z [N]"])
    weight = DENSITY * 9.81 * WIDTH * HEIGHT
    sheet.near("floor and walls bear the weight", floor + walls, weight, 0.01)
    ratio = forces["right_force_x [N]"] / HEIGHT / -stress["stress_zz [Pa]"]
    length = WIDTH / (2 * FRICTION * ratio)
    sheet.note("K", float(ratio))
    sheet.near("floor by Janssen's law", floor, DENSITY * 9.81 * WIDTH * length * (1 - np.exp(-HEIGHT / length)), 0.05)
    sheet.below("friction of the walls over the normal force", walls / 2 / forces["right_force_x [N]"], FRICTION + 1e-6)
