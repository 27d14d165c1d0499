# SPDX-License-Identifier: BSD-3-Clause
"""Rigid regions that forces move, and one that turns: the same bits for any ranks and threads and after a restart.

Would catch: impulses that are summed in the order of ranks or threads; a body whose state differs between ranks; a
rotation, momentum or energy that a restart loses or rounds; normals or nodes that belong to the place of the body
before the step; an iteration that ends after a different number of rounds on another layout.
"""
# tiers: full, long
# timeout: 300
# cores: 2

import pytest

import layouts

STEPS = 40
DECK = f"""
&run  dimension='{{dimension}}'  method='{{method}}' /
&grid  lo=0,0,0  hi=0.8,{{deep}},0.4  dx={{dx}} /
&time  t_end=1  max_steps={STEPS} /
&effects  gravity=.true. /
&material  name='m'  density=1500  young=1.0e6  poisson=0.3 /
&region  name='heap'  shape='box'  lo=0.21,0,0.13  hi=0.5,{{deep}},0.33 /
&body  name='heap'  region='heap'  material='m'  ppc=2,{{across}},2  velocity=1,0,-2 /
&region  name='ball'  shape='box'  lo=-0.06,-1,-0.04  hi=0.06,1,0.05  rotate=0,20,0  translate=0.3,{{middle}},0.07 /
&region  name='piece'  shape='box'  lo=-0.08,-0.08,-0.05  hi=0.08,0.08,0.05  rotate=0,-30,0
  translate=0.5,{{middle}},0.07 /
&region  name='wheel'  shape='sphere'  centre=0.4,{{middle}},0.37  radius=0.06 /
&boundary  region='ball'  type='stick'  density=700  velocity=0.3,0,0.5  spin=0,4,0 /
&boundary  region='piece'  type='friction'  friction=0.4  density=2500  velocity=-1,0,1  spin={{spin}} /
&boundary  region='wheel'  type='friction'  friction=0.9  spin=0,40,0 /
&boundary  face='zlo'  type='stick' /
&output  name='r'  kind='rigid'  every=10 /
"""


@pytest.mark.parametrize("name, words", (
        ("plane", {"dimension": "plane_strain", "method": "ddmp", "deep": 1, "dx": 0.01, "across": 1, "middle": 0.5,
                   "spin": "0,-5,0"}),
        pytest.param("space", {"dimension": "3d", "method": "ddmp", "deep": 0.4, "dx": 0.04, "across": 2,
                               "middle": 0.21, "spin": "2,-5,3"}, marks=pytest.mark.tiers("long")),
        ("before", {"dimension": "plane_strain", "method": "mpm", "deep": 1, "dx": 0.02, "across": 1, "middle": 0.5,
                    "spin": "0,-5,0"})))
def test_rigid_body_bits(options, sheet, name, words):
    """Two and three dimensions."""
    matrix = layouts.Matrix(options, sheet, name, DECK.format(**words), STEPS)
    matrix.whole(2, 1, "on")
    matrix.whole(3, 1, "off")
    matrix.whole(1, 2, "off")
    matrix.stopped(STEPS // 2, (2, 1), ((1, 1),), "on")
    fixed = matrix.new("fixed", 1, 1, "off")
    fixed.deck.write_text(fixed.deck.read_text(encoding="utf-8").replace("density=700", "").replace(
        "density=2500", ""), encoding="utf-8")
    sheet.require(fixed.run("-q").summary["digest"] != matrix.digest, f"{name}: forces move the bodies")
