# SPDX-License-Identifier: BSD-3-Clause
"""Histories of single bodies and contact forces between bodies.

Would catch: a force that is assigned to another pair or has the wrong sign, one that is counted twice at nodes that
tiles or ranks share, the second side of a failed body that is left out, a repeated step that counts twice, sums over
the particles of another body, an output that changes the run, friction that is not mu times the normal force,
and fragments of several bodies in contact.

Momentum of a body changes by the impulses of contact, walls and gravity alone: the residual is rounding, 1e-12 of the
greatest impulse after some hundred steps. The time over which gravity acts on the particles is the same for both bodies
of the slope, so their residuals over their weights agree. Friction: at all nodes below the block, apart from those at
its two edges, the normal is that of the floor, so the impulses differ from mu by less than the target of the sliding
block of test/hard/test_contact.py, 1e-3; the rows in which the block is pressed on the floor with at least its weight
are within one cell of the eight below it.
"""

import numpy as np
import pytest

import case

ALONG, DOWN, FRICTION, SETTLED = 3.420201433256687, -9.396926207859083, 0.2, 0.039
SLIDE = f"""
&run  dimension='plane_strain' /
&grid  lo=0,0,0  hi=1.2,1,0.5  dx=0.05 /
&time  t_end=0.3 /
&effects  artificial_viscosity=.false.  contact=.true.  gravity=.true.  gravity_vector={ALONG},0,{DOWN} /
&material  name='m'  density=1000  young=1e6  poisson=0.3 /
&region  name='floor'  shape='box'  lo=0,0,0  hi=1.2,1,0.2 /
&region  name='block'  shape='box'  lo=0.2,0,0.2  hi=0.6,1,0.4 /
&body  name='floor'  region='floor'  material='m'  ppc=2,1,2 /
&body  name='block'  region='block'  material='m'  ppc=2,1,2 /
&contact  bodies='floor','block'  friction={FRICTION} /
&boundary  face='zlo'  type='stick' /
&boundary  face='xlo'  type='symmetry' /
&boundary  face='xhi'  type='symmetry' /
"""
OUTPUTS = """
&output  name='block'  kind='history'  bodies='block'  every=10  fields='default','tail_z' /
&output  name='all'    kind='history'  every=10  fields='default','centre_x' /
&output  name='floor'  kind='history'  bodies='floor'  every=10 /
&output  name='f'      kind='forces'   contacts='block','floor'  walls='zlo'  every=10 /
"""
# three bodies of which one fails and has contact with itself
THREE = """
&run  dimension='plane_strain' /
&grid  lo=0,0,0  hi=1,1,1  dx=0.05 /
&time  t_end=0.06 /
&method  {method} /
&effects  contact=.true.  damage=.true. /
&material  name='m'  density=1000  young=1e5  poisson=0.3 /
&material  name='weak'  density=700  young=1e5  poisson=0.3  damage_model='principal_stress'  failure_stress=500 /
&region  name='a'  shape='box'  lo=0.1,0,0.1  hi=0.5,1,0.5 /
&region  name='b'  shape='box'  lo=0.5,0,0.15  hi=0.9,1,0.5 /
&region  name='c'  shape='box'  lo=0.35,0,0.5  hi=0.65,1,0.8 /
&body  name='a'  region='a'  material='m'  ppc=2,1,2  velocity=2,0,0 /
&body  name='b'  region='b'  material='m'  ppc=2,1,2  velocity=-2,0,0 /
&body  name='c'  region='c'  material='weak'  ppc=2,1,2  velocity=0.1,0,-2 /
&contact  friction=0.3 /
&contact  bodies='c','c'  friction=0.3 /
&output  name='f'  kind='forces'  contacts='c','a','b'  every=10 /
&output  name='a'  kind='history'  bodies='a'  every=10 /
&output  name='b'  kind='history'  bodies='b'  every=10 /
&output  name='c'  kind='history'  bodies='c'  every=10 /
"""
BALL = """
&run  dimension='axisymmetric' /
&grid  lo=0,0,0  hi=0.006,1,0.008  dx=0.0004 /
&time  t_end=0.6e-6 /
&effects  contact=.true. /
&material  name='m'  preset='al_2024_t351' /
&region  name='ball'   shape='sphere'  centre=0,0,0.005  radius=0.002 /
&region  name='plate'  shape='box'  lo=0,0,0.002  hi=0.006,1,0.003 /
&body  name='plate'  region='plate'  material='m'  ppc=2,1,2 /
&body  name='ball'   region='ball'   material='m'  ppc=2,1,2  velocity=0,0,-2000 /
&boundary  face='xlo'  type='symmetry' /
&output  name='f'  kind='forces'  contacts='ball','plate'  every=5 /
&output  name='ball'  kind='history'  bodies='ball'  every=5 /
"""


def table(run, name):
    """Columns of a table, without their units."""
    names = np.genfromtxt(run.path(f"_{name}.csv"), delimiter=",", names=True, deletechars="", replace_space=" ")
    return {word.split(" [")[0]: names[word] for word in names.dtype.names}


@pytest.fixture(scope="module")
def slope(file_options):
    """The block on the slope with all outputs."""
    return case.Case(file_options, "slope", SLIDE + OUTPUTS).run("-q")


def test_balance(slope, sheet):
    """Momentum of each body, and bodies against the whole."""
    forces, block, floor = table(slope, "forces"), table(slope, "block_history"), table(slope, "floor_history")
    whole = slope.history
    for name in ("mass", "momentum_x", "momentum_z", "kinetic", "internal", "angular_momentum_y"):
        scale = abs(whole[name]).max()
        sheet.require(scale > 0.0, f"{name} is not 0")
        sheet.below(f"{name}: sum of the bodies less the whole, over it",
                    abs(block[name] + floor[name] - whole[name]).max() / scale, 1.0e-13)
    impulse = forces["block_floor_impulse_z"]
    sheet.require(impulse.min() < -50.0, "the block presses on the floor")
    falling = (block["momentum_z"] + impulse) / block["mass"]
    other = (floor["momentum_z"] - impulse + forces["zlo_impulse_z"]) / floor["mass"]
    sheet.below("gravity on the block less that on the floor, over the impulse per mass",
                abs(falling - other).max() / abs(impulse / block["mass"]).max(), 1.0e-12)
    sheet.near("it is that of the time", falling[-1], DOWN * forces["time"][-1], 5.0e-3)
    along = block["momentum_x"] + forces["block_floor_impulse_x"]
    sheet.below("along the slope: the same time, over it", abs(along / block["mass"] / ALONG - falling / DOWN).max()
                / forces["time"][-1], 1.0e-12)
    middle = 0.4 + np.concatenate(
        ([0.0], np.cumsum(0.5 * (block["velocity_x"][1:] + block["velocity_x"][:-1]) * np.diff(block["time"]))))
    sheet.below("centre of the block less the path of its velocity [m]", abs(block["centre_x"] - middle).max(), 1.0e-3)
    sheet.above("path of the block [m]", block["centre_x"][-1] - block["centre_x"][0], 0.03)
    sheet.near("lowest particle of the block at the start [m]", block["tail_z"][0], 0.2125, 1.0e-9)


def test_friction(slope, sheet):
    """The force along the floor is mu times that normal to it."""
    forces = table(slope, "forces")
    late = np.flatnonzero(forces["time"] > SETTLED)
    along, down = (forces[f"block_floor_impulse_{axis}"][late[-1]] - forces[f"block_floor_impulse_{axis}"][late[0]]
                   for axis in "xz")
    sheet.near("friction of the impulses after the slip began", -along / down, FRICTION, 1.0e-3)
    pressed = late[forces["block_floor_force_z"][late] < 0.4 * 0.2 * 1000.0 * DOWN]
    sheet.require(len(pressed) > 10, "there are rows in which the block is pressed on the floor")
    ratio = -forces["block_floor_force_x"][pressed] / forces["block_floor_force_z"][pressed]
    sheet.below("friction of the rows, relative error", abs(ratio / FRICTION - 1.0).max(), 1.0 / 8.0)


@pytest.mark.parametrize("name, words, masses", [
    ("slides", {}, [240.0, 80.0]),
    ("one field", {"contact=.true.": "contact=.false.", "&contact ": "! "}, [320.0]),
    ("bonded", {"friction=0.2": "law='bonded'"}, [320.0])])
def test_fragments(options, sheet, name, words, masses):
    """Would catch bodies in contact that are one fragment, bonded bodies that are two, and a field that is not defined
    as the table: the block touches the floor."""
    text = SLIDE + "&output  name='g'  kind='fragments'  every=2 /\n" \
        "&output  name='p'  kind='particles'  every=2  fields='fragment','mass' /\n"
    for old, new in words.items():
        assert old in text
        text = text.replace(old, new)
    run = case.Case(options, name.replace(" ", "_"), text).run("-q", "--set", "time.max_steps=4")
    found = table(run, "fragments")
    sheet.require(len(found["mass"]) == 3 * len(masses), f"{name}: rows of three times: {found['mass']}")
    sheet.below(f"{name}: masses [kg]", abs(found["mass"][-len(masses):] - masses).max(), 1.0e-9)
    _, last = run.snapshots()[-1]
    number = last.fields["fragment"]
    counted = [last.fields["mass"][number == one].sum() for one in np.unique(number)]
    sheet.below(f"{name}: masses of the field [kg]", abs(np.array(counted) - masses).max(), 1.0e-3)


def test_same_bytes(slope, options, sheet):
    """The outputs do not change the run, and depend neither on ranks, threads nor a restart."""
    plain = case.Case(options, "plain", SLIDE).run("-q")
    sheet.require(plain.summary["digest"] == slope.summary["digest"], "the outputs do not change the run")
    for name, words in (("ranks", {"ranks": 2}), ("threads", {"threads": 2})):
        other = case.Case(options, name, SLIDE + OUTPUTS, **words)
        other.name = "slope"
        other.run("-q")
        for output in ("forces", "block_history", "history"):
            sheet.require(other.path(f"_{output}.csv").read_bytes() == slope.path(f"_{output}.csv").read_bytes(),
                          f"{name}: {output}")
    part = case.Case(options, "part", SLIDE + OUTPUTS)
    part.run("-q", "--set", "time.max_steps=200")
    part.run("-q", "--restart")
    for output in ("forces", "block_history"):
        found, whole = table(part, output), table(slope, output)
        for name in whole:
            if "force" not in name:
                sheet.require(found[name][-1] == whole[name][-1], f"restart: {output} {name}")


@pytest.mark.parametrize("method", ["", "transfer='flip'  stress_update='usf'"])
def test_three(options, sheet, method):
    """Three bodies in contact, one with itself. Other tiles of two ranks would show a crack whose particles are
    strained with nodes of its second side that are those of the step before."""
    deck = THREE.format(method="stress_update='usl'" if not method else method)
    run = case.Case(options, "three", deck).run("-q")
    sheet.require(case.Case(options, "three_ranks", deck, ranks=2).run("-q").summary["digest"]
                  == run.summary["digest"], "the same digest on two ranks")
    forces, history = table(run, "forces"), {name: table(run, f"{name}_history") for name in "abc"}
    sheet.require(history["c"]["failed_mass"][-1] > 0.0, "material of c has failed")
    scale = max(abs(value).max() for name, value in forces.items() if "impulse" in name)
    for pair in ("c_a", "c_b", "a_b"):
        size = max(abs(forces[f"{pair}_impulse_{axis}"]).max() for axis in "xz")
        sheet.above(f"{pair}: impulse [N s]", size, 0.01 * scale)
    for axis in "xz":
        push = {pair: forces[f"{pair}_impulse_{axis}"] for pair in ("c_a", "c_b", "a_b")}
        for body, gain in (("a", push["c_a"] - push["a_b"]), ("b", push["c_b"] + push["a_b"]),
                           ("c", -push["c_a"] - push["c_b"])):
            found = history[body][f"momentum_{axis}"]
            sheet.below(f"{body}: momentum along {axis} less the impulses, over the greatest",
                        abs(found - found[0] - gain).max() / scale, 1.0e-12)


def test_ball(options, sheet):
    """A ball hits a plate: the force stops the ball; around an axis only the axial component counts."""
    run = case.Case(options, "ball", BALL).run("-q")
    forces, ball = table(run, "forces"), table(run, "ball_history")
    lost = ball["momentum_z"][0] - ball["momentum_z"]
    sheet.below("lost momentum of the ball less the impulse on the plate, over it",
                abs(lost - forces["ball_plate_impulse_z"]).max() / abs(lost).max(), 1.0e-12)
    sheet.above("slowed by [m/s]", ball["velocity_z"][-1] - ball["velocity_z"][0], 100.0)
    sheet.require(not forces["ball_plate_impulse_x"].any() and not ball["centre_x"].any(), "there is none along x")
