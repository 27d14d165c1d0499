# SPDX-License-Identifier: BSD-3-Clause
"""Long rods into steel.

A rod of tungsten alloy, ten diameters long, penetrates a thick block of steel. Axisymmetric; rod and steel stick
together where they meet. Measured: the law of W. Lanz and W. Odermatt (2000) for tungsten rods in thick steel of
Brinell hardness 200 to 600, a law through many shots of guns whose scatter was not read. Choice of the constants:
the presets `tungsten_alloy` and `steel_4340`, from tension and torsion tests, with failure of the steel; the
hardness in the law is that of the preset, Rockwell C 30.
"""
SUBJECT = "impacts"
QUANTITIES = {"depth": ("depth", "mm")}
CELLS = 5                              # on the radius of the rod
COARSER = 5.0 / 3.0


def measure(run, shot):
    """Deepest place that material of the rod reaches."""
    return {"depth": -1.0e3 * run.tables["rod_history"]["tail_z"].min()}
