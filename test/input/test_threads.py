# SPDX-License-Identifier: BSD-3-Clause
# tiers: smoke
# cores: 2
"""Number of threads of a run, their waiting policy, and the warning when other processes use its cores.

Would catch: threads without work in a small scene, and a number set by the user that is ignored; threads that wait
without releasing their core by default, and a setting of the user that is overridden; a program that restarts itself
and then has lost an option of its command line, its process number or a signal, or restarts without end; a run without
processor time that does not warn, or warns twice; studies that run only one deck at a time.
"""

import os
import signal
import subprocess
import time
from pathlib import Path

import pytest

import case
from scree import program

SETTINGS = ("OMP_NUM_THREADS", "OMP_WAIT_POLICY", "GOMP_SPINCOUNT", "OMPI_MCA_mpi_yield_when_idle")
CORES = len(os.sched_getaffinity(0))
ENDLESS = 10**8
DECK = """
&run  dimension='plane_strain' /
&grid  lo=0,0,0  hi=1,1,1  dx={dx} /
&time  t_end=1e9  max_steps={steps}  dt_fixed=1e-7 /
&material  name='metal'  density=2700  young=70e9  poisson=0.3 /
&region  name='bar'   shape='box'  lo=0,0,0  hi=1,1,1 /
&body  name='one'   region='bar'   material='metal'  ppc=4,1,4  velocity=1,0,0 /
&boundary  face='all'  type='symmetry' /
&output  name='h'  kind='history'  every=1 /
&log  progress_seconds=0.5 /
"""
SMALL = DECK.replace("{dx}", "0.25")     # 256 particles in few tiles
LARGE = DECK.replace("{dx}", "0.02")     # 40000 particles


def clean(**more):
    """An environment without any setting of threads."""
    return {**{name: value for name, value in os.environ.items() if name not in SETTINGS}, **case.OPEN_MPI, **more}


class TestThreads:
    """Runs with and without settings of the user."""

    def threads(self, options, name, deck, **more):
        """Number of threads in the summary of a run, and the run."""
        run = case.Case(options, name, deck.format(steps=2))
        answer = subprocess.run(run.command(), env=clean(**more), cwd=run.folder, text=True, capture_output=True,
                                timeout=250, check=False)
        assert answer.returncode == 0, answer.stderr
        run.output = answer.stdout
        return run.summary["threads"], run

    def test_as_many_as_the_scene_keeps_busy(self, options):
        """One thread for few particles, all cores for many, and the number in OMP_NUM_THREADS if it is set; the same
        bits."""
        few, run = self.threads(options, "small", SMALL)
        assert few == 1
        if CORES > 1:
            assert "256 particles in" in run.output
        two, same = self.threads(options, "small_two", SMALL, OMP_NUM_THREADS="2")
        assert two == 2
        assert run.summary["digest"] == same.summary["digest"]
        assert self.threads(options, "large", LARGE)[0] == min(CORES, 40000 // 500)

    @pytest.fixture(autouse=True)
    def made(self):
        """Ensures that no process of the test is left running."""
        self.children = []
        yield
        for child in self.children:
            child.kill()

    def started(self, options, name, deck, *flags, **more):
        """A run that does not end by itself, after its first steps."""
        run = case.Case(options, name, deck.format(steps=ENDLESS))
        child = subprocess.Popen(run.command(*flags), env=clean(**more), cwd=run.folder, text=True,
                                 stdout=subprocess.PIPE, stderr=subprocess.STDOUT)
        self.children.append(child)
        history = run.path("_history.csv")
        end = time.monotonic() + 200
        while child.poll() is None and time.monotonic() < end and not (
                history.is_file() and history.stat().st_size > 2000):
            time.sleep(0.02)
        assert child.poll() is None, child.stdout.read() if child.poll() is not None else ""
        return run, child

    def stop(self, child):
        """Output of a run that is stopped by a signal."""
        child.send_signal(signal.SIGTERM)
        said, _ = child.communicate(timeout=200)
        assert child.returncode == 75, said
        return said

    def test_waiting(self, options, sheet):
        """Threads that wait for long release their core, unless the user sets otherwise. The program restarts itself in
        the same process, with all of its options, and handles signals."""
        # with two threads the options are the same after the program has restarted itself
        odd = ("--set", "run.title='a title with \"quotes\", blänks and = signs'", "-q")
        for name, more, expected in (("default", {}, "10000"), ("own", {"GOMP_SPINCOUNT": "7"}, "7"),
                                     ("policy", {"OMP_WAIT_POLICY": "passive"}, None),
                                     ("empty", {"GOMP_SPINCOUNT": ""}, "")):
            with sheet.part(name):
                run, child = self.started(options, f"wait_{name}", SMALL, *odd, OMP_NUM_THREADS="2", **more)
                place = Path("/proc") / str(child.pid)
                words = dict(word.split("=", 1) for word in place.joinpath("environ").read_bytes().decode().split("\0")
                             if "=" in word)
                assert words.get("GOMP_SPINCOUNT") == expected
                assert place.joinpath("cmdline").read_bytes().decode().split("\0")[:-1] == run.command(*odd)
                self.stop(child)
                assert "blänks" in run.path(".echo.nml").read_text(encoding="utf-8")
        run, child = self.started(options, "wait_one", SMALL, OMP_NUM_THREADS="1")
        assert b"GOMP_SPINCOUNT" not in Path(f"/proc/{child.pid}/environ").read_bytes()
        self.stop(child)

    def test_without_processor(self, options):
        """A run that is suspended for longer than it has worked warns once, with the remedy."""
        run, child = self.started(options, "starved", SMALL, "-q", OMP_NUM_THREADS="1")
        begin = time.monotonic()
        child.send_signal(signal.SIGSTOP)
        time.sleep(6.0)
        while time.monotonic() - begin < 4.0 * worked(child.pid):
            time.sleep(0.1)
        child.send_signal(signal.SIGCONT)
        log, end = run.path(".log"), time.monotonic() + 200
        while "of wall time" not in log.read_text(encoding="utf-8") and time.monotonic() < end:
            time.sleep(0.05)
        time.sleep(1.5)                           # two more lines of progress
        said = self.stop(child)
        assert said.count("s of wall time and") == 1, said
        assert "core of its own" in said
        run = case.Case(options, "fed", SMALL.format(steps=20)).run("-q")
        assert run.output == ""

    def test_studies(self):
        """A run of a study has one thread, and there are as many runs at a time as cores."""
        before = os.environ.pop("OMP_NUM_THREADS", None)
        try:
            assert (program.threads_of_a_run(), program.jobs_for(1)) == (1, CORES)
            os.environ["OMP_NUM_THREADS"] = "2"
            assert (program.threads_of_a_run(), program.jobs_for(2)) == (2, max(1, CORES // 2))
        finally:
            os.environ.pop("OMP_NUM_THREADS", None)
            if before is not None:
                os.environ["OMP_NUM_THREADS"] = before


def worked(process):
    """Processor time of a process [s]."""
    fields = Path(f"/proc/{process}/stat").read_text(encoding="ascii").rpartition(")")[2].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")
