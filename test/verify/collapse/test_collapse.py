# SPDX-License-Identifier: BSD-3-Clause
"""Collapsing columns of sand: run-out, height and time, against experiments.

Would catch: friction that depends on the grid or on the direction, material that separates and keeps its pressure or
never recovers it, a base without friction or one that holds material that should slide, missing hoop stresses in
axisymmetry, a front that almost empty cells push ahead; in tall columns energy lost or created in the fall or in the
impact on the base, an influence of the stiffness of the grains, a retarded free fall.

G. Lube and others, J. Fluid Mech. 508 (2004) 175 (axisymmetric): the run-out over the radius is 1.24 a to a = 1.7, then
1.6 a^(1/2), the height 0.88 a^(1/6), for all grains and bases; Phys. Rev. E 72 (2005) 041301 (plane): over the half
width 1.2 a to a = 1.8, from 2.8 on 1.9 a^(2/3), and no law between: there the run-out must be between both laws, with
the scatter. The final run-out is reached after 3.0 and 3.3 times sqrt(H/g). E. Lajeunesse, J. B. Monnier, G. M. Homsy,
Phys. Fluids 17 (2005) 103302: plane deposits are as high as the column, for a > 0.7 0.79 a^(1/3). Measured prefactors
scatter by 15 %, the limit of run-outs and heights; exponents must agree within 0.1 below the change of regime and 0.07
above. The beads of the heights run farther than the grains of the run-outs, and so does a law with one angle: plane
deposits are too high, known misses, held at a half. The exponent of low plane columns misses 0.1 and is held
at twice that; so are the run-outs of axisymmetric columns of 1.5 and 2, 18 % too short, and the exponent of tall ones.

P.-Y. Lagree, L. Staron, S. Popinet (J. Fluid Mech. 686 (2011) 378): a continuum with the law mu(I) has run-outs of
2.2 a to a = 7, and heights of 0.65 a^0.35. With the friction of a cell of spheres (input/grain_cell) run-outs and
heights must agree with it within the scatter; the heights of the lower columns are known misses.

The coefficient of friction, tan 33.2 degrees, was chosen within the angles of repose of dry sand, 30 to 35 degrees, and
determines the prefactors of the run-outs: these are a fit, while exponents, heights and times are not. So the range is
tested as well (tier long): sand of 35 degrees must spread less than sand of 30 degrees, and the measured values must be
between both, with the scatter.

The time at which the front has completed 97 % of its run-out has a target of 10 %. Fronts are defined by a thickness
and stop while single particles still move, so they are early: known misses, held at twice the target for low columns
and at a half for tall ones. The tallest axisymmetric deposits are too low: known misses, held at a half.

Tier full: low columns. Tier long: heights of half to sixteen times the half width.
"""
# tiers: full, long
# timeout long: 3600

import numpy as np
import pytest

import flows
import measured

SCATTER, LATE = 0.15, 0.1              # of measured prefactors; target of the time
IN_TIME = {("plane", 1.0), ("plane", 1.5), ("plane", 2.0), ("round", 0.5), ("round", 1.0)}
IN_TIME_AT_END = {("plane", 0.5)}      # in runs to the end, not in shorter ones
SHORT = {("round", 1.5), ("round", 2.0)}               # run-outs
FAR = {("round", 8.0), ("round", 16.0), *(("plane", aspect) for aspect in (1.0, 1.5, 2.0, 4.0, 8.0))}  # heights
# angles of the Drucker-Prager cone of plane strain whose friction coefficient in simple shear is tan 30 and tan 35
# degrees
SANDS = {30: 37.76, 35: 49.96}
SPHERES = 23.4                         # angle of the cone for spheres [degree]
LOW = {"plane": (0.5, 1.0, 1.5), "round": (0.5, 1.0, 1.5)}
BETWEEN = {"plane": (2.0,), "round": ()}
TALL = {"plane": (4.0, 8.0, 16.0), "round": (2.0, 4.0, 8.0, 16.0)}
STEEP = {"plane": 2.0 / 3.0, "round": 0.5}


def judge(sheet, name, label, value, exact, target, limit, missed):
    """A value against a measured one, within its target or as a known miss."""
    if missed:
        sheet.known(f"{name}: {label}, error", float(value / exact - 1.0), limit=limit, target=target)
    else:
        sheet.near(f"{name}: {label}", value, exact, target)


def study(options, sheet, word, aspects, label="", **more):
    """Columns of several aspect ratios; their run-outs. A label distinguishes runs that end earlier."""
    axisymmetric, runs = word == "round", []
    for aspect in aspects:
        name = f"{word}, {aspect:g} times as high"
        result = flows.collapse(options, f"{word}_{aspect:g}{label}", aspect=aspect, axisymmetric=axisymmetric, **more)
        least, most = flows.runout_laws(aspect, axisymmetric)
        key = word, aspect
        if key in SHORT:
            sheet.known(f"{name}: run-out, less than the least measured one by", 1.0 - result["runout"] / least,
                        limit=2.0 * SCATTER, target=SCATTER)
        else:
            sheet.above(f"{name}: run-out over the least measured one", result["runout"] / least, 1.0 - SCATTER)
        sheet.below(f"{name}: run-out over the greatest measured one", result["runout"] / most, 1.0 + SCATTER)
        measured.record(f"{word}_{aspect:g}{label}", {
            **({"runout over measured": result["runout"] / least} if least == most else {}),
            "time over measured": result["arrived"] / result["time"]})
        in_time = key in IN_TIME or (key in IN_TIME_AT_END and not label)
        judge(sheet, name, "height", result["height"], flows.measured_height(aspect, axisymmetric), SCATTER, 0.5,
              key in FAR)
        judge(sheet, name, "time over sqrt(H/g)", result["arrived"], result["time"], LATE,
              2.0 * LATE if aspect <= 2.0 else 0.5, not in_time)
        sheet.below(f"{name}: kinetic energy left over the greatest", result["kinetic"], 0.02)
        sheet.below(f"{name}: error of mass", result["lost"], 1.0e-12)
        runs.append(result["runout"])
    return np.array(runs)


def exponent(aspects, runs, chosen):
    """Slope of the run-out over the aspect ratio in logarithms."""
    here = [aspects.index(aspect) for aspect in chosen]
    return float(np.polyfit(np.log(chosen), np.log(runs[here]), 1)[0])


@pytest.mark.tiers("smoke", "long")
def test_range_of_sand(options, sheet):
    """Measured values are between those of sands with angles of repose of 30 and 35 degrees."""
    steep, flat = (flows.collapse(options, f"sand_{angle}", aspect=1.0, cells=16, ends=1.3, law=flows.SAND.replace(
        "friction_angle=45", f"friction_angle={cone}"))["runout"] for angle, cone in SANDS.items())
    run_out = flows.runout_laws(1.0)[0]
    sheet.above("sand of 30 degrees: run-out over the measured one", steep / run_out, 1.0 - SCATTER)
    sheet.below("sand of 35 degrees: run-out over the measured one", flat / run_out, 1.0 + SCATTER)
    sheet.below("sand of 35 degrees: run-out over that of 30 degrees", flat / steep, 1.0)


@pytest.mark.parametrize("aspect", [1.0, 2.0, 4.0])
def test_continuum(options, sheet, aspect):
    """With the friction of spheres plane columns agree with the continuum of Lagree and others."""
    name = f"spheres, {aspect:g} times as high"
    result = flows.collapse(options, f"spheres_{aspect:g}", aspect=aspect, law=flows.SAND.replace(
        "friction_angle=45", f"friction_angle={SPHERES}"))
    run_out, height = flows.continuum(aspect)
    sheet.near(f"{name}: run-out", result["runout"], run_out, SCATTER)
    judge(sheet, name, "height", result["height"], height, SCATTER, 0.5, aspect < 4.0)


@pytest.mark.tiers("full")
def test_low_columns(options, sheet):
    """The columns for the tier full."""
    options.timeout = 600
    runs = study(options, sheet, "plane", LOW["plane"], "_short", ends=1.3)
    judge(sheet, "plane", "exponent of low columns", exponent(LOW["plane"], runs, LOW["plane"]), 1.0, 0.1, 0.2, True)
    study(options, sheet, "plane", BETWEEN["plane"], "_short", ends=1.3)
    study(options, sheet, "round", (1.0,), "_short", ends=1.3)


@pytest.mark.tiers("smoke", "long")
@pytest.mark.parametrize("word, low", LOW.items(), ids=LOW)
def test_all_columns(options, sheet, word, low):
    options.timeout = 600
    aspects = low + BETWEEN[word] + TALL[word]
    runs = study(options, sheet, word, aspects)
    measured.record(f"{word} exponent", {"low": exponent(aspects, runs, low),
                                         "tall": exponent(aspects, runs, TALL[word])})
    judge(sheet, word, "exponent of low columns", exponent(aspects, runs, low), 1.0, 0.1, 0.2, word == "plane")
    steeper = exponent(aspects, runs, TALL[word]) - STEEP[word]
    label = f"exponent of tall columns, less {STEEP[word]:.3f}"
    if word == "round":                # columns of 1.5 and 2 are too short
        sheet.known(f"{word}: {label}", steeper, limit=0.14, target=0.07)
    else:
        sheet.below(f"{word}: {label}", steeper, 0.07)
