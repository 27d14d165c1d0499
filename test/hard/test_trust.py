# SPDX-License-Identifier: BSD-3-Clause
"""Errors that balances cannot show: the line `trust`, its warnings, and runs that stop because a value is impossible.

Would catch: a valid scene that is not reported as ok, volumes that do not fit into the box without a warning, values
that depend on ranks, threads or a restart, a warning that is repeated at every check or names a particle that is not
the worst, a run that continues with a particle of more energy than the whole run.

Gas in a closed box must remain at rest. With irregular particles it does not: their volumes grow beyond the box, while
all balances close to rounding. On a lattice it is at rest, and all entries are ok.
"""
# tiers: smoke, full
# timeout: 300

import re

import numpy as np

import case
import tier

# Sums that are not normalised: uniform pressure exerts forces where particles are irregularly placed.
GAS = """
&run  dimension='plane_strain' /
&method  normalise='none' /
&grid  lo=0,0,0  hi=1,1,0.5  dx=0.05 /
&time  t_end=0.02 /
&effects  strength=.false.  eos=.true.  artificial_viscosity=.false. /
&material  name='gas'  density=100  eos_model='ideal_gas'  ig_gamma=1.4 /
&region  name='box'  shape='box'  lo=0,0,0  hi=1,1,0.5 /
&body  name='gas'  region='box'  material='gas'  specific_energy=2.0e5  packing='{packing}' /
&boundary  face='all'  type='slip' /
&output  name='h'  kind='history'  every=25  fields='default','overlap','noise','stretch' /
"""
# The step is several times the stable one.
JET = """
&run  dimension='plane_strain' /
&grid  lo=0,0,0  hi=8,1,4  dx=1 /
&time  t_end=0.1  dt_fixed=0.015  dt_collapse=0 /
&effects  strength=.false.  eos=.true. /
&material  name='gas'  density=100  eos_model='ideal_gas'  ig_gamma=1.4 /
&region  name='box'  shape='box'  lo=1,0,1  hi=3,1,3 /
&body  name='gas'  region='box'  material='gas'  velocity=100,0,0  specific_energy=1.0e3 /
&boundary  face='all'  type='slip' /
&output  name='p'  kind='particles'  count=1  precision='double'  fields='identity','velocity','energy','mass' /
"""
NAMED = re.compile(r"step (\d+), .*particle (\d+) of body")
SIGNS = {"speed": "times the speed that initial state", "heat": "times the energy supplied",
         "total": "more than the energy of the whole run"}


def warnings(run, words):
    """Lines of the log that contain some words."""
    return [line for line in run.path(".log").read_text().splitlines() if words in line]


def test_healthy(options, sheet):
    """Two discs: all entries are ok."""
    deck = (case.ROOT / "input" / "two_discs" / "scene.nml").read_text()
    run = case.Case(options, "discs", deck)
    run.run("-q", "-s", f"grid.dx={tier.choose(0.0125, smoke=0.025)}", "-s", "run.case='discs'")
    trust = run.summary["trust"]
    for name, entry in trust.items():
        if name != "verdict":
            sheet.require(entry["verdict"] == "ok", f"discs: {name} is ok: {entry}")
    sheet.require(trust["verdict"] == "ok" and len(trust) == 10, f"discs: all is ok: {trust}")
    sheet.above("discs: greatest distance of neighbours [cells]", trust["stretch"]["greatest"], 0.5)
    sheet.above("discs: noise was looked for", trust["noise"]["value"], 1.0e-6)
    sheet.require(not warnings(run, "warning: step"), "discs: no warning")
    sheet.require(len(warnings(run, "trust     ok: energy")) == 1, "discs: the line in the log")


def test_gas(options, sheet):
    """Gas at rest, on a lattice and irregularly placed; ranks, threads, a restart."""
    run = case.Case(options, "lattice", GAS.format(packing="lattice")).run("-q")
    sheet.require(run.summary["trust"]["verdict"] == "ok", f"lattice: ok: {run.summary['trust']}")
    sheet.below("lattice: volume beyond that there is", run.summary["trust"]["volume"]["value"], 1.0e-6)
    for packing in tier.choose(("jitter", "poisson_disk"), smoke=("jitter",)):
        deck = GAS.format(packing=packing)
        run = case.Case(options, packing, deck).run("-q")
        trust = run.summary["trust"]
        sheet.below(f"{packing}: error of energy", abs(run.summary["ledger"]["energy_error"]), 1.0e-12)
        sheet.require(trust["volume"]["verdict"] == "bad" and trust["verdict"] == "bad", f"{packing}: bad: {trust}")
        said = warnings(run, "more volume than the cells that they fill")
        sheet.require(len(said) == 1, f"{packing}: one warning: {said}")
        # the column has every 25th step; the run checks some of these and the last one
        column = run.history["overlap"]
        sheet.require(column.max() >= trust["volume"]["value"] >= column[-1], f"{packing}: the column agrees")
        sheet.require(not run.history["stretch"].any(), f"{packing}: a fluid has no neighbours")
        for ranks, threads in tier.choose(((1, 2), (3, 1)), smoke=((2, 1),)):
            other = case.Case(options, f"{packing}_{ranks}_{threads}", deck, ranks, threads).run("-q")
            sheet.require(other.summary["trust"] == trust, f"{packing}, {ranks} x {threads}: the same values")
            sheet.require(warnings(other, "more volume than the cells that they fill") == said,
                          f"{packing}, {ranks} x {threads}: the same words")
    again = case.Case(options, "again", deck)
    again.run("-q", "-s", "time.max_steps=310")
    sheet.require(len(warnings(again, "more volume than the cells that they fill")) == 1,
                  "again: one warning before the restart")
    again.run("-q", "--restart")
    sheet.require(again.summary["trust"] == trust, f"again: the same values: {again.summary['trust']}, {trust}")
    sheet.require(not warnings(again, "more volume than the cells that they fill"), "again: none after it")


def test_impossible(options, sheet):
    """A run with errors: the particles that are named are the worst ones."""
    words = []
    for ranks, threads in ((1, 1), (2, 2)):
        run = case.Case(options, f"jet_{ranks}_{threads}", JET, ranks, threads)
        run.run("-q", "--force", expect=4)
        words.append([line for sign in SIGNS.values() for line in warnings(run, sign)])
        sheet.require(run.summary["trust"]["verdict"] == "bad", "jet: bad")
        sheet.require(run.summary["trust"]["heat"]["verdict"] == "bad", f"jet: heat is bad: {run.summary['trust']}")
    sheet.require(len(words[0]) == 3 and words[0] == words[1], f"jet: the same words: {words}")
    fields = run.snapshots()[-1][1].fields
    speed = np.linalg.norm(fields["velocity"], axis=1)
    energy = fields["energy"]
    shown = {"speed": speed, "heat": energy if energy.max() > -4.0 * energy.min() else -energy,
             "total": fields["mass"] * (0.5 * speed ** 2 + energy)}
    for (name, values), line in zip(shown.items(), words[0]):
        named = NAMED.search(line)
        sheet.require(named is not None and int(named.group(1)) == run.summary["steps"],
                      f"jet: step and particle: {line}")
        # mirrored particles differ by rounding
        worst = fields["identity"][values >= values.max() * (1.0 - 1.0e-12)]
        sheet.require(named is not None and int(named.group(2)) in worst and len(worst) < 3,
                      f"jet, {name}: the worst particle is named: {line}")
    total = sum(run.summary["ledger"]["start"][name] for name in ("kinetic", "internal"))
    sheet.above("jet: energy of the particle over all there is", shown["total"].max() / total, 2.0)
