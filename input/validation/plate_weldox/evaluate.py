# SPDX-License-Identifier: BSD-3-Clause
"""Plates of steel that are perforated.

Hard steel projectiles of 20 mm perforate plates of steel Weldox 460 E, 12 mm thick. Axisymmetric; the projectile
stays elastic and slides on the plate; the plate of the run is free at a radius of 100 mm, that of the experiment was
clamped. *Limit* is the ballistic limit after R. F. Recht and T. W. Ipson (1963): of the residual speed of one shot
above it, with the mass of a plug that has the diameter of the projectile. Choice of the constants: law and failure
of Johnson and Cook of Boervik and others (2002, part II), fitted to tension tests of smooth and notched bars, as
quoted in a public deck of OpenRadioss (GitHub); Hugoniot of steel 4340. Nothing was fitted to these shots.
"""
import numpy as np

SUBJECT = "impacts"
QUANTITIES = {"limit": ("ballistic limit", "m/s")}
CELLS = 10                             # through the plate
COARSER = 10.0 / 7.0
PLUG = 7850.0 * np.pi * 0.01**2 * 0.012


def measure(run, shot):
    """Limit by the balance of energy of projectile and plug, which leave with the same speed."""
    bullet = run.tables["bullet_history"]
    start, end = -bullet["velocity_z"].iloc[0], -bullet["velocity_z"].iloc[-1]
    return {"limit": np.sqrt(max(start**2 - ((1.0 + PLUG / bullet["mass"].iloc[0]) * end)**2, 0.0))}
