# SPDX-License-Identifier: BSD-3-Clause
# tiers: smoke
"""scree-deck migrate: decks in the names of before become decks in those of today, and nothing else of them changes.

Would catch a name that the program calls former and the command does not know, a comment, quote, blank or end of line
that is lost, a name that is changed where it is only a word of a title or comment, a deck that is half written where
somebody must decide, and an included file that is forgotten.
"""

import contextlib
import io
import os
import shutil
import subprocess
import sys
import unittest
from types import SimpleNamespace

import case
import post_command
from scree_post import deck_command, deck_migrate
from scree_post.deck_text import DeckText
from scree_post.errors import PostError

OPTIONS = case.arguments(__doc__)
OLD = """! packing = 'grid': as it was called; sparse = .true.
&run
  title = 'packing = grid, it''s old'   dimension = 'axisymmetric'
/
&effects gravity = .true.  granular = .true.  conduction = F /
&grid lo = 0 0 0  hi = 1 0 1
  sparse = .true.\t! only what holds matter
  GROW   = .false.
  dx = 0.05, layout_is_no_key
/
&time t_end = 0.01  cfl = 0.3 /
&material name = 'sand'  density = 1500  bulk = 3e5  shear = 1.4e5   ! packing
  strength_model = "drucker_prager"  friction_angle = 35
  Packing = "grid" /
&region name = 'pile'  shape = 'cylinder'  centre = 0 0 0.2  radius = 0.5  height = 0.4 /
&body name = 'heap'  region = 'pile'  material = 'sand'  packing = 'cut' /
&boundary face = 'zlo'  type = 'friction'  friction = 0.5 /
&parallel layout = 2, ! across
   1, 1
   balance="every" /
&log colour = 'never' /
"""
NEW = """! packing = 'grid': as it was called; sparse = .true.
&run
  title = 'packing = grid, it''s old'   dimension = 'axisymmetric'
/
&effects gravity = .true.  /
&grid lo = 0 0 0  hi = 1 0 1
  ! only what holds matter
  dx = 0.05, layout_is_no_key
/
&time t_end = 0.01  cfl = 0.3 /
&material name = 'sand'  density = 1500  bulk = 3e5  shear = 1.4e5   ! packing
  strength_model = "drucker_prager"  friction_angle = 35
  volume_from = "grid" /
&region name = 'pile'  shape = 'cylinder'  centre = 0 0 0.2  radius = 0.5  height = 0.4 /
&body name = 'heap'  region = 'pile'  material = 'sand'  packing = 'cut' /
&boundary face = 'zlo'  type = 'friction'  friction = 0.5 /
&parallel ! across
   balance="auto" /
&log /
"""
SAID = ["5: &effects: granular = .true.  ->  gone: ", "5: &effects: conduction = F  ->  gone: ",
        "7: &grid: sparse = .true.  ->  gone: ", "8: &grid: GROW = .false.  ->  gone: ",
        "14: &material: Packing = \"grid\"  ->  volume_from = \"grid\"",
        "18: &parallel: layout = 2, 1, 1  ->  gone: ",
        "20: &parallel: balance=\"every\"  ->  balance = \"auto\"", "21: &log: colour = 'never'  ->  gone: "]
LATER = """deck_version 3
grid.edge -> dx; since deck_version 2
body.kind = 'a' 'b' -> way = 'c'; since deck_version 3  ! both are one
effects.glow -> by hand; since deck_version 3  ! nothing glows
"""


def call(*words):
    """Exit code and what scree-deck prints, in this process."""
    out, errors, saved = io.StringIO(), io.StringIO(), sys.argv
    sys.argv = ["scree-deck", *map(str, words)]
    code = 0
    try:
        with contextlib.redirect_stdout(out), contextlib.redirect_stderr(errors):
            deck_command.run()
    except SystemExit as leave:
        code = leave.code
    finally:
        sys.argv = saved
    return SimpleNamespace(returncode=code, stdout=out.getvalue(), stderr=errors.getvalue())


def migrate(*words):
    """scree-deck migrate with the program of the test."""
    return call("migrate", *words, "--scree", OPTIONS.scree)


def check(path):
    """Exit code and what scree --check says of a deck."""
    answer = subprocess.run([OPTIONS.scree, "--check", "--no-estimate", str(path)], capture_output=True, text=True,
                            env={**os.environ, **case.OPEN_MPI})
    return answer.returncode, answer.stdout + answer.stderr


class Migrate(unittest.TestCase):
    """Each test has a folder of its own."""

    def setUp(self):
        self.folder = OPTIONS.work / self.id().rsplit(".", 1)[1]
        shutil.rmtree(self.folder, ignore_errors=True)
        self.folder.mkdir(parents=True)

    def deck(self, text, name="old.nml"):
        """A file of these letters, each as it is."""
        path = self.folder / name
        path.write_bytes(text.encode("utf-8"))
        return path

    def migrated(self, text, table=LATER):
        """What becomes of a deck by some table."""
        return deck_migrate.migrate(DeckText(self.deck(text)), deck_migrate.read_table(table))

    def test_names_change_and_nothing_else(self):
        """Letter by letter, with the ends of lines of any system, a mark at the begin and letters of any alphabet."""
        for ending, mark in [("\n", ""), ("\r\n", "\ufeff"), ("\r", "")]:
            with self.subTest(ending=repr(ending)):
                old = self.deck(mark + OLD.replace("sand", "Sä\u4e16").replace("\n", ending))
                new = self.folder / f"new{len(ending)}{len(mark)}{ord(ending[0])}.nml"
                answer = migrate(old, "--out", new)
                self.assertEqual(answer.returncode, 0, answer.stderr)
                wanted = mark + NEW.replace("sand", "Sä\u4e16").replace("\n", ending)
                self.assertEqual(new.read_bytes().decode("utf-8"), wanted)
                told = answer.stdout.splitlines()
                self.assertEqual(len(told), len(SAID) + 1)
                for line, said in zip(sorted(told, key=lambda text: text.startswith("wrote")), SAID):
                    self.assertIn(f"{old}:{said}", line)

    def test_the_program_takes_the_new_deck(self):
        """It refuses the old one and names the command; it finds no fault in the new one."""
        old = self.deck(OLD.replace(", layout_is_no_key", ""))
        code, said = check(old)
        self.assertEqual(code, 2)
        self.assertEqual(said.count(f"run scree-deck migrate {old}"), len(SAID))
        self.assertEqual(said.count(" is always so: ") + said.count(" does nothing: "), 4)
        answer = migrate(old, "--write")
        self.assertEqual(answer.returncode, 0, answer.stderr)
        code, said = check(old)
        self.assertEqual(code, 0, said)
        again = migrate(old, "--write")
        self.assertEqual((again.returncode, again.stdout), (0, f"{old}: nothing to change\n"))

    def test_the_table_is_that_of_the_program(self):
        """Every former name: the program tells a deck that holds it, and the command mends it or says who must."""
        table = deck_migrate.table_of(OPTIONS.scree)
        self.assertGreater(len(table.formers), 10)
        self.assertEqual(table.version, 1)
        for former in table.formers:
            value = former.words[0] if former.words else "0"
            value = value if value[0] in ".0" else f"'{value}'"
            with self.subTest(former=former):
                deck = self.deck(f"&{former.group} {former.key} = {value} /\n")
                self.assertRegex(check(deck)[1], rf"old.nml:1: (error: &{former.group}: .*(is called|is gone)"
                                 rf"|warning: &{former.group}: .*(is always so|does nothing))")
                answer = migrate(deck, "--write")
                if former.new == "by hand":
                    self.assertEqual(answer.returncode, 1)
                    self.assertIn(f"{deck}:1: error: &{former.group}: {former.key}", answer.stderr)
                else:
                    self.assertEqual(answer.returncode, 0, answer.stderr)
                    self.assertNotRegex(check(deck)[1], "is called|is gone|always so|does nothing")

    def test_what_somebody_must_decide(self):
        """A box that should grow, pores, a new name that is given already: told with lines, nothing is written."""
        text = ("&grid grow = T\n sparse = T /\n&body porosity = 0.1 /\n"
                "&material packing = 'grid'\n volume_from = 'grid' /\n")
        deck = self.deck(text)
        answer = migrate(deck, "--write")
        self.assertEqual(answer.returncode, 1)
        self.assertEqual([line.split(": ")[0] for line in answer.stderr.splitlines()[:3]],
                         [f"{deck}:{line}" for line in (1, 3, 4)])
        self.assertIn("volume_from is given already in line 5", answer.stderr)
        self.assertIn("nothing is written", answer.stderr)
        self.assertEqual(deck.read_text(encoding="utf-8"), text)
        self.assertEqual(migrate(deck, "--out", self.folder / "new.nml").returncode, 1)
        self.assertEqual([path.name for path in self.folder.iterdir()], ["old.nml"])

    def test_includes(self):
        """Files that a deck includes change with it, one that includes itself too, but not behind the back of --out."""
        self.deck("&parallel layout = 1 1 1 /\n&include file = 'old.nml' /\n", "more.nml")
        self.deck("&time t_end = 1 /\n", "same.nml")
        deck = self.deck("&log colour = 'auto' /\n&include file = 'more.nml' /\n&include file=\"same.nml\"/\n")
        answer = migrate(deck, "--out", self.folder / "new.nml")
        self.assertEqual(answer.returncode, 1)
        self.assertIn("more.nml must change too", answer.stderr)
        answer = migrate(deck, "--write")
        self.assertEqual(answer.returncode, 0, answer.stderr)
        self.assertEqual(answer.stdout.count("wrote"), 2)
        self.assertEqual(deck.read_text(encoding="utf-8"),
                         "&log /\n&include file = 'more.nml' /\n&include file=\"same.nml\"/\n")
        self.assertEqual((self.folder / "more.nml").read_text(encoding="utf-8"),
                         "&parallel /\n&include file = 'old.nml' /\n")
        there = self.folder / "there"
        there.mkdir(exist_ok=True)
        answer = migrate(deck, "--out", there / "new.nml")
        self.assertEqual(answer.returncode, 1)
        self.assertIn("names files by their place", answer.stderr)
        there.rmdir()
        self.assertEqual(migrate(self.deck("&include file = 'none.nml' /\n")).returncode, 3)

    def test_formats(self):
        """A table of later formats: the version is raised or written, and a deck of a still later one is refused."""
        for old, new in [("&run deck_version = 1 /", "&run deck_version = 3 /"), ("&run /", "&run deck_version = 3 /"),
                         ("&run\n  case = 'a'\n/", "&run\n  deck_version = 3\n  case = 'a'\n/"),
                         ("&run case='a' /", "&run deck_version = 3 case='a' /"),
                         ("&run deck_version = 3 /", "&run deck_version = 3 /"), ("&grid /", "&grid /"),
                         ("&RUN ! here\n Deck_Version=2, case = 'b' &END",
                          "&RUN ! here\n Deck_Version=3, case = 'b' &END"),
                         ("&grid edge = 1 /\n&body kind='B' /", "&grid dx = 1 /\n&body way='c' /")]:
            with self.subTest(old=old):
                done = self.migrated(old + "\n")
                self.assertEqual(done.refused, [])
                self.assertEqual(done.text, new + "\n")
                self.assertEqual(bool(done.changes), old != new)
        for old, why in [("&run\n deck_version = 4 /", (2, "knows formats from 1 to 3")),
                         ("&effects\n\n glow = F /", (3, "nothing glows"))]:
            (line, said), = self.migrated(old + "\n").refused
            self.assertEqual(line, why[0])
            self.assertIn(why[1], said)
        with self.assertRaises(PostError):
            deck_migrate.read_table("materials: elastic\n")

    def test_command_line(self):
        """Nothing is written without being asked, nor over a file; what is no deck is refused in a line."""
        deck = self.deck(OLD)
        answer = migrate(deck)
        self.assertEqual(answer.returncode, 0)
        self.assertIn("nothing is written; --write", answer.stdout)
        self.assertEqual(deck.read_bytes().decode("utf-8"), OLD)
        quote = self.deck("&run case = 'a\n/\n", "quote.nml")
        slash = self.deck("&run case = 'a'\n&grid /\n", "slash.nml")
        for words, code, said in [((deck, "--out", deck), 3, "is there already"),
                                  ((deck, "--out", "a", "--write"), 2, "not allowed with"),
                                  ((self.folder / "no.nml",), 3, "no such file"),
                                  ((quote,), 3, "quote.nml:1: the quote is not closed"),
                                  ((slash,), 3, "slash.nml:1: &run is not closed")]:
            answer = migrate(*words)
            self.assertEqual(answer.returncode, code, answer.stderr)
            self.assertIn(said, answer.stderr)
            self.assertEqual(answer.stderr.count("\n"), 1)
        self.assertEqual(call().returncode, 2)
        self.assertIn("did you mean 'migrate'?", call("migrat").stderr)
        self.assertIn("scree-deck migrate old.nml --write", call("migrate", "--help").stdout)
        self.assertIn("migrate", call("--help").stdout)

    def test_the_page_shows_what_is_said(self):
        """The lines in doc/guide/deck.md are those that the command prints of such a deck."""
        page = (case.ROOT / "doc/guide/deck.md").read_text(encoding="utf-8")
        shown = page.split("$ build/venv/bin/scree-deck migrate old.nml\n")[1].split("```")[0]
        self.deck("\n" * 3 + "&material packing = 'grid' /\n" + "\n" * 4 + "&grid sparse = .true. /\n")
        here = os.getcwd()
        os.chdir(self.folder)
        try:
            self.assertEqual(migrate("old.nml").stdout, shown)
        finally:
            os.chdir(here)

    def test_all_examples_stay(self):
        """Decks of today: none is touched, so the scanner takes their texts, comments and lists for what they are."""
        decks = sorted((case.ROOT / "input").rglob("*.nml"))
        self.assertGreater(len(decks), 10)
        table = deck_migrate.table_of(OPTIONS.scree)
        for deck in decks:
            for done in deck_migrate.with_includes(deck, table):
                self.assertEqual((done.changes, done.refused), ([], []), deck)
                self.assertEqual(done.text.encode("latin-1"), deck.read_bytes())
                self.assertGreater(sum(len(group.pieces) for group in done.deck.groups), 10)


class Command(unittest.TestCase):
    """The command by itself."""

    def test_it_starts(self):
        """In a process of its own, as the installed command calls it."""
        self.assertEqual(post_command.SCRIPTS.name, "scripts")
        text = (post_command.SCRIPTS / "pyproject.toml").read_text(encoding="utf-8")
        self.assertIn('scree-deck = "scree_post.deck_command:run"', text)
        answer = subprocess.run(
            [sys.executable, "-c", "from scree_post.deck_command import run; run()", "--version"], text=True,
            capture_output=True, env={**os.environ, "PYTHONPATH": str(post_command.SCRIPTS)}, check=False)
        self.assertEqual(answer.returncode, 0, answer.stderr)
        self.assertRegex(answer.stdout, r"^scree-deck \d+\.\d+\.\d+$")


if __name__ == "__main__":
    unittest.main()
