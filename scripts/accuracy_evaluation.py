# SPDX-License-Identifier: BSD-3-Clause
"""Evaluate runs by error and cost: cost of a given error, who wins, ties and loses, and the pictures.

A row is a dict of numbers and words as accuracy_cost.py writes them; a row with a cause has failed. A *line* is the
rows of one variant of a method with the usual ppc and cfl, from coarse to fine. Costs are interpolated along a line
only, never between variants. Cost is the processor time of the steps [core-seconds], the geometric mean of two runs.
"""
import math
from dataclasses import dataclass

import accuracy_problems
import scree_post
from accuracy_problems import PROBLEMS, method_of, update_of

TARGETS = (0.1, 0.01, 0.001)
ASSUMED = 0.1                            # scatter of a problem whose runs were made once
FAILED = 1.0                             # rows with an error of 100 % or more count as failed
COLOURS = {"ddmp": "#b3311b", "ddmp control": "#e08214", "mpm": "#8a6d3b", "gimp": "#2f7d3b", "cpgimp": "#58a55c",
           "quadratic": "#1f5a93", "cubic": "#6aa3d5", "cpdi": "#6a4098"}
REACHED, AT_MOST, NEVER, DIVERGES, FAILS = "reached", "at most", "never", "diverges", "fails"
BELOW = "below the accuracy of the reference"
REFERENCE = {"taylor": 0.002}            # least error that is significant, by problem


@dataclass(frozen=True)
class Cost:
    """Cost of an error with its bar; `state` says whether there is one."""

    state: str
    way: str = ""
    value: float = math.inf              # [core-seconds]
    low: float = math.inf                # ends of the error bar
    high: float = math.inf

    @property
    def known(self):
        """Is there a cost?"""
        return self.state in (REACHED, AT_MOST)


def line_of(rows, way):
    """The rows of a variant with the usual ppc and cfl of its problem, from coarse to fine."""
    chosen = []
    for row in rows:
        problem = PROBLEMS[row["problem"]]
        if row["way"] == way and (row["ppc"], row["cfl"]) == (problem.ppc[0], problem.cfl[0]):
            chosen.append(row)
    return sorted(chosen, key=lambda row: row["cells"])


def good(rows):
    """The rows of runs that ended with an error below 100 %."""
    return [row for row in rows if not row["cause"] and row["error"] < FAILED]


def order(rows):
    """Order of convergence, by least squares, of rows that differ only in their cell size."""
    pairs = [(math.log(row["cells"]), math.log(row["error"])) for row in good(rows)]
    if len(pairs) < 2:
        return math.nan
    x, y = (sum(column) / len(pairs) for column in zip(*pairs))
    return -sum((a - x) * (b - y) for a, b in pairs) / sum((a - x) ** 2 for a, _ in pairs)


def verdict(line):
    """FAILS if a run failed, DIVERGES if the error does not fall over the three finest grids by least squares, REACHED
    if the line converges."""
    if len(good(line)) < len(line) or len(line) < 3:
        return FAILS
    return REACHED if order(line[-3:]) > 0.0 else DIVERGES


def scatter(rows):
    """Root mean square, over the rows of a problem, of half the logarithm of the ratio of both times; ASSUMED if no row
    has two."""
    halves = [0.5 * math.log(row["core_seconds_again"] / row["core_seconds"]) for row in rows
              if row["core_seconds_again"] > 0.0 and row["core_seconds"] > 0.0]
    return math.sqrt(sum(half ** 2 for half in halves) / len(halves)) if halves else ASSUMED


def times(row, spread):
    """Cost of a row and the ends of its bar: both times, but at least the scatter of its problem on either side."""
    again = row["core_seconds_again"]
    if not again > 0.0:
        again = row["core_seconds"]
    value = math.sqrt(row["core_seconds"] * again)
    half = math.exp(max(0.5 * abs(math.log(again / row["core_seconds"])), spread))
    return value, value / half, value * half


def cost_at(line, error, spread):
    """Cost at which a line reaches an error for good, so that no finer grid exceeds it: interpolated between two grids,
    linearly in the logarithms of error and cost. If the coarsest grid is fine enough, its cost is an upper bound."""
    state = verdict(line)
    if state != REACHED:
        return Cost(state)
    way = line[0]["way"]
    above = [number for number, row in enumerate(line) if row["error"] > error]
    if not above:
        value, _, high = times(line[0], spread)
        return Cost(AT_MOST, way, value, 0.0, high)
    if above[-1] == len(line) - 1:
        return Cost(NEVER)
    before, after = line[above[-1]:above[-1] + 2]
    share = math.log(before["error"] / error) / math.log(before["error"] / after["error"])
    return Cost(REACHED, way, *(a * (b / a) ** share for a, b in zip(times(before, spread), times(after, spread))))


def least_error(rows):
    """Least error of a problem that is significant."""
    return REFERENCE.get(rows[0]["problem"], 0.0)


def method_cost(rows, method, error):
    """Cost of the variant of a method that reaches an error at the lowest cost. Without one: NEVER if a variant
    converges, else DIVERGES or FAILS."""
    if error < least_error(rows):
        return Cost(BELOW)
    spread = scatter(rows)
    problem = PROBLEMS[rows[0]["problem"]]
    costs = [cost_at(line, error, spread) for update in problem.updates
             if (line := line_of(rows, f"{method} {update}"))]
    known = [cost for cost in costs if cost.known]
    if known:
        return min(known, key=lambda cost: cost.value)
    states = {cost.state for cost in costs}
    return Cost(next((state for state in (NEVER, DIVERGES, FAILS) if state in states), FAILS))


def ranking(costs):
    """Methods at an error, from a dict of their costs: the one of lowest cost and those whose bars overlap with its
    bar; then the others that reach the error, in ascending order of cost."""
    known = sorted((method for method in costs if costs[method].known), key=lambda method: costs[method].value)
    first = [method for method in known if costs[method].low <= costs[known[0]].high]
    return first, [method for method in known if method not in first]


def standing(costs, method):
    """One method against those that are not DDMP: `wins`, `ties`, `loses`; `open` if a tie is one of upper bounds,
    because coarsest grids are fine enough; `nobody` if none reaches the error; and the best rival, None if no rival
    reaches it."""
    rivals = {name: cost for name, cost in costs.items() if not name.startswith("ddmp")}
    first, _ = ranking({method: costs[method], **rivals})
    rival = next(iter(ranking(rivals)[0]), None)
    if not first:
        return "nobody", None
    if method not in first:
        return "loses", rival
    if first == [method]:
        return "wins", rival
    return ("open" if AT_MOST in (costs[method].state, costs[rival].state) else "ties"), rival


def methods_in(rows):
    """The methods with rows of a problem, in order."""
    seen = {method_of(row["way"]) for row in rows}
    return tuple(method for method in PROBLEMS[rows[0]["problem"]].methods if method in seen)


def finest(rows, method):
    """The line of a method with the least error on the finest grid among those that converge, else among all."""
    problem = PROBLEMS[rows[0]["problem"]]
    lines = [line for update in problem.updates if (line := line_of(rows, f"{method} {update}"))]
    chosen = [line for line in lines if verdict(line) == REACHED] or [line for line in lines if good(line[-1:])]
    return min(chosen, key=lambda line: line[-1]["error"]) if chosen else lines[0] if lines else []


def costs_table(rows):
    """Rows of costs.csv: every variant with its errors, order, and costs with their bars."""
    table = []
    for name, problem in PROBLEMS.items():
        chosen = [row for row in rows if row["problem"] == name]
        spread = scatter(chosen)
        for way in problem.ways:
            line = line_of(chosen, way)
            if not line:
                continue
            state = verdict(line)
            entry = {"problem": name, "way": way, "cells": " ".join(str(row["cells"]) for row in line),
                     "errors_percent": " ".join(f"{100.0 * row['error']:.3g}" for row in line),
                     "state": "converges" if state == REACHED else state, "order": f"{order(line):.2f}"}
            for target in TARGETS:
                cost = cost_at(line, target, spread) if target >= least_error(chosen) else Cost(BELOW)
                words = f"{cost.value:.3g}", f"{cost.low:.3g}", f"{cost.high:.3g}"
                for key, word in zip(("cost", "low", "high"), words if cost.known else (cost.state, "", "")):
                    entry[f"{key}_{100.0 * target:g}"] = word
            table.append(entry)
    return table


def draw(rows, problem, path):
    """Error over core-seconds of one problem: the line of each method that is most accurate, with bars; its other lines
    thin; lines that do not converge dashed."""
    plot = scree_post.pyplot()
    figure, axes = plot.subplots(figsize=(8.0, 5.2))
    spread = scatter(rows)
    shown = []
    for method in methods_in(rows):
        best = finest(rows, method)
        for update in problem.updates:
            line = good(line_of(rows, f"{method} {update}"))
            if not line:
                continue
            seconds = [times(row, spread) for row in line]
            main = line[0]["way"] == (best[0]["way"] if best else "")
            style = "-" if verdict(line_of(rows, line[0]["way"])) == REACHED else "--"
            axes.plot([value for value, _, _ in seconds], [row["error"] for row in line], style, marker="o" if main else
                      "", ms=3.5, lw=1.6 if main else 0.6, alpha=1.0 if main else 0.45, color=COLOURS[method],
                      zorder=3 if main else 1, label=f"{method} ({update})" if main else None)
            if main:
                bars = [[value - low for value, low, _ in seconds], [high - value for value, _, high in seconds]]
                axes.errorbar([value for value, _, _ in seconds], [row["error"] for row in line], xerr=bars,
                              fmt="none", ecolor=COLOURS[method], elinewidth=0.8, capsize=2, zorder=3)
            shown += line
    for target in TARGETS:
        axes.axhline(target, color="#bbbbbb", lw=0.8, zorder=0)
    axes.set(xscale="log", yscale="log", xlabel="core-seconds in the steps", ylabel="error", title=problem.title)
    axes.set_ylim(0.7 * min(row["error"] for row in shown), 1.5 * min(FAILED, max(row["error"] for row in shown)))
    guide(axes, problem.dimensions)
    for axis, label in ((axes.xaxis, "{:g}"), (axes.yaxis, "{:g} %")):
        factor = 100.0 if "%" in label else 1.0
        axis.set_major_formatter(lambda value, _, label=label, factor=factor: label.format(factor * value))
        axis.set_minor_formatter(lambda value, _, label=label, factor=factor:
                                 label.format(factor * value) if f"{value:e}"[0] in "25" else "")
        axis.set_tick_params(which="minor", labelsize=7.5)
    axes.grid(True, which="major", color="#eeeeee", lw=0.5)
    axes.legend(loc="upper left", bbox_to_anchor=(1.0, 1.0), fontsize=8.5)
    figure.tight_layout()
    scree_post.save(figure, str(path), 225)
    plot.close(figure)


def guide(axes, dimensions):
    """The slope of a method of second order: the error is proportional to h^2, the cost to h^-(d+1)."""
    (low, high), (bottom, top) = axes.get_xlim(), axes.get_ylim()
    slope = -2.0 / (dimensions + 1)
    end = min(high, low * (bottom / top) ** (1.0 / slope))
    axes.plot([low, end], [top, top * (end / low) ** slope], ":", color="#999999", lw=1.0, zorder=0)
    axes.set_xlim(low, high)
    axes.set_ylim(bottom, top)


def ratios(rows, of, to, key):
    """Median over pairs of rows of the ratio of a number, of a row that `of` accepts to the row with the same method
    and cells that `to` accepts; and the least and greatest ratio. None without pairs."""
    base = {(method_of(row["way"]), row["cells"]): row for row in good(rows) if to(row)}
    found = sorted(row[key] / base[method_of(row["way"]), row["cells"]][key] for row in good(rows)
                   if of(row) and (method_of(row["way"]), row["cells"]) in base)
    if not found:
        return None
    half = len(found) // 2
    middle = found[half] if len(found) % 2 else 0.5 * (found[half - 1] + found[half])
    return middle, found[0], found[-1]


def transfer_ratios(rows, update):
    """Ratios of the error of an update to that of `usl`, on the finest grid of each method."""
    problem = PROBLEMS[rows[0]["problem"]]
    usual = [row for row in rows if (row["ppc"], row["cfl"]) == (problem.ppc[0], problem.cfl[0])
             and row["cells"] == max(other["cells"] for other in rows)]
    return ratios(usual, lambda row: update_of(row["way"]) == update, lambda row: update_of(row["way"]) == "usl",
                  "error")


def setting_ratios(rows, **setting):
    """Ratios of error and cost of `usl` with another ppc or cfl to those with the usual ones, for all methods."""
    problem = PROBLEMS[rows[0]["problem"]]
    usual = {"ppc": problem.ppc[0], "cfl": problem.cfl[0]}
    rows = [dict(row, cost=times(row, 0.0)[0]) for row in rows if update_of(row["way"]) == "usl"]
    return tuple(ratios(rows, lambda row: all(row[key] == value for key, value in {**usual, **setting}.items()),
                        lambda row: all(row[key] == value for key, value in usual.items()), key)
                 for key in ("error", "cost"))


assert set(COLOURS) == set(accuracy_problems.METHODS)
