# SPDX-License-Identifier: BSD-3-Clause
"""A run that is killed at random moments, files half written included, ends as if nothing had been.

Would catch: a checkpoint that takes its name before it is whole, an older one that goes before the
new one is safe, rows of a history that are doubled or lost, snapshots of a time that was undone.
"""
# tiers: smoke, full, long
# timeout: 900
# timeout long: 1800

import pytest

import killing
import tier

# ranks, kills and the seed of their moments
KILLS = tier.choose(smoke=((1, 3, 1),), full=((1, 8, 1), (2, 3, 2)), long=((1, 50, 3), (2, 50, 4)))


@pytest.mark.parametrize("ranks, number, seed", KILLS)
def test_kill(options, sheet, ranks, number, seed):
    """Each row."""
    killing.end_by_kills(options, sheet, number, seed=seed, ranks=ranks)
