# SPDX-License-Identifier: BSD-3-Clause
"""Charges in a tube of water.

A charge explodes in the middle of a tube of aluminium 5086-H116, 6.35 mm thick, that is filled with water; velocity
and displacement of its outer face were recorded beside the charge. Axisymmetric half; water and wall stick together;
the ends are held. *Final* is the mean displacement after 250 us. Data and set-up: blastFoam, after A. Wardlaw, R.
McKeown and A. Luton (1998), without a stated error or zero of time, so the times of 50 m/s, 17.7 and 14.2 us in the
records against 18.9 and 16.7 us after the ignition in the runs, are not judged. Choice of the
constants: products of the explosive and elastic modulus, yield and tensile strength of the alloy as in blastFoam;
linear hardening between the two strengths, no dependence on the rate; water: Tait's equation with
an exponent of 7, without tension. Nothing was fitted to these records. With 4 cells through the wall the run of 3.0 g
now ends at 290 us with an error: a particle of the products gains more energy than the run has (R111). Its numbers are
those of an earlier version.
"""
import numpy as np

SUBJECT = "impacts"
QUANTITIES = {"peak": ("greatest velocity", "m/s"), "greatest": ("greatest displacement", "mm"),
              "final": ("final displacement", "mm")}
CELLS = 4                              # through the wall
COARSER = 4.0 / 3.0


def measure(run, shot):
    """Marks of velocity and displacement of the outer face."""
    face = run.tables["gauge"]
    time, speed = 1e6 * face["time"].to_numpy(), face["velocity_x"].to_numpy()
    way = 1e-3 * np.concatenate(([0.0], np.cumsum(0.5 * (speed[1:] + speed[:-1]) * np.diff(time))))
    return {"peak": speed.max(), "greatest": way.max(), "final": way[time > 250.0].mean()}
