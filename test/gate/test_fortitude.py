# SPDX-License-Identifier: BSD-3-Clause
# tiers: smoke
"""The linter fortitude finds nothing in src/; skipped where it is not installed."""

import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from sources import ROOT

PROGRAM = shutil.which("fortitude", path=str(Path(sys.executable).parent)) or shutil.which("fortitude")


@pytest.mark.skipif(not PROGRAM, reason="fortitude is not installed")
def test_fortitude():
    # fortitude finds its settings in .fortitude.toml of this folder without an option
    answer = subprocess.run([PROGRAM, "check", "src"], cwd=ROOT, capture_output=True, text=True, check=False)
    assert answer.returncode == 0, answer.stdout + answer.stderr
