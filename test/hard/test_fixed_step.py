# SPDX-License-Identifier: BSD-3-Clause
# timeout: 200
"""Time steps that the deck fixes: above the stability limit they are refused, and a failure names them. The limit of
bars, and the growth of a lattice that moves through its cells, follow from the operator of the nodes.

Would catch a step above the limit that --check accepts, a limit that refuses stable steps or accepts unstable ones, and
a run that fails because of dt_fixed and recommends a smaller cfl, which has no effect then; forces, strains or mappings
that are stiffer than the equations at some positions of the particles, such as in light cells at surfaces; an update of
the stress that amplifies moving material faster than (T.9).
"""

import re

import numpy as np
import pytest

import case
import measured
import stable_step

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

BAR = """&run  dimension='1d'  method='{method}' /
&grid  lo=0,0,0  hi=1.6,1,1  dx=0.1 /
&time  t_end={end!r}  dt_fixed={step!r}  dt_collapse=0 /
&method  {words}  flip=1 /
&effects  artificial_viscosity=.false. /
&material  name='rock'  density=1000  young=1e6  poisson=0.25 /
&region  name='r'  shape='points'  file='points.csv'  point_volume=0.05 /
&body  name='b'  region='r'  material='rock'  packing='file' /
{faces}
&output  name='h'  kind='history'  every={every} /
&checkpoint  at_end=.false. /
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
    """With --force the step of the refusal is used, and with `usl`, whose limit it is, the energy of the block grows
    without bound."""
    text = deck("ddmp", 0.98, 2000) + "&method  stress_update='usl' /\n"
    run = case.Case(options, "forced", text).run("-q", "--force", expect=None)
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


def bar(options, name, method, words, courant, steps, offset=None, speed=0.0, every=50):
    """A bar of 12 cells with a free cell at its ends, or one that fills a periodic grid; speed over that of waves."""
    step = float(courant * CROSSING / (1.0 + speed))
    faces = "" if offset is not None else "\n".join(f"&boundary  face='{face}'  type='periodic' /"
                                                    for face in ("xlo", "xhi"))
    x = 0.1 * (stable_step.lattice(16, 2) if offset is None else stable_step.lattice(12, 2, 2.0 + offset))
    noise = 1e-4 * (np.sin(57 * x + 3) + np.cos(31 * x + 1))
    run = case.Case(options, name, BAR.format(method=method, words=words, step=step, end=steps * step, faces=faces,
                                              every=every))
    points = np.stack([x, 0.0 * x + 0.5, 0.0 * x + 0.5, speed * 0.1 / CROSSING + noise, 0.0 * x, 0.0 * x], axis=1)
    np.savetxt(run.folder / "points.csv", points, delimiter=",", comments="", header="x,y,z,vx,vy,vz")
    return run.run("-q", "--force", expect=None)


@pytest.mark.parametrize("method, words, offset, control", (
    ("ddmp", "stress_update='usl' quadrature='point'", 0.4, False),
    ("ddmp", "stress_update='usl' quadrature='control'", 0.4, True),
    ("ddmp", "stress_update='usavg' quadrature='control'", 0.25, True),
    ("mpm", "stress_update='usl'", 0.3, False), ("mpm", "stress_update='musl'", 0.3, False)))
def test_positions(options, sheet, method, words, offset, control):
    """A free bar whose ends are within cells: stable for 5000 steps of 0.95 of the limit of the operator, and unstable
    at 1.2. So close to the limit the energy of leapfrog oscillates by 1/(1 - 0.95^2)."""
    body = stable_step.Operator(stable_step.lattice(12, 2, 2.0 + offset), 0.5, 16, method == "ddmp", control)
    limit = body.limits()[0 if "'usl'" in words else 1]
    run = bar(options, "below", method, words, 0.95 * limit, 5000, offset)
    sheet.require(run.code == 0 and run.summary["steps"] == 5000, "5000 steps")
    sheet.below(f"{method} {words}: greatest energy", growth(run), 1.0 / (1.0 - 0.95**2))
    run = bar(options, "above", method, words, 1.2 * limit, 5000, offset)
    sheet.require(run.code == 4 or growth(run) > 1e3, f"unstable at 1.2 of the limit: {run.code}, {growth(run)}")


def test_drift(options, sheet):
    """A lattice that moves through 60 cells: its amplitude grows with usavg as the product of its steps does. 10 %
    of the exponent are a factor of 1.2 between the amplitudes, which other modes may still have after 20 cells."""
    speed, cells, courant = 0.1, 60, 0.8
    exact = stable_step.growth("usavg", courant, speed, cells=16, control=True)
    steps = int(cells * (1.0 + speed) / (speed * courant))
    run = bar(options, "drift", "ddmp", "stress_update='usavg' quadrature='control'", courant, steps, speed=speed,
              every=1)
    energy = run.history["internal"]
    third, width = len(energy) // 3, 40
    rate = 0.5 * np.log(energy[-width:].max() / energy[third - width:third].max()) / (cells * 2.0 / 3.0)
    sheet.near("growth of the amplitude for each cell", rate, exact, 0.1)


def test_map():
    """The limits for many positions, and the growth with the length of the step: numbers of doc/theory/time_step.md."""
    rng = np.random.default_rng(1)
    for name, dual, control in (("mpm", False, False), ("point", True, False), ("control", True, True)):
        for ppc in (1, 2, 3):
            places = {"inside": [stable_step.lattice(8, ppc, k / (8 * ppc)) % 8 for k in range(8)],
                      "ends": [stable_step.lattice(8, ppc, 2.0 + k / 16) for k in range(16)],
                      "jitter": [(stable_step.lattice(8, ppc) + (rng.random(8 * ppc) - 0.5) / ppc) % 8
                                 for _ in range(8)]}
            for where, some in places.items():
                limits = [stable_step.Operator(x, 1.0 / ppc, 12 if where == "ends" else 8, dual, control,
                                               where != "ends").limits() for x in some]
                measured.record(f"{name} {ppc} {where}", dict(zip(("usl", "musl"), np.min(limits, axis=0))))
    for update, control in (("usavg", True), ("musl", False), ("usl", False)):
        rates = {f"{100 * courant:.0f}": stable_step.growth(update, courant, 0.1, control=control)
                 for courant in (0.2, 0.4, 0.5, 0.6, 0.8)}
        measured.record(f"drift {update}", rates)
