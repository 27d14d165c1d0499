# SPDX-License-Identifier: BSD-3-Clause
# tiers: smoke
"""Invalid decks and command lines: all errors are reported in one pass, with line and hint, and with the exit code.

Would catch an error that is not found, is reported at another line, hides the next one, crashes the program, takes much
memory or time, or changes a file.
"""

import os
import re
import resource
import subprocess

import pytest

import broken_instruments as instruments
import broken_many as many
import broken_scenes as scenes
import broken_values as values
import case
import report

TABLES = [values.KINDS, values.NUMBERS, values.UNKNOWN, values.MARKS, scenes.CONTRADICTIONS, scenes.CELLS,
          scenes.ORPHANS, scenes.NAMES, scenes.BODIES, scenes.ANGLES, scenes.SIZES,
          scenes.INCLUDES, scenes.RARE, instruments.INSTRUMENTS]
ROWS = [row for table in TABLES for row in table]
GOOD = values.DECKS["plain"]
MEMORY = 2 << 30             # address space of a check [byte]; the libraries alone have 0.5 GB
SECONDS = 10                 # processor time of a check, far more than the 0.02 s that one takes

# The errors of the transcript in the manual, and their messages.
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
    """Limit memory and time of the child process."""
    resource.setrlimit(resource.RLIMIT_AS, (MEMORY, MEMORY))
    resource.setrlimit(resource.RLIMIT_CPU, (SECONDS, SECONDS))


def name_of(row):
    """Name of a row from its deck and its message, in ASCII."""
    return ascii(f"{row[0]}: {row[4]}"[:60])[1:-1]


def contents(folder):
    """All files in a folder and its subfolders with their contents."""
    return {path: path.read_bytes() for path in folder.rglob("*") if path.is_file()}


class TestBadDecks:
    """All decks are only checked, except in the last test."""

    @pytest.fixture(autouse=True, scope="class")
    @classmethod
    def made(cls, file_options):
        """True if the program was built with the address sanitizer."""
        answer = subprocess.run([file_options.scree, "--version"], stdout=subprocess.PIPE, text=True, check=True)
        cls.sanitized = "fsanitize" in answer.stdout
        if cls.sanitized:
            report.skipped("bounds of memory and time", "a program with checks of addresses maps terabytes")

    def check(self, options, name, text, *flags, expect=2):
        """Write a deck, from text or bytes, check it, and return the output."""
        folder = options.work / name
        folder.mkdir(parents=True, exist_ok=True)
        path = folder / f"{name}.nml"
        path.write_bytes(text if isinstance(text, bytes) else text.encode())
        return self.run_check(options, path, ("--check", "--no-estimate", *flags), expect)

    def run_check(self, options, path, flags, expect):
        """Run the program on a deck, and check that its folder is unchanged."""
        before = contents(path.parent)
        answer = subprocess.run([options.scree, *flags, path.name], cwd=path.parent,
                                stdout=subprocess.PIPE, stderr=subprocess.STDOUT, timeout=60,
                                env={**os.environ, **case.OPEN_MPI, "OMP_NUM_THREADS": "1"},
                                preexec_fn=None if self.sanitized else bound, check=False)
        output = answer.stdout.decode(errors="replace")
        assert answer.returncode == expect, output
        assert before == contents(path.parent), "a file was written"
        return output

    def look_for(self, options, row, word, expect):
        """One row of a table: the message must be reported at its line."""
        deck, old, new, line, said = row
        assert old in values.DECKS[deck]
        output = self.check(options, "deck", values.DECKS[deck].replace(old, new, 1), expect=expect)
        place = f"deck.nml:{line}:" if line else "deck.nml:"
        assert any(text.startswith(f"{place} {word}: ") and said in text for text in output.splitlines()), (
            f"{place} {word}: {said}\n{output}"
        )

    def test_all_faults_in_one_pass(self, options):
        """Would catch an error that hides another one."""
        output = self.check(options, "faulty", FAULTY).splitlines()
        wanted = SAID.splitlines()
        found = [line for line in output if line.startswith("faulty.nml")]
        assert len(found) == len(wanted), "\n".join(output)
        for line, start in zip(found, wanted):
            assert line.startswith(start), f"{line}\n{start}"

    def test_faults_of_all_stages(self, options, sheet):
        """Would catch: a stage of checks that is skipped because an earlier one found an unrelated error; follow-up
        errors."""
        for text, lines in many.DECKS:
            with sheet.part(lines[0]):
                output = self.check(options, "many", text)
                told = [re.sub(r" \[[A-Z]\d{3}\]$", "", line.partition(".nml:")[2])
                        for line in output.splitlines() if ": error: " in line]
                assert told == lines, output

    def test_good_decks(self, options, sheet):
        """Would catch a check that reports errors in valid decks, from which the changes start."""
        for name, text in values.DECKS.items():
            with sheet.part(name):
                assert " 0 errors, 0 warnings" in self.check(options, name, text, expect=0)

    @pytest.mark.parametrize("row", ROWS, ids=name_of)
    def test_broken_decks(self, options, row):
        """Would catch a single error without its message, at another line, or one that takes much memory."""
        self.look_for(options, row, "error", 2)

    def test_there_are_many(self):
        assert len(ROWS) > 200

    @pytest.mark.parametrize("row", scenes.WARNINGS, ids=name_of)
    def test_warnings(self, options, row):
        """Would catch numbers in wrong units, and overlapping bodies, that are not reported."""
        self.look_for(options, row, "warning", 0)

    def test_force(self, options):
        """Would catch sizes that cannot be requested at all, or a limit that --force does not lift."""
        deck = values.DECKS["shock"].replace("dt = 1 /", "dt = 1e-6 /")
        assert "continue with --force" in self.check(options, "force", deck)
        assert " 0 errors" in self.check(options, "force", deck, "--force", expect=0)

    def test_no_estimate(self, options):
        """Would catch an estimate that is made in spite of the option, other lines that are omitted with it, another
        exit code, and an option that is ignored where it has no meaning."""
        folder = options.work / "estimate"
        folder.mkdir(parents=True, exist_ok=True)
        path = folder / "estimate.nml"
        path.write_text(values.DECKS["plain"], encoding="utf-8")
        whole = self.run_check(options, path, ("--check",), 0).splitlines(keepends=True)
        less = self.run_check(options, path, ("--check", "--no-estimate"), 0).splitlines(keepends=True)
        assert whole[-1].startswith("estimate   "), whole
        assert less == whole[:-1]
        assert "--no-estimate needs --check" in self.run_check(options, path, ("--no-estimate",), 2)

    def test_command_lines(self, options, sheet):
        """Would catch an invalid option that is ignored."""
        for flags, said in scenes.COMMANDS:
            with sheet.part(flags):
                output = self.check(options, "command", GOOD, *flags)
                assert any(line.startswith("command line: error: ") and said in line for line in output.splitlines()), (
                    output
                )

    def test_what_is_no_deck(self, options):
        """Would catch a crash, or a wrong exit code, for files that are not decks."""
        assert "the deck is empty; scree --template" in self.check(options, "empty", "")
        assert "the deck is empty" in self.check(options, "comment", "! nothing here\n")
        assert "a deck is plain text" in self.check(options, "binary", bytes(range(256)) * 40)
        assert "not closed" in self.check(options, "open", "&run")
        assert "unknown group" in self.check(options, "long", "&" + "x" * 500 + " /")
        assert "longer than 512" in self.check(options, "line", GOOD + "!" + "x" * 600)
        self.run_check(options, options.work / "nobody.nml", ("--check",), 3)
        self.run_check(options, options.work / "empty", ("--check",), 3)

    def test_includes(self, options):
        """Would catch an include that is repeated without end, ignored, or not found."""
        assert "cannot include itself" in self.check(options, "ring", "&include file = 'ring.nml' /")
        assert "cannot read 'nobody.nml'" in self.check(options, "lost", "&include file = 'nobody.nml' /", expect=3)
        assert "this is a folder" in self.check(options, "dot", "&include file = '.' /", expect=3)
        folder = options.work / "chain"
        folder.mkdir(exist_ok=True)
        (folder / "other.nml").write_text("&include file = 'chain.nml' /\n", encoding="utf-8")
        assert "chain.nml > other.nml > chain.nml" in self.check(options, "chain", "&include file = 'other.nml' /")
        (folder / "other.nml").write_text("! a line\n&time t_end = x /\n", encoding="utf-8")
        assert "other.nml:2: error: &time: t_end = x  <- expects a number" in self.check(options,
            "chain", GOOD.replace("&time t_end = 1e-4 /", "&include file = 'other.nml' /")
        )

    def test_other_ends_of_lines(self, options):
        """Would catch decks with line ends of other systems that are read differently."""
        self.check(options, "returns", GOOD.replace("\n", "\r\n"), expect=0)
        self.check(options, "tabs", GOOD.replace("  ", "\t").rstrip("\n"), expect=0)
        self.check(options, "mark", b"\xef\xbb\xbf" + GOOD.encode(), expect=0)

    def test_results_stay(self, options, sheet):
        """Would catch a run that is refused only after it has changed the results of an earlier run."""
        folder = options.work / "stay"
        (folder / "out").mkdir(parents=True, exist_ok=True)
        for name in ("stay.log", "stay_history.csv", "stay_chk_0001.h5", "stay_p_000000.hdf"):
            (folder / "out" / name).write_text("earlier results\n", encoding="utf-8")
        path = folder / "stay.nml"
        for row in (values.NUMBERS[0], scenes.BODIES[0], scenes.SIZES[0], scenes.SIZES[2]):
            with sheet.part(row):
                path.write_text(values.DECKS[row[0]].replace(row[1], row[2]), encoding="utf-8")
                for flags in (("--outdir", "out"), ("--outdir", "out", "--restart")):
                    assert row[4] in self.run_check(options, path, flags, 2)
