# SPDX-License-Identifier: BSD-3-Clause
"""Sand between Hopkinson bars.

Dry mason sand in a stiff steel sleeve is compressed between steel bars at 400/s: records of github.com/Uintah/Uintah,
ArenaSoilBanerjeeBrannon/ValidationTests, for four initial densities, without a stated error. Shortening is that of
the first length, as in the deformation files beside the records. Choice of the constants: pressure against density,
yield surface and shear modulus of another dry sand from slow triaxial tests, L. Laine (2001), table 2, read in full
on GitHub (numerical-simulations-of-ground-shock-attenuation-layers-for-shelters); nothing was fitted to these
records. The equation of state is a table through the points of that curve: a looser sample joins it by a straight
line to its second point, a denser one along an elastic line with the sound speed of table 2. The shear modulus is
that at 1745.6 kg/m3, with which the stress lies on the yield surface. The ratio of stresses depends on this surface
alone and is 5 to 10 % too small. The pressure is 20 to 55 % too small at all densities, most in the loosest sample,
whose curve begins before the first point of the table: two sands, and rates that differ by orders of magnitude.
"""
import numpy as np

SUBJECT = "grains"
QUANTITIES = {"mean_10": ("mean stress at a shortening of 0.10", "MPa"),
              "mean_20": ("mean stress at a shortening of 0.20", "MPa"),
              "ratio_20": ("axial over mean stress at 0.20", "1")}
CELLS = 40                             # along the sample


def stresses(snap):
    """Axial and mean stress [MPa], means over the sample."""
    axial, *others = (-1.0e-6 * np.average(snap[f"stress_{name}"], weights=snap["volume"])
                      for name in ("xx", "yy", "zz"))
    return axial, (axial + sum(others)) / 3.0


def measure(run, shot):
    """Stresses at the shortenings of the quantities; the run ends at 0.20."""
    shortening = 0.2 * np.array([snap.time for snap in run.snapshots]) / run.snapshots[-1].time
    axial, mean = np.array([stresses(snap) for snap in run.snapshots]).T
    return {"mean_10": np.interp(0.1, shortening, mean), "mean_20": mean[-1], "ratio_20": axial[-1] / mean[-1]}
