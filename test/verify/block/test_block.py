# SPDX-License-Identifier: BSD-3-Clause
"""A block on a slope with Coulomb friction: it slides with g (sin - mu cos), or it sticks.

Would catch: friction on nodes that move away from the wall, which decelerates a rocking block twice; friction that
stops more than the relative motion; a wall pressure from FLIP velocities that particles never get; friction work that
is not recorded; a wall that holds a block that bounces.

24 degrees and mu = tan 15 degrees, as in tests of other codes: distance within 1e-3 in 5 s, speed within 1e-3. In 1 s
with finer cells and with the plain method 1 %. At 14 degrees the block may slip for 0.1 s while it bounces from its
start without stress, and then sticks; nothing damps the shear vibration of the elastic block, a known miss of 1e-4 m,
held at twice that.
"""

import numpy as np
import pytest

import flows


@pytest.mark.parametrize("name, limit, words", [
    ("5 s", 1.0e-3, {"end": 5.0}),
    ("finer cells", 0.01, {"spacing": 0.125}),
    ("mpm", 0.01, {"method": "mpm"}),
    ("apic", 0.01, {"words": "transfer='apic'"}),
])
def test_slides(options, sheet, name, limit, words):
    """Blocks that slide."""
    result = flows.block(options, name.replace(" ", "_"), **words)
    gain, end = result["expected"], result["when"][-1]
    sheet.near(f"{name}: way [m]", result["places"][-1], 0.5 * gain * end ** 2, limit)
    sheet.near(f"{name}: speed [m/s]", result["speeds"][-1], gain * end, limit)
    sheet.below(f"{name}: momentum", result["momentum"], 1.0e-13)
    if not words.get("method"):
        sheet.below(f"{name}: energy", result["energies"][-1], 0.02)


def test_rest(options, sheet):
    result = flows.block(options, "rest", angle=14.0)
    later = result["places"][result["when"] > 0.2]
    sheet.below("14 degrees: way while it bounces [m]", later[0], 2.0e-3)
    sheet.known("14 degrees: way after that [m]", np.abs(later - later[0]).max(), limit=2.0e-4, target=1.0e-4)
    sheet.require(len(later) > 10, "14 degrees: there are times after that")
