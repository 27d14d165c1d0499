# SPDX-License-Identifier: BSD-3-Clause
"""Grains whose stress relaxes as their contacts break: rate independence, and decaying waves.

Would catch: a relaxation that uses the strain of another step, or the time in place of the strain, a rate that includes
the dilatation or half of the shear, a rotation of the stress that depends on the rate, relaxation at rest where there
must be none; in a flow, grids or transfers with a time scale of their own.

D. Z. Zhang, R. M. Rauenzahn, J. Rheol. 41 (1997) 1275, with 1/tau = rate/gamma_c: the stress depends on the strain
alone and is that of constant tau with W = rate tau = gamma_c (see test/verify/shear for the formula).
One point at rates from 1e-3 to 1e4 /s: equal to 1e-12 of the shear modulus, and to the formula.
A flow whose layers have their velocities from the start: the formula to 1e-12. A flow driven by its boundaries, at 2
and 20 /s with a hundredth of the density, so that the waves are the same too: both agree to 1e-5, since perturbations
by round-off are not damped, and the formula is met within 0.5 %. There gamma_c = 0.3: with 0.7 the stress passes a
peak, and the driven flow splits into shear bands, which the law allows (14 % difference). A standing shear wave, u'' +
u'/tau + (c k)^2 u = 0, with a period 8 times longer than the relaxation, or 2 times shorter: speed and stress within
0.5 % at all times. At the end the stress that drives the grains is the one that relaxed while they moved.
"""

import numpy as np

import bodies
import flows
import test_point

POINT = """
&material  name='g'  density=1000  bulk=5  shear=3  strength_model='granular'  gr_gamma_c=0.3 /
&point  path='shear'  strain=2.6  rate={rate!r}  steps=260 /
"""


def test_points(options, sheet):
    """One point at very different rates."""
    tables = {rate: test_point.drive(options, f"rate_{rate:g}", POINT.format(rate=rate))
              for rate in (1.0e-3, 1.0, 1.0e4)}
    usual = tables[1.0]
    sheet.require(len(usual) == 261 and usual["xy"][-1] > 0.5, "the point bears shear")
    exact = np.array([bodies.shear_stress(time, 0.3, 1.0) for time in usual["time"]])
    for rate, table in tables.items():
        for name in ("xx", "xy", "yy"):
            sheet.below(f"point at {rate:g} /s: {name} against 1 /s", np.abs(table[name] - usual[name]).max() / 3.0,
                        1.0e-12)
        sheet.below(f"point at {rate:g} /s: shear stress", np.abs(table["xy"] - exact[:, 0]).max() / 3.0, 1.0e-12)
        half = 0.5 * (table["xx"] - table["yy"])
        sheet.below(f"point at {rate:g} /s: normal stress", np.abs(half - exact[:, 1]).max() / 3.0, 1.0e-12)


def test_flow(options, sheet):
    """Flows between two boundaries."""
    started = bodies.shear(options, "started", started=True, density=0.1, survival=0.7)
    sheet.below("layers that move: shear stress", started["across"], 1.0e-12)
    sheet.below("layers that move: normal stress", started["along"], 1.0e-12)
    curves = []
    for rate, density in ((2.0, 1.0e-4), (20.0, 1.0e-6)):
        driven = bodies.shear(options, f"driven_{rate:g}", density=density, survival=0.3, rate=rate)
        sheet.below(f"driven at {rate:g} /s: shear stress", driven["across"], 0.005)
        sheet.below(f"driven at {rate:g} /s: normal stress", driven["along"], 0.005)
        sheet.below(f"driven at {rate:g} /s: mean stress", driven["mean"], 0.002)
        curves.append(driven["curve"][:, 1:3])
    sheet.below("driven: one rate against the other", np.abs(curves[1] - curves[0]).max() / 1.5, 1.0e-5)
    sheet.above("driven: shear stress at the end [Pa]", curves[0][-1, 0], 0.8)


def test_fading(options, sheet):
    """Standing waves in grains that relax."""
    for relaxation, end in ((0.2, 0.6), (0.04, 0.6)):
        result = flows.wave(options, f"wave_{relaxation:g}", relaxation=relaxation, end=end)
        sheet.require(len(result["curve"]) == 31, f"tau {relaxation:g} s: all times are there")
        sheet.below(f"tau {relaxation:g} s: speed", result["speed"], 0.005)
        sheet.below(f"tau {relaxation:g} s: stress", result["stress"], 0.005)
        sheet.above(f"tau {relaxation:g} s: greatest stress", np.abs(result["curve"][:, 2]).max(), 0.3)
