# SPDX-License-Identifier: BSD-3-Clause
"""Triaxial compression of sand.

Drained triaxial compression of Karlsruhe fine sand at three densities and lateral pressures from 50 to 400 kPa: tests
TMD1 to TMD20 of the database of T. Wichtmann and Th. Triantafyllidis (Acta Geotech. 11 (2016) 739 and 763), read from
TMD-all of github.com/gagankaushikmanyam/mechanics-sand-model. The sample of the run is homogeneous, a periodic cell
whose lateral stresses are held. Choice of the constants: those of the surface of Mohr and Coulomb are taken from one
test of each density, at 100 kPa (TMD2, TMD7, TMD17, which are no rows): friction angle from the greatest deviator,
dilation angle from the volume over 4 % of strain around it, Young's modulus from half of the greatest deviator;
Poisson's ratio 0.25 is a choice. So the rows test how these constants carry over to other pressures. The strength
does, within 10 %, and mostly within 5 %: the measured friction angle of dense sand falls from 41 to 39 degrees from
50 to 400 kPa, which a surface with straight sides has not. The stiffness does not: that of sand grows with the
pressure, while the modulus of the law is constant. So the law is too soft at high pressure, and compacts too much
there before it yields. Its dilation has no critical state. Volume strains below 1 % are not compared. The error of
the tests is not stated; a second series of dense sand (TMD21 to TMD25) has greatest deviators that are 4 to 17 %
larger at densities that are 0.6 to 2.5 % larger.
"""
import numpy as np

SUBJECT = "grains"
QUANTITIES = {"greatest": ("greatest deviator up to a strain of 20 %", "kPa"),
              "early": ("deviator at a strain of 1 %", "kPa"), "volume": ("compaction at a strain of 10 %", "%")}
CELLS = 4                              # along an edge of the sample
COARSER = 2


def measure(run, shot):
    """Deviators and volume strain over the shortening after the consolidation."""
    table = run.tables["cell"]
    table = table[table["stage"] == 2]
    height, volume = table["edge_zz"].to_numpy(), table["volume"].to_numpy()
    strain = 1.0 - height / height[0]
    lateral = 0.5 * (table["stress_xx"] + table["stress_yy"]).to_numpy()
    deviator = 1.0e-3 * (lateral - table["stress_zz"].to_numpy())
    return {"greatest": deviator[strain <= 0.2].max(), "early": np.interp(0.01, strain, deviator),
            "volume": 100.0 * (1.0 - np.interp(0.1, strain, volume) / volume[0])}
