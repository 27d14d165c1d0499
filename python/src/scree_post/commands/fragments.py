# SPDX-License-Identifier: BSD-3-Clause
"""Finds fragments: connected particles that have not failed.

Particles are neighbours if their distance is at most --reach times the mean of their widths (1.5
connects the particles of a lattice along edges and face diagonals), or with --cell if they are in
the same or in adjacent cells. With --bonds they are neighbours if they were so in the first
snapshot of the series, and their distance has grown less than --stretch times: fragments that touch
again remain two, also two bodies. The table has one line per fragment, the heaviest first. In
axisymmetry fragments are rings. Models are completed at mirror planes: a fragment across the plane
is counted once, with its full mass, any other fragment once on each side. Fragments continue across
periodic boundaries. Two runs are compared: their distributions of masses and cumulative masses.
With --seeds the sources are decks, each of which is run with that number of seeds (&run seed = 1,
2, ...), as many at a time as there are cores; finished runs are not run again.
"""
from __future__ import annotations

import argparse
import os
from collections.abc import Sequence

import numpy as np

from scree.drawing import look
from scree.drawing.quantity import quantity
from scree.errors import EXIT_DIFFERENT, EXIT_USAGE, ScreeError, readable
from scree.files import Moment, beside, nearest, series, series_file, snapshot

from ..fragment_bonds import STRETCH
from ..fragment_curves import Fit, Sample, compared, fits, resolved_mass, verdict, with_error
from ..fragment_ensemble import ensembles, planned, seeds_differ
from ..fragment_pages import curves_page, history_page
from ..fragment_table import COLUMNS, COUNTS, FIELDS, RESOLVED, Fragments, fragments_of, reference_bonds
from ..progress import Progress

SUMMARY = "connected intact particles: table, masses, distributions, ensembles of seeds"
EXAMPLES = ("fragments out/debris_cloud",
            "fragments out/debris_cloud --time 5us 10us --reach 2",
            "fragments out/debris_cloud_3d --all --cell 0.4mm --table pieces.csv",
            "fragments out/debris_cloud_3d --bonds --history --plot",
            "fragments bar.nml --seeds 40 --bonds --set grid.dx=2e-3,1.4e-3 --fit")
SHOWN = 10               # lines of the table on the screen


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """The options."""
    add = parser.add_argument
    add("source", metavar="SERIES_OR_SNAPSHOT", nargs="+",
        help="CASE_p.hdf.series, CASE_p_000012.hdf or out/CASE; two are compared; with --seeds a deck or two")
    which = parser.add_mutually_exclusive_group()
    which.add_argument("--time", type=quantity, nargs="+", metavar="T",
                       help="nearest snapshots, in s or with a unit; default the last")
    which.add_argument("--all", action="store_true", help="all snapshots")
    which.add_argument("--history", action="store_true",
                       help="only numbers and masses over time, of all snapshots: CASE_pieces_over_time.csv")
    how = parser.add_mutually_exclusive_group()
    how.add_argument("--reach", type=float, default=1.5, metavar="F",
                     help="neighbours are within F times the mean of their widths (1.5)")
    how.add_argument("--cell", type=quantity, metavar="L",
                     help="neighbours are in the same or adjacent cells of this width, such as 1mm")
    add("--bonds", action="store_true", help="neighbours are those of the first snapshot that are not yet separated")
    add("--stretch", type=float, default=STRETCH, metavar="S",
        help=f"with --bonds: a bond is cut when its length is more than S times the first one ({STRETCH:g})")
    add("--resolved", type=int, default=RESOLVED, metavar="N",
        help=f"fragments of fewer particles are unresolved: stated apart, and not in fits and tests ({RESOLVED})")
    add("--fit", action="store_true", help="fit distributions to the masses of the resolved fragments")
    add("--seeds", type=int, metavar="N", help="run the decks with seeds 1 to N, and use all runs")
    add("--set", metavar="G.K=A,B", action="append", default=[], dest="values",
        help="with --seeds: value of a key; two values are two ensembles")
    add("--jobs", type=int, metavar="N", help="with --seeds: number of simultaneous runs; default: cores")
    add("--scree", metavar="PROGRAM", help="with --seeds: the program; default build/bin/scree or in the path")
    add("--outdir", metavar="DIR", help="with --seeds: folder of the folder NAME_seeds with all results; default out")
    add("--overwrite", action="store_true", help="with --seeds: replace results of another deck or program")
    add("--least", type=int, default=1, metavar="N",
        help="omit fragments of fewer particles from table and picture")
    add("--no-mirror", action="store_true", help="do not complete the model at mirror planes")
    add("--table", metavar="CSV", help="table; default CASE_pieces.csv in the folder of the series")
    add("--plot", action="store_true", help="with --history: also draw it, in CASE_pieces_over_time.png")
    add("--out", metavar="PNG", help="picture; default CASE_pieces.png in the folder of the series")
    add("--dpi", type=int, default=150, help="pixels per inch of the picture (150)")


def search(source: str, arguments: argparse.Namespace) -> tuple[list[Fragments], str]:
    """The fragments of the requested snapshots, and the title of the run."""
    frames = series(source)
    chosen: Sequence[Moment] = frames if arguments.all or arguments.history else nearest(
        frames, arguments.time or [frames[-1][0]])
    bonds = None
    if arguments.bonds:
        if not source.endswith(".series"):
            raise ScreeError(f"{source}: --bonds needs a series, whose first snapshot is the reference", EXIT_USAGE)
        bonds = reference_bonds(snapshot(frames[0][1], FIELDS), arguments.reach, arguments.stretch,
                                not arguments.no_mirror)
    found, title = [], ""
    with Progress(len(chosen), "searching") as progress:
        for _, file in chosen:
            snap = snapshot(file, FIELDS)
            title = snap.title
            found.append(fragments_of(snap, arguments.reach, arguments.cell, not arguments.no_mirror, bonds))
            progress.step()
    return found, title


def write_table(path: str, heads: Sequence[str], rows: Sequence[Sequence[float]], note: str) -> None:
    """A table as comma separated values; the line that begins with # describes it."""
    try:
        with open(path + ".part", "w", encoding="utf-8") as handle:
            handle.write(f"# {note}\n" + ",".join(heads) + "\n")
            handle.writelines(",".join(f"{value:.9g}" for value in row) + "\n" for row in rows)
        os.replace(path + ".part", path)
    except OSError as error:
        raise ScreeError(f"cannot write {path}: {error.strerror or error}") from error
    print(f"wrote {path}")


def shown(one: Fragments, least: int) -> list[tuple[float, ...]]:
    """Rows of the fragments that are not omitted."""
    return [row for row in one.rows if row[2] >= least]


def say(one: Fragments, arguments: argparse.Namespace) -> None:
    """The heaviest fragments, and the distribution of the mass."""
    rows, total = shown(one, arguments.least), max(one.total, 1.0e-300)
    kept = sum(row[3] for row in rows)
    lone = sum(row[2] == 1 for row in rows)
    _, _, resolved, _, _, small, _, _ = one.counts(arguments.resolved)
    print(f"t = {one.time:.6g} s: {len(rows)} fragments, {lone} of them single particles")
    print(f"mass {one.total:.6e} kg: fragments {kept:.6e}, failed {one.failed:.6e}, "
          f"left out {max(0.0, one.total - one.failed - one.absent - kept):.6e}"
          + (f", not in the first snapshot {one.absent:.6e}" if one.absent > 0.0 else ""))
    print(f"{resolved:.0f} fragments of at least {arguments.resolved} particles; fewer: {100.0 * small / total:.3g} % "
          f"of the mass (unresolved); failed: {100.0 * one.failed / total:.3g} % (fines)")
    if rows:
        print(f"{'':>4} {'particles':>9} {'mass [kg]':>12} {'size [m]':>11} {'x [m]':>11} "
              f"{'z [m]':>11} {'speed [m/s]':>12} {'spin [rad/s]':>12}")
    for row in rows[:SHOWN]:
        speed, spin = (float(np.linalg.norm(row[at:at + 3])) for at in (9, 13))
        print(f"{row[1]:4d} {row[2]:9d} {row[3]:12.5e} {row[5]:11.4e} {row[6]:11.4e} "
              f"{row[8]:11.4e} {speed:12.4f} {spin:12.5g}")
    if len(rows) > SHOWN:
        print(f" ... {len(rows) - SHOWN} more in the table")


def say_fits(sample: Sample, least: float) -> list[Fit]:
    """The table of the fitted distributions."""
    masses = sample.masses(least)
    found = fits(masses, least)
    if not found:
        print(f"{sample.name}: {len(masses)} resolved fragments are too few, or too equal, for a fit")
        return found
    print(f"{sample.name}: fits to {len(masses)} fragments above m0 = {least:.4g} kg; share heavier than m: "
          "exp(-(m^k - m0^k)/scale^k), power law (m/m0)^-exponent")
    print(f"{'':12} {'k':>7} {'scale [kg]':>12} {'exponent':>9} {'AIC':>9} {'KS distance':>12} {'p':>6}")
    best = min(one.aic for one in found)
    for one in found:
        power = one.shape == 0.0
        print(f"{one.name:12} {one.shape:7.3f} {'' if power else format(one.scale, '.5g'):>12} "
              f"{format(one.scale, '.4f') if power else '':>9} {one.aic - best:9.1f} {one.distance:12.4f} "
              f"{one.probability:6.3f}")
    print("AIC over that of the best fit. p: probability that a sample of the fit is farther from its own fit; "
          "only indicative, since the masses of a run are not independent")
    return found


def say_comparison(one: Sample, other: Sample, least: float) -> None:
    """Numbers and distributions of two samples."""
    result = compared(one, other, least)
    print(f"fragments above {least:.4g} kg: {one.name} {result.numbers[0]}, {other.name} {result.numbers[1]}"
          + (f"; difference of the same seed {result.paired}" if result.paired else ""))
    print(verdict(result))
    if max(run.copies for run in one.runs + other.runs) > 1:
        print("fragments are repeated at mirror planes, so that p is too small; --no-mirror counts each once")


def page(samples: Sequence[Sample], arguments: argparse.Namespace, title: str, out: str, histogram: bool) -> None:
    """Fits, comparison and picture of one or two samples, or of the times of a run."""
    least = resolved_mass(samples, arguments.resolved)
    found: list[Fit] = []
    if arguments.fit:
        for sample in samples:
            found = say_fits(sample, least)
    if len(samples) == 2 and not histogram:
        say_comparison(samples[0], samples[1], least)
    for one in (run for sample in samples for run in sample.runs):
        one.rows = shown(one, arguments.least)
    if any(len(sample.masses(0.0)) for sample in samples):
        look.save(curves_page(samples, least, found, title, histogram), out, arguments.dpi)
        print(f"wrote {out}")


def one_run(source: str, arguments: argparse.Namespace) -> int:
    """Table, summary and picture of one run."""
    out = arguments.out or beside(source, "_pieces.png")
    look.check_picture(out)
    found, title = search(source, arguments)
    for one in found:
        say(one, arguments)
    print(found[-1].note)
    write_table(arguments.table or beside(source, "_pieces.csv"), COLUMNS,
                [row for one in found for row in shown(one, arguments.least)], found[-1].note)
    clock, unit = look.scaled(max(abs(one.time) for one in found), "s")
    page([Sample(f"t = {clock * one.time:.4g} {unit}", [one], []) for one in found], arguments, title, out, True)
    return 0


def over_time(source: str, arguments: argparse.Namespace) -> int:
    """Numbers and masses of all snapshots."""
    out = arguments.out or beside(source, "_pieces_over_time.png")
    look.check_picture(out)
    found, title = search(source, arguments)
    rows = [one.counts(arguments.resolved) for one in found]
    note = f"fragments of at least {arguments.resolved} particles are resolved; {found[-1].note}"
    print("".join(f"{head:>16}" for head in COUNTS))
    for row in rows:
        print("".join(f"{value:16.6g}" for value in row))
    print(note)
    write_table(arguments.table or beside(source, "_pieces_over_time.csv"), COUNTS, rows, note)
    if arguments.plot or arguments.out:
        look.save(history_page(rows, arguments.resolved, title), out, arguments.dpi)
        print(f"wrote {out}")
    return 0


def two_runs(sources: Sequence[str], arguments: argparse.Namespace) -> int:
    """Comparison of the fragments of two runs."""
    out = arguments.out or beside(sources[0], "_pieces_compared.png")
    look.check_picture(out)
    names = [os.path.basename(beside(source, "")) for source in sources]
    samples = []
    for name, source in zip(names if names[0] != names[1] else sources, sources):
        found = search(source, arguments)[0]
        print(name, end=", ")
        say(found[-1], arguments)
        samples.append(Sample(name, found[-1:], []))
    page(samples, arguments, "", out, False)
    return 0


def many_runs(arguments: argparse.Namespace) -> int:
    """Ensembles of seeds of one or two decks."""
    if arguments.out:
        look.check_picture(arguments.out)
    decks = [readable(deck) for deck in arguments.source]
    plans = planned(decks, arguments.seeds, arguments.values, arguments.outdir)
    done = ensembles(plans, arguments.scree, arguments.jobs, arguments.overwrite,
                     lambda path: search(path, arguments)[0][-1])
    samples = [one.sample for one in done]
    least = resolved_mass(samples, arguments.resolved)
    for one in done:
        runs, name = one.sample.runs, one.sample.name
        numbers = one.sample.numbers(least)
        mass = sum(run.total for run in runs)
        small, fines = (sum(run.counts(arguments.resolved)[at] for run in runs) for at in (5, 4))
        print(f"{name}: t = {runs[-1].time:.6g} s, {len(runs)} seeds, {with_error(numbers)} fragments (mean and "
              f"standard error), standard deviation {numbers.std(ddof=min(1, len(runs) - 1)):.3g}; "
              f"unresolved {100.0 * small / mass:.3g} %, failed {100.0 * fines / mass:.3g} % of the mass")
        if len(runs) > 1 and not seeds_differ(one.sample):
            print(f"{name}: all seeds have the same fragments: nothing in this deck depends on the seed")
        write_table(one.stem + "_pieces.csv", ("seed", *COLUMNS),
                    [(seed, *row) for seed, run in zip(one.sample.seeds, runs) for row in shown(run, arguments.least)],
                    runs[-1].note)
        write_table(one.stem + "_seeds.csv", ("seed", *COUNTS),
                    [(seed, *run.counts(arguments.resolved)) for seed, run in zip(one.sample.seeds, runs)],
                    f"fragments of at least {arguments.resolved} particles are resolved; {runs[-1].note}")
    page(samples, arguments, "", arguments.out or done[0].stem + "_pieces.png", False)
    print(samples[0].runs[-1].note)
    return EXIT_DIFFERENT if any(one.failed for one in done) else 0


def check_arguments(arguments: argparse.Namespace) -> None:
    """Checks that the parser cannot do."""
    if not (np.isfinite(arguments.reach) and arguments.reach > 0.0):
        raise ScreeError("--reach must be above 0", EXIT_USAGE)
    if arguments.cell is not None and not arguments.cell > 0.0:
        raise ScreeError("--cell must be above 0", EXIT_USAGE)
    for name in ("least", "resolved", "seeds", "jobs"):
        if (value := getattr(arguments, name)) is not None and value < 1:
            raise ScreeError(f"--{name} must be above 0", EXIT_USAGE)
    if not (np.isfinite(arguments.stretch) and arguments.stretch > 1.0):
        raise ScreeError("--stretch must be above 1", EXIT_USAGE)
    if arguments.bonds and arguments.cell is not None:
        raise ScreeError("--bonds and --cell: give one of them", EXIT_USAGE)
    if not arguments.bonds and arguments.stretch != STRETCH:
        raise ScreeError("--stretch needs --bonds", EXIT_USAGE)
    if arguments.plot and not arguments.history:
        raise ScreeError("--plot needs --history; without it the picture is always drawn", EXIT_USAGE)
    if arguments.seeds is None:
        for name, value in (("set", arguments.values), ("jobs", arguments.jobs), ("outdir", arguments.outdir),
                            ("scree", arguments.scree), ("overwrite", arguments.overwrite)):
            if value:
                raise ScreeError(f"--{name} needs --seeds", EXIT_USAGE)
    if len(arguments.source) > 2:
        raise ScreeError(f"{len(arguments.source)} sources: give one, or two to be compared", EXIT_USAGE)
    if (len(arguments.source) == 2 or arguments.seeds) and (
            arguments.all or arguments.history or arguments.table or len(arguments.time or ()) > 1):
        raise ScreeError("--all, --history, --table and several times are for one run", EXIT_USAGE)


def run(arguments: argparse.Namespace) -> int:
    """Read, find, write."""
    check_arguments(arguments)
    if arguments.seeds:
        return many_runs(arguments)
    for source in arguments.source:
        if source.endswith(".nml"):
            raise ScreeError(f"{source} is a deck: run it with --seeds N, or name the folder of its run", EXIT_USAGE)
    sources = [series_file(source) for source in arguments.source]
    if len(sources) == 2:
        return two_runs(sources, arguments)
    return over_time(sources[0], arguments) if arguments.history else one_run(sources[0], arguments)
