# SPDX-License-Identifier: BSD-3-Clause
"""A ball that falls into glass beads.

A ball strikes a bed of glass beads, enters it and stops. Depth: the fit of J. S. Uehara and others (2003) to their
experiments; time to rest: three depths over the speed of impact (M. A. Ambroso and others 2005). Both are laws
through many shots, whose scatter was not read. Choice of the constants: the friction is that of the angle of repose
of the beads of the paper, 0.45, which is the slope of the yield surface of Mohr and Coulomb; it also acts between
ball and beads, where none was read: a value of 0.2 there makes the ball go 9 % deeper and rest after 57 instead of 44
ms (10 cells, 2 m/s). Moduli of beads and ball are softened, at one wave speed; four times the modulus changes the
depth by 2 %. Nothing was fitted to depths. With 10, 12, 16, 18 and 24 cells across the ball of 7700 kg/m3 the depth
at 2 m/s is 35.3, 34.5, 37.1, 37.3 and 38.3 mm. Earlier runs had one velocity field, so that beads stuck to the ball
(37, 44 and 48 mm with 10, 16 and 24 cells: not converged), and a cone of Drucker and Prager through plane strain. The
field alone makes the depth converge, but to a larger value (48 and 51 mm with 10 and 16 cells), so sticking was not
the cause of the deviation; the cone was. Below a ball the grains are compressed along one axis, where this cone is
too weak: the cone through triaxial compression gives 34 mm, mu(I) of the preset `glass_beads` 49 mm with 10 cells.
The time to rest does not depend on the speed as the law says.
"""
import numpy as np

SUBJECT = "grains"
QUANTITIES = {"depth": ("depth", "mm"), "time": ("time to rest", "ms")}
CELLS = 16                             # across the ball
COARSER = 1.6


def measure(run, shot):
    """Way of the centre of the ball, and the time at which a fiftieth of the speed is left."""
    table = run.tables["motion_history"]
    speed, way = table["velocity_z"].to_numpy(), table["centre_z"].to_numpy()
    rest = np.nonzero(speed > 0.02 * speed[0])[0]
    return {"depth": 1.0e3 * (way[0] - way.min()),
            "time": 1.0e3 * table["time"].iloc[rest[0]] if len(rest) else np.nan}
