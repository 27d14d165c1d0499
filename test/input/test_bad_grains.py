# SPDX-License-Identifier: BSD-3-Clause
# tiers: smoke
"""Invalid decks of cells of grains, and runs of them that stop early: message, line and exit code.

Would catch an error that is not found, is reported at another line, or writes a file; a valid deck that is refused; a
cell that is too thin, contacts that are too soft, or a restart with other grains that continue with wrong results.
"""

import subprocess

import broken_grains as broken
import case


class TestBadGrains:
    """All decks are only checked, except in the last tests."""

    def check(self, options, text, expect):
        """Check a deck, which must not write any file; the output."""
        folder = options.work / "deck"
        folder.mkdir(parents=True, exist_ok=True)
        (folder / "deck.nml").write_text(text, encoding="ascii")
        answer = subprocess.run([options.scree, "--grains", "--check", "deck.nml"], cwd=folder, text=True, timeout=60,
                                stdout=subprocess.PIPE, stderr=subprocess.STDOUT, check=False)
        assert answer.returncode == expect, answer.stdout
        assert [path.name for path in folder.rglob("*")] == ["deck.nml"]
        return answer.stdout

    def test_good_decks(self, options, sheet):
        """Would catch a check that reports errors in valid decks, from which the changes start."""
        for name, text in broken.DECKS.items():
            with sheet.part(name):
                assert " 0 errors, 0 warnings" in self.check(options, text, 0)

    def test_broken_decks(self, options, sheet):
        """Would catch an error without its message, or at another line."""
        assert len(broken.FAULTS) > 15
        for deck, old, new, line, said in broken.FAULTS:
            with sheet.part(said):
                assert old in broken.DECKS[deck]
                output = self.check(options, broken.DECKS[deck].replace(old, new, 1), 2)
                assert any(
                    text.startswith(f"deck.nml:{line}: error: ") and said in text for text in output.splitlines()
                ), output

    def test_a_run_of_the_scene_ignores_it(self, options):
        """Would catch groups of grains that are checked in a scene, where they have no effect."""
        text = broken.DECKS["discs"].replace("'isotropic'", "'xyz'")
        one = case.Case(options, "scene", text).run("--check", "--no-estimate", expect=None)
        assert "discs have no z" not in one.output

    def test_thin_cell(self, options, sheet):
        """Would catch a cell in which a grain has two images of another grain as neighbours, one of which would be
        lost."""
        for name, old, new in (("lattice", "cells = 3 3 3", "cells = 3 1 3"),
                               ("discs", "volume_fraction = 0.4", "volume_fraction = 0.4  aspect = 60 1 1")):
            with sheet.part(name):
                run = case.Case(options, "thin", broken.DECKS[name].replace(old, new)).run("--grains", expect=2)
                assert "the cell is lower than two diameters and two skins at step 0: use more" in run.output

    def test_soft_contacts(self, options):
        """Would catch overlaps beyond the range of any contact law that are not reported."""
        text = broken.DECKS["discs"].replace("stiffness = 1e6", "stiffness = 1e2").replace(
            "duration = 1e-3", "duration = 1").replace("0.4", "0.4  speed = 0.1")
        run = case.Case(options, "soft", text).run("--grains", "--quiet", expect=4)
        assert "grains overlap by more than a tenth of a diameter" in run.output
        assert "raise stiffness (or young) in &grains" in run.output

    def test_restart(self, options):
        """Would catch a restart with other grains, or one after the end of the run."""
        deck = broken.DECKS["discs"]
        run = case.Case(options, "again", deck).run("--grains", "--quiet")
        run.run("--grains", "--quiet", "--restart", expect=2)
        assert "all stages of the deck are completed; add a &stage to continue" in run.output
        more = deck + "&stage name = 'more'  servo = 'x'  pressure = 1e3  duration = 1e-4 /\n"
        run.deck.write_text(more.replace("number = 100", "number = 121"), encoding="ascii")
        run.run("--grains", "--quiet", "--restart", expect=3)
        assert "&grains number = 121, was 100" in run.output
        # with one more stage it continues, and ends as a run that had this stage from the start
        run.deck.write_text(more, encoding="ascii")
        run.run("--grains", "--quiet", "--restart")
        whole = case.Case(options, "whole", more).run("--grains", "--quiet")
        assert run.summary["digest"] == whole.summary["digest"]
        assert run.path("_history.csv").read_bytes() == whole.path("_history.csv").read_bytes()
