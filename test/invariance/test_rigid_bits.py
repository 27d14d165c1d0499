# SPDX-License-Identifier: BSD-3-Clause
"""Rigid regions that move, rub, appear and disappear, and parts of boundaries: the same bits for any ranks and threads
and after a restart.

Would catch: positions of nodes that differ between tiles in the last bit, so that one tile constrains a node and its
neighbour does not; a position or velocity of a region that is accumulated instead of computed from the time, so that a
restart loses it; nodes that are stored for tiles that have moved to another rank; normals that are computed again after
a restart only.
"""
# timeout: 300
# cores: 2

import pytest

import layouts

STEPS = 40
DECK = f"""
&run  dimension='{{dimension}}'  method='{{method}}' /
{{words}}
&grid  lo=0,0,0  hi=0.8,{{deep}},0.4  dx={{dx}} /
&time  t_end=1  max_steps={STEPS} /
&effects  gravity=.true. /
&material  name='m'  density=1500  young=1.0e6  poisson=0.3 /
&region  name='heap'  shape='box'  lo=0.21,0,0.13  hi=0.5,{{deep}},0.33 /
&body  name='heap'  region='heap'  material='m'  ppc=2,{{across}},2  velocity=1,0,-2 /
&region  name='ball'  shape='sphere'  centre=0.3,{{middle}},0.02  radius=0.1003 /
&region  name='cone'  shape='cone'  centre=0.52,{{middle}},0.1  axis=0,0,1  radius=0.2  radius2=0  height=0.2 /
&region  name='hole'  shape='box'  lo=0.33,0,0  hi=0.41,{{deep}},1 /
&boundary  region='ball'  type='slip'  velocity=0.7,0,1.1  t_on=0.002 /
&boundary  region='cone'  type='friction'  friction=0.4  t_off=0.012 /
&boundary  face='zlo'  type='stick' /
&boundary  face='zlo'  region='hole'  type='friction'  friction=0.2 /
"""


@pytest.mark.parametrize("name, words", (
        ("plane", {"dimension": "plane_strain", "method": "ddmp", "deep": 1, "dx": 0.01, "across": 1, "middle": 0.5,
                   "words": ""}),
        ("space", {"dimension": "3d", "method": "ddmp", "deep": 0.4, "dx": 0.04, "across": 2, "middle": 0.21,
                   "words": ""}),
        ("wide", {"dimension": "plane_strain", "method": "mpm", "deep": 1, "dx": 0.01, "across": 1, "middle": 0.5,
                  "words": "&method  basis='quadratic' /"}),
        ("before", {"dimension": "plane_strain", "method": "mpm", "deep": 1, "dx": 0.02, "across": 1, "middle": 0.5,
                    "words": "&method  stress_update='usf' /"})))
def test_rigid_bits(options, sheet, name, words):
    """Two and three dimensions."""
    matrix = layouts.Matrix(options, sheet, name, DECK.format(**words), STEPS)
    matrix.whole(2, 1, "on")
    matrix.whole(3, 1, "off")
    if name == "plane":
        matrix.whole(1, 2, "off")
    if name in ("plane", "before"):
        matrix.stopped(STEPS // 2, (2, 1), ((1, 1),), "on")
    first = matrix.new("free", 1, 1, "off")
    first.deck.write_text("".join(line for line in first.deck.read_text(encoding="utf-8").splitlines(True)
                                  if "&boundary" not in line or "region=" not in line), encoding="utf-8")
    sheet.require(first.run("-q").summary["digest"] != matrix.digest, f"{name}: the regions do something")
