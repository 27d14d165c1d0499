# SPDX-License-Identifier: BSD-3-Clause
"""Studies: a deck is run for all combinations of values of keys, each in a separate folder; studies can be
continued."""
from __future__ import annotations

import contextlib
import hashlib
import itertools
import json
import os
import re
import shutil
import subprocess
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor, as_completed
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, Union

from .errors import EXIT_STOPPED, EXIT_USAGE, DeckError, FileProblem, PhysicsError, ScreeError, reason_of
from .launch import Count, deck_value, echo_of, is_text, stop
from .launch import run as run_deck
from .program import find_program, version_of
from .quantities import check_quantities, value_of
from .results import Run, open_run

if TYPE_CHECKING:
    import pandas

Measure = Callable[[Run], Union[float, Mapping[str, float]]]
Ended = Callable[["Combination"], None]
STAMP = "sweep.json"     # file in the folder of a run that describes the run
SCREEN = "screen.txt"    # file that earlier versions wrote beside it


@dataclass
class Combination:
    """One combination of values and the result of its run."""

    settings: dict[str, Any]                             # value of each key
    folder: str
    case: str | None = None                              # None: as in the deck
    code: int | None = None                              # exit code; None if it was not run
    reason: str = ""                                     # reason of a failure
    kept: bool = False                                   # finished by an earlier call
    result: Run | None = None
    error: ScreeError | None = None

    @property
    def summary(self) -> dict[str, Any]:
        """Content of the summary of the run, empty without one."""
        return self.result.summary if self.result is not None else {}


def short(key: str) -> str:
    """The part of a key that is used in names of folders and columns."""
    return key.rpartition(".")[2]


def folder_name(values: Mapping[str, Any]) -> str:
    """A name for files from keys and values, such as dx_0.5 or mu_s_0.3_dx_0.1."""
    clash = len({short(key) for key in values}) < len(values)
    words = [f"{key if clash else short(key)}_{deck_value(value)}" for key, value in values.items()]
    return re.sub(r"[^\w.+-]+", "_", "_".join(words)).strip("_")


def combinations(keys: Mapping[str, Sequence[Any]], base: str | os.PathLike[str], case: str | None = None
                 ) -> list[Combination]:
    """All combinations of the values of keys, with folders in `base`; names of files begin with CASE and the values."""
    found = []
    for chosen in itertools.product(*keys.values()):
        values = dict(zip(keys, chosen))
        name = folder_name(values)
        found.append(Combination(values, os.path.join(base, name), f"{case}_{name}" if case else None))
    folders = [one.folder for one in found]
    for folder in folders:
        if folders.count(folder) > 1:
            raise DeckError(f"two combinations of values would share the folder {folder}", EXIT_USAGE)
    return found


def read_stamp(folder: str | os.PathLike[str]) -> dict[str, Any]:
    """Description of the run in a folder, or None if no study wrote it."""
    try:
        stamp = json.loads(Path(folder, STAMP).read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return {}
    return stamp if isinstance(stamp, dict) and isinstance(stamp.get("values"), dict) else {}


def holds_results(folder: str) -> bool:
    """True if a folder of a run contains more than its description."""
    return os.path.isdir(folder) and bool({*os.listdir(folder)} - {STAMP, SCREEN})


class Study:
    """Runs combinations of values, several at a time.

    With `resume` finished runs of the same deck, values and program are kept, and stopped ones are continued from
    their checkpoints; other results of a study are replaced only with `overwrite`. Without `resume` every combination
    is run, and results that are there are refused unless `overwrite` is true. `settings` are values of further keys,
    the same for all runs, and `options` those of scree.run.
    """

    def __init__(self, deck: str | os.PathLike[str], *, program: str | os.PathLike[str] | None = None,
                 overwrite: bool = False, resume: bool = True, settings: Mapping[str, Any] | None = None,
                 **options: Any) -> None:
        self.program = find_program(program)
        self.deck = str(deck) if is_text(deck) else os.path.abspath(deck)
        self.overwrite, self.resume, self.common, self.options = overwrite, resume, dict(settings or {}), options
        self.version = version_of(self.program)
        self._stopping = False
        self._children: list[subprocess.Popen[str]] = []
        self._echoes: dict[str, str] = {}                # digest of the deck by the values

    def stamp(self, one: Combination) -> dict[str, Any]:
        """Description of a run, by which a finished run is recognised."""
        values = {key: deck_value(value) for key, value in {**self.common, **one.settings}.items()}
        key = json.dumps(values)
        if key not in self._echoes:
            content = self.deck.encode() if is_text(self.deck) else Path(self.deck).read_bytes()
            if not is_text(self.deck):                   # the echo contains included files; an error is that of the run
                with contextlib.suppress(DeckError):
                    content = echo_of(self.program, self.deck, {**self.common, **one.settings}).encode()
            self._echoes[key] = hashlib.sha256(content).hexdigest()
        return {"deck": self._echoes[key], "values": values, "program": self.version}

    def is_done(self, one: Combination) -> bool:
        """True if an earlier call finished this run with the same deck, values and program; its results are then
        loaded."""
        if read_stamp(one.folder) != self.stamp(one):
            return False
        try:
            found = Run(one.folder, one.case) if one.case else open_run(one.folder)
            if found.exit_code != 0:
                return False
        except (ScreeError, KeyError):
            return False
        one.result = found
        return True

    def guard(self, one: Combination) -> None:
        """Refuse to replace results that this study did not make."""
        if not holds_results(one.folder):
            return
        if STAMP not in os.listdir(one.folder):
            raise FileProblem(f"{one.folder} is there and was not made by a sweep; choose another --outdir")
        if not self.overwrite and read_stamp(one.folder) != self.stamp(one):
            raise FileProblem(f"{one.folder} holds results of another deck, of other values or of another version of "
                              "the program; replace them with --overwrite (in Python overwrite=True), or choose "
                              "another --outdir")

    def _restarts(self, one: Combination) -> bool:
        """True if the folder contains a checkpoint of this run."""
        case = re.escape(one.case) if one.case else r".+"
        return read_stamp(one.folder) == self.stamp(one) and any(
            re.fullmatch(case + r"_chk_\d+\.h5", name) for name in os.listdir(one.folder))

    def _mark(self, one: Combination) -> None:
        """Write the description of the run to its folder."""
        Path(one.folder, STAMP).write_text(json.dumps(self.stamp(one), indent=1), encoding="utf-8")

    def _clear(self, one: Combination) -> bool:
        """Prepare the folder for the run; the result is whether the run continues from a checkpoint."""
        if not self.resume:
            if self.overwrite:                           # a failed run must not keep the description of an earlier one
                Path(one.folder, STAMP).unlink(missing_ok=True)
            return False
        if self._restarts(one):
            return True
        self.guard(one)
        shutil.rmtree(one.folder, ignore_errors=True)
        os.makedirs(one.folder)
        self._mark(one)
        return False

    def one(self, one: Combination) -> Combination:
        """Run a combination, unless an earlier call has finished it."""
        if self.resume and self.is_done(one):
            one.kept, one.code = True, 0
            return one
        if self._stopping:
            return one
        restart = self._clear(one)
        try:
            one.result = run_deck(self.deck, {**self.common, **one.settings}, outdir=one.folder, case=one.case,
                                  progress=False, program=self.program, restart=restart,
                                  overwrite=self.overwrite and not self.resume, _children=self._children,
                                  **self.options)
            one.code = 0
        except ScreeError as error:
            one.code, one.error = error.code, error
            one.reason = ("stopped with a checkpoint; the same command goes on" if error.code == EXIT_STOPPED
                          else reason_of("\n".join(error.messages) or str(error), error.code))
        if not self.resume and one.code in (0, EXIT_STOPPED):
            self._mark(one)
        return one

    def check_quantities(self, runs: Sequence[Combination], names: Sequence[str]) -> None:
        """Raise an error for names of quantities that the first run would not have, before it starts."""
        if runs and names:
            with contextlib.suppress(DeckError, PhysicsError, FileProblem):      # each run reports its own
                check_quantities(self.deck, names, {**self.common, **runs[0].settings},
                                 os.path.dirname(runs[0].folder), program=self.program, **self.options)

    def stop(self) -> None:
        """Stop all runs with a checkpoint."""
        self._stopping = True
        for child in list(self._children):
            stop(child)

    def all(self, runs: Sequence[Combination], jobs: int, ended: Ended, *, label: str = "runs", progress: bool = True,
            leave: bool = False, lines: bool = True) -> None:
        """Run all combinations, `jobs` at a time; `ended` is called with each finished one."""
        if self.resume:
            for one in runs:                             # before the first run starts
                self.guard(one)
        with Count(len(runs), label, progress, leave, lines) as bar, ThreadPoolExecutor(jobs) as pool:
            waiting = [pool.submit(self.one, one) for one in runs]
            try:
                for future in as_completed(waiting):
                    one = future.result()
                    bar.clear()
                    ended(one)
                    bar.update()
            except BaseException:                        # also after an interrupt: runs write checkpoints
                pool.shutdown(wait=False, cancel_futures=True)
                self.stop()
                raise


def sweep(deck: str | os.PathLike[str], key: str | Mapping[str, Sequence[Any]],
          values: Sequence[Any] | None = None, measure: Measure | str | Sequence[str] | None = None, *, jobs: int = 1,
          outdir: str | os.PathLike[str] | None = None, set: Mapping[str, Any] | None = None, progress: bool = True,
          resume: bool = False, overwrite: bool = False, **options: Any) -> pandas.DataFrame:
    """Run a deck for each value of a key, or for all combinations of values of several keys, and measure each run.

    key, values  a key and its values; or a mapping of keys to their values, and no values
    measure      gets a Run and returns a number, or a mapping of names and numbers; or names of quantities as for
                 scree.accuracy ("gauge.velocity_x:max"), which are checked before the first run; without it nothing is
                 measured
    jobs         runs at a time
    outdir       each run gets a folder in it, out/NAME_sweep by default
    set          further values of keys, the same for all runs
    resume       keep the finished runs of an earlier call with the same deck, values and program, and continue those
                 that were stopped
    overwrite    replace other results in the folders of the runs
    options      those of scree.run, such as threads and program

    The result has a row per run, in the order of the values: the keys, the measured numbers (a single one as `value`),
    the folder, and in `error` the reason of a failure, empty without one. The numbers of a failed run are NaN. An error
    in the deck raises DeckError; existing results raise FileProblem unless resume or overwrite is True.
    """
    import pandas
    if isinstance(key, str) == (values is None):
        raise ValueError("give a key and its values, or a mapping of keys to their values")
    keys: dict[str, Sequence[Any]] = {key: values or ()} if isinstance(key, str) else dict(key)
    name = "deck" if is_text(deck) else Path(deck).stem
    base = Path("out") / f"{name}_sweep" if outdir is None else Path(outdir)
    if jobs < 1:
        raise ValueError("jobs must be at least 1")
    try:
        runs = combinations(keys, base)
    except DeckError as error:
        raise ValueError(f"{', '.join(keys)}: two of the values are equal, or differ only in letters that names of "
                         "files lack") from error
    measured: dict[str, Mapping[str, float]] = {}

    def ended(one: Combination) -> None:
        if isinstance(one.error, (DeckError, FileProblem)):
            raise one.error
        if one.result is not None and names:
            measured[one.folder] = {name: value_of(one.result, name) for name in names}
        elif one.result is not None and callable(measure):
            found = measure(one.result)
            measured[one.folder] = found if isinstance(found, Mapping) else {"value": float(found)}

    names = [] if measure is None or callable(measure) else [measure] if isinstance(measure, str) else list(measure)
    study = Study(deck, overwrite=overwrite, resume=resume, settings=set, **options)
    study.check_quantities(runs, names)
    study.all(runs, jobs, ended, label=", ".join(keys), progress=progress, leave=True)
    table = pandas.DataFrame([{**one.settings, "folder": one.folder, "error": str(one.error or ""),
                               **measured.get(one.folder, {})} for one in runs])
    last = ["folder", "error"]
    ordered: pandas.DataFrame = table.reindex(columns=[name for name in table.columns if name not in last] + last)
    return ordered
