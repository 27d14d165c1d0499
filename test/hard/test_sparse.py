# SPDX-License-Identifier: BSD-3-Clause
"""Empty space costs nothing: a box of 10^9 cells, and debris that flies a thousand times its size.

Would catch: an array of the size of the box, numbers of cells or sites with 32 bits, tiles that remain where no
particles are left, memory that grows with the distance flown.
"""
# timeout: 300

import os
import time

import case

HUGE = """
&run  dimension='3d' /
&grid  lo=0,0,0  hi={size},{size},{size}  dx=1 /
&time  t_end=1.0e3  max_steps=5 /
&material  name='rubber'  density=1000  young=1.0e6  poisson=0.3 /
&region  name='low'   shape='box'  lo=1,1,1  hi=19,19,21 /
&region  name='high'  shape='box'  lo={low},{low},{low}  hi={high},{high},{top} /
&body  name='low'   region='low'   material='rubber'  velocity=1,2,3 /
&body  name='high'  region='high'  material='rubber'  velocity=-1,-2,-3 /
"""

FLIGHT = """
&run  dimension='3d' /
&grid  lo=0,0,0  hi=9000,9000,9000  dx=1 /
&time  t_end=4.0  max_steps={steps}  cfl=0.8 /
&method  transfer='flip'  flip=1.0 /
&material  name='rubber'  density=1000  young=1.0e3  poisson=0.3 /
&region  name='one'    shape='box'     lo=100,100,100  hi=104,104,104 /
&region  name='two'    shape='sphere'  centre=8000,4500,300  radius=2 /
&body  name='one'  region='one'  material='rubber'  ppc=1,1,1  velocity=1000,1000,1000 /
&body  name='two'  region='two'  material='rubber'  ppc=1,1,1  velocity=-900,40,1000 /
"""


def peak_memory(run, *options):
    """Greatest resident size of the program alone [MB], and its wall time [s]."""
    begin = time.time()
    child = os.posix_spawn(str(run.scree), run.command("-q", *options), run.environment)
    _, status, usage = os.wait4(child, 0)
    run.code = os.waitstatus_to_exitcode(status)
    return usage.ru_maxrss / 1024, time.time() - begin


def test_huge(options, sheet):
    """Two blocks in opposite corners, in a box that grows by a factor of 10^3 and more."""
    memory = {}
    for size in (100, 1000, 100000):
        run = case.Case(options, f"huge_{size}", HUGE.format(
            size=size, low=size - 20, high=size - 2, top=size - 1))
        memory[size], seconds = peak_memory(run)
        sheet.require(run.code == 0, f"box of {size}^3 cells: exit code {run.code}")
        summary = run.summary
        sheet.require(summary["particles"] == 101088, f"{summary['particles']} particles")
        sheet.note(f"box of {size}^3 cells, memory [MB]", memory[size])
        sheet.note(f"box of {size}^3 cells, wall time of 5 steps [s]", seconds)
        sheet.below(f"box of {size}^3 cells, momentum error",
                    summary["ledger"]["momentum_error"], 1.0e-13)
    sheet.below("memory of 10^9 cells [MB]", memory[1000], 300.0)
    sheet.near("memory of 10^15 cells against 10^6", memory[100000], memory[100], 0.1)


def test_flight(options, sheet):
    """Two bodies that fly apart by a thousand times their size."""
    seen = {}
    for steps in (300, 20000):
        run = case.Case(options, f"flight_{steps}", FLIGHT.format(steps=steps))
        memory, _ = peak_memory(run)
        sheet.require(run.code == 0, f"flight: exit code {run.code}")
        summary = run.summary
        loop = sum(summary["timers"][name]["avg"] for name in (
            "sort, move tiles", "points to nodes", "grid", "nodes to points", "strength", "eos"))
        seen[steps] = (memory, summary["bytes_per_particle"], loop / summary["steps"],
                       summary["time"])
        sheet.below(f"flight, {summary['steps']} steps, momentum error",
                    summary["ledger"]["momentum_error"], 1.0e-12)
    early, late = seen[300], seen[20000]
    sheet.note("distance flown by the block, in its size", 1732.0 * late[3] / 6.93)
    sheet.above("distance flown by the block, in its size", 1732.0 * late[3] / 6.93, 900.0)
    sheet.near("memory late against early", late[0], early[0], 0.05)
    # the number of tiles that a block of four cells a side touches depends on its position
    sheet.near("bytes a particle late against early", late[1], early[1], 0.2)
    # the time depends on the machine and its load: it is printed, not checked
    sheet.note("time a step late over early", late[2] / early[2])
