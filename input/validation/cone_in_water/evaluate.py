# SPDX-License-Identifier: BSD-3-Clause
"""Cones that fall into water.

A smooth rigid cone of 52 mm in diameter, followed by a cylinder, falls into water. Force: acceleration measured on
the body times its mass, data of B. Boom and others (github.com/Illimited-Lab/TwoBodyConeImpactData, 2025; paper arXiv
2403.13262), radius and masses from ConeImpact.py there, for their rigid connection of nose and body; 5 or 6 drops
each, whose standard deviation is the error. The angle is that between the axis and the side. Measured and computed
forces are means over 0.3 of the time in which the tip goes under, and the greatest of these. The cone strikes with
the speed of free fall, which the length of the weightless part of the records confirms to 1 %; the body of the run is
shorter and has the mass of the real one. Choice of the constants: density of water, a sound speed of 15 times the
speed, no friction. Forces are 16 to 28 % too great and the reason is not known; with `stress_update = 'usl'` they are
9 to 27 % too great. A [wedge](#a-wedge-that-falls-into-water) and [cylinders](#cylinders-that-fall-into-water) with
the same contact agree with boundary elements, so a common factor, such as the mass that the accelerometer feels, is
likelier than the contact. With `usl`, at 45 degrees and 1 m, the square root of the force grows at the measured rate
while the tip goes under (1.03 N^0.5/ms), but 0.5 ms earlier, as if the cone were 2 mm larger, with 16 and with 24
cells. `mpm` with `gimp`, twice the sound speed, a pool 1.8 times as wide, a limit of 10 Pa on the tension of the
water, or a rigid region with the speed of impact instead of a body with contact give 26.7 to 28.3 N there, so these
are not the reason.
"""
import numpy as np

SUBJECT = "fluids"
QUANTITIES = {"force": ("greatest force of the water", "N")}
CELLS = 24                             # in the radius of the cone
COARSER = 1.5
WINDOW = 0.3                           # time over which a force is averaged, in times the tip takes to go under


def measure(run, shot):
    """The greatest force on the cone, from its momentum."""
    table, gravity = run.tables["motion_history"], -run.deck["effects"]["gravity_vector"][2]
    time, speed = table["time"].to_numpy(), table["velocity_z"].to_numpy()
    window = WINDOW * time[-1] / 1.6
    start = np.linspace(0.0, time[-1] - window, 200)
    gain = (np.interp(start + window, time, speed) - np.interp(start, time, speed)) / window
    return {"force": table["mass"].iloc[0] * (gain + gravity).max()}
