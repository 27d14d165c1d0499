# SPDX-License-Identifier: BSD-3-Clause
"""A soft column on a wall feels gravity from one moment to the next and is pressed together by a fifth.

Would catch: the noise of particles that cross cells, which grows with each cell crossed; a stress that does
not belong to the stretch; a wall that leaks when cells beside it fill and empty.

L = 10 m, E = 1 MPa, nu = 0, rho = 1000 kg/m3, g = 10 m/s2 along x, Neo and Hooke: the static strain at the
foot is 0.1, the dynamic one twice that. After 1.8 s, one and a half periods, the column is short for the
second time and its top has moved by 0.96 m. The reference is the chain of 1000 finite elements in
test/support/bodies.py: P = E (F - 1/F)/2 on the material. It is held against d'Alembert here: for small
gravity the mean velocity is -g t + g c t2/(2 L) until 2 L/c.

Limits for 40 cells with four particles each: stress 2.2 % of the weight on the foot (root mean square; the
stress has kinks, and moves across 3.8 cells), mean velocity 0.9 %; rate of the stress above 0.8, of the
displacement above 1.2. The plain method is shown: it is wrong by 40 % of the weight.
"""

import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "support"))
import bodies  # noqa: E402
import case    # noqa: E402
import report  # noqa: E402

OTHERS = {"mpm": ("mpm", ""), "gimp": ("mpm", "basis='gimp'"), "quadratic": ("mpm", "basis='quadratic'"),
          "cubic": ("mpm", "basis='cubic'"), "control": ("ddmp", "quadrature='control'"),
          "usf": ("ddmp", "stress_update='usf'"), "musl": ("ddmp", "stress_update='musl'")}


def fall(options, name, *words, cells=40):
    """One column, shown."""
    result = bodies.column(options, name, *words, cells=cells)
    print(f"         {name}: " + (", ".join(f"{key} {result[key]:.2e}" for key in
                                            ("displacement", "stress", "velocity", "crossed"))
          if not result["code"] else f"exit code {result['code']}"), flush=True)
    return result


def main():
    """Three grids with the default, others beside them."""
    options = case.arguments()
    sheet = report.Report()
    small = bodies.chain(10.0, 1.0e6, 1000.0, 0.6, gravity=0.001, elements=200)
    speed = np.sqrt(1.0e6 / 1000.0)
    right = -0.001 * small["time"] + 0.001 * speed * small["time"] ** 2 / 20.0
    sheet.below("chain: mean velocity, small gravity", bodies.rms(small["mean"] - right) / np.abs(right).max(), 1.0e-3)
    runs = [fall(options, f"cells_{cells}", cells=cells) for cells in (20, 40, 80)]
    sheet.require(runs[1]["particles"] == 160, "the column keeps its particles")
    sheet.above("cells crossed by some particle", runs[1]["crossed"], 3.0)
    sheet.below("stress over the weight on the foot", runs[1]["stress"], 0.022)
    sheet.below("mean velocity", runs[1]["velocity"], 0.009)
    sheet.below("displacement [m]", runs[1]["displacement"], 2.0e-3)
    for key, least in (("stress", 0.8), ("displacement", 1.2)):
        for rate in bodies.rates([result[key] for result in runs]):
            sheet.above(f"rate of {key}", rate, least)
    for name, words in OTHERS.items():
        fall(options, name, *words)
    sheet.end()


if __name__ == "__main__":
    main()
