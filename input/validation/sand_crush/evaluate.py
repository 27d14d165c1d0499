# SPDX-License-Identifier: BSD-3-Clause
"""Confined sand.

Dry mason sand in a stiff tube is compressed (confined split Hopkinson bar, shot 052212-001: numbers of
github.com/Uintah/Uintah, ArenaSoilBanerjeeBrannon/ValidationTests); state at the greatest stress. Choice of the
constants: the preset `sand_dry` has the first slope of the compression curve and the loosest yield curve of another
sand (L. Laine 2001); nothing was fitted to this shot. Neither the density of the sample nor the error of the stress
was read, and the strain is taken as logarithmic.
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
