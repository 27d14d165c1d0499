# SPDX-License-Identifier: BSD-3-Clause
# tiers: smoke
"""Rules for the tests in Python: one harness, and one definition of the module paths.

Would catch a file that pytest runs and that contains no test, a test with another harness, whose checks are not
evaluated, a test that changes the module search path, on which another test then depends, and imports or variables that
are not used.
"""

import importlib.util
import re
import subprocess
import sys

import pytest

from sources import ROOT, place, project_files

TEST = ROOT / "test"
FILES = project_files(".py", under="test")
# Files that may change the path: scripts that are not tests, the definitions of the fixtures, and this gate
OWN = {TEST / "verify" / "_support.py", TEST / "conftest.py", TEST / "gate" / "test_tests.py"}
FORBIDDEN = (
    (re.compile(r"\bsys\.path(\.|\[.*\] *=| *\+?=)"), "bends sys.path: test/pytest.ini says where modules are"),
    (re.compile(r"^\s*(import|from) unittest\b(?! import mock)"), "uses unittest: write functions for pytest"),
    (re.compile(r"noqa: E402"), "imports late"),
    (re.compile(r"\bsheet\.end\(\)"), "ends its report: the fixture `sheet` does"),
)


def offences():
    """Lines of tests that violate a rule."""
    return [f"{place(path, number)} {why}" for path in FILES if path not in OWN
            for number, line in enumerate(path.read_text(encoding="utf-8").splitlines(), 1)
            for pattern, why in FORBIDDEN if pattern.search(line)]


def test_one_harness():
    assert len(FILES) > 150
    found = offences()
    assert not found, "\n" + "\n".join(found)


def test_each_file_has_tests():
    """Each file has tests, and none is run as a script."""
    found = []
    for path in FILES:
        text = path.read_text(encoding="utf-8")
        if path.name.startswith("test_"):
            if not re.search(r"^(    )?def test_\w+\(", text, re.M):
                found.append(f"{place(path, 1)} has no test")
            if "__main__" in text and path not in OWN:
                found.append(f"{place(path, 1)} runs by itself: pytest runs it")
    assert not found, "\n" + "\n".join(found)


def test_names_of_files_differ():
    """Test modules are imported by their names alone, so the names must differ."""
    names = [path.name for path in FILES if path.name != "conftest.py"]
    assert sorted({name for name in names if names.count(name) > 1}) == []


@pytest.mark.skipif(not importlib.util.find_spec("ruff"), reason="ruff is not installed; scripts/setup.sh installs it")
def test_ruff():
    answer = subprocess.run([sys.executable, "-m", "ruff", "check", "--no-cache", "--quiet", "."], cwd=TEST, text=True,
                            capture_output=True, check=False)
    assert answer.returncode == 0, "\n" + answer.stdout + answer.stderr
