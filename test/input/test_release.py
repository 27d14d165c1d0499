# SPDX-License-Identifier: BSD-3-Clause
# tiers: full
"""The files of a release: one version, the same bytes in two builds.

Would catch: a version that was increased in one file only, an archive with time stamps of files, a recipe without the
checksum of the archive, and a checksum that is missing.
"""

import hashlib
import os
import re
import shutil
import subprocess
import sys
import tarfile
import zipfile

import pytest

import case

VERSION = re.search(r"^project\(scree VERSION ([\d.]+)", (case.ROOT / "CMakeLists.txt").read_text(encoding="utf-8"),
                    re.M).group(1)


def run(*words, folder=case.ROOT, **environment):
    """What a command prints; it must succeed."""
    answer = subprocess.run([str(word) for word in words], cwd=folder, text=True, capture_output=True, check=False,
                            env={**os.environ, **environment})
    assert answer.returncode == 0, answer.stdout + answer.stderr
    return answer.stdout


def checksum(path):
    """SHA-256 of a file."""
    return hashlib.sha256(path.read_bytes()).hexdigest()


def test_one_version():
    """The version in CMakeLists.txt and those in files of other tools are the same."""
    found = {name: re.search(pattern, (case.ROOT / name).read_text(encoding="utf-8"), re.M).group(1)
             for name, pattern in (
                 ("CITATION.cff", r"^version: (\S+)$"), ("README.md", r"^Version ([\d.]*\d)"),
                 ("python/src/scree/__init__.py", r'^__version__ = "(.*)"'),
                 ("scripts/scree_bench/__init__.py", r'^__version__ = "(.*)"'),
                 ("doc/man/scree.1", r'^\.TH SCREE 1 "" "scree (\S+)"'))}
    assert set(found.values()) == {VERSION}, found


@pytest.fixture(scope="module")
def clone(file_options):
    """A clone of the last commit, with the build and the Python of this folder."""
    if not (case.ROOT / ".git").exists() or not shutil.which("git"):
        pytest.skip("there is no git repository around the sources")
    folder = file_options.work / "clone"
    shutil.rmtree(folder, ignore_errors=True)
    run("git", "clone", "--quiet", case.ROOT, folder)
    (folder / "build/venv").mkdir(parents=True)
    (folder / "build/venv/bin").mkdir()
    (folder / "build/venv/bin/python").write_text(f'#!/bin/sh\nexec "{sys.executable}" "$@"\n', encoding="utf-8")
    (folder / "build/venv/bin/python").chmod(0o755)
    return folder


class TestRelease:
    """Two releases of one commit, without manual and Debian package, which take long."""

    @pytest.fixture(scope="class")
    def release(self, clone, file_options):
        """The folders of two releases."""
        folders = [file_options.work / "first", file_options.work / "second/deeper"]
        for folder in folders:
            shutil.rmtree(folder, ignore_errors=True)
            run(clone / "scripts/release.sh", "--no-site", "--no-deb", folder, folder=clone)
        return folders

    def test_same_bytes(self, release):
        """Would catch the time, the user or the folder of the release in a file."""
        first, second = ({str(path.relative_to(folder)): checksum(path) for path in folder.rglob("*") if path.is_file()}
                         for folder in release)
        assert first == second
        assert len(first) == 8, sorted(first)

    def test_checksums(self, release):
        """All files are in SHA256SUMS, and in the recipes the checksum of the archive."""
        lines = (release[0] / "SHA256SUMS").read_text(encoding="utf-8").splitlines()
        listed = {line.split("  ")[1]: line.split("  ")[0] for line in lines}
        there = {str(path.relative_to(release[0])): checksum(path) for path in release[0].rglob("*")
                 if path.is_file() and path.name != "SHA256SUMS"}
        assert listed == there
        for recipe in ("recipes/spack/package.py", "recipes/conda/recipe.yaml"):
            text = (release[0] / recipe).read_text(encoding="utf-8")
            assert there[f"scree-{VERSION}.tar.gz"] in text
            assert f'"{VERSION}"' in text
            assert not re.search(r"@[A-Z]", text)

    def test_content(self, release, clone):
        """The archive has the files of git and the commit; the wheel has both packages."""
        with tarfile.open(release[0] / f"scree-{VERSION}.tar.gz") as archive:
            names = {name.partition("/")[2] for name in archive.getnames()}
            commit = archive.extractfile(f"scree-{VERSION}/cmake/commit.txt").read().decode()
        assert set(run("git", "ls-files", folder=clone).split("\n")) - {""} <= names
        assert f"commit: {run('git', 'rev-parse', 'HEAD', folder=clone).strip()}\n" in commit
        with zipfile.ZipFile(release[0] / f"scree_mpm-{VERSION}-py3-none-any.whl") as wheel:
            assert {"scree/__init__.py", "scree_post/command.py"} <= set(wheel.namelist())

    def test_not_committed(self, clone, options):
        """Would catch a release of sources that are not committed."""
        (clone / "new.txt").touch()
        answer = subprocess.run([clone / "scripts/release.sh", options.work / "no"], text=True, capture_output=True,
                                check=False)
        (clone / "new.txt").unlink()
        assert answer.returncode == 3
        assert "not committed" in answer.stderr
