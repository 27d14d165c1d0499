# SPDX-License-Identifier: BSD-3-Clause
# tiers: smoke
"""The indentation of src/ is that of findent; skipped where it is not installed."""

import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from sources import place, project_files

PROGRAM = shutil.which("findent", path=str(Path(sys.executable).parent)) or shutil.which("findent")


@pytest.mark.skipif(not PROGRAM, reason="findent is not installed")
def test_findent():
    offences = []
    files = project_files(".f90", under="src")
    assert len(files) > 100
    for path in files:
        text = path.read_text(encoding="utf-8")
        answer = subprocess.run([PROGRAM, "-i3", "-Rr", "-c3", "-k-", "-ifree"], input=text,
                                capture_output=True, text=True, check=True)
        for number, (old, new) in enumerate(zip(text.splitlines(), answer.stdout.splitlines()), 1):
            continued = number > 1 and text.splitlines()[number - 2].rstrip().endswith("&")
            if old != new and not continued:
                offences.append(f"{place(path, number)}: {old.strip()}")
    assert not offences, "\n" + "\n".join(offences)
