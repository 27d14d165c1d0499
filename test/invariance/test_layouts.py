# SPDX-License-Identifier: BSD-3-Clause
"""More ranks than cores, odd numbers of them, with and without balance: the same bits.

Would catch: a cut of the curve that depends on how tiles were measured and reaches the state, a
rank that gets no tile, a patch that is sent before it is complete or not sent at all after tiles
have moved, ghosts of the step before.
"""
# timeout: 300

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "support"))
import case     # noqa: E402
import layouts  # noqa: E402
import report   # noqa: E402


def main():
    """Few layouts; all of them are in test_all_layouts."""
    options = case.arguments()
    sheet = report.Report()
    layouts.run_all(options, sheet, ranks=(4, 7), threads=(1,), restarts=(1,))
    sheet.end()


if __name__ == "__main__":
    main()
