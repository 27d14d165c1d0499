# SPDX-License-Identifier: BSD-3-Clause
# tiers: smoke, full
# timeout: 600
"""The Python package in the folder python: its tests by pytest, its style by ruff, its types by mypy, and its
installation.

Would catch failures of the tests in python/tests, a function without types, a module that an installation lacks, a
dependency that is imported but not listed, and a wheel without licence or with another version than the program.
"""

import ast
import importlib.util
import os
import re
import shutil
import subprocess
import sys

import pytest

import case
import tier

FOLDER = case.ROOT / "python"


def call(sheet, options, what, *words):
    """Run a tool of Python in the folder of the package."""
    if not importlib.util.find_spec(words[0]):
        pytest.skip(f"{words[0]} is not installed; scripts/setup.sh installs it")
    answer = subprocess.run([sys.executable, "-m", *map(str, words)], cwd=FOLDER, text=True, check=False,
                            stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
                            env={**os.environ, **case.OPEN_MPI, "SCREE": str(options.scree),
                                 "PYTHONPATH": str(FOLDER / "src"), "PYTHONDONTWRITEBYTECODE": "1"})
    print(answer.stdout[-6000:], flush=True)
    sheet.require(answer.returncode == 0, f"{what}: exit code {answer.returncode}")


def names_and_ranges(text):
    """Requirements by name, such as {"numpy": ">=1.24,<3"}."""
    return dict(re.findall(r"^\s*\"?([\w-]+)(?:\[\w+\])?([<>=][^\"\n]*)\"?,?$", text, re.M))


def test_dependencies(sheet):
    """All imported packages are listed in python/pyproject.toml, and there is no second list."""
    project = (FOLDER / "pyproject.toml").read_text(encoding="utf-8")
    listed = names_and_ranges(re.search(r"^dependencies = \[(.*?)^\]", project, re.M | re.S).group(1))
    sheet.above("dependencies", len(listed), 4)
    others = sorted(path.name for path in (case.ROOT / "scripts").glob("*requirements*"))
    sheet.require(not others, f"a second list of packages: {others}")
    optional = set(re.findall(r"\"([\w-]+)>", re.search(r"^\[project.optional-dependencies\](.*?)^\[", project,
                                                         re.M | re.S).group(1)))
    if sys.version_info < (3, 10):
        sheet.skipped("imports", "this Python does not list its own modules")
        return
    own = {"scree", "scree_post", "PIL", "numpy.typing"}  # Pillow is installed with matplotlib
    for path in sorted((FOLDER / "src").rglob("*.py")):
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            names = [alias.name for alias in node.names] if isinstance(node, ast.Import) else \
                [node.module] if isinstance(node, ast.ImportFrom) and not node.level else []
            for name in {name.partition(".")[0] for name in names} - own - set(sys.stdlib_module_names):
                known = name.replace("_", "-") in set(listed) | optional
                sheet.require(known, f"{path.relative_to(FOLDER)} imports {name}, which python/pyproject.toml lacks")


@pytest.mark.tiers("full", "long")
def test_installation(options, sheet):
    """The package can be installed, and then works without the repository."""
    if not importlib.util.find_spec("hatchling"):
        pytest.skip("hatchling is not installed; scripts/setup.sh installs it")
    place = options.work / "place"
    shutil.rmtree(place, ignore_errors=True)
    answer = subprocess.run([sys.executable, "-m", "pip", "install", "--quiet", "--no-deps", "--no-build-isolation",
                             "--disable-pip-version-check", "--target", place, FOLDER], text=True, check=False,
                            stdout=subprocess.PIPE, stderr=subprocess.STDOUT)
    sheet.require(answer.returncode == 0, f"pip: {answer.stdout}")
    code = ("import importlib, pathlib, pkgutil, scree, scree_post\n"
            "place = pathlib.Path(scree.__file__).parent\n"
            "names = sorted(entry.name for entry in pkgutil.iter_modules([str(place)]))\n"
            "[importlib.import_module('scree.' + name) for name in names]\n"
            "print(place, (place / 'py.typed').exists(), *names, sep=chr(10))")
    answer = subprocess.run([sys.executable, "-c", code], cwd=options.work, text=True, check=False,
                            stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
                            env={**os.environ, "PYTHONPATH": str(place), "PYTHONDONTWRITEBYTECODE": "1"})
    there = sorted([path.stem for path in (FOLDER / "src/scree").glob("[a-z]*.py")] + ["drawing"])
    sheet.require(answer.returncode == 0 and answer.stdout.splitlines() == [str(place / "scree"), "True", *there],
                  f"the installed package: {answer.stdout}")
    sheet.require((place / "bin/scree-post").exists(), "the command scree-post is installed")
    (metadata,) = place.glob("scree_mpm-*.dist-info")
    said = subprocess.run([str(options.scree), "--version"], text=True, check=True, stdout=subprocess.PIPE).stdout
    sheet.require(f"-{said.split()[1]}." in metadata.name, f"version of the package: {metadata.name}, of {said}")
    licence = (case.ROOT / "LICENSE").read_text(encoding="utf-8")
    sheet.require([path.read_text(encoding="utf-8") for path in metadata.rglob("LICENSE")] == [licence],
                  f"the licence in {metadata}")
    rests = [str(path) for name in ("build", "dist", "*.egg-info") for path in FOLDER.rglob(name)]
    sheet.require(not rests, f"the installation leaves files in the sources: {rests}")


def test_ruff(options, sheet):
    call(sheet, options, "ruff", "ruff", "check", "--no-cache", "--quiet", ".")


@pytest.mark.tiers("full", "long")
def test_mypy(options, sheet):
    call(sheet, options, "mypy", "mypy", "--cache-dir", options.work / "mypy")


def test_pytest(options, sheet):
    """The tier smoke leaves out the tests that start many runs."""
    call(sheet, options, "pytest", "pytest", "-q", "--basetemp", options.work / "pytest", *tier.choose(
        smoke=[f"tests/test_{name}.py" for name in ("results", "snapshots", "plot")], full=[]))
