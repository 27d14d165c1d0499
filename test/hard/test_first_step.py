# SPDX-License-Identifier: BSD-3-Clause
# timeout: 120
"""The first time step that --check prints is that of the run.

Would catch a limit of the step that the run knows and the check does not: the mesh of a deformed cell, viscosity of
fluids, heat conduction, bodies with contact, loose grains.
"""

import re

import pytest

import case

DECK = """&run  dimension='plane_strain' /
&grid  lo=0,0,0  hi=1,1,1  dx=0.1 /
&time  t_end=1  max_steps=1 /
&material  name='m'  {material} /
&region  name='r'  shape='box'  lo={low}  hi={high} /
&body  name='b'  region='r'  material='m'  {body} /
{more}
&output  name='h'  kind='history'  every=1 /
&checkpoint  at_end=.false. /
"""
USUAL = {"material": "density=2000  bulk=1e7  shear=5e6", "low": "0.2,0,0.2", "high": "0.8,1,0.8", "body": "",
         "more": ""}
PERIODIC = {"low": "0,0,0", "high": "1,1,1", "more": "&boundary  face='all'  type='periodic' /\n"}
SCENES = {
    "still": {},
    "moving": {"body": "velocity=30,0,-40"},
    "tilted": {**PERIODIC, "more": PERIODIC["more"] + "&cell  tilt=0.4 /\n&stage  rate=0,0,0,0,1,0  strain=0.1 /\n"},
    "sheared": {**PERIODIC, "more": PERIODIC["more"] + "&cell /\n&stage  rate=0,0,0,0,900,0  strain=1 /\n"},
    "fluid": {"material": "density=1000  bulk=1e7  strength_model='newtonian'  viscosity=2e4"},
    "conduction": {"material": "density=2000  bulk=1e7  shear=5e6  specific_heat=100  conductivity=1e6",
                   "more": "&effects  thermal=.true. /\n"},
    "contact": {"body": "velocity=5,0,0", "more": "&effects  contact=.true. /\n&region  name='q'  shape='box'  lo=0,0,0"
                "  hi=1,1,0.2 /\n&body  name='floor'  region='q'  material='m' /\n&contact  friction=0.3 /\n"},
    "granular": {"material": "density=2000  bulk=1e7  shear=5e6  strength_model='granular'  gr_tau=1e-3  "
                 "gr_gamma_c=1e-2"},
    "gas": {"material": "density=1  elastic='none'  eos_model='ideal_gas'  ig_gamma=1.4",
            "body": "specific_energy=2e5"},
}


@pytest.mark.parametrize("name", SCENES)
def test_first_step(options, sheet, name):
    """One scene: four digits of the check against the history."""
    run = case.Case(options, name, DECK.format(**{**USUAL, **SCENES[name]}))
    said = re.search(r"first dt (\S+) s", run.run("--check", "--no-estimate").output)
    sheet.require(said is not None, f"{name}: the check names the step")
    run.run("-q")
    made = run.history["dt"][run.history["step"] == 1]
    sheet.near(f"{name}: first step of the check over that of the run", float(said.group(1)) / made[0], 1.0, 6e-4)
