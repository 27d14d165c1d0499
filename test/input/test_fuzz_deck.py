# SPDX-License-Identifier: BSD-3-Clause
"""Decks with random damage: each is refused with a message or understood, in one process.

Would catch a crash, a hang, a deck that is refused without a message, an unknown key, group, word or
name that is accepted, and a deck whose echo is another deck. The damage is the same in every run.
"""

import unittest

import case
import fuzzing

OPTIONS = case.arguments(__doc__)
COUNT = 2000


class Fuzz(unittest.TestCase):
    """Random damage, a short share of the long test."""

    def test_damaged_decks(self):
        """Would catch what is said above; and damage that does none, or unknown words left out."""
        code, output = fuzzing.fuzz(OPTIONS, 1, COUNT, 200)
        self.assertEqual(code, 0, output[-4000:])
        mutations, refused, unknown = fuzzing.counts(output)
        self.assertEqual(mutations, COUNT)
        self.assertGreater(refused, COUNT // 2)
        self.assertGreater(unknown, COUNT // 10)


if __name__ == "__main__":
    unittest.main()
