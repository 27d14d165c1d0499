# SPDX-License-Identifier: BSD-3-Clause
"""Inflows: the same bits for any ranks and threads and after a restart.

Would catch particles that a rank counts for another one, a step at whose end a restart inserts particles twice or not
at all, strengths of another place, and tiles that a rank without particles cannot create.
"""
# timeout: 300
# cores: 2

import pytest

import layouts

STEPS = 240
DECK = f"""
&run  dimension='{{dimension}}' /
&grid  lo=0,0,0  hi=0.8,{{deep}},0.8  dx={{dx}}  block=4 /
&time  t_end=1  max_steps={STEPS} /
&material  name='m'  density=1500  young=1.0e6  poisson=0.3  damage_model='principal_stress'  failure_stress=2e4
  weibull_m=6  weibull_volume=1e-5 /
&region  name='left'  shape='box'  lo=0,0,{{low}}  hi=0.16,{{deep}},{{high}} /
&region  name='top'   shape='box'  lo={{low}},0,0.6  hi={{high}},{{deep}},0.8 /
&body  name='left'  region='left'  material='m'  ppc=2,{{across}},2 /
&body  name='top'   region='top'   material='m'  ppc=2,{{across}},2  packing='jitter' /
&inflow  body='left'  velocity=30,0,0 /
&inflow  body='top'   velocity=0,0,-20  mass_rate={{rate}} /
&effects  damage=.true.  size_scatter=.true. /
"""


@pytest.mark.parametrize("name, words", (
        ("plane", {"dimension": "plane_strain", "deep": 1, "dx": 0.04, "across": 1, "low": 0.32, "high": 0.48,
                   "rate": 6000}),
        ("space", {"dimension": "3d", "deep": 0.24, "dx": 0.04, "across": 2, "low": 0.32, "high": 0.48,
                   "rate": 1400})))
def test_inflow_bits(options, sheet, name, words):
    """Two and three dimensions."""
    matrix = layouts.Matrix(options, sheet, name, DECK.format(**words), STEPS)
    matrix.whole(2, 1, "on")
    matrix.whole(3, 1, "off")
    matrix.whole(1, 2, "off")
    matrix.stopped(STEPS // 2, (2, 1), ((1, 1),), "on")
