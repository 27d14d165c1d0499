# SPDX-License-Identifier: BSD-3-Clause
# tiers: long
# timeout: 900
"""FORD writes the reference of the sources without a warning; skipped where it is not installed.

Would catch a comment whose first word is taken for a setting, so that its text is lost, a comment at a position that
FORD ignores, and a page of the reference that is not written.
"""

import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from sources import ROOT, project_files

# FORD does not know a name that a module makes public from another module.
NOT_OURS = re.compile(r"Unknown entity '\w+' with attribute 'public'")

PROGRAM = shutil.which("ford", path=str(Path(sys.executable).parent)) or shutil.which("ford")


@pytest.mark.skipif(not PROGRAM, reason="FORD is not installed; pip install ford")
def test_reference(options):
    work = options.work
    answer = subprocess.run([PROGRAM, "--output_dir", work, ROOT / "doc" / "ford.md"],
                            capture_output=True, text=True, env={**os.environ, "COLUMNS": "400"})
    said = (answer.stdout + answer.stderr).replace("\r", "\n")
    warnings = [line for line in said.splitlines()
                if re.search(r"warning|error", line, re.I) and not NOT_OURS.search(line)]
    print("\n".join(warnings))
    pages = {path.stem for path in (work / "module").glob("*.html")}
    modules = {path.stem for path in project_files(".f90", under="src")} - {"main"}
    print(f"{len(warnings)} warnings, {len(pages)} pages of {len(modules)} modules")
    assert answer.returncode == 0
    assert warnings == []
    assert len(modules) >= 50
    assert modules - pages == set()
