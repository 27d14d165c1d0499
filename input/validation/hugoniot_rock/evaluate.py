# SPDX-License-Identifier: BSD-3-Clause
"""Shocks in basalt and ice.

A bar strikes a rigid wall with the particle speed; the speed of the shock follows from the momentum that the wall
takes up in the second half of the run, as for [metals](validation_metals.md#shocks-in-metals). Basalt: means of
groups of points of M. van Thiel, UCRL-50108 (1977), and S. Nakazawa and others, Planet. Space Sci. 45 (1997) 1489, in
the shock wave database of github.com/ImpactsWiki/impedance-match-app (IHED-635, IHED-636); the error is their scatter
about the line of the group. Ice: the line of S. T. Stewart and T. J. Ahrens (2005) there, without a stated error.
Choice of the constants: Tillotson of W. Benz and E. Asphaug (1999) in github.com/christophmschaefer/miluphcuda, with
the yield stress of basalt of [a scene](../../input/blast_cavity/README.md); they were not fitted to these points. The
density is that of the constants, 1 % above that of the first basalt and 6 % below that of Vacaville. The exact
Hugoniot of the constants without strength, 6807 m/s at 2307 m/s and 5416 m/s in ice at 2000 m/s, agrees with the runs
to 3 %, so the constants deviate, not the solution.
"""
from scree_post.validation import shock_from_wall

SUBJECT = "brittle"
QUANTITIES = {"shock": ("speed of the shock", "m/s")}
CELLS = 200                            # along the bar


def measure(run, shot):
    """The speed from the momentum that the wall takes up."""
    return {"shock": shock_from_wall(run)}
