# SPDX-License-Identifier: BSD-3-Clause
"""The problems of test/support/bodies.py on fine grids with the defaults.

Would catch: errors that stop to fall, or grow, where grids are finer than those of the short tests, as noise of
moving particles does that is not damped; all short tests may pass with it.

Measured: spinning disc, 20 cells on the radius, angular momentum -3.0e-5 (2 x 2) and -1.3e-5 (3 x 3) in a turn; two
discs with 64 cells across, energy +0.03 %, and with 3 x 3 particles in 32 cells -0.08 %; period of the held bar
1.7e-4 and 4e-5 with 52 and 104 cells; column of 160 cells, stress 0.44 % of the weight.
"""
# label: long
# timeout: 1200

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "support"))
import bodies  # noqa: E402
import case    # noqa: E402
import report  # noqa: E402


def main():
    """One after the other."""
    options = case.arguments()
    sheet = report.Report()
    for ppc, limit in ((2, 6.0e-5), (3, 3.0e-5)):
        result = bodies.spin(options, f"spin_{ppc}", spacing=0.05, ppc=ppc)
        sheet.below(f"spin, {ppc} x {ppc}: angular momentum in a turn", result["drift"], limit)
        sheet.below(f"spin, {ppc} x {ppc}: energy in a turn", result["energy"], 5.0e-4)
        sheet.below(f"spin, {ppc} x {ppc}: displacement", result["displacement"], 6.0e-4)
    for name, words in (("64 cells", {"spacing": 0.00625}), ("3 x 3 particles", {"spacing": 0.0125, "ppc": 3}),
                        ("short steps", {"spacing": 0.0125, "cfl": 0.1})):
        result = bodies.two_discs(options, "discs", **words)
        sheet.below(f"two discs, {name}: energy", result["energy"], 0.005)
        sheet.below(f"two discs, {name}: greatest energy", result["greatest"], 0.01)
        sheet.below(f"two discs, {name}: momentum", result["momentum"], 1.0e-13)
    for speed in (0.1, 0.75):
        right = bodies.held_bar_reference(speed)["period"]
        errors = []
        for cells in (26, 52, 104):
            result = bodies.held_bar(options, "held", cells=cells, speed=speed)
            errors.append(abs(result["period"] / right - 1.0))
            sheet.below(f"held bar, {speed} m/s, {cells} cells: energy", result["energy"], 0.004)
        for rate in bodies.rates(errors):
            sheet.above(f"held bar, {speed} m/s: rate of the period", rate, 1.8)
    errors = [bodies.free_bar(options, "bar", spacing=spacing)["velocity"] for spacing in (1.0, 0.5, 0.25)]
    for rate in bodies.rates(errors):
        sheet.above("free bar: rate of the velocity", rate, 1.8)
    runs = [bodies.column(options, "column", cells=cells) for cells in (40, 80, 160)]
    for rate in bodies.rates([result["stress"] for result in runs]):
        sheet.above("column: rate of the stress", rate, 0.85)
    result = bodies.cantilever(options, "beam", spacing=0.125)
    sheet.near("cantilever, cells of 0.125 m: first minimum [m]", result["fall"], -3.27, 0.015)
    result = bodies.shear(options, "shear", density=1.0e-4)
    sheet.below("shear of very light grains: shear stress", result["across"], 0.005)
    sheet.end()


if __name__ == "__main__":
    main()
