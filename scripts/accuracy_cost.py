#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Measure error and cost of all methods on problems with known solutions.

    build/venv/bin/python scripts/accuracy_cost.py --work /tmp/accuracy          # all runs and pictures
    build/venv/bin/python scripts/accuracy_cost.py --work /tmp/accuracy --only waves
    build/venv/bin/python scripts/accuracy_cost.py --work /tmp/accuracy --draw   # pictures only
    build/venv/bin/python scripts/accuracy_cost.py --work /tmp/accuracy --quick  # small study with checks

The list of runs is in accuracy_problems.py. Runs are made one after the other. A row is written to
doc/accuracy/accuracy.csv (--csv) when its run has ended, and existing rows are not computed again, so
an interrupted study can be continued. Cost is the smallest processor time of the steps of several runs
[core-seconds], without outputs, ledger and start. Pictures and tables are written beside the CSV file.
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

import accuracy_front                                    # noqa: E402
import accuracy_problems                                 # noqa: E402
import scree_post                                        # noqa: E402
from accuracy_problems import PROBLEMS, ROOT, Setting    # noqa: E402

import case                                              # noqa: E402

NUMBERS = {"cells": int, "ppc": int, "cfl": float, "error": float, "core_seconds": float,
           "wall_seconds": float, "updates": int, "steps": int, "particles": int, "repeats": int}
COLUMNS = ("problem", "way", *NUMBERS, "cause", "commit", "machine")
ASIDE = ("output", "checkpoint", "ledger, history")      # timers that are no part of the steps
MOST = 2                                 # a run is repeated so often, or until all of them took
SHORT = 0.08                             # a run is repeated until its runs have taken this together [core-seconds]
TIMEOUT = 900                            # time limit of a run [s]


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
    """One run: its case, the cause if it failed, processor time and wall time of the steps [s]."""
    run = case.Case(options, name, problem.deck(way, setting))
    before = processor()
    try:
        run.run("-q", expect=None, timeout=TIMEOUT)
    except subprocess.TimeoutExpired:
        return run, f"longer than {TIMEOUT} s", processor() - before, math.nan
    if not run.path(".summary.json").exists():
        raise scree_post.ScreeError(f"{run.deck} does not run:\n{run.output[-2000:]}")
    timers = run.summary["timers"]
    wall = sum(entry["avg"] for name, entry in timers.items() if name not in ASIDE)
    return run, cause_of(run) if run.code else "", run.summary["processor_s"], wall


def measure(options, name, way, setting):
    """The row of a combination of problem, method and setting. It is run up to MOST times, and the least processor time
    counts, because other processes on the machine can only increase it."""
    problem, spents, walls = PROBLEMS[name], [], []
    while True:
        run, cause, spent, wall = once(options, problem, way, setting, f"accuracy_{name}")
        spents.append(spent)
        walls.append(wall)
        if cause or len(spents) >= MOST or sum(spents) > SHORT:
            break
    row = dict(problem=name, way=way, cells=setting.cells, ppc=setting.ppc, cfl=setting.cfl,
               error=math.nan, core_seconds=min(spents), wall_seconds=min(walls), updates=0,
               steps=0, particles=0, repeats=len(spents), cause=cause, commit=options.commit,
               machine=options.machine)
    if run.path(".summary.json").exists():
        seen = run.summary
        row.update(steps=seen["steps"], particles=seen["particles"],
                   updates=seen["particle_updates"])
    if not cause:
        try:
            row["error"] = problem.error(run, setting)
        except (AssertionError, ValueError, KeyError, IndexError) as error:
            row["cause"] = "no lattice any more" if "lattice" in str(error) else "not a number"
        if not row["cause"] and not math.isfinite(row["error"]):
            row["cause"] = "not a number"
    return row


def read(path):
    """The rows of a file; no rows if the file does not exist."""
    if not path.exists():
        return []
    with open(path, newline="", encoding="utf-8") as file:
        rows = [dict(row) for row in csv.DictReader(file)]
    for row in rows:
        row.update({key: kind(row[key]) for key, kind in NUMBERS.items()})
    return rows


def append(path, row):
    """Append one row to the file; a new file begins with a heading."""
    fresh = not path.exists()
    with open(path, "a", newline="", encoding="utf-8") as file:
        writer = csv.DictWriter(file, COLUMNS, lineterminator="\n")
        if fresh:
            writer.writeheader()
        short = {key: f"{value:.5g}" for key, value in row.items() if isinstance(value, float)}
        writer.writerow({**row, **short})


def key_of(row):
    """The values that identify a run."""
    return row["problem"], row["way"], row["cells"], row["ppc"], row["cfl"]


def study(options, plan):
    """Make the runs of a plan that are not in the file."""
    done = {key_of(row) for row in read(options.csv)}
    wanted = [(name, way, setting) for name, way, setting in plan
              if (name, way, setting.cells, setting.ppc, setting.cfl) not in done]
    options.csv.parent.mkdir(parents=True, exist_ok=True)
    weight = {entry: entry[2].cells ** (PROBLEMS[entry[0]].dimensions + 1)
              * entry[2].ppc ** PROBLEMS[entry[0]].dimensions / entry[2].cfl for entry in wanted}
    seen = []
    for count, entry in enumerate(wanted, 1):
        name, way, setting = entry
        before = time.time()
        row = measure(options, *entry)
        append(options.csv, row)
        seen.append((name, weight[entry], time.time() - before))
        left = time_left(wanted[count:], weight, seen)
        print(f"{count:4d} of {len(wanted)}  left {left / 60.0:5.1f} min  {name:<11} {way:<19}"
              f"{setting.cells:4d} cells {setting.ppc} ppc cfl {setting.cfl:g}  "
              + (row["cause"] or f"error {row['error']:.2e}")
              + f"  {row['core_seconds']:.3g} s", flush=True)


def time_left(rest, weight, seen):
    """Estimated duration of the remaining runs [s]. In a problem of which a run has ended: the time of the fastest run,
    plus a part in proportion to the work with the rate observed in this problem. In other problems: the mean time of
    all runs so far."""
    base = min(took for _, _, took in seen)
    mean = sum(took for _, _, took in seen) / len(seen)
    rate = {}
    for name in {name for name, _, _ in seen}:
        more = sum(took - base for other, _, took in seen if other == name)
        rate[name] = more / sum(work for other, work, _ in seen if other == name)
    return sum(base + rate[entry[0]] * weight[entry] if entry[0] in rate else mean
               for entry in rest)


def whole_plan(only):
    """All runs, problem by problem."""
    return [(name, *entry) for name in PROBLEMS if not only or name in only
            for entry in PROBLEMS[name].plan()]


def present(options):
    """Draw the pictures, and write the tables into the page if it exists."""
    rows = read(options.csv)
    if not rows:
        raise scree_post.ScreeError(f"{options.csv} holds no rows")
    accuracy_front.add_model(rows)
    page = options.csv.parent / "README.md"
    text = page.read_text(encoding="utf-8") if page.exists() else ""
    for name, problem in PROBLEMS.items():
        chosen = [row for row in rows if row["problem"] == name]
        if accuracy_front.good(chosen):
            accuracy_front.draw(chosen, problem, options.csv.parent / f"{name}.png")
            table = accuracy_front.tables(chosen)
            text = re.sub(rf"(<!-- table {name} -->\n).*?(<!-- end -->)",
                          lambda found, table=table: found[1] + table + found[2], text, flags=re.S)
            print(f"\n{problem.title}\n\n{table}", flush=True)
    if page.exists():
        page.write_text(text, encoding="utf-8")
    return rows


def reference(options):
    """Run the finest Taylor bars, whose sizes are the constant in accuracy_problems.py."""
    problem = PROBLEMS["taylor"]
    for way in ("ddmp", "quadratic usl"):
        run, cause, wall, _ = once(options, problem, way, Setting(24, 2, 0.4), "reference")
        print(way, cause or accuracy_problems.bar_sizes(run), f"{wall:.1f} s", flush=True)


def quick(options):
    """A study of 20 s in the work folder, made twice, with checks of rows, Pareto front and orders. Returns the number
    of faults."""
    options.csv = options.work / "quick.csv"
    options.csv.unlink(missing_ok=True)
    plan = [("waves", way, Setting(cells, 2, 0.4)) for way in ("ddmp", "ddmp control", "mpm")
            for cells in (8, 16)]
    study(options, plan[:4])
    study(options, plan)
    rows = present(options)
    faults = []
    if sorted(map(key_of, rows)) != sorted((n, w, s.cells, s.ppc, s.cfl) for n, w, s in plan):
        faults.append("each run of the plan has one row")
    best = accuracy_front.front(rows)
    for row in accuracy_front.good(rows):
        beaten = any(other["error"] < row["error"] and other["core_seconds"] < row["core_seconds"]
                     for other in rows if not other["cause"])
        if beaten == (row in best):
            faults.append(f"{key_of(row)} is on the front or beaten")
    for way, low, high in (("ddmp", 1.8, 2.2), ("ddmp control", 1.8, 2.2), ("mpm", -2.0, 1.0)):
        seen = accuracy_front.order([row for row in rows if row["way"] == way])
        if not low <= seen <= high:
            faults.append(f"order of {way} is {seen:.2f}, not from {low} to {high}")
    if not (options.work / "waves.png").exists():
        faults.append("the picture is drawn")
    for row in rows:
        if not 0.0 < row["core_seconds"] <= 2.0 * row["wall_seconds"] or not row["updates"]:
            faults.append(f"{key_of(row)} has times and updates")
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
    parser.add_argument("--draw", action="store_true", help="draw existing results without runs")
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
        present(options)
    return 0


if __name__ == "__main__":
    scree_post.run(main, "accuracy_cost")
