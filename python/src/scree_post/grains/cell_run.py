# SPDX-License-Identifier: BSD-3-Clause
"""Files of a finished run of scree --grains: deck, history, moduli, contacts."""
from __future__ import annotations

import json
import math
import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from scree import units as units_of
from scree.echo import groups
from scree.errors import ScreeError, decoded, readable
from scree.files import history, open_file, series

if TYPE_CHECKING:
    from scree.arrays import Array
    from scree.files import History, Moment

COLUMNS = ("stage", "time", "strain", "rate_xx", "rate_yy", "rate_xy", "volume_fraction", "stress_xx", "stress_yy",
           "stress_xy")
AGES = ("age", "age_strain", "normal_force")


@dataclass
class Stage:
    """One stage: its kind and its rows of the history."""

    number: int
    name: str
    kind: str                                            # shear, hold or other
    rows: dict[str, Array]                                          # name: column of the stage, SI
    start_time: float                                    # [s]
    start_strain: float                                  # accumulated shear strain [1]
    scale: float = 1.0                                   # rate to inertial number at 1 Pa

    @property
    def rate(self) -> float:
        """Shear rate du_x/dy [1/s]."""
        return float(self.rows["rate_xy"][-1])

    @property
    def strain(self) -> Array:
        """Shear strain since the start of the stage at the rows [1]."""
        return np.asarray(self.rows["strain"] - self.start_strain)

    def middle(self) -> Array:
        """Times of the middles of the row intervals since the start of the stage [s]."""
        time = self.rows["time"] - self.start_time
        return np.asarray(0.5 * (time + np.concatenate([[0.0], time[:-1]])))

    def steady(self, skip: float) -> dict[str, Array]:
        """Rows after the start of the stage: those beyond a strain `skip`, or beyond 40 % of a stage that is too
        short."""
        limit = self.skipped(skip)
        return {name: values[self.strain > limit] for name, values in self.rows.items()}

    def skipped(self, skip: float) -> float:
        """Strain at the start of the stage that is excluded [1]."""
        return min(skip, 0.4 * float(self.strain[-1]))


@dataclass
class CellRun:
    """A finished run."""

    folder: str
    case: str
    keys: dict[str, Any]                                          # of &grains and &cell, SI
    stages: list[Stage] = field(default_factory=list)
    moduli: History | None = None                                # table CASE_moduli.csv, or None
    contacts: list[Moment] = field(default_factory=list)         # (time [s], file)
    grains: list[Moment] = field(default_factory=list)           # (time [s], file)
    provenance: dict[str, str] = field(default_factory=dict)       # of the last snapshot
    unfinished: str = ""                                 # reason, empty if the run reached its end

    def path(self, ending: str) -> str:
        """A file of the case."""
        return os.path.join(self.folder, self.case + ending)

    def stages_of(self, kind: str) -> list[Stage]:
        """All stages of a kind."""
        return [stage for stage in self.stages if stage.kind == kind]

    def before(self, stage: Stage) -> Stage | None:
        """The previous stage, or None."""
        place = self.stages.index(stage)
        return self.stages[place - 1] if place else None


def read_run(folder: str) -> CellRun:
    """Read the results of a finished run from its folder."""
    if not os.path.isdir(folder):
        raise ScreeError(f"no such folder: {folder}; name the folder of a run of scree --grains, such as out/CASE")
    found = sorted(name for name in os.listdir(folder) if name.endswith("_history.csv"))
    if not found:
        raise ScreeError(f"{folder}: no *_history.csv in this folder; run `scree --grains DECK` first")
    if len(found) > 1:
        raise ScreeError(f"{folder}: {len(found)} histories ({', '.join(found)}); keep the runs in folders of their "
                         "own")
    run = CellRun(folder, found[0].removesuffix("_history.csv"), {})
    echo = run.path(".echo.nml")
    text = decoded(Path(readable(echo)).read_bytes())
    run.keys = {**keys_of(text, "cell"), **keys_of(text, "grains")}
    missing = [name for name in ("diameter", "density", "shape") if name not in run.keys]
    if missing:
        raise ScreeError(f"{echo}: &grains has no {', '.join(missing)}; this is not a run of scree --grains")
    run.unfinished = why_unfinished(run.path(".summary.json"))
    names = [str(values.get("name", "")) for values in groups(text, "stage")]
    run.stages = read_stages(run, names)
    if os.path.exists(run.path("_moduli.csv")):
        run.moduli = history_or_none(run.path("_moduli.csv"))
    for kind in ("contacts", "grains"):
        file = run.path(f"_{kind}.hdf.series")
        setattr(run, kind, series(file) if os.path.exists(file) else [])
    if run.contacts:
        with open_file(run.contacts[-1][1]) as handle:
            if "provenance" in handle:
                run.provenance = {key: units_of.plain(value) for key, value in handle["provenance"].attrs.items()}
    return run


def why_unfinished(path: str) -> str:
    """Reason in the summary of a run that did not reach its end, or empty."""
    try:
        with open(path, encoding="utf-8") as handle:
            summary = json.load(handle)
    except FileNotFoundError:
        return "it has no summary yet"
    except (OSError, ValueError) as error:
        raise ScreeError(f"cannot read {path}: {error}") from error
    return "" if summary.get("exit_code") == 0 else str(summary.get("reason", "unknown reason"))


def history_or_none(path: str) -> History | None:
    """A table, or None if it has a header only."""
    try:
        return history(path)
    except ScreeError as error:
        if "no complete line" in str(error):
            return None
        raise


def keys_of(text: str, name: str) -> dict[str, Any]:
    """The keys of the only group of a name."""
    return next(iter(groups(text, name)), {})


def read_stages(run: CellRun, names: Sequence[str]) -> list[Stage]:
    """The stages of the history."""
    path = run.path("_history.csv")
    table = history(path)
    missing = [name for name in COLUMNS if name not in table]
    if missing:
        raise ScreeError(f"{path} is not a history of scree --grains: it has no column {', '.join(missing)}")
    stages: list[Stage] = []
    start_time, start_strain = float(table["time"][0]), float(table["strain"][0])
    for number in np.unique(table["stage"]).astype(int):
        chosen = (table["stage"] == number) & (table["time"] > start_time)
        if not chosen.any():
            continue
        rows = {name: table[name][chosen] for name in table.order}
        wrong = next((name for name in COLUMNS if not np.isfinite(rows[name]).all()), None)
        if wrong:
            raise ScreeError(f"{path}: column {wrong} of stage {number} is not finite")
        name = names[number - 1] if number <= len(names) and names[number - 1] else "stage"
        if names.count(name) != 1:                       # stages may have no names
            name = f"{name} {number}"
        stages.append(Stage(int(number), name, kind_of(rows, stages), rows, start_time,
                            start_strain, run.keys["diameter"] * math.sqrt(run.keys["density"])))
        start_time, start_strain = float(rows["time"][-1]), float(rows["strain"][-1])
    return stages


def kind_of(rows: Mapping[str, Array], earlier: Sequence[Stage]) -> str:
    """shear: a constant rate; hold: no shear, after a shear stage; other: compression and all others."""
    rate = rows["rate_xy"]
    if np.all(np.abs(rate) > 0.0):
        return "shear"
    if earlier and earlier[-1].kind == "shear" and not np.any(np.abs(rate) > 0.0):
        return "hold"
    return "other"


def ages_of(run: CellRun, stage: Stage, skip: float) -> list[dict[str, Array]]:
    """Ages of the existing contacts in the snapshots of a stage after its start: a list of dicts of arrays."""
    found = []
    begin, end = stage.start_time, float(stage.rows["time"][-1])
    from_time = begin + stage.skipped(skip) / abs(stage.rate)
    for time, file in run.contacts:
        if not from_time * (1.0 - 1.0e-9) <= time <= end * (1.0 + 1.0e-9):
            continue
        with open_file(file) as handle:
            data = handle.get("VTKHDF/CellData", {})
            missing = [name for name in AGES if name not in data]
            if missing:
                raise ScreeError(f"{file} is not a file of contacts: it has no {', '.join(missing)}")
            found.append({name: units_of.data_si(data[name]) for name in AGES})
    return found
