#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Measure the speedup with ranks and threads, and compare the communication volume with a model.

    build/venv/bin/python scripts/scaling.py --work /tmp/scaling --cells 48 --steps 30

A block of elastic material is run on layouts "ranks x threads". Strong scaling: the same block for all
layouts. Weak scaling: the length of the block is proportional to ranks times threads. All layouts are
run alternately, several times, and the medians of ratios are reported, because the load of a machine
varies. Output: scaling.csv, scaling.md (a table) and scaling.png in the work folder.
"""
import argparse
import csv
import json
import os
import statistics
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
LAYOUTS = "1x1,2x1,1x2,4x1,2x2,1x4"
TILE_CELLS, TILE_NODES = 6, 7           # along an edge of a tile, three dimensions
# numbers on a node in each exchange of a step with the default method
EXCHANGES = {"mpm": (7, 3), "ddmp": (17,)}
DECK = """
&run  dimension='3d'  method='{method}' /
&grid  lo=0,0,0  hi={length},{cells},{cells}  dx=1 /
&time  t_end=1.0e9  max_steps={steps} /
&method  {words} /
&material  name='rubber'  density=1000  young=1.0e6  poisson=0.3 /
&region  name='box'  shape='box'  lo=0,0,0  hi={length},{cells},{cells} /
&body  name='block'  region='box'  material='rubber'  velocity=0.3,-0.2,0.1 /
&boundary  face='all'  type='periodic' /
&output  name='p'  kind='particles'  times=0 /
&output  name='h'  kind='history'  every=1000000 /
&checkpoint  at_end=.false. /
&log  progress_seconds=1000 /
"""


def model(method, cells, ranks):
    """Predicted messages and bytes of patches a step and rank. A piece of the curve is taken for a
    cube of e tiles along an edge among other such cubes: each of 6 of them sees e^2 of its tiles,
    each of 12 e, each of 8 one. Few ranks see each of its tiles at most once each."""
    tiles = cells / TILE_CELLS ** 3 / ranks
    edge = tiles ** (1.0 / 3.0)
    copies = min(6 * edge ** 2 + 12 * edge + 8, tiles * (ranks - 1))
    words = sum(1 + columns * TILE_NODES ** 3 for columns in EXCHANGES[method])
    return len(EXCHANGES[method]) * min(26, ranks - 1), 8 * copies * words


def run(options, method, ranks, threads, length, name):
    """One run; the summary of it."""
    folder = options.work / name
    folder.mkdir(parents=True, exist_ok=True)
    deck = folder / "block.nml"
    deck.write_text(DECK.format(method=method, length=length, cells=options.cells,
                                steps=options.steps, words=options.method_words),
                    encoding="utf-8")
    command = [options.scree, "-q", "--overwrite", "--case", "block", "--outdir", folder, deck]
    if ranks > 1:
        command = ["mpiexec", "-n", ranks, "--bind-to", "none", *command]
    environment = {"OMPI_MCA_rmaps_base_oversubscribe": "1", "OMP_WAIT_POLICY": "passive",
                   "OMPI_MCA_btl_vader_single_copy_mechanism": "none",
                   "PRTE_MCA_rmaps_default_mapping_policy": ":oversubscribe",
                   **os.environ, "OMP_NUM_THREADS": str(threads)}
    if os.geteuid() == 0:
        environment.update(OMPI_ALLOW_RUN_AS_ROOT="1", OMPI_ALLOW_RUN_AS_ROOT_CONFIRM="1")
    answer = subprocess.run([str(word) for word in command], env=environment, text=True,
                            stdout=subprocess.PIPE, stderr=subprocess.STDOUT)
    if answer.returncode != 0:
        sys.exit(f"scaling: {' '.join(map(str, command))} ended with exit code "
                 f"{answer.returncode}:\n{answer.stdout[-2000:]}")
    return json.loads((folder / "block.summary.json").read_text(encoding="utf-8"))


def measure(options, method, kind, layouts):
    """Rows of the table for one kind of scaling."""
    rates = {layout: [] for layout in layouts}
    waits, seen = {}, {}
    for repeat in range(options.repeat):
        for ranks, threads in layouts:
            length = options.cells * (ranks * threads if kind == "weak" else 1)
            if sys.stderr.isatty() or options.verbose:
                print(f"  {method} {kind} {ranks} x {threads}, {repeat + 1} of {options.repeat}",
                      file=sys.stderr, flush=True)
            summary = run(options, method, ranks, threads, length, f"{method}_{kind}")
            rates[ranks, threads].append(summary["particle_updates_per_s"])
            timers = summary["timers"]
            waits[ranks, threads] = timers["waiting for ranks"]["avg"] / max(
                sum(entry["avg"] for entry in timers.values()), 1e-30)
            seen[ranks, threads] = summary
    base = layouts[0]
    rows = []
    for ranks, threads in layouts:
        speedup = statistics.median(
            rate / first for rate, first in zip(rates[ranks, threads], rates[base]))
        summary = seen[ranks, threads]
        steps = summary["steps"] * ranks
        traffic = summary.get("traffic", {"patch_messages": 0, "patch_bytes": 0})
        length = options.cells * (ranks * threads if kind == "weak" else 1)
        messages, sent = model(method, length * options.cells ** 2, ranks)
        rows.append({
            "method": method, "kind": kind, "ranks": ranks, "threads": threads,
            "particles": summary["particles"],
            "updates_per_s": statistics.median(rates[ranks, threads]), "speedup": speedup,
            "efficiency": speedup * base[0] * base[1] / (ranks * threads),
            "waiting_share": waits[ranks, threads],
            "messages": traffic["patch_messages"] / steps, "messages_model": messages,
            "bytes": traffic["patch_bytes"] / steps, "bytes_model": sent})
    return rows


def table(rows):
    """The rows in Markdown."""
    lines = ["| method | scaling | ranks x threads | particles | million updates/s | speed-up | "
             "efficiency | waiting | messages, model | MB, model |",
             "|---|---|---|---|---|---|---|---|---|---|"]
    for row in rows:
        lines.append(
            f"| {row['method']} | {row['kind']} | {row['ranks']} x {row['threads']} | "
            f"{row['particles']} | {row['updates_per_s'] / 1e6:.2f} | {row['speedup']:.2f} | "
            f"{row['efficiency']:.2f} | {100 * row['waiting_share']:.0f} % | "
            f"{row['messages']:.1f}, {row['messages_model']:.0f} | "
            f"{row['bytes'] / 1e6:.2f}, {row['bytes_model'] / 1e6:.2f} |")
    return "\n".join(lines) + "\n"


def draw(rows, path):
    """Speed-up against the number of threads on all ranks, pure and hybrid layouts apart."""
    import matplotlib
    matplotlib.use("Agg")
    import matplotlib.pyplot as plt
    kinds = sorted({(row["method"], row["kind"]) for row in rows})
    figure, panels = plt.subplots(1, len(kinds), figsize=(3.6 * len(kinds), 3.4), squeeze=False)
    modes = (("ranks", "o-", "#1f5a93", lambda row: row["threads"] == 1),
             ("threads", "s-", "#b3311b", lambda row: row["ranks"] == 1),
             ("both", "^", "#2f7d3b", lambda row: row["ranks"] > 1 and row["threads"] > 1))
    for panel, (method, kind) in zip(panels[0], kinds):
        for label, mark, colour, chosen in modes:
            points = sorted((row["ranks"] * row["threads"], row["speedup"]) for row in rows
                            if (row["method"], row["kind"]) == (method, kind) and chosen(row))
            if points:
                panel.plot(*zip(*points), mark, color=colour, label=label)
        most = max(row["ranks"] * row["threads"] for row in rows)
        panel.plot([1, most], [1, most], color="#8a8a8a", lw=0.8, ls="--", label="ideal")
        panel.axvline(os.cpu_count(), color="#cccccc", lw=0.8)
        panel.set(title=f"{method}, {kind}", xlabel="ranks times threads", ylabel="speed-up",
                  ylim=(0, None))
    panels[0][0].legend(frameon=False)
    figure.tight_layout()
    figure.savefig(path, dpi=110)


def main():
    """Measure, write, draw."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--scree", type=Path, default=ROOT / "build/bin/scree")
    parser.add_argument("--work", type=Path, default=Path("scaling"), help="folder for results")
    parser.add_argument("--cells", type=int, default=48, help="cells along an edge of the block")
    parser.add_argument("--steps", type=int, default=30)
    parser.add_argument("--repeat", type=int, default=3)
    parser.add_argument("--layouts", default=LAYOUTS, help="ranks x threads, the reference layout first")
    parser.add_argument("--methods", default="ddmp,mpm")
    parser.add_argument("--kinds", default="strong,weak")
    parser.add_argument("--method-words", default="", help="keys of &method, such as \"flip=1.0\"")
    parser.add_argument("-v", "--verbose", action="store_true", help="report each run")
    options = parser.parse_args()
    options.scree, options.work = options.scree.resolve(), options.work.resolve()
    layouts = [tuple(map(int, word.split("x"))) for word in options.layouts.split(",")]
    rows = [row for method in options.methods.split(",") for kind in options.kinds.split(",")
            for row in measure(options, method, kind, layouts)]
    with open(options.work / "scaling.csv", "w", newline="", encoding="utf-8") as file:
        writer = csv.DictWriter(file, rows[0])
        writer.writeheader()
        writer.writerows(rows)
    (options.work / "scaling.md").write_text(table(rows), encoding="utf-8")
    draw(rows, options.work / "scaling.png")
    print(table(rows), end="")


if __name__ == "__main__":
    main()
