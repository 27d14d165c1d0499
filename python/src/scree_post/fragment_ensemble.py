# SPDX-License-Identifier: BSD-3-Clause
"""Ensembles: a deck is run with several seeds, and the fragments of all runs are collected."""
from __future__ import annotations

import os
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

from scree.errors import EXIT_USAGE, FileProblem, ScreeError
from scree.program import jobs_for, threads_of_a_run
from scree.study import Combination, Study, combinations, folder_name, short

from .commands.sweep import deck_name, settings, tell
from .fragment_curves import ROUNDING, Sample
from .fragment_table import Fragments

SEED = "run.seed"
MOST = 2                 # ensembles of a call


@dataclass
class Ensemble:
    """The runs of one deck with the same keys except the seed."""

    sample: Sample
    stem: str                                            # of the files of its results, with the folder
    failed: list[Combination] = field(default_factory=list)


Plan = tuple[str, Ensemble, list[Combination]]           # deck, its ensemble, its runs


def planned(decks: Sequence[str], seeds: int, words: Sequence[str], outdir: str | None
            ) -> list[Plan]:
    """Deck, ensemble and runs of each ensemble: of each deck with each value of --set."""
    keys = settings(words)
    if SEED in keys:
        raise ScreeError(f"--set {SEED}: the seeds are those of --seeds", EXIT_USAGE)
    names = [deck_name(deck) for deck in decks]
    if len(set(names)) < len(names):
        raise ScreeError(f"two decks have the name {names[0]}: rename one, since results are in folders of that name",
                         EXIT_USAGE)
    found = []
    for deck, name in zip(decks, names):
        base = os.path.abspath(os.path.join(outdir or "out", f"{name}_seeds"))
        groups: dict[tuple[tuple[str, str], ...], list[Combination]] = {}
        for one in combinations({**keys, SEED: [str(seed + 1) for seed in range(seeds)]}, base, name):
            groups.setdefault(tuple((key, one.settings[key]) for key in keys), []).append(one)
        for values, runs in groups.items():
            label = ", ".join([name, *(f"{short(key)} = {value}" for key, value in values)])
            stem = "_".join([name, folder_name(dict(values))]) if values else name
            found.append((deck, Ensemble(Sample(label, [], []), os.path.join(base, stem)), runs))
    if len(found) > MOST:
        raise ScreeError(f"{len(found)} ensembles: give one or two: two decks, or a key with two values",
                         EXIT_USAGE)
    return found


def ensembles(plans: Sequence[Plan], program: str | None, jobs: int | None, overwrite: bool,
              measure: Callable[[str], Fragments]) -> list[Ensemble]:
    """Run the decks with all seeds, unless an earlier call has, and find the fragments of each run.

    measure  gets the series of a run
    """
    for deck, ensemble, runs in plans:
        found: dict[str, Fragments] = {}
        threads = threads_of_a_run()

        def ended(one: Combination, found: dict[str, Fragments] = found, count: int = len(runs),
                  ensemble: Ensemble = ensemble) -> None:
            if one.code == 0:
                found[one.settings[SEED]] = measure(os.path.join(one.folder, f"{one.case}_p.hdf.series"))
            else:
                ensemble.failed.append(one)
            tell(one, f"{len(found) + len(ensemble.failed)} of {count}")

        base = os.path.dirname(ensemble.stem)
        try:
            os.makedirs(base, exist_ok=True)
        except OSError as error:
            raise FileProblem(f"cannot make {base}: {error.strerror or error}") from error
        Study(deck, program=program, overwrite=overwrite, threads=threads).all(runs, jobs or jobs_for(threads), ended,
                                                              label=ensemble.sample.name, lines=False)
        if not found:
            raise ScreeError(f"{ensemble.sample.name}: no run finished; {ensemble.failed[0].reason}")
        ensemble.sample.seeds = sorted(map(int, found))
        ensemble.sample.runs = [found[str(seed)] for seed in ensemble.sample.seeds]
    return [ensemble for _, ensemble, _ in plans]


def seeds_differ(sample: Sample) -> bool:
    """False if all runs have the same fragments."""
    first = sample.runs[0].masses
    return any(len(one.masses) != len(first) or (abs(one.masses - first) > ROUNDING * first).any()
               for one in sample.runs[1:])
