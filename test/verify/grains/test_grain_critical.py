# SPDX-License-Identifier: BSD-3-Clause
"""scree --grains: volume fraction of spheres in slow steady shear, by friction.

Would catch friction between spheres that is not that of the deck, a tangential force that is lost in a neighbour
search, and dilatancy that the servo prevents. Values are quoted from memory.
"""
# tiers: long
# timeout: 1200

import numpy as np
import pytest

import case

DECK = """&grains  shape = 'spheres'  number = 216  diameter = 1e-3  spread = 0.1  density = 2500  stiffness = 3e3
  restitution = 0.5  friction = {friction} /
&cell  pressure = 1e3  seed = 2 /
&stage  name = 'press'   servo = 'isotropic'  duration = 0.012  rows = 2  snapshots = 0 /
&stage  name = 'begin'   servo = 'y'  inertial_number = 0.03  strain = 1  rows = 2  snapshots = 0 /
&stage  name = 'steady'  servo = 'y'  inertial_number = 0.01  strain = 1.5  rows = 15  snapshots = 0 /
"""


@pytest.mark.parametrize("friction, critical", ((0.0, 0.636), (0.1, 0.613), (0.3, 0.596), (0.5, 0.587)))
def test_grain_critical(options, sheet, friction, critical):
    history = case.Case(options, f"friction_{friction}", DECK.format(friction=friction)).run(
        "--grains", "--quiet", timeout=600).history
    solid = history["volume_fraction"][history["stage"] == 3][5:]
    sheet.require(len(solid) == 10, "ten rows of the steady part")
    sheet.below(f"friction {friction}: volume fraction {np.mean(solid):.4f} from the critical one",
                np.mean(solid) - critical, 0.01)
