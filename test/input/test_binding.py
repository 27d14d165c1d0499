# SPDX-License-Identifier: BSD-3-Clause
# tiers: smoke
# cores: 2
"""Binding of ranks and threads to processors: the warning about threads that share a core, and the binding after the
program has restarted itself.

Would catch a run of four threads on the one core that `mpirun` gives each rank, without a warning; a warning about a
run whose threads have separate cores; a command in the warning that does not remove the cause; and a program that,
after it has restarted itself in the same process, has all threads on the OpenMP place of the first one.
"""

import os
import shutil
import signal
import subprocess
import time
from pathlib import Path

import pytest

import case

ENDLESS = 10**8
DECK = """&run dimension = 'plane_strain' /
&grid lo = 0 0 0  hi = 1 1 1  dx = 0.025 /
&time t_end = 1e9  max_steps = {steps}  dt_fixed = 1e-7 /
&material name = 'metal'  density = 2700  young = 70e9  poisson = 0.3 /
&region name = 'bar'  shape = 'box'  lo = 0 0 0  hi = 1 1 1 /
&body name = 'one'  region = 'bar'  material = 'metal'  velocity = 1 0 0 /
&boundary face = 'all'  type = 'symmetry' /
&output name = 'h'  kind = 'history'  every = 1 /
"""
PROCESSORS = sorted(os.sched_getaffinity(0))
if len(PROCESSORS) < 2:
    pytest.skip("there is one processor only", allow_module_level=True)


def environment(threads):
    """The environment of the tests without variables that change the binding by mpirun."""
    words = {name: value for name, value in {**os.environ, **case.OPEN_MPI}.items()
             if not name.startswith(("OMP_", "GOMP_")) and "binding" not in name and "rmaps" not in name}
    return {**words, "OMP_NUM_THREADS": str(threads)}


def said(options, name, *launcher, threads=1, **more):
    """Output of a short run on the error stream."""
    folder = options.work / name
    folder.mkdir()
    (folder / "bar.nml").write_text(DECK.format(steps=3), encoding="utf-8")
    answer = subprocess.run([*map(str, launcher), options.scree, "-q", "bar.nml"], cwd=folder, text=True,
                            capture_output=True, env={**environment(threads), **more}, timeout=250)
    assert answer.returncode == 0, answer.stdout + answer.stderr
    return answer.stderr


def need_open_mpi(options):
    """Skip without Open MPI, whose command-line options are used."""
    case.need_ranks(options.scree)
    version = shutil.which("mpirun") and subprocess.run(
        ["mpirun", "--version"], capture_output=True, text=True, env={**os.environ, **case.OPEN_MPI}).stdout
    # the same program under the name mpiexec prints OpenRTE with version 4
    if not version or not any(name in version for name in ("Open MPI", "OpenRTE")):
        pytest.skip("the mpirun here is not that of Open MPI")


def test_one_process(options):
    """Restricted to one processor, the program warns about several threads; with one thread or with enough processors
    it does not."""
    one = f"taskset -c {PROCESSORS[0]}".split()
    text = said(options, "restricted", *one, threads=2)
    assert (f"warning: rank 0 has 2 threads and may only run on processor {PROCESSORS[0]}; use OMP_NUM_THREADS=1, or "
            "allow it more processors (taskset, the limits of a container or a job) [R131]") in text
    assert said(options, "single", *one, threads=1) == ""
    assert said(options, "free", threads=2) == ""
    assert said(options, "places", threads=2, OMP_PLACES="cores", OMP_PROC_BIND="close") == ""


def test_default_of_mpirun(options):
    """One core for two threads; the command in the warning removes the cause."""
    need_open_mpi(options)
    text = said(options, "default", "mpirun", "-n", "1", "--bind-to", "core", threads=2)
    assert "warning: rank 0 has 2 threads and may only run on processor " in text
    words = text.partition("start it with '")[2].partition("'")[0].split()
    assert words == "mpirun -n 1 --map-by slot:PE=2 --bind-to core".split()
    assert said(options, "better", *words, threads=2) == ""


def test_two_ranks(options):
    """Two ranks on one core, two on separate cores, and two that are not bound."""
    need_open_mpi(options)
    start = ("mpirun", "-n", "2", "--bind-to", "none")
    text = said(options, "shared", *start, "taskset", "-c", PROCESSORS[0])
    assert (f"warning: rank 0 shares processor {PROCESSORS[0]} with other ranks (2 such ranks); "
            "start it with 'mpirun -n 2 --map-by slot:PE=1 --bind-to core' [R131]") in text
    assert said(options, "bound", "mpirun", "-n", "2", "--bind-to", "core") == ""
    assert said(options, "unbound", *start) == ""
    if len(PROCESSORS) < 4:
        text = said(options, "many", *start, "taskset", "-c", PROCESSORS[0], threads=2)
        assert f"the node has {os.cpu_count()} processors for 4 threads: use OMP_NUM_THREADS=1" in text


def test_places_after_restart(options):
    """With OMP_PROC_BIND the program has a place for each thread after it has restarted itself to set the waiting
    policy."""
    folder = options.work / "begun_again"
    folder.mkdir()
    (folder / "bar.nml").write_text(DECK.format(steps=ENDLESS), encoding="utf-8")
    child = subprocess.Popen(
        [options.scree, "-q", "bar.nml"], cwd=folder, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE,
        env={**environment(2), "OMP_PLACES": "threads", "OMP_PROC_BIND": "close"})
    try:
        history = folder / "out/bar/bar_history.csv"
        end = time.monotonic() + 200
        while child.poll() is None and time.monotonic() < end and not (
                history.is_file() and history.stat().st_size > 2000):
            time.sleep(0.02)
        place = Path("/proc") / str(child.pid)
        assert "GOMP_SPINCOUNT=10000" in place.joinpath("environ").read_text(encoding="utf-8").split("\0")
        masks = {os.sched_getaffinity(int(task.name)).copy().pop() for task in place.joinpath("task").iterdir()}
        assert len(masks) >= 2, f"all threads are on processor {masks}"
    finally:
        child.send_signal(signal.SIGTERM)
        child.communicate(timeout=200)
