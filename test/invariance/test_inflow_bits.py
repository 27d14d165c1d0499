# SPDX-License-Identifier: BSD-3-Clause
"""Inflows: the same bits for any layout and after a restart.

Would catch particles that a rank counts for another one, a step at whose end a restart feeds twice or not at all,
strengths that are drawn from another identity, and tiles that a rank without particles cannot make.
"""
# timeout: 300
# cores: 2

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "support"))
import case     # noqa: E402
import layouts  # noqa: E402
import report   # noqa: E402

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


def main():
    """Two and three dimensions."""
    options = case.arguments()
    sheet = report.Report()
    for name, words in (
            ("plane", {"dimension": "plane_strain", "deep": 1, "dx": 0.04, "across": 1, "low": 0.32, "high": 0.48,
                       "rate": 6000}),
            ("space", {"dimension": "3d", "deep": 0.24, "dx": 0.04, "across": 2, "low": 0.32, "high": 0.48,
                       "rate": 1400})):
        matrix = layouts.Matrix(options, sheet, name, DECK.format(**words), STEPS)
        matrix.whole(2, 1, "on")
        matrix.whole(3, 1, "off")
        matrix.whole(1, 2, "off")
        matrix.stopped(STEPS // 2, (2, 1), ((1, 1),), "on")
    sheet.end()


if __name__ == "__main__":
    main()
