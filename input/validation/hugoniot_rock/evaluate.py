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
SUBJECT = "brittle"
QUANTITIES = {"shock": ("speed of the shock", "m/s")}
CELLS = 200                            # along the bar


def measure(run, shot):
    """The momentum between the second and the third snapshot."""
    before, after = run.snapshots[1], run.snapshots[2]
    gained = [(snap["mass"] * snap["velocity"][:, 0]).sum() for snap in (before, after)]
    mass, grid, speed = after["mass"].sum(), run.deck["grid"], -run.deck["body"]["velocity"][0]
    return {"shock": grid["hi"][0] * (gained[1] - gained[0]) / (mass * speed * (after.time - before.time))}
