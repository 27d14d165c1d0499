# SPDX-License-Identifier: BSD-3-Clause
"""Figures: friction and volume fraction, relaxation of the stress, and the fitted law on the strain path of the
cell."""
from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from scree.drawing import look

from . import relaxation

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from scree.arrays import Array

    from .cell_run import CellRun, Stage
    from .memory import Memory
    from .rheology import Fits, SteadyShear

MARKS = {"survival": "o", "hold": "s", "normal": "^", "correlation": "D", "reversal": "v"}


def dress(axes: Axes, x: str, y: str) -> None:
    """Labels and the common style."""
    axes.set(xlabel=x, ylabel=y)
    axes.grid(color="#dddddd", linewidth=0.6)
    axes.set_axisbelow(True)
    axes.spines[["top", "right"]].set_visible(False)


def rheology(shears: Sequence[SteadyShear], fits: Fits, title: str) -> Figure:
    """mu and phi against the inertial number, with the fits."""
    figure: Figure
    figure, panels = look.pyplot().subplots(1, 2, figsize=(10.0, 4.2), layout="constrained")
    x = np.array([one.inertial for one in shears])
    line = np.linspace(0.0, 1.05 * x.max(), 200)
    for axes, name, words, tint in ((panels[0], "mu", "friction, shear stress / pressure", look.COLOURS[0]),
                                    (panels[1], "phi", "volume fraction", look.COLOURS[1])):
        axes.errorbar(x, [getattr(one, name) for one in shears], [getattr(one, f"{name}_error") for one in shears],
                      fmt="o", color=tint, capsize=3, markersize=5, label="cell")
        dress(axes, "inertial number I", words)
    if "mu_s" in fits:
        (base, _), (slope, _) = fits["mu_s"], fits["a"]
        panels[0].plot(line, base + slope * line, color=look.COLOURS[6], linewidth=1.2,
                       label=f"{base:.3f} + {slope:.2f} I")
        (base, _), (slope, _) = fits["phi_c"], fits["b"]
        panels[1].plot(line, base - slope * line, color=look.COLOURS[6], linewidth=1.2,
                       label=f"{base:.3f} - {slope:.2f} I")
    if "curve_mu_s" in fits:
        low, high, half = (fits[f"curve_{name}"][0] for name in ("mu_s", "mu_2", "I_0"))
        panels[0].plot(line, low + (high - low) * line / (line + half), color=look.COLOURS[4], linewidth=1.2,
                       linestyle="--", label=f"{low:.3f} + {high - low:.2f}/(1 + {half:.2f}/I)")
    for axes in panels:
        axes.legend()
    figure.suptitle(title, fontweight="bold")
    return figure


def curves(axes: Axes, chosen: Sequence[Memory], scale: float = 1.0) -> None:
    """Data and fit of some measurements."""
    for number, one in enumerate(chosen):
        tint = look.COLOURS[number % len(look.COLOURS)]
        x, y, smooth = one.curve
        axes.plot(scale * x, y, ".", color=tint, markersize=2.5, alpha=0.5)
        form = f"exponent {one.beta:.2f}" if np.isfinite(one.beta) else "not resolved"
        axes.plot(scale * x, smooth, color=tint, linewidth=1.4, label=f"{one.stage}, I = {one.inertial:.2g}: {form}")
    axes.axhline(0.0, color="#888888", linewidth=0.8)


def draw_survival(axes: Axes, chosen: Sequence[Memory]) -> None:
    """Fraction of existing contacts older than a strain."""
    for number, one in enumerate(chosen):
        tint = look.COLOURS[number % len(look.COLOURS)]
        ages, share, _ = one.curve
        axes.plot(ages, share, color=tint, linewidth=1.4, label=f"I = {one.inertial:.2g}: mean {one.strain:.3f}, "
                  f"exponent {one.beta:.2f}")
        axes.plot(ages, np.exp(-ages / one.strain), color=tint, linewidth=0.8, linestyle="--")
    axes.set_yscale("log")
    axes.set_ylim(1.0e-3, 1.1)
    dress(axes, "strain since the contact began", "fraction of contacts older than the strain")


def memory(memories: Sequence[Memory], title: str) -> Figure:
    """Survival of contacts, stops, correlation, and all measurements against the inertial number."""
    figure: Figure
    figure, grid = look.pyplot().subplots(2, 2, figsize=(11.5, 8.0), layout="constrained")
    of = {name: [one for one in memories if one.measure == name] for name in MARKS}
    draw_survival(grid[0, 0], of["survival"])
    longest = max((one.curve[0][-1] for one in of["hold"]), default=1.0)
    factor, unit = look.scaled(longest, "s")
    curves(grid[0, 1], of["hold"], factor)
    dress(grid[0, 1], f"time since the stop [{unit}]", "shear stress / that of steady shear")
    for number, one in enumerate(of["correlation"]):
        grid[1, 0].plot(*one.curve, color=look.COLOURS[number % 7], linewidth=1.3, label=f"I = {one.inertial:.2g}")
    grid[1, 0].axhline(0.0, color="#888888", linewidth=0.8)
    dress(grid[1, 0], "strain", "correlation of the shear stress")
    for number, (name, mark) in enumerate(MARKS.items()):
        found = [one for one in of[name] if one.strain > 0.0]
        if found:
            error = np.array([min(one.error, 0.9 * one.strain) for one in found])
            grid[1, 1].errorbar([one.inertial for one in found], [one.strain for one in found], error, fmt=mark,
                                color=look.COLOURS[number], capsize=3, markersize=5, label=name)
    grid[1, 1].set(xscale="log", yscale="log")
    dress(grid[1, 1], "inertial number I", "strain tau rate")
    for axes in grid.ravel():
        if axes.get_legend_handles_labels()[0]:
            axes.legend(fontsize=8)
    figure.suptitle(title, fontweight="bold")
    return figure


def episodes(run: CellRun, shears: Sequence[SteadyShear]) -> dict[str, tuple[Stage, SteadyShear]]:
    """Parts of the strain path with which the law is compared: a start, a reversal, a stop, each with its steady
    shear."""
    found: dict[str, tuple[Stage, SteadyShear]] = {}
    for shear in shears:
        before = run.before(shear.stage) if shear.run is run else None
        if before is None:
            continue
        kind = "start" if before.kind != "shear" else "reversal" if before.rate * shear.stage.rate < 0.0 else ""
        if kind and (kind not in found or shear.inertial < found[kind][1].inertial):
            found[kind] = (shear.stage, shear)
    for stage in run.stages_of("hold"):
        stopped = next((one for one in shears if one.stage is run.before(stage)), None)
        if stopped and ("stop" not in found or stopped.inertial < found["stop"][1].inertial):
            found["stop"] = (stage, stopped)
    return found


def law_on_path(run: CellRun, stage: Stage, times: Array, keys: Mapping[str, Any], sign: float) -> Array:
    """Shear stress of the law along the sign of the rate, starting from the stress of the cell before the stage
    [Pa]."""
    before = run.before(stage)
    assert before is not None, "episodes have a stage before them"
    rows = before.rows
    few = max(1, len(rows["time"]) // 100)
    start = 0.5 * np.mean(rows["stress_xx"][-few:] - rows["stress_yy"][-few:]) + 1j * np.mean(rows["stress_xy"][-few:])
    return sign * relaxation.follow(start, stage.rate if stage.kind == "shear" else 0.0, times, keys["shear"],
                                    keys["gr_gamma_c"]).imag


def loop(run: CellRun, shears: Sequence[SteadyShear], keys: Mapping[str, Any], title: str) -> Figure | None:
    """Stress of the cell and of the fitted law in a start, a reversal and a stop; None without any of them."""
    parts = episodes(run, shears)
    if not parts:
        return None
    figure: Figure
    figure, panels = look.pyplot().subplots(1, len(parts), figsize=(4.6 * len(parts), 4.2), layout="constrained",
                                            squeeze=False, sharey=True)
    for axes, (kind, (stage, shear)) in zip(panels[0], parts.items()):
        sign = np.sign(shear.stage.rate)
        time = stage.middle()
        if kind == "stop":
            factor, unit = look.scaled(float(time[-1]), "s")
            words = f"time since the stop [{unit}]"
        else:
            factor, words = abs(stage.rate), "strain"
            time = time[factor * time < 1.0]
        stress = sign * stage.rows["stress_xy"][:len(time)]
        axes.plot(factor * time, stress / shear.pressure, color=look.COLOURS[5], linewidth=1.0, label="cell")
        axes.plot(factor * time, law_on_path(run, stage, time, keys, sign) / shear.pressure, color=look.COLOURS[1],
                  linewidth=1.8, label=f"law, contact strain {keys['gr_gamma_c']:.3g}")
        axes.axhline(0.0, color="#888888", linewidth=0.8)
        axes.set_title(f"{kind}, I = {shear.inertial:.2g}")
        dress(axes, words, "shear stress / pressure" if kind == next(iter(parts)) else "")
    panels[0][0].legend()
    figure.suptitle(title, fontweight="bold")
    return figure
