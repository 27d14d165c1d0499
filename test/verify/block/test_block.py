# SPDX-License-Identifier: BSD-3-Clause
"""A block on a slope with Coulomb's friction: it slides with g (sin - mu cos), or it stays.

Would catch: friction on nodes that a wall pulls at, which brakes a block that rocks twice; friction that stops more
than there is; a pressure of the wall that counts the velocities of FLIP that particles never get; work of friction
that is not booked; a wall that holds what bounces.

24 degrees and mu = tan 15 degrees, as in larger codes: the way within 1e-3 in 5 s, the speed within 1e-3. In 1 s
with finer cells and with the plain method 1 %. At 14 degrees the block may slip while it bounces from its start
without stress, for 0.1 s, and then stays.
"""

import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "support"))
import case    # noqa: E402
import flows   # noqa: E402
import report  # noqa: E402


def main():
    """Blocks that slide, and one that does not."""
    options = case.arguments()
    sheet = report.Report()
    for name, limit, words in (("5 s", 1.0e-3, {"end": 5.0}), ("finer cells", 0.01, {"spacing": 0.125}),
                               ("mpm", 0.01, {"method": "mpm"}), ("apic", 0.01, {"words": "transfer='apic'"})):
        result = flows.block(options, name.replace(" ", "_"), **words)
        gain, end = result["expected"], result["when"][-1]
        sheet.near(f"{name}: way [m]", result["places"][-1], 0.5 * gain * end ** 2, limit)
        sheet.near(f"{name}: speed [m/s]", result["speeds"][-1], gain * end, limit)
        sheet.below(f"{name}: momentum", result["momentum"], 1.0e-13)
        if not words.get("method"):
            sheet.below(f"{name}: energy", result["energies"][-1], 0.02)
    result = flows.block(options, "rest", angle=14.0)
    later = result["places"][result["when"] > 0.2]
    sheet.below("14 degrees: way while it bounces [m]", later[0], 2.0e-3)
    sheet.below("14 degrees: way after that [m]", np.abs(later - later[0]).max(), 1.0e-4)
    sheet.require(len(later) > 10, "14 degrees: there are times after that")
    sheet.end()


if __name__ == "__main__":
    main()
