# SPDX-License-Identifier: BSD-3-Clause
"""Evaluates runs of scree --grains: constants of continuum laws from a sheared cell of grains.

From the stages of one or several finished runs the command computes friction mu and volume fraction
phi as functions of the inertial number, with fits; the relaxation time tau of the shear stress from
the survival of contacts, the decay after a stop, the normal stress and the correlation; and G and
lambda from probes. The start of each shear stage (--skip) is omitted. Tables, figures and a
&material block for a deck are written to the folder of the first run.
"""
from __future__ import annotations

import argparse
import os
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from scree.drawing import look
from scree.errors import EXIT_USAGE, ScreeError

from ..grains import force_chains, material, memory, moduli, pictures, rheology, tables
from ..grains.cell_run import CellRun, read_run

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from ..grains.memory import Memory
    from ..grains.moduli import Moduli
    from ..grains.rheology import Fits, SteadyShear

SUMMARY = "constants of a cell of grains: friction, relaxation, moduli, &material"
EXAMPLES = ("grains out/grain_cell",
            "grains out/grain_cell --tau reversal --stage reverse",
            "grains out/grain_cell --law mu_i --out mu_i.nml")

# runs, their steady shear, and for each run its measurements of tau and its probes
Measured = tuple[list[CellRun], list[rheology.SteadyShear], list[tuple[CellRun, list[memory.Memory]]],
                 list[tuple[CellRun, list[moduli.Moduli]]]]


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """The options."""
    add = parser.add_argument
    add("folders", metavar="FOLDER", nargs="+", help="out/CASE of runs of scree --grains")
    add("--skip", type=float, default=1.0, metavar="STRAIN",
        help="strain at the start of each shear stage that is omitted (1); at most 40 %% of the stage")
    add("--stage", metavar="NAME", help="shear stage that gives the constants of the block; default: the slowest")
    add("--tau", choices=material.MEASURES, default="survival", help="measure of tau for the block (survival)")
    add("--law", choices=material.LAWS, default="granular", help="strength_model of the block (granular)")
    add("--out", metavar="NML", help="file of the block; default CASE_material.nml in the first folder")
    add("--dpi", type=int, default=150, help="pixels per inch of the pictures (150)")


def check_arguments(arguments: argparse.Namespace) -> None:
    """Checks that the parser cannot do."""
    if not (np.isfinite(arguments.skip) and arguments.skip >= 0.0):
        raise ScreeError(f"--skip {arguments.skip:g} must not be negative", EXIT_USAGE)
    if arguments.out and not os.path.isdir(os.path.dirname(arguments.out) or "."):
        raise ScreeError(f"cannot write {arguments.out}: no folder {os.path.dirname(arguments.out)}")


def measured(arguments: argparse.Namespace) -> Measured:
    """Runs, their steady shear, and pairs of runs with measurements of tau and probes."""
    generator = np.random.default_rng(12345)             # the same error bars in each call
    runs = [read_run(os.path.normpath(folder)) for folder in arguments.folders]
    for run in runs:
        if run.unfinished:
            print(f"note: {run.folder} is not finished ({run.unfinished}); its last stage is used as far as it goes")
    if not any(run.stages_of("shear") for run in runs):
        raise ScreeError(f"{', '.join(arguments.folders)}: no stage has a shear rate; give a &stage rate or "
                        "inertial_number")
    shears = [rheology.steady_shear(run, stage, arguments.skip, generator)
              for run in runs for stage in run.stages_of("shear")]
    memories = [(run, memory.measure_memory(run, shears, arguments.skip, generator)) for run in runs]
    probes = [(run, moduli.moduli_of(run)) for run in runs]
    return runs, shears, memories, probes


def say_rheology(shears: Sequence[SteadyShear], fits: Fits) -> None:
    """Lines on friction and volume fraction."""
    print(f"{'stage':<20} {'I':>7} {'mu':>13} {'phi':>13} {'W':>13}  drift")
    for one in shears:
        print(f"{one.stage.name:<20} {one.inertial:7.4f} {tables.with_error(one.mu, one.mu_error):>13} "
              f"{tables.with_error(one.phi, one.phi_error):>13} {tables.with_error(one.normal, one.normal_error):>13}"
              f"  {one.drifting or 'none'}")
    if fits:
        said = {name: tables.with_error(*value) for name, value in fits.items()}
        print(f"mu = {said['mu_s']} + {said['a']} I, phi = {said['phi_c']} - {said['b']} I")
        if "curve_mu_s" in fits:
            print(f"mu = mu_s + (mu_2 - mu_s)/(1 + I_0/I): mu_s {said['curve_mu_s']}, mu_2 {said['curve_mu_2']}, "
                  f"I_0 {said['curve_I_0']}")
    else:
        print("one inertial number: no fit of mu and phi")


def say_memory(runs: Sequence[CellRun], shears: Sequence[SteadyShear],
               memories: Sequence[tuple[CellRun, list[Memory]]],
               probes: Sequence[tuple[CellRun, list[Moduli]]]) -> None:
    """Lines on tau and moduli."""
    for run, found in memories:
        for line in tables.four_ways([one for one in shears if one.run is run], found):
            print(line)
        for one in found:
            if one.measure in ("hold", "normal", "correlation") and one.note:
                print(f"  {one.measure} of {one.stage}: {one.note}")
    for run, probed in probes:
        for probe in probed:
            name = next((stage.name for stage in run.stages if stage.number == probe.stage), str(probe.stage))
            print(f"probe of {run.case}, {name}, {'relaxed' if probe.relaxed else 'unrelaxed'}: G {probe.shear:.4g} Pa,"
                  f" lambda {probe.lame:.4g} Pa at pressure {probe.pressure:.4g} Pa"
                  + ("" if probe.elastic else "; not elastic, so not used: grains changed places"))
    if not any(found for _, found in probes):
        print(f"no moduli in {', '.join(run.case for run in runs)}: set probe = .true. in a &stage")


def write_tables(run: CellRun, shears: Sequence[SteadyShear], memories: Sequence[tuple[CellRun, list[Memory]]],
                 probes: Sequence[tuple[CellRun, list[Moduli]]], fits: Fits, keys: Mapping[str, Any]) -> list[str]:
    """CSV files and a JSON file; the result is their paths."""
    parts = (("_shear.csv", tables.STAGES, tables.stage_rows(shears)),
             ("_tau.csv", tables.MEMORY, tables.memory_rows(memories)),
             ("_elastic.csv", tables.MODULI, tables.moduli_rows(probes)))
    for ending, columns, rows in parts:
        tables.write_table(run.path(ending), columns, rows)
    every = [one for _, found in memories for one in found]
    laws = {name: memory.rate_law(every, name) for name in (*memory.FOUR, "reversal")}
    tables.write_json(run.path("_fit.json"), {
        "fits": {name: list(value) for name, value in fits.items()},
        "tau_against_rate": {name: {"gamma_c": [float(x) for x in law[0]], "1/tau_0": [float(x) for x in law[1]]}
                             for name, law in laws.items() if law},
        "material": {key: tables.plain(value) for key, value in keys.items()},
        **{name: tables.records(columns, rows) for name, (_, columns, rows) in
           zip(("shear", "tau", "moduli"), parts)}})
    return [run.path(ending) for ending, *_ in parts] + [run.path("_fit.json")]


def draw(run: CellRun, shears: Sequence[SteadyShear], memories: Sequence[Memory], fits: Fits, keys: Mapping[str, Any],
         arguments: argparse.Namespace) -> list[str]:
    """All figures; the result is their paths."""
    title = look.words(run.case)
    figures: dict[str, Figure | None] = {"_rheology.png": pictures.rheology(shears, fits, title)}
    if memories:
        figures["_memory.png"] = pictures.memory(memories, title)
    if arguments.law == "granular":
        figures["_loop.png"] = pictures.loop(run, shears, keys, title)
    sheared = [number for number, (time, _) in enumerate(run.contacts) if any(
        one.start_time < time <= one.rows["time"][-1] * (1.0 + 1.0e-9) for one in run.stages_of("shear"))]
    if sheared and len(run.grains) == len(run.contacts):
        figures["_chains.png"] = force_chains.picture(run.grains[sheared[-1]][1], run.contacts[sheared[-1]][1], title)
    written = []
    for ending, figure in figures.items():
        if figure is not None:
            look.save(figure, run.path(ending), arguments.dpi)
            written.append(run.path(ending))
    return written


def run(arguments: argparse.Namespace) -> int:
    """Read, evaluate, write."""
    check_arguments(arguments)
    runs, shears, memories, probes = measured(arguments)
    fits = rheology.fit_rheology(shears)
    say_rheology(shears, fits)
    say_memory(runs, shears, memories, probes)
    every = [one for _, found in memories for one in found]
    text, keys, shear = material.block(runs[0], [one for one in shears if one.run is runs[0]] or shears, every,
                                       [one for _, found in probes for one in found], fits, arguments)
    path = arguments.out or runs[0].path("_material.nml")
    print(f"block for {arguments.law} of stage {shear.stage.name}: "
          + ", ".join(f"{key} {value:.4g}" for key, value in keys.items() if not isinstance(value, str)))
    material.write_block(path, text)
    written = [path, *write_tables(runs[0], shears, memories, probes, fits, keys),
               *draw(runs[0], shears, every, fits, keys, arguments)]
    print("wrote " + " ".join(written))
    return 0
