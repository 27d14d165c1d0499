# SPDX-License-Identifier: BSD-3-Clause
"""Runs that cannot or must not continue: signals, wall time, a step that is too small, files that cannot be written.

Would catch: a checkpoint that is not the state at the stop, a wrong exit code, work lost on a
signal, a run that overwrites its last valid checkpoint with an incomplete file, a file error that is not reported.
"""
# timeout: 600

import os
import shlex
import signal
import sys
import time
from pathlib import Path
from types import SimpleNamespace

import pytest

import case
import confine
import report

DECK = """
&run  dimension='3d' /
&grid  lo=0,0,0  hi=12,12,12  dx=1 /
&time  t_end=1000  max_steps={steps}  {time} /
&material  name='rubber'  density=1000  young=1.0e6  poisson=0.3 /
&region  name='box'  shape='box'  lo=1,1,1  hi=11,11,9 /
&body  name='block'  region='box'  material='rubber'  velocity=3,-6,9  spin=1,2,3 /
&boundary  face='all'  type='slip' /
&output  name='h'  kind='history'  every=1 /
&checkpoint  {checkpoint} /
"""
STEPS = 400
ENDLESS = 100000000     # steps that no machine completes during this test
WAIT = 150              # far longer than any machine needs [s]
LOGS = (".log", ".json", ".echo.nml")
SMALL_DISK = "small_disk"


def deck(steps=STEPS, time="", checkpoint=""):
    """A vibrating block in a closed box."""
    return DECK.format(steps=steps, time=time, checkpoint=checkpoint)


def checkpoints(folder):
    """Checkpoints in a folder, oldest first."""
    return sorted(folder.glob("*_chk_*.h5"))


def test_signals(options, sheet):
    """A signal in the middle: exit code 75 and a checkpoint from which the run ends as an uninterrupted one."""
    for ranks, number in ((1, signal.SIGUSR1), (1, signal.SIGTERM), (2, signal.SIGUSR1)):
        name = f"signal_{number.name}_{ranks}"
        # only the signal ends this run, however long the signal takes
        run = case.Case(options, name, deck(ENDLESS), ranks=ranks)
        table = run.path("_history.csv")
        child = run.start("-q")
        wait_for(child, lambda: table.is_file() and table.stat().st_size > 4000)   # some steps are done
        child.send_signal(number)
        said, _ = child.communicate(timeout=WAIT)
        sheet.require(child.returncode == 75, f"{name}: exit code {child.returncode}: {said[-300:]}")
        stopped = run.summary
        sheet.require(0 < stopped["steps"] < ENDLESS, f"{name}: stops at step {stopped['steps']}")
        sheet.require(stopped["exit_code"] == 75, f"{name}: the summary says 75")
        told = run.path(".log").read_text(encoding="utf-8").splitlines()[-1]
        sheet.require(told.startswith("go on ") and told.endswith(f"{shlex.quote(str(run.deck))} --restart")
                      and ("mpirun -n 2 " in told) == (ranks == 2), f"{name}: the last line goes on: {told}")
        run.ranks = 3 - ranks
        last = f"time.max_steps={stopped['steps'] + 50}"
        run.run("-q", "--restart", "-s", last)
        whole = case.Case(options, f"{name}_whole", deck(ENDLESS)).run("-q", "-s", last)
        sheet.require(whole.summary["steps"] == stopped["steps"] + 50, f"{name}: the whole run makes all steps")
        sheet.require(run.summary["digest"] == whole.summary["digest"],
                      f"{name}: the restart ends in the same state")
        print(f"         {name}: stopped at step {stopped['steps']}")


def wait_for(child, ready):
    """Wait until a condition holds or the child has ended; after the time limit the test fails by its own checks."""
    end = time.monotonic() + WAIT
    while not ready() and child.poll() is None and time.monotonic() < end:
        time.sleep(0.01)


@pytest.fixture(scope="module")
def digest(file_options):
    """Digest of the whole run, which makes all steps."""
    run = case.Case(file_options, "whole", deck()).run("-q")
    assert run.summary["steps"] == STEPS
    return run.summary["digest"]


def test_limits(options, sheet, digest):
    """Wall time and least time step."""
    run = case.Case(options, "wall_limit", deck(ENDLESS, "wall_limit='00:00:01'"))
    run.run("-q", expect=75)
    sheet.require(run.summary["steps"] > 0 and len(checkpoints(run.folder)) == 1,
                  "wall_limit: leaves a checkpoint")
    # it may end earlier by the time that the checkpoint takes; a run without the limit does not end
    sheet.require(run.summary["wall_s"] > 0.5, "wall_limit: computes until then")
    run = case.Case(options, "dt_min", deck(time="dt_min=1.0e-2"))
    run.run("-q", expect=4)
    sheet.require("dt_min" in run.output, f"dt_min: says so: {run.output}")
    sheet.require(len(checkpoints(run.folder)) == 1, "dt_min: leaves a checkpoint")
    run.deck.write_text(deck(), encoding="utf-8")
    run.run("-q", "--restart")
    sheet.require(run.summary["digest"] == digest,
                  "dt_min: a restart without it ends in the same state")


def test_scheduler(options, sheet):
    """The end of the job is taken from the environment, else from squeue; the run ends a minute before it."""
    words = ("SLURM_JOB_END_TIME", "SLURM_JOB_ID", "PATH")
    before = {word: os.environ.get(word) for word in words}
    try:
        os.environ.pop("SLURM_JOB_END_TIME", None)
        os.environ.pop("SLURM_JOB_ID", None)
        run = case.Case(options, "no_job", deck(5, "wall_limit='slurm'"))
        run.run()
        sheet.require("this is not a Slurm job" in run.output, f"no job: says so: {run.output}")
        os.environ["SLURM_JOB_ID"] = "no number"
        run = case.Case(options, "no_end", deck(ENDLESS, "wall_limit='slurm'"))
        run.run("-q", expect=2)
        sheet.require("SLURM_JOB_END_TIME" in run.output, f"a job without an end: says so: {run.output}")
        del os.environ["SLURM_JOB_ID"]
        os.environ["SLURM_JOB_END_TIME"] = str(int(time.time()) + 63)
        run = case.Case(options, "job_end", deck(ENDLESS, "wall_limit='slurm'"), ranks=2)
        run.run("-q", expect=75)
        sheet.require(len(checkpoints(run.folder)) == 1, "job end: leaves a checkpoint")
        del os.environ["SLURM_JOB_END_TIME"]
        # one rank: mpiexec may put the folder of MPI, with the squeue of a machine with Slurm, first in the search path
        run = case.Case(options, "squeue", deck(ENDLESS, "wall_limit='slurm'"))
        squeue = run.folder / "squeue"
        squeue.write_text('#!/bin/sh\ntest "$3" = 4711 && echo 1:01\n', encoding="utf-8")
        squeue.chmod(0o755)
        os.environ.update(SLURM_JOB_ID="4711", PATH=f"{run.folder}:{before['PATH']}")
        run.run("-q", expect=75)
        sheet.require(run.summary["reason"].startswith("wall_limit"), "squeue: leaves by the clock")
    finally:
        for word, value in before.items():
            if value is None:
                os.environ.pop(word, None)
            else:
                os.environ[word] = value


def test_files(options, sheet):
    """A folder that cannot be created, a deck and a checkpoint that cannot be read."""
    run = case.Case(options, "folder", deck(5))
    (run.folder / "file").write_text("not a folder", encoding="utf-8")
    run.run("-q", "--outdir", run.folder / "file/out", expect=3)
    sheet.require((run.folder / "file").read_text(encoding="utf-8") == "not a folder",
                  "folder: what is in the way stays")
    run.run("-q", "--set", "checkpoint.at_end=F")
    run.run("-q", "--restart", expect=3)
    sheet.require("heckpoint" in run.output, f"restart of results without a checkpoint: {run.output}")
    run.deck.unlink()
    run.run("-q", expect=3)
    sheet.require("folder.nml" in run.output, f"no deck: {run.output}")


def test_no_permission(options, sheet):
    """Folders and files that an ordinary user may not write or read: exit code 3, and existing files are unchanged."""
    with confine.user(options) as somebody:
        if somebody.why:
            sheet.skipped("no permission", somebody.why)
            return
        run = case.Case(somebody.options, "locked", deck(5))
        locked = run.folder / "locked"
        locked.mkdir()
        somebody.give(run.folder)
        run.run("-q", **somebody.identity)
        before = contents(run.folder)
        sheet.require(len(checkpoints(run.folder)) == 1, "no permission: there is a checkpoint")
        locked.chmod(0o555)
        refused(sheet, run, somebody, "a folder in it", "-q", "--outdir", locked / "out")
        refused(sheet, run, somebody, "files in it", "-q", "--outdir", locked)
        sheet.require(not list(locked.iterdir()), "no permission: nothing is in the locked folder")
        checkpoints(run.folder)[0].chmod(0)
        refused(sheet, run, somebody, "the checkpoint", "-q", "--restart")
        checkpoints(run.folder)[0].chmod(0o644)
        run.folder.chmod(0o555)
        refused(sheet, run, somebody, "the folder of the run", "-q", "--restart", "-s", "time.max_steps=9")
        run.folder.chmod(0o755)
        run.deck.chmod(0)
        refused(sheet, run, somebody, "the deck", "-q")
        run.deck.chmod(0o644)
        kept = {name: content for name, content in contents(run.folder).items() if not name.endswith(LOGS)}
        sheet.require(kept == {name: content for name, content in before.items() if not name.endswith(LOGS)},
                      "no permission: checkpoint, history and deck are as they were")


def contents(folder):
    """Files of a folder with their contents."""
    return {path.name: path.read_bytes() for path in folder.iterdir() if path.is_file()}


def refused(sheet, run, somebody, what, *words):
    """A call that must fail for lack of permission."""
    run.run(*words, expect=None, **somebody.identity)
    sheet.require(run.code == 3, f"no permission, {what}: exit code {run.code}: {run.output[-300:]}")
    sheet.require("Permission denied" in run.output, f"no permission, {what}: says so: {run.output[-300:]}")
    print(f"         no permission, {what}: {run.output.strip()[-160:]}")


def fill(path, left):
    """Fill the disk up to some bytes."""
    with open(path, "wb", buffering=0) as filler:
        try:
            while True:
                filler.write(bytes(4096))
        except OSError:
            pass
    os.truncate(path, path.stat().st_size - left)


def no_space(sheet, run, what, words, refuse):
    """No space, or enough for all but a checkpoint: exit code 3, and the older checkpoint is intact."""
    before = {path.name: path.read_bytes() for path in checkpoints(run.folder)}
    sheet.require(len(before) == 1, f"{what}: there is a checkpoint")
    for left in (0, 400 * 1024):
        how = refuse(left)
        run.run("-q", "--restart", expect=None, **how)
        sheet.require(run.code == 3, f"{what}: exit code {run.code}: {run.output[-300:]}")
        sheet.require(words in run.output, f"{what}: says so: {run.output[-300:]}")
        for name, content in before.items():
            sheet.require((run.folder / name).read_bytes() == content, f"{what}: {name} is intact")
        sheet.require(len(checkpoints(run.folder)) == 1, f"{what}: no half checkpoint is left")
        print(f"         {what} but {left} bytes: {run.output.strip()[-160:]}")


def test_short_files(options, sheet, digest):
    """Files with a size limit: the same errors as on a full disk, on any machine."""
    run = case.Case(options, "short_files", deck()).run("-q", "-s", "time.max_steps=100")
    table = run.path("_history.csv").stat().st_size
    # first the history cannot be extended; then it can, and the checkpoint is too large
    no_space(sheet, run, "short files", "File too large",
             lambda left: confine.short_files(table + left))
    run.run("-q", "--restart")
    sheet.require(run.summary["digest"] == digest, "short files: without the limit it goes on")


def full_disk(options, sheet, digest):
    """The disk becomes full between two checkpoints; called in a folder on a small disk."""
    run = case.Case(options, SMALL_DISK, deck(), keep=True).run("-q", "-s", "time.max_steps=100")

    def refuse(left):
        fill(run.folder / "filler", left)
        return {}

    no_space(sheet, run, "full disk", "No space left", refuse)
    (run.folder / "filler").unlink()
    run.run("-q", "--restart")
    sheet.require(run.summary["digest"] == digest, "full disk: with space again it goes on")


def test_full_disk(options, sheet, digest):
    """A small file system in a folder of the test."""
    folder = options.work / SMALL_DISK
    way = confine.way_to_small_disks(folder)
    if not way:
        pytest.skip("no small file system can be mounted here; files with a limit stand in")
    code = confine.on_small_disk(way, folder, "4m", [
        "env", f"PYTHONPATH={os.pathsep.join(sys.path)}", sys.executable, "-c",
        "import sys, test_stops; test_stops.on_small_disk(*sys.argv[1:])", options.scree, options.work, digest])
    sheet.require(code == 0, f"full disk: exit code {code} of the test on a small disk")


def on_small_disk(scree, work, digest):
    """The part of test_full_disk that runs in a folder on a small disk."""
    sheet = report.Report()
    full_disk(SimpleNamespace(scree=Path(scree), work=Path(work)), sheet, digest)
    print(sheet.verdict())
    sys.exit(0 if sheet.good() else 1)
