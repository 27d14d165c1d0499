# SPDX-License-Identifier: BSD-3-Clause
"""Spheres that vaporise on a sheet expand to ten diameters with physical states: lead at 6.58 km/s, aluminium at 12
km/s.

Would catch: a Grueneisen number that grows with the volume, as with Gamma rho = constant. A particle in tension at 130
times its initial volume then got energies below those of cold material and accelerated its neighbours to 280 km/s (exit
code 4 for lead, with the preset and without a limit of tension), and vapour had 0 K. Also tension that does not vanish
as the density tends to 0 (published form of Tillotson): -730 MJ/kg in one particle with a closed energy balance.

The sphere has a diameter of 9.4 cells, the sheet a thickness of 4: too coarse for the shape of the cloud, but hot and
thin. Limits: the free surface of shocked material moves with the impact speed and a few per cent more, so expansion
does not exceed 1.3 times it. Energies are above that of cold material at rest, 0, and in the second half of the run
below v^2/2, the whole kinetic energy of a particle as heat; before that, artificial viscosity heats single particles to
2 v^2/2.
"""
# tiers: full
# timeout: 180

import numpy as np
import pytest

import case

DECK = """
&run  dimension='{dimension}' /
&units  system='mm-us-mg' /
&grid  lo=0,0,-16  hi={hi}  dx=1.6 /
&time  t_end={end} /
&effects  thermal=.true. /
&material  name='m'  {material} /
&region  name='ball'   shape='sphere'  centre=0,0,-8  radius=7.5 /
&region  name='sheet'  shape='box'  lo=0,0,0  hi={sheet},6.4 /
&body  name='ball'   region='ball'   material='m'  velocity=0,0,{speed} /
&body  name='sheet'  region='sheet'  material='m' /
&boundary  face='xlo'  type='symmetry' /
{mirror}
&output  name='p'  kind='particles'  count=8  precision='double'
  fields='identity','velocity','volume','mass','energy','temperature' /
&output  name='h'  kind='history'  every=10 /
"""
BY_HAND = """density=11.35  eos_model='mie_gruneisen'  mg_c0=2.092  mg_s=1.45  mg_gamma=2  shear=7.887
  strength_model='von_mises'  yield=12e-3  hardening=0.125  specific_heat=1.29e-4"""
TILLOTSON = """density=2.7  elastic='none'  specific_heat=9e-4  eos_model='tillotson'  till_a=0.5  till_b=1.63
  till_bulk=75.2  till_square=65  till_alpha=5  till_beta=5  till_e0=5  till_eiv=3  till_ecv=13.9"""
TUBE = {"dimension": "axisymmetric", "hi": "80,0,160", "sheet": "24,0", "mirror": ""}
SPACE = {"dimension": "3d", "hi": "32,32,96", "sheet": "16,16", "mirror": "&boundary  face='ylo'  type='symmetry' /"}
# name: material, speed in km/s, density at rest, end in us, scene
CASES = {
    "lead": ("preset='lead'", 6.58, 11350.0, 30.0, TUBE),
    "lead_no_spall": (BY_HAND, 6.58, 11350.0, 30.0, TUBE),
    "lead_no_spall_3d": (BY_HAND, 6.58, 11350.0, 12.0, SPACE),
    "vapour": (TILLOTSON, 12.0, 2700.0, 30.0, TUBE),
}


@pytest.mark.parametrize("name", CASES)
def test_fly(options, sheet, name):
    """One impact: the run ends, its balances close, and its states are physical."""
    material, speed, density, end, scene = CASES[name]
    run = case.Case(options, name, DECK.format(material=material, speed=speed, end=end, **scene)).run("-q")
    sheet.below(f"{name}: energy", run.summary["ledger"]["energy_error"], 1.0e-6)
    fastest, least, most, thinnest, coldest = 0.0, 0.0, 0.0, 0.0, np.inf
    for time, snap in run.snapshots():
        fields = snap.fields
        fastest = max(fastest, np.linalg.norm(fields["velocity"], axis=1).max() / (1.0e3 * speed))
        least = min(least, fields["energy"].min() / (0.5e6 * speed ** 2))
        if time > 0.5e-6 * end:
            most = max(most, fields["energy"].max() / (0.5e6 * speed ** 2))
        thinnest = max(thinnest, (fields["volume"] / fields["mass"]).max() * density)
        coldest = min(coldest, fields["temperature"].min())
    sheet.require(thinnest > 50.0, f"{name}: material expands to 50 times its volume, {thinnest:.3g}")
    sheet.below(f"{name}: greatest speed [impact]", fastest, 1.3)
    sheet.below(f"{name}: energy below 0 [v^2/2]", least, 1.0e-2)
    sheet.below(f"{name}: greatest energy late [v^2/2]", most, 1.0)
    sheet.above(f"{name}: least temperature [K]", coldest, 0.0)
    sheet.note(f"{name}: steps", run.summary["steps"])
    sheet.note(f"{name}: greatest volume", thinnest)
