# SPDX-License-Identifier: BSD-3-Clause
"""Runs the program: options, progress, and errors by its exit code."""
from __future__ import annotations

import importlib.util
import os
import re
import shutil
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import IO, Any

from .errors import DeckError, FileProblem, decoded, error_of_run, readable
from .program import find_program
from .results import Run

# Open MPI refuses to run as root and with more ranks than cores unless this is allowed, and would bind all threads of a
# rank to one core.
OPEN_MPI = {
    "OMPI_ALLOW_RUN_AS_ROOT": "1",
    "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM": "1",
    "OMPI_MCA_rmaps_base_oversubscribe": "1",
    "OMPI_MCA_hwloc_base_binding_policy": "none",
    "OMPI_MCA_btl_vader_single_copy_mechanism": "none",
    "PRTE_MCA_rmaps_default_mapping_policy": ":oversubscribe",
    "PRTE_MCA_hwloc_default_binding_policy": "none",
}
HEAD = re.compile(r"^deck .*\bcase (.+?)  \d+ ranks x \d+ threads  results (.+)$")
END = "ended "
SHARE = re.compile(r"^ *[\d:d]+ +(\d+\.\d) % +(\d+) ")   # a line of progress: wall time, t/t_end, step


def deck_value(value: Any) -> str:
    """The text of a value in a deck: numbers, words, .true. and .false., and lists with commas."""
    if hasattr(value, "tolist"):                         # a scalar or array of numpy
        value = value.tolist()
    if isinstance(value, bool):
        return ".true." if value else ".false."
    if isinstance(value, (list, tuple)):
        return ",".join(deck_value(part) for part in value)
    return repr(value) if isinstance(value, float) else str(value)


def is_text(deck: str | os.PathLike[str]) -> bool:
    """True if a deck is given as its text."""
    return isinstance(deck, str) and "\n" in deck and "&" in deck


def deck_file(deck: str | os.PathLike[str], outdir: str | os.PathLike[str] | None, overwrite: bool) -> Path:
    """The file of a deck; a deck that is given as text is written to OUTDIR/deck.nml, where another file is an error
    unless `overwrite` is true."""
    if not is_text(deck):
        return Path(deck)
    if outdir is None:
        raise ValueError("a deck that is given as text needs outdir")
    path = Path(outdir) / "deck.nml"
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        if path.exists() and not overwrite and decoded(path.read_bytes()) != deck:
            raise FileProblem(f"{path} holds another deck: replace it by overwrite=True, or choose another outdir")
        path.write_text(str(deck), encoding="utf-8")
    except OSError as error:
        raise FileProblem(f"cannot write {path}: {error.strerror}") from error
    return path


def bar_is_seen() -> bool:
    """True if a bar is visible: on a terminal and in a notebook."""
    return "ipykernel" in sys.modules or sys.stderr.isatty()


def progress_bar(*arguments: Any, **options: Any) -> Any:
    """A bar of tqdm: widgets in a notebook where they are installed, otherwise characters."""
    widgets = "ipykernel" in sys.modules and importlib.util.find_spec("ipywidgets")
    return importlib.import_module("tqdm.notebook" if widgets else "tqdm").tqdm(*arguments, **options)


class Count:
    """Progress of a study: a bar on a terminal and in a notebook, otherwise a line on standard error for each run, so
    that a file of the output shows it as well."""

    def __init__(self, total: int, label: str, shown: bool = True, leave: bool = False, lines: bool = True) -> None:
        self._done, self._total, self._label, self._begin = 0, total, label, time.monotonic()
        self._bar: Any = progress_bar(total=total, desc=label, leave=leave) if shown and bar_is_seen() else None
        self._lines = lines and shown and self._bar is None

    def __enter__(self) -> Count:
        return self

    def __exit__(self, *_: object) -> None:
        if self._bar is not None:
            self._bar.close()

    def clear(self) -> None:
        """Remove the bar, so that following output is not mixed with it."""
        if self._bar is not None:
            self._bar.clear()

    def update(self) -> None:
        """A further run has ended."""
        self._done += 1
        if self._bar is not None:
            self._bar.update()
        if self._lines:
            print(f"{self._label}: {self._done} of {self._total} runs, {time.monotonic() - self._begin:.0f} s",
                  file=sys.stderr, flush=True)


class Progress:
    """A bar of tqdm that follows the output of the program."""

    def __init__(self, shown: bool, label: str) -> None:
        self._bar: Any = None
        if shown and bar_is_seen():
            self._bar = progress_bar(total=100.0, desc=label, bar_format="{desc} {percentage:3.0f} % |{bar}| {elapsed}"
                                     " < {remaining}{postfix}")

    def line(self, text: str) -> None:
        """A line of the program."""
        found = SHARE.match(text)
        if self._bar is not None and found:
            self._bar.set_postfix_str(f"step {found.group(2)}", refresh=False)
            self._bar.update(float(found.group(1)) - self._bar.n)

    def end(self, done: bool) -> None:
        """The program has ended."""
        if self._bar is not None:
            if done:
                self._bar.update(self._bar.total - self._bar.n)
            self._bar.close()


def stop(child: subprocess.Popen[str]) -> None:
    """Let a run write a checkpoint and end."""
    if child.poll() is None:
        child.send_signal(signal.SIGUSR1)                # mpiexec forwards this signal, unlike SIGTERM


def collect(stream: IO[str], lines: list[str]) -> None:
    """Read a stream to its end."""
    lines += [line.rstrip("\n") for line in stream]


def without_mpiexec(messages: list[str]) -> list[str]:
    """The messages without the blocks in which mpiexec of Open MPI repeats the exit code."""
    rule = re.compile(r"-{60,}$")
    kept: list[str] = []
    block: list[str] | None = None
    for line in messages:
        if not rule.match(line):
            (kept if block is None else block).append(line)
        elif block is None:
            block = []
        else:
            kept += [] if re.search(r"\bPrimary job\b|\bmpi(exec|run) detected\b", "\n".join(block)) else block
            block = None
    return kept + (block or [])


def communicate(words: list[str], environment: dict[str, str], progress: Progress,
                children: list[subprocess.Popen[str]]) -> tuple[int, list[str], list[str]]:
    """Exit code, lines and messages of the program. After an interrupt the program writes a checkpoint before the
    interrupt is raised."""
    try:
        child = subprocess.Popen(words, env=environment, text=True, encoding="utf-8", errors="replace",
                                 stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.PIPE,
                                 start_new_session=True)
    except OSError as error:
        raise FileProblem(f"cannot start {words[0]}: {error.strerror}") from error
    said: list[str] = []
    messages: list[str] = []
    children.append(child)
    with child:
        assert child.stdout is not None and child.stderr is not None
        reader = threading.Thread(target=collect, args=(child.stderr, messages), daemon=True)
        reader.start()
        try:
            for line in child.stdout:
                said.append(line.rstrip("\n"))
                progress.line(line)
        except BaseException:
            stop(child)
            for line in child.stdout:
                said.append(line.rstrip("\n"))
            raise
        finally:
            child.wait()
            reader.join()
    return child.returncode, said, messages


def options_of(settings: Mapping[str, Any], case: str | None, outdir: str | os.PathLike[str] | None) -> list[str]:
    """Options of the program for settings and names."""
    words = [word for key, value in settings.items() for word in ("--set", f"{key}={deck_value(value)}")]
    words += ["--case", case] if case else []
    return words + (["--outdir", os.fspath(outdir)] if outdir is not None else [])


def echo_of(program: str, deck: str | os.PathLike[str], settings: Mapping[str, Any]) -> str:
    """The echo of a deck with settings. Raises the errors that `scree --check` reports."""
    words = [program, "--echo", *options_of(settings, None, None), "--", readable(os.fspath(deck))]
    try:
        answer = subprocess.run(words, capture_output=True, check=False)
    except OSError as error:
        raise FileProblem(f"cannot start {program}: {error.strerror}") from error
    said, problems = map(decoded, (answer.stdout, answer.stderr))
    if answer.returncode:
        raise error_of_run(answer.returncode, ["the deck is not accepted:",
                                               *(said + problems).strip().splitlines()[-40:]])
    return said


def run(deck: str | os.PathLike[str], set: Mapping[str, Any] | None = None, *, ranks: int = 1, threads: int = 1,
        outdir: str | os.PathLike[str] | None = None, case: str | None = None, progress: bool = True,
        restart: bool = False, overwrite: bool = False, program: str | os.PathLike[str] | None = None,
        options: Iterable[str] = (), _children: list[subprocess.Popen[str]] | None = None) -> Run:
    """Run a deck and return its results.

    deck       a file, or the text of a deck, which is written to OUTDIR/deck.nml
    set        values of keys, such as {"grid.dx": 0.5, "body[ball].velocity": (0, 0, 1)}
    ranks      MPI ranks, started with mpiexec if there are several
    threads    threads of each rank
    outdir     folder of the results, out/CASE by default
    case       prefix of the files, by default as the deck says
    progress   show a bar on a terminal and in a notebook
    restart    continue from the newest checkpoint
    overwrite  remove the results of an earlier run of this case
    program    by default SCREE of the environment, build/bin/scree beside this package, or scree in PATH
    options    further options of the program

    Raises DeckError, FileProblem, PhysicsError, InternalError or Interrupted, with the messages of the program as text
    and in `messages`. Interrupted means that a checkpoint was written: call again with restart=True. An interrupt of
    the keyboard also lets the program write a checkpoint.
    """
    if ranks < 1 or threads < 1:
        raise ValueError("ranks and threads must be at least 1")
    words = [find_program(program), *options_of(set or {}, case, outdir), *options]
    words += (["--restart"] if restart else []) + (["--overwrite"] if overwrite else [])
    file = deck_file(deck, outdir, overwrite)
    words.append(os.fspath(file))
    if ranks > 1:
        mpiexec = shutil.which("mpiexec")
        if not mpiexec:
            raise FileProblem("mpiexec, which starts several ranks, was not found in PATH")
        words = [mpiexec, "-n", str(ranks), *words]
    bar = Progress(progress, case or file.stem)
    code: int | None = None
    try:
        code, said, messages = communicate(words, {**os.environ, **OPEN_MPI, "OMP_NUM_THREADS": str(threads)}, bar,
                                           [] if _children is None else _children)
    finally:
        bar.end(code == 0)
    place = next((found for found in map(HEAD.match, said) if found), None)
    if code != 0:
        reasons = without_mpiexec(messages) or [line[len(END):].strip() for line in said if line.startswith(END)]
        raise error_of_run(code, reasons, place.group(2) if place else "")
    if place is None:
        raise DeckError("the program ended without a run; its options leave nothing to compute:\n" + "\n".join(said))
    return Run(place.group(2), place.group(1))
