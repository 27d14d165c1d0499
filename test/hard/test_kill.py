# SPDX-License-Identifier: BSD-3-Clause
"""A run that is killed at random moments, also while files are being written, ends in the same state as an
uninterrupted run.

Would catch: a checkpoint that gets its name before it is complete, an older one that is removed before the new one is
complete, rows of a history that are repeated or lost, snapshots of times after the restart.
"""
# tiers: smoke, full, long
# timeout: 900
# timeout long: 1800

import pytest

import killing
import tier

# ranks, kills and the seed of their times
KILLS = tier.choose(smoke=((1, 3, 1),), full=((1, 8, 1), (2, 3, 2)), long=((1, 50, 3), (2, 50, 4)))


@pytest.mark.parametrize("ranks, number, seed", KILLS)
def test_kill(options, sheet, ranks, number, seed):
    """Each row of the table."""
    killing.end_by_kills(options, sheet, number, seed=seed, ranks=ranks)
