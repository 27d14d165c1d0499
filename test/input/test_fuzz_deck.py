# SPDX-License-Identifier: BSD-3-Clause
# label: long
# timeout: 900
"""Decks with random damage: whatever the deck, the program says what is wrong and stays alive.

Would catch a crash, a hang, or an exit code other than 0, 2 or 3. The damage is the same in every
run; --seed and --count change it.
"""

import argparse
import os
import random
import subprocess
import sys
import unittest

import case

PARSER = argparse.ArgumentParser(add_help=False)
PARSER.add_argument("--seed", type=int, default=1)
PARSER.add_argument("--count", type=int, default=300)
CHOICES, REST = PARSER.parse_known_args()
sys.argv[1:] = REST
OPTIONS = case.arguments(__doc__)

DECK = """! A deck with something of everything.
&run title = 'it''s a deck'  dimension = 'plane_strain' /
&units system = 'mm-us-mg' /
&grid lo = 0, 0, -12,  hi = 30, 1, 60  dx = 0.5 /
&time
  t_end = 12.0   ! us
  cfl = 0.35  dt_min = 1.0e-6
/
&method transfer = 'xpic'  alpha = 'product' /
&effects thermal = .true.  gravity = T  gravity_vector(3) = -1 /
&material name = 'al'  density = 2.79  young = 72.4  poisson = 0.33
  strength_model = 'johnson_cook'  eos_model = "mie_gruneisen"
  mg_c0 = 5.35  mg_s = 1.34  mg_gamma = 2.0
  jc_a = 0.265  jc_b = 0.426  jc_n = 0.34  jc_c = 0.015  jc_m = 1d0
  t_melt = 775.0  specific_heat = 8.75e-4
/
&region name = 'ball'  shape = 'sphere'  centre = 15, 0, -4.80  radius = 4.75 /
&region name = 'sheet'  shape = 'box'  lo = 3*0  hi = 2*30, 2.2 /
&region name = 'rest'  shape = 'difference'  of = 'sheet', 'ball' /
&body name = 'sphere'  region = 'ball'  material = 'al'  velocity = 0, 0, 6.7 /
&body name = 'plate'  region = 'rest'  material = 'al'  ppc = 3 2 3 /
&boundary face = 'xlo'  type = 'symmetry' /
&output name = 'cloud'  kind = 'particles'  dt = 0.5  fields = 'velocity', 'pressure' /
&output name = 'energy'  kind = 'history'  times = 1 2 3. /
&checkpoint wall_minutes = 30 /
"""
LETTERS = "'\"&/!=,()*. \n\tabc019eE+-%$;\r\x00\x7f\u00e9"
WORDS = ["&end", "&run", "='", "''", "(1)", "999999999*1", "1e308", "1e-308", "-", "..", "1e", "&",
         "&include file = 'x.nml' /", "nan", "a%b = 3", "= 1 =", "1,,2", "/ /", "-1", "0", "1e9"]


def damage(text, chance):
    """A text with a few random changes."""
    letters = list(text)
    for _ in range(chance.choice([1, 2, 5, 30])):
        place = chance.randrange(len(letters) + 1)
        kind = chance.random()
        if kind < 0.4:
            letters[place:place + 1] = chance.choice(LETTERS)
        elif kind < 0.6:
            del letters[place:place + chance.randrange(1, 30)]
        elif kind < 0.8:
            letters[place:place] = chance.choice(WORDS)
        else:
            start = chance.randrange(len(letters) + 1)
            letters[place:place] = letters[start:start + 40]
    return "".join(letters)


class Fuzz(unittest.TestCase):
    """Random damage."""

    def check(self, text, name):
        """Exit code and output of a check with bounded memory and time."""
        path = OPTIONS.work / f"{name}.nml"
        path.write_text(text, encoding="utf-8", newline="")
        answer = subprocess.run([OPTIONS.scree, "--check", path.name], cwd=OPTIONS.work, timeout=120,
                                stdout=subprocess.PIPE, stderr=subprocess.STDOUT, check=False,
                                env={**os.environ, **case.OPEN_MPI, "OMP_NUM_THREADS": "1"})
        return answer.returncode, answer.stdout.decode(errors="replace")

    def test_undamaged(self):
        """Would catch a deck that is wrong already, so that the rest would prove little."""
        code, output = self.check(DECK, "undamaged")
        self.assertEqual(code, 0, output)

    def test_damaged(self):
        """Would catch any deck that kills the program."""
        chance = random.Random(CHOICES.seed)
        refused = 0
        for number in range(CHOICES.count):
            code, output = self.check(damage(DECK, chance), f"deck_{number}")
            with self.subTest(number):
                self.assertIn(code, (0, 2, 3), output[-2000:])
                if code == 2:
                    self.assertIn("error: ", output)
            refused += code == 2
        self.assertGreater(refused, CHOICES.count // 4)


if __name__ == "__main__":
    unittest.main()
