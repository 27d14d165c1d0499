# SPDX-License-Identifier: BSD-3-Clause
"""Velocity transfers: the fraction of a mode that a filter keeps, modes that none may keep, and energy conservation.

Would catch: sums that borders of tiles or the periodic box truncate; motions that nodes do not resolve
and that reappear; kinetic energy that is lost without heat, or heat without a loss; an affine matrix that is not set at
the start.

Modes: a periodic line of 8 cells with particles at xi = 1/6, 1/2, 5/6 of each. Node velocities
cos(kappa i), given to the particles, are an eigenmode of the transfer to the nodes and back (S+ S) with q = 1 - 2 b (1
- cos kappa), b the mean of xi (1 - xi); PIC keeps the fraction q in a step. The
velocities (1, -2, 1) in a cell give no node a momentum: flip keeps its fraction of them, all other transfers nothing.
Both are superposed on a uniform flow. Limit: rounding.

Energy: two gases of different density that collide in a corner of two walls, one of which moves. The total energy is
conserved to rounding with every transfer, gradient and stress update.

Disc: one turn of an elastic disc that follows its exact solution, 20 cells across. Transfers with
linear velocity fields or rotations conserve angular momentum and energy: target 1e-3 (test_spin.py). flip = 0.999 does
not: a known miss, held at a tenth.
"""
# tiers: smoke, full
# timeout: 300

import numpy as np
import pytest

import case

CELLS, FLOW = 8, 3.0
PLACES = (np.arange(3 * CELLS) + 0.5) / 3.0
LIMIT = 1.0e-14

LINE = """
&run  dimension='1d' /
&grid  lo=0,0,0  hi=8,1,1  dx=1 /
&time  t_end=1.0e-3  dt_fixed=1.0e-3 /
&method  {words} /
&material  name='rubber'  density=1000  young=1.0e6  poisson=0 /
&boundary  face='all'  type='periodic' /
&output  name='p'  kind='particles'  count=1  precision='double'  fields='velocity','body' /
&checkpoint  at_end=.false. /
"""

GAS = """
&run  dimension='plane_strain'  method='{method}' /
&grid  lo=0,0,0  hi=2,1,1.2  dx=0.1 /
&time  t_end=1  max_steps=60 /
&method  {words} /
&effects  strength=.false. /
&material  name='light'  density=1.2  eos_model='ideal_gas'  ig_gamma=1.4 /
&material  name='heavy'  density=2    eos_model='ideal_gas'  ig_gamma=1.6 /
&region  name='left'   shape='box'  lo=0,0,0    hi=0.9,1,1.2 /
&region  name='right'  shape='box'  lo=0.9,0,0  hi=1.7,1,0.9 /
&body  name='left'   region='left'   material='light'  ppc=2,1,2  velocity=30,0,10
  specific_energy=2.0e5  spin=0,100,0 /
&body  name='right'  region='right'  material='heavy'  ppc=3,1,2  velocity=-400,0,100
  specific_energy=2.0e5 /
&boundary  face='xlo'  type='velocity'  velocity=50,0,0 /
&boundary  face='zlo'  type='symmetry' /
&boundary  face='zhi'  type='stick' /
&output  name='h'  kind='history'  every=20 /
&checkpoint  at_end=.false. /
"""

DISC = """
&run  dimension='plane_strain'  method='{method}' /
&grid  lo=-1.5,0,-1.5  hi=1.5,1,1.5  dx=0.1 /
&time  t_end=1.5707963267948966 /
&method  {words} /
&effects  artificial_viscosity=.false. /
&material  name='disc'  density=1000  young=1.0e7  poisson=0.3 /
&region  name='disc'  shape='cylinder'  axis=0,1,0  centre=0,0.5,0  radius=1  height=4 /
&body  name='disc'  region='disc'  material='disc'  ppc=2,1,2 /
&exact  solution='spinning_disc'  angular_speed=4  disc_radius=1 /
&output  name='h'  kind='history'  every=10 /
&checkpoint  at_end=.false. /
"""

ALL = ("transfer='flip'", "transfer='pic'", "transfer='apic'", "transfer='aflip' flip=0.7",
       "transfer='rflip' flip=0.9")


def step(options, name, words, velocity):
    """Velocities after one step without forces; each particle is a body, so that it has its own velocity."""
    text = LINE.format(words=words)
    for n, (place, speed) in enumerate(zip(PLACES, velocity)):
        text += (f"&region name='r{n}' shape='box' lo={float(place) - 1 / 6!r},0,0 "
                 f"hi={float(place) + 1 / 6!r},1,1 /\n&body name='b{n}' region='r{n}' "
                 f"material='rubber' ppc=3,1,1 velocity={float(speed)!r},0,0 /\n")
    run = case.Case(options, name, text).run("-q")
    _, last = run.snapshots()[-1]
    assert len(last.points) == len(PLACES) and run.summary["steps"] == 1
    return last.fields["velocity"][np.argsort(last.fields["body"]), 0]


@pytest.mark.tiers("full")
def test_modes(options, sheet):
    """Fractions kept of node modes and of motions that no node resolves."""
    b = np.mean([xi * (1.0 - xi) for xi in (1 / 6, 1 / 2, 5 / 6)])
    left, xi = np.floor(PLACES), PLACES % 1.0
    for number in (1, 3, 4):
        kappa = 2.0 * np.pi * number / CELLS
        mode = (1.0 - xi) * np.cos(kappa * left) + xi * np.cos(kappa * (left + 1.0))
        q = 1.0 - 2.0 * b * (1.0 - np.cos(kappa))
        after = step(options, "mode", "transfer='pic'", FLOW + mode)
        sheet.below(f"mode {number}, pic", np.abs(after - FLOW - q * mode).max(), 4.0 * LIMIT)
    hidden = np.tile([1.0, -2.0, 1.0], CELLS) * np.repeat(np.arange(1.0, CELLS + 1.0), 3)
    for words in ALL:
        kept = float(words.split("flip=")[1]) if "flip=" in words else float("flip" in words)
        error = np.abs(step(options, "hidden", words, FLOW + hidden) - FLOW - kept * hidden).max()
        sheet.below(f"hidden motion, {words}", error, 16.0 * LIMIT)


# in the tier smoke: velocities that are mapped again, slopes from velocities after the step
SMOKE = {("mpm", "linear", "musl", "transfer='flip'"), ("mpm", "linear", "musl", "transfer='aflip' flip=0.7"),
         ("ddmp", "linear", "usl", "transfer='aflip' flip=0.7")}
# each pair of gradient, update and transfer, and a third of the triples
TRIPLES = [(method, basis, update, words)
           for m, (method, basis) in enumerate((("ddmp", "linear"), ("mpm", "linear"), ("mpm", "quadratic")))
           for u, update in enumerate(("usl", "usf", "musl"))
           for w, words in enumerate(ALL) if (m + u + w) % 3 == 0]


@pytest.mark.parametrize("method, basis, update, words", [
    pytest.param(*row, marks=pytest.mark.tiers(*(("smoke",) if row in SMOKE else ()), "full")) for row in TRIPLES])
def test_gas(options, sheet, method, basis, update, words):
    """Energy and momentum of gases that are compressed."""
    text = f"basis='{basis}' stress_update='{update}' {words}"
    run = case.Case(options, "gas", GAS.format(method=method, words=text)).run("-q")
    ledger, table = run.summary["ledger"], run.history
    label = f"{method} {basis} {update} {words}"
    sheet.below(f"energy, {label}", ledger["energy_error"], 1.0e-13)
    sheet.below(f"momentum, {label}", ledger["momentum_error"], 1.0e-13)
    change = table["internal"][-1] / table["internal"][0] - 1.0
    sheet.require(change > 0.01 and run.summary["steps"] == 60,
                  f"{label}: the gases are compressed")


@pytest.mark.tiers("full")
@pytest.mark.parametrize("words", ["transfer='flip'", "transfer='apic'", "transfer='aflip'", "transfer='rflip'"])
def test_disc(options, sheet, words):
    """A disc that rotates once."""
    run = case.Case(options, "disc", DISC.format(method="ddmp", words=words)).run("-q")
    table = run.history
    drift = table["angular_momentum_y"][-1] / table["angular_momentum_y"][0] - 1.0
    energy = (table["kinetic"] + table["internal"])
    if "'flip'" in words:
        sheet.known("disc, flip: angular momentum in a turn", float(drift), limit=0.1, target=1.0e-3)
        return
    sheet.below(f"disc, {words}: angular momentum in a turn", drift, 1.0e-3)
    sheet.below(f"disc, {words}: energy in a turn", energy[-1] / energy[0] - 1.0, 1.0e-3)
