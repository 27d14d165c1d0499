# SPDX-License-Identifier: BSD-3-Clause
"""Tantalum behind a window.

A flyer of sapphire, backed by tungsten carbide and acrylic, strikes tantalum on a window of sapphire at 133 m/s;
the velocity of the interface between metal and window was recorded. In one dimension. Data and set-up:
`ExperimentalSapphireVelocityHistory` beside the plate impact of github.com/LLNL/spheral
(tests/functional/Strength), read off as medians and means; no error is stated. *Step* is the plateau behind the
elastic wave, *rise* the one that the first reflection from the flyer leaves, *peak* the greatest velocity, *low*
the plateau after the release. Choice of the constants: D. J. Steinberg, UCRL-MA-106439 (1996), after
github.com/Uintah/Uintah (SCGMaterials), for tantalum, carbide and acrylic, whose strengths were fitted to waves in
plates, not to this record as far as the source tells; sapphire: speed of its elastic wave as in the deck of
Spheral.
"""
import numpy as np

SUBJECT = "metals"
QUANTITIES = {"arrival": ("time of 20 m/s", "us"), "step": ("velocity behind the elastic wave", "m/s"),
              "rise": ("velocity before the second rise", "m/s"), "peak": ("greatest velocity", "m/s"),
              "release": ("time of 80 m/s after the peak", "us"), "low": ("velocity after the release", "m/s")}
CELLS = 200                            # through the tantalum


def measure(run, shot):
    """Marks of the velocity of the window at the metal, times after the impact."""
    table = run.tables["gauge"]
    time, speed = 1e6 * table["time"].to_numpy(), -table["velocity_x"].to_numpy()
    top = speed[time < 2.4].argmax()
    fall = top + np.nonzero(speed[top:] < 80.0)[0][0]
    first = np.nonzero(speed > 20.0)[0][0]
    mean = {name: speed[(time > begin) & (time < end)].mean()
            for name, begin, end in (("step", 1.36, 1.44), ("rise", 1.62, 1.70), ("low", 2.50, 2.66))}
    return {"arrival": np.interp(20.0, speed[first - 1:first + 1], time[first - 1:first + 1]), "peak": speed[top],
            "release": np.interp(-80.0, -speed[fall - 1:fall + 1], time[fall - 1:fall + 1]), **mean}
