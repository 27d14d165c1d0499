# SPDX-License-Identifier: BSD-3-Clause
"""Runs that cannot or must not go on: signals, wall time, a step too small, files that fail.

Would catch: a checkpoint that is not the state at the stop, a wrong exit code, work lost on a
signal, a run that overwrites its last good checkpoint with half a file, an error of a file that is
not noticed.
"""
# timeout: 200

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "support"))
import case    # noqa: E402
import report  # noqa: E402

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


def deck(steps=STEPS, time="", checkpoint=""):
    """A block that shakes in a closed box."""
    return DECK.format(steps=steps, time=time, checkpoint=checkpoint)


def checkpoints(folder):
    """Checkpoints in a folder, oldest first."""
    return sorted(folder.glob("*_chk_*.h5"))


def signals(options, sheet, digest):
    """A signal in the middle: exit code 75 and a checkpoint that leads to the same end."""
    for ranks, number in ((1, signal.SIGUSR1), (1, signal.SIGTERM), (2, signal.SIGUSR1)):
        name = f"signal_{number.name}_{ranks}"
        run = case.Case(options, name, deck(), ranks=ranks)
        table = run.path("_history.csv")
        child = run.start("-q")
        for _ in range(1000):      # until some steps are done
            time.sleep(0.01)
            if child.poll() is not None or table.is_file() and table.stat().st_size > 4000:
                break
        child.send_signal(number)
        child.communicate(timeout=100)
        stopped = run.summary
        sheet.require(child.returncode == 75, f"{name}: exit code {child.returncode}")
        sheet.require(0 < stopped["steps"] < STEPS, f"{name}: stops at step {stopped['steps']}")
        sheet.require(stopped["exit_code"] == 75, f"{name}: the summary says 75")
        run.ranks = 3 - ranks
        run.run("-q", "--restart")
        sheet.require(run.summary["digest"] == digest,
                      f"{name}: the restart ends in the same state")
        print(f"         {name}: stopped at step {stopped['steps']}")


def limits(options, sheet, digest):
    """Wall time and least time step."""
    run = case.Case(options, "wall_limit", deck(100000000, "wall_limit='00:00:01'"))
    run.run("-q", expect=75)
    sheet.require(run.summary["steps"] > 0 and len(checkpoints(run.folder)) == 1,
                  "wall_limit: leaves a checkpoint")
    sheet.require(0.5 < run.summary["wall_s"] < 10.0, "wall_limit: leaves after a second")
    run = case.Case(options, "dt_min", deck(time="dt_min=1.0e-2"))
    run.run("-q", expect=4)
    sheet.require("dt_min" in run.output, f"dt_min: says so: {run.output}")
    sheet.require(len(checkpoints(run.folder)) == 1, "dt_min: leaves a checkpoint")
    run.deck.write_text(deck(), encoding="utf-8")
    run.run("-q", "--restart")
    sheet.require(run.summary["digest"] == digest,
                  "dt_min: a restart without it ends in the same state")


def scheduler(options, sheet):
    """The end of the job is what the environment says, else what squeue prints; a minute before it
    the run leaves."""
    words = ("SLURM_JOB_END_TIME", "SLURM_JOB_ID", "PATH")
    before = {word: os.environ.get(word) for word in words}
    try:
        os.environ.pop("SLURM_JOB_END_TIME", None)
        os.environ.pop("SLURM_JOB_ID", None)
        run = case.Case(options, "no_job", deck(5, "wall_limit='slurm'"))
        run.run()
        sheet.require("this is no job of Slurm" in run.output, f"no job: says so: {run.output}")
        os.environ["SLURM_JOB_ID"] = "no number"
        run = case.Case(options, "no_end", deck(100000000, "wall_limit='slurm'"))
        run.run("-q", expect=2)
        sheet.require("SLURM_JOB_END_TIME" in run.output, f"a job without an end: says so: {run.output}")
        del os.environ["SLURM_JOB_ID"]
        os.environ["SLURM_JOB_END_TIME"] = str(int(time.time()) + 63)
        run = case.Case(options, "job_end", deck(100000000, "wall_limit='slurm'"), ranks=2)
        run.run("-q", expect=75)
        sheet.require(len(checkpoints(run.folder)) == 1, "job end: leaves a checkpoint")
        del os.environ["SLURM_JOB_END_TIME"]
        squeue = run.folder / "squeue"
        squeue.write_text('#!/bin/sh\ntest "$3" = 4711 && echo 1:01\n', encoding="utf-8")
        squeue.chmod(0o755)
        os.environ.update(SLURM_JOB_ID="4711", PATH=f"{run.folder}:{before['PATH']}")
        run.run("-q", "--restart", expect=75)
        sheet.require(run.summary["reason"].startswith("wall_limit"), "squeue: leaves by the clock")
    finally:
        for word, value in before.items():
            if value is None:
                os.environ.pop(word, None)
            else:
                os.environ[word] = value


def files(options, sheet):
    """A folder that cannot be made, a deck and a checkpoint that cannot be read."""
    run = case.Case(options, "folder", deck(5))
    (run.folder / "file").write_text("not a folder", encoding="utf-8")
    run.run("-q", "--outdir", run.folder / "file/out", expect=3)
    sheet.require((run.folder / "file").read_text(encoding="utf-8") == "not a folder",
                  "folder: what is in the way stays")
    run.run("-q", "--restart", expect=3)
    sheet.require("heckpoint" in run.output, f"restart without a checkpoint: {run.output}")
    if os.geteuid() != 0:
        locked = run.folder / "locked"
        locked.mkdir(mode=0o555)
        run.run("-q", "--outdir", locked / "out", expect=3)
    run.deck.unlink()
    run.run("-q", expect=3)
    sheet.require("folder.nml" in run.output, f"no deck: {run.output}")


def mounted(folder):
    """Mount a file system of 4 MB; false if that is not allowed."""
    folder.mkdir(parents=True, exist_ok=True)
    answer = subprocess.run(["mount", "-t", "tmpfs", "-o", "size=4m", "tmpfs", str(folder)],
                            stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, check=False)
    return answer.returncode == 0


def fill(path, left):
    """Fill the disk up to some bytes."""
    with open(path, "wb", buffering=0) as filler:
        try:
            while True:
                filler.write(bytes(4096))
        except OSError:
            pass
    os.truncate(path, path.stat().st_size - left)


def full_disk(options, sheet, digest):
    """The disk fills up between two checkpoints: exit code 3, the older one is intact."""
    folder = options.work / "small_disk"
    subprocess.run(["umount", str(folder)], stderr=subprocess.DEVNULL, check=False)
    try:
        small = mounted(folder)
    except OSError:
        small = False
    if not small:
        print("         full disk: mounting is not allowed here, not tested")
        return
    try:
        run = case.Case(options, "small_disk", deck(), keep=True)
        run.run("-q", "-s", "time.max_steps=100")
        before = {path.name: path.read_bytes() for path in checkpoints(folder)}
        sheet.require(len(before) == 1, "full disk: there is a checkpoint")
        for left in (0, 400 * 1024):     # no byte; enough for all but a checkpoint
            fill(folder / "filler", left)
            run.run("-q", "--restart", expect=None)
            sheet.require(run.code == 3, f"full disk: exit code {run.code}: {run.output[-300:]}")
            sheet.require("No space left" in run.output, f"full disk: says so: {run.output[-300:]}")
            for name, content in before.items():
                sheet.require((folder / name).read_bytes() == content,
                              f"full disk: {name} is intact")
            sheet.require(len(checkpoints(folder)) == 1, "full disk: no half checkpoint is left")
            print(f"         full disk but {left} bytes: {run.output.strip()[-160:]}")
        (folder / "filler").unlink()
        run.run("-q", "--restart")
        sheet.require(run.summary["digest"] == digest, "full disk: with space again it goes on")
    finally:
        subprocess.run(["umount", str(folder)], check=False)


def main():
    """All stops."""
    options = case.arguments()
    sheet = report.Report()
    run = case.Case(options, "whole", deck()).run("-q")
    digest = run.summary["digest"]
    sheet.require(run.summary["steps"] == STEPS, "the whole run makes all steps")
    signals(options, sheet, digest)
    limits(options, sheet, digest)
    scheduler(options, sheet)
    files(options, sheet)
    full_disk(options, sheet, digest)
    sheet.end()


if __name__ == "__main__":
    main()
