# SPDX-License-Identifier: BSD-3-Clause
"""Accuracy of a number of a deck, and the cost of more accuracy: the deck is run with cells of three or more sizes.

    found = scree.accuracy("scene.nml", ["kinetic:max", "front_z"], factors=(4, 2, 1))
    found.table                                    # of pandas: a row for each run
    found.verdicts["front_z"].order, found.verdicts["front_z"].limit, found.verdicts["front_z"].error
    found.cost("front_z", 1e-4)                    # cells [m] and core-seconds for an error of 0.1 mm
    found.plot()
"""
from __future__ import annotations

import math
import os
import subprocess
import warnings
from collections.abc import Callable, Iterable, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

from . import grids
from .convergence import Verdict, forecast, judge
from .drawing.look import COLOURS
from .errors import ScreeError, error_of_run
from .launch import deck_file, is_text, options_of, progress_bar
from .launch import run as run_deck
from .plot import label
from .program import find_program
from .quantities import unit_of, value_of
from .results import Run
from .units import si_unit

if TYPE_CHECKING:
    import pandas
    from matplotlib.figure import Figure

Measure = Callable[[Run], "float | Mapping[str, float]"]
UNEQUAL_MASS = 1.0e-3                    # a larger relative difference of mass means that bodies differ
CHANGED = ("grid.dx", "grid.cells")      # settings that the factors replace


class MassWarning(UserWarning):
    """The grids have different bodies, which is an error without an order."""


@dataclass
class Accuracy:
    """Runs of a deck on several grids and the convergence of each quantity, in SI."""

    grid: grids.Grid
    sizes: list[float]                   # edges of cells, coarse first, in the unit of the deck
    table: pandas.DataFrame              # cell_size, factor, particles, steps, core_seconds, and the quantities
    verdicts: dict[str, Verdict]         # by quantity
    units: dict[str, str]                # by quantity
    folders: list[Path] = field(default_factory=list)

    def cost(self, quantity: str, tolerance: float) -> tuple[float, float] | None:
        """Cells [m] and core-seconds for an error within a tolerance; None without an order."""
        sizes, seconds = (self.table[name].tolist() for name in ("cell_size", "core_seconds"))
        verdict = self.verdicts[quantity]
        if verdict.error <= tolerance:
            return float(sizes[-1]), float(seconds[-1])
        return forecast(sizes, seconds, verdict, tolerance, len(self.grid.axes))

    def plot(self, names: Mapping[str, Accuracy] | None = None) -> Figure:
        """Values against the size of cells with the extrapolated value at 0, and errors against cost.

        `names` are results to draw for comparison by their labels, such as those of several methods.
        """
        import matplotlib.pyplot as pyplot
        from matplotlib.ticker import NullFormatter
        results = dict(names or {"deck": self})
        figure, panels = pyplot.subplots(len(self.verdicts), 2, figsize=(9.0, 3.4 * len(self.verdicts)), squeeze=False,
                                         layout="constrained")
        for (left, right), quantity in zip(panels, self.verdicts):
            for colour, (name, result) in zip(COLOURS * len(results), results.items()):
                verdict, values = result.verdicts[quantity], result.table[quantity]
                left.plot(result.sizes, values, "o-", color=colour, ms=4, label=name)
                if math.isfinite(verdict.limit):
                    left.errorbar([0.0], [verdict.limit], yerr=verdict.error, fmt="s", ms=4, color=colour, capsize=3)
                if verdict.kind == "monotone":
                    right.plot(result.table["core_seconds"], (values - verdict.limit).abs(), "o-", color=colour, ms=4)
            left.set(xlabel=f"edge of a cell [{self.grid.unit}]", ylabel=label(quantity, self.units[quantity]))
            left.legend(title="at 0: extrapolated", fontsize=9, title_fontsize=9)
            if not right.lines:
                right.axis("off")
                right.text(0.5, 0.5, f"{self.verdicts[quantity].kind}: no order", ha="center")
                continue
            right.set(xscale="log", yscale="log", xlabel="core-seconds", ylabel="distance to the extrapolated value")
            for axis in (right.xaxis, right.yaxis):
                axis.set_minor_formatter(NullFormatter())
        return figure


def check(program: str, deck: Path, settings: Mapping[str, Any]) -> None:
    """Raise the errors that `scree --check` reports, which costs nothing compared with a run."""
    words = [program, "--check", "--no-estimate", *options_of(settings, None, None), os.fspath(deck)]
    answer = subprocess.run(words, text=True, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, check=False)
    if answer.returncode:
        raise error_of_run(answer.returncode, ["the deck is not accepted:", *answer.stdout.strip().splitlines()[-40:]])


def measured(run: Run, quantities: Iterable[str | Measure], body: str | None, percentile: float
             ) -> tuple[dict[str, float], dict[str, str]]:
    """The quantities of a run and their units; functions may return several numbers by name."""
    values: dict[str, float] = {}
    units: dict[str, str] = {}
    for quantity in quantities:
        if isinstance(quantity, str):
            values[quantity] = value_of(run, quantity, body, percentile)
            units[quantity] = unit_of(run, quantity)
            continue
        found = quantity(run)
        values |= found if isinstance(found, Mapping) else {getattr(quantity, "__name__", "value"): float(found)}
    return values, {name: units.get(name, "") for name in values}


def accuracy(deck: str | os.PathLike[str], quantities: str | Measure | Sequence[str | Measure], *,
             factors: Iterable[float] = (2.0, 1.4, 1.0), set: Mapping[str, Any] | None = None, body: str | None = None,
             percentile: float = 100.0, outdir: str | os.PathLike[str] | None = None, jobs: int = 1, label: str = "",
             program: str | os.PathLike[str] | None = None, progress: bool = True, **options: Any) -> Accuracy:
    """Run a deck with cells of several sizes and estimate the accuracy of numbers of it.

    quantities  functions of a Run that return a number or numbers by name, or names: a column of the history (its last
                row; kinetic:max, kinetic:at=5us), a number of the summary (ledger.energy_error), or an extent of the
                particles of the last snapshot (length, radius, front_z)
    factors     sizes of cells over those of the deck, three or more; moved to the nearest that fit
    set         values of keys, as for scree.run
    body        extents of the particles of this body only
    percentile  extents leave out the rest of the mass on each side [%]
    outdir      folder of the runs, out/accuracy_DECK by default; earlier runs of this kind are replaced
    jobs        runs at a time
    label       part of the names of the runs
    options     those of scree.run, such as threads

    Raises what scree.run raises. Warns if the mass of the bodies differs between the grids.
    """
    import pandas
    chosen = [quantities] if isinstance(quantities, str) or callable(quantities) else list(quantities)
    name = "deck" if is_text(deck) else Path(deck).stem
    base = Path("out") / f"accuracy_{name}" if outdir is None else Path(outdir)
    path, found = deck_file(deck, base, True), find_program(program)
    settings = {**(set or {}), "checkpoint.at_end": False}
    grid = grids.read_grid(os.fspath(path), settings)
    every = grids.choose_parts(grid, factors)
    settings = {key: value for key, value in settings.items() if key not in CHANGED}
    for parts in every:
        check(found, path, {**settings, **grid.setting(parts)})

    def one(parts: int) -> tuple[dict[str, Any], dict[str, str], Run]:
        name = f"accuracy_{label or 'deck'}_{parts}"
        size = grid.size(parts)
        try:
            run = run_deck(path, {**settings, **grid.setting(parts)}, outdir=base / name, case=name, progress=False,
                           overwrite=True, program=found, **options)
        except ScreeError as error:
            words = f"the run with cells of {size:.4g} {grid.unit} ended with exit code {error.code}:\n{error}"
            raise type(error)(words, error.code, error.messages, error.folder) from error
        values, units = measured(run, chosen, body, percentile)
        summary = run.summary
        return {"cell_size": size * 10.0 ** si_unit(grid.unit)[1], "factor": grid.common / parts,
                "particles": summary["particles"], "steps": summary["steps"], "core_seconds": summary["processor_s"],
                "mass": summary["ledger"]["start"]["mass"], **values}, units, run

    # the coarsest run is first, and shows whether these numbers exist
    with progress_bar(total=len(every), desc="accuracy", disable=None if progress else True) as bar:
        results = [one(every[0])]
        bar.update()
        with ThreadPoolExecutor(jobs) as pool:
            for result in pool.map(one, every[1:]):
                results.append(result)
                bar.update()
    table = pandas.DataFrame([row for row, _, _ in results])
    masses = table.pop("mass")
    if masses.max() - masses.min() > UNEQUAL_MASS * masses.max():
        warnings.warn(
            f"the mass of the bodies differs by {100.0 * (masses.max() / masses.min() - 1.0):.2g} % between the grids, "
            "because their edges do not lie between particles in all of them; that hides the order. Use factors "
            "such as 2, 1, 0.5, or packing='cut' of &body", MassWarning, stacklevel=2)
    units = results[-1][1]
    sizes = [grid.size(parts) for parts in every]
    verdicts = {name: judge(sizes[-3:], table[name].tolist()[-3:]) for name in units}
    table.attrs["units"] = {"cell_size": "m", "core_seconds": "s", **units}
    return Accuracy(grid, sizes, table, verdicts, units, [Path(run.folder) for _, _, run in results])
