# SPDX-License-Identifier: BSD-3-Clause
"""More ranks than cores, odd numbers of them, with and without load balancing: the same bits.

Would catch: a partition of the curve that depends on the measured cost of tiles and affects the state, a rank that gets
no tile, a patch that is sent before it is complete or not sent at all after tiles have moved, ghosts of the previous
step. smoke: one deck on few ranks and threads; full: four decks on 4 and 7 ranks; long: all of them for all
combinations of ranks {1, 2, 3, 4, 7} and threads {1, 2, 3}, with restarts at the first, a middle and the last step but
one.
"""
# tiers: smoke, full, long
# timeout: 900
# timeout long: 7200
# cores: 2

import layouts
import tier


def test_layouts(options, sheet):
    """The combinations of ranks and threads of this tier."""
    if tier.NAME == "smoke":
        layouts.run_few(options, sheet)
    elif tier.NAME == "full":
        layouts.run_all(options, sheet, ranks=(4, 7), threads=(1,), restarts=(1,))
    else:
        layouts.run_all(options, sheet, ranks=(1, 2, 3, 4, 7), threads=(1, 2, 3), restarts=(0, 1, 2))
