# SPDX-License-Identifier: BSD-3-Clause
"""scree --grains: packings without friction at a small pressure are isostatic and have the jamming density.

Would catch friction that is not zero, a pressure that is wrong by a factor, a bidisperse distribution with wrong sizes,
contacts and rattlers that are counted differently, and a servo that ends at another pressure.
"""
# tiers: full
# timeout: 200

import pytest

import case
import measured

PRESS = """&grains  shape = '{shape}'  number = {number}  diameter = 1e-3  sizes = 'two'  spread = {spread}
  density = 2500  stiffness = {stiffness}  restitution = 0.2  friction = 0 /
&cell  seed = 1 /
&stage  name = 'press'  servo = 'isotropic'  pressure = 1e3  duration = {time}  rows = 2  snapshots = 0 /
&stage  name = 'rest'   servo = 'isotropic'  pressure = 200  duration = 0.15  quiet = 1e-6  rows = 4  snapshots = 0 /
"""


@pytest.mark.parametrize("shape, number, spread, stiffness, density, contacts", [
    ("discs", 400, "{1/6}", 1e6, 0.842, 4.0),
    ("spheres", 400, "0", 1e3, 0.64, 6.0),
])
def test_grain_jamming(options, sheet, shape, number, spread, stiffness, density, contacts):
    """Overlaps are 2e-4 of a diameter, so the density is above the jamming density by about as much, and the number of
    contacts by about its square root: a few percent. 0.01 is the spread of protocols and of cells of this size."""
    history = case.Case(options, shape, PRESS.format(shape=shape, number=number, spread=spread, time=0.02,
                                                     stiffness=stiffness)).run("--grains", "--quiet").history
    last = {name: history[name][-1] for name in ("volume_fraction", "coordination_held", "pressure", "rattlers")}
    measured.record(shape, last)
    sheet.near(f"{shape}: pressure", last["pressure"], 200.0, 0.01)
    sheet.below(f"{shape}: volume fraction less that of jamming",
                last["volume_fraction"] - density, 0.01)
    sheet.near(f"{shape}: contacts of grains that are held", last["coordination_held"], contacts, 0.05)
    sheet.below(f"{shape}: rattlers", last["rattlers"], 0.1)
