# SPDX-License-Identifier: BSD-3-Clause
"""Cylinders around explosives.

A steel cylinder around a charge; a thin slice across it, whose charge burns at once. The greatest mean radial speed
is compared with that of R. W. Gurney (BRL report 405, 1943) for cylinders, with the energy (2 E)^0.5 of 2.70 km/s of
composition B, 2.44 of TNT and 2.90 of PBX 9404 that measured speeds of plates and cylinders gave. His formula assumes
products of uniform density and a wall without strength. Choice of the constants: the products of the presets were
fitted to expanding copper cylinders, so the rows are a consistency check. The run has no failure: real cylinders of
steel break at about twice their radius.
"""
SUBJECT = "impacts"
QUANTITIES = {"speed": ("speed of the wall", "m/s")}
CELLS = 60                             # on the radius of the charge


def measure(run, shot):
    """Greatest mean radial velocity."""
    return {"speed": run.tables["gauge"]["velocity_x"].max()}
