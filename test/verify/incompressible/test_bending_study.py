# SPDX-License-Identifier: BSD-3-Clause
"""The beam of test_bending.py up to nu = 0.4999, with and without the cure, in three resolutions.

Would catch: a cure that holds for one ratio of the moduli only, errors that do not fall with the cells.

Wave speeds grow as the root of the bulk modulus, so the last beams take 20 and 40 thousand steps.
"""
# label: long
# timeout: 3000

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "support"))
import beams   # noqa: E402
import bodies  # noqa: E402
import case    # noqa: E402
import report  # noqa: E402

RATIOS = (0.3, 0.49, 0.499, 0.4999)
SIZES = (0.5, 0.25, 0.125)


def main():
    """A table; the finest beams with the cure are judged."""
    options = case.arguments()
    options.timeout = 1500
    sheet = report.Report()
    for poisson in RATIOS:
        expected = beams.expected(poisson)["fall"]
        for words in ("", "antilock='bbar'"):
            errors = []
            for spacing in SIZES:
                name = f"{'even' if words else 'plain'}_{poisson}_{spacing}"
                result = beams.bend(options, name, poisson, spacing, words)
                sheet.require(not result["code"], f"{name}: runs")
                errors.append(result["fall"] / expected - 1.0)
                sheet.note(f"{name}: fall of the tip, jumps, pressures within a cell, steps",
                           f"{errors[-1]:+.4f} {result['jump']:.3f} {result['spread']:.3f} {result['steps']}")
            if words:
                sheet.below(f"nu = {poisson}: fall of the tip, eight cells across", errors[-1], 0.02)
                sheet.above(f"nu = {poisson}: rate", bodies.rates(errors)[-1], 1.5)
                sheet.below(f"nu = {poisson}: jumps of pressure", result["jump"], 0.05)
    sheet.end()


if __name__ == "__main__":
    main()
