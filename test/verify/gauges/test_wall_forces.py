# SPDX-License-Identifier: BSD-3-Clause
# tiers: smoke, full
"""Forces on boundaries, their parts and rigid regions.

Would catch a force that is assigned to another wall, one that is counted twice where two walls meet, friction or a
repeated step that is omitted, a mean force that is not the change of the impulse, work of a wall with another velocity,
and an output that changes the run.
"""

import numpy as np

import case

DECK = """
&run  dimension='plane_strain' /
&grid  lo=0,0,0  hi=2,1,1.5  dx=0.05 /
&time  t_end=0.3 /
&material  name='m'  density=1000  young=1e6  poisson=0.3 /
&region  name='left'   shape='box'  lo=0.5,0,0.15  hi=1,1,0.6 /
&region  name='right'  shape='box'  lo=1.1,0,0.05  hi=1.4,1,0.5 /
&region  name='wedge'  shape='box'  lo=0.7,0,0  hi=0.9,1,0.1 /
&region  name='plate'  shape='box'  lo=1.5,0,0  hi=1.6,1,1.5 /
&region  name='middle'  shape='box'  lo=0,0,0  hi=1.1,1,1 /
&body  name='left'   region='left'   material='m'  velocity=0,0,-2 /
&body  name='right'  region='right'  material='m'  velocity=1,0,-1 /
&boundary  face='zlo'  type='friction'  friction=0.4 /
&boundary  face='zlo'  type='slip'  region='middle' /
&boundary  region='wedge'  type='stick' /
&boundary  region='plate'  type='velocity'  velocity=-0.5,0,0 /
&output  name='h'  kind='history'  every=20 /
{more}
"""
FORCES = "&output  name='f'  kind='forces'  every=20 /"
# A brick at rest on the floor: the load cell below it shows its weight.
WEIGHT = """
&run  dimension='plane_strain' /
&grid  lo=0,0,0  hi=1,1,1  dx=0.1 /
&time  t_end=0.5 /
&effects  gravity=.true.  gravity_vector=0,0,-9.81 /
&material  name='m'  density=1000  young=1e6  poisson=0.3 /
&region  name='brick'  shape='box'  lo=0,0,0  hi=1,1,0.5 /
&body  name='b'  region='brick'  material='m' /
&boundary  face='zlo'  type='slip' /
&boundary  face='xlo'  type='slip' /
&boundary  face='xhi'  type='slip' /
&output  name='f'  kind='forces'  walls='zlo','xlo'  dt=0.01 /
"""


def table(run, name):
    """Columns of a table."""
    return np.genfromtxt(run.path(f"_{name}.csv"), delimiter=",", names=True, deletechars="", replace_space=" ")


def sums(sheet, one):
    """The sum of the impulses of all walls is that of the ledger; forces are their changes; work is that of the
    plate."""
    forces, history = table(one, "forces"), one.history
    for axis in "xz":
        walls = sum(forces[name] for name in forces.dtype.names if name.endswith(f"_impulse_{axis} [N s]"))
        scale = abs(history[f"impulse_{axis}"]).max()
        sheet.require(scale > 10.0, f"walls push along {axis}: {scale}")
        sheet.below(f"impulse along {axis}: walls against the ledger, over it",
                    abs(walls + history[f"impulse_{axis}"]).max() / scale, 1e-13)
    for wall in ("zlo", "middle", "wedge", "plate"):
        impulse = forces[f"{wall}_impulse_x [N s]"], forces[f"{wall}_impulse_z [N s]"]
        sheet.require(np.hypot(*impulse).max() > 1.0, f"{wall} is touched")
        mean = np.diff(impulse[1]) / np.diff(forces["time [s]"])
        wrong = abs(mean - forces[f"{wall}_force_z [N]"][1:]).max() / max(abs(mean).max(), 1.0)
        sheet.below(f"{wall}: mean force less change of the impulse", wrong, 1e-12)
    sheet.below("work on the plate: impulse times its velocity",
                abs(forces["plate_work [J]"] + 0.5 * forces["plate_impulse_x [N s]"]).max(), 1e-9)
    sheet.below("slip has no force along it", abs(forces["middle_impulse_x [N s]"]).max(), 1e-12)
    push, rub = -forces["zlo_impulse_z [N s]"], abs(forces["zlo_impulse_x [N s]"])
    sheet.below("friction is at most the coefficient times the normal impulse", (rub - 0.4 * push).max(), 1e-9)


def test_wall_forces(options, sheet):
    one = case.Case(options, "walls", DECK.format(more=FORCES)).run("-q")
    sums(sheet, one)
    plain = case.Case(options, "plain", DECK.format(more="")).run("-q")
    sheet.require(plain.summary["digest"] == one.summary["digest"], "the output does not change the run")
    two = case.Case(options, "two", DECK.format(more=FORCES), ranks=2)
    two.name = "walls"
    two.run("-q")
    part = case.Case(options, "part", DECK.format(more=FORCES))
    part.name = "walls"
    part.run("-q", "--set", "time.max_steps=301")
    part.run("-q", "--restart")
    text = one.path("_forces.csv").read_bytes()
    sheet.require(two.path("_forces.csv").read_bytes() == text, "two ranks write the same bytes")
    last = table(part, "forces")[-1]
    for name in last.dtype.names:
        if "impulse" in name:
            sheet.require(last[name] == table(one, "forces")[-1][name], f"after a restart: {name}")
    brick = table(case.Case(options, "weight", WEIGHT).run("-q"), "forces")
    # the brick oscillates about its compressed state, with periods of 55 ms
    sheet.near("mean force on the floor over nine periods", brick["zlo_impulse_z [N s]"][-1] / brick["time [s]"][-1],
               -4905.0, 0.02)
    sheet.require(brick["xlo_impulse_x [N s]"][-1] < -100.0, "the brick presses on the side")
