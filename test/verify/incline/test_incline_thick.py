# SPDX-License-Identifier: BSD-3-Clause
"""A thick layer of grains on a slope, and cells that differ.

Would catch: an inertial number that depends on the height or on the cells, a viscosity of the transfer that grows
with the number of steps. P. Jop, Y. Forterre, O. Pouliquen, Nature 441 (2006) 727: 24 degrees, 20 mm, steady speed of
the surface 0.77988 m/s, the mean goes with the height to the power of 3/2. Limit 1 %, for layers that start with 0.9
of the steady profile and are on their way to it for four of its times of relaxation; 20 cells, and for 10 mm 5 and 20.
"""
# label: long
# timeout: 600

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "support"))
import case    # noqa: E402
import flows   # noqa: E402
import report  # noqa: E402


def main():
    """One thick layer, and a thin one with coarse and fine cells."""
    options = case.arguments()
    sheet = report.Report()
    sheet.near("formula: speed of the surface [m/s]", flows.bagnold(0.02, 24.0, 0.02), 0.77988, 1.0e-5)
    for height, cells, end, limit in ((0.02, 20, 4.0, 0.01), (0.01, 20, 2.5, 0.01), (0.01, 5, 2.5, 0.03)):
        name = f"{1e3 * height:.0f} mm, {cells} cells"
        result = flows.incline(options, f"thick_{cells}_{1e3 * height:.0f}", height=height, cells=cells, start=0.9,
                               end=end, count=1)
        sheet.below(f"{name}: speed over that of the surface, worst particle", result["profile"], limit)
        sheet.below(f"{name}: mean speed", result["mean"], limit)
        sheet.above(f"{name}: change of the mean speed", result["means"][-1] / result["means"][0] - 1.0, 0.05)
    sheet.end()


if __name__ == "__main__":
    main()
