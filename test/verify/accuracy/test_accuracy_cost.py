# SPDX-License-Identifier: BSD-3-Clause
"""The study of accuracy against cost: that it runs, continues after an interruption, and evaluates correctly; and that
its page shows what its rows give.

Would catch: rows that are lost or computed twice after an interruption; costs interpolated between different variants,
or beyond a grid on which the error rises again; a cost of a variant that diverges or fails; a winner whose error bar
overlaps with that of another method; methods with more variants than others; grids that are powers of two of each
other; a problem whose deck the program no longer accepts; a sentence, table or file that differs from the rows. With
artificial numbers the results are known; `--quick` makes nine short runs twice. No run time is checked.
"""
# timeout: 200

import math
import re
import subprocess
import sys

import pytest

import accuracy_cost
import accuracy_evaluation as evaluation
import accuracy_page
import accuracy_problems
import case
import convergence

FOLDER = case.ROOT / "doc/accuracy"


def row(way, cells, error, seconds, again=None, cause="", ppc=2, cfl=0.4):
    """A row of the table."""
    return {"problem": "waves", "way": way, "cells": cells, "ppc": ppc, "cfl": cfl, "error": error,
            "core_seconds": seconds, "core_seconds_again": again or seconds, "cause": cause, "memory_mb": 30.0,
            "updates": 1, "steps": 1, "particles": 1, "commit": "made_up", "machine": "none"}


def line(way, errors, seconds, cells=(8, 12, 18, 28)):
    """Rows of one variant."""
    return [row(way, number, error, time) for number, error, time in zip(cells, errors, seconds)]


def test_cost(sheet):
    """Interpolation along one variant, and cases without a cost."""
    usual = line("ddmp usl", (0.5, 0.05, 0.005, 0.0005), (1.0, 10.0, 1000.0, 1.0e4))
    sheet.near("at an error that was run", evaluation.cost_at(usual, 0.05, 0.0).value, 10.0, 1e-12)
    sheet.near("half a decade more", evaluation.cost_at(usual, 0.05 / math.sqrt(10.0), 0.0).value, 100.0, 1e-12)
    sheet.require(evaluation.cost_at(usual, 1.0e-4, 0.0).state == evaluation.NEVER, "not reached")
    bound = evaluation.cost_at(usual, 0.6, 0.0)
    sheet.require((bound.state, bound.value, bound.low) == (evaluation.AT_MOST, 1.0, 0.0), "the coarsest grid")
    lucky = line("ddmp usl", (0.5, 0.009, 0.02, 0.005), (1.0, 10.0, 100.0, 1000.0))
    sheet.above("a coarse grid that meets the error by chance", evaluation.cost_at(lucky, 0.01, 0.0).value, 100.0)
    rising = line("ddmp usl", (0.05, 0.04, 0.07, 0.09), (1.0, 10.0, 100.0, 1000.0))
    failing = usual[:3] + [row("ddmp usl", 28, math.nan, 5.0, cause="exit code 4")]
    for name, rows, state in (("rising", rising, evaluation.DIVERGES), ("failing", failing, evaluation.FAILS)):
        cost = evaluation.cost_at(rows, 0.1, 0.0)
        sheet.require(cost.state == state and cost.value == math.inf, f"{name}: no cost at an error of a coarse grid")
    # a straight line between variants would cost 3.2 at 10 %
    two = line("gimp usl", (0.3, 0.2, 0.15, 0.12), (1.0, 2.0, 3.0, 4.0))
    two += line("gimp aflip", (0.9, 0.8, 0.4, 0.05), (1.0, 10.0, 20.0, 40.0))
    sheet.above("nothing is interpolated between variants", evaluation.method_cost(two, "gimp", 0.1).value, 20.0)
    bars = [dict(entry, problem="taylor") for entry in usual]
    sheet.require(evaluation.method_cost(bars, "ddmp", 0.001).state == evaluation.BELOW, "below the reference: no cost")
    other = [row("ddmp usl", 18, 1.0e-4, 1.0e-3, cfl=0.7)]
    sheet.require(evaluation.line_of(usual + other, "ddmp usl") == usual, "a line has one ppc and cfl")


def test_bars(sheet):
    """Error bars, and who wins, ties and loses."""
    value, low, high = evaluation.times(row("ddmp usl", 8, 0.1, 1.0, 1.21), 0.0)
    sheet.near("mean of both times", value, 1.1, 1e-12)
    sheet.near("lower end", low, 1.0, 1e-12)
    sheet.near("upper end", high, 1.21, 1e-12)
    sheet.near("at least the scatter", evaluation.times(row("ddmp usl", 8, 0.1, 1.0), 0.2)[2], math.exp(0.2), 1e-12)
    rows = [row("ddmp usl", 8, 0.1, 1.0, 1.21), row("mpm usl", 8, 0.1, 1.0, 1.0)]
    sheet.near("scatter of two rows", evaluation.scatter(rows), 0.5 * math.log(1.21) / math.sqrt(2.0), 1e-12)
    cost = {"ddmp": evaluation.Cost(evaluation.REACHED, "ddmp usl", 1.0, 0.9, 1.1),
            "gimp": evaluation.Cost(evaluation.REACHED, "gimp usl", 1.15, 1.05, 1.25),
            "cpdi": evaluation.Cost(evaluation.REACHED, "cpdi usl", 1.4, 1.3, 1.5),
            "mpm": evaluation.Cost(evaluation.DIVERGES)}
    sheet.require(evaluation.ranking(cost) == (["ddmp", "gimp"], ["cpdi"]), "overlapping bars tie")
    sheet.require(evaluation.standing(cost, "ddmp") == ("ties", "gimp"), "ddmp ties")
    del cost["gimp"]
    sheet.require(evaluation.standing(cost, "ddmp") == ("wins", "cpdi"), "ddmp wins")
    cost["cubic"] = evaluation.Cost(evaluation.REACHED, "cubic usl", 0.5, 0.4, 0.6)
    sheet.require(evaluation.standing(cost, "ddmp") == ("loses", "cubic"), "ddmp loses")
    sheet.require(evaluation.standing({"ddmp": cost["mpm"], "mpm": cost["mpm"]}, "ddmp") == ("nobody", None), "nobody")
    cost["ddmp control"] = evaluation.Cost(evaluation.REACHED, "ddmp control usl", 0.1, 0.1, 0.1)
    sheet.require(evaluation.standing(cost, "ddmp")[1] == "cubic", "other quadratures of ddmp are no rivals")


def test_plan(options, sheet):
    """Every method has the same variants on the same grids; the program accepts the decks."""
    for name, problem in accuracy_problems.PROBLEMS.items():
        plan = problem.plan()
        convergence.check(problem.cells)
        sheet.require(len(plan) == len(set(plan)), f"{name}: no run is planned twice")
        sets = [{(accuracy_problems.update_of(way), setting) for way, setting in plan
                 if accuracy_problems.method_of(way) == method} for method in problem.methods]
        sheet.require(all(other == sets[0] for other in sets), f"{name}: the same variants and grids for all methods")
        sheet.require(len(sets[0]) >= 4 * len(problem.cells), f"{name}: all variants")
        for way in problem.ways[::5]:
            run = case.Case(options, "deck", problem.deck(way, plan[0][1])).run("--check", "-q", expect=None)
            sheet.require(run.code == 0, f"{name}, {way}: {run.output[-500:]}")


def test_quick(options, sheet):
    """The study itself, small."""
    answer = subprocess.run([sys.executable, case.ROOT / "scripts/accuracy_cost.py", "--quick", "--scree",
                             options.scree, "--work", options.work / "quick"], text=True, capture_output=True)
    sheet.require(answer.returncode == 0 and "all checks met" in answer.stdout, answer.stdout + answer.stderr)
    made = [entry.split()[0] for entry in answer.stdout.splitlines() if " cells " in entry]
    sheet.require((made.count("new"), made.count("again")) == (9, 9), f"nine runs, each twice: {made}")
    sheet.require(len(accuracy_cost.read(options.work / "quick" / "quick.csv")) == 9, "nine rows")


@pytest.fixture(name="stored", scope="module")
def read_rows():
    """The rows in the repository."""
    return accuracy_cost.read(FOLDER / "accuracy.csv")


def test_stored(sheet, stored):
    """The rows in the repository belong to the study."""
    keys = [accuracy_cost.key_of(entry) for entry in stored]
    sheet.above("stored rows", len(stored), 300)
    sheet.require(len(keys) == len(set(keys)), "no row is stored twice")
    sheet.require({entry["problem"] for entry in stored} <= set(accuracy_problems.PROBLEMS), "of known problems")
    sheet.require({entry["way"] for entry in stored} <= set(accuracy_problems.WAYS), "by known ways")
    sheet.require(all(entry["cause"] or math.isfinite(entry["error"]) for entry in stored), "with an error or a cause")


def test_page(sheet, stored):
    """Pages and table of costs are what the script makes of the rows, and text outside of its blocks has no costs."""
    sheet.require(accuracy_page.costs_text(stored) == (FOLDER / "costs.csv").read_text(encoding="utf-8"), "costs.csv")
    changed = [dict(entry, error=2.0 * entry["error"]) for entry in stored]
    for name, least in (("README.md", 5), ("problems.md", len(accuracy_problems.PROBLEMS))):
        page = (FOLDER / name).read_text(encoding="utf-8")
        sheet.require(accuracy_page.fill(page, stored) == page, f"{name}: run scripts/accuracy_cost.py --draw")
        sheet.require(len(accuracy_page.BLOCK.findall(page)) >= least, f"{name} has its blocks")
        sheet.require(accuracy_page.fill(page, changed) != page, f"{name} depends on the rows")
        words = accuracy_page.BLOCK.sub("", page)
        sheet.require(not re.search(r"\d core-second|as much as", words), f"{name}: costs are only in the blocks")
