# SPDX-License-Identifier: BSD-3-Clause
"""All layouts of ranks {1, 2, 3, 4, 7} and threads {1, 2, 3}, balance on and off, restarts at the
first, a middle and the last but one step, of a debris cloud, a granular column and a bar.

Would catch what test_layouts would, for layouts that it leaves out.
"""
# label: long
# timeout: 7200

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "support"))
import case     # noqa: E402
import layouts  # noqa: E402
import report   # noqa: E402


def main():
    """The whole product."""
    options = case.arguments()
    sheet = report.Report()
    layouts.run_all(options, sheet, ranks=(1, 2, 3, 4, 7), threads=(1, 2, 3), restarts=(0, 1, 2))
    sheet.end()


if __name__ == "__main__":
    main()
