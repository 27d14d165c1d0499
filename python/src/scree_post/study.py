# SPDX-License-Identifier: BSD-3-Clause
"""A study: one deck run for all combinations of values, each in a folder of its own."""
import hashlib
import itertools
import json
import os
import re
import shutil
import signal
import subprocess
from concurrent.futures import ThreadPoolExecutor, as_completed
from dataclasses import dataclass, field

from scree.program import find_program

from .errors import EXIT_USAGE, PostError
from .progress import Progress

STAMP = "sweep.json"     # in the folder of a run: what was run
SCREEN = "screen.txt"    # in the folder of a run: what the program said
STOPPED = 75             # exit code of a run that asks to be run again with --restart


@dataclass
class Run:
    """One combination of values."""

    values: dict                                         # text of each key
    folder: str
    case: str
    code: int = None                                     # exit code; None if it did not run
    reason: str = ""                                     # why it failed
    kept: bool = False                                   # done by an earlier call
    summary: dict = field(default_factory=dict)


def settings(words):
    """Keys and their lists of values, from GROUP.KEY=A,B,C; values that hold commas end in ';'."""
    found = {}
    for word in words:
        key, equals, text = word.partition("=")
        if not equals or not re.fullmatch(r"\w+(\[[^\]]+\])?\.\w+", key):
            raise PostError(f"--set {word}: write GROUP.KEY=A,B,C or 'GROUP[NAME].KEY=A,B'",
                            EXIT_USAGE)
        values = [part.strip() for part in text.split(";" if ";" in text else ",")]
        values = [value for value in values if value]
        if not values:
            raise PostError(f"--set {word}: no value", EXIT_USAGE)
        if key in found:
            raise PostError(f"--set {key} is given twice; list its values behind one", EXIT_USAGE)
        if len(set(values)) < len(values):
            raise PostError(f"--set {word}: a value stands there twice", EXIT_USAGE)
        found[key] = values
    return found


def short(key):
    """The part of a key that names folders and columns."""
    return key.rpartition(".")[2]


def name_of(values):
    """A name for files from the values, such as mu_s_0.3_dx_0.1."""
    clash = len({short(key) for key in values}) < len(values)
    words = [f"{key if clash else short(key)}_{value}" for key, value in values.items()]
    return re.sub(r"[^\w.+-]+", "_", "_".join(words)).strip("_")


def combinations(keys, base, case):
    """A Run for every combination of values."""
    runs = []
    for chosen in itertools.product(*keys.values()):
        values = dict(zip(keys, chosen))
        name = name_of(values)
        runs.append(Run(values, os.path.join(base, name), f"{case}_{name}"))
    folders = [run.folder for run in runs]
    for folder in folders:
        if folders.count(folder) > 1:
            raise PostError(f"two combinations of values would share the folder {folder}",
                            EXIT_USAGE)
    return runs


def stamp_of(run, deck, version):
    """What makes a finished run the one that is asked for."""
    with open(deck, "rb") as handle:
        digest = hashlib.sha256(handle.read()).hexdigest()
    return {"deck": digest, "values": run.values, "program": version}


def cores():
    """Cores that this process may use."""
    return len(os.sched_getaffinity(0))


def threads_of_a_run():
    """Threads of a run of a study: one, as many runs at a time use the cores better, or those of OMP_NUM_THREADS."""
    try:
        return max(1, int(os.environ.get("OMP_NUM_THREADS", "1")))
    except ValueError:
        return 1


def jobs_for(threads):
    """Runs at a time that keep the cores busy."""
    return max(1, cores() // threads)


def version_of(program):
    """What the program says it is."""
    try:
        answer = subprocess.run([program, "--version"], capture_output=True, text=True, check=True)
    except (OSError, subprocess.CalledProcessError) as error:
        raise PostError(f"{program} does not tell its version; is it scree?") from error
    return answer.stdout.strip()


def read_stamp(folder):
    """What was run in a folder, or nothing if no sweep made it."""
    try:
        with open(os.path.join(folder, STAMP), encoding="utf-8") as handle:
            stamp = json.load(handle)
    except (OSError, ValueError):
        return {}
    return stamp if isinstance(stamp, dict) and isinstance(stamp.get("values"), dict) else {}


def is_done(run, stamp):
    """Whether an earlier call finished this run with the same deck and values."""
    try:
        with open(os.path.join(run.folder, STAMP), encoding="utf-8") as handle:
            if json.load(handle) != stamp:
                return False
        run.summary = read_summary(run)
    except (OSError, ValueError):
        return False
    return run.summary.get("exit_code") == 0


def holds_results(folder):
    """Whether a folder of a run holds more than what was run and said."""
    return os.path.isdir(folder) and bool(set(os.listdir(folder)) - {STAMP, SCREEN})


def read_summary(run):
    """What CASE.summary.json of a run holds."""
    with open(os.path.join(run.folder, f"{run.case}.summary.json"), encoding="utf-8") as handle:
        return json.load(handle)


def reason_of(said, code):
    """Why a run failed, from what the program said: its first error, or its last line."""
    lines = [line.strip() for line in said.splitlines() if line.strip()]
    errors = [line for line in lines if "error" in line.lower()]
    return (errors or lines[-1:] or [f"exit code {code}"])[0][:200]


class Study:
    """Runs combinations, some at a time. Results of another deck, of other values or of another program are
    replaced only if `overwrite` is true."""

    def __init__(self, program, deck, threads=1, overwrite=False):
        self.program, self.deck, self.threads = program, os.path.abspath(deck), threads
        self.overwrite = overwrite
        self.version = version_of(program)
        self.children, self.stopping = set(), False

    def command(self, run, restart):
        """The words that start a run."""
        words = [self.program, "--quiet", "--case", run.case, "--outdir", run.folder]
        for key, value in run.values.items():
            words += ["--set", f"{key}={value}"]
        return words + (["--restart"] if restart else []) + [self.deck]

    def is_same(self, run, stamp):
        """Whether the folder is of this deck, these values and this program."""
        try:
            with open(os.path.join(run.folder, STAMP), encoding="utf-8") as handle:
                return json.load(handle) == stamp
        except (OSError, ValueError):
            return False

    def guard(self, run):
        """Refuse to replace results that the run would not have."""
        if not holds_results(run.folder):
            return
        if STAMP not in os.listdir(run.folder):
            raise PostError(f"{run.folder} is there and was not made by a sweep; choose "
                            "another --outdir")
        if not self.overwrite and not self.is_same(run, stamp_of(run, self.deck, self.version)):
            raise PostError(f"{run.folder} holds results of another deck, of other values or of another version of "
                            "the program; replace them with --overwrite, or choose another --outdir")

    def resumes(self, run, stamp):
        """Whether the folder holds a checkpoint of this very run."""
        return self.is_same(run, stamp) and any(re.fullmatch(re.escape(run.case) + r"_chk_\d+\.h5", name)
                            for name in os.listdir(run.folder))

    def one(self, run):
        """Run a combination, unless it is done."""
        stamp = stamp_of(run, self.deck, self.version)
        if is_done(run, stamp):
            run.kept, run.code = True, 0
            return run
        if self.stopping:
            return run
        restart = self.resumes(run, stamp)
        if not restart:
            self.guard(run)
            shutil.rmtree(run.folder, ignore_errors=True)
            os.makedirs(run.folder)
            with open(os.path.join(run.folder, STAMP), "w", encoding="utf-8") as handle:
                json.dump(stamp, handle, indent=1)
        environment = {**os.environ, "OMP_NUM_THREADS": str(self.threads)}
        with open(os.path.join(run.folder, SCREEN), "w+", encoding="utf-8") as screen:
            with subprocess.Popen(self.command(run, restart), stdout=screen,
                                  stderr=subprocess.STDOUT, env=environment,
                                  stdin=subprocess.DEVNULL, start_new_session=True) as child:
                self.children.add(child)
                run.code = child.wait()
                self.children.discard(child)
            screen.seek(0)
            said = screen.read()
        try:
            run.summary = read_summary(run)
        except (OSError, ValueError):
            run.summary = {}
        if run.code != 0:
            run.reason = ("stopped with a checkpoint; the same command goes on" if
                          run.code == STOPPED else reason_of(said, run.code))
        return run

    def stop(self):
        """Ask all children for a checkpoint and to leave."""
        self.stopping = True
        for child in list(self.children):
            child.send_signal(signal.SIGTERM)

    def all(self, runs, jobs, tell):
        """Run all combinations; `tell` is called with each that ends."""
        for run in runs:                                 # before the first one begins
            self.guard(run)
        with Progress(len(runs), "runs") as progress, ThreadPoolExecutor(jobs) as pool:
            waiting = [pool.submit(self.one, run) for run in runs]
            try:
                for future in as_completed(waiting):
                    run = future.result()
                    progress.clear()
                    tell(run)
                    progress.step()
            except BaseException:                        # an interrupt too: leave checkpoints
                self.stop()
                raise
