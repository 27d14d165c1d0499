# SPDX-License-Identifier: BSD-3-Clause
"""Particles on faces, edges and corners of cells and one rounding beside them; the same at the boundaries of the box.

Would catch: a particle that two cells or none own, mass missing at the nodes, a result that jumps when a particle is
one rounding on the other side of a face, mass, momentum or energy that leaves through an edge or a corner without being
recorded.
"""
# timeout: 120

import itertools

import numpy as np

import case

# Particles begin in the middles of cells; half a cell of flight per step brings them to nodes.
DECK = """
&run  dimension='{dimension}'  method='{method}' /
&method  {words} /
&grid  lo=0,0,0  hi=8,8,8  dx=1 /
&time  t_end=1  max_steps={steps}  {time} /
&material  name='al'  density=2785  eos_model='mie_gruneisen'  mg_c0=5328  mg_s=1.338  mg_gamma=2
  shear=27.6e9 /
&region  name='box'  shape='box'  {region} /
&body  name='block'  region='box'  material='al'  ppc=1,1,1  velocity={velocity}
  specific_energy={energy} /
{faces}
&output  name='p'  kind='particles'  every={every}  precision='double'
  fields='identity','velocity','stress','volume','mass' /
&output  name='h'  kind='history'  every=1 /
&checkpoint  at_end=.false. /
"""
STEP = 1.0e-5


def flight(options, name, steps, away):
    """A block under pressure whose particles move onto nodes, or to a distance `away` from them [cell]."""
    speed = 0.5 * (1.0 + away) / STEP
    run = case.Case(options, name, DECK.format(
        dimension="3d", method="ddmp", words="", steps=steps, every=steps, time=f"dt_fixed={STEP}",
        region="lo=2,2,2 hi=5,5,4", velocity=f"{speed!r},{speed!r},{speed!r}", energy=1.0e4,
        faces="&boundary face='all' type='periodic' /")).run("-q", "--force")
    first, last = (run.snapshots()[n][1] for n in (0, -1))
    order = np.argsort(last.fields["identity"])
    sheet_mass = last.fields["mass"].sum() / first.fields["mass"].sum() - 1.0
    return last.points[order], {k: v[order] for k, v in last.fields.items()}, sheet_mass, run


def test_beside_nodes(options, sheet):
    """Exactly on nodes, one rounding before and one behind: the same stress one step later."""
    tiny = 2.0**-51
    # rounding errors of nine steps add up
    for steps, limit in ((2, 1.0e-12), (9, 1.0e-11)):
        runs = [flight(options, f"beside_{steps}_{n}", steps, n * tiny) for n in (-1, 0, 1)]
        stress = [fields["stress"] for _, fields, _, _ in runs]
        scale = np.abs(stress[1]).max()
        sheet.require(scale > 1.0e7 and len(stress[0]) == 18, f"beside: there is stress: {scale}")
        for n, side in ((0, "before"), (2, "behind")):
            sheet.below(f"beside, {steps} steps: stress {side} a node",
                        np.abs(stress[n] - stress[1]).max() / scale, limit)
            apart = np.abs(runs[n][0] - runs[1][0])
            sheet.below(f"beside, {steps} steps: places {side}",
                        np.minimum(apart, 8.0 - apart).max() / 8.0, 1.0e-12)
            sheet.below(f"beside, {steps} steps: mass {side}", runs[n][2], 1.0e-14)


def test_leave(options, sheet):
    """An isolated particle leaves through each face, edge and corner; the balances have no error."""
    worst = np.zeros(4)
    count = 0
    for way in itertools.product((-1, 0, 1), repeat=3):
        if way == (0, 0, 0):
            continue
        count += 1
        velocity = 1.0e4 * np.array(way)
        run = case.Case(options, "leave", DECK.format(
            dimension="3d", method="ddmp", words="", steps=100000, every=100000,
            time="dt_max=3.0e-5", region="lo=3,3,3 hi=4,4,4", faces="", energy=0.0,
            velocity=",".join(str(part) for part in velocity))).run("-q", "--force", "-s", "time.t_end=8.0e-4")
        ledger = run.summary["ledger"]
        sheet.require(run.summary["particles"] == 0, f"leave {way}: has left")
        start, end = ledger["start"], ledger["end"]
        lost = np.array([end[f"lost_momentum_{axis}"] for axis in "xyz"])
        worst = np.maximum(worst, [abs(end["lost_mass"] / start["mass"] - 1.0),
                                   np.abs(lost / start["mass"] - velocity).max() / 1.0e4,
                                   abs(end["lost_energy"] / start["kinetic"] - 1.0),
                                   ledger["energy_error"]])
    sheet.require(count == 26, "leave: six faces, twelve edges, eight corners")
    for name, value in zip(("mass", "momentum", "energy", "total energy"), worst):
        sheet.below(f"leave, 26 ways: {name}", value, 1.0e-12)


def test_cloud(options, sheet):
    """A cloud that its pressure expands leaves at 10 km/s through all open boundaries."""
    run = case.Case(options, "cloud", DECK.format(
        dimension="3d", method="ddmp", words="", steps=100000, every=100000, time="",
        region="lo=3,3,3 hi=6,6,6", faces="", energy=3.0e7,
        velocity="1.0e4,2.0e3,-3.0e3")).run("-q", "--force", "-s", "time.t_end=1.5e-3")
    ledger, table = run.summary["ledger"], run.history
    sheet.require(run.summary["particles"] < 20, f"cloud: {run.summary['particles']} are left")
    books = np.abs(table["mass"] + table["lost_mass"] - table["mass"][0]).max() / table["mass"][0]
    sheet.below("cloud: mass at all times", books, 1.0e-12)
    sheet.below("cloud: momentum", ledger["momentum_error"], 1.0e-12)
    sheet.below("cloud: energy", ledger["energy_error"], 1.0e-12)
