# SPDX-License-Identifier: BSD-3-Clause
"""Kill a run at random times and restart it from its newest checkpoint."""

import os
import random
import re
import signal
import time
from pathlib import Path

import case

# A step takes about a millisecond, so most times are near or during the writing of a checkpoint.
DECK = """
&run  dimension='3d' /
&grid  lo=0,0,0  hi=12,12,12  dx=1 /
&time  t_end=0.6 /
&material  name='rubber'  density=1000  young=1.0e6  poisson=0.3 /
&region  name='box'  shape='box'  lo=1,1,1  hi=11,11,9 /
&body  name='block'  region='box'  material='rubber'  velocity=3,-6,9  spin=1,2,3 /
&boundary  face='all'  type='slip' /
&output  name='h'  kind='history'  every=5 /
&output  name='p'  kind='particles'  dt=0.1 /
&checkpoint  dt=0.02  keep=2 /
"""


def family(root):
    """A process and all its descendants."""
    parents = {}
    for entry in Path("/proc").iterdir():
        if entry.name.isdigit():
            try:
                text = (entry / "stat").read_text(encoding="utf-8", errors="replace")
            except OSError:
                continue      # it has ended meanwhile
            parents[int(entry.name)] = int(text[text.rindex(")") + 2:].split()[1])
    members, found = [root], True
    while found:
        found = [pid for pid, parent in parents.items() if parent in members and pid not in members]
        members += found
    return members


def kill_family(root):
    """Kill mpiexec and its ranks at the same time, as a machine that fails would."""
    members = family(root)
    for number in (signal.SIGSTOP, signal.SIGKILL):
        for pid in members:
            try:
                os.kill(pid, number)
            except ProcessLookupError:
                pass


def wait_for_steps(run, child):
    """Wait until the first step begins: starting mpiexec and reading a checkpoint take some time."""
    while child.poll() is None:
        time.sleep(0.005)
        if run.path(".log").is_file() and "t/t_end" in run.path(".log").read_text(
                encoding="utf-8", errors="replace"):
            return


def reported(run):
    """Numbers of the checkpoints that the last start has reported, and of the one from which it started."""
    log = run.path(".log")
    text = log.read_text(encoding="utf-8", errors="replace") if log.is_file() else ""
    written = [int(number) for number in re.findall(r"checkpoint \S+_chk_(\d+)\.h5 at step", text)]
    origin = re.search(r"restart from \S+_chk_(\d+)\.h5\n", text)
    return written, int(origin.group(1)) if origin else None


def end_by_kills(options, sheet, number, seed, ranks=1):
    """Kill a run `number` times, restart it each time, and compare its end with that of an uninterrupted run: state,
    history and snapshots."""
    whole = case.Case(options, f"whole_{ranks}", DECK)
    whole.name, whole.deck = "killed", whole.deck.rename(whole.folder / "killed.nml")
    whole.ranks = ranks
    whole.run("-q")
    length = whole.summary["wall_s"]
    run = case.Case(options, f"killed_{ranks}", DECK, ranks=ranks)
    run.name, run.deck = "killed", run.deck.rename(run.folder / "killed.nml")
    chance = random.Random(seed)
    kills, written, partial, ends, followed, last = 0, 0, 0, 0, 0, 0
    while kills < number:
        resume = any(run.folder.glob("*_chk_*.h5"))
        run.path(".log").unlink(missing_ok=True)
        begin = time.time()
        child = run.start("-q", *(["--restart"] if resume else []), start_new_session=True)
        if chance.random() < 0.7:
            wait_for_steps(run, child)
            time.sleep(chance.uniform(0.0, 0.5) * length)
        else:
            time.sleep(chance.uniform(0.02, 0.5) * length)
        if child.poll() is not None:
            # the run has ended before it was killed: start again
            sheet.require(child.returncode == 0, f"exit code {child.returncode}: "
                          f"{child.stdout.read()[-500:]}")
            sheet.require(run.summary["digest"] == whole.summary["digest"],
                          f"after {kills} kills the end is that of the whole run")
            ends += 1
            for path in run.folder.iterdir():
                if path != run.deck:
                    path.unlink()
            last = 0
            continue
        kill_family(child.pid)
        child.communicate()
        kills += 1
        partial += any(path.stat().st_mtime >= begin for path in run.folder.glob("*.part"))
        numbers, origin = reported(run)
        if resume and origin is not None:
            sheet.require(origin >= last, f"kill {kills}: goes on from {origin}, not from {last}")
            followed += 1
        written += len(numbers)
        last = max([last, *numbers])
    run.run("-q", *(["--restart"] if any(run.folder.glob("*_chk_*.h5")) else []))
    sheet.require(run.summary["digest"] == whole.summary["digest"],
                  f"{ranks} ranks: after {kills} kills the state is {run.summary['digest']}, not "
                  f"{whole.summary['digest']}")
    sheet.require(run.path("_history.csv").read_bytes() == whole.path("_history.csv").read_bytes(),
                  f"{ranks} ranks: the history is that of the whole run")
    names = sorted(path.name for path in whole.folder.glob("*.hdf"))
    sheet.require(names == sorted(path.name for path in run.folder.glob("*.hdf")),
                  f"{ranks} ranks: the snapshots are those of the whole run")
    for name in names:
        sheet.require((whole.folder / name).read_bytes() == (run.folder / name).read_bytes(),
                      f"{ranks} ranks: {name} is that of the whole run")
    sheet.require(not any(run.folder.glob("*.part")), "no half file is left at the end")
    if number >= 20:      # a small number of kills may by chance all occur before the first checkpoint
        sheet.require(followed > 0, f"{followed} restarts are followed in the log")
        sheet.require(written > number // 4, f"{written} checkpoints between {number} kills")
    print(f"         {ranks} ranks: {kills} kills, {partial} of them in the middle of a file, "
          f"{written} checkpoints, {ends} ends on the way")
