# SPDX-License-Identifier: BSD-3-Clause
"""Water behind a gate.

A column of water, 600 mm high and wide, is released by a gate that is lifted, and runs along the floor to a wall 1.01
m from the gate: L. Lobovsky and others, J. Fluids Struct. 48 (2014) 407, figure 12, whose points are read in
scripts/fluid-gates/lib/s34metrics.mjs of github.com/Marreonline0201/universe-status (drawing of arXiv 1308.0115),
without a stated error; the gate rose with a median speed of 4.53 m/s. T = t (g/height)^0.5 after its first motion.
The gate of the run rises at this speed from the start, as a rigid region without friction. Choice of the constants:
density and viscosity of water; a sound speed of ten times the speed of free fall. From T = 1 the front is where it was
measured. Without the gate it is at 1.35 and 1.67 instead of 1.26 and 1.56 at T = 1.3 and 1.5 (40 cells), 6 to 7 % too
far: this is the cause of a part of the deviation of [columns released at once](#columns-of-water). At first the
measured tip is farther: a sheet thinner than a cell leaves under the rising gate.
"""
import numpy as np

SUBJECT = "water"
QUANTITIES = {f"front_{round(10 * time)}": (f"front in heights at T = {time}", "1")
              for time in (0.4, 0.7, 1.0, 1.3, 1.5)}
CELLS = 60                             # in the height of the column
COARSER = 1.5
LEAST = 0.01                           # depth of water at the front, in heights


def tip(snap, dx, height):
    """End of the layer that is connected with the column, from the gate, in heights."""
    depth = np.bincount((snap["x"] / dx + height / dx + 1e-9).astype(int), weights=snap["volume"]) / dx
    dry = np.nonzero(np.append(depth, 0.0) < LEAST * height)[0][0]
    return snap["x"][snap["x"] < dry * dx - height].max() / height


def measure(run, shot):
    """Fronts at the times of the quantities."""
    dx, height = run.deck["grid"]["dx"], -run.deck["grid"]["lo"][0]
    clock = np.sqrt(height / 9.81)
    fronts = [(snap.time / clock, tip(snap, dx, height)) for snap in run.snapshots]
    time, place = np.array(fronts).T
    return {name: np.interp(float(name.partition("_")[2]) / 10.0, time, place) for name in QUANTITIES}
