# SPDX-License-Identifier: BSD-3-Clause
"""Failure fronts in glass rods.

A rod of soda-lime glass strikes an equal one, and a front runs along it behind which the glass has failed. N. S.
Brar, S. J. Bless (1991) measured speeds of 2.3 to 5.2 km/s in rods, rising with the speed of impact; the row compares
with the middle of this range, and half of the range is its error, because the speeds of single shots were not read.
Choice of the constants: JH-2 of T. J. Holmquist and others (1995), from plate impacts; it has no time to failure.
"""
import numpy as np

SUBJECT = "brittle"
QUANTITIES = {"front": ("speed of the front in the glass", "m/s")}
CELLS = 12                             # on the radius


def place(snap, layer):
    """Highest layer in which a tenth of the particles has failed [m]."""
    rows = (snap["z"] / layer).astype(int)
    whole, failed = (np.bincount(rows, weights=weights) for weights in (np.ones(len(rows)), snap["failed"]))
    broken = np.nonzero(failed > 0.1 * np.maximum(whole, 1.0))[0]
    return (broken.max() + 1) * layer if len(broken) else 0.0


def measure(run, shot):
    """Slope of the front between one and four diameters from the impact, relative to the glass ahead."""
    diameter = 2.0 * run.deck["region"]["hi"][0]
    front = np.array([(snap.time, place(snap, 0.05 * diameter)) for snap in run.snapshots])
    chosen = (front[:, 1] > diameter) & (front[:, 1] < 4.0 * diameter)
    if chosen.sum() < 3:
        return {"front": 0.0}
    return {"front": np.polyfit(*front[chosen].T, 1)[0] - run.deck["body"]["velocity"][2]}
