# SPDX-License-Identifier: BSD-3-Clause
# tiers: smoke, full
# timeout: 300
"""A cell of grains with several numbers of ranks and threads, uninterrupted and stopped in the middle: the same digest.

Would catch sums in the order of ranks or threads, rows of other ranks that are not up to date, a sort or a neighbour
search that depends on ranks, a value missing in a checkpoint, a stage that starts again after a restart, and a tilt of
whole periods that changes the cell.
"""

import signal
import time

import pytest

import case
import tier

# The program uses one thread for 300 grains of a rank: 1800 are enough for three ranks with two threads each.
LOOSE = """&grains number = {number}  shape = '{shape}'  diameter = 1e-3  density = 2500
  stiffness = {stiff}  friction = 0.4  restitution = 0.7 /
&cell volume_fraction = {solid}  speed = {speed}  pressure = 200  tilt = {tilt}  seed = 5 /
&stage name = 'press'  servo = 'isotropic'  rate = {press}  duration = {time}  rows = 3  snapshots = 1 /
&stage name = 'shear'  servo = 'y'  rate = 0 0 0 {rate} 0 0  strain = {strain}  rows = 4  snapshots = 2 /
"""
DISCS = {"number": 1900, "shape": "discs", "solid": 0.48, "speed": 0.3, "press": "-300 -300 0 0 0 0", "time": 1e-3,
         "rate": 600, "strain": 1.2, "tilt": 0, "stiff": 1e6}
SPHERES = {**DISCS, "shape": "spheres", "solid": 0.27, "press": "-300 -300 -300 0 0 0", "stiff": 700}
LAYOUTS = tier.choose(full=((2, 1), (1, 2), (3, 2)), smoke=((2, 1), (1, 2)))


def run(options, name, values, ranks=1, threads=1, keep=False, more=(), expect=0):
    """Run a deck in a separate folder; the case has the same name in all of them."""
    one = case.Case(options, name, LOOSE.format(**values), ranks, threads, keep=keep)
    one.name = "cell"
    # passive waiting, because there may be more threads than cores
    return one.run("--grains", "--quiet", *more, expect=expect, env={"OMP_WAIT_POLICY": "passive"})


@pytest.mark.parametrize("name, values", [
    ("discs", DISCS),
    pytest.param("spheres", SPHERES, marks=pytest.mark.tiers("full")),
])
def test_layouts(options, sheet, name, values):
    """All numbers of ranks and threads, and a stop by a signal and by the wall limit, continued with other numbers."""
    first = run(options, name, values)
    digest, steps = first.summary["digest"], first.summary["steps"]
    history = first.path("_history.csv").read_bytes()
    sheet.require(first.summary["strain"] > 1.0, f"{name}: edges have flipped and rows were sorted")
    sheet.require(len(history.splitlines()) >= 8, f"{name}: the history has all rows")
    for ranks, threads in LAYOUTS:
        other = run(options, f"{name}_{ranks}x{threads}", values, ranks, threads)
        text = f"{name}: {ranks} x {threads}"
        sheet.require(other.summary["threads"] == threads, f"{text}: has its threads")
        sheet.require(other.summary["digest"] == digest, f"{text}: {other.summary['digest']}, not {digest}")
        sheet.require(other.path("_history.csv").read_bytes() == history, f"{text}: the history has the same bytes")
    # with a wall limit of zero the run stops at the first check, each time with another number of ranks and threads
    name_of = f"{name}_stopped"
    run(options, name_of, values, 2, 1, more=("--set", "time.wall_limit='00:00:00'"), expect=None)
    for ranks, threads in ((1, 1), (2, 1), (1, 2)):
        part = run(options, name_of, values, ranks, threads, keep=True, expect=None,
                   more=("--restart", "--set", "time.wall_limit='00:00:00'"))
    sheet.require(part.code == 75, f"{name}: stopped by the wall limit with code 75, not {part.code}")
    sheet.require(part.summary["steps"] < steps, f"{name}: {part.summary['steps']} is not the end")
    last = run(options, name_of, values, 1, 1, keep=True, more=("--restart",))
    sheet.require(last.summary["digest"] == digest, f"{name}: after restarts {last.summary['digest']}, not {digest}")
    sheet.require(last.summary["steps"] == steps, f"{name}: after restarts all steps")
    sheet.require(last.path("_history.csv").read_bytes() == history, f"{name}: the history after restarts")


@pytest.mark.tiers("full")
def test_by_signal(options, sheet):
    """A run that is stopped by a signal and continued."""
    values = {**DISCS, "strain": 3.0}
    whole = run(options, "signal_whole", values).summary
    one = case.Case(options, "signal", LOOSE.format(**values))
    one.name = "cell"
    process = one.start("--grains")
    deadline = time.time() + 60.0
    # the history has its first row when the run handles signals
    while time.time() < deadline and process.poll() is None:
        table = one.path("_history.csv")
        if table.exists() and len(table.read_text(encoding="ascii").splitlines()) > 2:
            break
    process.send_signal(signal.SIGTERM)
    process.communicate(timeout=60)
    sheet.require(process.returncode == 75, f"a signal ends with code 75, not {process.returncode}")
    sheet.require(0 < one.summary["steps"] < whole["steps"], "the signal came in the middle")
    one.run("--grains", "--quiet", "--restart")
    sheet.require(one.summary["digest"] == whole["digest"], "after a signal and a restart the same digest")


def test_periods(options, sheet):
    """A tilt of whole periods gives the same cell; a tilt of half a period to either side gives the same cell."""
    short = {**DISCS, "number": 400, "strain": 0.3}
    digests = {tilt: run(options, f"tilt_{n}", {**short, "tilt": tilt}).summary["digest"]
               for n, tilt in enumerate((0, 1, -2, 0.25))}
    sheet.require(digests[0] == digests[1] == digests[-2], f"tilts of 0, 1 and -2 periods: {digests}")
    sheet.require(digests[0] != digests[0.25], "a tilt of a quarter is another cell")
