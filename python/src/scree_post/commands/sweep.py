# SPDX-License-Identifier: BSD-3-Clause
"""Runs a deck for all combinations of values and collects the results.

Every combination gets a folder of its own below --outdir. A combination that is done is not run
again, one that was stopped goes on from its checkpoint, so that the same command resumes a
study. Results of another deck or program are replaced only with --overwrite. A run has one thread,
and as many run at a time as there are cores. The table keeps the runs of earlier sweeps of the same
deck and program in that folder. It holds the values, how the run ended, and the quantities of
--take: names of the summary, columns of the history at the end, with .max, .min or .mean over the
history, or extents of the last snapshot such as length, radius, front_z. A value that holds commas
is separated by semicolons: --set 'body[ball].velocity=0,0,1;0,0,2'.
"""
import csv
import os

import numpy as np

from .. import look
from ..errors import EXIT_DIFFERENT, EXIT_USAGE, PostError, readable, unknown
from scree.files import history
from ..study import (Run, Study, combinations, find_program, is_done, jobs_for, read_stamp, settings, short,
                      stamp_of, threads_of_a_run, version_of)
from scree.units import summary_unit
from ..written import EXTENTS, Written

SUMMARY = "a deck for many values: table and plot of what came out"
EXAMPLES = ("sweep input/two_discs/scene.nml --set grid.dx=0.05,0.025 --take energy_error,steps",
            "sweep input/column_collapse/scene.nml --set material.friction_angle=30,45 --jobs 2",
            "sweep input/debris_cloud/scene.nml --set 'body[sphere].velocity=0,0,6;0,0,7' --list")
OVER = {"max": np.max, "min": np.min, "mean": np.mean}
DEFAULT = "time,steps,wall_s,kinetic,energy_error"


def add_arguments(parser):
    """The options."""
    add = parser.add_argument
    add("deck", metavar="DECK", help="deck of the study")
    add("--set", metavar="G.K=A,B", action="append", required=True, dest="values",
        help="values of a key; repeat for more keys")
    add("--take", metavar="X,Y", default=DEFAULT, help=f"quantities of the table ({DEFAULT})")
    add("--jobs", type=int, metavar="N", help="runs at a time; default the cores over --threads")
    add("--threads", type=int, metavar="N", help="threads of a run; default OMP_NUM_THREADS or 1")
    add("--overwrite", action="store_true", help="replace results of another deck or program")
    add("--outdir", metavar="DIR", help="default out/NAME_sweep with the name of the deck")
    add("--scree", metavar="PROGRAM", help="the program; default build/bin/scree or in the path")
    add("--out", metavar="PNG", help="plot; default DIR/sweep.png")
    add("--list", action="store_true", help="print the combinations and run nothing")


def deck_name(deck):
    """Name of the deck, of its folder if it is named scene.nml."""
    stem = os.path.splitext(os.path.basename(deck))[0]
    return os.path.basename(os.path.dirname(os.path.abspath(deck))) if stem == "scene" else stem


def quantity_of(run, name):
    """A number of the summary or of the history of a run, and its unit; None if it did not end."""
    base, _, over = name.partition(".")
    if over and over not in OVER:
        raise unknown("word behind the point", over, OVER, name)
    if name in EXTENTS:
        return Written(run.folder, run.case).value(name), "m"
    ends = run.summary.get("ledger", {}).get("end", {})
    if not over:
        for place in (run.summary, run.summary.get("extremes", {}), run.summary.get("exact", {})):
            if isinstance(place, dict) and isinstance(place.get(base), (int, float)):
                return float(place[base]), summary_unit(base)
    path = os.path.join(run.folder, f"{run.case}_history.csv")
    if os.path.exists(path):
        table = history(path)
        if base in table:
            return float(OVER.get(over, lambda values: values[-1])(table[base])), table.units[base]
        ends = {**ends, **dict.fromkeys(table.order)}
    if not over and isinstance(ends.get(base), (int, float)):
        return float(ends[base]), summary_unit(base)
    known = [key for key, value in run.summary.items() if isinstance(value, (int, float))]
    known += list(run.summary.get("extremes", {}))
    known += [key for key in (*ends, *EXTENTS) if key not in known]
    raise unknown("quantity", base, known, run.folder)


def results(runs, names):
    """Rows of the table and units by name; empty where a run failed, or has no such key of its own."""
    rows, units = [], {}
    keys = dict.fromkeys(key for run in runs for key in run.values)
    for run in runs:
        row = {**dict.fromkeys(keys, ""), **run.values, "exit_code": "" if run.code is None else run.code}
        for name in names:
            row[name] = ""
            if run.code == 0:
                row[name], unit = quantity_of(run, name)
                units[name] = unit or units.get(name, "")
        row["folder"], row["reason"] = run.folder, run.reason
        rows.append(row)
    return rows, units


def earlier(base, deck, program, runs):
    """Finished runs of earlier sweeps in this folder with the same deck and program, and how many
    there are of others."""
    found, others, version = [], 0, version_of(program)
    known = {run.folder for run in runs}
    for name in sorted(os.listdir(base)):
        folder = os.path.join(base, name)
        stamp = read_stamp(folder)
        if folder in known or not stamp:
            continue
        run = Run(stamp["values"], folder, f"{deck_name(deck)}_{name}", code=0, kept=True)
        if is_done(run, stamp_of(run, deck, version)):
            found.append(run)
        else:
            others += 1
    return found, others


def write_table(path, rows, units):
    """The table, units in the heading."""
    with open(path + ".part", "w", newline="", encoding="utf-8") as handle:
        writer = csv.writer(handle)
        writer.writerow([f"{key} [{units[key]}]" if units.get(key, "1") not in ("", "1") else key
                         for key in rows[0]])
        writer.writerows([f"{value:.9g}" if isinstance(value, float) else value
                          for value in row.values()] for row in rows)
    os.replace(path + ".part", path)


def number(text):
    """A number from the text of a deck, or None."""
    try:
        return float(text.lower().replace("d", "e"))
    except ValueError:
        return None


def picture(rows, keys, names, units, title):
    """A panel for each quantity: against the first key with several values, a line for each value of the others."""
    plot = look.pyplot()
    first, *rest = [key for key in keys if len(keys[key]) > 1] or list(keys)[:1]
    columns = min(2, len(names))
    lines = (len(names) + columns - 1) // columns
    figure, grid = plot.subplots(lines, columns, figsize=(5.2 * columns + 0.4, 3.4 * lines + 0.5),
                                 squeeze=False, layout="constrained")
    places = [number(value) for value in keys[first]]
    numeric = None not in places
    groups = {}
    for row in rows:
        if row["exit_code"] == 0:
            label = ", ".join(f"{short(key)} = {row[key]}" for key in rest)
            groups.setdefault(label, []).append(row)
    cells = list(grid.ravel())
    for axes, name in zip(cells, names):
        size = max((abs(row[name]) for row in rows if row["exit_code"] == 0), default=0.0)
        factor, unit = look.label_unit(size, units.get(name) or "1")
        for tint, (label, part) in enumerate(groups.items()):
            across = [number(row[first]) if numeric else keys[first].index(row[first])
                      for row in part]
            order = np.argsort(across)
            up = factor * np.array([row[name] for row in part])
            axes.plot(np.array(across)[order], up[order], "o-", label=label, linewidth=1.6,
                      color=look.COLOURS[tint % len(look.COLOURS)], markersize=5)
        if not numeric:
            axes.set_xticks(range(len(places)), keys[first])
        elif min(places) > 0.0 and max(places) / min(places) > 20.0:
            axes.set_xscale("log")
        axes.set_xlabel(first)
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


def tell(run):
    """A line for a run that ended."""
    values = ", ".join(f"{key} = {value}" for key, value in run.values.items())
    if run.code == 0:
        print(f"{'there' if run.kept else 'done '}  {values}", flush=True)
    elif run.code is not None:
        print(f"FAILED {values}: exit code {run.code}, {run.reason}", flush=True)


def check_arguments(arguments):
    """Quantities and keys, with what the parser cannot check."""
    if any(given is not None and given < 1 for given in (arguments.jobs, arguments.threads)):
        raise PostError("--jobs and --threads must be above 0", EXIT_USAGE)
    names = [name.strip() for name in arguments.take.split(",") if name.strip()]
    if not names:
        raise PostError("--take names no quantity", EXIT_USAGE)
    for name in names:
        over = name.partition(".")[2]
        if over and over not in OVER:
            raise unknown("word behind the point", over, OVER, f"--take {name}")
    return names, settings(arguments.values)


def run(arguments):
    """Run what is not there yet, then table and plot."""
    names, keys = check_arguments(arguments)
    deck = readable(arguments.deck)
    base = os.path.abspath(arguments.outdir or os.path.join("out", deck_name(deck) + "_sweep"))
    runs = combinations(keys, base, deck_name(deck))
    if arguments.list:
        for one in runs:
            print(f"{one.folder}: " + ", ".join(f"{key} = {v}" for key, v in one.values.items()))
        return 0
    program = find_program(arguments.scree)
    threads = arguments.threads or threads_of_a_run()
    jobs = arguments.jobs or jobs_for(threads)
    try:
        os.makedirs(base, exist_ok=True)
    except OSError as error:
        raise PostError(f"cannot make {base}: {error.strerror or error}") from error
    out = arguments.out or os.path.join(base, "sweep.png")
    look.check_picture(out)

    def ended(one):
        tell(one)
        if one.code == 0:                                # a wrong name is told before the last run
            results([one], names)

    Study(program, deck, threads, arguments.overwrite).all(runs, jobs, ended)
    failed = [one for one in runs if one.code != 0]
    before, others = earlier(base, deck, program, runs)
    rows, units = results(runs + before, names)
    table = os.path.join(base, "sweep.csv")
    write_table(table, rows, units)
    print(f"{len(runs) - len(failed)} of {len(runs)} runs finished\nwrote {table}"
          + (f" with {len(before)} runs of earlier sweeps" if before else ""))
    if others:
        print(f"left out of the table: {others} earlier runs in {base} that failed, or that another deck or "
              "program made")
    if len(failed) < len(runs):
        same = [row for row, one in zip(rows, runs + before) if set(one.values) == set(keys)]
        seen = {key: list(dict.fromkeys(row[key] for row in same)) for key in keys}
        look.save(picture(same, seen, names, units, deck_name(deck)), out, 150)
        print(f"wrote {out}")
    return EXIT_DIFFERENT if failed else 0
