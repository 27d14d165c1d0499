# SPDX-License-Identifier: BSD-3-Clause
# tiers: smoke
"""What a run knows beside its particles is there again after a restart.

Would catch: a guard against steps that collapse which forgets the longest step of the run when it stops and goes on, so
that a run which is restarted every day collapses unseen; and quantities between the restart and its first step that use
gravity of the begin of the table.

The guard: the run takes 20 steps, 20 of 0.3 times their length and then such of 0.08 times it, with a restart between
each. Steps below a tenth of the longest end it; those of the second part are eight thirds of the last ones only.

Gravity: a history that the restart adds begins with the state of the checkpoint, where the other history has a row; its
potential energy is the same to the last digit.
"""

import numpy as np

import case

BAR = """
&run  dimension='1d' /
&grid  lo=0,0,0  hi=4,1,1  dx=0.1 /
&time  t_end=100  max_steps=20  cfl=0.5  dt_collapse=0.1 /
&material  name='m'  density=1000  young=1e6  poisson=0 /
&region  name='r'  shape='box'  lo=1,0,0  hi=2,1,1 /
&body  name='b'  region='r'  material='m'  ppc=2,1,1  velocity=0.1,0,0 /
&checkpoint  at_end=.true. /
&output  name='h'  kind='history'  every=1 /
"""

SHAKEN = """
&run  dimension='plane_strain' /
&grid  lo=0,0,0  hi=4,1,4  dx=0.25 /
&time  t_end=1  max_steps={steps} /
&effects  gravity=.true.  gravity_vector=1,0,-2  gravity_table='g.csv' /
&material  name='al'  density=2700  young=1e7  poisson=0.3 /
&region  name='a'  shape='box'  lo=1,0,1.5  hi=2,1,2.5 /
&body  name='a'  region='a'  material='al' /
&checkpoint  at_end=.true. /
&output  name='h'  kind='history'  every=1  fields='potential' /
"""
TABLE = "t, gx, gy, gz\n0, 0, 0, 0\n0.1, 30, 0, 4\n"


def test_longest_step(options):
    """The guard against collapsing steps."""
    run = case.Case(options, "bar", BAR).run("-q")
    first = np.diff(run.history["time"])[-5:].mean()
    run.run("-q", "--restart", "--set", "time.max_steps=40", "--set", "time.cfl=0.15")
    second = np.diff(run.history["time"])[-5:].mean()
    assert abs(second / first - 0.3) < 0.01
    run.run("-q", "--restart", "--set", "time.max_steps=60", "--set", "time.cfl=0.04", expect=4)
    assert "has fallen below dt_collapse" in run.output
    assert run.summary["steps"] <= 42


def test_gravity(options):
    """The first row of a history that a restart adds."""
    run = case.Case(options, "shaken", SHAKEN.format(steps=20))
    (run.folder / "g.csv").write_text(TABLE, encoding="utf-8")
    run.run("-q")
    run.deck.write_text(SHAKEN.format(steps=22) + "&output  name='k'  kind='history'  every=1  fields='potential' /\n",
                        encoding="utf-8")
    run.run("-q", "--restart")
    old, new = (case.post().history(str(run.path(ending))) for ending in ("_history.csv", "_k_history.csv"))
    for step in (20, 21, 22):
        rows = [table["potential"][table["step"] == step] for table in (old, new)]
        assert len(rows[0]) == len(rows[1]) == 1
        assert rows[0][0] == rows[1][0]
    assert abs(new["potential"][0] - old["potential"][0]) > 1e3
