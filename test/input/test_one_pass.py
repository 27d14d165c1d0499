# SPDX-License-Identifier: BSD-3-Clause
# tiers: smoke
"""All errors of a deck in one pass, each once, and no warning without a reason.

Would catch: fields of outputs that are checked only where all else is right, errors that only follow from a wrong
preset, one mistake in a repeated body that is reported for each copy, a gas that is called too light, a table of
gravity that is called one of velocities, a velocity formula that fails only when the run begins, and a run that
computes on when nothing is left.
"""

import shutil
import subprocess
import unittest

import case

OPTIONS = case.arguments(__doc__)
DECK = {"run": "&run case='c' dimension='plane_strain' /", "grid": "&grid lo=0,0,0 hi=1,1,1 dx=0.1 /",
        "time": "&time t_end=1e-3 /", "material": "&material name='m' preset='al_6061_t6' /",
        "region": "&region name='r' shape='sphere' centre=0.5,0,0.5 radius=0.25 /",
        "body": "&body name='b' region='r' material='m' /"}


def said_of(name, *words, files=None, expect=2, **groups):
    """What a check, or another call, says of a deck with some groups changed: its lines but the last."""
    folder = OPTIONS.work / f"{name} ü"
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    for file, text in (files or {}).items():
        (folder / file).write_text(text, encoding="utf-8")
    deck = folder / "deck.nml"
    deck.write_text("\n".join({**DECK, **groups}.values()) + "\n", encoding="utf-8")
    words = words or ("--check", "--no-estimate")
    answer = subprocess.run([OPTIONS.scree, *words, deck.name], cwd=folder, text=True, capture_output=True,
                            check=False, timeout=100)
    if answer.returncode != expect:
        raise AssertionError(f"exit code {answer.returncode}, not {expect}: {answer.stdout}{answer.stderr}")
    return answer.stdout + answer.stderr


def problems(said):
    """Lines of errors and warnings."""
    return [line for line in said.splitlines() if ": error: " in line or ": warning: " in line]


class OnePass(unittest.TestCase):
    """Decks with a few mistakes each."""

    def test_preset(self):
        """Would catch follow-up errors of a wrong preset, on keys that it sets or that need what it sets."""
        for word, near in (("aluminium_6061", "al_6061_t6"), ("copper", "cu_ofhc"), ("al6061", "al_6061_t6"),
                           ("steel 1006", "steel_4340"), ("al_6061_t5", "al_6061_t6")):
            lines = problems(said_of("preset", material=f"&material name='m' preset='{word}' jc_a=1e8 /"))
            self.assertEqual(len(lines), 1, lines)
            self.assertIn(f"did you mean '{near}'?", lines[0])
        # a warning on the wave speed of a material that is not known
        lines = problems(said_of("no modulus", material="&material name='m' density=2700 young=7e10 /"))
        self.assertEqual(len(lines), 1, lines)
        lines = problems(said_of("no preset", material="&material name='m' preset='xyz' /"))
        self.assertNotIn("did you mean", lines[0])
        lines = problems(said_of("given wrong", material="&material name='m' preset='copper' density=-1 /"))
        self.assertEqual(len(lines), 2, "an error that does not follow from the preset is reported")

    def test_fields(self):
        """Would catch fields that are checked after all else, or of which only the first wrong one is named."""
        output = "&output name='o' kind='{}' dt=1e-4 fields='{}','velocty','mass' /"
        for other in ({}, {"time": "&time t_end=1 parsec /"}, {"material": "&material name='m' preset='al_60' /"},
                      {"grid": "&grid lo=0,0,0 hi=1,1,1 dx=-1 /"}):
            for kind in ("particles", "grid", "profile", "slice"):
                at = " " if kind != "slice" else " at=0.5 "
                said = said_of("fields", output=output.format(kind, "pressur").replace(" dt", at + "dt"), **other)
                wrong = [line for line in problems(said) if "output field" in line]
                self.assertEqual(len(wrong), 2, said)
                self.assertIn("; did you mean 'pressure'?", wrong[0])
                self.assertIn("'velocty' is unknown", wrong[1])
                self.assertEqual(len(problems(said)), 2 + len(other), said)
            said = said_of("history", output="&output name='o' kind='history' dt=1e-4 fields='kinetik' /", **other)
            self.assertIn("did you mean 'kinetic'?", said)
        said = said_of("lacks", time="&time t_end=1 parsec /",
                       output="&output name='o' kind='particles' dt=1e-4 fields='temperature' /")
        self.assertIn("is not carried by any material of this scene", said)

    def test_repeat(self):
        """Would catch a mistake that is reported for each copy, or copies that are wrong and not counted."""
        body = "&body name='b' region='r' material='m' repeat=3,1,2 repeat_step={},0,0.02 temperature=300 /"
        lines = problems(said_of("copies", body=body.format(0.01)))
        errors = [line for line in lines if ": error: " in line]
        self.assertEqual(len(errors), 1, lines)
        self.assertIn("&body 'b': temperature needs", errors[0])
        self.assertTrue(errors[0].endswith("(all 6 copies)"), errors)
        lines = problems(said_of("outside", body=body.format(1.5).replace(" temperature=300", "")))
        errors = [line for line in lines if ": error: " in line]
        self.assertEqual(len(errors), 1, lines)
        self.assertRegex(errors[0], r"&body 'b_2_1|&body 'b_3_1")
        self.assertRegex(errors[0], r"lies outside of the grid.*\(and \d more among the 6 copies\)$")

    def test_gas(self):
        """Would catch a gas that is called too light, and a solid or a liquid in other units that is not."""
        light = "lighter than polystyrene"
        gas = "&material name='m' density={} elastic='none' {} /"
        for density, keys, warned in ((1.2, "eos_model='ideal_gas' ig_gamma=1.4", False),
                                      (1e-3, "eos_model='ideal_gas' ig_gamma=1.4", False),
                                      (1.2, "bulk=1.4e5", False), (1.0, "bulk=2.2e9", True),
                                      (1.0, "bulk=2.2", True)):
            said = said_of("gas", material=gas.format(density, keys), expect=0)
            self.assertEqual(light in said, warned, (density, keys, said))
        said = said_of("solid", material="&material name='m' density=2.7 young=7e5 poisson=0.3 /", expect=0)
        self.assertIn(light, said)

    def test_gravity_table(self):
        """Would catch a faulty file that is blamed on velocities, or without the key that names it."""
        effects = "&effects gravity=.true. gravity_vector=0,0,-9.8 gravity_table='g.csv' /"
        said = said_of("no table", effects=effects)
        self.assertIn("&effects: gravity_table: cannot read 'g.csv'", said)
        said = said_of("table", effects=effects, files={"g.csv": "0 0 0\n"})
        self.assertIn("gravity_table: cannot read the accelerations of 'g.csv': line 1: expected four numbers "
                      "t, gx, gy, gz", said)

    def test_formula(self):
        """Would catch a formula without a value at one particle of many that a check lets pass."""
        formula = "&body name='b' region='r' material='m' velocity_formula='1/(x-0.525)','0','sqrt(z-0.3)' /"
        lines = problems(said_of("formula", body=formula))
        self.assertEqual(len(lines), 1)
        self.assertRegex(lines[0], r"deck.nml:6: error: &body 'b': velocity_formula: .* at x, y, z = ")
        said_of("sound formula", body=formula.replace("-0.525", "-0.52").replace("-0.3", "-0.2"), expect=0)
        lines = problems(said_of("two", time="&time t_end=1 parsec /", body=formula))
        self.assertEqual(len(lines), 2, lines)

    def test_all_has_left(self):
        """Would catch a run that goes on without material, says nothing of it, or cannot be restarted."""
        body = "&body name='b' region='r' material='m' velocity=3000,0,0 /"
        said = said_of("left", "--overwrite", body=body, time="&time t_end=0.1 /", expect=0)
        self.assertRegex(said, r"warning: all material has left the grid before t_end, through open boundaries")
        self.assertRegex(said, r"ended +all material has left the grid")
        folder = OPTIONS.work / "left ü"
        again = subprocess.run([OPTIONS.scree, "deck.nml", "--restart"], cwd=folder, text=True, capture_output=True,
                               check=False, timeout=100)
        self.assertEqual(again.returncode, 0, again.stderr)
        self.assertRegex(again.stdout, r"ended +all material has left the grid")

    def test_list(self):
        """Would catch --list without a value that is an error, or names one that cannot be listed."""
        answer = subprocess.run([OPTIONS.scree, "--list"], text=True, capture_output=True, check=False)
        self.assertEqual(answer.returncode, 0, answer.stderr)
        names = [line.split()[0] for line in answer.stdout.splitlines() if line.startswith("   ")]
        self.assertGreater(len(names), 4)
        for name in names:
            answer = subprocess.run([OPTIONS.scree, "--list", name], text=True, capture_output=True, check=False)
            self.assertEqual(answer.returncode, 0, answer.stderr)
            self.assertGreater(len(answer.stdout), 10)
        answer = subprocess.run([OPTIONS.scree, "--list", "?"], text=True, capture_output=True, check=False)
        self.assertEqual(answer.returncode, 2)
        for name in names:
            self.assertIn(name, answer.stderr)


if __name__ == "__main__":
    unittest.main()
