# SPDX-License-Identifier: BSD-3-Clause
# tiers: smoke, full
"""Inflowing material: its mass, the balance, and the force of a jet on a wall.

Would catch a particle that enters twice or not at all, a gap between copies of the body, a speed that is not that of
the deck, a flow that does not end, and a jet that loses its momentum. A plane jet of width b, density rho and speed v
that spreads along a wall exerts the force rho b v^2 per depth on it (momentum theorem).
"""

import numpy as np

import case

DENSITY, SPEED, WIDTH, DEPTH = 1000.0, 5.0, 0.02, 0.01
JET = f"""
&run  dimension='{{dimension}}' /
&grid  lo={{lo}}  hi=0.05,{DEPTH},0.1  dx=0.0025 /
&time  t_end={{end}} /
&method  transfer='{{transfer}}' /
&material  name='water'  density={DENSITY}  eos_model='tait'  tait_n=7  bulk=1e7  strength_model='newtonian'
  viscosity=1e-3 /
&region  name='nozzle'  shape='box'  lo=-0.01,0,0.08  hi=0.01,{DEPTH},0.1 /
&body  name='jet'  region='nozzle'  material='water' /
&inflow  body='jet'  {{flow}} /
&boundary  face='zlo'  type='{{floor}}' /
&output  name='h'  kind='history'  every=1 /
&output  name='f'  kind='forces'  dt=1e-4 /
"""
SPACE = """
&run  dimension='3d' /
&grid  lo=0,0,0  hi=0.04,0.04,0.08  dx=0.005 /
&time  t_end=0.005 /
&material  name='clay'  density=2000  young=1e6  poisson=0.3  strength_model='von_mises'  yield=1e4 /
&region  name='die'  shape='cylinder'  centre=0.01,0.02,0.02  axis=1,0,0  radius=0.01  height=0.02 /
&body  name='bar'  region='die'  material='clay'  packing='cut' /
&inflow  body='bar'  velocity=1,0,0  mass_rate=2 /
&output  name='h'  kind='history'  every=1 /
"""


def balance(sheet, name, run, limit=1e-12):
    """Errors of the ledger at the end."""
    for what in ("mass", "momentum", "energy"):
        sheet.below(f"{name}: error of the {what}", abs(run.history[f"{what}_error"]).max(), limit)


def test_free(options, sheet):
    """Before the jet reaches the wall all moving material has the speed of the flow."""
    deck = JET.format(dimension="plane_strain", lo="-0.05,0,0", end=0.014, transfer="flip", flow="velocity=0,0,-5",
                      floor="slip")
    run = case.Case(options, "free", deck).run("-q")
    rows = run.history
    balance(sheet, "free", run)
    layer = DENSITY * WIDTH * DEPTH * 0.00125
    entered = -rows["lost_mass"]
    wrong = entered - DENSITY * WIDTH * DEPTH * SPEED * rows["time"]
    sheet.below("free: mass that has entered, over that of a layer", abs(wrong).max() / layer, 0.5 + 1e-6)
    sheet.below("free: kinetic energy over that of the speed, less 1",
                abs(rows["kinetic"] / (0.5 * rows["mass"] * SPEED**2) - 1.0).max(), 1e-12)
    sheet.below("free: elastic energy over the kinetic one", (rows["internal"] / rows["kinetic"]).max(), 1e-12)


def test_stopped(options, sheet):
    """A flow that starts from rest and ends: the integral of its table."""
    folder = case.Case(options, "stopped", JET.format(
        dimension="plane_strain", lo="-0.05,0,0", end=0.012, transfer="flip",
        flow="velocity=0,0,0  table='speed.csv'  t_off=0.01", floor="slip"))
    (folder.deck.parent / "speed.csv").write_text("0, 0, 0, 0\n0.004, 0, 0, -5\n", encoding="utf-8")
    run = folder.run("-q")
    layer = DENSITY * WIDTH * DEPTH * 0.00125
    sheet.below("table: mass less that of the integral, over that of a layer",
                abs(-run.history["lost_mass"][-1] - DENSITY * WIDTH * DEPTH * SPEED * 0.008) / layer, 1.0)
    late = run.history["time"] > 0.0101
    sheet.require(np.ptp(run.history["lost_mass"][late]) == 0.0, "nothing enters after t_off")


def test_rate(options, sheet):
    """A bar in 3-D with a given mass per time."""
    run = case.Case(options, "rate", SPACE).run("-q")
    balance(sheet, "rate", run)
    layer = run.history["mass"][0] / 8.0
    sheet.below("rate: mass less rate times time, over that of a layer",
                abs(-run.history["lost_mass"][-1] - 2.0 * 0.005) / layer, 0.5 + 1e-6)


def test_wall(options, sheet):
    """The steady force on the wall."""
    transfer = "flip"
    deck = JET.format(dimension="plane_strain", lo="-0.05,0,0", end=0.05, transfer=transfer, flow="velocity=0,0,-5",
                      floor="slip")
    run = case.Case(options, f"wall_{transfer}", deck).run("-q")
    rows = np.genfromtxt(run.path("_forces.csv"), delimiter=",", names=True, deletechars="", replace_space=" ")
    steady = rows["time [s]"] >= 0.03
    push = rows["zlo_impulse_z [N s]"][steady]
    force = -(push[-1] - push[0]) / np.ptp(rows["time [s]"][steady])
    sheet.near(f"{transfer}: force on the wall", force, DENSITY * WIDTH * DEPTH * SPEED**2, 0.02)
    sheet.below(f"{transfer}: error of the momentum", abs(run.history["momentum_error"]).max(), 1e-12)
