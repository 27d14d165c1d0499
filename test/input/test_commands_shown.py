# SPDX-License-Identifier: BSD-3-Clause
# timeout: 600
"""Every command that README, guide and scenes show is typed, in a folder that looks like a clone.

Would catch a command of a document that nobody tried, a deck or a script that was renamed, an option that is gone.
Runs of the program are cut after a few steps or take few grains, checks make no estimate of the time, scree-bench
measures its smallest case, and studies that take minutes are asked for their options; commands
of scree-post are run by test_post_documents, two pages as a whole by tests of their own, those of single messages by
test_message_pages.
"""

import os
import re
import shlex
import shutil
import subprocess
import sys
from pathlib import Path

import case
from post_command import RUNS

#: Pages that a test types from top to bottom.
TYPED = {"doc/learn/first_hour.md": "test_first_hour.py", "doc/guide/geometry.md": "test_geometry_page.py"}
#: Beginnings of commands that another test runs, or that are no commands to type.
ELSEWHERE = {"build/venv/bin/scree-post": "test_post_documents.py", "scree-post": "test_post_documents.py",
             "paraview": "test_paraview.py", "pvbatch": "test_paraview.py",
             "build/bin/scree [options]": "a pattern", "build/bin/scree scene.nml & sleep": "test_first_hour.py",
             "build/bin/scree --check bad.nml": "test_documents.py", "ctest": "the tests themselves"}
FEW = ("--set", "time.max_steps=3")
SPHERES = ("grains.number=64", *(f"stage[{name}].strain=0.05" for name in ("fast", "middle_1", "middle_2", "slow_1",
                                                                           "slow_2")))
SMALLEST = ("--only", "line", "--repeat", "1", "--size", "small")
NO_RUN = ("--check", "--preview", "--template", "--list", "--new", "--job", "--digest", "--explain")
LEAST = 60                             # commands that the documents are known to show


def shown():
    """Pages and commands of all console blocks; without what is printed, comments behind them, and scripts."""
    pages = [case.ROOT / "README.md",                    # those of messages are made by running what they show
             *sorted(path for path in (case.ROOT / "doc").rglob("*.md") if path.parent.name != "messages"),
             *sorted((case.ROOT / "input").glob("*/README.md"))]
    for page in pages:
        text = page.read_text(encoding="utf-8")
        for block in re.findall(r"^```console\n(.*?)^```", text, re.M | re.S):
            lines = [line for line in block.replace("\\\n", " ").splitlines() if line.strip()]
            if any(line.startswith("$ ") for line in lines):
                lines = [line[2:] for line in lines if line.startswith("$ ")]
            for line in lines:
                yield str(page.relative_to(case.ROOT)), re.sub(r"\s+#.*$", "", line).strip()


class Clone:
    """A folder with the sources and the program where a user has them."""

    def __init__(self, options):
        self.folder = options.work / "clone"
        shutil.rmtree(self.folder, ignore_errors=True)
        (self.folder / "build").mkdir(parents=True)
        for name in ("input", "scripts", "python", "doc", "test", "CMakeLists.txt"):
            (self.folder / name).symlink_to(case.ROOT / name)
        (self.folder / "build/bin").symlink_to(options.scree.parent)
        (self.folder / "scene.nml").symlink_to(case.ROOT / "input/two_discs/scene.nml")
        self.environment = {**os.environ, **case.OPEN_MPI, "OMP_NUM_THREADS": "1",
                            "PYTHONDONTWRITEBYTECODE": "1",
                            "PYTHONPATH": f"{case.ROOT / 'scripts'}{os.pathsep}{case.ROOT / 'python/src'}"}

    def run(self, words):
        """Exit code, and what was said."""
        answer = subprocess.run(words, cwd=self.folder, env=self.environment, text=True, timeout=300, check=False,
                                stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.STDOUT)
        return answer.returncode, answer.stdout

    def program(self, words):
        """The program, for a few steps; what it writes to a file is told."""
        if ">" in words:
            words = words[:words.index(">")]
        if words[0] == "mpirun":
            words[2] = "2"
            if "build/bin/scree" in words:      # without a binding to more cores than there may be
                words[3:] = words[words.index("build/bin/scree"):]
        if not any(word in NO_RUN for word in words):
            few = SPHERES if words[-1].endswith("spheres.nml") else RUNS["grain_cell"][1]
            words += FEW if "--grains" not in words else [word for setting in few for word in ("--set", setting)]
            # the commands of all pages run in one folder
            if "--restart" not in words:
                words.append("--overwrite")
        if "--check" in words and "--grains" not in words:
            words.append("--no-estimate")
        # a page shows where its own run would have left a checkpoint
        words = [self.newest() if word.endswith(".h5") else word for word in words]
        code, said = self.run(words)
        return code == (2 if "grid.dxx=1" in words else 0), said

    def newest(self):
        """A checkpoint of the deck scene.nml."""
        return str(max((self.folder / "out").glob("*/*_chk_*.h5"), key=lambda path: path.stat().st_mtime))

    def bench(self, words):
        """scree-bench with its smallest case, and this program in place of another one; any may be faster."""
        words = ["page.md" if before == "--markdown" else "build/bin/scree" if before == "--turns" else word
                 for before, word in zip(["", *words], words)]
        if "--compare" in words:
            for name in words[2:4]:
                if not (self.folder / name).exists():
                    shutil.copy(next(self.folder.glob("*.json")), self.folder / name)
        elif "--list" not in words:
            words += SMALLEST
        code, said = self.run(words)
        may_differ = "--turns" in words or "--compare" in words
        return code == 0 or code == 1 and may_differ and "times slower" in said, said

    def script(self, words):
        """A study or a script of the shell: its options."""
        shell = words[0].endswith(".sh")
        command = ["bash", words[0]] if shell else [sys.executable, words[1]]
        options = [word for word in words[1:] if word.startswith("--")]
        code, said = self.run([*command, "--help"])
        source = (self.folder / command[1]).read_text(encoding="utf-8")     # not all say all of them
        missing = [word for word in options if word not in said and f'"{word}"' not in source]
        return code == 0 and not missing, f"{said}\nwithout {missing}"

    def tests(self, words):
        """A file of tests: it is there, and has these options."""
        options = [word for word in words[1:] if word.startswith("--")]
        code, said = self.run([sys.executable, "-m", "pytest", words[1], "--help"])
        missing = [word for word in options if word not in said]
        good = code == 0 and not missing and (self.folder / words[1]).exists()
        return good, f"{said[-400:]}\nwithout {missing}, or there is no {words[1]}"

    def type(self, line):
        """True if the command does what it is there for, and what was said."""
        words = shlex.split(line)
        while words and re.fullmatch(r"[A-Z_]+=\S*", words[0]):
            words = words[1:]
        if words[0] in ("export", "echo"):
            return True, ""
        if words[0] in ("build/bin/scree", "mpirun"):
            return self.program(words)
        if words[0] == "build/bin/scree-bench":
            return self.bench(words)
        if words[0].endswith("python") or words[0].startswith("python") or words[0].endswith(".sh"):
            return self.script(words)
        if words[0].endswith("pytest"):
            return self.tests(words)
        if words[0] == "pip" or words[:2] == ["cd", "python"]:
            # test_python installs and tests the package
            return (case.ROOT / "python/pyproject.toml").is_file(), "there is no package"
        return False, "nobody knows how to try this command"


def test_commands_shown(options, sheet):
    """All pages; a command that stands twice is typed once."""
    for page, test in TYPED.items():
        sheet.require(Path(page).name in (case.ROOT / "test/input" / test).read_text(encoding="utf-8"),
                      f"{test} types {page}")
    clone = Clone(options)
    commands = [(page, line) for page, line in shown() if page not in TYPED]
    sheet.require(len(commands) >= LEAST, f"only {len(commands)} commands were found")
    done = set()
    for page, line in commands:
        if line in done or line.startswith(tuple(ELSEWHERE)):
            continue
        done.add(line)
        good, said = clone.type(line)
        sheet.require(good, f"{page}: {line}: {said[-400:]}")
