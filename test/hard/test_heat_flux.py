# SPDX-License-Identifier: BSD-3-Clause
"""A hot corner in a closed box of cold gas, with the artificial heat flux.

Would catch: a flux that takes more energy from nodes or particles than they have (before it was limited, 2 % of the
particles of this gas had -1.3e6 J/kg, minus four times their initial energy, which was not visible in the pressure), a
limit that loses energy, and one that depends on ranks.

No particle may have a negative energy in any of six snapshots. Balances: 1e-12. Bits: those of one rank.
"""
# timeout: 120

import pytest

import case

DECK = """
&run  dimension='3d'  seed=21 /
&grid  lo=0,0,0  hi=0.7,1,0.7  dx=0.1 /
&time  t_end=1.4e-3  cfl=0.7 /
&method  heat_flux={flux} /
&material  name='gas'  density=4.6  eos_model='ideal_gas'  ig_gamma=1.16  elastic='none' /
&region  name='box'  shape='box'  lo=0,0,0  hi=0.7,1,0.7 /
&region  name='corner'  shape='box'  lo=0,0,0  hi=0.2,0.3,0.2 /
&region  name='rest'  shape='difference'  of='box','corner' /
&body  name='cold'  region='rest'  material='gas'  ppc=2,2,2  packing='jitter'  specific_energy=3.4e5 /
&body  name='hot'  region='corner'  material='gas'  ppc=2,2,2  specific_energy=7.9e6 /
&boundary  face='all'  type='slip' /
&output  name='p'  kind='particles'  count=6  precision='double'  fields='energy' /
"""


@pytest.mark.parametrize("flux", (1, 20))
def test_heat_flux(options, sheet, flux):
    """Two strengths of the flux, and two ranks."""
    run = case.Case(options, f"flux_{flux}", DECK.format(flux=flux)).run("-q")
    least = min(snapshot.fields["energy"].min() for _, snapshot in run.snapshots())
    sheet.above(f"heat_flux={flux}: least energy", least, 0.0)
    sheet.below(f"heat_flux={flux}: energy error", run.summary["ledger"]["energy_error"], 1.0e-12)
    other = case.Case(options, f"flux_{flux}_ranks", DECK.format(flux=flux), ranks=2).run("-q")
    sheet.require(other.summary["digest"] == run.summary["digest"], f"heat_flux={flux}: two ranks, the same bits")
