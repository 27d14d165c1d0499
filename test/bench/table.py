# SPDX-License-Identifier: BSD-3-Clause
"""How fast the steps are: methods, dimensions, laws, ranks and threads, beside what the memory gives.

    python3 test/bench/table.py --scree build/bin/scree --work /tmp/bench                 all, a few minutes
    python3 test/bench/table.py --scree build/bin/scree --work /tmp/bench --only 3d       rows with 3d in their name
    python3 test/bench/table.py ... --write doc/developer/performance_table.md            the page
    python3 test/bench/table.py ... --store                                               a new reference

A block strikes a wall, so that laws which flow do flow. Nanoseconds are core time in the steps, the least of some runs
that are made in turn; they are shared out to phases as the timing table of the run says. The kernels copy and triad of
`bench_stream` run in the same session. A row is compared with test/bench/reference.json by its ratio to the time in
which a triad moves 8 bytes, which a slower machine makes longer too; more than SLOWER times the stored ratio is told,
and ends with exit code 1. Written into the work folder: table.json, table.csv, table.md.
"""

import argparse
import csv
import json
import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

HERE = Path(__file__).resolve().parent
REFERENCE = HERE / "reference.json"
SLOWER = 1.25                          # times the stored ratio that is told
LEAST_PLASTIC = 0.7                    # share of the elastic rate that J2 must reach
LEAST_FLAT = 2.0                       # times the rate in three dimensions that two must reach

SCENE = """
&run  dimension='{dimension}'  method='{method}' /
&method  {words} /
&grid  lo=0,0,0  hi={upper}  dx=1 /
&time  t_end=1.0e9  max_steps={steps} /
&effects  artificial_viscosity=.false.  {effects} /
&material  name='m'  density=1000  {material} /
&region  name='a'  shape='box'  lo=0,0,0  hi={block} /
&body  name='a'  region='a'  material='m'  ppc={ppc}  velocity={velocity} /
&boundary  face='all'  type='slip' /
&output  name='h'  kind='history'  every=1000000 /
&checkpoint  at_end=.false. /
&log  progress_seconds=1000 /
"""
DIMENSIONS = {  # box, block, particles a cell (eight or nine: what a cell costs is shared alike), velocity, steps
    "1d": ("6000,1,1", "5000,1,1", "8,1,1", "-4,0,0", 50),
    "plane_strain": ("64,1,72", "64,1,64", "3,1,3", "0,0,-4", 40),
    "axisymmetric": ("64,1,72", "64,1,64", "3,1,3", "0,0,-4", 40),
    "3d": ("20,20,24", "20,20,20", "2,2,2", "0,0,-4", 20),
}
METHODS = {
    "ddmp": ("ddmp", ""), "mpm": ("mpm", ""), "gimp": ("mpm", "basis='gimp'"),
    "quadratic": ("mpm", "basis='quadratic'"), "cubic": ("mpm", "basis='cubic'"), "cpdi": ("mpm", "basis='cpdi'"),
}
ELASTIC = "bulk=1.0e6  shear=5.0e5"
MATERIALS = {  # words of &material, of &effects
    "elastic": (ELASTIC, ""),
    "von_mises": (f"{ELASTIC}  strength_model='von_mises'  yield=1.0e4", ""),
    "johnson_cook": ("shear=5.0e5  eos_model='mie_gruneisen'  mg_c0=32  mg_s=1.3  mg_gamma=2  "
                     "strength_model='johnson_cook'  jc_a=1.0e4  jc_b=3.0e4  jc_n=0.3", "rate=.false."),
    "drucker_prager": (f"{ELASTIC}  strength_model='drucker_prager'  friction_angle=30", ""),
}
PHASES = {"sort, move tiles": "sort", "points to nodes": "to nodes", "grid": "nodes", "exchange": "exchange",
          "nodes to points": "to particles", "waiting for ranks": "waiting",
          **dict.fromkeys(("strength", "eos", "voids", "damage", "thermal", "artificial_viscosity"), "matter")}
COLUMNS = tuple(dict.fromkeys(PHASES.values()))


def plan():
    """Names of rows: method, dimension, material, ranks x threads."""
    rows = [(method, dimension, "elastic", "1x1") for dimension in DIMENSIONS for method in METHODS]
    rows += [("ddmp", dimension, material, "1x1") for dimension in DIMENSIONS for material in list(MATERIALS)[1:]]
    rows += [("mpm", "3d", "von_mises", "1x1")]
    return rows + [("ddmp", dimension, "elastic", layout) for dimension in ("plane_strain", "3d")
                   for layout in ("2x1", "1x2")]


def run(options, name):
    """One run of a row; its summary."""
    method, dimension, material, layout = name
    upper, block, ppc, velocity, steps = DIMENSIONS[dimension]
    (key, words), (matter, effects) = METHODS[method], MATERIALS[material]
    folder = options.work / "run"
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    (folder / "scene.nml").write_text(SCENE.format(
        dimension=dimension, method=key, words=words, upper=upper, block=block, ppc=ppc, velocity=velocity,
        steps=steps, material=matter, effects=effects), encoding="ascii")
    ranks, threads = layout.split("x")
    command = [options.scree, "-q", "--case", "scene", "--outdir", folder, folder / "scene.nml"]
    if ranks != "1":
        command = ["mpiexec", "-n", ranks, "--bind-to", "none", *command]
    environment = {"OMPI_ALLOW_RUN_AS_ROOT": "1", "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM": "1", "OMP_WAIT_POLICY": "passive",
                   "OMPI_MCA_rmaps_base_oversubscribe": "1", **os.environ, "OMP_NUM_THREADS": threads}
    done = subprocess.run([str(word) for word in command], env=environment, text=True, check=False,
                          stdout=subprocess.PIPE, stderr=subprocess.STDOUT)
    if done.returncode:
        sys.exit(f"{' '.join(name)} ended with exit code {done.returncode}:\n{done.stdout[-2000:]}")
    return json.loads((folder / "scene.summary.json").read_text(encoding="utf-8"))


def stream(program, threads=1):
    """Gigabytes a second of copy and triad of each thread."""
    done = subprocess.run([str(program)], env={**os.environ, "OMP_NUM_THREADS": str(threads)}, text=True, check=True,
                          stdout=subprocess.PIPE)
    return {word: float(re.search(rf"{word} GB/s ([\d.]+)", done.stdout).group(1)) for word in ("copy", "triad")}


def row_of(name, summaries, bandwidth):
    """The row of the table from the summaries of some runs and the bandwidth of a triad [GB/s]."""
    best = min(summaries, key=lambda summary: summary["processor_s"] / summary["particle_updates"])
    spent = 1.0e9 * best["processor_s"] / best["particle_updates"]
    phases = dict.fromkeys(COLUMNS, 0.0)
    for phase, short in PHASES.items():
        phases[short] += best["timers"].get(phase, {"avg": 0.0})["avg"]
    whole = sum(phases.values()) or 1.0
    size = best["bytes_per_particle"]
    return {"method": name[0], "dimension": name[1], "material": name[2], "layout": name[3],
            "particles": best["particles"], "steps": best["steps"], "ns": spent, "updates_per_core_s": 1.0e9 / spent,
            "updates_per_wall_s": max(summary["particle_updates_per_s"] for summary in summaries),
            **{f"ns {short}": spent * part / whole for short, part in phases.items()},
            "bytes": size, "bandwidth": 2.0 * size / spent / bandwidth, "ratio": spent / (8.0 / bandwidth)}


def key_of(row):
    """Name of a row in the reference."""
    return " ".join((row["method"], row["dimension"], row["material"], row["layout"]))


def slower(rows, stored, factor=SLOWER):
    """Sentences on rows whose ratio is more than `factor` times the stored one, and on rows that are not stored."""
    told = []
    for row in rows:
        key, before = key_of(row), stored.get(key_of(row))
        if before is None:
            told.append(f"{key}: no reference; --store makes one")
        elif row["ratio"] > factor * before:
            told.append(f"{key}: {row['ratio'] / before:.2f} times slower than the reference, limit {factor:g}")
    return told


def shortfalls(rows):
    """Sentences on rates that are not what they should be beside others, and all of those ratios."""
    rates = {key_of(row): row["updates_per_core_s"] for row in rows}
    told, seen = [], {}
    for low, high, least in (
            *((f"{method} {dimension} von_mises 1x1", f"{method} {dimension} elastic 1x1", LEAST_PLASTIC)
              for dimension in DIMENSIONS for method in METHODS),
            *((f"{method} {dimension} elastic 1x1", f"{method} 3d elastic 1x1", LEAST_FLAT)
              for dimension in ("plane_strain", "axisymmetric") for method in METHODS)):
        if low in rates and high in rates:
            share = rates[low] / rates[high]
            seen[low, high] = share
            if share < least:
                told.append(f"{low} has {share:.2f} of the rate of {high}, at least {least:g} is asked")
    return told, seen


def markdown(rows, memory):
    """The readable table."""
    shorts = [short for short in COLUMNS if any(row[f"ns {short}"] > 0.005 * row["ns"] for row in rows)]
    lines = [f"Copy {memory['copy']:.1f} GB/s, triad {memory['triad']:.1f} GB/s on one thread: "
             f"{8.0 / memory['triad']:.2f} ns for 8 bytes.", "",
             "| method | dimension | material | ranks x threads | million updates/core-s | ns | "
             + " | ".join(shorts) + " | bytes | of the bandwidth |", "|---" * (8 + len(shorts)) + "|"]
    for row in rows:
        lines.append(f"| {row['method']} | {row['dimension']} | {row['material']} | {row['layout']} | "
                     f"{1e-6 * row['updates_per_core_s']:.2f} | {row['ns']:.0f} | "
                     + " | ".join(f"{row[f'ns {short}']:.0f}" for short in shorts)
                     + f" | {row['bytes']:.0f} | {100 * row['bandwidth']:.0f} % |")
    _, seen = shortfalls(rows)
    lines += ["", "| rate of | over that of | |", "|---|---|---|"]
    lines += [f"| {low} | {high} | {share:.2f} |" for (low, high), share in seen.items()]
    return "\n".join(lines) + "\n"


def write(options, rows, memory):
    """Files of the work folder, and the page if it is asked for."""
    (options.work / "table.json").write_text(json.dumps({"memory": memory, "rows": rows}, indent=1), encoding="utf-8")
    with open(options.work / "table.csv", "w", newline="", encoding="utf-8") as file:
        writer = csv.DictWriter(file, rows[0], lineterminator="\n")
        writer.writeheader()
        writer.writerows(rows)
    text = markdown(rows, memory)
    (options.work / "table.md").write_text(text, encoding="utf-8")
    if options.write:
        page = Path(options.write)
        old = page.read_text(encoding="utf-8")
        page.write_text(re.sub(r"(<!-- table -->\n).*(<!-- end -->)", lambda found: found[1] + text + found[2], old,
                               flags=re.S), encoding="utf-8")
    print(text)


def main():
    """Run in turn, write, compare."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--scree", type=Path, required=True)
    parser.add_argument("--stream", type=Path, help="bench_stream; default: beside the program")
    parser.add_argument("--work", type=Path, required=True)
    parser.add_argument("--only", default="", help="rows whose name holds this")
    parser.add_argument("--repeat", type=int, default=3)
    parser.add_argument("--write", help="page that holds the table")
    parser.add_argument("--store", action="store_true", help="take the ratios as the new reference")
    options = parser.parse_args()
    options.scree, options.work = options.scree.resolve(), options.work.resolve()
    kernel = options.stream or options.scree.parent / "bench_stream"
    names = [name for name in plan() if options.only in " ".join(name)]
    if not names:
        sys.exit(f"no row has '{options.only}' in its name")
    found, memory = {name: [] for name in names}, {"copy": 0.0, "triad": 0.0}
    for turn in range(options.repeat):
        memory = {word: max(value, memory[word]) for word, value in stream(kernel).items()}
        for name in names:
            found[name].append(run(options, name))
            print(f"{turn + 1} of {options.repeat}  {' '.join(name)}", file=sys.stderr, flush=True)
    rows = [row_of(name, found[name], memory["triad"]) for name in names]
    write(options, rows, memory)
    stored = json.loads(REFERENCE.read_text(encoding="utf-8")) if REFERENCE.exists() else {}
    if options.store:
        stored.update({key_of(row): round(row["ratio"], 1) for row in rows})
        REFERENCE.write_text(json.dumps(stored, indent=1, sort_keys=True) + "\n", encoding="utf-8")
    warnings = slower(rows, stored) + shortfalls(rows)[0]
    print("\n".join(f"warning: {text}" for text in warnings) or "as fast as the reference")
    return 1 if warnings else 0


if __name__ == "__main__":
    sys.exit(main())
