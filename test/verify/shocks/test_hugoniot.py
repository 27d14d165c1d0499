# SPDX-License-Identifier: BSD-3-Clause
"""States behind shocks in five metals: at one point, and in bars that hit a wall.

Would catch: a constant of the equation of state that is used wrongly for s or gamma other than those of aluminium,
`--point` that solves the jump conditions wrongly, work that does not heat, a release that does not follow the isentrope
(speed of the free surface), viscosity that is not of the order of the shock.

Rankine and Hugoniot with Us = c0 + s up and gamma rho constant; the velocity of the free surface is u + integral of
dp/(rho c) along the isentrope. Both are computed in test/support/shocks.py. A bar of 120 cells hits a rigid wall; the
plateau consists of the particles that began in the cells 25 to 65, and the free surface of those in the last 4 to 14
cells, at 60 % of the transit time of the shock after it has reached the free end. Limits: targets, pressure 0.3 % and
density 0.1 % up to 1 km/s, 1 % and 0.3 % above; speed of the shock and of the free surface 1 %. Energy and momentum:
rounding.
"""

import subprocess

import numpy as np
import pytest

import case
import measured
import shocks

# "fe" is iron above 13 GPa and "pb" an older set of lead; the presets and published points: test/verify/materials.
METALS = {metal.name: metal for metal in (
    shocks.Metal("al_2024", 2785.0, 5328.0, 1.338, 2.00), shocks.Metal("al_6061", 2703.0, 5350.0, 1.34, 1.97),
    shocks.Metal("cu", 8930.0, 3940.0, 1.489, 2.02), shocks.Metal("fe", 7830.0, 3574.0, 1.92, 1.69),
    shocks.Metal("pb", 11350.0, 2092.0, 1.45, 2.0))}
SPEEDS = {"al_2024": (100, 400, 1000, 2000, 3350), "al_6061": (100, 400, 3350), "cu": (95, 500, 1000), "fe": (500,),
          "pb": (500,)}
# Published values (pressure [GPa]) and values of an independent integration (speed of the free surface), to verify the
# closed solutions of this test.
KNOWN = {("al_2024", 400): (6.53160, 800.376), ("al_6061", 400): (6.36394, 800.360), ("cu", 95): (3.46250, 190.008),
         ("fe", 500): (17.75061, 1000.782), ("pb", 500): (15.98648, 1005.184)}
CELLS, SIZE = 120, 0.1
POINT = """
&units  system='mm-us-mg' /
&material  name='m'  {words} /
&effects  strength=.false. /
&point  path='hugoniot'  speed={speed}  steps=1 /
"""
DECK = """
&run  dimension='1d' /
&units  system='mm-us-mg' /
&grid  lo=0,0,0  hi={box},1,1  dx={size} /
&time  t_end={end!r} /
&method  {method} /
&effects  strength=.false. /
&material  name='m'  {words} /
&region  name='bar'  shape='box'  lo=0,0,0  hi={length},1,1 /
&body  name='bar'  region='bar'  material='m'  ppc=4,1,1  velocity={velocity!r},0,0 /
&boundary  face='xlo'  type='slip' /
&output  name='p'  kind='particles'  times={first!r},{second!r},{end!r}  precision='double'
  fields='identity','velocity','stress','volume','mass','energy' /
&output  name='h'  kind='history'  every=10 /
&checkpoint  at_end=.false. /
"""


def point(options, metal, speed):
    """The row in the output of `scree --point`."""
    name = f"point_{metal.name}_{speed}"
    folder = options.work / name
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "path.nml").write_text(POINT.format(words=metal.words(), speed=speed / 1e3), encoding="ascii")
    subprocess.run([options.scree, "--point", "path.nml"], cwd=folder, check=True, capture_output=True)
    return np.genfromtxt(folder / "out" / "path" / "path_point.csv", delimiter=",", names=True)


def front(places, stress, level):
    """The outermost position where the stress falls below a level, by linear interpolation."""
    last = np.flatnonzero(stress > level)[-1]
    share = (stress[last] - level) / (stress[last] - stress[last + 1])
    return places[last] + share * (places[last + 1] - places[last])


def strike(options, metal, speed, words=""):
    """Relative differences of one bar from the closed solution."""
    exact, length = metal.shock(speed), CELLS * SIZE * 1e-3
    arrival = length / exact["speed"]           # the bar moves towards the shock, so it takes L/Us
    times = [share * arrival for share in (0.5, 0.9, 1.6)]
    deck = DECK.format(box=length * 1e3 + 2.0, size=SIZE, length=length * 1e3, end=times[2] * 1e6, first=times[0] * 1e6,
                       second=times[1] * 1e6, method=words, words=metal.words(), velocity=-speed / 1e3)
    run = case.Case(options, f"bar_{metal.name}_{speed}", deck).run("-q")
    states = []
    for time, snap in run.snapshots():
        order = np.argsort(snap.fields["identity"])
        assert len(order) == 4 * CELLS
        states.append((time, snap.points[order, 0], {key: values[order] for key, values in snap.fields.items()}))
    fronts = [front(places, -fields["stress"][:, 0], 0.5 * exact["pressure"]) for _, places, fields in states[:2]]
    _, _, fields = states[1]
    here = slice(4 * 25, 4 * 65)
    pace = (fronts[1] - fronts[0]) / (states[1][0] - states[0][0]) + speed
    free = states[2][2]["velocity"][-4 * 14:-4 * 4, 0].mean() + speed
    ledger = run.summary["ledger"]
    return {"pressure": -fields["stress"][here, 0].mean() / exact["pressure"] - 1.0,
            "density": fields["mass"][here].sum() / fields["volume"][here].sum() / exact["density"] - 1.0,
            "speed": pace / exact["speed"] - 1.0, "free": free / metal.released(speed)["velocity"] - 1.0,
            "energy": ledger["energy_error"], "momentum": ledger["momentum_error"], "steps": run.summary["steps"]}


def test_closed(sheet):
    """Closed solutions against values computed independently."""
    for (name, speed), (pressure, free) in KNOWN.items():
        sheet.near(f"closed solution of {name} at {speed} m/s: pressure", METALS[name].shock(speed)["pressure"],
                   1e9 * pressure, 2.0e-6)
        sheet.near(f"closed solution of {name} at {speed} m/s: free surface", METALS[name].released(speed)["velocity"],
                   free, 1.0e-4)


@pytest.mark.parametrize("name, speed", [(name, speed) for name, speeds in SPEEDS.items() for speed in speeds])
def test_bar(options, sheet, name, speed):
    """All rows of the table."""
    metal = METALS[name]
    row, exact = point(options, metal, speed), metal.shock(speed)
    for key, column in (("speed", "shock_speed"), ("pressure", "pressure"), ("density", "density")):
        sheet.near(f"{name} at {speed} m/s, point: {key}", float(row[column]), exact[key], 1.0e-10)
    found = strike(options, metal, speed)
    measured.show(f"{name} {speed}", found)
    strong = speed > 1000
    for key, limit in (("pressure", 0.01 if strong else 0.003), ("density", 0.003 if strong else 0.001),
                       ("speed", 0.01), ("free", 0.01), ("energy", 1.0e-12), ("momentum", 1.0e-13)):
        sheet.below(f"{name} at {speed} m/s, bar: {key}", found[key], limit)
