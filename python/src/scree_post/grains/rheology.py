# SPDX-License-Identifier: BSD-3-Clause
"""Friction mu and volume fraction phi of steady shear against the inertial number I = rate d sqrt(rho/p)."""
from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np

from scree.errors import ScreeError

from . import statistics
from .statistics import linear_fit

if TYPE_CHECKING:
    from scree.arrays import Array

    from .cell_run import CellRun, Stage

LEAST_LINEAR, LEAST_CURVED = 2, 4      # inertial numbers that a fit needs
FASTEST = 0.25                         # greatest inertial number for the linear fits


Fits = dict[str, tuple[float, float]]  # name: value and error


@dataclass
class SteadyShear:
    """Means of one shear stage; errors are standard errors of blocks."""

    stage: Stage
    run: CellRun
    inertial: float
    rate: float                                          # absolute value [1/s]
    pressure: float                                      # -sigma_yy [Pa]
    stress: float                                        # shear stress along the rate [Pa]
    mu: float
    mu_error: float
    phi: float
    phi_error: float
    normal: float                                        # W = N1/(2 sigma_xy)
    normal_error: float
    coordination: float
    drifting: str                                        # names of means with a drift, or empty
    samples: dict[str, Array] = field(default_factory=dict)          # of the bootstrap


def steady_shear(run: CellRun, stage: Stage, skip: float, generator: np.random.Generator) -> SteadyShear:
    """Means of a shear stage after its start."""
    rows = stage.steady(skip)
    sign = np.sign(stage.rate)
    shear, normal, difference = sign * rows["stress_xy"], -rows["stress_yy"], \
        sign * (rows["stress_xx"] - rows["stress_yy"])
    fraction = rows["volume_fraction"]
    stress, pressure = float(shear.mean()), float(normal.mean())
    if not (pressure > 0.0 and stress > 0.0):
        raise ScreeError(f"{run.path('_history.csv')}: stage '{stage.name}' has no stress: pressure {pressure:.3g} "
                        f"Pa, shear stress {stress:.3g} Pa; compress the cell first")
    means = statistics.resampled_means([shear, normal, sign * difference, fraction], generator)
    samples = {"mu": means[:, 0] / means[:, 1], "phi": means[:, 3], "normal": means[:, 2] / (2.0 * means[:, 0]),
               "inertial": abs(stage.rate) * stage.scale / np.sqrt(np.abs(means[:, 1]))}
    mu = stress / pressure
    drifting = [name for name, values in (("mu", shear / pressure), ("phi", fraction)) if statistics.drifts(values)]
    return SteadyShear(
        stage, run, abs(stage.rate) * stage.scale / np.sqrt(abs(pressure)), abs(stage.rate), pressure, stress, mu,
        max(float(samples["mu"].std()), statistics.mean_error((shear - mu * normal) / pressure)),
        float(fraction.mean()), statistics.mean_error(fraction),
        float(sign * difference.mean() / (2.0 * stress)), float(samples["normal"].std()),
        float(rows["coordination_held"].mean()) if "coordination_held" in rows else float("nan"),
        " and ".join(drifting), samples)


def straight(x: Array, y: Array, errors: Array) -> Array:
    """Intercept and slope."""
    return linear_fit(np.column_stack([np.ones_like(x), x]), y, errors)[0]


def curved(x: Array, y: Array, errors: Array) -> Array:
    """mu_s, mu_2 and I_0 of mu_s + (mu_2 - mu_s)/(1 + I_0/I): linear in two of them for each I_0."""
    def basis(log: float) -> Array:
        return np.column_stack([np.ones_like(x), x / (x + np.exp(log))])

    log = statistics.least_on_grid(lambda log: linear_fit(basis(log), y, errors)[1],
                                   np.log(0.3 * x.min()), np.log(30.0 * x.max()))
    base, rise = linear_fit(basis(log), y, errors)[0]
    return np.array([base, base + rise, np.exp(log)])


def with_errors(fit: Callable[[Array, Array, Array], Array], x: Array, y: Array, errors: Array,
                draws: Array) -> tuple[Array, Array]:
    """Values of a fit and their bootstrap errors; `draws` are samples (sample, 2, stage) of x and y."""
    values = fit(x, y, errors)
    found = np.array([fit(draw[0], draw[1], errors) for draw in draws])
    return values, found.std(axis=0)


def fit_rheology(shears: Sequence[SteadyShear]) -> Fits:
    """Fits of mu(I) and phi(I): a dict of name: (value, error). Empty with fewer than two inertial numbers."""
    slow = [shear for shear in shears if shear.inertial <= FASTEST]
    x = np.array([shear.inertial for shear in slow])
    if distinct(x) < LEAST_LINEAR:
        return {}
    result = {}
    for name, words in (("mu", ("mu_s", "a")), ("phi", ("phi_c", "b"))):
        y = np.array([getattr(shear, name) for shear in slow])
        errors = np.array([getattr(shear, f"{name}_error") for shear in slow])
        draws = np.stack([np.array([shear.samples["inertial"] for shear in slow]).T,
                          np.array([shear.samples[name] for shear in slow]).T], axis=1)
        values, spread = with_errors(straight, x, y, errors, draws)
        if name == "phi":
            values[1] = -values[1]
        for word, value, error in zip(words, values, spread):
            result[word] = (float(value), float(error))
        if name == "mu" and distinct(x) >= LEAST_CURVED:
            values, spread = with_errors(curved, x, y, errors, draws[::4])
            if spread[2] < values[2] and values[1] > values[0]:
                for word, value, error in zip(("curve_mu_s", "curve_mu_2", "curve_I_0"), values, spread):
                    result[word] = (float(value), float(error))
    return result


def distinct(numbers: Iterable[float]) -> int:
    """Number of values that differ by more than a tenth."""
    count, last = 0, 0.0
    for number in sorted(numbers):
        if number > 1.1 * last:
            count, last = count + 1, number
    return count
