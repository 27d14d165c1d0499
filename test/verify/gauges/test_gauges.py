# SPDX-License-Identifier: BSD-3-Clause
# tiers: smoke, full
"""Gauges: a flyer meets a plate that breaks, recorded by instruments and by snapshots.

Would catch a gauge that follows another particle after particles are sorted or ranks exchange them, rows that a
restart leaves out or writes twice, values that depend on ranks, a surface that is not the free one, and a value at a
point that is the mean of its surroundings where the field has a slope.
"""

import numpy as np

import case

DENSITY, SOUND, THICK, SPEED = 2703.0, 6400.0, 2.0e-3, 20.0
CELL = THICK / 40
DECK = f"""
&run  dimension='1d' /
&grid  lo=-1e-3,0,0  hi=7e-3,1,1  dx={CELL!r} /
&time  t_end={6 * THICK / SOUND!r} /
&effects  strength=.false.  damage=.true. /
&material  name='flyer'  density={DENSITY}  bulk={DENSITY * SOUND**2!r} /
&material  name='plate'  density={DENSITY}  bulk={DENSITY * SOUND**2!r}  spall={0.3 * DENSITY * SOUND * SPEED!r} /
&region  name='flyer'  shape='box'  lo=0,0,0  hi=2e-3,1,1 /
&region  name='plate'  shape='box'  lo=2e-3,0,0  hi=6e-3,1,1 /
&body  name='flyer'  region='flyer'  material='flyer'  ppc=4,1,1  velocity={SPEED},0,0 /
&body  name='plate'  region='plate'  material='plate'  ppc=4,1,1 /
&output  name='p'  kind='particles'  every=10  precision='double'  fields='identity','velocity','stress' /
&output  name='rear'    kind='gauge'  gauge='particle'  point=6e-3,0,0  every=1  fields='velocity','stress' /
&output  name='laser'   kind='gauge'  gauge='surface'  side='+x'  point=0,0,0  every=1  fields='velocity' /
&output  name='inside'  kind='gauge'  point=4e-3,0,0  every=1  fields='velocity','density' /
&output  name='plate'   kind='gauge'  gauge='mean'  bodies='plate'  every=1  fields='velocity' /
"""
GAUGES = ("gauge", "laser_gauge", "inside_gauge", "plate_gauge")
# A bar that expands uniformly: the velocity is linear, and a gauge off the centre must give its exact value.
SLOPE = """
&run  dimension='plane_strain' /
&grid  lo=0,0,0  hi=1,1,1  dx=0.05 /
&time  t_end=1e-9 /
&material  name='m'  density=1000  bulk=1e9  shear=1e8 /
&region  name='r'  shape='box'  lo=0.2,0,0.2  hi=0.8,1,0.8 /
&body  name='b'  region='r'  material='m'  velocity_formula='3*x - 2*z + 1', '0', '5*z + x' /
&output  name='g'  kind='gauge'  point=0.437,0.5,0.511  every=1  fields='velocity' /
&output  name='s'  kind='gauge'  gauge='surface'  side='-z'  point=0.437,0.5,0  every=1  fields='velocity' /
"""


def table(run, name):
    """Columns of a gauge."""
    return np.genfromtxt(run.path(f"_{name}.csv"), delimiter=",", names=True, deletechars="", replace_space=" ")


def test_plate(options, sheet):
    """The plate on one rank, on several, and stopped in between."""
    one = case.Case(options, "plate", DECK).run("-q")
    rear, laser = table(one, "gauge"), table(one, "laser_gauge")
    snapshots = one.snapshots()
    number = snapshots[0][1].fields["identity"][np.argmax(snapshots[0][1].points[:, 0])]
    seen = {round(time, 15): snap for time, snap in snapshots}
    compared = 0
    for row in rear:
        snap = seen.get(round(row["time [s]"], 15))
        if snap is None:
            continue
        at = np.flatnonzero(snap.fields["identity"] == number)[0]
        sheet.require(row["velocity_x [m/s]"] == snap.fields["velocity"][at, 0], "velocity of the snapshot")
        sheet.require(row["stress_xx [Pa]"] == snap.fields["stress"][at, 0], "stress of the snapshot")
        compared += 1
    sheet.require(compared > 20, f"{compared} rows at the times of snapshots")
    # pull-back: the surface reaches V and decreases by 2 s/(rho c) before the break is visible
    time, speed = laser["time [s]"] * SOUND / THICK, laser["velocity_x [m/s]"] / SPEED
    plateau = speed[(time > 2.4) & (time < 3.6)].mean()
    fallen = speed[(time > 4.0) & (time < 4.6)].min()
    sheet.below("plateau of the surface over that of the flyer, less 1", plateau - 1.0, 0.01)
    # a rectangular pulse breaks at once: the tension is that of two cells, as in test_flyer
    sheet.require(fallen > 0.2, f"the surface does not come to rest, as the plate breaks: {fallen}")
    inside = table(one, "inside_gauge")
    # a single row is in the ringing behind the front
    within = abs(inside["time [s]"] * SOUND / THICK - 1.5) < 0.3
    sheet.near("mean velocity at a fixed point in the pulse", inside["velocity_x [m/s]"][within].mean(), 0.5 * SPEED,
               0.01)
    mean = table(one, "plate_gauge")
    at = np.argmin(abs(mean["time [s]"] * SOUND / THICK - 1.0))
    sheet.near("mean velocity of the plate: impulse over mass", mean["velocity_x [m/s]"][at], 0.5 * SPEED / 2, 0.03)
    bits(options, sheet, one)


def bits(options, sheet, one):
    """The same bytes on two ranks, and with a restart that omits no row."""
    two = case.Case(options, "two", DECK, ranks=2)
    two.name = "plate"
    two.run("-q", "--case", "plate")
    part = case.Case(options, "part", DECK)
    part.name = "plate"
    part.run("-q", "--case", "plate", "--set", "time.t_end=1e-6")
    part.run("-q", "--case", "plate", "--restart")
    for name in GAUGES:
        text = one.path(f"_{name}.csv").read_bytes()
        steps = np.atleast_1d(table(one, name)["step"])
        sheet.require(np.array_equal(steps, np.arange(len(steps))), f"{name}: a row each step, {len(steps)}")
        sheet.require(two.path(f"_{name}.csv").read_bytes() == text, f"{name}: two ranks write the same bytes")
        again = np.atleast_1d(table(part, name)["step"])
        sheet.require(np.array_equal(again, np.arange(len(again))), f"{name}: a restart writes each row once")


def test_slope(options, sheet):
    """Linear fields are reproduced exactly, inside and at a surface."""
    run = case.Case(options, "slope", SLOPE).run("-q")
    inside, below = np.atleast_1d(table(run, "gauge"))[0], np.atleast_1d(table(run, "s_gauge"))[0]
    sheet.near("x velocity inside", inside["velocity_x [m/s]"], 3 * 0.437 - 2 * 0.511 + 1, 1e-13)
    sheet.near("z velocity inside", inside["velocity_z [m/s]"], 5 * 0.511 + 0.437, 1e-13)
    sheet.near("place of the surface", below["z [m]"], 0.2, 1e-13)
    sheet.near("x velocity at the surface", below["velocity_x [m/s]"], 3 * 0.437 - 2 * 0.2 + 1, 1e-12)
    sheet.near("z velocity at the surface", below["velocity_z [m/s]"], 5 * 0.2 + 0.437, 1e-12)
