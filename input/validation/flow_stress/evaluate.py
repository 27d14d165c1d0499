# SPDX-License-Identifier: BSD-3-Clause
"""Flow stress of aluminium at high rates.

Samples of aluminium 6061-T6 in split Hopkinson bars. Axisymmetric: a short cylinder between smooth rigid plates, one
of which moves, as a sample is compressed; the heat of plastic work stays in it. *Stress* is the mean axial stress at
true strains of 0.05, 0.1 and 0.2; the law itself (`scree --point`) has 358, 368 and 380 MPa at 1000/s and 298 K, and
the cells take up to 2 % from that. Rows in tension are computed in compression, where the law has the same stress.
Data: curves in github.com/bbanerjee/HighRateExptData, without a stated error; samples of different authors at the
same rate and temperature differ by 20 % (319 to 390 MPa at a strain of 0.05), which is thus the scatter between lots
of this alloy and not an error of a curve. Choice of the constants: the preset `al_6061_t6` has the set of Johnson and
Cook that Lesuer and others fitted to their own tests, of which only the row named so is one.
"""
import numpy as np

SUBJECT = "strength"
QUANTITIES = {"flow_5": ("stress at a strain of 0.05", "MPa"), "flow_10": ("stress at a strain of 0.1", "MPa"),
              "flow_20": ("stress at a strain of 0.2", "MPa")}
CELLS = 6                              # on the radius


def measure(run, shot):
    """Mean axial stress, over a hundredth of strain to both sides; strain: the mean plastic one and stress over E."""
    record, last, metal = run.tables["gauge"], float(shot["strain"]), run.deck["material"]
    stress = -record["stress_zz"].to_numpy()
    bulk, shear = metal["density"] * metal["mg_c0"]**2, metal["shear"]
    strain = record["plastic_strain"].to_numpy() + stress * (3.0 * bulk + shear) / (9.0 * bulk * shear)
    found = {name: np.abs(strain - at) < 0.01 for name, at in (("flow_5", 0.05), ("flow_10", 0.1), ("flow_20", 0.2))
             if at <= last}
    return {name: 1.0e-6 * stress[near].mean() for name, near in found.items()}
