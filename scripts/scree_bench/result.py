# SPDX-License-Identifier: BSD-3-Clause
"""Results: derived numbers of each case, and the file of all results.

A result is a dictionary: the case, its layout, and for each program (one, or two that alternate) all runs and the
numbers derived from them. The speed is computed from the processor time of the steps, so start and output do not
contribute. The copy speed is that of one core.
"""
import json
import statistics

from scree.errors import EXIT_USAGE, ScreeError, readable

SCHEMA, SCHEMA_VERSION = "scree-bench", 1
#: Names of phases in tables, by the names of timers of a summary. A phase that is not listed keeps its name.
PHASES = {"sort, move tiles": "sort", "points to nodes": "to nodes", "grid": "nodes", "exchange": "exchange",
          "nodes to points": "to particles", "waiting for ranks": "waiting", "heat conduction": "conduction",
          "contact": "contact",
          **dict.fromkeys(("strength", "eos", "voids", "damage", "thermal", "artificial_viscosity"), "material")}
OUTSIDE = ("ledger, history", "output", "checkpoint")    # timers that are no part of the steps


def taken(summary):
    """The values of CASE.summary.json that are stored."""
    return {"processor_s": summary["processor_s"], "particle_updates": summary["particle_updates"],
            "particle_updates_per_s": summary["particle_updates_per_s"], "particles": summary["particles"],
            "steps": summary["steps"], "bytes_per_particle": summary["bytes_per_particle"],
            "timers": {name: entry["avg"] for name, entry in summary["timers"].items()}}


def started(run, digest, why, programs):
    """The result of a case before its first repeat."""
    return {"case": run.key, "about": run.case.about, "ranks": run.ranks, "threads": run.threads, "deck": digest,
            "skipped": why, "programs": [{"runs": [], "failed": ""} for _ in range(programs)]}


def phases_of(timers, whole):
    """The time `whole`, divided among the phases in proportion to the timers."""
    found = {}
    for name, seconds in timers.items():
        if name not in OUTSIDE:
            phase = PHASES.get(name, name)
            found[phase] = found.get(phase, 0.0) + max(seconds, 0.0)
    total = sum(found.values())
    return {phase: whole * seconds / total for phase, seconds in found.items()} if total > 0.0 else {}


def all_timers(runs):
    """Sum of the timers over all repeats. This is more accurate because material models are timed only in a few steps
    of each run."""
    return {name: sum(raw["timers"].get(name, 0.0) for raw in runs) for raw in runs for name in raw["timers"]}


def nanoseconds(raw):
    """Processor time per particle and step [ns]."""
    return 1.0e9 * raw["processor_s"] / raw["particle_updates"]


def finish(entry):
    """Compute the numbers of a result from its runs so far."""
    cores = entry["ranks"] * entry["threads"]
    for one in entry["programs"]:
        good = [raw for raw in one["runs"] if "failed" not in raw and raw["particle_updates"] > 0
                and raw["processor_s"] > 0.0]
        one["failed"] = next((raw["failed"] for raw in one["runs"] if "failed" in raw), "")
        if not good:
            if one["runs"]:
                one["failed"] = one["failed"] or "no step was made"
            continue
        best = min(good, key=nanoseconds)
        spent = [nanoseconds(raw) for raw in good]
        copies = [raw[when]["copy"] / cores for raw in good for when in ("copy_before", "copy_after")]
        one.update(
            # the least time, because other processes can only increase it
            particles=best["particles"], steps=best["steps"], bytes_per_particle=best["bytes_per_particle"],
            ns=min(spent), ns_median=statistics.median(spent), ns_most=max(spent),
            updates_per_core_s=1.0e9 / min(spent),
            updates_per_wall_s=max(raw["particle_updates_per_s"] for raw in good),
            copy_gb_s=max(copies), copy_gb_s_median=statistics.median(copies),
            updates_per_mb=updates_per_mb(min(spent), max(copies)),
            phases_ns=phases_of(all_timers(good), min(spent)))
    if len(entry["programs"]) == 2:
        entry["turns"] = turns(entry["programs"])


def updates_per_mb(spent, copy):
    """Particle updates in the time in which one core copies a megabyte, where read and written bytes are added [1/MB].

    spent: [ns], copy: [GB/s].
    """
    return 1.0e6 / (spent * copy)


def turns(programs):
    """Ratio of the speeds of the first and the second program, from runs of the same repeat."""
    first, second = ({raw["repeat"]: nanoseconds(raw) for raw in one["runs"] if "failed" not in raw}
                     for one in programs)
    ratios = sorted(second[repeat] / first[repeat] for repeat in first if repeat in second)
    if not ratios:
        return {}
    return {"ratios": ratios, "median": statistics.median(ratios), "least": ratios[0], "most": ratios[-1],
            "of_best": min(second.values()) / min(first.values())}


def document(about, results):
    """The content of the file as a dictionary; `about` describes machine, programs, size and so on."""
    return {"schema": SCHEMA, "schema_version": SCHEMA_VERSION, **about, "results": results}


def write(path, whole):
    """Write the file. If that fails, an error with a message is raised."""
    try:
        with open(path, "w", encoding="utf-8") as handle:
            json.dump(whole, handle, indent=1)
            handle.write("\n")
    except OSError as error:
        raise ScreeError(f"cannot write {path}: {error.strerror}; choose another file with --out") from error


def read(path):
    """Read a file of results."""
    try:
        with open(readable(path), encoding="utf-8") as handle:
            whole = json.load(handle)
    except (UnicodeDecodeError, ValueError) as error:
        raise ScreeError(f"{path} is not JSON, or cut short: {error}") from error
    except OSError as error:
        raise ScreeError(f"cannot read {path}: {error.strerror}") from error
    if not isinstance(whole, dict) or whole.get("schema") != SCHEMA:
        raise ScreeError(f"{path} holds no results of scree-bench; make some with scree-bench --out FILE.json")
    if whole.get("schema_version") != SCHEMA_VERSION:
        raise ScreeError(f"{path} has version {whole.get('schema_version')} of the results, this scree-bench reads "
                        f"version {SCHEMA_VERSION}; measure again")
    return whole


def comparable(first, second, names):
    """Raise an error if two files hold results that are not comparable."""
    if first["size"] != second["size"]:
        raise ScreeError(f"{names[0]} was measured with --size {first['size']}, {names[1]} with --size "
                        f"{second['size']}: measure one of them again", EXIT_USAGE)
