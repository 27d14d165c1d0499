# SPDX-License-Identifier: BSD-3-Clause
"""Speed and turn of a plate that an explosive drives, against the formulas of Gurney and Taylor.

    python input/driven_plate/measure.py --scree build/bin/scree
"""
import sys
from pathlib import Path

import numpy as np

sys.path[:0] = [str(Path(__file__).resolve().parents[2] / folder) for folder in ("scripts", "python/src")]
from scree_post import panel     # noqa: E402
from scree_scene import Study, Table   # noqa: E402

SPEED, GURNEY = 7980.0, 2700.0         # of the detonation and of Gurney, composition B [m/s]
RATIO = 7810.0 * 5.0 / (1717.0 * 20.0)  # mass of plate over that of explosive
PLATE = 2                              # its number in the field material
PLACES = (0.030, 0.050, 0.070)         # along the plate [m]
NAMES = {"along": "along the plate", "across": "all of its face at once"}


def gurney():
    """Speed of a plate on an open charge [m/s]."""
    return GURNEY / np.sqrt(((1.0 + 2.0 * RATIO) ** 3 + 1.0) / (6.0 * (1.0 + RATIO)) + RATIO)


def piece(run, place, width=0.003):
    """Mean velocity of a short piece of the plate at the end [m/s]."""
    snap = run.near(1.0)
    near = (snap.fields["material"] == PLATE) & (abs(snap.points[:, 0] - place) < width)
    return np.average(snap.fields["velocity"][near], axis=0, weights=snap.fields["mass"][near])


def tables(runs):
    """Speeds along the plate, and the turn of its velocity."""
    table = Table(["detonation", *(f"speed at {1e3 * place:.0f} mm [m/s]" for place in PLACES), "Gurney [m/s]",
                   "turn at 70 mm [deg]", "Taylor [deg]"])
    for name, run in runs.items():
        found = [piece(run, place) for place in PLACES]
        last = np.hypot(found[-1][0], found[-1][2])
        turn = np.degrees(np.arctan2(found[-1][0], found[-1][2]))
        taylor = np.degrees(np.arcsin(0.5 * last / SPEED)) if name == "along" else 0.0
        table.rows.append([NAMES[name], *(f"{np.hypot(velocity[0], velocity[2]):.0f}" for velocity in found),
                           f"{gurney():.0f}", f"{turn:.1f}", f"{taylor:.1f}"])
    return [table]


def draw(runs, plot):
    """Products and plate at three times."""
    figure, panels = plot.subplots(3, 1, figsize=(7.4, 9.6), sharex=True, layout="constrained")
    run = runs["along"]
    for axes, moment in zip(panels, (4.0e-6, 10.0e-6, 18.0e-6)):
        snap = run.near(moment)
        plate = snap.fields["material"] == PLATE
        shown = panel.particles(axes, snap, 1e-9 * snap.fields["pressure"], low=0.02, high=20.0,
                                rows=~plate, log=True)
        panel.particles(axes, snap, "#0072b2", rows=plate)
        panel.window(axes, (-10, 130, -20, 50), "", "z [mm]", f"{1e6 * snap.time:.0f} µs")
    panels[-1].set_xlabel("x [mm]")
    panels[0].legend(handles=panel.patches({"plate": "#0072b2"}), loc="upper right")
    figure.colorbar(shown, ax=panels, label="pressure of the explosive [GPa]", shrink=0.5, extend="both")
    return figure


CASES = {"along": ("scene.nml", {}),
         "across": ("scene.nml", {"detonation.normal": "0,0,1"})}

if __name__ == "__main__":
    Study(__file__, CASES, tables, {"picture.png": draw}, as_it_stands="along").main()
