# SPDX-License-Identifier: BSD-3-Clause
"""Pictures of fragments: numbers and cumulative curves, with fits and the scatter of seeds, and both over time."""
from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from scree.drawing import look

from .fragment_curves import Fit, Sample, mass_share, number_above

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from scree.arrays import Array

DASHES = ("--", "-.", ":", (0, (5, 1, 1, 1, 1, 1)))      # of the fits
BAND = (10.0, 50.0, 90.0)                                # percentiles of an ensemble


def tint_of(number: int, count: int) -> Any:
    """Colour of a curve, of a map if there are many."""
    if count <= len(look.COLOURS):
        return look.COLOURS[number]
    return look.pyplot().get_cmap(look.SEQUENTIAL)(number / count)


def style(axes: Axes, across: str, up: str) -> None:
    """Labels and grid of a panel."""
    axes.set_xlabel(across)
    axes.set_ylabel(up)
    axes.grid(color="#dddddd", linewidth=0.6)
    axes.set_axisbelow(True)
    axes.spines[["top", "right"]].set_visible(False)


def curves(axes: Axes, sample: Sample, points: Array, factor: float, tint: Any, share: bool) -> None:
    """Cumulative mass or number of a run, or the median of an ensemble with its band."""
    up = np.array([100.0 * mass_share([one], points) if share else number_above(one.masses, points)
                   for one in sample.runs])
    if len(sample.runs) == 1:
        axes.step(factor * points, up[0], where="post" if share else "pre", color=tint, label=sample.name)
        return
    low, middle, high = np.percentile(up, BAND, axis=0)
    axes.fill_between(factor * points, low, high, color=tint, alpha=0.25, linewidth=0.0)
    axes.plot(factor * points, middle, color=tint, label=f"{sample.name}: {len(sample.runs)} seeds")


def curves_page(samples: Sequence[Sample], least: float, fits: Sequence[Fit], title: str, histogram: bool) -> Figure:
    """Cumulative numbers and masses of runs or ensembles, and if wanted the numbers in classes of mass.

    least  resolved mass [kg];  fits  of the last sample
    """
    plot = look.pyplot()
    every = np.concatenate([sample.masses(0.0) for sample in samples])
    factor, unit = look.scaled(float(every.max()), "kg")
    figure: Figure
    figure, panels = plot.subplots(1, 2 + histogram, figsize=(5.2 * (2 + histogram), 4.6), layout="constrained")
    number, share = panels[-2:]
    ends = np.log10(min(every.min(), least)) - 0.1, np.log10(every.max()) + 0.1
    grid = np.logspace(*ends, 400)
    for row, sample in enumerate(samples):
        tint = tint_of(row, len(samples))
        points = grid
        if len(sample.runs) == 1:
            points = np.unique(np.concatenate([grid[[0, -1]], sample.masses(0.0)]))
        curves(number, sample, points, factor, tint, False)
        curves(share, sample, points, factor, tint, True)
        if histogram and len(sample.masses(0.0)):
            bins = np.logspace(*ends, 4 + int(8 * (ends[1] - ends[0])))
            panels[0].hist(factor * sample.masses(0.0), factor * bins, color=tint, linewidth=1.5, label=sample.name,
                           histtype="stepfilled" if len(samples) == 1 else "step")
    for dash, one in zip(DASHES, fits):
        points = np.logspace(np.log10(least), ends[1], 200)
        number.plot(factor * points, samples[-1].numbers(least).mean() * one.above(points), color="#444444",
                    linestyle=dash, linewidth=1.2, label=f"fit: {one.name}")
    if histogram:
        style(panels[0], f"mass [{unit}]", "number of fragments in a class")
        panels[0].yaxis.get_major_locator().set_params(integer=True)
    style(number, f"mass [{unit}]", "number of fragments at least as heavy")
    style(share, f"mass [{unit}]", "mass in lighter fragments and failed [%]")
    for axes in panels:
        axes.set_xscale("log")
    for axes in (number, share):
        axes.axvline(factor * least, color="#999999", linewidth=0.8, linestyle=":")
    number.set_yscale("log")
    number.set_ylim(bottom=0.8)
    share.set_ylim(0.0, 102.0)
    number.legend(loc="best", fontsize=9)
    figure.suptitle(title, fontsize=11)
    return figure


def history_page(rows: Sequence[Sequence[float]], particles: int, title: str) -> Figure:
    """Numbers of fragments and shares of the mass over time, from rows of COUNTS."""
    plot = look.pyplot()
    time, every, resolved, largest, fines, small, absent, total = np.array(rows, float).T
    factor, unit = look.scaled(float(abs(time).max()), "s")
    figure: Figure
    figure, (left, right) = plot.subplots(1, 2, figsize=(11.0, 4.6), layout="constrained")
    for values, label, dash in ((every, "all", "-"), (resolved, f"of at least {particles} particles", "--")):
        left.plot(factor * time, values, dash, label=label)
    for values, label in ((largest, "largest fragment"), (fines, "failed"), (absent, "not in the first snapshot"),
                          (small, f"in fragments of fewer than {particles} particles")):
        if label != "not in the first snapshot" or values.max() > 0.0:
            right.plot(factor * time, 100.0 * values / np.maximum(total, 1.0e-300), label=label)
    style(left, f"time [{unit}]", "number of fragments")
    style(right, f"time [{unit}]", "share of the mass [%]")
    for axes in (left, right):
        axes.set_ylim(bottom=0.0)
        axes.legend(loc="best", fontsize=9)
    figure.suptitle(title, fontsize=11)
    return figure
