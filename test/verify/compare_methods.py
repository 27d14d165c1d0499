# SPDX-License-Identifier: BSD-3-Clause
"""One table of all verification problems and the main methods.

    python test/verify/compare_methods.py --scree build/bin/scree --work FOLDER

runs every problem with every method and writes FOLDER/comparison.json and the table in Markdown. A figure is the
decisive one of a problem: an error against the closed solution, or a change of energy. A run that fails is `x`; figures
above the limit of their row are in brackets. The last line is the number of rows in which a method is within the limit.
The line above it is the mean over the rows of log10(figure/limit); in it a figure counts as at least a hundredth and at
most a hundred times the limit, so that no single row dominates. `--only WORD` selects problems, `--ways WORD` selects
methods whose name contains a word; `--from FILE FILE ...` writes the table of earlier runs without running them again.
"""

import argparse
import importlib.util
import json
import re
import resource
import time
from pathlib import Path

import numpy as np

import _support
import bodies
import case

WAYS = {  # heading: method, keys of &method
    "ddmp": ("ddmp", ""),
    "ddmp usl": ("ddmp", "stress_update='usl'"),
    "ddmp flip": ("ddmp", "stress_update='usl' transfer='flip'"),
    "ddmp aflip": ("ddmp", "transfer='aflip'"),
    "ddmp apic": ("ddmp", "transfer='apic'"),
    "ddmp musl": ("ddmp", "stress_update='musl'"),
    "ddmp usf": ("ddmp", "stress_update='usf'"),
    "ddmp control": ("ddmp", "stress_update='usl' quadrature='control'"),
    "ddmp linear blend": ("ddmp", "stress_update='usl' blend='linear'"),
    "ddmp product": ("ddmp", "stress_update='usl' alpha='product'"),
    "ddmp paper": ("ddmp", "paper=.true."),
    "mpm": ("mpm", ""),
    "gimp": ("mpm", "basis='gimp'"),
    "quadratic": ("mpm", "basis='quadratic'"),
    "quadratic rflip": ("mpm", "basis='quadratic' transfer='rflip'"),
    "quadratic usl": ("mpm", "basis='quadratic' transfer='rflip' stress_update='usl'"),
    "cubic rflip": ("mpm", "basis='cubic' transfer='rflip'"),
}
FURTHER = {  # further methods, if the program has them
    "ddmp sub-points": ("ddmp", "quadrature='sub_points'"),
    "cpdi": ("mpm", "basis='cpdi'"),
    "cpdi rflip": ("mpm", "basis='cpdi' transfer='rflip'"),
}
LARGEST = 100.0        # in the mean a figure counts as at most this many limits, and at least 1/this

WAVES = """
&run  dimension='1d'  method='{method}' /
&grid  lo=0,0,0  hi=1,1,1  dx=0.015625 /
&time  t_end=0.01  cfl=0.2 /
&method  {words} /
&effects  artificial_viscosity=.false. /
&material  name='rubber'  density=1  young=1.0e4  poisson=0  strength_model='neo_hookean' /
&region  name='bar'  shape='box'  lo=0,0,0  hi=1,1,1 /
&body  name='bar'  region='bar'  material='rubber'  ppc=4,1,1 /
&boundary  face='all'  type='symmetry' /
&exact  solution='axis_aligned'  amplitude=0.1 /
"""

VORTEX = """
&run  dimension='plane_strain'  method='{method}' /
&grid  lo=-1.5,0,-1.5  hi=1.5,1,1.5  dx=0.05 /
&time  t_end=0.45 /
&method  {words} /
&effects  artificial_viscosity=.false. /
&material  name='rubber'  density=1000  young=1000  poisson=0.3  strength_model='neo_hookean' /
&region  name='outer'  shape='cylinder'  axis=0,1,0  centre=0,0.5,0  radius=1.25  height=4 /
&region  name='inner'  shape='cylinder'  axis=0,1,0  centre=0,0.5,0  radius=0.75  height=4 /
&region  name='ring'  shape='difference'  of='outer','inner' /
&body  name='ring'  region='ring'  material='rubber'  ppc=3,1,3 /
&exact  solution='vortex'  frequency=0.5 /
"""


def load(place):
    """The module of a test, which contains its deck and its closed solution."""
    path = _support.HERE / place
    spec = importlib.util.spec_from_file_location(path.stem, path)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def waves(options, name, method, words):
    """Greatest error in time of manufactured waves of a large amplitude."""
    run, result = bodies.launch(options, name, WAVES.format(method=method, words=words), may_fail=True)
    return None if result["code"] else [run.history["displacement_error"].max() / 0.1]


def vortex(options, name, method, words):
    """The ring whose centre circle is rotated by one radian, just before it reverses."""
    run, result = bodies.launch(options, name, VORTEX.format(method=method, words=words), every=5, may_fail=True)
    if result["code"]:
        return None
    seen = run.summary["exact"]
    return [seen["displacement_error"] / seen["greatest_displacement"]]


def disc(options, name, method, words):
    """One revolution of a disc."""
    result = bodies.spin(options, name, method, words, may_fail=True)
    return None if result["code"] else [abs(result["drift"]), result["displacement"]]


def free_bar(options, name, method, words):
    """Free flight."""
    result = bodies.free_bar(options, name, method, words, may_fail=True)
    return None if result["code"] else [abs(result["energy"]), result["velocity"]]


def held_bar(options, name, method, words):
    """Ten periods with cell crossing."""
    result = bodies.held_bar(options, name, method, words, cells=26, speed=0.75, may_fail=True)
    if result["code"]:
        return None
    right = bodies.held_bar_reference(0.75)["period"]
    return [abs(result["energy"]), abs(result["period"] / right - 1.0)]


def discs(options, name, method, words):
    """Rebound."""
    result = bodies.two_discs(options, name, method, words, spacing=0.0125, may_fail=True)
    return None if result["code"] else [abs(result["energy"])]


def column(options, name, method, words):
    """Column with cell crossing."""
    result = bodies.column(options, name, method, words, cells=80, may_fail=True)
    return None if result["code"] else [result["stress"]]


def cantilever(options, name, method, words):
    """Deflection of the tip against finite elements."""
    result = bodies.cantilever(options, name, method, words, may_fail=True)
    return None if result["code"] else [abs(result["fall"] / -3.27 - 1.0)]


def shear(options, name, method, words):
    """Shear of grains."""
    result = bodies.shear(options, name, method, words, density=1.0e-3, may_fail=True)
    return None if result["code"] else [max(result["across"], result["along"])]


def sod(options, name, method, words):
    """Shock tube of 200 cells."""
    module = load("sod/test_sod.py")
    deck = module.DECK.format(spacing=0.005).replace("&run  dimension='1d' /",
                                                     f"&run  dimension='1d'  method='{method}' /")
    run = case.Case(options, name, deck + f"\n&method {words} /\n").run("-q", expect=None)
    if run.code:
        return None
    _, last = run.snapshots()[-1]
    fields = last.fields
    return [(abs(fields["density"] - module.density(last.points[:, 0])) * fields["volume"]).sum()]


def piston(options, name, method, words):
    """A fluid hits a wall at 400 m/s: mean and scatter of the pressure behind the shock."""
    module = load("piston/test_piston.py")
    try:
        states, _ = module.strike(options, name, 400, 2.6, False, words, method)
    except (AssertionError, ValueError):
        return None
    _, stress, _ = module.hugoniot(400.0)
    _, places, fields = states[1]
    front = module.front(places, -fields["stress"][:, 0], 0.5 * stress)
    got = module.plateau(places, fields, 1.5e-3, front - 1.0e-3)
    return [abs(got[0] / stress - 1.0), got[1]]


ROWS = [  # problem, figures with their limits
    (disc, [("spinning disc: angular momentum a turn", 1.0e-3), ("spinning disc: displacement", 1.0e-2)]),
    (free_bar, [("free bar: energy", 1.0e-2), ("free bar: velocity", 1.5e-2)]),
    (held_bar, [("held bar, crossing: energy in 10 periods", 1.0e-2), ("held bar, crossing: period", 5.0e-3)]),
    (discs, [("two discs: energy", 2.0e-2)]),
    (column, [("column, crossing: stress", 2.0e-2)]),
    (cantilever, [("cantilever: deflection", 1.5e-2)]),
    (waves, [("waves, amplitude 0.1: displacement", 5.0e-3)]),
    (vortex, [("vortex: displacement", 2.5e-2)]),
    (shear, [("granular shear: stress", 1.0e-2)]),
    (sod, [("Sod: density", 7.4e-3)]),
    (piston, [("piston: pressure", 1.0e-2), ("piston: scatter of pressure", 5.0e-2)]),
]


def measure(options, only="", some=""):
    """All figures: {row: {method: figure or None}}, and processor time relative to the first method."""
    ways = dict(WAYS)
    listed = case.Case(options, "template", "").run("--template").output
    ways.update({way: words for way, words in FURTHER.items()
                 if re.search(words[1].split("'")[1] + r"[|}]", listed)})
    ways = {way: words for way, words in ways.items() if some in way}
    table, cost = {}, {}
    for problem, figures in ROWS:
        if only not in problem.__name__:
            continue
        for way, (method, words) in ways.items():
            before = resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime
            begin = time.time()
            seen = problem(options, "comparison", method, words)
            spent = resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime - before
            cost.setdefault(problem.__name__, {})[way] = spent
            for (label, _), figure in zip(figures, seen or [None] * len(figures)):
                good = figure is not None and np.isfinite(figure)
                table.setdefault(label, {})[way] = float(figure) if good else None
            print(f"{problem.__name__:<12} {way:<18}", "fails" if seen is None else
                  " ".join(f"{figure:10.3e}" for figure in seen), f"{time.time() - begin:6.1f} s", flush=True)
        (options.work / "comparison.json").write_text(json.dumps({"figures": table, "seconds": cost}, indent=1))
    return table, cost


def short(figure, limit):
    """A cell of the table."""
    if figure is None:
        return "x"
    text = f"{figure:.1e}".replace("e-0", "e-").replace("e+0", "e")
    return text if figure <= limit else f"({text})"


def write(table, cost):
    """The table in Markdown, one method per line."""
    limits = {label: limit for _, figures in ROWS for label, limit in figures}
    rows = list(table)
    ways = list(next(iter(table.values())))
    lines = []
    parts = [rows[n:n + 8] for n in range(0, len(rows), 8)]
    for part in parts:
        lines += ["| | " + " | ".join(part) + " |", "|---" * (len(part) + 1) + "|",
                  "| *limit* | " + " | ".join(f"*{short(limits[row], 1e9)}*" for row in part) + " |"]
        for way in ways:
            cells = [short(table[row][way], limits[row]) for row in part]
            lines.append(f"| {way} | " + " | ".join(cells) + " |")
        lines.append("")
    lines += ["| | within the limit | fails | mean of log10(figure/limit) | processor time |", "|---|---|---|---|---|"]
    for way in ways:
        figures = [table[row][way] / limits[row] if table[row][way] is not None else np.inf for row in rows]
        clipped = np.clip(figures, 1.0 / LARGEST, LARGEST)
        share = np.median([seconds[way] / seconds[ways[0]] for seconds in cost.values()])
        lines.append(f"| {way} | {sum(figure <= 1.0 for figure in figures)} of {len(rows)} | "
                     f"{sum(not np.isfinite(figure) for figure in figures)} | "
                     f"{np.log10(clipped).mean():+.2f} | {share:.1f} |")
    return "\n".join(lines) + "\n"


def main():
    """The table."""
    options = case.arguments()
    parser = argparse.ArgumentParser()
    parser.add_argument("--table", help="file for the table; default: comparison.md in the work folder")
    parser.add_argument("--only", default="", help="problems whose name holds this")
    parser.add_argument("--ways", default="", help="ways whose name holds this")
    parser.add_argument("--from", dest="files", nargs="+", help="files comparison.json to join")
    further = parser.parse_args()
    if further.files:
        table, cost = {}, {}
        for file in further.files:
            seen = json.loads(Path(file).read_text(encoding="utf-8"))
            for whole, part in ((table, seen["figures"]), (cost, seen["seconds"])):
                for row, figures in part.items():
                    whole.setdefault(row, {}).update(figures)
    else:
        table, cost = measure(options, further.only, further.ways)
    text = write(table, cost)
    Path(further.table or options.work / "comparison.md").write_text(text, encoding="utf-8")
    print(text)


if __name__ == "__main__":
    main()
