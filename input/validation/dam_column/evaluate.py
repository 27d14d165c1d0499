# SPDX-License-Identifier: BSD-3-Clause
"""Water against a column.

Water, 0.3 m high and 0.4 m long, is released by a gate in a tank of 1.6 by 0.61 m, runs over a floor with 10 mm of
water and strikes a square column of 0.12 m, 0.5 m from the gate. Horizontal force on the column: H. Yeh, C. Petroff
(University of Washington), as digitised in pysph/examples/db_exp_data.py of github.com/pypr/pysph, without a stated
error; the dimensions are from a script beside it. The run is one half of the tank, and the water on the floor is half
a cell deep. Choice of the constants: density and viscosity of water; a sound speed of ten times the speed of free
fall. The run releases the water at once, so that it arrives 0.045 s too early. With a gate that rises at 2 m/s, a
choice, since the motion of the gate is not known, it arrives at 0.360 s, and the four forces are 48, 22, 18 and 10 N
(4 cells in the width of the column; released at once 30, 24, 17 and 8 N). So the arrival is that of the gate; the
impact depends on the cells, because the water in front of the gate is thinner than a cell.
"""
from scree_post.validation import first_above, mean_forces

SUBJECT = "water"
WINDOWS = {"impact": (0.38, 0.44), "first": (0.5, 0.7), "second": (0.7, 0.9), "third": (0.9, 1.1)}
QUANTITIES = {"arrival": ("time at which the force exceeds 8 N", "s")} | {
    name: (f"force on the column, {start:g} to {end:g} s", "N") for name, (start, end) in WINDOWS.items()}
CELLS = 6                              # in the width of the column
COARSER = 1.5


def measure(run, shot):
    """Arrival and mean forces from the impulse on the half of the column."""
    table = run.tables["forces"]
    time, impulse = table["time"].to_numpy(), 2.0 * table["column_impulse_x"].to_numpy()
    return {"arrival": first_above(time, impulse, 8.0)} | mean_forces(time, impulse, WINDOWS)
