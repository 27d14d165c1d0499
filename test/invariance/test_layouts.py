# SPDX-License-Identifier: BSD-3-Clause
"""More ranks than cores, odd numbers of them, with and without balance: the same bits.

Would catch: a cut of the curve that depends on how tiles were measured and reaches the state, a
rank that gets no tile, a patch that is sent before it is complete or not sent at all after tiles
have moved, ghosts of the step before.
smoke: one deck on few ranks and threads; full: four decks on 4 and 7 ranks; long: all of them on all
layouts of ranks {1, 2, 3, 4, 7} and threads {1, 2, 3}, with restarts at the first, a middle and the last step but one.
"""
# tiers: smoke, full, long
# timeout: 900
# timeout long: 7200
# cores: 2

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "support"))
import case     # noqa: E402
import layouts  # noqa: E402
import report   # noqa: E402
import tier     # noqa: E402


def main():
    """The layouts of this tier."""
    options = case.arguments()
    sheet = report.Report()
    if tier.NAME == "smoke":
        layouts.run_few(options, sheet)
    elif tier.NAME == "full":
        layouts.run_all(options, sheet, ranks=(4, 7), threads=(1,), restarts=(1,))
    else:
        layouts.run_all(options, sheet, ranks=(1, 2, 3, 4, 7), threads=(1, 2, 3), restarts=(0, 1, 2))
    sheet.end()


if __name__ == "__main__":
    main()
