# SPDX-License-Identifier: BSD-3-Clause
"""A block without stress flies through a periodic box: velocity and shape must not change.

Would catch: a particle lost, duplicated or assigned to the wrong cell when it crosses a cell, tile or periodic
boundary; node values of one tile that differ from those of its neighbour; velocity that decays in the transfer;
gradients that are not zero for a uniform velocity (partition of unity, free surfaces with nearly empty cells).

Limits: velocity, positions, volume and stress over modulus 1e-12. The distance may be off by the rounding of the time,
which is the same in every step of the same length: 2**-52 per step. The velocity is of the order of the wave speed, so
that cells are crossed in a usual number of steps.

The dual domain method runs with its defaults. The plain method updates the stress with velocities
that are mapped again (musl): with usl a node that is nearly empty gets a force that is too large for its mass, and
rounding errors of a free block in 3-D grew until the run stopped within 1700 crossings; the dual domain method has no
force there, as its alpha is zero on cell faces.
"""
# timeout: 200

import math

import numpy as np
import pytest

import case

YOUNG, DENSITY = 100.0e6, 1000.0
SPEED = 200.0                 # of the order of sqrt(E/rho) = 316 m/s
SIZE, CELLS = 4.0, 12         # edge of the block and of the box [m]; cells of 1 m
LIMIT = 1.0e-12

DECK = """
&run  dimension='{dimension}'  method='{method}' /
&method  stress_update='{update}'  {words} /
&grid  lo=0,0,0  hi=12,12,12  dx=1 /
&time  t_end={end!r} /
&material  name='rubber'  density=1000  young=100.0e6  poisson=0.3 /
&region  name='box'  shape='box'  lo=4.3,4.2,4.1  hi=8.3,8.2,8.1 /
&body  name='block'  region='box'  material='rubber'  ppc=2,2,2
  velocity={velocity} /
&boundary  face='all'  type='periodic' /
&output  name='p'  kind='particles'  count=1  precision='double'
  fields='identity','velocity','volume','stress' /
&output  name='h'  kind='history'  every=500 /
&checkpoint  at_end=.false. /
"""


WORDS = ("transfer='pic'", "transfer='apic'", "transfer='aflip'", "transfer='rflip'")


@pytest.mark.parametrize("dimension, method, update, crossings, words", [
    *((dimension, method, update, crossings, "") for method, update, crossings in (
        ("ddmp", "usl", 10000), ("mpm", "musl", 3000)) for dimension in ("1d", "plane_strain", "3d")),
    *(("plane_strain", "ddmp", "usl", 300, words) for words in WORDS),
    *(("plane_strain", "mpm", "musl", 300, words + " basis='quadratic'") for words in WORDS),
])
def test_fly(options, sheet, dimension, method, update, crossings, words):
    """One flight; the ratios of the velocity components are irrational, so that cells are crossed in any order."""
    direction = {"1d": (1.0, 0.0, 0.0), "plane_strain": (1.0, 0.0, -0.6180339887),
                 "3d": (1.0, 0.4142135624, -0.6180339887)}[dimension]
    velocity = SPEED * np.array(direction)
    end = crossings / SPEED
    name = f"{dimension}_{method}" + "".join(c for c in words if c.isalnum())
    deck = DECK.format(dimension=dimension, method=method, update=update, end=end,
                       words=words, velocity=",".join(repr(float(part)) for part in velocity))
    run = case.Case(options, name, deck).run("-q")
    (_, first), (time, last) = run.snapshots()
    sheet.require(math.isclose(time, end, rel_tol=1.0e-12), f"{name} reaches its end")
    sheet.require(len(first.points) == len(last.points) == 8 ** len(np.flatnonzero(velocity)),
                  f"{name} keeps its {8 ** len(np.flatnonzero(velocity))} particles")
    sheet.require(run.summary["steps"] > 2 * crossings, f"{name} makes steps of less than a cell")
    before, after = np.argsort(first.fields["identity"]), np.argsort(last.fields["identity"])
    flown = last.points[after] - first.points[before]
    active = np.flatnonzero(velocity)
    # all particles must have the displacement of the first one, modulo the box
    relative = (flown - flown[0])[:, active]
    relative = np.abs(relative - CELLS * np.round(relative / CELLS)).max() / SIZE
    total = (flown[0] - velocity * time)[active]
    total = np.abs(total - CELLS * np.round(total / CELLS)).max() / (SPEED * time)
    print(f"{name}: {run.summary['steps']} steps, {crossings} crossings, "
          f"{run.summary['wall_s']:.1f} s", flush=True)
    sheet.below(f"{name} velocity", np.abs(last.fields["velocity"] - velocity).max() / SPEED, LIMIT)
    sheet.below(f"{name} relative places", relative, LIMIT)
    sheet.below(f"{name} way", total, run.summary["steps"] * 2.0 ** -52)
    volume = last.fields["volume"][after] / first.fields["volume"][before]
    sheet.below(f"{name} volume", np.abs(volume - 1.0).max(), LIMIT)
    sheet.below(f"{name} stress/modulus", np.abs(last.fields["stress"]).max() / YOUNG, LIMIT)
    sheet.below(f"{name} momentum", run.summary["ledger"]["momentum_error"], LIMIT)
    sheet.below(f"{name} energy", run.summary["ledger"]["energy_error"], LIMIT)
