# SPDX-License-Identifier: BSD-3-Clause
"""A wedge that falls into water.

A symmetric wedge 1.2 m wide with sides inclined by 25 degrees falls into water. Plane strain. Speed against time of
M. D. Yettou and others (2006), as digitised in github.com/dineshadepu/02_particles_dispersion (the file of code/
sun_2015_2d_water_wedge_entry for the experiment), without a stated error; width, angle, speed, depth and width of the
pool and a mass of 94 kg/m from the script beside it. The length of the wedge was not read, so its mass per length is
uncertain: with 78 kg/m the speeds are 4.05, 2.80 and 1.91 m/s (24 cells). Choice of the constants: density of water,
a sound speed of 15 times the speed, no friction. A boundary element method for plane flow of Zhao and Faltinsen
(1993), in the same folder, gives 3.96, 2.79 and 2.14 m/s, thus also a greater speed at 20 ms than measured.
"""
import numpy as np

SUBJECT = "fluids"
QUANTITIES = {f"speed_{time}": (f"speed after {time} ms", "m/s") for time in (10, 20, 30)}
CELLS = 40                             # on half of the width
COARSER = 1.5


def measure(run, shot):
    """Speeds of the wedge."""
    table = run.tables["motion_history"]
    return {name: -np.interp(float(name.partition("_")[2]), 1.0e3 * table["time"], table["velocity_z"])
            for name in QUANTITIES}
