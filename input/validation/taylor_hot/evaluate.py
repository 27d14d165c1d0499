# SPDX-License-Identifier: BSD-3-Clause
"""Hot metal bars on a wall.

Bars that are heated before they strike a hard wall. Axisymmetric, smooth rigid wall, law of Johnson and Cook, without
failure; the length follows from the velocity of the rear end, the foot from the lowest row of particles. Data: W. H.
Gust (1982), as tabulated in github.com/bbanerjee/HighRateExptData, without a stated error. Choice of the constants:
presets, fitted to torsion and tension tests at low and high rates; most of the bars are hotter than those tests. Bars
of the run have expanded, and have the elastic moduli of cold metal.
"""
import numpy as np

SUBJECT = "strength"
QUANTITIES = {"ratio": ("final over initial length", "1"), "foot": ("diameter of the foot", "mm")}
CELLS = 8                              # on the radius


def measure(run, shot):
    """Way of the rear end, from its velocity; half a step beyond the last particle of the lowest row."""
    rear, start, end = run.tables["gauge"], run.snapshots[0], run.snapshots[-1]
    way = np.trapezoid(rear["velocity_z"], rear["time"])
    lowest = start["identity"][start.points[:, 2] < 1.01 * start.points[:, 2].min()]
    radius = np.sort(end.points[np.isin(end["identity"], lowest), 0])
    return {"ratio": 1.0 + way / run.deck["region"]["hi"][2],
            "foot": 2.0e3 * (radius[-1] + 0.5 * (radius[-1] - radius[-2]))}
