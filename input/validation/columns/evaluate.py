# SPDX-License-Identifier: BSD-3-Clause
"""Columns of grains.

A plane column of grains on a rough floor is released. Glass beads: laws of E. Lajeunesse and others (2005), as cited
by P.-Y. Lagree, L. Staron, S. Popinet, J. Fluid Mech. 686 (2011) 378. Sand: laws of G. Lube and others, Phys. Rev. E
72 (2005) 041301, whose prefactors scatter by 15 %. *a* is height over half width; run-out and height are in half
widths. Choice of the constants: mu(I) of the preset `glass_beads` from flows on an incline (Jop and others 2006),
friction of the preset `sand_dry` from triaxial tests (Laine 2001); neither from columns. Bulk moduli are softened to
a hundred times the weight on the base. The page on [flows of grains](verification_granular.md) has an angle that was
fitted to columns.
"""
import numpy as np

QUANTITIES = {"runout": ("run-out", "1"), "height": ("height in the middle", "1")}
CELLS = 20                             # on half of the column
LEAST = 0.02                           # depth at the front over the square root of half of the cross-section


def measure(run, shot):
    """Where the deposit ends, and its top at the mirror plane."""
    snap, dx = run.snapshots[-1], run.deck["grid"]["dx"]
    half, _, height = run.deck["region"]["hi"]
    depth = np.bincount((snap["x"] / dx).astype(int), weights=snap["volume"]) / dx
    thin = np.nonzero(np.append(depth, 0.0) < LEAST * np.sqrt(half * height))[0][0]
    return {"runout": thin * dx / half - 1.0, "height": snap["z"][snap["x"] < 0.2 * half].max() / half}
