# SPDX-License-Identifier: BSD-3-Clause
"""The echo of a deck: all keys and their values in SI. Only the program reads decks; this module reads its echo, which
every file of a run contains and `scree --echo` prints."""
from __future__ import annotations

import functools
from typing import Any

from .errors import DAMAGE, FileProblem


@functools.lru_cache(maxsize=8)
def _read(echo: str) -> Any:
    import f90nml
    try:
        return f90nml.reads(echo)
    except DAMAGE as error:
        raise FileProblem(f"the deck stored in a file cannot be read: {error}") from error


def groups(echo: str, name: str) -> list[dict[str, Any]]:
    """The keys of all groups with a name."""
    found = _read(echo).get(name, [])
    return [dict(group) for group in (found if isinstance(found, list) else [found])]
