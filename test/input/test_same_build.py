# SPDX-License-Identifier: BSD-3-Clause
# tiers: long
# timeout long: 3600
# cores: 2
"""Two builds of the same sources in different folders give the same bytes.

Would catch a path, a time, a random name or an order of files in the program or in the library.
"""

import hashlib
import os
import shutil
import subprocess

import pytest

import case

LEFT_OUT = shutil.ignore_patterns("build", "out", ".git", "__pycache__", ".*_cache")


def test_same_bytes(options):
    if not shutil.which("ninja"):
        pytest.skip("there is no ninja")
    sums = []
    for place in ("one", "a second place ü/deeper"):
        folder = options.work / place / "scree"
        shutil.rmtree(options.work / place.split("/", maxsplit=1)[0], ignore_errors=True)
        shutil.copytree(case.ROOT, folder, ignore=LEFT_OUT, symlinks=True)
        words = ("cmake", "-S", folder, "-B", folder / "build", "-G", "Ninja", "-DBUILD_TESTING=OFF",
                 "-DCMAKE_BUILD_TYPE=Release", "-DSCREE_ARCH=")
        build = ("cmake", "--build", folder / "build", "--target", "scree", "-j", os.environ.get("JOBS", "2"))
        for command in (words, build):
            answer = subprocess.run(command, text=True, capture_output=True, check=False)
            assert answer.returncode == 0, answer.stdout[-3000:] + answer.stderr
        sums.append({name: hashlib.sha256((folder / "build" / name).read_bytes()).hexdigest()
                     for name in ("bin/scree", "lib/libscree.so")})
        shutil.rmtree(folder)
    assert sums[0] == sums[1]
