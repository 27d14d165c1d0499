# SPDX-License-Identifier: BSD-3-Clause
"""Errors for users: one line on standard error and an exit code."""
from __future__ import annotations

import os
import sys
from collections.abc import Callable

from scree.errors import EXIT_FILE, ScreeError


def run(main: Callable[[], int | None], name: str) -> None:
    """Run a command's main; errors are one line on standard error and an exit code."""
    os.environ["MPLBACKEND"] = "Agg"                     # pictures are written to files, with a display or without
    code: int | None
    try:
        code = main()
        sys.stdout.flush()
    except ScreeError as error:
        print(f"{name}: {error}", file=sys.stderr)
        code = error.code
    except BrokenPipeError:                              # the reader of the output has closed it
        sys.stdout = open(os.devnull, "w", encoding="ascii")  # noqa: SIM115
        code = 0
    except KeyboardInterrupt:
        print(f"{name}: interrupted", file=sys.stderr)
        code = 130
    except MemoryError as error:
        print(f"{name}: not enough memory: {error}", file=sys.stderr)
        code = EXIT_FILE
    sys.exit(code or 0)
