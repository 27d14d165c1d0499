# SPDX-License-Identifier: BSD-3-Clause
"""Errors: of files that are read, and of runs by the exit code of the program."""
from __future__ import annotations

import contextlib
import difflib
import importlib
import os
from collections.abc import Iterable, Iterator
from typing import Any

EXIT_DIFFERENT = 1       # a comparison or a study found a difference
EXIT_USAGE = 2           # error in the command line or the deck
EXIT_FILE = 3            # file missing, unreadable, or of another kind
EXIT_PHYSICS = 4         # the computation failed
EXIT_DEFECT = 5          # a result contradicts itself, or the program has a defect
EXIT_STOPPED = 75        # stopped with a checkpoint


class ScreeError(Exception):
    """A message for the user and the exit code that goes with it.

    `messages` are the lines that the program printed, if the error is that of a run, and `folder` is the folder of its
    results.
    """

    default = EXIT_FILE

    def __init__(self, message: str, code: int | None = None, messages: Iterable[str] = (),
                 folder: str = "") -> None:
        super().__init__(message)
        self.code = self.default if code is None else code
        self.messages = tuple(messages)
        self.folder = folder


class DeckError(ScreeError):
    """The deck or an option has an error; nothing was computed."""

    default = EXIT_USAGE


class FileProblem(ScreeError):
    """A file is missing, damaged or cannot be written, or results of an earlier run exist."""

    default = EXIT_FILE


class PhysicsError(ScreeError):
    """The computation failed: a particle left its bounds, or the time step fell below its limit."""

    default = EXIT_PHYSICS


class InternalError(ScreeError):
    """The program ended with an internal error; please report it."""

    default = EXIT_DEFECT


class Interrupted(ScreeError):
    """The run stopped with a checkpoint: call it again with restart=True."""

    default = EXIT_STOPPED


class StaleView(ScreeError):
    """A view of a field of a Simulation was used after a further step of the simulation."""

    default = EXIT_USAGE


BY_CODE: dict[int, type[ScreeError]] = {
    EXIT_USAGE: DeckError, EXIT_FILE: FileProblem, EXIT_PHYSICS: PhysicsError, EXIT_STOPPED: Interrupted}


def error_of_run(code: int, messages: Iterable[str], folder: str = "") -> ScreeError:
    """The error for an exit code of the program other than 0; its text is the output of the program."""
    lines = [line for line in messages if line.strip()]
    kind = BY_CODE.get(code, InternalError)
    text = "\n".join(lines) or f"scree ended with exit code {code} and printed no reason"
    if kind is Interrupted:
        text += "\nthe run stopped with a checkpoint: call scree.run again with the same arguments and restart=True"
    if kind is FileProblem and "--overwrite" in text:
        text += "\nin Python: overwrite=True, restart=True, or another outdir or case"
    if code < 0:
        text += f"\nscree was killed by signal {-code}"
    return kind(text, code, lines, folder)


def reason_of(said: str, code: int) -> str:
    """Reason for the failure of a run from the output of the program: its first error, or its last line."""
    lines = [line.strip() for line in said.splitlines() if line.strip()]
    errors = [line for line in lines if "error" in line.lower()]
    return (errors or lines[-1:] or [f"exit code {code}"])[0][:200]


# What the libraries raise while they read damaged files.
DAMAGE = (ArithmeticError, AssertionError, AttributeError, LookupError, MemoryError, OSError, RuntimeError,
          StopIteration, TypeError, ValueError)


@contextlib.contextmanager
def reading(path: object) -> Iterator[None]:
    """While a file is read, an error of a library means that the file is damaged; all errors name the file."""
    try:
        yield
    except BrokenPipeError:
        raise
    except ScreeError as error:
        if str(path) in str(error):
            raise
        raise type(error)(f"{path}: {error}", error.code) from error
    except DAMAGE as error:
        raise FileProblem(f"cannot read {path}: damaged or truncated") from error


def modules(*names: str) -> list[Any]:
    """Import the modules that a command needs, with a one-line message if one is not installed."""
    try:
        return [importlib.import_module(name) for name in names]
    except ImportError as error:
        raise ScreeError(
            f"Python package '{error.name}' is missing; scripts/setup.sh installs it in "
            "build/venv, then use build/venv/bin/scree-post"
        ) from error


def nearest(name: object, known: Iterable[object]) -> str:
    """A hint with the closest name and a list of all names."""
    words = [str(word) for word in known]
    near = difflib.get_close_matches(str(name), words, 1, 0.5)
    hint = f"; did you mean '{near[0]}'?" if near else ""
    return f"{hint} (there are: {', '.join(words) or 'none'})"


def unknown(kind: str, name: object, known: Iterable[object], where: str = "",
            code: int = EXIT_USAGE) -> ScreeError:
    """An error for an unknown name: the closest one, and all valid ones."""
    place = f"{where}: " if where else ""
    return ScreeError(f"{place}no {kind} '{name}'{nearest(name, known)}", code)


def decoded(text: bytes) -> str:
    """A text in UTF-8, or in Latin-1, in which all bytes are characters."""
    try:
        return text.decode("utf-8")
    except UnicodeDecodeError:
        return text.decode("latin-1")


def readable(path: str) -> str:
    """The path itself if it is a readable file."""
    if not os.path.exists(path):
        folder, name = os.path.split(path)
        folder = folder or "."
        near: list[str] = []
        if os.path.isdir(folder):
            near = difflib.get_close_matches(name, os.listdir(folder), 1, 0.7)
        raise FileProblem(f"no such file: {path}"
                          + (f"; did you mean {os.path.join(folder, near[0])}?" if near else ""))
    if os.path.isdir(path):
        raise FileProblem(f"{path} is a folder, not a file")
    if not os.access(path, os.R_OK):
        raise FileProblem(f"no permission to read {path}")
    return path
