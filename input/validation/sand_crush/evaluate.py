# SPDX-License-Identifier: BSD-3-Clause
"""Confined sand.

Dry mason sand in a stiff tube is compressed (confined split Hopkinson bar, shot 052212-001: numbers of
github.com/Uintah/Uintah, ArenaSoilBanerjeeBrannon/ValidationTests); state at the greatest stress. Choice of the
constants: the preset `sand_dry` has the first slope of the compression curve and the loosest yield curve of another
sand (L. Laine 2001); nothing was fitted to this shot. The strain is the shortening of the first length. The sample had
1770 kg/m3, the preset has 1674; the error of the stress is not stated. With the whole compaction curve of that sand
the stresses are [30 % too small](#sand-between-hopkinson-bars).
"""
import numpy as np

SUBJECT = "grains"
QUANTITIES = {"axial": ("axial stress", "MPa"), "mean": ("mean stress", "MPa"),
              "shear": ("greatest shear stress", "MPa")}
CELLS = 40                             # along the sample


def measure(run, shot):
    """Means over the sample at the end."""
    snap = run.snapshots[-1]
    axial, *others = (-1.0e-6 * np.average(snap[f"stress_{name}"], weights=snap["volume"])
                      for name in ("xx", "yy", "zz"))
    return {"axial": axial, "mean": (axial + sum(others)) / 3.0, "shear": 0.5 * (axial - min(others))}
