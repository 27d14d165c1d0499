# SPDX-License-Identifier: BSD-3-Clause
"""Runs of cases. Two programs run alternately, and the speed of copying memory is measured before and after each
run."""
import hashlib
import json
import shlex
import shutil
import subprocess
import time
from dataclasses import dataclass, field
from pathlib import Path

from scree.errors import EXIT_USAGE, ScreeError
from scree_post.progress import Progress
from scree.errors import reason_of

from . import machine, result

CASE = "case"                            # prefix of the files of every run
SCREEN = "screen.txt"                    # file in the folder of a run with the output of the program


@dataclass
class Bench:
    """Settings of the measurement: programs (one, or two that alternate), folder for scratch files, and so on."""

    programs: list
    copy: str                            # program that copies memory
    work: Path
    size: str = "small"
    mpiexec: tuple = ("mpiexec",)
    copy_megabytes: int = machine.COPY_MEGABYTES
    decks: dict = field(default_factory=dict)            # decks that exist already, by case

    def prepare(self, case):
        """Write the deck of a case, or let the first program copy its example. Returns the path of the deck."""
        if case.name in self.decks:
            return self.decks[case.name]
        folder = self.work / case.name
        shutil.rmtree(folder, ignore_errors=True)
        if case.example:
            answer = subprocess.run([self.programs[0].path, "--new", case.example, str(folder)], text=True,
                                    capture_output=True)
            found = sorted(folder.glob("*.nml")) if folder.is_dir() else []
            if answer.returncode or not found:
                raise ScreeError(f"{case.name}: scree --new {case.example} failed: "
                                f"{reason_of(answer.stdout + answer.stderr, answer.returncode)}")
            deck = found[0]
        else:
            folder.mkdir(parents=True)
            deck = folder / f"{case.name}.nml"
            deck.write_text(case.deck(self.size), encoding="utf-8")
            for name, text in case.companions(self.size).items():
                (folder / name).write_text(text, encoding="utf-8")
        self.decks[case.name] = deck
        return deck

    def digest(self, case):
        """Digest of a deck and its settings. Only results with equal digests are compared."""
        text = self.prepare(case).read_text(encoding="utf-8") + " ".join(case.overrides(self.size))
        return hashlib.sha256(text.encode()).hexdigest()[:16]

    def command(self, run, program):
        """The command of a run as a list of words."""
        words = [program.path, "--quiet", "--overwrite", "--case", CASE, "--outdir", str(self.folder(run))]
        for setting in run.case.overrides(self.size):
            words += ["--set", setting]
        words.append(str(self.prepare(run.case)))
        return [*self.mpiexec, "-n", str(run.ranks), *words] if run.ranks > 1 else words

    def folder(self, run):
        """The folder of a run; it replaces that of the previous run."""
        return self.work / run.case.name / "out"

    def once(self, run, program):
        """Make one run of a program. Returns values of its summary, or a message with the cause of a failure."""
        folder = self.folder(run)
        shutil.rmtree(folder, ignore_errors=True)
        folder.mkdir(parents=True)
        begin = time.monotonic()
        try:
            with open(folder / SCREEN, "w+", encoding="utf-8", errors="replace") as screen:
                code = subprocess.run(self.command(run, program), env=machine.environment(run.threads), check=False,
                                      stdin=subprocess.DEVNULL, stdout=screen, stderr=subprocess.STDOUT).returncode
                screen.seek(0)
                said = screen.read()
            if code:
                return {"failed": f"exit code {code}: {reason_of(said, code)}"}
            summary = json.loads((folder / f"{CASE}.summary.json").read_text(encoding="utf-8"))
            return {"seconds": round(time.monotonic() - begin, 3), **result.taken(summary)}
        except (OSError, ValueError, KeyError) as error:
            return {"failed": f"{type(error).__name__}: {error}"}


def skipped(run, mpiexec):
    """The reason why a run is not possible on this machine; empty if it is."""
    if run.cores > machine.cores():
        return f"needs {run.cores} cores, this machine gives {machine.cores()}"
    if run.ranks > 1 and not machine.has(mpiexec[0]):
        return f"needs {mpiexec[0]}, which is not in the path; name another one with --mpiexec"
    return ""


def mpiexec_words(text):
    """The command that starts ranks, as a list of words."""
    try:
        words = tuple(shlex.split(text))
    except ValueError:
        words = ()
    if not words:
        raise ScreeError(f"--mpiexec '{text}' names no command; write --mpiexec mpiexec, or 'srun --exclusive'",
                        EXIT_USAGE)
    return words


def measure(bench, runs, repeats, save):
    """The results of all runs. `save` is called with them after each repeat, so that results are kept after an
    interrupt."""
    results = [result.started(run, bench.digest(run.case), skipped(run, bench.mpiexec), len(bench.programs))
               for run in runs]
    todo = [entry for entry in zip(runs, results) if not entry[1]["skipped"]]
    with Progress(len(todo) * repeats * len(bench.programs), "runs") as progress:
        for repeat in range(repeats):
            copies = Copies(bench)
            for run, entry in todo:
                progress.what = run.key
                around(bench, run, entry, repeat, copies)
                progress.step(len(bench.programs))
            for entry in results:
                result.finish(entry)
            save(results)
    return results


class Copies:
    """Measurements of the copy speed. The measurement after a run also serves as the one before the next run on the
    same number of cores."""

    def __init__(self, bench):
        self.bench, self.last = bench, {}

    def before(self, cores):
        """The copy speed before a run."""
        return self.last.get(cores) or self.after(cores)

    def after(self, cores):
        """The copy speed after a run."""
        found = machine.measure_copy(self.bench.copy, cores, self.bench.copy_megabytes)
        self.last = {cores: found}
        return found


def around(bench, run, entry, repeat, copies):
    """One run of each program, with the copy speed before, between and after them. The order of two programs alternates
    between repeats."""
    order = list(range(len(bench.programs)))
    for number in order if repeat % 2 == 0 else order[::-1]:
        before = copies.before(run.cores)
        raw = bench.once(run, bench.programs[number])
        entry["programs"][number]["runs"].append({"repeat": repeat + 1, **raw, "copy_before": before,
                                                  "copy_after": copies.after(run.cores)})
