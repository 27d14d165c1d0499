# SPDX-License-Identifier: BSD-3-Clause
# tiers: smoke, full, long
# timeout: 300
# timeout long: 3600
"""Decks with random damage: each is refused with a message or understood, in one process.

Would catch a crash, a hang, a deck that is refused without a message, an unknown key, group, word or
name that is accepted, and a deck whose echo is another deck. The damage is the same in every run; a
higher tier repeats that of the lower one and adds to it.
"""

import unittest

import case
import fuzzing
import tier

OPTIONS = case.arguments(__doc__)
COUNT = tier.choose(smoke=300, full=2000, long=100000)
TIMEOUT = tier.choose(full=280, long=3500)


class Fuzz(unittest.TestCase):
    """Random damage, more of it in higher tiers."""

    def test_damaged_decks(self):
        """Would catch what is said above; and damage that does none, or unknown words left out."""
        code, output = fuzzing.fuzz(OPTIONS, 1, COUNT, TIMEOUT)
        self.assertEqual(code, 0, output[-4000:])
        mutations, refused, unknown = fuzzing.counts(output)
        self.assertEqual(mutations, COUNT)
        self.assertGreater(refused, COUNT // 2)
        self.assertGreater(unknown, COUNT // 10)


if __name__ == "__main__":
    unittest.main()
