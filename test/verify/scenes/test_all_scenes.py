# SPDX-License-Identifier: BSD-3-Clause
"""The same for all scenes that measure themselves, which takes about half an hour.

Would catch what test_scenes would, in the scenes that take minutes.
"""
# label: long
# timeout: 7200

import sys
from pathlib import Path

sys.path[:0] = [str(Path(__file__).resolve().parents[2] / "support"), str(Path(__file__).resolve().parent)]
import case         # noqa: E402
import report       # noqa: E402
import test_scenes  # noqa: E402


def main():
    """All of them."""
    options = case.arguments()
    sheet = report.Report()
    for script in sorted((test_scenes.ROOT / "input").glob("*/measure.py")):
        test_scenes.check(options, sheet, script.parent.name)
    sheet.end()


if __name__ == "__main__":
    main()
