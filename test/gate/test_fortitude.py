# SPDX-License-Identifier: BSD-3-Clause
# tiers: smoke
"""The linter fortitude finds nothing in src/; skipped where it is not installed."""

import shutil
import subprocess
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "support"))
import report  # noqa: E402

ROOT = Path(__file__).resolve().parents[2]

program = shutil.which("fortitude", path=str(Path(sys.executable).parent)) or shutil.which("fortitude")
if not program:
    report.skip_all("fortitude is not installed")
# The settings are in .fortitude.toml, which it finds by itself in this folder.
sys.exit(subprocess.run([program, "check", "src"], cwd=ROOT).returncode)
