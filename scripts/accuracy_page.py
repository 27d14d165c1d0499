# SPDX-License-Identifier: BSD-3-Clause
"""Sentences and tables with numbers of the pages in doc/accuracy, made from the rows of accuracy.csv.

    text = accuracy_page.fill(text, rows)          # a page with new blocks
    words = accuracy_page.costs_text(rows)         # the content of costs.csv

A block is between `<!-- made NAME -->` and `<!-- end -->`; the text between blocks has no number of a run.
"""
import csv
import io
import math
import re

import accuracy_evaluation as evaluation
from accuracy_evaluation import AT_MOST, BELOW, DIVERGES, FAILS, NEVER, REACHED, TARGETS
from accuracy_problems import METHODS, PROBLEMS, update_of

NAMES = {"waves": "waves in a square", "waves_cube": "waves in a cube", "waves_small": "small waves",
         "flight": "flying bar", "vortex": "vortex", "piston": "shock", "taylor": "Taylor bar", "slope": "slope"}
BLOCK = re.compile(r"(<!-- made (\w+)(?: (\w+))? -->\n).*?(<!-- end -->)", re.S)
STATES = {NEVER: "not reached", DIVERGES: "diverges", FAILS: "fails", BELOW: BELOW}


def number(value):
    """A number of seconds as text, two digits."""
    digits = max(0, 1 - math.floor(math.log10(value))) if value > 0.0 else 0
    return f"{value:.{digits}f}"


def percent(value):
    """A share as percent, two digits."""
    return f"{100.0 * value:.2g} %"


def cost_text(cost):
    """A cost with its bar, or the reason why there is none."""
    if not cost.known:
        return STATES[cost.state]
    if cost.state == AT_MOST:
        return f"at most {number(cost.value)}"
    return f"{number(cost.value)} ± {100.0 * math.sqrt(cost.high / cost.low) - 100.0:.0f} %"


def listing(words):
    """Words as `a, b and c`."""
    return " and ".join(part for part in (", ".join(words[:-1]), words[-1]) if part)


def problems(rows):
    """Names of the problems that have rows, in order."""
    seen = {row["problem"] for row in rows}
    return [name for name in PROBLEMS if name in seen]


def costs_of(rows, name, target):
    """Costs of all methods at an error."""
    chosen = [row for row in rows if row["problem"] == name]
    return {method: evaluation.method_cost(chosen, method, target) for method in evaluation.methods_in(chosen)}


def summary(rows):
    """Table: who wins or ties at each error."""
    lines = ["| problem | " + " | ".join(percent(target) for target in TARGETS) + " |",
             "|---" * (len(TARGETS) + 1) + "|"]
    for name in problems(rows):
        cells = []
        for target in TARGETS:
            costs = costs_of(rows, name, target)
            first, _ = evaluation.ranking(costs)
            if not first:
                cells.append(nobody(costs))
            elif len(first) == 1:
                cells.append(f"**{costs[first[0]].way}** {cost_text(costs[first[0]])}")
            elif AT_MOST in [costs[method].state for method in first]:
                count = sum(cost.state == AT_MOST for cost in costs.values())
                cells.append(f"open: the coarsest grid is enough for {count} of {len(costs)} methods")
            else:
                cells.append("tie: " + listing([f"{costs[method].way} {cost_text(costs[method])}" for method in first]))
        lines.append(f"| {NAMES[name]} | " + " | ".join(cells) + " |")
    return "\n".join(lines) + "\n"


def standings(rows):
    """Table: where DDMP wins, ties and loses against the methods that are not DDMP; and how often."""
    lines = ["| problem | method | " + " | ".join(percent(target) for target in TARGETS) + " |",
             "|---" * (len(TARGETS) + 2) + "|"]
    counts = {}
    for name in problems(rows):
        for method in ("ddmp", "ddmp control"):
            cells = []
            for target in TARGETS:
                costs = costs_of(rows, name, target)
                if method not in costs:
                    cells.append("not run")
                    continue
                state, rival = evaluation.standing(costs, method)
                counts.setdefault((method, target), []).append(state)
                cells.append(nobody(costs) if state == "nobody" else
                             standing_text(state, costs[method], costs.get(rival)))
            lines.append(f"| {NAMES[name]} | {method} | " + " | ".join(cells) + " |")
    lines.append("")
    for (method, target), states in sorted(counts.items(), key=lambda item: (item[0][0], -item[0][1])):
        number_of = {state: states.count(state) for state in ("wins", "ties", "loses", "open", "nobody")}
        lines.append(f"* `{method}` at {percent(target)}: wins {number_of['wins']}, ties {number_of['ties']}, loses "
                     f"{number_of['loses']}, open {number_of['open']}, reached by no method {number_of['nobody']}, of "
                     f"{len(states)} problems.")
    return "\n".join(lines) + "\n"


def nobody(costs):
    """Why no method has a cost."""
    return BELOW if BELOW in [cost.state for cost in costs.values()] else "not reached"


def standing_text(state, own, other):
    """A cell of the table of standings: the state, the cost, and that of the best rival."""
    if state == "open":
        return "open"
    words = f"**{state}**: " + (("≤ " if own.state == AT_MOST else "") + number(own.value) if own.known
                                else STATES[own.state])
    if other:
        words += f"; `{other.way}` " + ("≤ " if other.state == AT_MOST else "") + number(other.value)
    return words + ("" if other else "; no other")


def transfers(rows):
    """Table: error with each update relative to that with `usl`."""
    updates = ("musl", "aflip", "apic")
    lines = ["| problem | " + " | ".join(updates) + " |", "|---" * (len(updates) + 1) + "|"]
    for name in problems(rows):
        chosen = [row for row in rows if row["problem"] == name]
        found = [evaluation.transfer_ratios(chosen, update) for update in updates]
        lines.append(f"| {NAMES[name]} | " + " | ".join(ratio_text(entry) for entry in found) + " |")
    return "\n".join(lines) + "\n"


def ratio_text(found):
    """Median of a ratio with the least and the greatest value."""
    return "" if found is None else f"{found[0]:.2g} ({found[1]:.2g} to {found[2]:.2g})"


def settings(rows):
    """Table: error and cost with other steps or numbers of particles."""
    lines = ["| problem | cfl | error | cost | ppc | error | cost |", "|---|---|---|---|---|---|---|"]
    for name in problems(rows):
        problem = PROBLEMS[name]
        chosen = [row for row in rows if row["problem"] == name]
        words = [NAMES[name]]
        for key, values in (("cfl", problem.cfl), ("ppc", problem.ppc)):
            words.append(f"{values[0]:g} to {values[1]:g}")
            words += [ratio_text(found) for found in evaluation.setting_ratios(chosen, **{key: values[1]})]
        lines.append("| " + " | ".join(words) + " |")
    return "\n".join(lines) + "\n"


def conditions(rows):
    """Table: versions, number of runs, scatter; processor."""
    lines = ["| problem | version | combinations | failed | run twice | scatter of the times |",
             "|---|---|---|---|---|---|"]
    for name in problems(rows):
        chosen = [row for row in rows if row["problem"] == name]
        twice = sum(row["core_seconds_again"] > 0.0 for row in chosen)
        lines.append(f"| {NAMES[name]} | {listing(sorted({row['commit'] for row in chosen}))} | {len(chosen)} | "
                     f"{sum(bool(row['cause']) for row in chosen)} | {twice} | {percent(evaluation.scatter(chosen))}"
                     + ("" if twice else " (assumed)") + " |")
    lines += ["", f"Processor: {listing(sorted({row['machine'] for row in rows}))}."]
    return "\n".join(lines) + "\n"


def table(rows, name):
    """Table of one problem: costs of all methods; the most accurate variant; variants without cost."""
    chosen = [row for row in rows if row["problem"] == name]
    if not chosen:
        return "There are no rows of this problem.\n"
    lines = ["| method | " + " | ".join(percent(target) for target in TARGETS)
             + " | most accurate variant | its error | order | memory, MB | do not converge | not run |",
             "|---" * (len(TARGETS) + 7) + "|"]
    firsts = [evaluation.ranking(costs_of(rows, name, target))[0] for target in TARGETS]
    for method in evaluation.methods_in(chosen):
        words = []
        for target, first in zip(TARGETS, firsts):
            cost = evaluation.method_cost(chosen, method, target)
            text = cost_text(cost) + (f" ({update_of(cost.way)})" if cost.known else "")
            words.append(f"**{text}**" if method in first else text)
        line = evaluation.finest(chosen, method)
        last = line[-1]
        variants = {update: evaluation.line_of(chosen, f"{method} {update}") for update in PROBLEMS[name].updates}
        odd = [update for update, rows_of in variants.items() if rows_of and evaluation.verdict(rows_of) != REACHED]
        missing = [update for update, rows_of in variants.items() if not rows_of]
        lines.append(f"| {method} | " + " | ".join(words) + f" | {update_of(last['way'])} | "
                     + (f"{percent(last['error'])} | {evaluation.order(line):.1f}" if not last["cause"]
                        else f"{last['cause']} | ")
                     + (f" | {last['memory_mb']:.0f}" if last["memory_mb"] > 0.0 else " | ")
                     + f" | {', '.join(odd)} | {', '.join(missing)} |")
    usual = evaluation.line_of(chosen, "ddmp usl")
    grids = listing([str(row["cells"]) for row in usual])
    errors = listing([row["cause"] or f"{100.0 * row['error']:.2g}" for row in usual])
    lines += ["", f"The default of DDMP (`ddmp usl`) has errors of {errors} % on {grids} cells"
              + (" and does not converge." if evaluation.verdict(usual) != REACHED else ".")]
    return "\n".join(lines) + "\n"


def fill(text, rows):
    """The page with its blocks made anew. A block of unknown name is an error."""
    makers = {"summary": summary, "standings": standings, "transfers": transfers, "settings": settings,
              "conditions": conditions}

    def made(found):
        name, problem = found[2], found[3]
        return found[1] + (table(rows, problem) if name == "table" else makers[name](rows)) + found[4]

    return BLOCK.sub(made, text)


def costs_text(rows):
    """The content of costs.csv."""
    found = evaluation.costs_table(rows)
    file = io.StringIO()
    writer = csv.DictWriter(file, list(found[0]), lineterminator="\n")
    writer.writeheader()
    writer.writerows(found)
    return file.getvalue()


assert list(NAMES) == list(PROBLEMS) and METHODS
