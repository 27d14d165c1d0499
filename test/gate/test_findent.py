# SPDX-License-Identifier: BSD-3-Clause
# tiers: smoke
"""The indentation of src/ is what findent makes of it; skipped where it is not installed."""

import shutil
import subprocess
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "support"))
import report  # noqa: E402

ROOT = Path(__file__).resolve().parents[2]

program = shutil.which("findent", path=str(Path(sys.executable).parent)) or shutil.which("findent")
if not program:
    report.skip_all("findent is not installed")
offences = 0
for path in sorted((ROOT / "src").rglob("*.f90")):
    text = path.read_text(encoding="utf-8")
    answer = subprocess.run([program, "-i3", "-Rr", "-c3", "-k-", "-ifree"], input=text,
                            capture_output=True, text=True, check=True)
    for number, (old, new) in enumerate(zip(text.splitlines(), answer.stdout.splitlines()), 1):
        continued = number > 1 and text.splitlines()[number - 2].rstrip().endswith("&")
        if old != new and not continued:
            print(f"{path.relative_to(ROOT)}:{number}: {old.strip()}")
            offences += 1
sys.exit(1 if offences else 0)
