# SPDX-License-Identifier: BSD-3-Clause
"""The echo of a deck: all keys and their values in SI. Only the program reads decks; this module reads its echo, which
every file of a run contains and `scree --echo` prints."""
from __future__ import annotations

import contextlib
import functools
import io
from typing import Any

from .errors import DAMAGE, FileProblem


def namelist(echo: str) -> Any:
    """An echo as a namelist of f90nml, which prints its tables where a letter of a damaged text surprises it."""
    import f90nml
    with contextlib.redirect_stdout(io.StringIO()), contextlib.redirect_stderr(io.StringIO()):
        return f90nml.reads(echo)


@functools.lru_cache(maxsize=8)
def _read(echo: str) -> Any:
    try:
        return namelist(echo)
    except DAMAGE as error:
        raise FileProblem(f"the deck stored in a file cannot be read: {error}") from error


def groups(echo: str, name: str) -> list[dict[str, Any]]:
    """The keys of all groups with a name."""
    found = _read(echo).get(name, [])
    return [dict(group) for group in (found if isinstance(found, list) else [found])]
