# SPDX-License-Identifier: BSD-3-Clause
"""The bars of test_taylor.py with three sizes of cells, by several methods.

Would catch: results that change with the cells without end, a method that locks or loses its foot in fine grids.

Figures in doc/theory/verification_metals.md. Limits: classic bar within 0.6 % of the length and 1.2 % of the foot of
the finite elements for cells of 0.2 mm, measured bar within 1 % for 0.3175 mm, and the last halving of the cells
changes less than the first.
"""
# label: long
# timeout: 1200

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "support"))
import case    # noqa: E402
import report  # noqa: E402
import taylor  # noqa: E402

METHODS = {"ddmp": ("ddmp", ""), "ddmp bbar": ("ddmp", "antilock='bbar'"), "mpm": ("mpm", ""),
           "gimp": ("mpm", "basis='gimp'")}
BARS = ((taylor.MEASURED, (1.27, 0.635, 0.3175)), (taylor.CLASSIC, (0.8, 0.4, 0.2)))


def table(options, methods=tuple(METHODS)):
    """All runs, by method, deck and spacing."""
    found = {}
    for name in methods:
        method, words = METHODS[name]
        for bar, spacings in BARS:
            for spacing in spacings:
                label = f"{name}_{bar.deck[:-4]}_{spacing}".replace(" ", "_").replace(".", "_")
                found[name, bar.deck, spacing] = taylor.strike(options, label, bar, spacing, words, method,
                                                               timeout=600)
    return found


def main():
    """Every method on both bars."""
    options = case.arguments()
    sheet = report.Report()
    found = table(options)
    for name in METHODS:
        runs = [found[name, "classic.nml", spacing] for spacing in (0.8, 0.4, 0.2)]
        sheet.near(f"{name}: length of the classic bar [m]", runs[-1]["length"], 21.442e-3, 0.006)
        sheet.near(f"{name}: foot of the classic bar [m]", runs[-1]["foot"], 7.200e-3, 0.012)
        changes = [abs(fine["foot"] - coarse["foot"]) for coarse, fine in zip(runs, runs[1:])]
        sheet.below(f"{name}: last change of the foot over the first", changes[1] / changes[0], 0.75)
        result = found[name, "scene.nml", 0.3175]
        sheet.below(f"{name}: mean error against the experiment", taylor.difference(result), 0.01)
        sheet.below(f"{name}: energy", result["energy"], 1.0e-13)
    sheet.end()


if __name__ == "__main__":
    main()
