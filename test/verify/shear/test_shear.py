# SPDX-License-Identifier: BSD-3-Clause
"""Grains between two boundaries that move parallel to themselves: the stress at the start of the shear.

Would catch: a Jaumann rate with the wrong sign or without the normal stresses, relaxation of a part of the
stress only, moving boundaries that do not shear or that compress, periodic boundaries that lose stress.

D. Z. Zhang, R. M. Rauenzahn, J. Rheol. 41 (1997) 1275, with constant relaxation: rate g = 2 /s, G = 3 Pa,
from rest. With W = g tau and A = G W/(1 + W2):
  s_xz = A [1 - exp(-t/tau) (cos gt - W sin gt)],  s_xx = A [W - exp(-t/tau) (W cos gt + sin gt)],
  so at 1.3 s and tau = 0.7 s 1.7686065 and 2.1380370 Pa. Errors are root mean squares over all particles, the
  greatest of 26 times, over G/2, the greatest stress that such a flow supports.

Two initial conditions: `started` gives every layer its velocity, so the flow is uniform and the formula is met to
round-off (limit 1e-12); `driven` has grains at rest and moving boundaries, and waves between the boundaries that the
formula does not include. The first of them has the stress sqrt(G rho) V, with V the speed of a boundary: 2.6 % of G/2
with 5e-4 kg/m3. It decays while it is reflected; target 1 % over all times. The mean of waves is zero: the mean stress
of all particles is correct to 1e-3. Here tau = 0.35 s: above W = 1 the law gives less stress for more shear, so that
flows that are not quite uniform may split into bands. With GIMP, flip and `musl` noise grows: a known miss, held at a
quarter of the greatest stress; with `usl` it does not grow.
"""
# tiers: smoke, full

import pytest

import bodies
import measured


def flow(options, name, *words, **more):
    """One flow; prints its errors."""
    result = bodies.shear(options, name, *words, **more)
    measured.show(name, {key: result[key] for key in ("across", "along", "mean", "steps")})
    return result


def judge(sheet, name, result, limit):
    """Stresses of all particles and times."""
    sheet.require(len(result["curve"]) == 27, f"{name}: all times are there")
    sheet.near(f"{name}: shear stress at the end over the formula", result["curve"][-1, 1] / result["curve"][-1, 3],
               1.0, max(limit, 1.0e-3))
    sheet.below(f"{name}: shear stress", result["across"], limit)
    sheet.below(f"{name}: normal stress", result["along"], limit)


def test_formula(sheet):
    exact = bodies.shear_stress(1.3, 0.7)
    sheet.near("formula: shear stress [Pa]", exact[0], 1.7686065, 1.0e-7)
    sheet.near("formula: normal stress [Pa]", exact[1], 2.1380370, 1.0e-7)


def test_started(options, sheet):
    judge(sheet, "started", flow(options, "started", started=True, density=0.1, relaxation=0.7), 1.0e-12)


@pytest.mark.tiers("full", "long")
@pytest.mark.parametrize("name, words", [
    ("driven", ()),
    ("mpm", ("mpm",)),
    ("gimp_usl", ("mpm", "basis='gimp' stress_update='usl'")),
])
def test_driven(options, sheet, name, words):
    """The second initial condition, and other methods."""
    result = flow(options, name, *words, density=5.0e-4)
    judge(sheet, name, result, 0.01)
    sheet.below(f"{name}: mean stress", result["mean"], 1.0e-3)


@pytest.mark.tiers("full", "long")
def test_noisy(options, sheet):
    noisy = flow(options, "gimp_musl", "mpm", "basis='gimp' stress_update='musl'", density=5.0e-4)
    for key in ("across", "along"):
        sheet.known(f"gimp_musl: stress {key}", noisy[key], limit=0.25, target=0.01)
