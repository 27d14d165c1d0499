# SPDX-License-Identifier: BSD-3-Clause
"""Shells around explosives.

A spherical steel shell around a charge that is ignited at its centre. Axisymmetric: a quarter of the section. The
speed is that of the kinetic energy of the shell at its greatest, compared with that of R. W. Gurney (BRL report 405,
1943) for spheres, with energies that measured speeds of plates and cylinders gave; his formula assumes products of
uniform density and a shell without strength. Choice of the constants: the products of the presets (LLNL Explosives
Handbook, 1985) were fitted to expanding copper cylinders, so the rows are a consistency check of other explosives and
another shape. The run has no failure: real shells of steel break at about twice their radius.
"""
import numpy as np

SUBJECT = "impacts"
QUANTITIES = {"speed": ("speed of the shell", "m/s")}
CELLS = 40                             # on the radius of the charge


def measure(run, shot):
    """Speed of the greatest kinetic energy."""
    shell = run.tables["shell_history"]
    return {"speed": np.sqrt(2.0 * shell["kinetic"] / shell["mass"]).max()}
