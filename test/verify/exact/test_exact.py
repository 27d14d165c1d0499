# SPDX-License-Identifier: BSD-3-Clause
"""Runs that follow an exact solution converge to it.

Would catch: a body force at the wrong time or position, or added to the wrong columns of the nodes; an initial stress,
volume or deformation gradient that does not agree with the initial motion; positions and stresses that do not move with
the velocity in the middle of the step (the error is then of first order); columns of errors that compare at the wrong
time; work of the body force that is not recorded.

With the defaults but without artificial viscosity, error of displacement at the end (root mean square) over the
greatest displacement of the solution, error of velocity over its amplitude:

  line   axis_aligned, A = 1e-4, 2 particles a cell, t = 2 L/c: 9, 13, 20, 30 cells
  plane  axis_aligned, A = 0.02, 3 x 3 particles, t = L/c: 9, 13, 20, 30 cells
  cube   axis_aligned, A = 0.02, 2 x 2 x 2 particles, t = L/(3 c): 6, 7, 9, 11 cells
  ring   vortex, 3 x 3 particles, the middle turned by 0.45: 10, 12, 14, 18 cells a unit
  bar    bar_mode, fixed and free, a quarter of a period: 12, 16, 20, 28 cells
  disc   spinning_disc, a twentieth of a turn: 10, 12, 14, 18 cells a unit

Limits of the finest runs. Line: the dispersion of ddmp in closed form (test/support/manufactured.py), whose relative
errors of displacement and stress are the same; plane and cube: its bound where a body force maintains the motion. Bar:
the same phase lag makes an amplitude too large by kappa (k h)2 and delays a velocity by that fraction of its angle.
Ring: target 2.5 %, of the greatest displacement and of the greatest speed, pi. Disc: the angular velocity may be off by
the target of test_spin.py, 1e-3 per turn; cells at the rim are partly filled, and their missing stress causes waves of
the velocity stress/(rho c). Orders by least squares over four grids: those of a ratio of errors per doubling of the
cells of 3.5 instead of 4 where the error is of second order, 3.3 on the grids of the cube, 1.8 instead of 2 where free
rims make it of first order. The disc misses its orders, the velocity of the ring its
limit: known misses; the errors of the disc must decrease, that of the ring is held at twice its limit. A limit for the
stress applies to the line only: elsewhere free ends or particles that cross cells make it of first order. The momentum
balance closes to round-off; those of energy and angular momentum within the accuracy of the time step, target 1 % and
2e-3: without the recorded work of the body force the error would be 1.
"""
# timeout: 200

import math

import case
import convergence
import manufactured
import measured

STIFF = 0.7 / (1.3 * 0.4)              # modulus of a pressure wave over Young's modulus, nu = 0.3

LINE, ROUND = (9, 13, 20, 30), (10, 12, 14, 18)         # cells of line and plane; of ring and disc

DECK = """
&run  dimension='{dimension}' /
&time  t_end={end} /
&effects  artificial_viscosity=.false. /
&output  name='h'  kind='history'  count=4 /
&output  name='p'  kind='particles'  count=1  fields='identity','reference'  precision='double' /
&checkpoint  at_end=.false. /
"""

CUBE = """
&grid  lo=0,0,0  hi=1,1,1  dx={spacing} /
&material  name='rubber'  density=20  young=2.0e5  poisson={poisson}
  strength_model='neo_hookean' /
&region  name='cube'  shape='box'  lo=0,0,0  hi=1,1,1 /
&body  name='cube'  region='cube'  material='rubber'  ppc={ppc} /
&boundary  face='all'  type='symmetry' /
&exact  solution='axis_aligned'  amplitude={amplitude} /
"""

RING = """
&grid  lo=-1.5,0,-1.5  hi=1.5,1,1.5  dx={spacing} /
&material  name='rubber'  density=1000  young=1000  poisson=0.3  strength_model='neo_hookean' /
&region  name='outer'  shape='cylinder'  axis=0,1,0  centre=0,0.5,0  radius=1.25  height=4 /
&region  name='inner'  shape='cylinder'  axis=0,1,0  centre=0,0.5,0  radius=0.75  height=4 /
&region  name='ring'  shape='difference'  of='outer','inner' /
&body  name='ring'  region='ring'  material='rubber'  ppc=3,1,3 /
&exact  solution='vortex'  frequency=0.5 /
"""

BAR = """
&grid  lo=0,0,0  hi=1.25,1,1  dx={spacing} /
&material  name='bar'  density=20  young=2.0e5  poisson=0 /
&region  name='bar'  shape='box'  lo=0,0,0  hi=1,1,1 /
&body  name='bar'  region='bar'  material='bar'  ppc=2,1,1 /
&boundary  face='xlo'  type='symmetry' /
&exact  solution='bar_mode'  bar_length=1  mode_speed=0.001 /
"""

DISC = """
&grid  lo=-1.5,0,-1.5  hi=1.5,1,1.5  dx={spacing} /
&material  name='disc'  density=1000  young=1.0e7  poisson=0.3 /
&region  name='disc'  shape='cylinder'  axis=0,1,0  centre=0,0.5,0  radius=1  height=4 /
&body  name='disc'  region='disc'  material='disc'  ppc=3,1,3 /
&exact  solution='spinning_disc'  angular_speed=4  disc_radius=1 /
"""


def follow(options, name, dimension, deck, end, cells, **words):
    """Errors of successively finer runs, as lists."""
    result = {"name": name, "cells": cells, "displacement": [], "velocity": [], "stress": [], "books": []}
    for number in cells:
        text = DECK.format(dimension=dimension, end=end) + deck.format(spacing=1.0 / number, **words)
        run = case.Case(options, f"{name}_{number}", text).run("-q")
        seen = run.summary["exact"]
        history = run.history
        for key in ("displacement", "velocity", "stress"):
            assert history[f"{key}_error"][-1] == seen[f"{key}_error"]
        result["displacement"].append(seen["displacement_error"] / seen["greatest_displacement"])
        result["velocity"].append(seen["velocity_error"])
        result["stress"].append(seen["stress_error"])
        result["books"].append([run.summary["ledger"][f"{key}_error"] for key in
                                ("energy", "momentum", "angular_momentum")])
        result["start"] = history["displacement_error"][0]
        result["snapshot"] = run.snapshots()[-1][1]
        measured.show(f"{name} {number}", {key: result[key][-1] for key in ("displacement", "velocity", "stress")})
    return result


def judge(sheet, result, error, ratio, key="displacement"):
    """The finest error and the order, that of a ratio of errors per doubling, must meet their limits."""
    name, errors = result["name"], result[key]
    if (name, key) == ("ring", "velocity"):
        sheet.known(f"{name}: error of {key}", errors[-1], limit=2.0 * error, target=error)
    else:
        sheet.below(f"{name}: error of {key}", errors[-1], error)
    order, target = convergence.order(result["cells"], errors), math.log2(ratio)
    if name == "disc":
        sheet.known(f"{name}: {target:.2f} less the order of the error of {key}", max(0.0, target - order),
                    limit=target, target=0.0)
    else:
        sheet.above(f"{name}: order of the error of {key}", order, target)


def rim(spacing):
    """Velocity [m/s] of waves from a rim of that width without its hoop stress, root mean square over the disc."""
    ratio, modulus = 0.3 / 0.7, 1.0e7 * STIFF
    hoop = (2.0 - 2.0 * ratio) / 8.0 * 1000.0 * 4.0 ** 2
    return math.sqrt(1.0 - (1.0 - spacing) ** 2) * hoop / math.sqrt(1000.0 * modulus)


def test_exact(options, sheet):
    """All solutions, each with the resolution that takes a few seconds."""
    line = follow(options, "line", "1d", CUBE, 0.02, LINE, poisson=0, ppc="2,1,1",
                  amplitude="1.0e-4")
    plane = follow(options, "plane", "plane_strain", CUBE, 0.01, LINE, poisson=0.3,
                   ppc="3,1,3", amplitude="0.02")
    cube = follow(options, "cube", "3d", CUBE, 0.0033, (6, 7, 9, 11), poisson=0.3, ppc="2,2,2",
                  amplitude="0.02")
    ring = follow(options, "ring", "plane_strain", RING, 0.15, ROUND)
    bar = follow(options, "bar", "1d", BAR, 0.01, (12, 16, 20, 28))
    disc = follow(options, "disc", "plane_strain", DISC, 0.08, ROUND)
    lag = manufactured.dispersion("ddmp", LINE[-1], 2.0 * math.pi)
    judge(sheet, line, lag, 3.5)
    judge(sheet, line, lag * 2.0e5 * math.pi * 1.0e-4, 3.5, "stress")
    speed = 100.0 * math.pi * 0.02                     # greatest speed of plane and cube [m/s]
    judge(sheet, plane, manufactured.forced("ddmp", LINE[-1], math.pi, STIFF, 0.02)[0], 3.5)
    far, fast = manufactured.forced("ddmp", 11, 0.33 * math.pi, STIFF, 0.02)
    judge(sheet, cube, far, 3.3)
    judge(sheet, cube, fast * speed, 3.3, "velocity")
    judge(sheet, ring, 0.025, 3.5)
    judge(sheet, ring, 0.025 * math.pi, 1.8, "velocity")
    late = 7.0 / 24.0 * (0.5 * math.pi / 28) ** 2 / math.sqrt(2.0)
    judge(sheet, bar, late, 3.5)
    judge(sheet, bar, late * 0.5 * math.pi * 1.0e-3, 3.5, "velocity")
    # angle of the disc, whose angular velocity may be off by that fraction of 1e-3
    turn = 0.08 * 4.0
    judge(sheet, disc, 0.5 * 1.0e-3 / (2.0 * math.pi) * turn ** 2 * math.sqrt(0.5) / (2.0 * math.sin(0.5 * turn)), 3.3)
    judge(sheet, disc, rim(1.0 / ROUND[-1]), 1.8, "velocity")
    for result in (line, plane, cube, ring, bar, disc):
        energy, momentum, angular = (abs(error) for error in result["books"][-1])
        sheet.below(f"{result['name']}: energy", energy, 0.01)
        sheet.below(f"{result['name']}: momentum", momentum, 1.0e-13)
        sheet.below(f"{result['name']}: angular momentum", angular, 2.0e-3)
        sheet.require(result["start"] <= 1.0e-14, f"{result['name']}: starts on the solution")
    last = ring["snapshot"]
    lattice = last.fields["reference"] * 3.0 * ROUND[-1] - 0.5
    sheet.below("distance of references from the lattice", abs(lattice - lattice.round())
                [:, (0, 2)].max(), 1.0e-9)
    sheet.above("way of some particle", abs(last.points - last.fields["reference"]).max(), 0.1)
