# SPDX-License-Identifier: BSD-3-Clause
"""Expanding tube.

A cylinder of polycarbonate enters a tube of AerMet 100 steel and strikes an equal one there; the tube bulges, and
its outer face is observed 25, 20 and 15 mm above its foot (a, b, c). Axisymmetric, without failure, as the records
end before the tube breaks; polycarbonate slides in the tube. Data: T. J. Vogler and others, Int. J. Impact Eng. 29
(2003) 735; records and set-up as with Spheral (github.com/LLNL/spheral, tests/functional/Damage/ExpandingTube),
without a stated error; which of their shots they are is not said. *Peak* is the greatest velocity within 6 us after
75 m/s, *late* that 10 us after, *delay* the time of 75 m/s after that at a. Choice of the constants: steel and
polycarbonate of github.com/Uintah/Uintah (MaterialData), whose origin is not stated: the yield stress of 2.59 GPa
may come from such tubes, so this row is no prediction of it. Greatest tension of polycarbonate: its yield stress,
chosen. The entrance of the tube, chamfered by 1.8 degrees, and foam behind the copper are left out.
"""
import numpy as np

SUBJECT = "impacts"
QUANTITIES = {"peak_a": ("peak at 25 mm", "m/s"), "peak_b": ("peak at 20 mm", "m/s"),
              "peak_c": ("peak at 15 mm", "m/s"), "late_c": ("late velocity at 15 mm", "m/s"),
              "delay_b": ("delay at 20 mm", "us"), "delay_c": ("delay at 15 mm", "us")}
CELLS = 11                             # through the wall
COARSER = 11.0 / 8.0


def measure(run, shot):
    """Marks of the three records, smoothed over 0.3 us as the measured ones."""
    time = np.arange(0.0, 30.0, 0.02)
    start, found = {}, {}
    for name, table in (("a", "gauge"), ("b", "b_gauge"), ("c", "c_gauge")):
        record = run.tables[table]
        speed = np.interp(time, 1e6 * record["time"], record["velocity_x"])
        speed = np.convolve(speed, np.full(15, 1.0 / 15.0), "same")
        first = np.nonzero(speed > 75.0)[0][0]
        start[name] = time[first]
        found[f"peak_{name}"] = speed[first:first + 300].max()
        found[f"late_{name}"] = np.interp(time[first] + 10.0, time, speed)
    return {**found, "delay_b": start["b"] - start["a"], "delay_c": start["c"] - start["a"]}
