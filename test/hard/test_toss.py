# SPDX-License-Identifier: BSD-3-Clause
"""Sand is thrown up, separates, falls back and packs.

Would catch: loose sand that resists or pulls while it is separated, volume that sand gains permanently, halves of a
body that still interact when they are apart, gaps between particles that support pressure.

The volume at the end should be that at the start: target 1 %, of which compression by the weight takes 0.5 %. The
volume of a particle follows the velocity gradient and not the positions of its neighbours, so by default the sum of the
volumes and the heap, with gaps that support pressure, are too large; with `voids` too. Known misses, held at 16 %:
grains that fall back loosely (0.55 of the volume, loose random packing) occupy that much more than dense ones (0.64).
With volume_from = 'grid' the sum of the volumes meets the target; the volume under the highest particles misses it,
because irregularly placed particles are packed slightly too densely, and is held at the height of half a particle, a
quarter of a cell of eight.

In flight the halves are apart and transmit no stress; their mean velocities are those of free fall within 2 % of their
initial speed, the target, because they share nodes until they are a cell apart. At the end the sand is at rest: no
particle moves faster than half a cell per second.
"""
# timeout: 120

import numpy as np
import pytest

import case

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


TARGET, LOOSE = 0.01, 0.64 / 0.55 - 1.0


def heap(snap):
    """Mean height of the highest particles over strips of a cell, plus half a particle, over the initial height."""
    across, up = snap.points[:, 0], snap.points[:, 2]
    return float(np.mean([up[(across >= low) & (across < low + 1)].max() for low in range(8)]) + 0.25) / 8.0


@pytest.mark.parametrize("name, words, most, highest", [
    ("toss", "", LOOSE, LOOSE),
    ("toss_grid", "volume_from='grid'", None, None),
])
def test_toss(options, sheet, name, words, most, highest):
    """The upper half flies up at 9 m/s, the lower one at 5 m/s; both fall and come to rest.

    `most` and `highest` are the limits of volume and heap in known misses of the target, else None.
    """
    run = case.Case(options, name, SAND.format(
        end=14.0, effects="", words=words, slow=5, fast=9)).run("-q")
    snaps = run.snapshots()
    aloft = [(time, snap) for time, snap in snaps if 0.5 < time < 0.75]
    sheet.require(len(aloft) > 1, f"{name}: snapshots of the flight")
    for time, snap in aloft:
        upper, lower = (snap.fields["body"] == number for number in (2, 1))
        gap = snap.points[upper, 2].min() - snap.points[lower, 2].max()
        sheet.above(f"{name}, {time:.2f} s: gap of the halves [cell]", float(gap), 1.0)
        for half, start in ((upper, 9.0), (lower, 5.0)):
            mean = np.average(snap.fields["velocity"][half, 2], weights=snap.fields["mass"][half])
            sheet.below(f"{name}, {time:.2f} s: velocity of a half off free fall",
                        (mean - (start - 10.0 * time)) / start, 0.02)
        sheet.below(f"{name}, {time:.2f} s: stress over weight of the heap",
                    np.abs(snap.fields["stress"]).max() / (1600 * 10 * 8), 1.0e-10)
    last = snaps[-1][1]
    packed = np.mean([snap.fields["volume"].sum() for _, snap in snaps[-20:]]) \
        / (last.fields["mass"].sum() / 1600.0)
    speed = np.linalg.norm(last.fields["velocity"], axis=1).max()
    sheet.below(f"{name}: greatest speed at the end [m/s]", float(speed), 0.5)
    for label, value, limit in (("volume at the end", packed - 1.0, most), ("volume under the heap", np.mean(
            [heap(snap) for _, snap in snaps[-20:]]) - 1.0, highest)):
        if limit is None:
            sheet.below(f"{name}: {label} over that at the start, less 1", value, TARGET)
        else:
            sheet.known(f"{name}: {label} over that at the start, less 1", float(value), limit=limit, target=TARGET)
    sheet.below(f"{name}: momentum", run.summary["ledger"]["momentum_error"], 1.0e-12)
