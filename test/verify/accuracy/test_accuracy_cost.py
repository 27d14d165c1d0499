# SPDX-License-Identifier: BSD-3-Clause
"""The study of accuracy against cost: that it runs, continues after an interruption, and evaluates correctly.

Would catch: rows that are lost or computed twice after an interruption, a Pareto front that contains a dominated run or
lacks a good one, failed runs that count as good, costs between two runs that are not on the line through them, a cost
model that an outlier distorts, a problem whose deck the program no longer accepts. With artificial numbers the results
are known; `--quick` makes six short runs. No run time is checked.
"""
# timeout: 200

import math
import subprocess
import sys

import accuracy_cost
import accuracy_front
import accuracy_problems
import case


def row(way, error, seconds, cause="", steps=100, updates=1000, ppc=2):
    """A row of the table."""
    return {"problem": "made_up", "way": way, "error": error, "core_seconds": seconds, "cause": cause, "cells": 8,
            "ppc": ppc, "cfl": 0.4, "steps": steps, "updates": updates}


def test_front(sheet):
    """Best rows and interpolation between them."""
    best = [row("a", 0.5, 1.0), row("b", 0.05, 10.0), row("a", 0.005, 1000.0)]
    beaten = [row("b", 0.6, 2.0), row("a", 0.05, 11.0), row("b", 0.06, 10.0), row("a", 0.004, 5.0, "exit code 4"),
              row("b", 3.0, 0.1), row("b", math.nan, 0.1, "not a number")]
    rows = beaten[:3] + best[::-1] + beaten[3:]
    sheet.require(accuracy_front.front(rows) == best, "the front is what nothing beats, by cost")
    sheet.near("cost at an error that was run", accuracy_front.cost_at(rows, 0.05), 10.0, 1e-12)
    sheet.near("cost at half a decade more", accuracy_front.cost_at(rows, 0.05 / math.sqrt(10.0)), 100.0, 1e-12)
    sheet.require(accuracy_front.cost_at(rows, 0.001) == math.inf, "what nobody reaches costs without end")
    sheet.near("cost of the coarsest error", accuracy_front.cost_at(rows, 0.9), 1.0, 1e-12)
    sheet.require(accuracy_front.cheapest(rows, 0.01) is best[2], "the cheapest run below 1 %")
    sheet.require(accuracy_front.cheapest(rows, 1.0e-4) is None, "no run below 0.01 %")
    fine = [dict(row("a", 3.0 * cells ** -1.7, 1.0), cells=cells) for cells in (8, 16, 64)]
    sheet.near("order of three rows", accuracy_front.order(fine), 1.7, 1e-9)


def test_model(sheet):
    """Steps and updates have the correct cost in the model, in spite of outliers."""
    rows = [row(way, 0.1, steps * 2.0e-5 + updates * price, steps=steps, updates=updates)
            for way, price in (("a", 3.0e-7), ("b", 5.0e-7)) for steps, updates in
            ((10, 1000), (100, 5000), (200, 90000), (400, 500000), (800, 10000))]
    rows[3]["core_seconds"] *= 3.0
    accuracy_front.add_model(rows)
    for line in (rows[3], rows[4], rows[8]):
        right = line["steps"] * 2.0e-5 + line["updates"] * (3.0e-7 if line["way"] == "a" else 5.0e-7)
        sheet.near(f"model of {line['updates']} updates", line["model_seconds"], right, 0.01)


def test_decks(options, sheet):
    """The program accepts the deck of every problem and method."""
    decks = 0
    for name, problem in accuracy_problems.PROBLEMS.items():
        plan = problem.plan()
        sheet.require(len(plan) == len(set(plan)), f"{name}: no run is planned twice")
        sheet.require({way for way, _ in plan} == set(problem.ways), f"{name}: all ways are planned")
        for way in problem.ways[::4]:
            run = case.Case(options, "deck", problem.deck(way, plan[0][1])).run("--check", "-q", expect=None)
            sheet.require(run.code == 0, f"{name}, {way}: {run.output[-500:]}")
            decks += 1
    sheet.above("decks that were checked", decks, 25)


def test_quick(options, sheet):
    """The study itself, small."""
    answer = subprocess.run([sys.executable, case.ROOT / "scripts/accuracy_cost.py", "--quick", "--scree",
                             options.scree, "--work", options.work / "quick"], text=True, capture_output=True)
    sheet.require(answer.returncode == 0 and "all checks met" in answer.stdout, answer.stdout + answer.stderr)
    lines = [line for line in answer.stdout.splitlines() if " of " in line and "left" in line]
    sheet.require(len(lines) == 6, f"six runs, none twice: {lines}")
    rows = accuracy_cost.read(options.work / "quick" / "quick.csv")
    sheet.require(len(rows) == 6, "six rows")


def test_stored(sheet):
    """The rows in the repository belong to the plan of the study."""
    rows = accuracy_cost.read(accuracy_cost.ROOT / "doc/accuracy/accuracy.csv")
    keys = [accuracy_cost.key_of(line) for line in rows]
    sheet.above("stored rows", len(rows), 300)
    sheet.require(len(keys) == len(set(keys)), "no row is stored twice")
    sheet.require({line["problem"] for line in rows} <= set(accuracy_problems.PROBLEMS), "of known problems")
    sheet.require({line["way"] for line in rows} <= set(accuracy_problems.WAYS), "by known ways")
    sheet.require(all(line["cause"] or math.isfinite(line["error"]) for line in rows), "with an error or a cause")
