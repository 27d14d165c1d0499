# SPDX-License-Identifier: BSD-3-Clause
"""Bars of Al-2024 hit a rigid wall in one dimension: the states behind the shocks.

Would catch: a wrong equation of state or energy in it, work of another stress than that of the force, artificial
viscosity that is not Galilean invariant or not recorded, a wall that is not rigid, a dual gradient that exerts a force
at the free rear end.

Closed solutions: Rankine-Hugoniot with Us = c0 + s up, gamma rho constant, and the two jumps of an
elastic-plastic solid, computed here from the constants of the material.
Limits: plateau pressure 1 %, density 0.3 %, shock speed 1 %, velocity of the free end 1.1 % at 400 m/s, the effect of
the waves of a linear method there, and 1e-4 at 3350 m/s, where no signal can reach it. Solid: elastic limit 2 %,
plastic stress 0.5 %, density 0.3 %, speeds 1 %, with bulk_q1 = 0.5 and by default. Energy and momentum: rounding.
The plain method, where particles oscillate behind all shocks, misses some of these: known misses, held at 5 %.
"""
# tiers: smoke, full
# timeout: 120

import numpy as np
import pytest

import case
import measured

DENSITY, SOUND, SLOPE, GAMMA = 2785.0, 5328.0, 1.338, 2.0
SHEAR, YIELD = 27.6e9, 0.3e9
SMOOTH = "bulk_q1=0.5"

DECK = """
&run  dimension='1d'  method='{method}' /
&units  system='mm-us-mg' /
&method  {words} /
&grid  lo=0,0,0  hi={box},1,1  dx=0.1 /
&time  t_end={end!r}  cfl={cfl} /
&effects  strength={strength} /
&material  name='al'  density=2.785  eos_model='mie_gruneisen'  mg_c0=5.328  mg_s=1.338
  mg_gamma=2  {law} /
&region  name='bar'  shape='box'  lo=0,0,0  hi={length},1,1 /
&body  name='bar'  region='bar'  material='al'  ppc={ppc},1,1  velocity={velocity!r},0,0 /
&boundary  face='xlo'  type='slip' /
&output  name='p'  kind='particles'  times={half!r},{end!r}  precision='double'
  fields='identity','velocity','stress','volume','mass','energy' /
&output  name='h'  kind='history'  every=10 /
&checkpoint  at_end=.false. /
"""
FULL = pytest.mark.tiers("full", "long")


def hugoniot(speed):
    """Shock speed, pressure and density of a fluid."""
    shock = SOUND + SLOPE * speed
    return shock, DENSITY * shock * speed, DENSITY * shock / (shock - speed)


def pressure(density, energy):
    """Mie-Grueneisen equation of state [Pa]."""
    strain = 1.0 - DENSITY / density
    reference = DENSITY * SOUND ** 2 * strain / (1.0 - SLOPE * strain) ** 2
    return reference * (1.0 - GAMMA * strain / 2.0) + GAMMA * DENSITY * energy


def solve(function, low, high):
    """Root between two positions with values of different sign."""
    sign = function(low) > 0.0
    for _ in range(200):
        middle = 0.5 * (low + high)
        if (function(middle) > 0.0) == sign:
            low = middle
        else:
            high = middle
    return middle


def precursor():
    """Density, stress, velocity, energy and speed of the elastic wave."""
    density = DENSITY * np.exp(YIELD / (2.0 * SHEAR))
    jump = 1.0 / DENSITY - 1.0 / density
    stress = solve(lambda s: pressure(density, 0.5 * s * jump) + 2.0 / 3.0 * YIELD - s, 0.0, 5.0e9)
    return {"density": density, "stress": stress, "velocity": np.sqrt(stress * jump),
            "energy": 0.5 * stress * jump, "speed": np.sqrt(stress / jump) / DENSITY}


def plastic(speed):
    """Density, stress and speed, relative to the bar at rest, of the wave behind the precursor."""
    before = precursor()

    def state(density):
        jump = 1.0 / before["density"] - 1.0 / density
        energy = before["energy"]
        for _ in range(100):   # converges fast, because gamma jump / 2 is small
            stress = pressure(density, energy) + 2.0 / 3.0 * YIELD
            energy = before["energy"] + 0.5 * (stress + before["stress"]) * jump
        return stress, jump

    def excess(density):
        stress, jump = state(density)
        return before["velocity"] + np.sqrt((stress - before["stress"]) * jump) - speed

    density = solve(excess, before["density"] * 1.000001, 1.5 * DENSITY)
    stress, _ = state(density)
    mass_flow = (stress - before["stress"]) / (speed - before["velocity"])
    return {"density": density, "stress": stress,
            "speed": before["velocity"] + mass_flow / before["density"]}


def front(places, stress, level):
    """The outermost position where the stress falls below a level."""
    last = np.flatnonzero(stress > level)[-1]
    share = (stress[last] - level) / (stress[last] - stress[last + 1])
    return places[last] + share * (places[last + 1] - places[last])


def strike(options, name, speed, end, solid, words, method="ddmp", cfl=0.4):
    """One bar: ordered particles at two times, and the run. Speed in m/s, end in us."""
    ppc, length = 4, 36 if solid else 20
    law = ("shear=27.6 strength_model='von_mises' yield=0.3" if solid else "")
    deck = DECK.format(method=method, end=end, half=0.6 * end, velocity=-speed / 1000.0, ppc=ppc,
                       strength=".true." if solid else ".false.", law=law, words=words, cfl=cfl,
                       length=length, box=length + 2)
    run = case.Case(options, name, deck).run("-q")
    states = []
    for time, snap in run.snapshots():
        order = np.argsort(snap.points[:, 0])
        states.append((time, snap.points[order, 0],
                       {key: values[order] for key, values in snap.fields.items()}))
    assert len(states) == 2 and len(states[1][1]) == 10 * length * ppc, name
    return states, run


def plateau(places, fields, low, high):
    """Mean and scatter of minus the axial stress, and density, between two positions."""
    here = (places > low) & (places < high)
    stress = -fields["stress"][here, 0]
    density = fields["mass"][here].sum() / fields["volume"][here].sum()
    return stress.mean(), stress.std() / stress.mean(), density, here.sum()


MISSES = {"fluid_400_mpm": ("pressure",), "fluid_3350_mpm": ("density",),
          "solid_mpm": ("precursor stress", "plastic stress", "plastic speed")}


def compare(sheet, name, label, value, exact, limit):
    """A value against the closed solution; some are known misses."""
    if label in MISSES.get(name, ()):
        sheet.known(f"{name}: {label}, error", value / exact - 1.0, limit=0.05, target=limit)
    else:
        sheet.near(f"{name}: {label}", value, exact, limit)


def fluid(options, sheet, name, speed, end, words=SMOOTH, method="ddmp", cfl=0.4):
    """A shock in a fluid."""
    states, run = strike(options, name, speed, end, False, words, method, cfl)
    shock, stress, density = hugoniot(speed)
    fronts = [front(places, -fields["stress"][:, 0], 0.5 * stress) for _, places, fields in states]
    _, places, fields = states[1]
    # the first 15 cells, shortened, contain the heated wall, the last 10 the width of the shock
    got = plateau(places, fields, 1.5e-3 * DENSITY / density, fronts[1] - 1.0e-3)
    pace = (fronts[1] - fronts[0]) / (states[1][0] - states[0][0]) + speed
    free = abs(fields["velocity"][-1, 0] / -speed - 1.0)
    heat = fields["energy"][:4].mean() / (0.5 * speed ** 2) - 1.0
    drift = run.summary["ledger"]["energy_error"]
    measured.show(name, {"pressure": got[0] / stress - 1.0, "density": got[2] / density - 1.0, "energy": drift,
                         "shock speed": pace / shock - 1.0, "scatter": got[1], "heat of the wall": heat})
    sheet.require(got[3] > 100, f"{name}: the plateau has {got[3]} particles")
    compare(sheet, name, "pressure", got[0], stress, 0.01)
    compare(sheet, name, "density", got[2], density, 0.003)
    compare(sheet, name, "speed of the shock", pace, shock, 0.01)
    sheet.below(f"{name}: velocity error of the free end", free, 0.011 if speed < 1000 else 1.0e-4)
    sheet.below(f"{name}: energy error", drift, 1.0e-12)
    sheet.below(f"{name}: momentum error", run.summary["ledger"]["momentum_error"], 1.0e-13)


def solid(options, sheet, name, words=SMOOTH, method="ddmp"):
    """Elastic precursor and plastic shock."""
    speed = 400
    states, run = strike(options, name, speed, 4.8, True, words, method)
    before, after = precursor(), plastic(speed)
    level = (0.5 * before["stress"], 0.5 * (before["stress"] + after["stress"]))
    fronts = np.array([[front(places, -fields["stress"][:, 0], height) for height in level]
                       for _, places, fields in states])
    pace = (fronts[1] - fronts[0]) / (states[1][0] - states[0][0]) + speed
    _, places, fields = states[1]
    width = fronts[1, 0] - fronts[1, 1]
    elastic = plateau(places, fields, fronts[1, 1] + 0.3 * width, fronts[1, 0] - 0.2 * width)
    got = plateau(places, fields, 1.5e-3, fronts[1, 1] - 1.0e-3)
    values = (("precursor stress", elastic[0], before["stress"], 0.02),
              ("precursor speed", pace[0], before["speed"], 0.01),
              ("plastic stress", got[0], after["stress"], 0.005),
              ("plastic density", got[2], after["density"], 0.003),
              ("plastic speed", pace[1], after["speed"], 0.01))
    drift = run.summary["ledger"]["energy_error"]
    measured.show(name, {**{label: value / exact - 1.0 for label, value, exact, _ in values}, "energy": drift,
                         "scatter ahead": elastic[1], "scatter behind": got[1]})
    for label, value, exact, limit in values:
        compare(sheet, name, label, value, exact, limit)
    sheet.require(elastic[3] > 20 and got[3] > 100, f"{name}: both plateaus have particles")
    sheet.below(f"{name}: energy error", drift, 1.0e-12)
    sheet.below(f"{name}: momentum error", run.summary["ledger"]["momentum_error"], 1.0e-13)


def test_closed(sheet):
    """The closed solutions against values computed independently."""
    sheet.near("closed solution: pressure at 400 m/s", hugoniot(400.0)[1], 6.53160e9, 1.0e-5)
    sheet.near("closed solution: precursor stress", precursor()["stress"], 0.635879e9, 1.0e-5)
    sheet.near("closed solution: plastic stress", plastic(400.0)["stress"], 6.635879e9, 1.0e-5)
    sheet.near("closed solution: plastic speed", plastic(400.0)["speed"], 5908.5, 1.0e-4)


@pytest.mark.parametrize("speed, end", [(400, 2.6), (3350, 1.5)])
@pytest.mark.parametrize("name, more", [
    ("", {"words": ""}),
    pytest.param("_fine_step", {"words": SMOOTH + " flip=1", "cfl": 0.15}, marks=FULL),
    pytest.param("_smooth", {}, marks=FULL),
    pytest.param("_mpm", {"method": "mpm"}, marks=FULL),
], ids=["usual", "fine_step", "smooth", "mpm"])
def test_fluid(options, sheet, speed, end, name, more):
    """Two speeds; the plain method and other viscosities in addition to the default."""
    fluid(options, sheet, f"fluid_{speed}{name}", speed, end, **more)


@pytest.mark.parametrize("name, more", [
    ("solid", {}),
    pytest.param("solid_default", {"words": ""}, marks=FULL),
    pytest.param("solid_mpm", {"method": "mpm"}, marks=FULL),
])
def test_solid(options, sheet, name, more):
    solid(options, sheet, name, **more)
