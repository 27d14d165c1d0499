# SPDX-License-Identifier: BSD-3-Clause
"""Columns of grains.

A plane or round column of grains is released on a rough floor. Glass beads: laws of E. Lajeunesse and others (2005),
as cited by P.-Y. Lagree, L. Staron, S. Popinet, J. Fluid Mech. 686 (2011) 378. Sand: laws of G. Lube and others,
plane columns Phys. Rev. E 72 (2005) 041301, round ones J. Fluid Mech. 508 (2004) 175; their prefactors scatter by 15
%. *a* is height over half width or radius, by which run-out and height are divided. Choice of the constants: mu(I) of
the preset `glass_beads` from flows on an incline (Jop and others 2006), friction of the preset `sand_dry` from
triaxial tests (Laine 2001); neither from columns. The cone of `sand_dry` goes through triaxial compression, where its
angle was measured, and is stronger than the surface of Mohr and Coulomb of this angle in other directions; with that
surface (`material.strength_model = 'mohr_coulomb'`) the run-outs of the sand rows in their order are 1.70, 5.22, 1.33
and 3.69, so the measured ones lie between the two in all four. Bulk moduli are softened to a hundred times the weight
on the base. The page on [flows of grains](verification_granular.md) has an angle that was fitted to columns.
"""
import numpy as np

SUBJECT = "grains"
QUANTITIES = {"runout": ("run-out", "1"), "height": ("height in the middle", "1")}
CELLS = 40                             # on half of the column
COARSER = 1.5
LEAST = 0.02                           # depth at the front over the square root of half of the cross-section


def measure(run, shot):
    """Where the deposit ends, and its top at the mirror plane."""
    snap, dx = run.snapshots[-1], run.deck["grid"]["dx"]
    half, _, height = run.deck["region"]["hi"]
    depth = np.bincount((snap["x"] / dx).astype(int), weights=snap["volume"]) / dx
    if run.deck["run"]["dimension"] == "axisymmetric":
        depth /= 2.0 * np.pi * dx * (np.arange(len(depth)) + 0.5)
    least, depth = LEAST * np.sqrt(half * height), np.append(depth, 0.0)
    thin = np.nonzero(depth < least)[0][0]
    end = dx * (thin - 0.5 + (depth[thin - 1] - least) / (depth[thin - 1] - depth[thin]))
    top = snap["z"][snap["x"] < 0.2 * half].max() + 0.25 * dx          # two particles in the height of a cell
    return {"runout": end / half - 1.0, "height": top / half}
