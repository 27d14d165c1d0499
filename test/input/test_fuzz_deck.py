# SPDX-License-Identifier: BSD-3-Clause
# tiers: smoke, full, long
# timeout: 300
# timeout long: 3600
"""Decks with random damage: each is either refused with a message or accepted; all are read in one process.

Would catch a crash, a hang, a deck that is refused without a message, an unknown key, group, word or
name that is accepted, and a deck whose echo is another deck. The damage is the same in every run; a
higher tier repeats that of the lower one and adds to it.
"""

import fuzzing
import tier

COUNT = tier.choose(smoke=300, full=2000, long=100000)
TIMEOUT = tier.choose(full=280, long=3500)


class TestFuzz:
    """Random damage, more of it in higher tiers."""

    def test_damaged_decks(self, options):
        """Would catch the errors listed above; and damage without any effect, or a lack of unknown words."""
        code, output = fuzzing.fuzz(options, 1, COUNT, TIMEOUT)
        assert code == 0, output[-4000:]
        mutations, refused, unknown = fuzzing.counts(output)
        assert mutations == COUNT
        assert refused > COUNT // 2
        assert unknown > COUNT // 10
