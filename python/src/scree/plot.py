# SPDX-License-Identifier: BSD-3-Clause
"""Figures of matplotlib: histories, fields of particles, and fields along a line.

    figure = scree.plot.field(run.snapshots[-1], "pressure")
    figure.savefig("pressure.png")

The functions return a Figure and draw into `axes` if given. Numbers are in SI with a power of ten in the unit, so that
axes are readable. Colours and colour maps can be distinguished with any colour vision.
"""
from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import TYPE_CHECKING, Any, cast

import numpy as np

from .drawing.look import COLOURS, plain_texts, readable_unit, with_unit, words
from .errors import nearest
from .results import Run
from .snapshot import Snapshot

if TYPE_CHECKING:
    import pandas
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from numpy.typing import NDArray

SEQUENTIAL, DIVERGING = "viridis", "PuOr_r"
ENERGIES = ("kinetic", "internal", "total")
DASHES: tuple[Any, ...] = ("-", (0, (5, 2)), (0, (1, 1.2)), (0, (5, 2, 1, 2)))
WORDS = {"J": "energy", "kg": "mass", "s": "time", "m": "length", "m/s": "velocity", "kg m/s": "momentum",
         "N s": "impulse", "kg m2/s": "angular momentum"}    # quantities of columns by their unit


def label(name: str, unit: str) -> str:
    """Label of an axis: words and the unit in brackets."""
    return with_unit(words(name), unit)


def largest(values: Iterable[float] | NDArray[np.floating]) -> float:
    """The greatest magnitude of finite numbers, 0 if there are none."""
    sizes = np.abs(np.asarray(values, dtype=np.float64))
    return float(np.max(sizes[np.isfinite(sizes)], initial=0.0))


def canvas(axes: Axes | None) -> tuple[Figure, Axes]:
    """The axes to draw into and their figure."""
    if axes is None:
        import matplotlib.pyplot
        axes = matplotlib.pyplot.figure(figsize=(6.4, 4.4), layout="constrained").add_subplot()
    axes.spines[["top", "right"]].set_visible(False)
    figure = cast("Figure", axes.figure)
    return figure, axes


def columns_of(tables: Mapping[str, pandas.DataFrame], names: Sequence[str], *, x: str = "time", log: bool = False,
               log_x: bool = False) -> Figure:
    """Columns of tables against the column `x`, a panel for each unit.

    `tables` are tables of one kind by the names of their curves, such as cases. With `log` magnitudes are drawn on a
    logarithmic axis without zeros, with `log_x` the other axis is logarithmic.
    """
    import matplotlib.pyplot
    several, (first, *_) = list(tables.items()), tables.values()
    for name in (x, *names):
        for _, table in several:
            if name not in table:
                raise KeyError(f"no column '{name}' in the table{nearest(name, table.columns)}")
    panels: dict[str, list[str]] = {}
    for name in names:
        panels.setdefault(first.attrs["units"][name], []).append(name)
    figure = matplotlib.pyplot.figure(figsize=(8.0, 3.4 * len(panels) + 0.6), layout="constrained")
    cells = figure.subplots(len(panels), 1, squeeze=False, sharex=True)
    factor_x, unit_x = readable_unit(max(largest(table[x]) for table in tables.values()), first.attrs["units"][x])
    for axes, (unit, group) in zip(cells[:, 0], panels.items()):
        size = max(largest(table[name]) for table in tables.values() for name in group)
        factor, shown = (1.0, unit) if log else readable_unit(size, unit)
        for number, (case, table) in enumerate(several):
            for place, name in enumerate(group):
                tint = place if len(group) > 1 or len(several) == 1 else number
                values = factor * table[name].to_numpy()
                if log:
                    values = np.where(values != 0.0, np.abs(values), np.nan)
                axes.plot(factor_x * table[x].to_numpy(), values, color=COLOURS[tint % len(COLOURS)],
                          linestyle=DASHES[number % len(DASHES)], linewidth=1.6,
                          label=f"{case}: {words(name)}" if len(several) > 1 else words(name))
        head = words(group[0]) if len(group) == 1 else WORDS.get(unit, "value")
        if log and any(table[name].min() < 0.0 for table in tables.values() for name in group):
            head = f"size of {head}"
        axes.set(xscale="log" if log_x else "linear", yscale="log" if log else "linear", ylabel=with_unit(head, shown))
        canvas(axes)
        axes.grid(color="#dddddd", linewidth=0.6)
        axes.set_axisbelow(True)
        axes.margins(x=0.0)
        if len(group) * len(several) > 1:
            axes.legend(loc="center left", bbox_to_anchor=(1.01, 0.5), borderaxespad=0.0, frameon=False)
    cells[-1, 0].set_xlabel(label(x, unit_x))
    return plain_texts(figure)


def history(runs: Run | Sequence[Run], columns: str | Sequence[str] = ENERGIES, table: str = "history", *,
            x: str = "time", log: bool = False, log_x: bool = False) -> Figure:
    """Columns of a table over time, a panel for each unit; several runs share the panels.

    `table` is a name in `run.tables`, such as "gauge" or "forces", and `x` another column to draw over. `log` and
    `log_x` make axes logarithmic.
    """
    several = [runs] if isinstance(runs, Run) else list(runs)
    names = [columns] if isinstance(columns, str) else list(columns)
    tables: dict[str, pandas.DataFrame] = {}
    for run in several:                                  # cases of the same name are distinguished
        name = run.case if run.case not in tables else f"{run.case} ({len(tables) + 1})"
        tables[name] = run.history if table == "history" else run.tables[table]
    return columns_of(tables, names, x=x, log=log, log_x=log_x)


def limits_of(values: NDArray[np.floating], limits: tuple[float, float] | None) -> tuple[float, float]:
    """Ends of the colour bar: as given, or the least and the greatest number, symmetric if the sign changes."""
    if limits is not None:
        return limits
    finite = values[np.isfinite(values)]
    if len(finite) == 0:
        return 0.0, 1.0
    low, high = float(finite.min()), float(finite.max())
    if low < 0.0 < high and min(-low, high) > 0.05 * max(-low, high):
        return -max(-low, high), max(-low, high)
    return low, high if high > low else low + (abs(low) or 1.0)


def field(snapshot: Snapshot, name: str, *, axes: Axes | None = None, limits: tuple[float, float] | None = None,
          colour_map: str | None = None, mirror: bool = True) -> Figure:
    """Particles of a run in two dimensions, coloured by a field and drawn as squares of their volume.

    `name` is a field, a component such as stress_zz, or a vector, whose length is shown; speed is that of the velocity.
    `limits` are the ends of the colour bar in SI. Axisymmetric runs show both halves of their plane unless `mirror` is
    False. Colours are those of a diverging map where the numbers change their sign. In one dimension the field is drawn
    over x.
    """
    if snapshot.dimension == "3d":
        raise ValueError("a run in three dimensions: use snapshot.along with plot.line, snapshot.to_pyvista, or the "
                         "command scree-post picture")
    if name == "speed" and name not in snapshot:
        name = "velocity"
    values = snapshot[name].astype(np.float64)
    if values.ndim == 2:
        if values.shape[1] != 3:
            raise ValueError(f"{name} is a tensor: choose a component, such as {name}_xx")
        values = np.linalg.norm(values, axis=1)
    figure, axes = canvas(axes)
    low, high = limits_of(values, limits)
    factor, unit = readable_unit(max(abs(low), abs(high)), snapshot.unit(name))
    factor_length, unit_length = readable_unit(largest(snapshot.points), "m")
    factor_time, unit_time = readable_unit(snapshot.time, "s")
    axes.set_title(f"{factor_time * snapshot.time:.4g} {unit_time}")
    across = factor_length * snapshot["x"]
    if snapshot.dimension == "1d":
        axes.plot(across, factor * values, ".", color=COLOURS[0])
        axes.set_xlabel(label("x", unit_length))
        axes.set_ylabel(label(name, unit))
        return figure
    from matplotlib.collections import PolyCollection
    up, half = factor_length * snapshot["z"], 0.5 * factor_length * snapshot.size()
    colours = factor * values
    if snapshot.dimension == "axisymmetric" and mirror:
        across, up, half, colours = (np.concatenate(pair) for pair in (
            (-across, across), (up, up), (half, half), (colours, colours)))
    corners = np.array([[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]])
    squares = PolyCollection(np.stack([across, up], axis=1)[:, None] + half[:, None, None] * corners, array=colours,
                             cmap=colour_map or (DIVERGING if low < 0.0 < high else SEQUENTIAL),
                             edgecolors="face", linewidths=0.5)
    squares.set_clim(factor * low, factor * high)
    axes.add_collection(squares)
    axes.autoscale_view()
    axes.set_aspect("equal")
    axes.set_xlabel(label("radius" if snapshot.dimension == "axisymmetric" else "x", unit_length))
    axes.set_ylabel(label("z", unit_length))
    finite = colours[np.isfinite(colours)]
    beyond = (bool((finite < factor * low).any()), bool((finite > factor * high).any()))
    # the height of the axes, whose aspect ratio is that of the particles
    narrow = max(1.0, float(np.ptp(axes.get_ylim()) / np.ptp(axes.get_xlim())))
    beside = axes.inset_axes((1.0 + 0.03 * narrow, 0.0, 0.035 * narrow, 1.0))
    figure.colorbar(squares, cax=beside, label=label(name, unit),
                    extend={(True, True): "both", (True, False): "min", (False, True): "max"}.get(beyond, "neither"))
    return figure


def line(snapshot: Snapshot, names: str | Sequence[str], start: Sequence[float], end: Sequence[float], *,
         width: float | None = None, axes: Axes | None = None) -> Figure:
    """Fields of one unit over the distance along a line, such as a stress; see `Snapshot.along`."""
    table = snapshot.along(start, end, names, width)
    units, columns = table.attrs["units"], [name for name in table.columns if name != "distance"]
    if len({units[name] for name in columns}) > 1:
        raise ValueError(f"fields of several units: {', '.join(columns)}; draw each by itself")
    if table.empty:
        raise ValueError("no particle is near the line: set width, or other ends")
    figure, axes = canvas(axes)
    factor, unit = readable_unit(max(largest(table[name]) for name in columns), units[columns[0]])
    factor_length, unit_length = readable_unit(largest(table["distance"]), "m")
    for place, name in enumerate(columns):
        axes.plot(factor_length * table["distance"], factor * table[name], ".-", linewidth=0.8, markersize=4,
                  color=COLOURS[place % len(COLOURS)], label=name.replace("_", " "))
    axes.set_xlabel(label("distance", unit_length))
    axes.set_ylabel(label(columns[0] if len(columns) == 1 else "", unit).strip())
    if len(columns) > 1:
        axes.legend(frameon=False)
    factor_time, unit_time = readable_unit(snapshot.time, "s")
    axes.set_title(f"{factor_time * snapshot.time:.4g} {unit_time}")
    return figure
