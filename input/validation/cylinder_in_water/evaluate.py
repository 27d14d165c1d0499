# SPDX-License-Identifier: BSD-3-Clause
"""Cylinders that fall into water.

A circular cylinder of 110 mm falls 0.5 m and enters water, with its axis level. Plane strain. Depth against time of
M. Greenhow, W. M. Lin (1983), as digitised in github.com/dineshadepu/02_particles_dispersion (files sun_2018_falling_
in code), without a stated error; diameter, speed of 2.955 m/s and pool of 0.3 by 1 m from a script beside them. T = t
(g/diameter)^0.5 after the first contact. Of the cylinder as dense as water the first three points lie beyond free
fall at this speed, so that its zero of time is not known, and its row is not comparable. Choice of the constants:
density of water, a sound speed of 12 times the speed, no friction. A boundary element method in the same folder gives
0.46, 0.61, 1.09 and 1.37 for the lighter and 1.51 and 1.80 for the denser cylinder at these times.
"""
import numpy as np

SUBJECT = "fluids"
QUANTITIES = {f"depth_{time}": (f"depth in diameters at T = {0.001 * time:.3f}", "1")
              for time in (277, 378, 797, 843, 1032, 1131)}
CELLS = 14                             # on the radius
COARSER = 1.5


def measure(run, shot):
    """Way of the cylinder after it touches the water."""
    table, diameter = run.tables["motion_history"], 2.0 * run.deck["region"][1]["radius"]
    clock = np.sqrt(diameter / 9.81)
    way = (table["centre_z"].iloc[0] - table["centre_z"]) / diameter
    return {name: np.interp(0.001 * float(name.partition("_")[2]), table["time"] / clock, way) for name in QUANTITIES}
