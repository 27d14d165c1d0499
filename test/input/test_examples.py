# SPDX-License-Identifier: BSD-3-Clause
"""`--list examples` and `--new`: from the build tree, installed, and where they must refuse.

Would catch examples that are found only from the source tree or one working folder, a copy that does not run or
whose picture cannot be drawn, text that points to files that are not there, and a folder that is overwritten.
"""

import os
import re
import shutil
import subprocess
import sys
import unittest

import case
import report

OPTIONS = case.arguments(__doc__)
BUILD = OPTIONS.scree.parents[1]
LINK = re.compile(r"\]\(([^)\s:]+)\)")


def run(program, *words, folder=OPTIONS.work):
    """Exit code, output and errors of a call from a folder."""
    answer = subprocess.run([str(word) for word in (program, *words)], cwd=folder, text=True, timeout=100,
                            capture_output=True, env={**os.environ, **case.OPEN_MPI, "OMP_NUM_THREADS": "1"})
    return answer.returncode, answer.stdout, answer.stderr


class Examples(unittest.TestCase):
    """Each test has a folder of its own, with a blank and an accent in its name."""

    def setUp(self):
        self.folder = OPTIONS.work / f"{self.id().split('.')[-1]} é"
        shutil.rmtree(self.folder, ignore_errors=True)
        self.folder.mkdir(parents=True)

    def test_list(self):
        """Would catch an example without a line, or a line without an example."""
        code, said, _ = run(OPTIONS.scree, "--list", "examples", folder="/")
        self.assertEqual(code, 0)
        names = [line.split()[0] for line in said.splitlines()]
        there = sorted(path.parent.name for path in (case.ROOT / "input").glob("*/scene.nml"))
        self.assertEqual(names, there)
        self.assertGreater(len(names), 3)
        self.assertTrue(all(len(line.split()) > 1 for line in said.splitlines()), said)

    def test_all_can_be_checked(self):
        """Would catch a copy without its deck, with a broken link, or with names of the source tree."""
        _, said, _ = run(OPTIONS.scree, "--list", "examples")
        for name in [line.split()[0] for line in said.splitlines()]:
            with self.subTest(name):
                code, told, wrong = run(OPTIONS.scree, "--new", name, f"mine/{name}", folder=self.folder)
                self.assertEqual(code, 0, wrong)
                self.assertIn(f"{name}.nml", told)
                copy = self.folder / "mine" / name
                of_grains = "\n&grains" in (copy / f"{name}.nml").read_text(encoding="utf-8")
                words = ["--grains", "--check"] if of_grains else ["--check", "--no-estimate"]
                code, _, wrong = run(OPTIONS.scree, *words, f"{name}.nml", folder=copy)
                self.assertEqual(code, 0, wrong)
                readme = (copy / "README.md").read_text(encoding="utf-8")
                self.assertNotIn("scene.nml", readme)
                self.assertNotIn("build/bin", readme)
                for target in LINK.findall(readme):
                    self.assertTrue((copy / target).exists(), target)
                self.assertEqual((copy / "view.py").exists(), not of_grains)
                self.assertEqual("scree-post grains out/grain_cell" in told, of_grains, told)
                if not of_grains:                        # there are no job scripts for cells of grains
                    self.assertEqual(subprocess.run(["bash", "-n", copy / "job.slurm"]).returncode, 0)

    def test_run_and_plot(self):
        """Would catch a plot script that does not fit the files of the program."""
        self.assertEqual(run(OPTIONS.scree, "--new", "two_discs", "mine", folder=self.folder)[0], 0)
        code, _, wrong = run(OPTIONS.scree, "--quiet", "--set", "time.max_steps=20", "two_discs.nml",
                             folder=self.folder / "mine")
        self.assertEqual(code, 0, wrong)
        code, said, wrong = run(sys.executable, "plot.py", folder=self.folder / "mine")
        self.assertEqual(code, 0, wrong)
        picture = self.folder / "mine/out/two_discs/two_discs.png"
        self.assertGreater(picture.stat().st_size, 20000, said)

    def test_refusals(self):
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
            with self.subTest(words):
                answer = run(OPTIONS.scree, "--new", *words, folder=self.folder)
                self.assertEqual(answer[0], code, answer)
                self.assertRegex(answer[2], message)
        self.assertEqual(sorted(path.name for path in self.folder.rglob("*")),
                         ["empty", "file", "full", "own.txt"])
        self.assertEqual(run(OPTIONS.scree, "--new", "two_discs", "empty", folder=self.folder)[0], 0)

    def test_installed(self):
        """Would catch an installation that still looks into the tree it was built in."""
        if not (BUILD / "cmake_install.cmake").is_file():
            report.skip_part(self, "there is no build tree around the program")
        place = self.folder / "opt"
        done = subprocess.run(["cmake", "--install", BUILD, "--prefix", place], text=True, capture_output=True)
        self.assertEqual(done.returncode, 0, done.stderr)
        program = place / "bin/scree"
        shared = place / "share/scree/input"
        shutil.copytree(shared / "two_discs", shared / "of_this_place")
        (shared / "of_this_place/README.md").write_text("# Only here\n", encoding="utf-8")
        moved = self.folder / "elsewhere"
        place.rename(moved)
        program = moved / "bin/scree"
        code, said, wrong = run(program, "--list", "examples", folder="/")
        self.assertEqual(code, 0, wrong)
        self.assertRegex(said, "of_this_place +Only here")
        code, said, wrong = run(program, "--new", "of_this_place", self.folder / "mine", folder="/")
        self.assertEqual(code, 0, wrong)
        self.assertTrue((self.folder / "mine/of_this_place.nml").is_file())
        shutil.rmtree(moved / "share")
        code, said, wrong = run(program, "--list", "examples", folder="/")
        self.assertEqual(code, 3)
        self.assertIn("the examples are not in the folder of this installation", wrong)


if __name__ == "__main__":
    unittest.main()
