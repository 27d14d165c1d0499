# SPDX-License-Identifier: BSD-3-Clause
"""One run of a case in a folder at a time.

Would catch: a second run that replaces, continues or removes the files of a run that is still computing; a lock that
remains and refuses the run after a kill, or that is removed by a run that does not own it; a run on another host that
is taken for ended; files of other programs that are changed through a link; ranks with different options that wait for
each other.
"""

import os
import signal
import subprocess
import time

import pytest

import case

DECK = """
&run  dimension='1d' /
&grid  lo=0,0,0  hi=1,1,1  dx=0.1 /
&time  t_end=1  max_steps=20  dt_fixed=1e-9 /
&material  name='metal'  density=2700  young=70e9  poisson=0.3 /
&region  name='bar'   shape='box'  lo=0.1,0,0  hi=0.5,1,1 /
&body  name='one'   region='bar'   material='metal' /
"""
ENDLESS = ("--set", "time.max_steps=100000000")
OTHER = "node7 4f1c-another-kernel 17 4711 1700000000 {beat}\n"    # a line of a lock of another host


def await_file(path, child=None):
    """Wait until a file exists."""
    end = time.monotonic() + 60
    while not path.exists():
        assert time.monotonic() < end and (child is None or child.poll() is None), f"no {path.name}"
        time.sleep(0.02)


def contents(folder, without=()):
    """Files of a folder with their contents; of a lock without its last word, the sign of life every ten seconds."""
    files = [path for path in folder.iterdir() if path.is_file() and path.name not in without]
    return {path.name: path.read_bytes().split()[:-1] if path.suffix == ".lock" else path.read_bytes()
            for path in files}


@pytest.fixture(scope="module", autouse=True)
def watching(file_options):
    """A run that watches the lock of a host that has ended, for half a minute beside the other tests; its process and
    when it began [s]."""
    run = case.Case(file_options, "watching", DECK)
    run.guarded = True
    run.path(".lock").write_text(OTHER.format(beat=1700000000), encoding="utf-8")
    begin = time.time()
    child = run.start("--restart")
    yield run, child, begin
    child.kill()
    child.wait(timeout=60)


class TestLock:
    """Each test has a folder of its own."""

    @pytest.fixture(autouse=True)
    def children(self):
        """Runs that a failed test leaves are ended."""
        self.started = []
        yield
        for child in self.started:
            child.kill()
            child.wait(timeout=60)

    def start(self, run, *words):
        """Start a run."""
        self.started.append(run.start(*words))
        return self.started[-1]

    def run_of(self, options, name="c", **how):
        run = case.Case(options, name, DECK, **how)
        run.guarded = True
        return run

    @pytest.mark.parametrize("ranks", [1, 2])
    def test_two_at_the_same_time(self, options, ranks):
        """Would catch a second run that starts beside the first one, in each of the three ways, also in another process
        of several ranks; and a lock that the second one removes."""
        if ranks > 1:
            case.need_ranks(options.scree)
        first = self.run_of(options)
        child = self.start(first, "--quiet", *ENDLESS)
        lock = first.path(".lock")
        await_file(first.path("_p_000000.hdf"), child)
        end = time.monotonic() + 60
        while "t/t_end" not in first.path(".log").read_text(encoding="utf-8"):
            assert time.monotonic() < end
            time.sleep(0.02)
        time.sleep(0.3)                                  # all output of the first state
        second = self.run_of(options, ranks=ranks, keep=True)
        before = contents(first.folder, ("c.log",))
        for words in (["--overwrite"], ["--restart"], []):
            second.run("--quiet", *words, expect=3)
            assert f"case 'c' in '{first.folder}' is in use by process {child.pid} on host" in second.output
            assert "wait for its end or stop it" in second.output
            assert contents(first.folder, ("c.log",)) == before and child.poll() is None
        self.run_of(options, "beside").run("--quiet", "--case", "d", "--outdir", first.folder)
        child.send_signal(signal.SIGUSR1)
        assert child.wait(timeout=60) == 75
        assert not lock.exists()
        second.run("--quiet", "--restart", "--set", "time.max_steps=0", expect=None)
        assert "in use" not in second.output

    def test_killed(self, options):
        """Would catch a lock of a killed run that refuses the next run at once, and a killed run that cannot be
        continued because it has no checkpoint yet: a run that starts with --restart writes one first."""
        run = self.run_of(options)
        child = self.start(run, "--quiet", "--restart", *ENDLESS)
        await_file(run.path("_chk_0001.h5"), child)
        os.kill(child.pid, signal.SIGKILL)
        # not waited for: the ended process is still listed
        again = self.run_of(options, keep=True).run("--restart", "--set", "time.max_steps=30")
        assert "the lock of an earlier run, process" in again.output
        assert "restart from" in again.output
        assert again.summary["steps"] == 30
        assert not run.path(".lock").exists()
        child.wait(timeout=60)

    def test_reused_number(self, options):
        """Would catch a lock that is kept because another process has the number of the killed one."""
        run = self.run_of(options)
        child = self.start(run, "--quiet", *ENDLESS)
        await_file(run.path(".lock"), child)
        line = run.path(".lock").read_text(encoding="utf-8").split()
        child.kill()
        child.wait(timeout=60)
        line[2] = str(os.getpid())
        run.path(".lock").write_text(" ".join(line) + "\n", encoding="utf-8")
        run.run("--overwrite")
        assert "the lock of an earlier run" in run.output

    def test_other_host_that_runs(self, options):
        """Would catch a run on another host that is taken for ended although it gives signs of life, whatever its
        clock says."""
        run = self.run_of(options)
        lock = run.path(".lock")
        lock.write_text(OTHER.format(beat=1700000000), encoding="utf-8")
        child = self.start(run, "--restart")
        time.sleep(1.5)
        assert child.poll() is None
        lock.write_text(OTHER.format(beat=1700000010), encoding="utf-8")
        output, _ = child.communicate(timeout=60)
        assert child.returncode == 3
        assert "is in use by process 17 on host 'node7'" in output
        assert "waiting until it is clear whether process 17 on host 'node7'" in output
        assert lock.read_text(encoding="utf-8") == OTHER.format(beat=1700000010)

    def test_lost_lock(self, options):
        """Would catch a run that goes on writing although another host has taken over its files."""
        run = self.run_of(options)
        child = self.start(run, "--quiet", *ENDLESS)
        await_file(run.path("_p_000000.hdf"), child)
        run.path(".lock").write_text(OTHER.format(beat=int(time.time())), encoding="utf-8")
        output, _ = child.communicate(timeout=60)
        assert child.returncode == 3
        assert "another run took over the files of this case" in output
        assert run.path(".lock").exists() and not run.path(".summary.json").exists()

    def test_nothing_to_restart(self, options):
        """Would catch a restart that fails where there is nothing, removes results without a checkpoint, or leaves a
        new folder after an error."""
        run = self.run_of(options)
        run.run("--restart")
        assert "there are no results of this case to continue, so --restart starts it at step 0" in run.output
        assert run.summary["steps"] == 20
        for path in run.folder.glob("*.h5"):
            path.unlink()
        before = contents(run.folder)
        run.run("--restart", expect=3)
        assert "no checkpoint 'c_chk_*.h5' in" in run.output and "--overwrite" in run.output
        assert contents(run.folder) == before
        run.run("--restart", "nobody.h5", "--outdir", run.folder / "new", expect=3)
        assert not (run.folder / "new").exists()

    def test_planted_link(self, options):
        """Would catch a file of another program that is emptied through a link with the name of an incomplete file."""
        run = self.run_of(options)
        victim = run.folder / "victim"
        victim.write_text("mine", encoding="utf-8")
        for name in ("c.log", "c.echo.nml.part", "c_p_000000.hdf.part", "c_chk_0001.h5.part", "c.summary.json.part"):
            (run.folder / name).symlink_to(victim)
        run.run("--quiet")
        assert victim.read_text(encoding="utf-8") == "mine"
        assert not [path for path in run.folder.iterdir() if path.is_symlink()]

    def test_different_ranks(self, options):
        """Would catch ranks with different options or decks that wait for each other forever, or that compute with the
        options of the first one only."""
        case.need_ranks(options.scree)
        run = self.run_of(options)
        (run.folder / "other.nml").write_text(DECK.replace("0.1 /", "0.2 /"), encoding="utf-8")
        one = [str(options.scree), "--quiet", "--outdir", "out", run.deck.name]
        for two in ([*one, "--set", "time.max_steps=10"], [*one[:-1], "other.nml"], [*one, "--restart"]):
            answer = subprocess.run(["mpiexec", "-n", "1", *one, ":", "-n", "1", *two], cwd=run.folder, text=True,
                                    env=run.environment, timeout=60, capture_output=True)
            assert answer.returncode == 2, answer.stderr
            assert answer.stderr.count("the ranks have different decks, options or versions of scree") == 1
        assert not (run.folder / "out").exists()

    def test_other_host_that_has_ended(self, watching):
        """Would catch a lock of another host that is taken over before it was watched for three signs of life, or
        never."""
        run, child, begin = watching
        output, _ = child.communicate(timeout=100)
        assert child.returncode == 0, output
        assert 29 < run.path(".summary.json").stat().st_mtime - begin < 100
        assert "the lock of an earlier run, process 17 on host 'node7'" in output
        assert not run.path(".lock").exists()
