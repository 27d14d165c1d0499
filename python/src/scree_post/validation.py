# SPDX-License-Identifier: BSD-3-Clause
"""Rows of the validation: shots that were measured, the deck that computes them, and what came out.

A family is a folder of input/validation with three files:

  deck.nml     a deck for all shots; what differs between them is named by &define
  data.csv     a line for each shot: its name, inputs, measured quantities, error [%], source and note. A heading may
               have a unit, `length [mm]`. A column is an input unless evaluate.py lists it as a quantity: a name of
               &define, or a key such as material.preset; a value may be a file of the folder
  evaluate.py  its docstring is the text of the page. QUANTITIES: words and unit of each quantity by name; CELLS: value
               of `cells` of &define, unless it is an input; COARSER: how many times fewer cells the second grid has (2
               by default); SUBJECT: the page, one of SUBJECTS; measure(run, shot): the quantities of a run, in their
               units; `shot` has the inputs as texts with units
"""
from __future__ import annotations

import csv
import math
import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

import scree
from scree.drawing import look
from scree.errors import EXIT_USAGE, FileProblem, ScreeError, readable, reading, unknown
from scree.launch import Count
from scree.program import find_program

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from scree.results import Run

TARGET = 5.0                                             # accepted deviation [%], if the measurement is as good
TEXTS = ("name", "what", "source", "note")               # columns of data.csv that are neither inputs nor quantities
ERROR = "error"                                          # column: error of all quantities of a shot [%]
MARKS = ("<!-- rows -->", "<!-- end of rows -->")
SUBJECTS = {"metals": "metals", "strength": "strength of metals", "impacts": "impacts and explosives",
            "grains": "grains", "brittle": "rock, concrete and glass", "fluids": "fluids and gas",
            "water": "water with a free surface", "others": "other experiments"}
COLUMNS = ("family", "name", "quantity", "unit", "prediction", "cells_error", "measured", "error", "deviation",
           "verdict", "seconds")


@dataclass(frozen=True)
class Shot:
    """One experiment."""

    name: str
    what: str
    inputs: dict[str, str]                               # with their units; those that the deck chooses are missing
    measured: dict[str, float]                           # in the units of the quantities
    error: dict[str, float | None]                       # stated error or scatter [%], None if not stated
    source: str = ""
    note: str = ""                                       # why it deviates; "not comparable: ..." if nothing follows


@dataclass
class Family:
    """Experiments that one deck computes."""

    name: str
    folder: Path
    title: str
    text: str
    quantities: dict[str, tuple[str, str]]
    cells: int
    coarser: float
    measure: Callable[[Run, Mapping[str, str]], Mapping[str, float]]
    units: dict[str, str]                                # of the inputs in data.csv
    subject: str                                         # a name of SUBJECTS
    shots: dict[str, Shot] = field(default_factory=dict)

    def defined(self) -> list[str]:
        """Names that &define of the deck has."""
        text = re.sub(r"!.*", "", (self.folder / "deck.nml").read_text(encoding="utf-8"))
        return [name for group in re.findall(r"&define(.*?)\s/\s*$", text, re.M | re.S)
                for name in re.findall(r"(\w+)\s*=", group)]

    def settings(self, inputs: Mapping[str, str], cells: int) -> dict[str, str]:
        """Keys of the deck for the inputs of a shot."""
        named = {**inputs, "cells": str(cells)}
        return {key if "." in key else f"define.{key}": str(file) if (file := self.folder / value).is_file() else value
                for key, value in named.items()}


@dataclass
class Result:
    """One quantity of one shot."""

    family: str
    name: str
    quantity: str
    unit: str
    prediction: float
    cells_error: float                                   # prediction less that of the coarser grid
    measured: float = math.nan
    error: float | None = None                           # of the measurement [%]
    seconds: float = 0.0                                 # processor time of both runs, at the first quantity of a shot
    blocked: str = ""                                    # reason why the two are not comparable

    @property
    def deviation(self) -> float:
        """Prediction over measurement less one [%]."""
        return 100.0 * (self.prediction / self.measured - 1.0)

    @property
    def verdict(self) -> str:
        """Within, outside, or not comparable where the cells alone cause a larger error than the allowed one."""
        if math.isnan(self.measured):
            return "no measurement"
        allowed = max(TARGET, self.error or 0.0)
        if self.blocked or not abs(self.cells_error) <= 0.01 * allowed * abs(self.measured):
            return "not comparable"
        return "within" if abs(self.deviation) <= allowed else "outside"

    def row(self) -> dict[str, str]:
        """Texts for results.csv."""
        error = "" if self.error is None else f"{self.error:g}"
        return dict(zip(COLUMNS, (self.family, self.name, self.quantity, self.unit, f"{self.prediction:.4g}",
                                  f"{self.cells_error:.2g}", f"{self.measured:g}", error, f"{self.deviation:+.1f}",
                                  self.verdict, f"{self.seconds:.2g}")))


def place() -> Path:
    """The folder input/validation, of this tree or beside the program."""
    beside = Path(__file__).resolve().parents[3] / "input" / "validation"
    if beside.is_dir():
        return beside
    shared = Path(find_program()).resolve().parents[1] / "share" / "scree" / "input" / "validation"
    if not shared.is_dir():
        raise FileProblem(f"no folder {beside} or {shared}")
    return shared


def heading(text: str) -> tuple[str, str]:
    """Name and unit of a column from `length [mm]`."""
    found = re.fullmatch(r"([\w.\[\]]+?)(?: \[(.*)\])?", text.strip())
    if not found:
        raise FileProblem(f"'{text}' is no heading such as: length [mm]")
    return found[1], found[2] or ""


def read_family(folder: Path) -> Family:
    """The family in a folder."""
    script = folder / "evaluate.py"
    with reading(script):
        found: dict[str, Any] = {"__name__": folder.name}    # not imported: an import would write into the folder
        exec(compile(script.read_text(encoding="utf-8"), str(script), "exec"), found)
        quantities, cells, measure = found["QUANTITIES"], found["CELLS"], found["measure"]
    subject = found.get("SUBJECT", "others")
    if subject not in SUBJECTS:
        raise unknown("SUBJECT", subject, SUBJECTS, str(script))
    title, _, text = (found.get("__doc__") or folder.name).partition("\n")
    family = Family(folder.name, folder, title.strip().rstrip("."), text.strip(), quantities, cells,
                    found.get("COARSER", 2.0), measure, {}, subject)
    data = folder / "data.csv"
    with reading(data), open(data, newline="", encoding="utf-8") as file:
        table = csv.reader(line for line in file if not line.startswith("#"))
        heads = [heading(text) for text in next(table)]
        own = {ERROR, *TEXTS, *family.quantities, *(f"{name}_{ERROR}" for name in family.quantities)}
        family.units = {name: unit for name, unit in heads if name not in own}
        for line in table:
            cells = {name: text.strip() for (name, _), text in zip(heads, line) if text.strip()}
            shot = Shot(cells["name"], cells.get("what", ""), with_units(family, cells),
                        {name: float(cells[name]) for name in family.quantities if name in cells},
                        {name: float(text) if text else None for name in family.quantities
                         for text in [cells.get(f"{name}_{ERROR}", cells.get(ERROR, ""))]},
                        cells.get("source", ""), cells.get("note", ""))
            family.shots[shot.name] = shot
    return family


def with_units(family: Family, values: Mapping[str, str]) -> dict[str, str]:
    """Inputs as texts for the deck: a number without a unit gets that of its column."""
    found = {}
    for name, value in values.items():
        if name in family.units:
            bare = re.fullmatch(r"[-+.\deE]+", value)
            found[name] = f"{value} {family.units[name]}".strip() if bare else value
    return found


def families() -> dict[str, Family]:
    """All families by name."""
    return {script.parent.name: read_family(script.parent) for script in sorted(place().glob("*/evaluate.py"))}


def choose(known: Mapping[str, Family], names: Iterable[str]) -> list[tuple[Family, Shot]]:
    """The shots of names: of a family all of its shots."""
    found = []
    for name in names:
        if name in known:
            found += [(known[name], shot) for shot in known[name].shots.values()]
            continue
        family = next((one for one in known.values() if name in one.shots), None)
        if family is None:
            raise unknown("row", name, [*known, *(shot for one in known.values() for shot in one.shots)])
        found.append((family, family.shots[name]))
    return found


def changed(family: Family, shot: Shot, settings: Mapping[str, str]) -> Shot:
    """A shot with other inputs, of which there is no measurement."""
    known = [*family.units, *(name for name in family.defined() if name not in family.units)]
    for name in settings:
        if name not in known and "." not in name:
            raise unknown("input", name, known, f"family {family.name}", EXIT_USAGE)
    if not settings.get("cells", "2").isdigit():
        raise ScreeError(f"cells = {settings['cells']}: write an integer above 1", EXIT_USAGE)
    keys = {name: value for name, value in settings.items() if name not in family.units}
    words = ", ".join(f"{name} = {value}" for name, value in settings.items())
    return Shot("prediction", f"{shot.name} with {words}", {**shot.inputs, **with_units(family, settings), **keys}, {},
                {})


def compute(shots: Sequence[tuple[Family, Shot]], *, program: str | None, outdir: Path, jobs: int, threads: int,
            cells: int | None = None) -> tuple[list[Result], list[ScreeError]]:
    """Run the shots on two grids each; `cells` replaces that of the families. Also returns the errors of the runs that
    failed, whose shots have no results."""
    found = find_program(program)
    grids = []
    for family, shot in shots:
        fine = cells or int(shot.inputs.get("cells", family.cells))
        grids += [(family, shot, fine), (family, shot, max(1, round(fine / family.coarser)))]

    def one(task: tuple[Family, Shot, int]) -> tuple[Mapping[str, float], float] | ScreeError:
        family, shot, number = task
        try:
            run = scree.run(family.folder / "deck.nml", family.settings(shot.inputs, number), case=shot.name,
                            outdir=outdir / shot.name / f"cells_{number}", overwrite=True, progress=False,
                            program=found, threads=threads)
        except ScreeError as error:
            return type(error)(f"{shot.name} with cells = {number}: {error}", error.code, error.messages, error.folder)
        return family.measure(run, shot.inputs), run.summary["processor_s"]

    runs = []
    with Count(len(grids), "validate") as bar, ThreadPoolExecutor(jobs) as pool:
        for answer in pool.map(one, grids):
            runs.append(answer)
            bar.update()
    results, failed = [], [answer for answer in runs if isinstance(answer, ScreeError)]
    for (family, shot), fine_run, coarse_run in zip(shots, runs[::2], runs[1::2]):
        if isinstance(fine_run, ScreeError) or isinstance(coarse_run, ScreeError):
            continue
        (values, seconds), (coarse, more) = fine_run, coarse_run
        for name, (_, unit) in family.quantities.items():
            if name in values and (name in shot.measured or not shot.measured):
                blocked = shot.note.partition("not comparable:")[2].strip()
                results.append(Result(family.name, shot.name, name, unit, values[name], values[name] - coarse[name],
                                      shot.measured.get(name, math.nan), shot.error.get(name), seconds + more,
                                      blocked))
                seconds = more = 0.0
    return results, failed


def first_above(time: np.ndarray, impulse: np.ndarray, force: float) -> float:
    """Time at the end of the first interval over which the mean force, the rate of the impulse, exceeds a value."""
    return float(time[1 + np.nonzero(np.diff(impulse) > force * np.diff(time))[0][0]])


def mean_forces(time: np.ndarray, impulse: np.ndarray, spans: Mapping[str, tuple[float, float]]) -> dict[str, float]:
    """Mean forces over spans of time by their names, from the impulse."""
    found = {}
    for name, (start, end) in spans.items():
        first, last = np.interp((start, end), time, impulse)
        found[name] = float((last - first) / (end - start))
    return found


def shock_from_wall(run: Run) -> float:
    """Speed of the shock [m/s] in a bar that strikes a rigid wall at x = 0, with the particles at rest behind it.

    It follows from the momentum that the wall takes up between the second and the third snapshot.
    """
    before, after = run.snapshots[1], run.snapshots[2]
    gained = [float((snap["mass"] * snap["velocity"][:, 0]).sum()) for snap in (before, after)]
    mass, grid, speed = float(after["mass"].sum()), run.deck["grid"], -run.deck["body"]["velocity"][0]
    return float(grid["hi"][0] * (gained[1] - gained[0]) / (mass * speed * (after.time - before.time)))


def read_results(path: Path) -> list[dict[str, str]]:
    """Rows of results.csv; none without the file."""
    if not path.is_file():
        return []
    with reading(path), open(path, newline="", encoding="utf-8") as file:
        return list(csv.DictReader(file))


def renewed(rows: Iterable[Mapping[str, str]], results: Iterable[Result], known: Mapping[str, Family]
            ) -> list[dict[str, str]]:
    """Rows of results.csv with the new results, in the order of the families and their shots, without removed ones."""
    by_place = {(row["name"], row["quantity"]): dict(row) for row in rows}
    by_place |= {(result.name, result.quantity): result.row() for result in results}
    order = [(shot.name, quantity) for family in known.values() for shot in family.shots.values()
             for quantity in family.quantities]
    return [by_place[key] for key in order if key in by_place]


def write_results(path: Path, rows: Iterable[Mapping[str, str]]) -> None:
    """Write results.csv."""
    with open(path, "w", newline="", encoding="utf-8") as file:
        writer = csv.DictWriter(file, COLUMNS, lineterminator="\n")
        writer.writeheader()
        writer.writerows(rows)


def page_rows(known: Mapping[str, Family], rows: Sequence[Mapping[str, str]], stem: str) -> str:
    """The generated part of the page: summary, and families with links to the pages of their subjects."""
    total = sum(float(row["seconds"]) for row in rows)
    lines = ["", f"{len(rows)} measured quantities: {counted(rows, ' within, {} outside, {} not comparable')}. All "
             f"rows take {total / 60.0:.0f} minutes of processor time.", "",
             "| experiments | rows | within | outside | not comparable | s |", "|---|---|---|---|---|---|"]
    for family, own in by_subject(known, rows):
        anchor = re.sub(r"[^\w -]", "", family.title.lower()).replace(" ", "-")
        seconds = sum(float(row["seconds"]) for row in own)
        lines.append(f"| [{family.title}]({stem}_{family.subject}.md#{anchor}) (`{family.name}`) | "
                     f"{len({row['name'] for row in own})} | {counted(own, ' | {} | {}')} | {seconds:.2g} |")
    return "\n".join([*lines, "", ""])


def counted(rows: Sequence[Mapping[str, str]], words: str) -> str:
    """Numbers of rows by verdict: that of `within`, then `words` with the other two."""
    verdicts = [row["verdict"] for row in rows]
    return str(verdicts.count("within")) + words.format(verdicts.count("outside"), verdicts.count("not comparable"))


def by_subject(known: Mapping[str, Family], rows: Sequence[Mapping[str, str]]
               ) -> list[tuple[Family, list[Mapping[str, str]]]]:
    """Families that have rows, with these, in the order of the subjects."""
    found = [(family, [row for row in rows if row["family"] == family.name]) for family in known.values()]
    return sorted(((family, own) for family, own in found if own),
                  key=lambda pair: list(SUBJECTS).index(pair[0].subject))


def subject_pages(known: Mapping[str, Family], rows: Sequence[Mapping[str, str]], stem: str) -> dict[str, str]:
    """Texts of the pages of the subjects by file name: text, table and notes of each family."""
    pages: dict[str, list[str]] = {}
    for family, own in by_subject(known, rows):
        words = SUBJECTS[family.subject]
        lines = pages.setdefault(f"{stem}_{family.subject}.md", [
            f"# Validation: {words}", "", f"This page compares predictions of Scree with measurements of {words}. "
            f"[Validation]({stem}.md) explains the columns;", "`scree-post validate` writes this page.", ""])
        lines += [f"## {family.title}", "", *family.text.splitlines(), "",
                  "| row | shot | quantity | prediction | cells | measured | error | deviation | verdict | s |",
                  "|---|---|---|---|---|---|---|---|---|---|"]
        before = ""
        for row in own:
            words, unit = family.quantities[row["quantity"]]
            first = row["name"] != before
            before = row["name"]
            error = f"{row['error']} %" if row["error"] else ""
            shot = family.shots[before]
            words_of = f"`{before}` | {shot.what} ({shot.source})" if first else " | "
            lines.append(f"| {words_of} | {look.with_unit(words, unit)} | {row['prediction']} | "
                         f"{float(row['cells_error']):+.2g} | {row['measured']} | {error} | {row['deviation']} % | "
                         f"{row['verdict']} | {row['seconds'] if first else ''} |")
        notes = [f"* `{name}`: {family.shots[name].note}" for name in dict.fromkeys(row["name"] for row in own)
                 if family.shots[name].note]
        lines += ["", *notes, ""] if notes else [""]
    return {name: "\n".join(lines).rstrip() + "\n" for name, lines in pages.items()}


def parts_of(path: Path) -> tuple[str, str]:
    """The page before and after the generated part."""
    text = Path(readable(str(path))).read_text(encoding="utf-8")
    before, first, rest = text.partition(MARKS[0])
    _, last, after = rest.partition(MARKS[1])
    if not (first and last):
        raise FileProblem(f"{path} does not contain the lines {MARKS[0]} and {MARKS[1]}")
    return f"{before}{first}\n", f"{last}{after}"


def picture(known: Mapping[str, Family], rows: Sequence[Mapping[str, str]]) -> Figure:
    """Prediction over measurement of all quantities, a line for each family, with the error of the measurement."""
    plot = look.pyplot()
    there = by_subject(known, rows)
    figure: Figure
    figure, axes = plot.subplots(figsize=(9.0, 1.2 + 0.4 * len(there)), layout="constrained")
    axes.axvspan(1.0 - 0.01 * TARGET, 1.0 + 0.01 * TARGET, color="#e8e8e8", zorder=0)
    for number, (_, own) in enumerate(there):
        colour = look.COLOURS[number % len(look.COLOURS)]
        for place, row in enumerate(own):
            ratio = float(row["prediction"]) / float(row["measured"])
            blocked = row["verdict"] == "not comparable"
            axes.errorbar([ratio], [number + 0.7 * ((place + 0.5) / len(own) - 0.5)],
                          xerr=0.01 * float(row["error"] or 0.0) * ratio, fmt="o", ms=4, color=colour,
                          mfc="white" if blocked else colour, lw=0.8, capsize=1.5)
    axes.set_yticks(range(len(there)), [family.title for family, _ in there], fontsize=9)
    axes.set(ylim=(len(there) - 0.5, -0.5), xlabel="prediction over measurement")
    axes.axvline(1.0, color="black", lw=0.8)
    axes.grid(axis="x", color="#dddddd", lw=0.6)
    for number in range(1, len(there)):
        axes.axhline(number - 0.5, color="#eeeeee", lw=0.6, zorder=0)
    return figure
