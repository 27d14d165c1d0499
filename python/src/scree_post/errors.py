# SPDX-License-Identifier: BSD-3-Clause
"""Errors that users see: one line on standard error and an exit code."""
import os
import sys

from scree.errors import (EXIT_DEFECT, EXIT_DIFFERENT, EXIT_FILE, EXIT_USAGE, ScreeError, modules,
                          readable, unknown)

PostError = ScreeError   # a one-line message for the user and the exit code that goes with it
__all__ = ["EXIT_DEFECT", "EXIT_DIFFERENT", "EXIT_FILE", "EXIT_USAGE", "PostError", "modules", "readable",
           "run", "unknown"]


def run(main, name):
    """Run a command's main; errors are one line on standard error and an exit code."""
    os.environ["MPLBACKEND"] = "Agg"                     # pictures go into files, with a display or without
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
