# SPDX-License-Identifier: BSD-3-Clause
"""Shocks in marble, gabbro and water.

A bar strikes a rigid wall with the particle speed; the speed of the shock follows from the momentum that the wall
takes up in the second half of the run. Marble and gabbro: lines of Q. B. Zhang and others, Phil. Trans. R. Soc. A 375
(2017) 20160169, read in its abstract, through plate impacts of 1.5 to 12 GPa, whose scatter was not read. Water: the
line of M. A. Meyers (1994), read in github.com/Jake-Diamond-9/shock_calculations, and above 3 km/s a curve through
the points of the shock wave database, read in github.com/ImpactsWiki/impedance-match-app; the error is the difference
of the two at 1 km/s. Choice of the constants: Tillotson of limestone, gabbroic anorthosite and water of
github.com/LLNL/spheral (MaterialPropertiesLib.py, H. J. Melosh 1989), at their density; they were not fitted to these
lines, but those of water to older points of the same kind. Without strength, because none was read for these rocks.
"""
from scree_post.validation import shock_from_wall

SUBJECT = "brittle"
QUANTITIES = {"shock": ("speed of the shock", "m/s")}
CELLS = 200                            # along the bar


def measure(run, shot):
    """The speed from the momentum that the wall takes up."""
    return {"shock": shock_from_wall(run)}
