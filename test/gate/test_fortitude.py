# SPDX-License-Identifier: BSD-3-Clause
"""The linter fortitude finds nothing in src/; skipped where it is not installed."""

import shutil
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
NOT_INSTALLED = 77

program = shutil.which("fortitude", path=str(Path(sys.executable).parent)) or shutil.which("fortitude")
if not program:
    print("fortitude is not installed")
    sys.exit(NOT_INSTALLED)
# The settings are in .fortitude.toml, which it finds by itself in this folder.
sys.exit(subprocess.run([program, "check", "src"], cwd=ROOT).returncode)
