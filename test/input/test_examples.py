# SPDX-License-Identifier: BSD-3-Clause
"""`--list examples` and `--new`: from the build tree, installed, and where they must refuse.

Would catch examples that are found only from the source tree or from one working folder, a copy that does not run or
whose picture cannot be drawn, a text that refers to files that do not exist, and a folder that is overwritten.
"""

import os
import re
import shutil
import subprocess
import sys

import pytest

import case

LINK = re.compile(r"\]\(([^)\s:]+)\)")


def run(options, program, *words, folder=None):
    """Exit code, output and errors of a call from a given folder."""
    answer = subprocess.run([str(word) for word in (program, *words)], cwd=folder or options.work, text=True,
                            timeout=100,
                            capture_output=True, env={**os.environ, **case.OPEN_MPI, "OMP_NUM_THREADS": "1"})
    return answer.returncode, answer.stdout, answer.stderr


class TestExamples:
    """Each test has a separate folder, with a blank and an accent in its name."""

    @pytest.fixture(autouse=True)
    def made(self, options):
        self.folder = options.work / "mein Ordner é"
        self.folder.mkdir()

    def test_list(self, options):
        """Would catch an example without a line, or a line without an example."""
        code, said, _ = run(options, options.scree, "--list", "examples", folder="/")
        assert code == 0
        names = [line.split()[0] for line in said.splitlines()]
        there = sorted(path.parent.name for path in (case.ROOT / "input").glob("*/scene.nml"))
        assert names == there
        assert len(names) > 3
        assert all(len(line.split()) > 1 for line in said.splitlines()), said

    def test_all_can_be_checked(self, options, sheet):
        """Would catch a copy without its deck, with a broken link, or with names of the source tree."""
        _, said, _ = run(options, options.scree, "--list", "examples")
        for name in [line.split()[0] for line in said.splitlines()]:
            with sheet.part(name):
                code, told, wrong = run(options, options.scree, "--new", name, f"mine/{name}", folder=self.folder)
                assert code == 0, wrong
                assert f"{name}.nml" in told
                copy = self.folder / "mine" / name
                of_grains = "\n&grains" in (copy / f"{name}.nml").read_text(encoding="utf-8")
                words = ["--grains", "--check"] if of_grains else ["--check", "--no-estimate"]
                code, _, wrong = run(options, options.scree, *words, f"{name}.nml", folder=copy)
                assert code == 0, wrong
                readme = (copy / "README.md").read_text(encoding="utf-8")
                assert "scene.nml" not in readme
                assert "build/bin" not in readme
                for target in LINK.findall(readme):
                    assert (copy / target).exists(), target
                assert (copy / "view.py").exists() == (not of_grains)
                assert ("scree-post grains out/grain_cell" in told) == of_grains, told
                if not of_grains:                        # cells of grains have no job scripts
                    assert subprocess.run(["bash", "-n", copy / "job.slurm"]).returncode == 0

    def test_run_and_plot(self, options):
        """Would catch a plot script that does not match the output files of the program."""
        assert run(options, options.scree, "--new", "two_discs", "mine", folder=self.folder)[0] == 0
        code, _, wrong = run(options, options.scree, "--quiet", "--set", "time.max_steps=20", "two_discs.nml",
                             folder=self.folder / "mine")
        assert code == 0, wrong
        code, said, wrong = run(options, sys.executable, "plot.py", folder=self.folder / "mine")
        assert code == 0, wrong
        picture = self.folder / "mine/out/two_discs/two_discs.png"
        assert picture.stat().st_size > 20000, said

    def test_refusals(self, options, sheet):
        """Would catch a folder that is overwritten, and refusals with another exit code or without a hint."""
        (self.folder / "full").mkdir()
        (self.folder / "full/own.txt").write_text("kept", encoding="utf-8")
        (self.folder / "file").write_text("kept", encoding="utf-8")
        (self.folder / "empty").mkdir()
        for words, code, message in [
                (["two_disc", "new"], 2, "there is no example 'two_disc', but .*; did you mean two_discs?"),
                (["two_discs"], 2, "--new needs a folder after the example"),
                (["two_discs", "full"], 3, "'full' exists and is not overwritten"),
                (["two_discs", "file"], 3, "'file' exists and is not overwritten"),
                (["two_discs", "file/new"], 3, "cannot make the folder 'file"),
                (["two_discs", "/proc/new"], 3, "cannot make the folder '/proc/new'")]:
            with sheet.part(words):
                answer = run(options, options.scree, "--new", *words, folder=self.folder)
                assert answer[0] == code, answer
                assert re.search(message, answer[2])
        assert sorted(path.name for path in self.folder.rglob("*")) == ["empty", "file", "full", "own.txt"]
        assert run(options, options.scree, "--new", "two_discs", "empty", folder=self.folder)[0] == 0

    def test_installed(self, options):
        """Would catch an installation that depends on the build tree."""
        build = options.scree.parents[1]
        if not (build / "cmake_install.cmake").is_file():
            pytest.skip("there is no build tree around the program")
        place = self.folder / "opt"
        done = subprocess.run(["cmake", "--install", build, "--prefix", place], text=True, capture_output=True)
        assert done.returncode == 0, done.stderr
        program = place / "bin/scree"
        shared = place / "share/scree/input"
        shutil.copytree(shared / "two_discs", shared / "of_this_place")
        (shared / "of_this_place/README.md").write_text("# Only here\n", encoding="utf-8")
        moved = self.folder / "elsewhere"
        place.rename(moved)
        program = moved / "bin/scree"
        code, said, wrong = run(options, program, "--list", "examples", folder="/")
        assert code == 0, wrong
        assert re.search("of_this_place +Only here", said)
        code, said, wrong = run(options, program, "--new", "of_this_place", self.folder / "mine", folder="/")
        assert code == 0, wrong
        assert (self.folder / "mine/of_this_place.nml").is_file()
        shutil.rmtree(moved / "share")
        code, said, wrong = run(options, program, "--list", "examples", folder="/")
        assert code == 3
        assert "the examples are not in the folder of this installation" in wrong
