# SPDX-License-Identifier: BSD-3-Clause
"""How accurate a number of the user's own deck is, and what more accuracy would cost.

The deck is run with cells of three or more sizes. From three of them follow the observed order of
convergence, the value for cells of no size (L. F. Richardson 1911) and a bound of the error of the
finest run (grid convergence index: P. J. Roache, J. Fluids Eng. 116 (1994) 405; I. B. Celik and
others, ibid. 130 (2008) 078001). A quantity is one of:

  NAME     a column of the history: its last row; NAME:max, NAME:min, NAME:at=TIME
  PLACE    a number of the summary, such as ledger.energy_error
  length, width, radius, front_z, ...   of the particles of the last snapshot
"""
import argparse
import csv
import math
import os
import re
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field
from pathlib import Path

import scree_post

from .. import written as written_files
from ..errors import EXIT_USAGE, PostError
from ..quantity import quantity as number_with_unit
from ..study import find_program, jobs_for, threads_of_a_run
from scree.units import deck_length

SUMMARY = "how accurate a number of a deck is, and what more costs"
EXAMPLES = ("accuracy input/taylor_copper/scene.nml --quantity length radius --factors 4,2,1",
            "accuracy input/two_discs/scene.nml --quantity length --factors 4,2,1")
AXES = {"3d": (0, 1, 2), "plane_strain": (0, 2), "axisymmetric": (0, 2), "1d": (0,)}
SAFE, WARY = 1.25, 3.0                   # factors of safety: the order is as expected, or it is not
EXPECTED = (0.5, 2.5)                    # orders that are believed
UNLIKE = 1.0e-3                          # a larger share of the mass is another body
STILL = 1.0e-12                          # a smaller change, as a share of the value, is none


@dataclass(frozen=True)
class Grid:
    """Cells of a deck, which may be made larger and smaller alike."""

    lower: tuple                                         # corner, in the unit of the deck
    upper: tuple
    cells: tuple                                         # along x, y, z
    key: str                                             # dx or cells: what the deck gives
    axes: tuple                                          # along which there is more than a cell
    spacing: float                                       # edge of a cell, in the unit of the deck
    unit: str = "m"                                      # of lengths in the deck

    @property
    def common(self):
        """Greatest number of parts into which all axes can be cut with whole cells in each."""
        return math.gcd(*(self.cells[axis] for axis in self.axes))

    def parts(self, factor):
        """Into how many of those the axes must be cut for cells that are `factor` times as large."""
        return max(1, round(self.common / factor))

    def words(self, parts):
        """Word for --set and edge of a cell, in the unit of the deck."""
        if self.key == "dx":
            size = self.spacing * self.common / parts
            return f"grid.dx={size:.15g}", size
        cells = [count * parts // self.common if axis in self.axes else count
                 for axis, count in enumerate(self.cells)]
        return "grid.cells=" + ",".join(map(str, cells)), self.spacing * self.common / parts


@dataclass
class Run:
    """What one run gave."""

    method: str
    factor: float                                        # edge of its cells over that of the deck
    size: float                                          # that edge, in the unit of the deck
    seconds: float = math.nan                            # core-seconds in the steps
    particles: int = 0
    steps: int = 0
    mass: float = 0.0                                    # of all matter at the start [kg]
    values: dict = field(default_factory=dict)           # by quantity


@dataclass
class Verdict:
    """What three runs say of a number."""

    kind: str                                            # monotone, oscillating, ...
    order: float                                         # observed, nan if there is none
    limit: float                                         # extrapolated value
    error: float                                         # bound of the error of the finest run
    safety: float                                        # factor in that


def read_grid(deck, settings):
    """The grid of a deck, with what --set changes of it."""
    group, dimension, system = {}, "3d", "si"
    for read in groups(deck):
        group.update(read.get("grid", {}))
        system = read.get("units", {}).get("system", system)
        dimension = read.get("run", {}).get("dimension", dimension)
    for name, value in settings:
        if name == "run.dimension":
            dimension = value.strip("'\"")
        elif name == "units.system":
            system = value.strip("'\"")
        elif name.startswith("grid."):
            numbers = [float(word) for word in value.split(",")]
            group[name[5:]] = numbers if len(numbers) > 1 else numbers[0]
    for key in ("lo", "hi"):
        if len(group.get(key, ())) != 3:
            raise PostError(f"{deck}: &grid {key} must be three numbers", EXIT_USAGE)
    key = "dx" if "dx" in group else "cells"
    if dimension not in AXES or key not in group:
        raise PostError(f"{deck}: &grid with dx or cells and a known dimension are needed; what "
                        f"'scree --check {deck}' says comes first", EXIT_USAGE)
    axes, spans = AXES[dimension], [high - low for low, high in zip(group["lo"], group["hi"])]
    if key == "cells":
        cells = [int(count) for count in group["cells"]]
    else:
        cells = [max(1, round(span / group["dx"])) if axis in axes else 1
                 for axis, span in enumerate(spans)]
    return Grid(tuple(group["lo"]), tuple(group["hi"]), tuple(cells), key, axes,
                spans[axes[0]] / cells[axes[0]], deck_length(system))


def groups(deck):
    """The groups of a deck and of the files that it includes, as dicts of dicts."""
    (f90nml,) = scree_post.modules("f90nml")
    try:
        read = f90nml.read(scree_post.readable(str(deck)))
    except (ValueError, UnicodeDecodeError, StopIteration, AssertionError) as error:
        raise PostError(f"{deck} is not a deck: {error}", EXIT_USAGE) from error
    found = [{name: value for name, value in read.items() if isinstance(value, dict)}]
    more = read.get("include", [])
    for entry in more if isinstance(more, list) else [more]:
        found += groups(os.path.join(os.path.dirname(deck), entry["file"]))
    return found


def choose_sizes(grid, factors):
    """Pairs of factor and parts, coarse first; the factors as they come out with whole cells."""
    chosen = {grid.parts(factor) for factor in factors}
    if len(chosen) < 3 or len(chosen) < len(set(factors)):
        near = {grid.parts(factor) for factor in (3.0, 2.5, 2.0, 1.7, 1.4, 1.2, 1.0, 0.7, 0.5, 0.3)}
        fitting = ", ".join(f"{grid.common / parts:.4g}" for parts in sorted(near))
        cells = " x ".join(map(str, grid.cells))
        raise PostError(
            f"--factors {','.join(f'{factor:g}' for factor in factors)} are not as many different "
            f"grids: {cells} cells have {grid.common} as greatest common divisor, so cells may be "
            f"larger by {fitting}; name three of these, or change &grid hi", EXIT_USAGE)
    return [(grid.common / parts, parts) for parts in sorted(chosen)]


def ask(options, words):
    """Run the program; exit code and what it says."""
    environment = {**os.environ, "OMP_NUM_THREADS": str(threads_of_a_run())}
    try:
        answer = subprocess.run([str(options.scree), *map(str, words)], env=environment, text=True,
                                stdout=subprocess.PIPE, stderr=subprocess.STDOUT, check=False)
    except OSError as error:
        raise PostError(f"cannot run {options.scree}: {error.strerror}; name the program with "
                        "--scree", EXIT_USAGE) from error
    return answer.returncode, answer.stdout


def words_of(options, method, word):
    """What is put in place of the deck's, as options of the program."""
    changes = [f"{name}={value}" for name, value in options.settings]
    changes = [text for text in changes if not text.startswith(("grid.dx=", "grid.cells="))]
    changes += [word, "checkpoint.at_end=.false."] + ([f"run.method={method}"] if method else [])
    return [part for text in changes for part in ("--set", text)]


def make_runs(options, grid, method, sizes):
    """All runs of one method, coarse first. The first one already tells whether there is such a
    number; the others use the cores at the same time."""
    runs = [make_run(options, grid, method, *sizes[0])]
    with ThreadPoolExecutor(jobs_for(threads_of_a_run())) as pool:
        runs += pool.map(lambda one: make_run(options, grid, method, *one), sizes[1:])
    warn_of_mass(runs)
    return runs


def make_run(options, grid, method, factor, parts):
    """One run."""
    word, size = grid.words(parts)
    name = f"accuracy_{method or 'deck'}_{parts}"
    code, text = ask(options, ["-q", "--overwrite", "--case", name, "--outdir", options.work / name,
                               *words_of(options, method, word), options.deck])
    if code:
        raise PostError(f"the run with cells of {size:.4g} {grid.unit} ended with exit code {code}:\n"
                        + text.strip()[-1500:], code if code in (2, 3, 4) else 4)
    case = written_files.Written(options.work / name, name)
    summary = case.summary
    if "processor_s" not in summary:
        raise PostError(f"{options.scree} is too old: its summaries do not tell core-seconds; "
                        "build it anew or name another with --scree")
    run = Run(method, factor, size, summary["processor_s"], summary["particles"],
              summary["steps"], summary["ledger"]["start"]["mass"])
    for quantity in options.quantity:
        run.values[quantity] = case.value(quantity, options.body, options.percentile)
    if sys.stderr.isatty():
        print(f"{method or 'deck'}, cells of {size:.4g} {grid.unit}: {run.steps} steps, "
              f"{run.seconds:.3g} core-seconds", file=sys.stderr, flush=True)
    return run


def warn_of_mass(runs):
    """Say so if the grids hold different bodies, which is an error without any order."""
    masses = [run.mass for run in runs]
    if max(masses) - min(masses) > UNLIKE * max(masses):
        print(f"note: the mass of the bodies differs by {100 * (max(masses) / min(masses) - 1):.2g} %"
              " between the grids, as their edges do not lie between particles in all of them. That "
              "hides the order; factors such as 2,1,0.5 may do, or packing='cut' of &body")


def observed_order(coarse, middle, ratio_fine, ratio_coarse):
    """Order p with (f3-f2)/(f2-f1) = r21^p (r32^p-1)/(r21^p-1), by bisection: the right side grows
    with p. Arguments are the changes f3-f2 and f2-f1 and the two ratios of cell sizes, all above 1."""
    wanted = coarse / middle
    low, high = -10.0, 20.0

    def seen(order):
        if abs(order) < 1.0e-9:
            return math.log(ratio_coarse) / math.log(ratio_fine)
        fine = ratio_fine ** order
        return fine * (ratio_coarse ** order - 1.0) / (fine - 1.0)

    for _ in range(100):
        order = 0.5 * (low + high)
        if seen(order) < wanted:
            low = order
        else:
            high = order
    return 0.5 * (low + high)


def judge(sizes, values):
    """The verdict on a number from its values on three grids, coarse first."""
    coarse, middle, fine = values
    first, last = coarse - middle, middle - fine
    ratio_coarse, ratio_fine = sizes[0] / sizes[1], sizes[1] / sizes[2]
    still = STILL * max(map(abs, values))
    spread = max(values) - min(values)
    if abs(last) <= still:
        return Verdict("does not change", math.nan, fine, WARY * spread, WARY)
    if first * last <= 0.0:
        return Verdict("oscillating", math.nan, fine, WARY * spread, WARY)
    order = observed_order(first, last, ratio_fine, ratio_coarse)
    if order <= 0.05:
        return Verdict("not converging", order, math.nan, math.inf, WARY)
    safety = SAFE if EXPECTED[0] <= order <= EXPECTED[1] else WARY
    trusted = min(order, EXPECTED[1])
    gain = last / (ratio_fine ** trusted - 1.0)
    return Verdict("monotone", order, fine - gain, safety * abs(gain), safety)


def cost_law(runs, dimensions):
    """Core-seconds of cells of size 1 if cost grows with h^-(d+1), and the power that was seen."""
    logs = [(math.log(run.size), math.log(run.seconds)) for run in runs if run.seconds > 0.0]
    if len(logs) < 2:
        return math.nan, math.nan
    power = dimensions + 1.0
    factor = math.exp(sum(cost + power * size for size, cost in logs) / len(logs))
    middle = sum(size for size, _ in logs) / len(logs)
    slope = (sum(cost * (size - middle) for size, cost in logs)
             / sum((size - middle) ** 2 for size, _ in logs))
    return factor, -slope


def forecast(runs, verdict, tolerance, dimensions):
    """Size of the cells whose error is within a tolerance and their core-seconds, or None."""
    if verdict.kind != "monotone" or not verdict.error > 0.0:
        return None
    order = min(verdict.order, EXPECTED[1])
    size = runs[-1].size * (tolerance / verdict.error) ** (1.0 / order)
    return size, cost_law(runs, dimensions)[0] * size ** -(dimensions + 1.0)


def tolerance_of(text, verdict, fine):
    """The tolerance as a number in the unit of the quantity; 1% is of the extrapolated value."""
    if not text.endswith("%"):
        return number_with_unit(text)
    base = verdict.limit if math.isfinite(verdict.limit) else fine
    return 0.01 * float(text[:-1]) * abs(base)


def sentence(verdict, unit, fine):
    """The verdict for people."""
    share = f" ({100.0 * verdict.error / abs(verdict.limit):.2g} %)" if verdict.limit else ""
    bound = f"error of the finest run below {verdict.error:.3g}{unit}{share}, safety {verdict.safety:g}"
    if verdict.kind == "does not change":
        return f"the last two runs agree to round-off: {bound}; no order can be seen"
    if verdict.kind == "oscillating":
        return (f"oscillating: values go up and down with the cells, so no order and no better value; "
                f"{bound} times the range")
    if verdict.kind == "not converging":
        return (f"not converging: changes grow as cells get smaller (order {verdict.order:.2f}), "
                f"nothing is known beyond the finest value {fine:.6g}{unit}; finer or coarser cells, "
                "more particles a cell or another method may show why")
    belief = "" if verdict.safety == SAFE else ", which is not as expected"
    return (f"monotone, order {verdict.order:.2f}{belief}; value without cells {verdict.limit:.8g}{unit}; "
            f"{bound}")


def plan_text(runs, verdict, text, grid):
    """What a tolerance would cost."""
    dimensions = len(grid.axes)
    _, seen = cost_law(runs, dimensions)
    law = f"cost as h^-{dimensions + 1}, {seen:.1f} seen"
    fine = runs[-1]
    wanted = tolerance_of(text, verdict, fine.values[verdict.name])
    if verdict.error <= wanted:
        return f"{text} is met by cells of {fine.size:.4g} {grid.unit}: {fine.seconds:.3g} core-seconds"
    plan = forecast(runs, verdict, wanted, dimensions)
    if plan is None:
        return f"{text} cannot be planned: there is no order to go by"
    if plan[1] > 1.0e15:
        return f"{text} is out of reach at order {verdict.order:.2f}"
    return (f"{text} needs cells of about {plan[0]:.3g} {grid.unit}, {fine.size / plan[0]:.1f} times smaller: "
            f"{plan[1]:.3g} core-seconds ({law})")


def report(options, method, quantity, runs, unit, grid):
    """Print the table of one quantity and method; its verdict."""
    chosen = runs[-3:]
    verdict = judge([run.size for run in chosen], [run.values[quantity] for run in chosen])
    verdict.name = quantity
    unit = f" {unit}" if unit and unit != "1" else ""
    print(f"\n{quantity}{unit and f' [{unit.strip()}]'}{', ' + method if method else ''}")
    print(f"  {f'cells [{grid.unit}]':>10} {'particles':>10} {'steps':>8} {'core-seconds':>13} {'value':>18}"
          f" {'change':>10}")
    before = None
    for run in runs:
        value = run.values[quantity]
        change = "" if before is None else f"{value - before:.2e}"
        print(f"  {run.size:10.4g} {run.particles:10d} {run.steps:8d} {run.seconds:13.4g}"
              f" {value:18.10g} {change:>10}")
        before = value
    print("  " + sentence(verdict, unit, runs[-1].values[quantity]))
    print("  " + plan_text(runs, verdict, options.tolerance, grid))
    return verdict


def write_table(path, found):
    """All runs and verdicts as comma separated values."""
    with open(path, "w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(["quantity", "unit", "method", "cell_size", "factor", "particles", "steps",
                         "core_seconds", "value", "kind", "order", "extrapolated", "error_bound"])
        for (method, quantity), (runs, unit, verdict) in found.items():
            for run in runs:
                writer.writerow([quantity, unit, method or "", f"{run.size:.12g}", f"{run.factor:.12g}",
                                 run.particles, run.steps, repr(run.seconds),
                                 repr(run.values[quantity]), verdict.kind, repr(verdict.order),
                                 repr(verdict.limit), repr(verdict.error)])


def draw(path, found, length):
    """Values against the size of cells with the extrapolated one, and errors against cost."""
    plot = scree_post.pyplot()
    names = list(dict.fromkeys(quantity for _, quantity in found))
    figure, panels = plot.subplots(len(names), 2, figsize=(9.0, 3.4 * len(names)), squeeze=False)
    colours = ("#b3311b", "#1f5a93", "#2f7d3b", "#6a4098", "#e08a1e")
    for row, quantity in zip(panels, names):
        lines = [(method, *rest) for (method, name), rest in found.items() if name == quantity]
        for colour, (method, runs, unit, verdict) in zip(colours * len(lines), lines):
            sizes, values = ([run.size for run in runs], [run.values[quantity] for run in runs])
            row[0].plot(sizes, values, "o-", color=colour, ms=4, label=method or "deck")
            if math.isfinite(verdict.limit):
                row[0].errorbar([0.0], [verdict.limit], yerr=verdict.error, fmt="s", ms=4,
                                color=colour, capsize=3)
                far = [(run.seconds, abs(value - verdict.limit)) for run, value in zip(runs, values)
                       if value != verdict.limit]
                if verdict.kind == "monotone" and far:
                    row[1].plot(*zip(*far), "o-", color=colour, ms=4, label=method or "deck")
        unit = f" [{lines[0][2]}]" if lines[0][2] else ""
        row[0].set(xlabel=f"edge of a cell [{length}]", ylabel=quantity + unit)
        row[0].legend(title="at 0: extrapolated", fontsize=9, title_fontsize=9)
        if not row[1].lines:
            row[1].axis("off")
            row[1].text(0.5, 0.5, f"{lines[0][3].kind}: no order", ha="center")
            continue
        row[1].set(xscale="log", yscale="log", xlabel="core-seconds",
                   ylabel="distance from the extrapolated")
        for axis in (row[1].xaxis, row[1].yaxis):
            axis.set_minor_formatter(plot.NullFormatter())
    figure.tight_layout()
    scree_post.save(figure, path, 110)
    plot.close(figure)


def numbers(text):
    """Positive numbers between commas, none twice."""
    try:
        found = [float(word) for word in text.split(",")]
    except ValueError:
        found = []
    if len(set(found)) < 3 or min(found) <= 0.0 or not all(map(math.isfinite, found)):
        raise argparse.ArgumentTypeError(
            "at least three different numbers above zero, such as 2,1.4,1, are needed")
    return found


def change(text):
    """A pair of name and value from GROUP.KEY=VALUE."""
    name, sign, value = text.partition("=")
    if not sign or not re.fullmatch(r"\w+(\[[^]]*\])?\.\w+", name.strip()):
        raise argparse.ArgumentTypeError(f"'{text}' is not of the form GROUP.KEY=VALUE")
    return name.strip(), value.strip()


def tolerance(text):
    """A tolerance: a number, or a percentage."""
    try:
        if (float(text[:-1]) if text.endswith("%") else number_with_unit(text)) > 0.0:
            return text
    except (ValueError, argparse.ArgumentTypeError):
        pass
    raise argparse.ArgumentTypeError(f"'{text}' is not like 1% (of the value), 0.002 (in SI) or 2mm")


def percentile(text):
    """More than a half of the mass, at most all of it."""
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not 50.0 < value <= 100.0:
        raise argparse.ArgumentTypeError(f"'{text}' is not a number above 50 and up to 100")
    return value


def add_arguments(parser):
    """The options."""
    parser.add_argument("deck", metavar="DECK")
    parser.add_argument("--quantity", nargs="+", required=True, metavar="NAME", help="see above")
    parser.add_argument("--factors", type=numbers, default=[2.0, 1.4, 1.0],
                        help="sizes of cells over that of the deck (2,1.4,1)")
    parser.add_argument("--methods", help="ddmp,mpm: each of them; else that of the deck")
    parser.add_argument("--tolerance", type=tolerance, default="1%", help="wanted (1%%)")
    parser.add_argument("--set", dest="settings", type=change, action="append", default=[],
                        metavar="G.K=VALUE", help="as that of the program")
    parser.add_argument("--body", help="particles of this body alone")
    parser.add_argument("--percentile", type=percentile, default=100.0,
                        help="extents leave out the rest of the mass on each side (100)")
    parser.add_argument("--scree", metavar="PROGRAM",
                        help="the program; default build/bin/scree or in the path")
    parser.add_argument("--work", type=Path, help="folder for the runs (out/accuracy_DECK)")
    parser.add_argument("--csv", metavar="FILE", help="write the table")
    parser.add_argument("--plot", metavar="FILE", help="draw it")


def run(options):
    """Run, judge, print."""
    options.scree = find_program(options.scree)
    grid = read_grid(options.deck, options.settings)
    sizes = choose_sizes(grid, options.factors)
    stem = os.path.splitext(os.path.basename(options.deck))[0]
    options.work = options.work or Path("out") / f"accuracy_{stem}"
    methods = options.methods.split(",") if options.methods else [None]
    for method in methods:                               # faults of the deck cost nothing
        for _, parts in sizes:
            code, text = ask(options, ["--check", "--no-estimate", *words_of(options, method,
                                                                             grid.words(parts)[0]), options.deck])
            if code:
                raise PostError("the deck is not accepted:\n" + text.strip()[-1500:], code)
    found = {}
    for method in methods:
        runs = make_runs(options, grid, method, sizes)
        name = f"accuracy_{method or 'deck'}_{sizes[-1][1]}"
        written = written_files.Written(options.work / name, name)
        for quantity in options.quantity:
            unit = written.unit(quantity)
            verdict = report(options, method, quantity, runs, unit, grid)
            found[method, quantity] = runs, unit, verdict
    if options.csv:
        write_table(options.csv, found)
    if options.plot:
        draw(options.plot, found, grid.unit)
    return 0
