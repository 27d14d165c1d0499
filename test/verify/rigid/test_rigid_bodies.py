# SPDX-License-Identifier: BSD-3-Clause
"""Rigid regions that forces move: a ram on an elastic block, a piston on gas, a disc that floats, a disc that turns
on a bed; free flight; and a drum that turns at a given rate.

Would catch: an impulse that material and body receive with different values, or at different times; torque about a
wrong point or with a wrong sign; gravity that is missing or acts twice; a mass or inertia that is not that of the
shape; added mass that is not solved with the body, so that a light one is unstable; a rotation that does not follow the
spin; friction without its torque; work that is not the change of the kinetic energy.

Limits. Balances: rounding. Piston: nodes act in steps of a cell, the amplitude is eight cells. Disc that floats: its
force is the weight if it is at rest; the residual velocity over the time of the mean is below a percent of g. Disc on a
bed: the radius at which nodes act is up to half a cell, a tenth, greater than its own.
"""
# timeout: 300

import math

import numpy as np

import case

STORING = ("eos_model='mie_gruneisen'  mg_c0=32  mg_s=1.3  mg_gamma=1.5  shear=0.6e6  strength_model='elastic'")
END = """
&output  name='r'  kind='rigid'  count={count} /
&checkpoint  at_end=.false. /
"""

RAM = """
&run  dimension='{dimension}' /
&grid  lo=-0.5,{low},0  hi=0.5,{high},1.2  dx={dx} /
&time  t_end=0.2 /
&effects  gravity=.true.  gravity_vector=0,0,-9.81 /
&boundary  face='zlo'  type='stick' /
&material  name='m'  density=1000  {storing} /
&region  name='block'  shape='box'  lo=-0.3,-0.3,0  hi=0.3,1,0.5 /
&body  name='block'  region='block'  material='m' /
&region  name='ram'  shape='box'  lo=-0.21,-0.2,-0.1  hi=0.21,0.2,0.1  rotate={turn}  translate=0.02,{middle},0.7 /
&boundary  region='ram'  {words}  velocity=0,0,-1  spin={spin} /
"""

PISTON = """
&run  dimension='1d' /
&grid  lo=0,0,0  hi=1.5,1,1  dx=0.02 /
&time  t_end=1.25 /
&effects  gravity=.true.  gravity_vector=-100,0,0  artificial_viscosity=.false.  strength=.false. /
&boundary  face='xlo'  type='slip' /
&material  name='gas'  density=1  eos_model='ideal_gas'  ig_gamma=1.4 /
&region  name='gas'  shape='box'  lo=0,0,0  hi=1,1,1 /
&body  name='gas'  region='gas'  material='gas'  ppc=4,1,1  specific_energy=25000 /
&region  name='piston'  shape='box'  lo=1,0,0  hi=1.2,1,1 /
&boundary  region='piston'  type='slip'  mass=100  velocity=-1.6,0,0 /
"""

FLOAT = """
&run  dimension='plane_strain' /
&grid  lo=0,0,0  hi=1,1,0.8  dx=0.05 /
&time  t_end=2.4 /
&effects  gravity=.true.  gravity_vector=0,0,-10  strength=.false.  damping=6 /
&boundary  face='zlo'  type='slip' /
&boundary  face='xlo'  type='slip' /
&boundary  face='xhi'  type='slip' /
&material  name='w'  density=1000  bulk=1e5 /
&region  name='pool'  shape='box'  lo=0,0,0  hi=1,1,0.5 /
&region  name='disc'  shape='cylinder'  centre=0.5,0.5,0.52  axis=0,1,0  radius=0.2  height=2 /
&region  name='rest'  shape='difference'  of='pool','disc' /
&body  name='w'  region='rest'  material='w'  ppc=2,1,2 /
&boundary  region='disc'  type='slip'  density=500 /
"""

TURNING = """
&run  dimension='plane_strain' /
&grid  lo=0,0,0  hi=0.6,1,0.5  dx=0.02 /
&time  t_end=0.2 /
&effects  gravity=.true.  gravity_vector=0,0,-10  damping=5 /
&boundary  face='zlo'  type='stick' /
&material  name='m'  density=1000  bulk=1.0e6  shear=0.6e6 /
&region  name='bed'  shape='box'  lo=0.1,0,0  hi=0.5,1,0.2 /
&body  name='bed'  region='bed'  material='m'  ppc=2,1,2 /
&region  name='disc'  shape='cylinder'  centre=0.3,0.5,0.31  axis=0,1,0  radius=0.1  height=2 /
&boundary  region='disc'  type='friction'  friction=0.3  density=1000  spin=0,20,0  lock='x' /
"""

DRUM = """
&run  dimension='plane_strain' /
&grid  lo=-0.55,0,-0.55  hi=0.55,1,0.55  dx=0.05 /
&time  t_end=0.4 /
&effects  gravity=.true.  gravity_vector=0,0,-10 /
&material  name='m'  density=1500  eos_model='mie_gruneisen'  mg_c0=20  mg_s=1.3  mg_gamma=1.5  shear=1e5
  strength_model='elastic' /
&region  name='all'  shape='box'  lo=-0.6,0,-0.6  hi=0.6,1,0.6 /
&region  name='round'  shape='cylinder'  centre=0,0.5,0  axis=0,1,0  radius=0.4  height=2 /
&region  name='low'  shape='box'  lo=-0.5,0,-0.5  hi=0.5,1,-0.1 /
&region  name='fill'  shape='intersection'  of='round','low' /
&region  name='drum'  shape='difference'  of='all','round' /
&body  name='m'  region='fill'  material='m'  ppc=2,1,2 /
&boundary  region='drum'  type='stick'  spin=0,1,0  centre=0,0.5,0 /
&output  name='h'  kind='history'  fields='external_work','potential'  count=20 /
"""


def rows(run):
    """The columns of the table of rigid bodies, by name without the unit."""
    text = run.path("_rigid.csv").read_text(encoding="utf-8").splitlines()
    names = [word.strip().split(" [")[0] for word in text[0].split(",")]
    numbers = np.array([[float(word) for word in line.split(",")] for line in text[1:]])
    return dict(zip(names, numbers.T))


def run_of(options, name, deck, count=40):
    """Run a deck and return the run and its table of bodies."""
    run = case.Case(options, "bodies_" + name, deck + END.format(count=count)).run("-q")
    return run, rows(run)


def books(sheet, name, run, energy):
    """Momentum and energy of material and bodies."""
    ledger = run.summary["ledger"]
    sheet.below(f"{name}: momentum error", ledger["momentum_error"], 1.0e-13)
    sheet.below(f"{name}: energy error", abs(ledger["energy_error"]), energy)


def test_ram(options, sheet):
    """A ram falls on an elastic block, turns and rebounds; of twice its density and of a fiftieth."""
    plane = {"dimension": "plane_strain", "low": 0, "high": 1, "dx": 0.05, "turn": "0,10,0", "middle": 0.5,
             "spin": "0,0.5,0", "storing": STORING}
    space = {"dimension": "3d", "low": -0.4, "high": 0.4, "dx": 0.1, "turn": "10,20,5", "middle": 0,
             "spin": "1,0.5,-2", "storing": STORING}
    for name, words, kind, thick in (
            ("heavy", plane, "type='friction'  friction=0.3  density=2000", 1.0),
            ("light", plane, "type='stick'  density=20", 1.0),
            ("space", space, "type='friction'  friction=0.5  density=2000", 0.4)):
        run, table = run_of(options, "ram_" + name, RAM.format(words=kind, **words))
        books(sheet, f"ram, {name}", run, 1.0e-12)
        density = float(kind.split("density=")[1])
        mass = density * 0.42 * 0.2 * thick
        start, end = run.summary["ledger"]["start"], run.summary["ledger"]["end"]
        sheet.near(f"ram, {name}: momentum at the start over that of its volume",
                   start["rigid_momentum_z"] / -mass, 1.0, 1.0e-3)
        # forces of the material and weight are the change of momentum; work is the change of energy
        push = np.sum(table["ram_force_z"][1:] * np.diff(table["time"]))
        gain = end["rigid_momentum_z"] - start["rigid_momentum_z"]
        # it starts with 1 m/s downwards, so this momentum is minus its mass
        weight = 9.81 * start["rigid_momentum_z"] * table["time"][-1]
        sheet.near(f"ram, {name}: impulse and weight over the gain of momentum", (push + weight) / gain, 1.0, 2.0e-2)
        work = table["ram_work"][-1] + table["ram_weight_work"][-1]
        sheet.below(f"ram, {name}: energy that is not work, over the energy at the start",
                    abs(table["ram_kinetic"][-1] - table["ram_kinetic"][0] - work) / table["ram_kinetic"][0], 1.0e-12)
        sheet.above(f"ram, {name}: it has been thrown back [m/s]", table["ram_velocity_z"].max(), 0.1)
        sheet.below(f"ram, {name}: greatest speed over that at the start", np.abs(table["ram_velocity_z"]).max(), 2.0)


def test_free_flight(options, sheet):
    """A body above the block falls on a parabola and turns by its spin."""
    deck = RAM.format(words="type='stick'  density=100", dimension="plane_strain", low=0, high=1, dx=0.05, turn="0,0,0",
                      middle=0.5, spin="0,3,0", storing=STORING).replace("0.5,0.7 /", "0.5,1.1 /").replace(
                          "velocity=0,0,-1", "velocity=0.2,0,0").replace("t_end=0.2", "t_end=0.1")
    _, table = run_of(options, "flight", deck)
    time = table["time"]
    # the first step of velocities at half steps is exact for constant gravity
    sheet.below("flight: height against the parabola [m]",
                np.abs(table["ram_z"] - 1.1 + 0.5 * 9.81 * time**2).max(), 1.0e-6)
    sheet.below("flight: way along x [m]", np.abs(table["ram_x"] - 0.02 - 0.2 * time).max(), 1.0e-14)
    sheet.below("flight: rotation", np.abs(table["ram_turn_y"] - np.sin(1.5 * time)).max(), 1.0e-9)


def test_force(options, sheet):
    """Would catch a force that is missing, divided by the wrong mass, or not in the work and the balances.

    A body without gravity moves as its force says, then pushes the block with it: the force is minus its weight.
    Velocities are those of half steps, so work and way differ by a step, 1/200 of the time.
    """
    words = "type='slip'  density=500  force=0,0,{force}"
    for name, start, end in (("free", "0.5,1.05 /", 0.08), ("pressed", "0.5,0.7 /", 0.2)):
        deck = RAM.format(words=words.format(force=-500.0 * 0.42 * 0.2 * 9.81), dimension="plane_strain", low=0, high=1,
                          dx=0.05, turn="0,0,0", middle=0.5, spin="0,0,0", storing=STORING)
        deck = deck.replace("0.5,0.7 /", start).replace("velocity=0,0,-1", "velocity=0,0,0")
        deck = deck.replace("t_end=0.2", f"t_end={end}")
        deck = deck.replace("gravity=.true.  gravity_vector=0,0,-9.81", "damping=0")
        run, table = run_of(options, "force_" + name, deck)
        books(sheet, f"force, {name}", run, 1.0e-12)
        time, gain = table["time"], table["ram_kinetic"][-1] - table["ram_work"][-1]
        sheet.near(f"force, {name}: its work over force and way", table["ram_weight_work"][-1]
                   / (-500.0 * 0.42 * 0.2 * 9.81 * (table["ram_z"][-1] - table["ram_z"][0])), 1.0, 1.0e-2)
        sheet.near(f"force, {name}: its work over the other energy", table["ram_weight_work"][-1] / gain, 1.0, 1.0e-9)
        if name == "free":
            sheet.below("force, free: height against the parabola [m]",
                        np.abs(table["ram_z"] - 1.05 + 0.5 * 9.81 * time**2).max(), 2.0e-5)
        else:
            sheet.above("force, pressed: the block pushes back [N]", table["ram_force_z"].max(), 100.0)


def test_piston(options, sheet):
    """A piston rests on gas and oscillates: x tan x = mass of the gas over that of the piston, for waves in the gas."""
    run, table = run_of(options, "piston", PISTON, 1000)
    books(sheet, "piston", run, 1.0e-12)
    low, high = 1.0e-6, 1.0
    for _ in range(100):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if middle * math.tan(middle) < 0.01 else (low, middle)
    exact = 2.0 * math.pi / (low * math.sqrt(1.4 * 0.4 * 25000.0))
    time, speed = table["time"], table["piston_velocity_x"]
    turns = np.nonzero((speed[:-1] < 0.0) & (speed[1:] >= 0.0))[0]
    at = time[turns] - speed[turns] * (time[turns + 1] - time[turns]) / (speed[turns + 1] - speed[turns])
    at = at[np.append(True, np.diff(at) > 0.2 * exact)]
    sheet.above("piston: lower turning points", len(at), 2.5)
    sheet.near("piston: period over that of the closed form", (at[-1] - at[0]) / (len(at) - 1) / exact, 1.0, 0.02)


def test_floating_disc(options, sheet):
    """A disc of half the density of the fluid comes to rest: the fluid carries its weight, half of it is immersed."""
    run, table = run_of(options, "float", FLOAT, 120)
    sheet.below("float: momentum error", run.summary["ledger"]["momentum_error"], 1.0e-13)
    weight = 500.0 * math.pi * 0.2**2 * 10.0
    sheet.near("float: mean force of the fluid over the weight", table["disc_force_z"][-60:].mean() / weight, 1.0, 0.01)
    # the level: the area of the fluid at the start, and half of the disc
    angle = math.acos(0.02 / 0.2)
    under = 0.2**2 * (angle - math.sin(angle) * math.cos(angle))
    level = 0.5 - under + 0.5 * math.pi * 0.2**2
    sheet.below("float: height of the centre over the level, in cells",
                abs(table["disc_z"][-60:].mean() - level) / 0.05, 0.6)
    sheet.below("float: spin [1/s]", np.abs(table["disc_spin_y"]).max(), 1.0e-6)


def test_turning_disc(options, sheet):
    """A disc turns on a bed that carries it: friction times the pressure at its radius slows it."""
    run, table = run_of(options, "turning", TURNING)
    inertia = 1000.0 * math.pi * 0.1**4 / 2.0
    sheet.below("turning: momentum error", run.summary["ledger"]["momentum_error"], 1.0e-13)
    turn = np.sum(table["disc_torque_y"][1:] * np.diff(table["time"]))
    sheet.near("turning: angular impulse over the loss of angular momentum",
               turn / (inertia * (table["disc_spin_y"][-1] - 20.0)), 1.0, 1.0e-3)
    push = np.sum(table["disc_force_z"][1:] * np.diff(table["time"]))
    sheet.above("turning: it still turns [1/s]", table["disc_spin_y"][-1], 3.0)
    sheet.near("turning: torque over friction, pressure and radius", -turn / (0.3 * push * 0.1), 1.05, 0.06)


def test_drum(options, sheet):
    """A drum turns material that sticks to it: its work is the energy of the material, it turns at its rate."""
    run, table = run_of(options, "drum", DRUM, 20)
    books(sheet, "drum", run, 1.0e-12)
    history = run.history
    lifted = history["external_work"][-1] + history["potential"][-1] - history["potential"][0]
    sheet.near("drum: work over the energy that the material got", -table["drum_work"][-1] / lifted, 1.0, 1.0e-2)
    sheet.below("drum: rotation", np.abs(table["drum_turn_y"] - np.sin(0.5 * table["time"])).max(), 1.0e-14)
    power = -np.sum(table["drum_torque_y"][1:] * np.diff(table["time"])) * 1.0
    sheet.near("drum: torque times rate over the work", power / -table["drum_work"][-1], 1.0, 1.0e-12)
