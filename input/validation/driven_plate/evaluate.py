# SPDX-License-Identifier: BSD-3-Clause
"""Plates on explosives.

A steel plate on a slab of composition B, in one dimension, ignited at its free face. The speed is compared with that
of R. W. Gurney (BRL report 405, 1943) for an open charge, with the energy (2 E)^0.5 = 2.70 km/s that measured speeds
of plates and cylinders gave. Its formula assumes products of uniform density and is thus a limit rather than a shot.
Choice of the constants: the products of the preset `comp_b` (LLNL Explosives Handbook, 1985) were fitted to expanding
cylinders, not to plates.
"""
SUBJECT = "impacts"
QUANTITIES = {"speed": ("speed of the plate", "m/s")}
CELLS = 100                            # in the explosive


def measure(run, shot):
    """Mean velocity of the plate at the end."""
    return {"speed": run.tables["motion_history"]["velocity_x"].iloc[-1]}
