# SPDX-License-Identifier: BSD-3-Clause
"""Columns of water.

A column of water on a smooth floor is released (J. C. Martin, W. J. Moyce, Phil. Trans. R. Soc. A 244 (1952) 312,
figure 3, height twice the width, as tabulated in pysph/examples/db_exp_data.py of github.com/pypr/pysph). The front
is given in widths of the column at the time t (2 g/width)^0.5. The error is the difference of the two columns that
were measured, 1.125 and 2.25 inches wide, which the equations of a fluid without surface tension and friction of the
floor do not distinguish. Choice of the constants: density and viscosity of water; a sound speed of ten times the
speed of free fall.
"""
import numpy as np

QUANTITIES = {"front": ("front in widths of the column", "1")}
CELLS = 24                             # across the column
LEAST = 0.01                           # depth of water at the front, in widths


def measure(run, shot):
    """End of the layer that is connected with the column."""
    snap, dx = run.snapshots[-1], run.deck["grid"]["dx"]
    width = run.deck["region"]["hi"][0]
    depth = np.bincount((snap["x"] / dx).astype(int), weights=snap["volume"]) / dx
    dry = np.nonzero(np.append(depth, 0.0) < LEAST * width)[0][0]
    last = snap["x"][snap["x"] < dry * dx].max()
    return {"front": last / width}
