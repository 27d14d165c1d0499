#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Measure error and cost of all methods on problems with known solutions.

    build/venv/bin/python scripts/accuracy_cost.py --work /tmp/accuracy          # all runs, pictures and page
    build/venv/bin/python scripts/accuracy_cost.py --work /tmp/accuracy --only waves
    build/venv/bin/python scripts/accuracy_cost.py --work /tmp/accuracy --draw   # pictures and page only
    build/venv/bin/python scripts/accuracy_cost.py --work /tmp/accuracy --quick  # small study with checks

The list of runs is in accuracy_problems.py. Runs are made one after the other, each twice. A row is written to
doc/accuracy/accuracy.csv (--csv) when its run has ended, and existing rows are not computed again, so an interrupted
study can be continued. Cost is the processor time of the steps [core-seconds], without outputs, ledger and start.
costs.csv and the pictures are written beside the CSV file, and the numbers of the pages there are written anew from
the rows (accuracy_page.py).
"""
import argparse
import csv
import math
import os
import platform
import re
import resource
import subprocess
import sys
import time
from pathlib import Path

sys.dont_write_bytecode = True
sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "python/src"))

import accuracy_evaluation  # noqa: E402
import accuracy_page  # noqa: E402
import accuracy_problems  # noqa: E402
import case  # noqa: E402
import scree_post  # noqa: E402
from accuracy_problems import PROBLEMS, ROOT, Setting  # noqa: E402

NUMBERS = {"cells": int, "ppc": int, "cfl": float, "error": float, "core_seconds": float,
           "core_seconds_again": float, "updates": int, "steps": int, "particles": int, "memory_mb": float}
COLUMNS = ("problem", "way", *NUMBERS, "cause", "commit", "machine")
TIMEOUT = 240                            # time limit of a run [s]


def machine():
    """The class of this machine: processor and number of cores, no names."""
    model = platform.machine()
    try:
        text = Path("/proc/cpuinfo").read_text(encoding="ascii", errors="replace")
        found = re.search(r"^model name\s*: (.*)$", text, re.M)
        model = found.group(1).strip() if found else model
    except OSError:
        pass
    return f"{model}, {os.cpu_count()} cores"


def processor():
    """Processor time of all child processes that have ended [s]."""
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


def cause_of(run):
    """The cause of a failure in a few words."""
    text = run.output
    for pattern, words in (("turned inside out|is inverted", "particle inverted"),
                           ("dt_collapse", "step collapsed"), ("dt_min", "step below dt_min"),
                           ("volume_ratio", "volume out of bounds"), ("speed_max", "speed too high"),
                           ("NaN|no number|none", "not a number"), ("left|leaves", "left the grid")):
        if re.search(pattern, text):
            return words
    return f"exit code {run.code}"


def once(options, problem, way, setting, name):
    """One run: its case, the cause if it failed, and the processor time of the steps [s]."""
    run = case.Case(options, name, problem.deck(way, setting))
    before = processor()
    try:
        run.run("-q", expect=None, timeout=TIMEOUT)
    except subprocess.TimeoutExpired:
        return run, f"longer than {TIMEOUT} s", processor() - before
    if not run.path(".summary.json").exists():
        raise scree_post.ScreeError(f"{run.deck} does not run:\n{run.output[-2000:]}")
    return run, cause_of(run) if run.code else "", run.summary["processor_s"]


def measure(options, name, way, setting):
    """The row of a combination of problem, method and setting, without the second time."""
    problem = PROBLEMS[name]
    run, cause, spent = once(options, problem, way, setting, f"accuracy_{name}")
    row = dict(problem=name, way=way, cells=setting.cells, ppc=setting.ppc, cfl=setting.cfl,
               error=math.nan, core_seconds=spent, core_seconds_again=math.nan, updates=0,
               steps=0, particles=0, memory_mb=math.nan, cause=cause, commit=options.commit,
               machine=options.machine)
    if run.path(".summary.json").exists():
        seen = run.summary
        row.update(steps=seen["steps"], particles=seen["particles"], updates=seen["particle_updates"],
                   memory_mb=seen["rank_counts"]["memory_peak_bytes"]["max"] / 1.0e6)
    if not cause:
        try:
            row["error"] = problem.error(run, setting)
        except (AssertionError, ValueError, KeyError, IndexError) as error:
            row["cause"] = "no lattice any more" if "lattice" in str(error) else "not a number"
        if not row["cause"] and not math.isfinite(row["error"]):
            row["cause"] = "not a number"
    return row


def repeat(options, row):
    """The row with the time of a second run, which must make the same steps."""
    setting = Setting(row["cells"], row["ppc"], row["cfl"])
    run, _, spent = once(options, PROBLEMS[row["problem"]], row["way"], setting, "accuracy_again")
    if run.summary["steps"] != row["steps"]:
        raise scree_post.ScreeError(f"{key_of(row)}: {run.summary['steps']} steps, not {row['steps']} as before")
    row["core_seconds_again"] = spent


def read(path):
    """The rows of a file; no rows if the file does not exist."""
    if not path.exists():
        return []
    with open(path, newline="", encoding="utf-8") as file:
        rows = [dict(row) for row in csv.DictReader(file)]
    for row in rows:
        row.update({key: kind(row[key]) for key, kind in NUMBERS.items()})
    return rows


def write(path, rows):
    """Write all rows; the old file is replaced at the end."""
    path.parent.mkdir(parents=True, exist_ok=True)
    order = {way: number for number, way in enumerate(accuracy_problems.WAYS)}
    rows = sorted(rows, key=lambda row: (list(PROBLEMS).index(row["problem"]), order[row["way"]], row["ppc"],
                                         row["cfl"], row["cells"]))
    fresh = path.with_suffix(".new")
    with open(fresh, "w", newline="", encoding="utf-8") as file:
        writer = csv.DictWriter(file, COLUMNS, lineterminator="\n")
        writer.writeheader()
        for row in rows:
            short = {key: f"{value:.5g}" for key, value in row.items() if isinstance(value, float)}
            writer.writerow({**row, **short})
    fresh.replace(path)


def key_of(row):
    """The values that identify a run."""
    return row["problem"], row["way"], row["cells"], row["ppc"], row["cfl"]


def study(options, plan):
    """Make the runs of a plan that are not in the file, problem by problem: first the runs that are new, then each a
    second time for its processor time, so that a disturbance of the machine seldom affects both. Stops when the time
    is over."""
    end = time.time() + 60.0 * options.minutes
    rows = read(options.csv)
    for name in dict.fromkeys(entry[0] for entry in plan):
        entries = [entry for entry in plan if entry[0] == name]
        done = {key_of(row) for row in rows}
        for entry in entries:
            key = (name, entry[1], entry[2].cells, entry[2].ppc, entry[2].cfl)
            if key not in done and time.time() < end:
                rows.append(measure(options, *entry))
                write(options.csv, rows)
                report("new", rows[-1])
        for row in rows:
            if row["problem"] == name and not row["cause"] and math.isnan(row["core_seconds_again"]) \
                    and row["commit"] == options.commit and time.time() < end and not options.once:
                repeat(options, row)
                write(options.csv, rows)
                report("again", row)
    missing = len(plan) - len({key_of(row) for row in rows})
    print(f"{missing} runs are missing", flush=True)


def report(kind, row):
    """Print one run."""
    print(f"{kind:<5} {row['problem']:<11} {row['way']:<19}{row['cells']:4d} cells {row['ppc']} ppc "
          f"cfl {row['cfl']:g}  "
          + (row["cause"] or f"error {row['error']:.2e}")
          + f"  {row['core_seconds']:.3g} s  {row['core_seconds_again']:.3g} s", flush=True)


def whole_plan(only):
    """All runs, problem by problem."""
    return [(name, *entry) for name in PROBLEMS if not only or name in only
            for entry in PROBLEMS[name].plan()]


def present(options):
    """Draw the pictures; write costs.csv, and the numbers of the pages that exist."""
    rows = read(options.csv)
    if not rows:
        raise scree_post.ScreeError(f"{options.csv} holds no rows")
    folder = options.csv.parent
    for name, problem in PROBLEMS.items():
        chosen = [row for row in rows if row["problem"] == name]
        if accuracy_evaluation.good(chosen):
            accuracy_evaluation.draw(chosen, problem, folder / f"{name}.png")
    (folder / "costs.csv").write_text(accuracy_page.costs_text(rows), encoding="utf-8")
    for page in folder.glob("*.md"):
        page.write_text(accuracy_page.fill(page.read_text(encoding="utf-8"), rows), encoding="utf-8")
    return rows


def reference(options):
    """Run the finest Taylor bars, whose sizes are the constant in accuracy_problems.py."""
    problem = PROBLEMS["taylor"]
    for way in ("ddmp usl", "quadratic usl"):
        run, cause, wall = once(options, problem, way, Setting(48, 2, 0.4), "reference")
        print(way, cause or accuracy_problems.bar_sizes(run), f"{wall:.1f} s", flush=True)


def quick(options):
    """A study of 20 s in the work folder, interrupted once, with checks of rows, repeats and orders. Returns the number
    of faults."""
    options.csv = options.work / "quick.csv"
    options.csv.unlink(missing_ok=True)
    plan = [("waves", way, Setting(cells, 2, 0.4)) for way in ("ddmp usl", "ddmp control usl", "mpm musl")
            for cells in (8, 12, 18)]
    study(options, plan[:4])
    study(options, plan)
    rows = present(options)
    faults = []
    if sorted(map(key_of, rows)) != sorted((n, w, s.cells, s.ppc, s.cfl) for n, w, s in plan):
        faults.append("each run of the plan has one row")
    for way, low, high in (("ddmp usl", 1.8, 2.2), ("ddmp control usl", 1.8, 2.2), ("mpm musl", -2.0, 1.0)):
        seen = accuracy_evaluation.order([row for row in rows if row["way"] == way])
        if not low <= seen <= high:
            faults.append(f"order of {way} is {seen:.2f}, not from {low} to {high}")
    if not (options.work / "waves.png").exists():
        faults.append("the picture is drawn")
    for row in rows:
        if not (row["core_seconds"] > 0.0 and row["core_seconds_again"] > 0.0 and row["updates"]
                and 5.0 < row["memory_mb"] < 1000.0):
            faults.append(f"{key_of(row)} has two times, updates and memory")
    print("\n".join(f"FAILED   {text}" for text in faults) or "all checks met")
    return len(faults)


def commit_of(program):
    """The commit that the program was made from."""
    text = subprocess.run([program, "--version"], capture_output=True, text=True, check=True).stdout
    found = re.search(r"git (?:\S*-g)?(\w+)", text)
    return found.group(1) if found else "unknown"


def main():
    """Make the missing runs, draw the pictures and write the tables."""
    parser = argparse.ArgumentParser(description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--scree", type=Path, default=ROOT / "build/bin/scree")
    parser.add_argument("--work", type=Path, required=True, help="folder for the runs")
    parser.add_argument("--csv", type=Path, default=ROOT / "doc/accuracy/accuracy.csv")
    parser.add_argument("--only", nargs="+", choices=list(PROBLEMS), help="problems")
    parser.add_argument("--minutes", type=float, default=math.inf, help="start no run after this time")
    parser.add_argument("--once", action="store_true", help="do not repeat runs for their time")
    parser.add_argument("--draw", action="store_true", help="draw existing results without runs")
    parser.add_argument("--study-only", action="store_true", help="make runs without drawing")
    parser.add_argument("--quick", action="store_true", help="run a small study with checks")
    parser.add_argument("--reference", action="store_true", help="run the finest Taylor bars")
    options = parser.parse_args()
    options.scree, options.work = options.scree.resolve(), options.work.resolve()
    if not options.scree.is_file():
        raise scree_post.ScreeError(f"there is no program {options.scree}", scree_post.EXIT_USAGE)
    os.environ["OMP_NUM_THREADS"] = "1"
    os.environ["OMPI_MCA_ess_singleton_isolated"] = "1"  # no helper processes of MPI
    options.commit, options.machine = commit_of(options.scree), machine()
    if options.reference:
        reference(options)
    elif options.quick:
        return 1 if quick(options) else 0
    else:
        if not options.draw:
            study(options, whole_plan(options.only))
        if not options.study_only:
            present(options)
    return 0


if __name__ == "__main__":
    scree_post.run(main, "accuracy_cost")
