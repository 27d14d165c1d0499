# SPDX-License-Identifier: BSD-3-Clause
"""The page of a history: energies, momentum, mass and their errors over time.

Columns that the file lacks are omitted; columns unknown to this module are drawn by unit below the ledger.
"""
from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from typing import TYPE_CHECKING, Any, Union

import numpy as np

from scree.drawing import look
from scree.errors import ScreeError

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from scree.arrays import Array
    from scree.files import History

ENERGY = {"total": "#111111", "kinetic": "#1f5a93", "internal": "#b3311b", "plastic": "#e08a1e",
          "viscous": "#2f7d3b", "lost_energy": "#8a8a8a", "external_work": "#6a4098"}
ERRORS = {
    "energy_error": ("#111111", "total energy"),
    "mass_error": ("#1f5a93", "mass"),
    "momentum_error": ("#b3311b", "momentum"),
    "angular_momentum_error": ("#2f7d3b", "angular momentum"),
}
AXES = ("#1f5a93", "#2f7d3b", "#b3311b")
DASHES = {"total": "-", "lost_energy": (0, (4, 2)), "external_work": (0, (1, 1.2))}
FLOOR = 1.0e-17          # smaller errors are drawn here: round-off of one number is 1e-16
BOOKKEEPING = ("step", "particles")

Style = Callable[[str], tuple[str, Any, Union[str, None]]]   # colour, dash and label of a column
Draw = Callable[["Axes", "Array", "History"], None]


def present(table: History, names: Iterable[str]) -> list[str]:
    """Those of the names that are in the file and not always zero."""
    return [name for name in names if name in table and abs(table[name]).max() > 0.0]


def largest(table: History, names: Iterable[str]) -> float:
    """Largest finite magnitude in some columns."""
    values = np.abs(np.concatenate([table[name] for name in names]))
    values = values[np.isfinite(values)]
    return float(values.max()) if len(values) else 0.0


def lines(axes: Axes, time: Array, table: History, names: Sequence[str], style: Style) -> str:
    """Draw columns of one unit; `style` gives colour, dash pattern and label of a name."""
    unit = table.units[names[0]]
    size = largest(table, names)
    factor, label = look.readable_unit(size, unit)
    for name in names:
        colour, dash, text = style(name)
        axes.plot(
            time,
            factor * table[name],
            color=colour,
            linestyle=dash,
            linewidth=1.6,
            label=text,
            zorder=3 if name == "total" else 2,
        )
    return label


def energies(axes: Axes, time: Array, table: History) -> None:
    """Energies against time."""
    names = present(table, ENERGY)
    label = lines(axes, time, table, names, lambda n: (
        ENERGY[n], DASHES.get(n, "-"), look.words(n)))
    axes.set_ylabel(f"energy [{label}]")
    axes.set_title("Energy", loc="left")


def errors(axes: Axes, time: Array, table: History) -> None:
    """Relative errors on a log axis."""
    for name, (colour, text) in ERRORS.items():
        if name in table:
            axes.semilogy(time, np.maximum(np.abs(table[name]), FLOOR), color=colour, linewidth=1.4,
                          label=text if abs(table[name]).max() > 0.0 else f"{text} (zero)")
    low, high = axes.get_ylim()
    axes.set_ylim(0.3 * FLOOR if low < 1.0e-15 else low / 2.0, max(high * 2.0, 1.0e-13))
    axes.set_ylabel("relative error")
    axes.set_title("Ledger", loc="left")


def momenta(axes: Axes, time: Array, table: History) -> None:
    """Components of the momentum, and dashed the momentum that left through boundaries."""
    names = present(
        table, [stem + axis for stem in ("momentum_", "lost_momentum_") for axis in "xyz"]
    )
    size = largest(table, names)
    names = [name for name in names if abs(table[name]).max() > 1.0e-9 * size]
    label = lines(axes, time, table, names, lambda n: (
        AXES["xyz".index(n[-1])], (0, (4, 2)) if n.startswith("lost") else "-", look.words(n)))
    axes.set_ylabel(f"momentum [{label}]")
    axes.set_title("Momentum", loc="left")


def angular(axes: Axes, time: Array, table: History) -> None:
    """Components of the angular momentum."""
    names = present(table, ["angular_momentum_" + axis for axis in "xyz"])
    label = lines(axes, time, table, names, lambda n: (
        AXES["xyz".index(n[-1])], "-", look.words(n)))
    axes.set_ylabel(f"angular momentum [{label}]")
    axes.set_title("Angular momentum", loc="left")


def masses(axes: Axes, time: Array, table: History) -> None:
    """Mass in the domain and mass that left."""
    names = present(table, ("mass", "lost_mass"))
    label = lines(axes, time, table, names, lambda n: (
        "#1f5a93" if n == "mass" else "#8a8a8a", "-" if n == "mass" else (0, (4, 2)),
        "in the domain" if n == "mass" else "left the domain"))
    axes.set_ylabel(f"mass [{label}]")
    axes.set_ylim(bottom=-0.02 * axes.get_ylim()[1])
    axes.set_title("Mass", loc="left")


def steps(axes: Axes, time: Array, table: History) -> None:
    """Time step."""
    label = lines(axes, time, table, ["dt"], lambda n: ("#1f5a93", "-", None))
    axes.set_ylabel(f"time step [{label}]")
    axes.set_ylim(bottom=0.0)
    axes.set_title("Time step", loc="left")


def others(names: Sequence[str]) -> Draw:
    """A panel of further columns of one unit."""
    def draw(axes: Axes, time: Array, table: History) -> None:
        label = lines(axes, time, table, names, lambda n: (
            look.COLOURS[names.index(n) % len(look.COLOURS)], "-", look.words(n)))
        title = look.words(names[0]).capitalize() if len(names) == 1 else "Further columns"
        axes.set_ylabel(f"[{label}]" if label not in ("", "1") else "")
        axes.set_title(title, loc="left")
    return draw


def panels(table: History) -> list[Draw]:
    """The panels for the columns of the file, in the order of the page."""
    wanted: list[tuple[Draw, Iterable[str]]] = [
        (energies, ENERGY),
        (errors, ERRORS),
        (momenta, ["momentum_" + axis for axis in "xyz"]),
        (angular, ["angular_momentum_" + axis for axis in "xyz"]),
        (masses, ["mass"]),
        (steps, ["dt"]),
    ]
    found: list[Draw] = [draw for draw, names in wanted
             if (any(name in table for name in names) if draw is errors else present(table, names))]
    known = {"time", "mass", "lost_mass", "dt", *ENERGY, *ERRORS, *BOOKKEEPING}
    known |= {stem + axis for stem in ("momentum_", "lost_momentum_", "angular_momentum_",
                                       "lost_angular_momentum_") for axis in "xyz"}
    units: dict[str, list[str]] = {}
    for name in table.order:
        if name not in known and abs(table[name]).max() > 0.0:
            units.setdefault(table.units[name], []).append(name)
    for names in units.values():
        found.extend(others(names[k:k + 7]) for k in range(0, len(names), 7))
    return found


def picture(table: History, title: str) -> Figure:
    """The figure: panels in two columns."""
    plot = look.pyplot()
    draws = panels(table)
    if not draws:
        raise ScreeError("the history has no column except time that is not zero")
    factor, unit = look.scaled(float(np.abs(table["time"]).max()), "s")
    columns = min(2, len(draws))
    rows = (len(draws) + columns - 1) // columns
    figure: Figure
    figure, grid = plot.subplots(
        rows,
        columns,
        figsize=(6.4 * columns, 3.5 * rows + 0.5),
        squeeze=False,
        layout="constrained",
    )
    cells = list(grid.ravel())
    for axes, draw in zip(cells, draws):
        draw(axes, factor * table["time"], table)
        axes.set_xlabel(f"time [{unit}]")
        axes.grid(color="#dddddd", linewidth=0.6)
        axes.set_axisbelow(True)
        axes.spines[["top", "right"]].set_visible(False)
        axes.margins(x=0.0)
        if axes.get_legend_handles_labels()[1]:
            count = len(axes.get_legend_handles_labels()[1])
            axes.legend(
                loc="lower right",
                bbox_to_anchor=(1.0, 1.0),
                borderaxespad=0.2,
                handlelength=1.6,
                columnspacing=1.2,
                ncol=count if count <= 3 else (count + 1) // 2,
            )
    for axes in cells[len(draws):]:
        axes.set_visible(False)
    figure.suptitle(title, fontweight="bold", fontsize=14)
    return figure
