# SPDX-License-Identifier: BSD-3-Clause
"""A run that is killed at random moments, files half written included, ends as if nothing had been.

Would catch: a checkpoint that takes its name before it is whole, an older one that goes before the
new one is safe, rows of a history that are doubled or lost, snapshots of a time that was undone.
"""
# timeout: 300

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "support"))
import case     # noqa: E402
import killing  # noqa: E402
import report   # noqa: E402


def main():
    """On one rank and on two."""
    options = case.arguments()
    sheet = report.Report()
    killing.end_by_kills(options, sheet, 8, seed=1)
    killing.end_by_kills(options, sheet, 3, seed=2, ranks=2)
    sheet.end()


if __name__ == "__main__":
    main()
