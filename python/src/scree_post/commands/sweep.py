# SPDX-License-Identifier: BSD-3-Clause
"""Runs a deck for all combinations of values and collects the results.

Every combination has a separate folder below --outdir. Completed combinations are not run again,
and stopped ones continue from their checkpoint, so the same command resumes a study. Results of
another deck or program are replaced only with --overwrite. Each run has one thread, and there are
as many simultaneous runs as cores. The table keeps the runs of earlier sweeps of the same deck and
program in that folder. It contains the values, how each run ended, and the quantities of --take:
names in the summary, columns of the history at the end, TABLE.COLUMN of other tables, such as
gauge.velocity_x and fragments[1].mass, both with :max, :min, :mean or :at=TIME, or extents of the
last snapshot such as length, radius, front_z. Unknown names are refused before the first run. If
values contain commas, separate them by semicolons: --set 'body[ball].velocity=0,0,1;0,0,2'.
"""
from __future__ import annotations

import argparse
import os
import re
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from scree.drawing import look
from scree.errors import EXIT_DIFFERENT, EXIT_USAGE, FileProblem, ScreeError, readable
from scree.program import jobs_for, key_unit, threads_of_a_run
from scree.quantities import unit_of, value_of
from scree.study import Combination, Study, combinations, read_stamp, short

if TYPE_CHECKING:
    from matplotlib.figure import Figure

SUMMARY = "run a deck for several values: table and plot of the results"
EXAMPLES = ("sweep input/two_discs/scene.nml --set grid.dx=0.05,0.025 --take energy_error,steps",
            "sweep input/column_collapse/scene.nml --set material.friction_angle=30,45 --jobs 2",
            "sweep input/debris_cloud/scene.nml --set 'body[sphere].velocity=0,0,6;0,0,7' --list")
DEFAULT = "time,steps,wall_s,kinetic,energy_error"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """The options."""
    add = parser.add_argument
    add("deck", metavar="DECK", help="deck of the study")
    add("--set", metavar="G.K=A,B", action="append", required=True, dest="values",
        help="values of a key; repeat for more keys")
    add("--take", metavar="X,Y", default=DEFAULT, help=f"quantities of the table ({DEFAULT})")
    add("--jobs", type=int, metavar="N", help="number of simultaneous runs; default: cores over --threads")
    add("--threads", type=int, metavar="N", help="threads of a run; default OMP_NUM_THREADS or 1")
    add("--overwrite", action="store_true", help="replace results of another deck or program")
    add("--outdir", metavar="DIR", help="default out/NAME_sweep with the name of the deck")
    add("--scree", metavar="PROGRAM", help="the program; default build/bin/scree or in the path")
    add("--out", metavar="PNG", help="plot; default DIR/sweep.png")
    add("--list", action="store_true", help="only print the combinations")


def settings(words: Sequence[str]) -> dict[str, list[str]]:
    """Keys and their lists of values, from GROUP.KEY=A,B,C; values that contain commas end in
    ';'."""
    found: dict[str, list[str]] = {}
    for word in words:
        key, equals, text = word.partition("=")
        if not equals or not re.fullmatch(r"\w+(\[[^\]]+\])?\.\w+", key):
            raise ScreeError(f"--set {word}: write GROUP.KEY=A,B,C or 'GROUP[NAME].KEY=A,B'", EXIT_USAGE)
        values = [part.strip() for part in text.split(";" if ";" in text else ",")]
        values = [value for value in values if value]
        if not values:
            raise ScreeError(f"--set {word}: no value", EXIT_USAGE)
        if key in found:
            raise ScreeError(f"--set {key} is given twice; give all its values in one option", EXIT_USAGE)
        if len(set(values)) < len(values):
            raise ScreeError(f"--set {word}: a value is given twice", EXIT_USAGE)
        found[key] = values
    return found


def deck_name(deck: str) -> str:
    """Name of the deck, or of its folder if the deck is named scene.nml."""
    stem = os.path.splitext(os.path.basename(deck))[0]
    return os.path.basename(os.path.dirname(os.path.abspath(deck))) if stem == "scene" else stem


def results(runs: Sequence[Combination], names: Sequence[str]) -> tuple[list[dict[str, Any]], dict[str, str]]:
    """Rows of the table and units by name; empty where a run failed, or its summary lacks the
    key."""
    rows: list[dict[str, Any]] = []
    units: dict[str, str] = {}
    keys = dict.fromkeys(key for run in runs for key in run.settings)
    for run in runs:
        row = {**dict.fromkeys(keys, ""), **run.settings, "exit_code": run.code}
        for name in names:
            row[name] = np.nan
            if run.result is not None:
                row[name], units[name] = value_of(run.result, name), unit_of(run.result, name)
        row["folder"], row["reason"] = run.folder, run.reason
        rows.append(row)
    return rows, units


def earlier(base: str, study: Study, runs: Sequence[Combination], case: str) -> tuple[list[Combination], int]:
    """Finished runs of earlier sweeps in this folder with the same deck and program, and the
    number of runs with another one."""
    found, others = [], 0
    known = {run.folder for run in runs}
    for name in sorted(os.listdir(base)):
        folder = os.path.join(base, name)
        stamp = read_stamp(folder)
        if folder in known or not stamp:
            continue
        run = Combination(stamp["values"], folder, f"{case}_{name}", code=0, kept=True)
        if study.is_done(run):
            found.append(run)
        else:
            others += 1
    return found, others


def varied(keys: Mapping[str, Sequence[str]]) -> list[str]:
    """The keys with several values, or the first key."""
    return [key for key in keys if len(keys[key]) > 1] or list(keys)[:1]


def write_table(path: str, rows: Sequence[Mapping[str, Any]], units: Mapping[str, str]) -> None:
    """The table, units in the heading."""
    import pandas
    heads = {key: f"{key} [{units[key]}]" if units.get(key, "1") not in ("", "1") else key for key in rows[0]}
    pandas.DataFrame(rows).rename(columns=heads).to_csv(path + ".part", index=False, float_format="%.9g")
    os.replace(path + ".part", path)


def places_of(runs: Sequence[Combination], key: str) -> dict[str, float]:
    """The values of a key that the runs used, in SI, by their texts in --set; empty if they are not single numbers."""
    group, _, name = key.rpartition(".")
    group, _, which = group.rstrip("]").partition("[")
    found: dict[str, float] = {}
    for run in runs:
        if run.result is None or key not in run.settings:
            continue
        entry = run.result.deck.get(group.lower(), [])
        entries = entry if isinstance(entry, list) else [entry]
        values = [entry.get(name.lower()) for entry in entries if not which or entry.get("name") == which]
        if len(values) != 1 or isinstance(values[0], bool) or not isinstance(values[0], (int, float)):
            return {}
        found[run.settings[key]] = float(values[0])
    return found


def picture(rows: Sequence[Mapping[str, Any]], keys: Mapping[str, Sequence[str]], names: Sequence[str],
            units: Mapping[str, str], title: str, places: Mapping[str, float]) -> Figure:
    """A panel for each quantity: against the first key with several values, one line for each
    combination of the other values. `places` are the values of that key in SI, empty if they are not numbers."""
    plot = look.pyplot()
    first, *rest = varied(keys)
    scale, unit_across = look.readable_unit(max(map(abs, places.values()), default=0.0), units.get(first) or "1")
    columns = min(2, len(names))
    lines = (len(names) + columns - 1) // columns
    figure: Figure
    figure, grid = plot.subplots(lines, columns, figsize=(5.2 * columns + 0.4, 3.4 * lines + 0.5),
                                 squeeze=False, layout="constrained")
    groups: dict[str, list[Mapping[str, Any]]] = {}
    for row in rows:
        if row["exit_code"] == 0:
            label = ", ".join(f"{short(key)} = {row[key]}" for key in rest)
            groups.setdefault(label, []).append(row)
    cells = list(grid.ravel())
    for axes, name in zip(cells, names):
        size = max((abs(row[name]) for row in rows if row["exit_code"] == 0), default=0.0)
        factor, unit = look.readable_unit(size, units.get(name) or "1")
        for tint, (label, part) in enumerate(groups.items()):
            across = [scale * places[row[first]] if places else keys[first].index(row[first]) for row in part]
            order = np.argsort(across)
            up = factor * np.array([row[name] for row in part])
            axes.plot(np.array(across)[order], up[order], "o-", label=label, linewidth=1.6,
                      color=look.COLOURS[tint % len(look.COLOURS)], markersize=5)
        if not places:
            axes.set_xticks(range(len(keys[first])), keys[first])
        elif min(places.values()) > 0.0 and max(places.values()) / min(places.values()) > 20.0:
            axes.set_xscale("log")
        axes.set_xlabel(look.with_unit(first, unit_across if places else ""))
        axes.set_ylabel(look.with_unit(look.words(name.replace(".", " ")), unit))
        axes.grid(color="#dddddd", linewidth=0.6)
        axes.set_axisbelow(True)
        axes.spines[["top", "right"]].set_visible(False)
    if rest:
        cells[0].legend(loc="best", fontsize=9)
    for axes in cells[len(names):]:
        axes.set_visible(False)
    figure.suptitle(title, fontsize=12)
    return figure


def tell(run: Combination, count: str) -> None:
    """A line for a finished run, also in a file."""
    values = ", ".join(f"{key} = {value}" for key, value in run.settings.items())
    if run.code == 0:
        print(f"{'there' if run.kept else 'done '}  {values}  ({count})", flush=True)
    elif run.code is not None:
        print(f"FAILED {values}: exit code {run.code}, {run.reason}  ({count})", flush=True)


def check_arguments(arguments: argparse.Namespace) -> tuple[list[str], dict[str, list[str]]]:
    """Quantities and keys, with checks that the parser cannot do."""
    if any(given is not None and given < 1 for given in (arguments.jobs, arguments.threads)):
        raise ScreeError("--jobs and --threads must be above 0", EXIT_USAGE)
    names = [name.strip() for name in arguments.take.split(",") if name.strip()]
    if not names:
        raise ScreeError("--take names no quantity", EXIT_USAGE)
    return names, settings(arguments.values)


def run(arguments: argparse.Namespace) -> int:
    """Run the combinations that are not finished, then write table and plot."""
    names, keys = check_arguments(arguments)
    deck = readable(arguments.deck)
    base = os.path.abspath(arguments.outdir or os.path.join("out", deck_name(deck) + "_sweep"))
    runs = combinations(keys, base, deck_name(deck))
    if arguments.list:
        for one in runs:
            print(f"{one.folder}: " + ", ".join(f"{key} = {v}" for key, v in one.settings.items()))
        return 0
    threads = arguments.threads or threads_of_a_run()
    study = Study(deck, program=arguments.scree, overwrite=arguments.overwrite, threads=threads)
    try:
        os.makedirs(base, exist_ok=True)
    except OSError as error:
        raise FileProblem(f"cannot make {base}: {error.strerror or error}") from error
    out = arguments.out or os.path.join(base, "sweep.png")
    look.check_picture(out)

    done: list[Combination] = []

    def ended(one: Combination) -> None:
        done.append(one)
        tell(one, f"{len(done)} of {len(runs)}")

    study.check_quantities(runs, names)
    study.all(runs, arguments.jobs or jobs_for(threads), ended, lines=False)
    failed = [one for one in runs if one.code != 0]
    before, others = earlier(base, study, runs, deck_name(deck))
    rows, units = results(runs + before, names)
    table = os.path.join(base, "sweep.csv")
    write_table(table, rows, units)
    print(f"{len(runs) - len(failed)} of {len(runs)} runs finished\nwrote {table}"
          + (f" with {len(before)} runs of earlier sweeps" if before else ""))
    if others:
        print(f"left out of the table: {others} earlier runs in {base} that failed, or that another deck or "
              "program made")
    if len(failed) < len(runs):
        same = [row for row, one in zip(rows, runs + before) if set(one.settings) == set(keys)]
        seen = {key: list(dict.fromkeys(row[key] for row in same)) for key in keys}
        first = varied(seen)[0]
        places = places_of([one for one in runs + before if one.code == 0], first)
        page = picture(same, seen, names, {**units, first: key_unit(study.program, first)}, deck_name(deck), places)
        look.save(page, out, 150)
        print(f"wrote {out}")
    return EXIT_DIFFERENT if failed else 0
