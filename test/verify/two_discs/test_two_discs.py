# SPDX-License-Identifier: BSD-3-Clause
"""Two elastic discs meet head-on and rebound (D. Sulsky et al. 1994).

Would catch: momentum lost at free surfaces or between tiles, energy created or lost when bodies collide through the
grid, a pair of discs that does not remain point symmetric, a transfer or a stress update that dissipates or creates
energy.

Discs of radius 0.2 m at +-(0.3, 0.3) with velocities -+(0.1, 0.1), E = 1000 Pa, nu = 0.3, rho =
1000 kg/m3, without artificial viscosity. They touch at 1.5858 s.

Limits. Momentum, angular momentum and symmetry: rounding. First force: two cells early at most, as the function of a
node extends one cell to both sides. Total energy: target 2 % of that at the start with cells of 0.025 m, 1 % with cells
of 0.0125 m, where a loss of at least first order is half as large; greatest total energy: half of the target, as
created energy grows. The material is neo-Hookean: the law of rates, the default of elastic material, has no energy at
these strains, and the same discs gain 1.4 % with any size of step. Kinetic energy after the rebound: there is no closed
solution, because the discs continue to vibrate. Runs with 64 cells across, 2 x 2 and 3 x 3 particles, which conserve
their energy to 0.03 %, end with 0.888; target: that within the target of the energy, a known miss held at twice that.
usl loses 3.5 %: a known miss, held at twice the target. The PIC fraction of `flip` in each step dissipates more than
the target from a vibration of few cells: a known miss, held at a tenth of the energy.
"""
# tiers: smoke, full

import numpy as np
import pytest

import bodies
import measured
import tier

TARGET = 0.02                          # of the energy at the start
REBOUND = 0.888                        # kinetic energy at the end of fine runs, over that at the start
FILTERS = ("flip",)
OTHERS = {"usl": ("ddmp", "stress_update='usl'"), "flip": ("ddmp", "stress_update='usl' transfer='flip'"),
          "aflip": ("ddmp", "transfer='aflip'"), "musl": ("ddmp", "stress_update='musl'"),
          "usf": ("ddmp", "stress_update='usf'"), "point": ("ddmp", "stress_update='usavg' quadrature='point'"),
          "mpm": ("mpm", "")}


def collide(options, sheet, name, method="ddmp", words="", target=TARGET, **more):
    """One rebound; momentum, symmetry and energy are checked."""
    result = bodies.two_discs(options, name, method, words, **more)
    figures = ("kinetic", "least", "energy", "books", "greatest", "early", "momentum")
    measured.show(name, {key: result[key] for key in figures})
    _, last = result["run"].snapshots()[-1]
    left, right = (last.points[last.fields["body"] == number][:, [0, 2]] for number in (1, 2))
    sheet.require(len(left) == len(right) > 700, f"{name}: both discs have their particles")
    centre = left.mean(axis=0) + right.mean(axis=0)
    sheet.below(f"{name}: centre of mass off the middle [m]", np.abs(centre).max(), 1.0e-13)
    sheet.below(f"{name}: momentum", result["momentum"], 1.0e-13)
    sheet.below(f"{name}: angular momentum", result["angular"], 1.0e-13)
    sheet.below(f"{name}: least kinetic energy", result["least"], 0.1)
    sheet.below(f"{name}: greatest total energy", result["greatest"], 0.5 * TARGET)
    sheet.below(f"{name}: cells felt early", result["early"], 2.0)
    if name in FILTERS:
        sheet.known(f"{name}: total energy at the end", result["books"], limit=0.1, target=target)
    elif name == "usl":
        sheet.known(f"{name}: total energy at the end, with viscous work", result["books"], limit=2.0 * target,
                    target=target)
    else:
        sheet.below(f"{name}: total energy at the end, with viscous work", result["books"], target)
    return result


def test_usual(options, sheet):
    """The default with two cell sizes."""
    coarse = collide(options, sheet, "coarse")
    sheet.known("coarse: kinetic energy after the rebound, less that of fine runs", coarse["kinetic"] - REBOUND,
                limit=2.0 * TARGET, target=TARGET)
    if tier.NAME != "smoke":
        usual = collide(options, sheet, "usual", spacing=0.0125, target=0.5 * TARGET)
        sheet.known("usual: kinetic energy after the rebound, less that of fine runs", usual["kinetic"] - REBOUND,
                    limit=TARGET, target=0.5 * TARGET)
        sheet.above("loss of energy, coarse over usual", coarse["energy"] / usual["energy"], 2.0)


@pytest.mark.tiers("full", "long")
def test_viscous(options, sheet):
    """With artificial viscosity."""
    wet = collide(options, sheet, "viscous", effects="")
    sheet.above("viscous: work of the viscosity over the energy", wet["books"] - wet["energy"], 0.005)


@pytest.mark.tiers("full", "long")
@pytest.mark.parametrize("name", OTHERS)
def test_others(options, sheet, name):
    """Other methods."""
    collide(options, sheet, name, *OTHERS[name])
