# SPDX-License-Identifier: BSD-3-Clause
"""Water that strikes a wall.

A column of water, 300 mm high and 600 mm wide, is released by a gate, runs 1.01 m along the floor and strikes the
wall at the end of the tank: L. Lobovsky and others, J. Fluids Struct. 48 (2014) 407, with the pressures at three
sensors over the height of the column, 3, 30 and 80 mm above the floor, as digitised in pysph/examples/db_exp_data.py
of github.com/pypr/pysph, without a stated error. Their time is T = t (g/height)^0.5 after the first motion of the
gate, whose speed is that of the [higher column](#water-behind-a-gate). Pressures are means over a time, divided by
density, g and height; those of the run follow from the forces on strips of the wall around the sensors. Choice of the
constants: density and viscosity of water; a sound speed of ten times the speed of free fall. The water arrives in
time, without the gate 0.08 earlier. Later the measured pressures are nearly equal at the three sensors, while that of
the run falls with the height: the sheet that arrives is 50 mm deep with 2.0 m/s. A steady sheet of this depth and
speed, without gravity, gives 0.95 to 1.0 of its stagnation pressure in the corner and a force of 1.02 times its
momentum (cells of 5 mm), so the pressures of a given sheet are right. With 30 cells the pressures from T = 3.5 are
1.05, 0.94 and 0.27; `bbar`, `usl`, `mpm` with `gimp`, twice the sound speed and a wall from which water can separate
change the first by at most 3 %. On a floor that sticks, with a boundary layer of a cell, the water arrives at 2.73,
and they are 0.25, 0.56 and 0.40: friction, which the run has not, moves the pressure upwards, but finer cells make
this effect smaller, so that the reason is not known.
"""
import numpy as np

from scree_post.validation import first_above, mean_forces

SUBJECT = "water"
WINDOWS = {"p1_impact": (2.5, 2.7), "p1_early": (3.0, 3.5), "p1_late": (3.5, 4.5), "p3_impact": (2.7, 3.0),
           "p3_early": (3.0, 3.5), "p3_late": (3.5, 4.5), "p4_early": (3.0, 3.5), "p4_late": (3.5, 4.5)}
PLACES = {"p1": "3 mm", "p3": "30 mm", "p4": "80 mm"}
QUANTITIES = {"arrival": ("T at which the pressure at 3 mm exceeds 0.25", "1")} | {
    name: (f"pressure at {PLACES[name[:2]]}, T = {start} to {end}", "1") for name, (start, end) in WINDOWS.items()}
CELLS = 50                             # in the height of the column
COARSER = 5 / 3


def measure(run, shot):
    """Arrival and mean pressures from the impulses on strips of the wall."""
    table, dx, height = run.tables["forces"], run.deck["grid"]["dx"], -0.5 * run.deck["grid"]["lo"][0]
    clock, unit = np.sqrt(height / 9.81), 1000.0 * 9.81 * height
    nodes, time = dx * np.arange(round(height / dx)), table["time"].to_numpy() / clock
    impulse = {}
    for region in run.deck["region"]:
        if region["name"] in PLACES:
            inside = nodes[(nodes >= region["lo"][2] - 1e-9) & (nodes <= region["hi"][2])]
            area = dx * (len(inside) - 0.5 * (inside[0] == 0.0))
            impulse[region["name"]] = table[f"{region['name']}_impulse_x"].to_numpy() / (area * clock * unit)
    found = {"arrival": first_above(time, impulse["p1"], 0.25)}
    for sensor, values in impulse.items():
        found |= mean_forces(time, values, {name: span for name, span in WINDOWS.items() if name.startswith(sensor)})
    return found
