# SPDX-License-Identifier: BSD-3-Clause
"""Sliding of a block down an incline, from the snapshots of a run in which gravity is rotated instead of the floor."""

import numpy as np


def sliding(run, belongs, settled, friction=0.0):
    """Acceleration of a block along the slope plus friction times that normal to it, from a parabola fitted to its
    positions after the initial vibration [s], and its last velocity along the slope. `belongs` selects its particles
    in a snapshot."""
    times, places, speed = [], [], 0.0
    for time, snap in run.snapshots():
        here = belongs(snap)
        if time > settled:
            times.append(time)
            places.append(snap.points[here, 0].mean() + friction * snap.points[here, 2].mean())
        speed = np.average(snap.fields["velocity"][here, 0], weights=snap.fields["mass"][here])
    return 2.0 * np.polyfit(times, places, 2)[0], speed
