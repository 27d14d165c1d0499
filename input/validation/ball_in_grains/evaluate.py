# SPDX-License-Identifier: BSD-3-Clause
"""A ball that falls into glass beads.

A ball strikes a bed of glass beads, enters it and stops. Depth: the fit of J. S. Uehara and others (2003) to their
experiments; time to rest: three depths over the speed of impact (M. A. Ambroso and others 2005). Both are laws
through many shots, whose scatter was not read. Choice of the constants: the friction is that of the angle of repose
of the beads of the paper, 0.45; moduli of beads and ball are softened, at one wave speed. Nothing was fitted to
depths. Beads and ball have one velocity field, so beads stick to the ball. The depth grows with finer cells (37, 44
and 48 mm with 10, 16 and 24 cells across the ball at 2 m/s): it has not converged, and agreement on one grid is no
evidence. The time to rest has converged, but does not depend on the speed as the law says.
"""
import numpy as np

SUBJECT = "grains"
QUANTITIES = {"depth": ("depth", "mm"), "time": ("time to rest", "ms")}
CELLS = 24                             # across the ball
COARSER = 1.5


def measure(run, shot):
    """Way of the centre of the ball, and the time at which a fiftieth of the speed is left."""
    table = run.tables["motion_history"]
    speed, way = table["velocity_z"].to_numpy(), table["centre_z"].to_numpy()
    rest = np.nonzero(speed > 0.02 * speed[0])[0]
    return {"depth": 1.0e3 * (way[0] - way.min()),
            "time": 1.0e3 * table["time"].iloc[rest[0]] if len(rest) else np.nan}
