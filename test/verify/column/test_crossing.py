# SPDX-License-Identifier: BSD-3-Clause
"""A soft column on a wall is compressed by a fifth under suddenly applied gravity.

Would catch: cell-crossing noise, which grows with each crossing; a stress that does not agree with the stretch; a wall
that loses momentum when cells beside it become filled and empty.

L = 10 m, E = 1 MPa, nu = 0, rho = 1000 kg/m3, g = 10 m/s2 along x, neo-Hookean: the static strain at the foot is 0.1,
the dynamic one twice that. After 1.8 s, one and a half periods, the column is short for the second time and its top has
moved by 0.96 m. The reference is the bar of 1000 finite elements in test/support/bodies.py: P = E (F - 1/F)/2 in
material coordinates. It is verified here against d'Alembert's solution: for small gravity the mean velocity is -g t + g
c t2/(2 L) until 2 L/c.

Limits for 40 cells with four particles each. Stress (root mean square): the weight of one cell over that on the
foot, h/L = 2.5 %, as the stress of a particle may be that of its neighbour. Mean velocity: target 1 %. Displacement:
a hundredth of a cell. Orders: the stress has kinks, so it is of first order and the displacement of order 1.5 at best;
0.8 and 1.2. GIMP and quadratic splines, whose cell-crossing noise does not decrease with the cell size, miss the limit
of the stress: known misses, held at a tenth of the weight. The plain method is the control: the error of its stress
must exceed that tenth; otherwise no particle crosses cells.
"""
# tiers: smoke, full

import numpy as np

import bodies
import convergence
import measured
import tier

NOISY = ("gimp", "quadratic")
OTHERS = {"mpm": ("mpm", ""), "gimp": ("mpm", "basis='gimp'"), "quadratic": ("mpm", "basis='quadratic'"),
          "cubic": ("mpm", "basis='cubic'"), "control": ("ddmp", "quadrature='control'"),
          "usf": ("ddmp", "stress_update='usf'"), "musl": ("ddmp", "stress_update='musl'")}


def fall(options, name, *words, cells=40):
    """One column; prints its errors."""
    result = bodies.column(options, name, *words, cells=cells)
    measured.show(name, {key: result[key] for key in ("displacement", "stress", "velocity", "crossed")})
    return result


def judge(sheet, name, result):
    """Limits with 40 cells."""
    sheet.require(result["particles"] == 160, f"{name}: the column keeps its particles")
    sheet.above(f"{name}: cells crossed by some particle", result["crossed"], 3.0)
    sheet.below(f"{name}: mean velocity", result["velocity"], 0.01)
    if name in NOISY:
        sheet.known(f"{name}: stress over the weight on the foot", result["stress"], limit=0.1, target=1.0 / 40)
    else:
        sheet.below(f"{name}: stress over the weight on the foot", result["stress"], 1.0 / 40)
        sheet.below(f"{name}: displacement [m]", result["displacement"], 0.01 * 0.25)


def test_crossing(options, sheet):
    """Four grids with the default, and other methods."""
    small = bodies.chain(10.0, 1.0e6, 1000.0, 0.6, gravity=0.001, elements=200)
    speed = np.sqrt(1.0e6 / 1000.0)
    right = -0.001 * small["time"] + 0.001 * speed * small["time"] ** 2 / 20.0
    sheet.below("chain: mean velocity, small gravity", bodies.rms(small["mean"] - right) / np.abs(right).max(), 1.0e-3)
    grids = tier.choose((24, 40, 56, 76), smoke=(40,))
    runs = {cells: fall(options, f"cells_{cells}", cells=cells) for cells in grids}
    judge(sheet, "default", runs[40])
    if tier.NAME != "smoke":
        orders = {key: convergence.order(grids, [runs[cells][key] for cells in grids])
                  for key in ("displacement", "stress", "velocity")}
        measured.record("order", orders)
        for key, least in (("stress", 0.8), ("displacement", 1.2)):
            sheet.above(f"order of {key}", orders[key], least)
        for name, words in OTHERS.items():
            result = fall(options, name, *words)
            if name == "mpm":
                sheet.above("mpm: stress over the weight on the foot", result["stress"], 0.1)
            else:
                judge(sheet, name, result)
