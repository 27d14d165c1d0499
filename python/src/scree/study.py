# SPDX-License-Identifier: BSD-3-Clause
"""A deck run for many values of a key."""
from __future__ import annotations

import os
import re
import subprocess
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import TYPE_CHECKING, Any

from .errors import DeckError, FileProblem, ScreeError
from .launch import bar_is_seen, deck_value, is_text, progress_bar, stop
from .launch import run as run_deck
from .results import Run

if TYPE_CHECKING:
    import pandas

Measure = Callable[[Run], "float | Mapping[str, float]"]


def folder_name(key: str, value: Any) -> str:
    """A name for files from a key and its value, such as dx_0.5."""
    return re.sub(r"[^\w.+-]+", "_", f"{key.rpartition('.')[2]}_{deck_value(value)}").strip("_")


def sweep(deck: str | os.PathLike[str], key: str, values: Sequence[Any], measure: Measure, *, jobs: int = 1,
          outdir: str | os.PathLike[str] | None = None, set: Mapping[str, Any] | None = None, progress: bool = True,
          **options: Any) -> pandas.DataFrame:
    """Run a deck for each value of a key and measure each run.

    measure   gets a Run and returns a number, or a mapping of names and numbers
    jobs      runs at a time
    outdir    each run gets a folder in it, out/NAME_sweep by default
    set       further values of keys, the same for all runs
    options   those of scree.run, such as threads and overwrite

    The result has a row a value, in their order: the key, the measured numbers (a single one as `value`), the folder,
    and in `error` why a run failed, empty if it did not. The numbers of a run that failed are NaN. A wrong deck
    raises DeckError, results that are there already raise FileProblem unless overwrite is True.
    """
    import pandas
    name = "deck" if is_text(deck) else Path(deck).stem
    base = Path("out") / f"{name}_sweep" if outdir is None else Path(outdir)
    folders = [base / folder_name(key, value) for value in values]
    if len({*folders}) < len(folders):
        raise ValueError(f"{key}: two of the values are equal, or differ only in letters that names of files lack")
    if jobs < 1:
        raise ValueError("jobs must be at least 1")

    children: list[subprocess.Popen[str]] = []

    def one(value: Any, folder: Path) -> dict[str, Any]:
        row: dict[str, Any] = {key: value, "folder": str(folder), "error": ""}
        try:
            result = run_deck(deck, {**(set or {}), key: value}, outdir=folder, progress=False, _children=children,
                              **options)
        except (DeckError, FileProblem):
            raise
        except ScreeError as error:
            return {**row, "error": str(error)}
        found = measure(result)
        return {**row, **(found if isinstance(found, Mapping) else {"value": float(found)})}

    rows = []
    with ThreadPoolExecutor(jobs) as pool:
        waiting = [pool.submit(one, value, folder) for value, folder in zip(values, folders)]
        try:
            for future in progress_bar(waiting, desc=key, disable=not (progress and bar_is_seen())):
                rows.append(future.result())
        except BaseException:
            pool.shutdown(wait=False, cancel_futures=True)
            for child in children:
                stop(child)
            raise
    table = pandas.DataFrame(rows)
    last = ["folder", "error"]
    ordered: pandas.DataFrame = table.reindex(columns=[name for name in table.columns if name not in last] + last)
    return ordered
