# SPDX-License-Identifier: BSD-3-Clause
"""Errors that users see: one line on standard error and an exit code."""
import difflib
import importlib
import os
import sys

EXIT_DIFFERENT = 1       # a comparison or a study found something
EXIT_USAGE = 2           # command line wrong
EXIT_FILE = 3            # file missing, unreadable, or not what was wanted
EXIT_DEFECT = 5          # a result contradicts itself


class PostError(Exception):
    """A one-line message for the user and the exit code that goes with it."""

    def __init__(self, message, code=EXIT_FILE):
        super().__init__(message)
        self.code = code


def modules(*names):
    """Import what a command needs, with one clear line if it is not installed."""
    try:
        return [importlib.import_module(name) for name in names]
    except ImportError as error:
        raise PostError(
            f"Python package '{error.name}' is missing; scripts/setup.sh installs it in "
            "build/venv, then use build/venv/bin/scree-post"
        ) from error


def run(main, name):
    """Run a command's main; errors are one line on standard error and an exit code."""
    try:
        code = main()
        sys.stdout.flush()
    except PostError as error:
        print(f"{name}: {error}", file=sys.stderr)
        code = error.code
    except BrokenPipeError:                              # the reader of our output went away
        sys.stdout = open(os.devnull, "w", encoding="ascii")
        code = 0
    except KeyboardInterrupt:
        print(f"{name}: interrupted", file=sys.stderr)
        code = 130
    except MemoryError as error:
        print(f"{name}: not enough memory: {error}", file=sys.stderr)
        code = EXIT_FILE
    sys.exit(code or 0)


def unknown(kind, name, known, where="", code=EXIT_USAGE):
    """An error for a name that there is not: the nearest one, and all there are."""
    known = [str(word) for word in known]
    near = difflib.get_close_matches(str(name), known, 1, 0.5)
    hint = f"; did you mean '{near[0]}'?" if near else ""
    place = f"{where}: " if where else ""
    return PostError(f"{place}no {kind} '{name}'{hint} (there are: {', '.join(known) or 'none'})",
                     code)


def readable(path):
    """The path itself if it is a file that can be read."""
    if not os.path.exists(path):
        folder, name = os.path.split(path)
        folder = folder or "."
        near = []
        if os.path.isdir(folder):
            near = difflib.get_close_matches(name, os.listdir(folder), 1, 0.7)
        raise PostError(f"no such file: {path}"
                        + (f"; did you mean {os.path.join(folder, near[0])}?" if near else ""))
    if os.path.isdir(path):
        raise PostError(f"{path} is a folder, a file is wanted")
    if not os.access(path, os.R_OK):
        raise PostError(f"no permission to read {path}")
    return path
