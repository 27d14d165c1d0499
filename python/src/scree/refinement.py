# SPDX-License-Identifier: BSD-3-Clause
"""Accuracy of a number of a deck, and the cost of more accuracy: the deck is run with cells of three or more sizes.

    found = scree.accuracy("scene.nml", ["kinetic:max", "front_z"], factors=(4, 2, 1))
    found.table                                    # of pandas: a row for each run
    found.verdicts["front_z"].order, found.verdicts["front_z"].limit, found.verdicts["front_z"].error
    found.cost("front_z", 1e-4)                    # cells [m] and core-seconds for an error of 0.1 mm
    found.plot()
"""
from __future__ import annotations

import os
import warnings
from collections.abc import Callable, Iterable, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

from . import grids
from .causes import causes_of
from .convergence import Verdict, forecast, judge
from .drawing.look import COLOURS, plain_texts, readable_unit, with_unit
from .errors import DeckError, ScreeError
from .launch import Count, deck_file, echo_of, is_text
from .launch import run as run_deck
from .plot import label, largest
from .program import find_program
from .quantities import check_quantities, unit_of, value_of
from .results import Run

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
    sizes: list[float]                   # edges of cells [m], coarse first
    table: pandas.DataFrame              # cell_size, factor, particles, steps, core_seconds, and the quantities
    verdicts: dict[str, Verdict]         # by quantity
    units: dict[str, str]                # by quantity
    folders: list[Path] = field(default_factory=list)
    causes: list[str] = field(default_factory=list)      # in the deck, of results that depend on the size of cells

    def cost(self, quantity: str, tolerance: float) -> tuple[float, float] | None:
        """Cells [m] and core-seconds for an error within a tolerance; None without an order."""
        seconds, verdict = self.table["core_seconds"].tolist(), self.verdicts[quantity]
        if verdict.error <= tolerance:
            return self.sizes[-1], float(seconds[-1])
        return forecast(self.sizes, seconds, verdict, tolerance, len(self.grid.axes))

    def plot(self, names: Mapping[str, Accuracy] | None = None) -> Figure:
        """Values against the size of cells with the extrapolated value at 0, and errors against cost.

        `names` are results to draw for comparison by their labels, such as those of several methods.
        """
        import matplotlib.pyplot as pyplot
        from matplotlib.ticker import NullFormatter
        results = dict(names or {"deck": self})
        factor, unit = readable_unit(max(self.sizes), "m")
        figure, panels = pyplot.subplots(len(self.verdicts), 2, figsize=(9.0, 3.4 * len(self.verdicts)), squeeze=False,
                                         layout="constrained")
        for (left, right), quantity in zip(panels, self.verdicts):
            size = max(largest(result.table[quantity]) for result in results.values())
            scale, shown = readable_unit(size, self.units[quantity])
            for colour, (name, result) in zip(COLOURS * len(results), results.items()):
                verdict, values = result.verdicts[quantity], result.table[quantity]
                left.plot([factor * size for size in result.sizes], scale * values, "o-", color=colour, ms=4,
                          label=name)
                if verdict.limit is not None:
                    left.errorbar([0.0], [scale * verdict.limit], yerr=scale * verdict.error, fmt="s", ms=4,
                                  color=colour, capsize=3)
                if verdict.limit is not None and verdict.kind == "monotone":
                    right.plot(result.table["core_seconds"], scale * (values - verdict.limit).abs(), "o-",
                               color=colour, ms=4)
            left.set(xlabel=f"edge of a cell [{unit}]", ylabel=label(quantity, shown))
            if any(result.verdicts[quantity].limit is not None for result in results.values()):
                left.legend(title="at 0: extrapolated", fontsize=9, title_fontsize=9)
            if not right.lines:
                right.axis("off")
                right.text(0.5, 0.5, f"{self.verdicts[quantity].kind}: no order", ha="center")
                continue
            right.set(xscale="log", yscale="log", xlabel="core-seconds",
                      ylabel=with_unit("distance to the extrapolated value", shown))
            for axis in (right.xaxis, right.yaxis):
                axis.set_minor_formatter(NullFormatter())
        return plain_texts(figure)


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

    quantities  functions of a Run that return a number or numbers by name, or names: a column of the history or of
                another table (its last row; kinetic:max, gauge.velocity_x:at=5us, fragments[1].mass), a number of the
                summary (ledger.energy_error), or an extent of the particles of the last snapshot (length, radius,
                front_z); unknown names are errors before the first run
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
    echo = echo_of(found, path, settings)
    grid = grids.grid_of(echo)
    every = grids.choose_parts(grid, factors)
    settings = {key: value for key, value in settings.items() if key not in CHANGED}
    for parts in every:
        try:
            echo_of(found, path, {**settings, **grid.setting(parts)})
        except DeckError as error:
            raise DeckError(f"with cells of {grid.size(parts):.4g} m {error}", error.code, error.messages) from error
    check_quantities(path, [name for name in chosen if isinstance(name, str)], {**settings, **grid.setting(every[0])},
                     base, body, program=found, **options)

    def one(parts: int) -> tuple[dict[str, Any], dict[str, str], Run]:
        name = f"accuracy_{label or 'deck'}_{parts}"
        size = grid.size(parts)
        try:
            run = run_deck(path, {**settings, **grid.setting(parts)}, outdir=base / name, case=name, progress=False,
                           overwrite=True, program=found, **options)
        except ScreeError as error:
            words = f"the run with cells of {size:.4g} m ended with exit code {error.code}:\n{error}"
            raise type(error)(words, error.code, error.messages, error.folder) from error
        values, units = measured(run, chosen, body, percentile)
        summary = run.summary
        return {"cell_size": size, "factor": grid.common / parts,
                "particles": summary["particles"], "steps": summary["steps"], "core_seconds": summary["processor_s"],
                "mass": summary["ledger"]["start"]["mass"], **values}, units, run

    with Count(len(every), "accuracy", progress) as bar, ThreadPoolExecutor(jobs) as pool:
        results = []
        for result in pool.map(one, every):
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
    return Accuracy(grid, sizes, table, verdicts, units, [Path(run.folder) for _, _, run in results], causes_of(echo))
