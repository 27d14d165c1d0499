# SPDX-License-Identifier: BSD-3-Clause
# tiers: smoke
"""Each data set of a snapshot states its unit, and the powers of length, mass, time and temperature in it.

Would catch a field whose unit is missing in a list, so that its powers are zero, and powers in another order.
"""

import re

import h5py
import numpy as np

import case

DECK = """
&run  dimension='3d' /
&grid  lo=0,0,0  hi=4,4,4  dx=1 /
&time  t_end=1  max_steps=1 /
&effects  damage=.true.  thermal=.true.  size_scatter=.true. /
&material  name='m'  density=1000  shear=5e6  eos_model='mie_gruneisen'  mg_c0=100  mg_s=1.4  mg_gamma=2
  strength_model='von_mises'  yield=1e5  specific_heat=500
  damage_model='principal_stress'  failure_stress=1e5  weibull_m=7  weibull_volume=1 /
&region  name='r'  shape='box'  lo=1,1,1  hi=3,3,3 /
&body  name='b'  region='r'  material='m'  velocity=1,0,0 /
&output  name='p'  kind='particles'  every=1  fields='default','state','density','speed','pressure','mises','scatter' /
&output  name='g'  kind='grid'  every=1 /
&checkpoint  at_end=.false. /
"""
BASE = {"m": (1, 0, 0, 0), "kg": (0, 1, 0, 0), "s": (0, 0, 1, 0), "K": (0, 0, 0, 1), "N": (1, 1, -2, 0),
        "J": (2, 1, -2, 0), "W": (2, 1, -3, 0), "Pa": (-1, 1, -2, 0), "1": (0, 0, 0, 0), "deg": (0, 0, 0, 0)}


def powers(unit):
    """Powers of length, mass, time, current, temperature, amount and light."""
    total, side = np.zeros(4), 1
    for slash, symbol, power in re.findall(r"(/)|([A-Za-z]+|\b1\b)(-?\d*)", unit):
        side = -1 if slash else side
        if symbol:
            total += side * int(power or 1) * np.array(BASE[symbol])
    return [*total[:3].astype(int), 0, int(total[3]), 0, 0]


def test_unit_powers(options, sheet):
    """All data sets of particles and of the grid."""
    assert powers("kg/m3") == [-3, 1, 0, 0, 0, 0, 0] and powers("J/(kg K)") == [2, 0, -2, 0, -1, 0, 0]
    run = case.Case(options, "powers", DECK).run("--quiet")
    units, seen = set(), 0

    def check(name, item):
        nonlocal seen
        if isinstance(item, h5py.Dataset) and "unitDimension" in item.attrs:
            unit = item.attrs["units"]
            unit = unit.decode() if isinstance(unit, bytes) else str(unit)
            units.add(unit)
            seen += 1
            sheet.require(list(item.attrs["unitDimension"]) == powers(unit),
                          f"{name} [{unit}]: {list(item.attrs['unitDimension'])}, not {powers(unit)}")

    for path in sorted(run.folder.glob("*_00000*.hdf")):
        with h5py.File(path) as file:
            file.visititems(check)
    sheet.require(seen > 20 and {"m/s", "Pa", "kg", "m3", "K", "J/kg", "kg/m3"} <= units, f"{seen} data sets, {units}")
