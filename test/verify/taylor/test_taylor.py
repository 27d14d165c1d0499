# SPDX-License-Identifier: BSD-3-Clause
"""Copper bars strike a rigid smooth wall: length, foot and intermediate diameter, and the balances.

Would catch: hoop strain or hoop force that is wrong where material flows to three times its radius, hardening by the
wrong strain, plastic flow that locks, plastic work that does not heat, a wall that resists the spreading of the foot or
lets material through, an input deck that differs from its sources.

The decks are those of input/taylor_copper, with coarser cells. Measured bar (25.4 x 7.62 mm, 190 m/s): 16.2 mm
long, foot of 13.5 mm, intermediate diameter of 10.1 mm, G. R. Johnson and T. J. Holmquist, J. Appl. Phys. 64 (1988)
3901; the mean of the three relative errors must be below 3 %, the measure used for other material point codes (S. Ma,
X. Zhang, X. M. Qiu, Int. J. Impact Eng. 36 (2009) 272). Classic bar (32.4 x 6.4 mm, 227 m/s): axisymmetric finite
elements with a mean dilatation have 21.479 mm and 7.167 mm with 5 x 50 elements, 21.442 mm and 7.200 mm with 10 x 100;
published lengths lie within 1 % of that, radii between 6.97 and 7.24 mm. Limits: 1 % and 2 %. Greatest plastic strain:
3.22 and 3.31 in the finite elements; limit 6 %, twice their difference. At the end the bar is at rest: kinetic energy
4e-4 in the finite elements, limit 1e-3; the measured bar of three cells vibrates longer, limit 4e-3.

The measured bar carries its internal energy and conserves energy to rounding; the classic one carries none, so the
energy that the stress update dissipates is missing in its balance: 1 %.

Preset cu_ofhc (Johnson-Cook): three other measured bars. Axisymmetric finite elements with the same law, constants and
equation of state, 6 x 40 and 6 x 37 elements of four points with a mean dilatation, have the lengths below; limit 1 %,
as for the classic bar. The finite elements miss the measured lengths by 5.6, 6.8 and -0.6 %, so the law does; target 3
%, held at the miss of the finite elements plus 1 %. Would catch flow stress with a wrong rate or temperature.

Tier long: both bars with three sizes of cells by several methods, figures in doc/theory/verification_metals.md. Would
catch results that do not converge, and a method that locks or loses the foot on fine grids. Cells of 0.2 mm: 1 % and 2
% again; the last halving of the cell size must change the foot less than the first. Measured bar, 0.3175 mm: 3 %.
"""
# tiers: smoke, full, long
# timeout long: 2400

import pytest

import measured
import taylor
import tier

BBAR = "antilock='bbar'"
METHODS = {"ddmp": ("ddmp", ""), "ddmp bbar": ("ddmp", BBAR), "mpm": ("mpm", ""), "gimp": ("mpm", "basis='gimp'")}
BARS = ((taylor.MEASURED, (1.27, 0.635, 0.3175)), (taylor.CLASSIC, (0.8, 0.4, 0.2)))
EXPERIMENT = 0.03                      # mean error against the experiment


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


def classic(sheet, name, result):
    """Length and foot of the classic bar."""
    sheet.near(f"{name}: length of the classic bar [m]", result["length"], 21.46e-3, 0.01)
    sheet.near(f"{name}: radius of its foot [m]", result["foot"], 7.105e-3, 0.02)
    sheet.below(f"{name}: momentum", result["momentum"], 1.0e-13)


@pytest.mark.tiers("long")
def test_fine(options, sheet):
    """Every method on both bars, with successively finer cells."""
    found = table(options)
    for name in METHODS:
        runs = [found[name, "classic.nml", spacing] for spacing in (0.8, 0.4, 0.2)]
        classic(sheet, name, runs[-1])
        changes = [abs(two["foot"] - one["foot"]) for one, two in zip(runs, runs[1:])]
        measured.record(f"{name}.change of the foot", dict(zip(("first", "last"), changes)))
        sheet.below(f"{name}: last change of the foot over the first", changes[1] / changes[0], 1.0)
        for spacing in (1.27, 0.635, 0.3175):
            result = found[name, "scene.nml", spacing]
            if spacing < 1.0:
                sheet.below(f"{name}, {spacing} mm: mean error against the experiment", taylor.difference(result),
                            EXPERIMENT)
            sheet.below(f"{name}, {spacing} mm: energy", result["energy"], 1.0e-13)


CASES = (("three cells, bbar", 1.27, BBAR), ("six cells", 0.635, ""), ("six cells, bbar", 0.635, BBAR))


@pytest.mark.parametrize("name, spacing, words", tier.choose(CASES, smoke=CASES[:1]))
def test_measured(options, sheet, name, spacing, words):
    """The bar that was measured."""
    result = taylor.strike(options, name.translate({32: "_", 44: None}), taylor.MEASURED, spacing, words)
    sheet.below(f"{name}: mean error against the experiment", taylor.difference(result), EXPERIMENT)
    sheet.below(f"{name}: energy", result["energy"], 1.0e-13)
    sheet.below(f"{name}: momentum", result["momentum"], 1.0e-13)
    sheet.below(f"{name}: kinetic energy left", result["kinetic"], 4.0e-3)


@pytest.mark.tiers("full", "long")
def test_classic(options, sheet):
    """The bar that is the usual benchmark of codes."""
    result = taylor.strike(options, "classic", taylor.CLASSIC)
    classic(sheet, "classic", result)
    sheet.near("classic: greatest plastic strain", result["strain"], 3.265, 0.06)
    sheet.below("classic: energy", result["energy"], 0.01)
    sheet.below("classic: kinetic energy left", result["kinetic"], 1.0e-3)


#: Final over initial length by finite elements.
ELEMENTS = {"johnson_130": 0.8133, "johnson_190": 0.6816, "wilkins_210": 0.6392}


@pytest.mark.tiers("full", "long")
@pytest.mark.parametrize("name", tuple(taylor.SHOTS))
def test_johnson_cook(options, sheet, name):
    """The preset cu_ofhc against finite elements and measured bars, with and without the factor of the rate."""
    shot, right = taylor.SHOTS[name], ELEMENTS[name]
    result = taylor.shoot(options, name, shot)
    sheet.near(f"{name}: length over that of finite elements", result["ratio"] / right, 1.0, 0.01)
    slow = taylor.shoot(options, f"{name}_without_rate", shot, "rate=.false.")
    sheet.require(slow["ratio"] < 0.98 * result["ratio"], f"{name}: the rate strengthens the bar")
    miss = abs(right / shot.ratio - 1.0)
    if miss > EXPERIMENT:
        sheet.known(f"{name}: length against the experiment", result["error"], miss + 0.01, EXPERIMENT)
    else:
        sheet.below(f"{name}: length against the experiment", abs(result["error"]), EXPERIMENT)
