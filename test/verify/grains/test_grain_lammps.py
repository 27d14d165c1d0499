# SPDX-License-Identifier: BSD-3-Clause
"""scree --grains against LAMMPS (pair_style gran/hooke/history, gran/hertz/history); skipped where it is not
installed.

Would catch a force, a reduced mass or radius, a dashpot or an image across oblique cell faces that is wrong in the same
way in all tests of this project, and friction of a flow that another program does not confirm.

Exact agreement is required for springs along the line of centres, dashpots at the same velocities, and steps of both
programs where nothing else acts. Differences: in LAMMPS surfaces slide at the full radii, in scree at the radii less
half of the overlap, so tangential forces agree to the order of the overlap; dashpots of LAMMPS use the velocity in the
middle of the step, those of scree that at its end; LAMMPS projects the tangential spring onto the new plane, scree
rotates it.
"""
# tiers: long
# timeout: 1800

import numpy as np
import pytest

import case
import lammps

DENSITY, STIFFNESS = 2500.0, 1e3
SPRINGS = f"stiffness = {STIFFNESS}"
PRESSED = 2000                                            # steps in which a packing is compressed
# flying grains are compressed obliquely, in a fixed number of steps
CROWD = """&grains  shape = 'spheres'  number = {number}  diameter = 1e-3  spread = {spread}  density = 2500
  {law}  restitution = {restitution}  friction = {friction} /
&cell  volume_fraction = 0.25    speed = {speed}  seed = 4 /
&stage  name = 'press'  rate = -100 -100 -100 150 0 0  duration = {press}  rows = 1  snapshots = 0 /
{more}
"""
HOLD = "&stage  name = 'hold'  duration = {time}  rows = 1  snapshots = 0 /"
FLOW = """&grains  shape = 'spheres'  number = 300  diameter = 1e-3  spread = 0  density = 2500
  stiffness = 1e3  restitution = 0.5  friction = 0.5 /
&cell  volume_fraction = 0.4  speed = 0.05  seed = {seed} /
&stage  name = 'press'   rate = -30 -30 -30 0 0 0  duration = {time}  rows = 1  snapshots = 0 /
{more}
"""
STEADY = """&stage  name = 'begin'   rate = 0 0 0 {rate} 0 0  strain = 2  rows = 2  snapshots = 0 /
&stage  name = 'steady'  rate = 0 0 0 {rate} 0 0  strain = 8  rows = 200  snapshots = 0 /
"""

pytestmark = pytest.mark.skipif(not lammps.PROGRAM, reason="LAMMPS (lmp) is not installed; apt-get install lammps")


def state_of(options, name, deck):
    """The last state of a run, and the run."""
    one = case.Case(options, name, deck).run("--grains", "--quiet", timeout=900)
    return lammps.State.of_checkpoint(sorted(one.folder.glob("*_chk_*.h5"))[-1]), one


def crowd(options, name, steps, more, **values):
    """A packing that is compressed for some steps and then free for some more."""
    values = {"number": 216, "spread": 0.2, "restitution": 1, "friction": 0, "speed": 0.05, "law": SPRINGS, **values}
    dt = state_of(options, name, CROWD.format(press=1e-12, more="", **values))[0].dt
    state, one = state_of(options, name, CROWD.format(press=(steps - 0.5) * dt, more=HOLD.format(
        time=(more - 0.5) * dt), **values))
    if one.summary["steps"] != steps + more:
        raise AssertionError(f"{name}: {one.summary['steps']} steps, not {steps + more}")
    return state


def off(sheet, name, found, expected, limit):
    """The greatest difference of two fields over the greatest of the second."""
    sheet.require(np.abs(expected).max() > 0.0, f"{name}: something acts")
    sheet.below(name, np.abs(found - expected).max() / np.abs(expected).max(), limit)


def mass_of(diameter):
    """Mass of a sphere [kg]."""
    return DENSITY * np.pi / 6 * diameter**3


def gamma(mass, restitution):
    """Dashpot of LAMMPS for pairs of equal spheres: g sqrt(m)/m with g of (G.4) [1/s]."""
    log = np.log(restitution)
    return -2 * log * np.sqrt(STIFFNESS / (np.pi**2 + log**2)) / np.sqrt(0.5 * mass)


def test_springs(options, sheet):
    """Springs alone: one state of spheres of different sizes, and the motion of both programs from it. Rounding of
    positions is 1e-13 of the overlaps, and each collision increases it by a factor of about ten; with Hertz contacts
    there are more collisions here."""
    for law, text, longest, pair in (
            ("linear", SPRINGS, 100, f"pair_style gran/hooke/history {STIFFNESS:.17g} NULL 0 NULL 0 0"),
            ("Hertz", "law = 'hertz'  young = 2e8  poisson = 0.3", 30,
             f"pair_style gran/hertz/history {2 / 3 * 2e8 / (1 - 0.3**2):.17g} NULL 0 NULL 0 0")):
        first = crowd(options, law, PRESSED, 1, law=text)
        for steps in (0, 1, 10, longest):
            state = crowd(options, law, PRESSED, 1 + steps, law=text)
            found = lammps.forces(options.work / "lammps", first, DENSITY, pair, steps)[0]
            off(sheet, f"{law} springs: forces after {steps} steps", found, state.force, 1e-12)


def test_dashpots(options, sheet):
    """Springs and dashpots of equal spheres in one state: LAMMPS gets the velocities that the dashpots of scree use,
    those in the middle of the step plus half a step of the previous forces. m gamma = g sqrt(m) for reduced m."""
    values = {"spread": 0, "restitution": 0.5}
    last = crowd(options, "dashpots", PRESSED, 30, **values)
    before = crowd(options, "dashpots", PRESSED, 29, **values)
    mass = mass_of(2 * last.radius[0])
    last.velocity += 0.5 * last.dt / mass * (before.force - last.force)
    pair = f"pair_style gran/hooke/history {STIFFNESS:.17g} NULL {gamma(mass, 0.5):.17g} NULL 0 0"
    off(sheet, "springs and dashpots: forces of one state",
        lammps.forces(options.work / "lammps", last, DENSITY, pair)[0], last.force, 1e-12)


def test_friction(options, sheet):
    """Friction from the beginning of all contacts: the difference is of the order of the overlap over the radius, 0.01
    here, until collisions have increased it (some 1500 steps)."""
    values = {"friction": 0.5, "speed": 0.1}
    first = crowd(options, "free", 1, 1, **values)
    sheet.require(np.abs(first.force).max() == 0.0, "no grains touch at the start")
    pair = f"pair_style gran/hooke/history {STIFFNESS:.17g} {0.5 * STIFFNESS:.17g} 0 0 0.5 0"
    for steps in (600, 1000):
        last = crowd(options, "free", 1, 1 + steps, **values)
        force, torque = lammps.forces(options.work / "lammps", first, DENSITY, pair, steps)
        off(sheet, f"friction: forces after {steps} steps", force, last.force, 0.01)
        off(sheet, f"friction: torques after {steps} steps", torque, last.torque, 0.01)


def test_flow(options, sheet):
    """Steady shear of equal spheres at the same volume fraction from the same states. Stresses of one such cell vary by
    a third between initial states; friction does not."""
    pair = (f"pair_style gran/hooke/history {STIFFNESS:.17g} {0.5 * STIFFNESS:.17g} "
            f"{gamma(mass_of(1e-3), 0.5):.17g} 0 0.5 0")
    for fraction, rate in ((0.56, 60.0), (0.58, 20.0)):
        ours, theirs, inertial = [], [], []
        for seed in (3, 4):
            values = {"time": np.log(fraction / 0.4) / 90.0, "seed": seed}
            start, _ = state_of(options, f"start_{fraction}", FLOW.format(more="", **values))
            history = state_of(options, f"flow_{fraction}", FLOW.format(more=STEADY.format(rate=rate), **values))[
                1].history
            steady = history["stage"] == 3
            sheet.near(f"volume fraction {fraction}: that of the cell", history["volume_fraction"][-1], fraction, 1e-3)
            ours.append([np.mean(history[key][steady]) for key in ("stress_xy", "stress_yy")])
            inertial.append(np.mean(history["inertial_number"][steady]))
            rows = lammps.shear(options.work / "lammps", start, DENSITY, pair, rate, 10)
            theirs.append(np.mean(rows[rows[:, 0] > 2, 1:3], axis=0))
        friction_of = [-np.mean([xy / yy for xy, yy in stresses]) for stresses in (ours, theirs)]
        sheet.near(f"volume fraction {fraction}, I = {np.mean(inertial):.3f}: friction of LAMMPS and ours",
                   friction_of[1], friction_of[0], 0.05)
        sheet.note("stress yy of both [Pa]", f"{-np.mean(ours, axis=0)[1]:.0f}, {np.mean(theirs, axis=0)[1]:.0f}")
