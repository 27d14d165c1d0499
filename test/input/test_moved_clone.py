# SPDX-License-Identifier: BSD-3-Clause
"""A clone that is copied into another folder keeps a working Python environment.

Would catch: commands of build/venv that call the Python or the sources of the old folder, that do not start in a folder
with a blank and an umlaut in its name, and an environment that is made again each time.
"""

import importlib.util
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

import case

RENEW = 'set -euo pipefail; source "$1/scripts/common.sh"; renew_python'


def run(*words):
    """Exit code and all output."""
    answer = subprocess.run([str(word) for word in words], text=True, stdout=subprocess.PIPE, check=False,
                            stderr=subprocess.STDOUT)
    return answer.returncode, answer.stdout


def renew(root):
    """Adapt the environment of a clone to its present folder."""
    return run("bash", "-c", RENEW, "bash", root)


def test_moved_clone(options, sheet):
    """A small environment in one folder, copied into another one."""
    first, second = options.work / "first", options.work / "zweiter Klon ü"
    for folder in (first, second):
        shutil.rmtree(folder, ignore_errors=True)
    for name in ("scripts", "python"):
        shutil.copytree(case.ROOT / name, first / name, ignore=shutil.ignore_patterns("__pycache__"))
    code, said = run(sys.executable, "-m", "venv", first / "build" / "venv")
    backend = importlib.util.find_spec("hatchling")
    if code or backend is None or importlib.util.find_spec("editables") is None:
        pytest.skip(f"no environment can be made here, or hatchling or editables is missing: {said[-200:]}")
    (packages,) = (first / "build/venv/lib").glob("python3*/site-packages")
    # The build tools of the package come from the environment of the tests; links in a folder that is added in this way
    # are not followed.
    (packages / "builder.pth").write_text(f"{Path(backend.origin).parents[1]}\n", encoding="utf-8")
    code, said = renew(first)
    sheet.require(code == 0, f"the first environment: {said}")
    command = Path("build/venv/bin/scree-post")
    sheet.require(run(first / command, "--version")[0] == 0, "its command starts")
    shutil.copytree(first, second, symlinks=True)
    code, said = renew(second)
    sheet.require(code == 0 and "Bringing" in said, f"the copy is brought along: {said}")
    code, said = run(second / command, "--version")
    sheet.require(code == 0 and "scree-post" in said, f"the command of the copy starts: {said}")
    asks = "import scree_post; print(scree_post.__file__)"
    code, said = run(second / "build/venv/bin/python", "-c", asks)
    sheet.require(code == 0 and said.strip() == str(second / "python/src/scree_post/__init__.py"), f"it imports {said}")
    held = [path.name for path in (second / "build/venv/bin").iterdir()
            if path.is_file() and not path.is_symlink() and f"{first}/".encode() in path.read_bytes()]
    sheet.require(not held, f"commands with the path of the old place: {held}")
    sheet.require(renew(second) == (0, ""), "a second call has nothing to do")
    shutil.rmtree(first)
    sheet.require(run(second / command, "--version")[0] == 0, "it needs nothing of the old place")
    shutil.rmtree(second)
