# SPDX-License-Identifier: BSD-3-Clause
"""Sand is thrown up, comes apart, falls back and packs.

Would catch: loose sand that resists or pulls while it is open, volume that sand gains for good,
halves of a body that still feel each other when they are apart,
gaps between particles that bear pressure.

The volume at the end should be that at the start within 1 %. The volume of a particle follows the velocity
gradient and not the places of its neighbours, so by default the sum of the volumes is 7 % too large (limit 10 %) and
the heap, with gaps that bear pressure, 14 %; with `voids` it is the same. With volume_from = 'grid' the sum of the
volumes is judged at 1 % and the volume under the highest particles at 3 %: particles that lie irregularly are packed
a little too well. The weight takes 0.5 % of both.
"""
# timeout: 120

import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "support"))
import case    # noqa: E402
import report  # noqa: E402

SAND = """
&run  dimension='plane_strain' /
&grid  lo=0,0,0  hi=8,1,24  dx=1 /
&time  t_end={end} /
&effects  gravity=.true.  gravity_vector=0,0,-10  {effects} /
&material  name='sand'  density=1600  young=1.0e7  poisson=0.3  strength_model='drucker_prager'
  friction_angle=30  {words} /
&region  name='low'   shape='box'  lo=0,0,0  hi=8,1,4 /
&region  name='high'  shape='box'  lo=0,0,4  hi=8,1,8 /
&body  name='low'   region='low'   material='sand'  velocity=0,0,{slow} /
&body  name='high'  region='high'  material='sand'  velocity=0,0,{fast} /
&boundary  face='zlo'  type='friction'  friction=0.5 /
&boundary  face='xlo'  type='slip' /
&boundary  face='xhi'  type='slip' /
&output  name='p'  kind='particles'  count=100  precision='double'
  fields='identity','body','velocity','stress','volume','mass' /
&output  name='h'  kind='history'  every=5 /
&checkpoint  at_end=.false. /
"""


def heap(snap):
    """Mean height of the highest particles over strips of a cell, and half a particle, over the first height."""
    across, up = snap.points[:, 0], snap.points[:, 2]
    return float(np.mean([up[(across >= low) & (across < low + 1)].max() for low in range(8)]) + 0.25) / 8.0


def toss(options, sheet, name, words, most, highest):
    """The upper half flies up at 9 m/s, the lower one at 5 m/s; both fall and come to rest."""
    run = case.Case(options, name, SAND.format(
        end=14.0, effects="", words=words, slow=5, fast=9)).run("-q")
    snaps = run.snapshots()
    aloft = [(time, snap) for time, snap in snaps if 0.5 < time < 0.75]
    sheet.require(len(aloft) > 1, f"{name}: snapshots of the flight")
    for time, snap in aloft:
        upper, lower = (snap.fields["body"] == number for number in (2, 1))
        gap = snap.points[upper, 2].min() - snap.points[lower, 2].max()
        sheet.note(f"{name}, {time:.2f} s: gap of the halves [cell]", float(gap))
        for half, start in ((upper, 9.0), (lower, 5.0)):
            mean = np.average(snap.fields["velocity"][half, 2], weights=snap.fields["mass"][half])
            sheet.below(f"{name}, {time:.2f} s: velocity of a half off free fall",
                        (mean - (start - 10.0 * time)) / start, 0.02)
        sheet.below(f"{name}, {time:.2f} s: stress over weight of the heap",
                    np.abs(snap.fields["stress"]).max() / (1600 * 10 * 8), 0.05)
    last = snaps[-1][1]
    packed = np.mean([snap.fields["volume"].sum() for _, snap in snaps[-20:]]) \
        / (last.fields["mass"].sum() / 1600.0)
    speed = np.linalg.norm(last.fields["velocity"], axis=1).max()
    sheet.note(f"{name}: greatest speed at the end", float(speed))
    sheet.below(f"{name}: volume at the end over that at the start, less 1", packed - 1.0, most)
    sheet.below(f"{name}: volume under the heap over that at the start, less 1",
                np.mean([heap(snap) for _, snap in snaps[-20:]]) - 1.0, highest)
    ledger = run.summary["ledger"]
    sheet.below(f"{name}: momentum", ledger["momentum_error"], 1.0e-10)


def main():
    """Sand."""
    options = case.arguments()
    sheet = report.Report()
    toss(options, sheet, "toss", "", 0.1, 0.2)
    toss(options, sheet, "toss_grid", "volume_from='grid'", 0.01, 0.03)
    sheet.end()


if __name__ == "__main__":
    main()
