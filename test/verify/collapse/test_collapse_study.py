# SPDX-License-Identifier: BSD-3-Clause
"""Columns of sand that collapse, half to sixteen times as high as half of them is wide: the laws of run-out.

Would catch what test_collapse.py does, and in tall columns: energy that the fall or the impact on the base loses or
makes, a softness of the grains that matters, free fall that is held back.

G. Lube and others, J. Fluid Mech. 508 (2004) 175 (round): 1.24 a to a = 1.7, then 1.6 a^(1/2); Phys. Rev. E 72 (2005)
041301 (plane): 1.2 a to a = 2, then 1.9 a^(2/3). Every prefactor within 15 %, exponents within 0.1 below and 0.07
above the change. Times and heights are printed and stand in doc/theory/verification_granular.md.
"""
# label: long
# timeout: 1800

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "support"))
import case                             # noqa: E402
import report                           # noqa: E402
from test_collapse import exponent, study  # noqa: E402


def main():
    """All aspect ratios."""
    options = case.arguments()
    options.timeout = 600
    sheet = report.Report()
    for word, aspects, low, high, steep in (
            ("plane", (0.5, 1.0, 2.0, 4.0, 8.0, 16.0), (0.5, 1.0, 2.0), (4.0, 8.0, 16.0), 2.0 / 3.0),
            ("round", (0.5, 1.0, 1.5, 2.0, 4.0, 8.0, 16.0), (0.5, 1.0, 1.5), (2.0, 4.0, 8.0, 16.0), 0.5)):
        runs = study(options, sheet, word, aspects, ())
        sheet.below(f"{word}: exponent of low columns, less 1", exponent(aspects, runs, low) - 1.0, 0.1)
        sheet.below(f"{word}: exponent of tall columns, less {steep:.3f}", exponent(aspects, runs, high) - steep, 0.07)
    sheet.end()


if __name__ == "__main__":
    main()
