# SPDX-License-Identifier: BSD-3-Clause
"""Table, CSV and figures of scripts/scaling.py from the summaries of runs."""
import csv
import math
import os
import platform
import statistics
import sys
from pathlib import Path

from scaling_model import EXCHANGES, traffic

ROOT = Path(__file__).resolve().parents[1]
MEGA = 1.0e-6
#: Columns of the tables in the report: heading, key of a row, format.
COMMUNICATION = (("messages, mean", "messages", ".1f"), ("max", "messages_max", ".1f"),
                 ("model", "messages_model", ".0f"), ("MB, mean", "megabytes", ".3f"), ("max", "megabytes_max", ".3f"),
                 ("model", "megabytes_model", ".3f"), ("collective calls", "collectives", ".2f"),
                 ("their bytes", "collective_bytes", ".0f"))
WORK = (("particles", "particles", "d"), ("of a rank, mean", "particles_of_rank", ".0f"),
        ("max/mean", "particles_imbalance", ".2f"), ("nodes of a rank, mean", "nodes", ".0f"),
        ("max/mean", "nodes_imbalance", ".2f"), ("tiles, mean", "tiles", ".1f"),
        ("ghosts/tiles", "halo", ".2f"), ("digest", "digest", "s"))
MEMORY = (("private, mean [MB]", "memory", ".1f"), ("max [MB]", "memory_max", ".1f"),
          ("of MPI at its start [MB]", "memory_mpi", ".1f"), ("rest [MB]", "memory_rest", ".1f"),
          ("resident peak, max [MB]", "memory_peak", ".1f"), ("arrays of one entry per rank [kB]", "by_ranks", ".1f"),
          ("tiles listed at start", "listed", "d"))
TIME = (("million updates/s", "rate", ".2f"), ("speed-up", "speedup", ".2f"), ("efficiency", "efficiency", ".2f"),
        ("waiting", "waiting", ".0%"))


def row(method, kind, summary, rates, tiles):
    """A row from the summary of a run. `rates` are particle updates per second, and empty if times are not meaningful;
    `tiles` is the number of tiles per rank in weak scaling."""
    counts, ranks = summary["rank_counts"], summary["ranks"]
    steps = counts["steps"]
    each = {name: value["avg"] / steps for name, value in counts.items() if name != "steps"}
    most = {name: value["max"] / steps for name, value in counts.items() if name != "steps"}
    memory = {name: value for name, value in counts.items() if name.startswith("memory")}
    sent = traffic(method, tiles if kind == "weak" else each["tiles"], ranks)
    timers = summary["timers"]
    return {
        "method": method, "kind": kind, "ranks": ranks, "threads": summary["threads"], "steps": steps,
        "messages": each["messages"], "messages_max": most["messages"], "messages_model": sent[0],
        "megabytes": MEGA * each["bytes"], "megabytes_max": MEGA * most["bytes"], "megabytes_model": MEGA * sent[1],
        "collectives": each["collective_calls"], "collective_bytes": each["collective_bytes"],
        "particles": summary["particles"], "particles_of_rank": each["particle_updates"],
        "particles_imbalance": most["particle_updates"] / each["particle_updates"],
        "nodes": each["nodes"], "nodes_imbalance": most["nodes"] / each["nodes"], "tiles": each["tiles"],
        "halo": each["ghost_tiles"] / each["tiles"], "digest": summary["digest"],
        "memory": MEGA * memory["memory_private_bytes"]["avg"],
        "memory_max": MEGA * memory["memory_private_bytes"]["max"],
        "memory_mpi": MEGA * memory["memory_of_mpi_bytes"]["avg"],
        "memory_rest": MEGA * (memory["memory_private_bytes"]["avg"] - memory["memory_of_mpi_bytes"]["avg"]),
        "memory_peak": MEGA * memory["memory_peak_bytes"]["max"],
        "by_ranks": 1.0e-3 * memory["memory_by_ranks_bytes"]["max"],
        "listed": summary.get("traffic", {}).get("tiles_listed_at_start", summary.get("tiles", 0)),
        "rate": MEGA * statistics.median(rates) if rates else math.nan,
        "waiting": timers["waiting for ranks"]["avg"] / max(1e-30, sum(entry["avg"] for entry in timers.values()))
        if rates else math.nan,
        "wall": summary["wall_s"]}


def add_speed(rows):
    """Add speed-up and efficiency relative to the first row of the same method and kind."""
    for entry in rows:
        first = next(other for other in rows if all(other[key] == entry[key] for key in ("method", "kind")))
        entry["speedup"] = entry["rate"] / first["rate"]
        workers = entry["ranks"] * entry["threads"] / (first["ranks"] * first["threads"])
        entry["efficiency"] = entry["speedup"] / workers


def differing_digests(rows):
    """Digests of runs of the same scene that differ from the first of them."""
    first = {}
    return [entry["digest"] for entry in rows if entry["kind"] == "strong"
            and first.setdefault(entry["method"], entry["digest"]) != entry["digest"]]


def cell(value, form):
    """A value as text; a dash if it was not measured."""
    return "-" if isinstance(value, float) and math.isnan(value) else format(value, form)


def table(rows, columns):
    """The given columns of the rows as a table in Markdown."""
    lines = ["| ranks x threads | " + " | ".join(heading for heading, _, _ in columns) + " |",
             "|" + "---|" * (len(columns) + 1)]
    for entry in rows:
        lines.append(f"| {entry['ranks']} x {entry['threads']} | "
                     + " | ".join(cell(entry[key], form) for _, key, form in columns) + " |")
    return "\n".join(lines)


def growth(rows):
    """Fit of the memory per rank by a straight line over the number of ranks, by least squares, for 27 ranks or more,
    where every rank has all its neighbours: slope [MB per rank] and intercept [MB], with and without the memory of
    MPI at its start. None with fewer than three layouts."""
    points = [(entry["ranks"], entry["memory"], entry["memory_rest"]) for entry in rows if entry["ranks"] >= 27]
    if len(points) < 3:
        return None
    import numpy
    ranks, memory, rest = zip(*points)
    return [tuple(numpy.polyfit(ranks, values, 1)) for values in (memory, rest)]


def report(rows, scene):
    """The report in Markdown."""
    parts = ["# Scaling report", "",
             f"{platform.processor() or platform.machine()}, {os.cpu_count()} cores; {scene}. Messages, bytes, calls, "
             "particles and nodes are means over the steps, of a rank and a step. Times are given where every thread "
             "has a core.", ""]
    for method in EXCHANGES:
        for kind in ("weak", "strong"):
            chosen = [entry for entry in rows if (entry["method"], entry["kind"]) == (method, kind)]
            if not chosen:
                continue
            parts += [f"## {method}, {kind} scaling", "", "### Communication", "", table(chosen, COMMUNICATION), "",
                      "### Work", "", table(chosen, WORK), "", "### Memory", "", table(chosen, MEMORY), ""]
            fit = growth(chosen) if kind == "weak" else None
            if fit:
                parts += ["From 27 ranks on, private memory of a rank by least squares: "
                          f"{fit[0][1]:.1f} MB + {1e6 * fit[0][0]:.0f} bytes per rank; without that of MPI at its "
                          f"start: {fit[1][1]:.1f} MB + {1e6 * fit[1][0]:.0f} bytes per rank.", ""]
            if kind == "strong":
                same = not differing_digests(chosen)
                parts += ["All layouts end with the same digest." if same else
                          "**The digests differ: results depend on the ranks.**", ""]
            if any(not math.isnan(entry["rate"]) for entry in chosen):
                parts += ["### Time", "", table([entry for entry in chosen if not math.isnan(entry["rate"])], TIME), ""]
    return "\n".join(parts)


def panel(axes, rows, keys, ylabel, log=True):
    """Curves of some quantities over the number of ranks."""
    from scree.plot import COLOURS
    for colour, (key, label, style) in zip(COLOURS, keys):
        points = [(entry["ranks"], entry[key]) for entry in rows if entry[key] > 0]
        if points:
            axes.plot(*zip(*points), style, color=colour, ms=4, lw=1.4, label=label)
    axes.set(xscale="log", xlabel="ranks", ylabel=ylabel)
    axes.set_xscale("log", base=2)
    if log:
        axes.set_yscale("log")
    else:
        axes.set_ylim(0, None)
    axes.spines[["top", "right"]].set_visible(False)
    axes.legend(frameon=False, fontsize=8)


def draw(rows, title, path):
    """Four panels of one kind of scaling: messages, bytes, balance and halo, memory."""
    import matplotlib
    matplotlib.use("Agg")
    import matplotlib.pyplot as plt
    figure, axes = plt.subplots(2, 2, figsize=(9.0, 6.6), layout="constrained")
    panel(axes[0][0], rows, (("messages", "messages, mean", "o-"), ("messages_max", "messages, busiest rank", "^--"),
                             ("messages_model", "patches, model", ":"), ("collectives", "collective calls", "s-")),
          "per step and rank", log=False)
    panel(axes[0][1], rows, (("megabytes", "mean", "o-"), ("megabytes_max", "busiest rank", "^--"),
                             ("megabytes_model", "patches, model", ":")), "sent per step and rank [MB]", log=False)
    panel(axes[1][0], rows, (("particles_imbalance", "particles, max/mean", "o-"),
                             ("nodes_imbalance", "nodes, max/mean", "s-"), ("halo", "ghost tiles per own tile", "^--")),
          "ratio", log=False)
    panel(axes[1][1], rows, (("memory", "private memory", "o-"), ("memory_rest", "without MPI at its start", "s-"),
                             ("memory_mpi", "MPI at its start", "^--")), "memory of a rank [MB]", log=False)
    figure.suptitle(title)
    figure.savefig(path, dpi=200)
    plt.close(figure)


def draw_time(rows, path):
    """Speed-up of the layouts that were timed."""
    import matplotlib
    matplotlib.use("Agg")
    import matplotlib.pyplot as plt
    from scree.plot import COLOURS
    figure = plt.figure(figsize=(8.2, 5.0), layout="constrained")
    axes = figure.add_subplot()
    axes.spines[["top", "right"]].set_visible(False)
    names = sorted({(entry["method"], entry["kind"]) for entry in rows})
    for colour, name in zip(COLOURS, names):
        points = sorted((entry["ranks"] * entry["threads"], entry["speedup"]) for entry in rows
                        if (entry["method"], entry["kind"]) == name)
        axes.plot(*zip(*points), "o-", color=colour, label=", ".join(name))
    most = max(entry["ranks"] * entry["threads"] for entry in rows)
    axes.plot([1, most], [1, most], "k:", lw=1, label="ideal")
    axes.set(xlabel="ranks times threads", ylabel="speed-up", ylim=(0, None))
    axes.legend(frameon=False)
    figure.savefig(path, dpi=200)
    plt.close(figure)


def write(folder, rows, scene):
    """Write scaling.csv, scaling.md and the figures of all rows so far."""
    sys.path.insert(0, str(ROOT / "python/src"))
    add_speed(rows)
    with open(folder / "scaling.csv", "w", newline="", encoding="utf-8") as file:
        writer = csv.DictWriter(file, rows[0])
        writer.writeheader()
        writer.writerows(rows)
    (folder / "scaling.md").write_text(report(rows, scene), encoding="utf-8")
    for method, kind in sorted({(entry["method"], entry["kind"]) for entry in rows}):
        chosen = [entry for entry in rows if (entry["method"], entry["kind"]) == (method, kind)]
        draw(chosen, f"{method}, {kind} scaling, {scene}", folder / f"scaling_{method}_{kind}.png")
    timed = [entry for entry in rows if not math.isnan(entry["rate"])]
    if timed:
        draw_time(timed, folder / "scaling_time.png")
