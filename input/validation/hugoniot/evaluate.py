# SPDX-License-Identifier: BSD-3-Clause
"""Shocks in metals.

A bar strikes a rigid wall with the particle speed; the speed of the shock into it follows from the momentum that
the wall takes up in the second half of the run. Copper: means of the points of S. P. Marsh, LASL Shock Hugoniot
Data (1980), after github.com/llnl/BALSCD; the error is the scatter of single points about the line of their group.
Aluminium: also points of R. G. McQueen and others (1970) and A. C. Mitchell and others (1981). Other metals: lines
that other authors fitted to their points, without a stated error. Choice of the constants: all presets have
Hugoniots fitted to shocks, that of copper to points of the same laboratory. The rows therefore check that the
equation of state, the strength and the shock of the program give the measured speed, not the constants.
"""
from scree_post.validation import shock_from_wall

SUBJECT = "metals"
QUANTITIES = {"shock": ("speed of the shock", "m/s")}
CELLS = 200                            # along the bar


def measure(run, shot):
    """The speed from the momentum that the wall takes up."""
    return {"shock": shock_from_wall(run)}
