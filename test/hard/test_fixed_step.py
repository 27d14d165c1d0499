# SPDX-License-Identifier: BSD-3-Clause
# timeout: 200
"""Time steps that the deck fixes: above the stability limit they are refused, and a failure names them.

Would catch a step above the limit that --check accepts, a limit that refuses stable steps or accepts unstable ones, and
a run that fails because of dt_fixed and recommends a smaller cfl, which has no effect then.
"""

import re

import numpy as np
import pytest

import case

DECK = """&run  dimension='plane_strain'  method='{method}' /
&grid  lo=0,0,0  hi=1.6,1,1.6  dx=0.1 /
&time  t_end={end}  dt_fixed={step}  dt_collapse=0 /
&effects  artificial_viscosity=.false. /
&material  name='rock'  density=1000  young=1e6  poisson=0.25 /
&region  name='r'  shape='box'  lo=0.4,0,0.4  hi=1.2,1,1.2 /
&body  name='b'  region='r'  material='rock'
  velocity_formula='1e-4*sin(57*x+3)*cos(31*z+1)','0','1e-4*sin(43*x)*cos(61*z+2)' /
&output  name='h'  kind='history'  every=50 /
"""
# h/c with the wave speed of uniaxial strain, 1.2 E at nu = 1/4; velocities are negligible
CROSSING = float(0.1 / np.sqrt(1.2e6 / 1000))
SHOCK = """&run  dimension='1d' /
&grid  lo=0,0,0  hi=2,1,1  dx=0.05 /
&time  t_end=1e-3  dt_fixed={step}  dt_collapse=0 /
&effects  strength=.false. /
&material  name='gas'  density=1  eos_model='ideal_gas'  ig_gamma=1.4 /
&region  name='r'  shape='box'  lo=0,0,0  hi=1,1,1 /
&body  name='b'  region='r'  material='gas'  velocity=-3000,0,0  specific_energy=2e5 /
&boundary  face='xlo'  type='slip' /
"""


def deck(method, courant, steps=600):
    """The block with a fixed step."""
    step = courant * CROSSING
    return DECK.format(method=method, step=repr(step), end=repr(steps * step))


def growth(run):
    """Greatest energy over that at the start."""
    total = run.history["kinetic"] + run.history["internal"]
    return np.nanmax(total) / total[0]


@pytest.mark.parametrize("method, refused, accepted", (("ddmp", 0.98, 0.75), ("mpm", 1.02, 1.0)))
def test_limit(options, sheet, method, refused, accepted):
    """A step above the limit is refused by the check and by the run, with the limit and a step to write instead; that
    step and one just below the limit are accepted, and with both the energy of an elastic block does not grow."""
    run = case.Case(options, f"{method}_above", deck(method, refused))
    for words in (("--check",), ("-q",)):
        text = " ".join(run.run(*words, expect=2).output.split())
        found = re.search(rf"{run.deck.name}:3: error: &time: dt_fixed is above the stability limit of the first "
                          r"state, (\S+); write dt_fixed = (\S+) or less", text)
        sheet.require(found is not None and "[D230]" in text, f"{method}: refused: {text}")
    limit, instead = (float(word.rstrip(";")) for word in found.groups())
    sheet.near(f"{method}: limit over h/c", limit / CROSSING, 0.96 if method == "ddmp" else 1.0, 1e-3)
    sheet.near(f"{method}: step to write over h/c", instead / CROSSING, 0.4, 1e-3)
    for courant in (instead / CROSSING, accepted):
        run = case.Case(options, f"{method}_{courant:.2f}", deck(method, courant)).run()
        sheet.require("stability limit" not in run.output, f"{method}: no warning at {courant:.2f}: {run.output}")
        sheet.below(f"{method}: growth of the energy at {courant:.2f} h/c", growth(run), 1.5)


def test_close(options, sheet):
    """Between the greatest step that is stable with all options and the limit there is a warning."""
    run = case.Case(options, "close", deck("ddmp", 0.9)).run("--check")
    said = "warning: &time: dt_fixed is 0.9375 times the stability limit"
    sheet.require(said in run.output and "[D231]" in run.output, f"warned: {run.output}")


def test_unstable(options, sheet):
    """With --force the step of the refusal is used, and the energy of the block grows without bound: it is unstable."""
    run = case.Case(options, "forced", deck("ddmp", 0.98, 2000)).run("-q", "--force", expect=None)
    sheet.require(run.code == 4 or growth(run) > 1e3, f"unstable: {run.code}, {growth(run)}")
    if run.code == 4:
        sheet.require("remove dt_fixed" in run.output, f"the failure names dt_fixed: {run.output}")


def test_later(options, sheet):
    """A step that is stable at first and not in the shock: the failure names dt_fixed, and no smaller cfl."""
    first = float(0.05 / (3000 + np.sqrt(1.4 * 0.4 * 2e5)))
    run = case.Case(options, "later", SHOCK.format(step=repr(0.9 * first))).run(expect=4)
    text = " ".join(run.output.split())
    said = r"dt_fixed = +\S+ s is +\S+ times the stable step before, +\S+ s with cfl = 0\.40; write that or less, or "
    sheet.require(re.search(said + "remove dt_fixed", text) is not None, f"named: {text}")
    sheet.require("smaller cfl" not in text, f"no cfl: {text}")
