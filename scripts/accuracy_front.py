# SPDX-License-Identifier: BSD-3-Clause
"""Evaluate runs by error and cost: Pareto front, cost of a given error, and the picture.

A row is a dict of numbers and words as accuracy_cost.py writes them; a row with a cause has failed.
Cost is the measured processor time of the steps [core-seconds], or a model of it that does not depend
on the load of the machine.
"""
import math

import scree_post

FAILED = 1.0                             # rows with an error of 100 % or more count as failed
COLOURS = {"ddmp": "#b3311b", "mpm": "#8a6d3b", "gimp": "#2f7d3b", "cpgimp": "#58a55c",
           "quadratic": "#1f5a93", "cubic": "#6aa3d5", "cpdi": "#6a4098"}
OTHER = "#444444"


def method_of(way):
    """The numerical method to which a variant belongs: the first word of its name."""
    return way.split()[0]


def good(rows):
    """The rows of runs that ended with an error below 100 %."""
    return [row for row in rows if not row["cause"] and row["error"] < FAILED]


def front(rows, cost="core_seconds"):
    """The Pareto front in ascending order of cost: no row has both a smaller error and a smaller cost than a row of the
    front."""
    best, least = [], math.inf
    for row in sorted(good(rows), key=lambda row: (row[cost], row["error"])):
        if row["error"] < least:
            best.append(row)
            least = row["error"]
    return best


def cost_at(rows, error, cost="core_seconds"):
    """Cost at which the Pareto front of some rows reaches an error; infinity if it never does.

    Between two rows of the front error and cost are interpolated linearly in their logarithms, so that the result
    depends little on the cell sizes that were run.
    """
    line = front(rows, cost)
    for before, after in zip([None] + line, line):
        if after["error"] <= error:
            if before is None:
                return after[cost]
            share = math.log(before["error"] / error) / math.log(before["error"] / after["error"])
            return before[cost] * (after[cost] / before[cost]) ** share
    return math.inf


def cheapest(rows, error, cost="core_seconds"):
    """The cheapest row whose error does not exceed the given one, or None."""
    return next((row for row in front(rows, cost) if row["error"] <= error), None)


def order(rows):
    """Order of convergence, by least squares, of rows that differ only in their cell size."""
    (np,) = scree_post.modules("numpy")
    pairs = [(math.log(row["cells"]), math.log(row["error"])) for row in good(rows)]
    return -float(np.polyfit(*zip(*pairs), 1)[0]) if len(pairs) > 1 else math.nan


def add_model(rows):
    """Give each row `model_seconds`: steps times o plus particle updates times u, where u belongs to a variant and a
    number of particles per cell.

    o is the cost of a step without particles and is common to all rows of a problem. The sum of the absolute relative
    errors of the model is minimised; in a sum of squares runs that were disturbed by other processes would have too
    much weight.
    """
    (np,) = scree_post.modules("numpy")
    for problem in {row["problem"] for row in rows}:
        chosen = [row for row in good(rows) if row["problem"] == problem]
        kinds = sorted({(row["way"], row["ppc"]) for row in chosen})
        matrix = np.zeros((len(chosen), len(kinds) + 1))
        for line, row in zip(matrix, chosen):
            line[0] = row["steps"] / row["core_seconds"]
            line[1 + kinds.index((row["way"], row["ppc"]))] = row["updates"] / row["core_seconds"]
        found = positive(np, matrix)
        for row in rows:
            if row["problem"] == problem:
                kind = (row["way"], row["ppc"])
                row["model_seconds"] = math.nan
                if kind in kinds and row["steps"]:
                    row["model_seconds"] = float(
                        row["steps"] * found[0] + row["updates"] * found[1 + kinds.index(kind)])


def positive(np, matrix, rounds=60):
    """The non-negative solution that minimises the sum of |matrix x - 1|, by iteratively reweighted least squares."""
    weight = np.ones(len(matrix))
    found = np.zeros(matrix.shape[1])
    for _ in range(rounds):
        free = np.ones(matrix.shape[1], dtype=bool)
        while True:
            root = np.sqrt(weight)[:, None]
            answer = np.linalg.lstsq(matrix[:, free] * root, root[:, 0], rcond=None)[0]
            if (answer >= 0.0).all() or not free.any():
                break
            free[np.flatnonzero(free)[answer < 0.0]] = False
        found[:] = 0.0
        found[free] = answer
        weight = 1.0 / np.maximum(np.abs(matrix @ found - 1.0), 1.0e-3)
    return found


def setting_text(row, length=True):
    """The variant and the setting of a row as text."""
    text = row["way"]
    if length:
        text += f", {row['cells']} cells, {row['ppc']} ppc, cfl {row['cfl']:g}"
    return text


def number(value):
    """A number of seconds as text."""
    if not math.isfinite(value):
        return "never"
    digits = max(0, 1 - math.floor(math.log10(value))) if value > 0.0 else 0
    return f"{value:.{digits}f}"


def tables(rows, targets=(0.1, 0.01, 0.001)):
    """Tables in Markdown: the run of lowest cost for each error, then the cost of each method for the same error."""
    lines = ["| error | run of lowest cost | its error | core-seconds | by the model |",
             "|---|---|---|---|---|"]
    for target in targets:
        row = cheapest(rows, target)
        cells = ["not reached by any run", "", "", ""] if row is None else [
            setting_text(row), percent(row["error"]), number(row["core_seconds"]),
            number(row["model_seconds"])]
        lines.append(f"| {percent(target)} | " + " | ".join(cells) + " |")
    methods = [name for name in COLOURS if any(method_of(row["way"]) == name for row in rows)]
    lines += ["", "| core-seconds for | " + " | ".join(methods) + " |",
              "|---" * (len(methods) + 1) + "|"]
    for cost, label in (("core_seconds", "measured"), ("model_seconds", "model")):
        for target in targets:
            seen = [cost_at([row for row in rows if method_of(row["way"]) == name], target, cost)
                    for name in methods]
            least = min(seen)
            cells = [f"**{number(value)}**" if value == least < math.inf else number(value)
                     for value in seen]
            lines.append(f"| {percent(target)}, {label} | " + " | ".join(cells) + " |")
    return "\n".join(lines) + "\n"


def percent(value):
    """A share as percent, two digits."""
    return f"{100.0 * value:.2g} %"


def draw(rows, problem, path):
    """Error over core-seconds of one problem, with its Pareto front; failed runs are marked at the upper frame."""
    plot = scree_post.pyplot()
    figure, axes = plot.subplots(figsize=(8.0, 5.2))
    fine, best = good(rows), front(rows)
    for row in fine:
        if row not in best:
            axes.plot(row["core_seconds"], row["error"], ".", color="#bdbdbd", ms=5, zorder=1)
    for method, colour in COLOURS.items():
        line = front([row for row in fine if method_of(row["way"]) == method])
        if line:
            axes.plot([row["core_seconds"] for row in line], [row["error"] for row in line], "o-",
                      color=colour, ms=3.5, lw=1.0, label=method, zorder=2)
    axes.plot([row["core_seconds"] for row in best], [row["error"] for row in best], "-",
              color="#111111", lw=2.6, zorder=3, label="front")
    for row in best:
        axes.plot(row["core_seconds"], row["error"], "o", ms=6, zorder=4,
                  color=COLOURS.get(method_of(row["way"]), OTHER))
    axes.set(xscale="log", yscale="log", xlabel="core-seconds in the steps", ylabel="error",
             title=problem.title)
    axes.set_ylim(0.6 * min(row["error"] for row in fine), 1.6 * max(row["error"] for row in fine))
    axes.set_xlim(0.2 * min(row["core_seconds"] for row in fine),      # space for names on the left
                  1.5 * max(row["core_seconds"] for row in fine))
    guide(axes, problem.dimensions)
    label(axes, best)
    failures(axes, rows)
    axes.grid(True, which="major", color="#e6e6e6", lw=0.6)
    axes.legend(loc="upper left", bbox_to_anchor=(1.0, 1.0), fontsize=9)
    figure.tight_layout()
    scree_post.save(figure, str(path), 225)
    plot.close(figure)


def label(axes, best):
    """Names beside the front without overlap. They are placed below and to the left of it, where nothing else is
    drawn."""
    done = []
    for row in best:
        place = axes.transData.transform((row["core_seconds"], row["error"]))
        if all(abs(place[1] - other) > 14.0 for other in done):
            done.append(place[1])
            axes.annotate(f"{row['way']} {row['cells']}, {row['ppc']}, {row['cfl']:g}",
                          (row["core_seconds"], row["error"]), xytext=(-7, -5),
                          textcoords="offset points", ha="right", va="center", fontsize=7.5)


def guide(axes, dimensions):
    """The slope of a method of second order: the error is proportional to h^2, the cost to h^-(d+1)."""
    (low, high), (bottom, top) = axes.get_xlim(), axes.get_ylim()
    slope = -2.0 / (dimensions + 1)
    end = min(high, low * (0.3 * top / bottom) ** (-1.0 / slope) if top > bottom else high)
    axes.plot([low, end], [top, top * (end / low) ** slope], ":", color="#999999", lw=1.0, zorder=0)
    axes.set_xlim(low, high)
    axes.set_ylim(bottom, top)


def failures(axes, rows):
    """A cross at the upper frame at the cost of each failed run, and the causes below."""
    lost = [row for row in rows if row["cause"] or row["error"] >= FAILED]
    if not lost:
        return
    low, high = axes.get_xlim()
    top = axes.get_ylim()[1]
    told = {}
    for row in lost:
        method = method_of(row["way"])
        place = min(max(row["core_seconds"], low), high)
        axes.plot(place, top, "x", color=COLOURS.get(method, OTHER), ms=7, mew=1.8,
                  clip_on=False, zorder=5)
        told.setdefault((method, row["cause"] or "error above 100 %"), []).append(row)
    lines = [f"{method}: {len(group)} x {cause}" for (method, cause), group in sorted(told.items())]
    axes.text(1.02, 0.02, "crosses, failed:\n" + "\n".join(lines), transform=axes.transAxes,
              fontsize=7.5, va="bottom", color="#555555")
