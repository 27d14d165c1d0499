# SPDX-License-Identifier: BSD-3-Clause
# tiers: smoke
"""Wrong decks and command lines: all faults in one pass, with line and hint, and the exit code.

Would catch a fault that is not seen, is seen at another line, hides the next one, crashes the
program, takes memory or time with it, or changes a file.
"""

import os
import re
import resource
import subprocess
import unittest

import case
import report
import broken_instruments as instruments
import broken_many as many
import broken_scenes as scenes
import broken_values as values

OPTIONS = case.arguments(__doc__)
TABLES = [values.KINDS, values.NUMBERS, values.UNKNOWN, values.MARKS, scenes.CONTRADICTIONS, scenes.CELLS,
          scenes.ORPHANS, scenes.NAMES, scenes.BODIES, scenes.ANGLES, scenes.SIZES,
          scenes.INCLUDES, scenes.RARE, instruments.INSTRUMENTS]
GOOD = values.DECKS["plain"]
MEMORY = 2 << 30             # address space of a check [byte]; the libraries alone have 0.5 GB
SECONDS = 10                 # processor time of a check, far more than the 0.02 s that one takes

# The faults of the transcript in the manual, and what is said about them.
FAULTY = """&run
  title = 'many faults'
  dimention = '3d'
/
&grid
  lo = 0, 0, 0
  hi = 30, 30, 30
  dx = 1 mmm
/
&material
  name = 'first'
  density = 2700 kg
  young = 70e9
  poisson = 0.3
  strength_model = 'jonson_cook'
/
&material name = 'second'  density = 7800  young = 200e9  poisson = 0.3
&region name = 'ball'  shape = 'sphere'  centre = 3*15  radius = 5 /
&body name = 'one'  region = 'bal'  material = 'first' /
&time
  t_end = 1
/
&boundry face = 'xlo' /
&output name = 'o'  kind = 'history'  every = 2.5 /
&time t_end = 2 /
&effects gravity = yes /
"""
SAID = """faulty.nml:3: error: &run: unknown key 'dimention'; did you mean 'dimension'?
faulty.nml:8: error: &grid: dx = 1 mmm  <- 'mmm' is not a unit
faulty.nml:12: error: &material: density = 2700 kg  <- expects kg/m3 or a unit
faulty.nml:15: error: &material: strength_model = 'jonson_cook' is none of:
faulty.nml:18: error: &material opened in line 17 is not closed before this group
faulty.nml:19: error: &body 'one': no region 'bal'; defined: ball; did you mean 'ball'?
faulty.nml:23: error: unknown group &boundry; did you mean &boundary?
faulty.nml:24: error: &output: every = 2.5  <- expects an integer
faulty.nml:25: error: &time appears twice; only one is allowed
faulty.nml:26: error: &effects: gravity = yes  <- expects .true. or .false.
faulty.nml: 11 groups, 10 errors, 0 warnings"""


def bound():
    """Bounds of memory and time in the child. A program with checks of addresses maps terabytes."""
    if not SANITIZED:
        resource.setrlimit(resource.RLIMIT_AS, (MEMORY, MEMORY))
        resource.setrlimit(resource.RLIMIT_CPU, (SECONDS, SECONDS))


def sanitized():
    """True if the program was built with checks of addresses."""
    answer = subprocess.run([OPTIONS.scree, "--version"], stdout=subprocess.PIPE, text=True,
                            check=True)
    return "fsanitize" in answer.stdout


SANITIZED = sanitized()
if SANITIZED:
    report.skipped("bounds of memory and time", "a program with checks of addresses maps terabytes")


def contents(folder):
    """All files below a folder with their bytes."""
    return {path: path.read_bytes() for path in folder.rglob("*") if path.is_file()}


class BadDecks(unittest.TestCase):
    """Each is checked only, but for the last: nothing is computed."""

    def check(self, name, text, *options, expect=2):
        """Write a deck, or the bytes given, check it, and give back what is said."""
        folder = OPTIONS.work / name
        folder.mkdir(parents=True, exist_ok=True)
        path = folder / f"{name}.nml"
        path.write_bytes(text if isinstance(text, bytes) else text.encode())
        return self.run_check(path, ("--check", "--no-estimate", *options), expect)

    def run_check(self, path, options, expect):
        """Run the program on a deck, and see that its folder is what it was."""
        before = contents(path.parent)
        answer = subprocess.run([OPTIONS.scree, *options, path.name], cwd=path.parent,
                                stdout=subprocess.PIPE, stderr=subprocess.STDOUT, timeout=60,
                                env={**os.environ, **case.OPEN_MPI, "OMP_NUM_THREADS": "1"},
                                preexec_fn=bound, check=False)
        output = answer.stdout.decode(errors="replace")
        self.assertEqual(answer.returncode, expect, output)
        self.assertEqual(before, contents(path.parent), "a file was written")
        return output

    def look_for(self, row, word, expect):
        """One row of a table: the message must stand at its line."""
        deck, old, new, line, said = row
        self.assertIn(old, values.DECKS[deck])
        output = self.check("deck", values.DECKS[deck].replace(old, new, 1), expect=expect)
        place = f"deck.nml:{line}:" if line else "deck.nml:"
        self.assertTrue(any(text.startswith(f"{place} {word}: ") and said in text
                            for text in output.splitlines()), f"{place} {word}: {said}\n{output}")

    def test_all_faults_in_one_pass(self):
        """Would catch a fault that hides another one."""
        output = self.check("faulty", FAULTY).splitlines()
        wanted = SAID.splitlines()
        found = [line for line in output if line.startswith("faulty.nml")]
        self.assertEqual(len(found), len(wanted), "\n".join(output))
        for line, start in zip(found, wanted):
            self.assertTrue(line.startswith(start), f"{line}\n{start}")

    def test_faults_of_all_stages(self):
        """Would catch: a stage that is not run because an earlier one found a fault of something else; follow-up
        errors."""
        for text, lines in many.DECKS:
            with self.subTest(lines[0]):
                output = self.check("many", text)
                told = [re.sub(r" \[[A-Z]\d{3}\]$", "", line.partition(".nml:")[2])
                        for line in output.splitlines() if ": error: " in line]
                self.assertEqual(told, lines, output)

    def test_good_decks(self):
        """Would catch a check that finds faults where there are none: the changes start from it."""
        for name, text in values.DECKS.items():
            with self.subTest(name):
                self.assertIn(" 0 errors, 0 warnings", self.check(name, text, expect=0))

    def test_broken_decks(self):
        """Would catch a single fault without its message, at another line, or that takes memory."""
        rows = [row for table in TABLES for row in table]
        self.assertGreater(len(rows), 200)
        for row in rows:
            with self.subTest(row):
                self.look_for(row, "error", 2)

    def test_warnings(self):
        """Would catch numbers in wrong units, and bodies in each other, that nobody is told of."""
        for row in scenes.WARNINGS:
            with self.subTest(row):
                self.look_for(row, "warning", 0)

    def test_force(self):
        """Would catch sizes that can be had in no way, or a limit that --force does not lift."""
        deck = values.DECKS["shock"].replace("dt = 1 /", "dt = 1e-6 /")
        self.assertIn("continue with --force", self.check("force", deck))
        self.assertIn(" 0 errors", self.check("force", deck, "--force", expect=0))

    def test_no_estimate(self):
        """Would catch an estimate that is made all the same, other lines that are left out with it, another exit
        code, and an option that is ignored where it has no meaning."""
        folder = OPTIONS.work / "estimate"
        folder.mkdir(parents=True, exist_ok=True)
        path = folder / "estimate.nml"
        path.write_text(values.DECKS["plain"], encoding="utf-8")
        whole = self.run_check(path, ("--check",), 0).splitlines(keepends=True)
        less = self.run_check(path, ("--check", "--no-estimate"), 0).splitlines(keepends=True)
        self.assertTrue(whole[-1].startswith("estimate   "), whole)
        self.assertEqual(less, whole[:-1])
        self.assertIn("--no-estimate needs --check", self.run_check(path, ("--no-estimate",), 2))

    def test_command_lines(self):
        """Would catch a wrong option that is ignored."""
        for options, said in scenes.COMMANDS:
            with self.subTest(options):
                output = self.check("command", GOOD, *options)
                self.assertTrue(any(line.startswith("command line: error: ") and said in line
                                    for line in output.splitlines()), output)

    def test_what_is_no_deck(self):
        """Would catch a crash, or a wrong exit code, on files that are no deck."""
        self.assertIn("the deck is empty; scree --template", self.check("empty", ""))
        self.assertIn("the deck is empty", self.check("comment", "! nothing here\n"))
        self.assertIn("a deck is plain text", self.check("binary", bytes(range(256)) * 40))
        self.assertIn("not closed", self.check("open", "&run"))
        self.assertIn("unknown group", self.check("long", "&" + "x" * 500 + " /"))
        self.assertIn("longer than 512", self.check("line", GOOD + "!" + "x" * 600))
        self.run_check(OPTIONS.work / "nobody.nml", ("--check",), 3)
        self.run_check(OPTIONS.work / "empty", ("--check",), 3)

    def test_includes(self):
        """Would catch an include that never ends, is ignored, or is not found."""
        self.assertIn("cannot include itself", self.check("ring", "&include file = 'ring.nml' /"))
        self.assertIn("cannot read 'nobody.nml'",
                      self.check("lost", "&include file = 'nobody.nml' /", expect=3))
        self.assertIn("this is a folder", self.check("dot", "&include file = '.' /", expect=3))
        folder = OPTIONS.work / "chain"
        folder.mkdir(exist_ok=True)
        (folder / "other.nml").write_text("&include file = 'chain.nml' /\n", encoding="utf-8")
        self.assertIn("chain.nml > other.nml > chain.nml",
                      self.check("chain", "&include file = 'other.nml' /"))
        (folder / "other.nml").write_text("! a line\n&time t_end = x /\n", encoding="utf-8")
        self.assertIn("other.nml:2: error: &time: t_end = x  <- expects a number",
                      self.check("chain", GOOD.replace("&time t_end = 1e-5 /",
                                                       "&include file = 'other.nml' /")))

    def test_other_ends_of_lines(self):
        """Would catch decks of other systems that are read differently."""
        self.check("returns", GOOD.replace("\n", "\r\n"), expect=0)
        self.check("tabs", GOOD.replace("  ", "\t").rstrip("\n"), expect=0)
        self.check("mark", b"\xef\xbb\xbf" + GOOD.encode(), expect=0)

    def test_results_stay(self):
        """Would catch a run that is refused after it has touched the results of an earlier one."""
        folder = OPTIONS.work / "stay"
        (folder / "out").mkdir(parents=True, exist_ok=True)
        for name in ("stay.log", "stay_history.csv", "stay_chk_0001.h5", "stay_p_000000.hdf"):
            (folder / "out" / name).write_text("earlier results\n", encoding="utf-8")
        path = folder / "stay.nml"
        for row in (values.NUMBERS[0], scenes.BODIES[0], scenes.SIZES[0], scenes.SIZES[2]):
            with self.subTest(row):
                path.write_text(values.DECKS[row[0]].replace(row[1], row[2]), encoding="utf-8")
                for options in (("--outdir", "out"), ("--outdir", "out", "--restart")):
                    self.assertIn(row[4], self.run_check(path, options, 2))


if __name__ == "__main__":
    unittest.main()
