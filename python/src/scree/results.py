# SPDX-License-Identifier: BSD-3-Clause
"""Results of a run: deck, summary, tables and snapshots."""
from __future__ import annotations

import json
import os
from collections.abc import Iterator, Mapping
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

from . import echo, files
from .errors import FileProblem, decoded, nearest, readable, reading
from .snapshot import Snapshots

if TYPE_CHECKING:
    import pandas

SERIES = ".hdf.series"
# Endings that identify the name of a case, the most specific first.
MARKS = (".summary.json", ".echo.nml", "_history.csv", f"_p{SERIES}")


def read_table(path: str | os.PathLike[str]) -> pandas.DataFrame:
    """A table of a run, such as CASE_history.csv, in SI.

    Columns are named without units; `attrs["units"]` holds the unit of each.
    """
    import pandas
    table = files.history(str(path), may_be_empty=True)
    frame = pandas.DataFrame({name: table[name] for name in table.order})
    frame.attrs["units"] = dict(table.units)
    return frame


class Tables(Mapping[str, "pandas.DataFrame"]):
    """The tables CASE_NAME.csv of a run by NAME, such as history, gauge and forces; read at first use."""

    def __init__(self, folder: Path, case: str) -> None:
        self._folder, self._case = folder, case
        self._read: dict[str, pandas.DataFrame] = {}

    def _names(self) -> list[str]:
        first = f"{self._case}_"
        return sorted(path.stem[len(first):] for path in self._folder.glob("*.csv") if path.stem.startswith(first))

    def __repr__(self) -> str:
        return f"<scree.Tables: {', '.join(self._names()) or 'none'}>"

    def __getitem__(self, name: str) -> pandas.DataFrame:
        if name not in self._read:
            if name not in self._names():
                raise KeyError(f"{self._folder} has no table '{name}'{nearest(name, self._names())}")
            self._read[name] = read_table(self._folder / f"{self._case}_{name}.csv")
        return self._read[name]

    def __contains__(self, name: object) -> bool:
        return name in self._names()

    def __iter__(self) -> Iterator[str]:
        return iter(self._names())

    def __len__(self) -> int:
        return len(self._names())


class Run:
    """Results of a run.

        run.deck["grid"]["dx"]              # the deck as used, in SI
        run.summary["steps"]                # the end of the run
        run.history["kinetic"]              # pandas; units in run.history.attrs["units"]
        run.tables["gauge"]                 # further tables
        run.snapshots[-1]["velocity"]       # particles; run.snapshots.near(2e-6), run.series["tip_p"]
    """

    def __init__(self, folder: str | os.PathLike[str], case: str, stream: str = "") -> None:
        # absolute, so that they remain valid after a change of the working folder
        self.folder, self.case = Path(folder).absolute(), case
        self.tables = Tables(self.folder, case)
        self._stream = stream

    def __repr__(self) -> str:
        return f"<scree.Run {self.case} in {self.folder}>"

    def path(self, ending: str) -> Path:
        """A file of the run, such as path("_walls.hdf")."""
        return self.folder / f"{self.case}{ending}"

    @cached_property
    def deck(self) -> Any:
        """The deck with all keys and their values, in SI, as a namelist of f90nml. Repeated groups are lists."""
        path = self.path(".echo.nml")
        with reading(path):
            return echo.namelist(text_of(path))

    @cached_property
    def summary(self) -> dict[str, Any]:
        """Content of CASE.summary.json."""
        path = self.path(".summary.json")
        try:
            found = json.loads(text_of(path))
        except (RecursionError, ValueError) as error:
            raise FileProblem(f"cannot read {path}: {error}") from error
        if not isinstance(found, dict):
            raise FileProblem(f"{path} is not a summary")
        return found

    @property
    def exit_code(self) -> int:
        """Exit code of the run: 0 if it finished."""
        with reading(self.path(".summary.json")):
            return int(self.summary["exit_code"])

    @property
    def log(self) -> str:
        """Output of the program."""
        return text_of(self.path(".log"))

    @property
    def warnings(self) -> list[str]:
        """Warnings of the run."""
        first = "warning: "
        return [line[len(first):] for line in self.log.splitlines() if line.startswith(first)]

    @property
    def history(self) -> pandas.DataFrame:
        """The first history, also where other tables, such as gauges, come before it in the deck."""
        name = self.history_name
        if name is None:
            raise FileProblem(f"{self.folder} holds no history of '{self.case}'; its tables are: "
                              f"{', '.join(self.tables) or 'none'}; add &output kind = 'history' to the deck")
        return self.tables[name]

    @property
    def history_name(self) -> str | None:
        """Name of the first history in `tables`, None if the run wrote none."""
        listed = self.summary.get("files", {}) if self.path(".summary.json").exists() else {}
        listed = listed if isinstance(listed, dict) else {}
        # older versions listed all tables as history_N: the name of the file tells the kind
        files = [str(file) for file in listed.values()] or [f"{self.case}_history.csv"]
        names = [file[len(self.case) + 1:-len(".csv")] for file in files if file.endswith("_history.csv")]
        return next((name for name in names if name in self.tables), None)

    @property
    def fragments(self) -> pandas.DataFrame | None:
        """The table of fragments, None if the run wrote none."""
        return self.tables.get("fragments")

    @cached_property
    def series(self) -> dict[str, Snapshots]:
        """Series of particles and slices by the name after CASE_: p, s, NAME_p."""
        first, found = f"{self.case}_", {}
        for path in sorted(self.folder.glob(f"*{SERIES}")):
            name = path.name[:-len(SERIES)]
            if name.startswith(first) and name.rpartition("_")[2] in ("p", "s"):
                found[name[len(first):]] = Snapshots(files.series(str(path)))
        return found

    @property
    def snapshots(self) -> Snapshots:
        """Snapshots of the first series of particles; of the series that was opened, if one was named."""
        if self._stream:
            return self.series[self._stream]
        if "p" in self.series:
            return self.series["p"]
        streams = [name for name in self.series if name.endswith("_p")]
        return self.series[streams[0]] if len(streams) == 1 else Snapshots([])


def text_of(path: Path) -> str:
    """A text file, in UTF-8 or, as an older editor writes a title, in Latin-1."""
    try:
        return decoded(Path(readable(str(path))).read_bytes())
    except OSError as error:
        raise FileProblem(f"cannot read {path}: {error.strerror}") from error


def cases_in(folder: Path) -> list[str]:
    """Names of the cases in a folder."""
    for mark in MARKS:
        found = sorted(path.name[:-len(mark)] for path in folder.glob(f"*{mark}"))
        if mark in MARKS[2:]:                            # CASE_NAME_history.csv belongs to CASE
            found = [name for name in found if not any(name.startswith(f"{other}_") for other in found)]
        if found:
            return found
    return []


def open_run(place: str | os.PathLike[str]) -> Run:
    """The results of a run.

    `place` is a folder with one case, FOLDER/CASE, or a series FOLDER/CASE_p.hdf.series or .vtkhdf. Files are read
    at first use.
    """
    path = Path(place)
    if path.is_dir():
        cases = cases_in(path)
        if len(cases) != 1:
            raise FileProblem(f"{path} holds no results of a run" if not cases else
                              f"{path} holds results of several cases, open one of them: "
                              + ", ".join(str(path / case) for case in cases))
        return Run(path, cases[0])
    for ending in (SERIES, ".vtkhdf"):
        if path.name.endswith(ending):
            return open_series(path.parent, path.name[:-len(ending)], str(path))
    if any((path.parent / f"{path.name}{mark}").exists() for mark in MARKS):
        return Run(path.parent, path.name)
    known = cases_in(path.parent) if path.parent.is_dir() else []
    raise FileProblem(f"no results of a run at {path}" + (nearest(path.name, known) if known else ""))


def open_series(folder: Path, name: str, file: str) -> Run:
    """The run of a series CASE_STREAM."""
    readable(file)
    readable(str(folder / f"{name}{SERIES}"))
    cases = [case for case in cases_in(folder) if name.startswith(f"{case}_")]
    case = max(cases, key=len) if cases else name.rpartition("_")[0] or name
    return Run(folder, case, name[len(case) + 1:])
