# SPDX-License-Identifier: BSD-3-Clause
"""Charges in tubes full of water.

A small charge explodes in the middle of a tube of aluminium 5086, 102 mm in diameter with a wall of 6.35 mm and full
of water; speed and way of the outer face of the wall beside the charge. Axisymmetric, without failure. Records: A.
Wardlaw, R. McKeown, A. Luton (1998), with the set-up in github.com/synthetik-technologies/blastfoam
(validation/blastFSIFoam), digitised, without a stated error. The charges are those of that set-up, 3.0 and 5.7 g. The
peak is a mean over 3 us. Choice of the constants, all of that set-up: products with the constants named c4, sound
speed and Grueneisen parameter of the water; yield stress, greatest stress and elongation of 5086, between which
hardening is taken as linear; its elastic constants. The slope 1.92 of the shock in water is that of M. A. Meyers
(1994). Water supports a tension of 10 kPa and slides on the wall. Nothing was fitted to these records. The ends of
the tube are rigid; their waves need more than 70 us to the middle.
"""
import numpy as np

SUBJECT = "impacts"
QUANTITIES = {"peak": ("greatest speed of the wall", "m/s"), "way_60": ("way of the wall after 60 us", "mm"),
              "way_100": ("way of the wall after 100 us", "mm")}
CELLS = 7                              # through the wall
COARSER = 1.4


def measure(run, shot):
    """Greatest speed, as a mean over 3 us, and integrals of the speed of the outer face."""
    record = run.tables["gauge"]
    time = np.arange(0.0, 120.0, 0.1)
    speed = np.interp(time, 1e6 * record["time"], record["velocity_x"])
    way = 1e-3 * np.cumsum(speed) * 0.1
    return {"peak": np.convolve(speed, np.full(30, 1.0 / 30.0), "valid").max(),
            "way_60": np.interp(60.0, time, way), "way_100": np.interp(100.0, time, way)}
