# SPDX-License-Identifier: BSD-3-Clause
"""The blast wave of the Trinity test.

Radius of the ball of fire against time, from photographs of the nuclear explosion of 16 July 1945: G. I. Taylor,
Proc. R. Soc. A 201 (1950) 175, table 1, as tabulated in taylor-fireball.py of github.com/floquet/jop. The run
releases 25 kt (1.046e14 J, stated to 8 %, which is 1.6 % of the radius; Wikipedia, Trinity (nuclear test)) in a
sphere of air of 0.15 of the radius, 30.48 m above a rigid ground (the tower of 100 feet). Density and pressure of the
air: 1.01 kg/m3 from the 852 mbar and 20 C that were measured there at the time of the test. Nothing was fitted to the
radii. Air is an ideal gas of an exponent of 1.4, but at these temperatures it dissociates and is ionised, which
lowers the exponent; Taylor found his energy from the same radii and with 1.4, so that his value cannot be used here.
With an exponent of 1.2 the radius at 1.93 ms would be 48.6 m and that at 62 ms 210 m: this change of the gas explains
the early rows. Later the ball of fire has radiated a part of its energy.
"""
import numpy as np

SUBJECT = "fluids"
QUANTITIES = {"radius": ("radius of the front", "m")}
CELLS = 40                             # in the radius of the front
COARSER = 1.5


def measure(run, shot):
    """Distance of the front from the source, mean over directions from horizontal to upwards."""
    snap, dx, height = run.snapshots[-1], run.deck["grid"]["dx"], run.deck["region"][0]["centre"][2]
    x, z = snap["x"], snap["z"] - height
    radius, up = np.hypot(x, z), np.arctan2(z, x)
    speed = (snap["velocity_x"] * x + snap["velocity_z"] * z) / np.maximum(radius, dx)
    fronts = []
    for first in np.linspace(0.0, 0.5 * np.pi, 7)[:-1]:
        own = (up >= first) & (up < first + np.pi / 12.0)
        bins = (radius[own] / (0.5 * dx)).astype(int)
        mass = np.bincount(bins, weights=snap["mass"][own])
        mean = np.bincount(bins, weights=(snap["mass"] * speed)[own]) / np.maximum(mass, 1e-300)
        last = np.nonzero(mean > 0.5 * mean[len(mean) // 4:].max())[0][-1]
        fronts.append(0.5 * dx * (last + 1))
    return {"radius": np.mean(fronts)}
