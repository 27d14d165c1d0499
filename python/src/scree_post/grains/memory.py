# SPDX-License-Identifier: BSD-3-Clause
"""The relaxation time tau of the shear stress, measured by independent methods.

survival       age distribution of living contacts. In steady shear contacts are born at a constant rate B per unit
               of strain; of those born a strain a ago the share S(a) survives, so n(a) = B S(a): the distribution of
               ages is proportional to the survival function. Of S = exp(-a/gamma) the mean age of the contacts younger
               than A is gamma - A/(exp(A/gamma) - 1), which gives gamma with the greatest likelihood.
               S = exp(-(a/s)^beta) tests the form.
hold           shear stress after a stop, r + (q - r) exp(-(t/tau)^beta)
normal         W = N1/(2 sigma_xy) of steady shear; the relaxation law has W = tau rate
correlation    time of correlation of sigma_xy in steady shear, as if fluctuations decay like the mean
reversal       r + (q - r) exp(-a/gamma) in the strain a since the reversal, with q the stress before it, as in the law
"""
from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from . import cell_run, statistics
from .statistics import least_on_grid, least_on_plane, linear_fit

if TYPE_CHECKING:
    from scree.arrays import Array

    from .cell_run import CellRun, Stage
    from .rheology import SteadyShear

FOUR = ("survival", "hold", "normal", "correlation")
LEAST_AGES = 100         # contacts that a survival law needs at least
LEAST_ROWS = 20          # rows that a decay or a correlation needs at least
DRAWS = 40               # bootstrap samples of decays


@dataclass
class Memory:
    """One measurement of tau; strain = tau rate."""

    measure: str
    stage: str
    inertial: float
    rate: float                                          # of the corresponding shear, absolute [1/s]
    pressure: float                                      # [Pa]
    strain: float                                        # tau rate [1]
    error: float                                         # standard error of it [1]
    beta: float = float("nan")                           # stretching exponent, where one is fitted
    residual: float = float("nan")                       # remaining stress, over that of steady shear
    note: str = ""
    curve: tuple[Array, ...] = ()                                    # data and fit, for the figures

    @property
    def tau(self) -> float:
        """Relaxation time [s]."""
        return self.strain / self.rate

    @property
    def tau_error(self) -> float:
        """Standard error of tau [s]."""
        return self.error / self.rate


def truncated_mean(gamma: float, window: float) -> float:
    """Mean age of contacts younger than `window` of a survival law exp(-a/gamma)."""
    x = window / gamma
    return gamma - window / np.expm1(x) if x < 500.0 else gamma


def exponential_age(mean: float, window: float) -> float:
    """gamma of a survival law exp(-a/gamma) from the mean age below `window`."""
    if not 0.0 < mean < 0.49 * window:
        return float("nan")                              # no decay within the window
    from scipy.optimize import brentq
    return float(brentq(lambda gamma: truncated_mean(gamma, window) - mean, 1.0e-3 * mean, 100.0 * window,
                        xtol=1.0e-14 * mean, rtol=1.0e-13))


def stretched_age(ages: Array, window: float) -> tuple[float, float]:
    """s and beta of greatest likelihood of ages with the survival law exp(-(a/s)^beta), younger than `window`."""
    ages = np.sort(ages)
    count = min(400, len(ages))
    binned = np.array([part.mean() for part in np.array_split(ages, count)])
    share = np.array([len(part) for part in np.array_split(ages, count)]) / len(ages)
    nodes = window * ((np.arange(800) + 0.5) / 800) ** 2
    width = np.diff(window * (np.arange(801) / 800) ** 2)

    def loss(log: float, beta: float) -> float:
        scale = np.exp(log)
        total = np.sum(np.exp(-(nodes / scale) ** beta) * width)
        return float(np.sum(share * (binned / scale) ** beta) + np.log(total))

    mean = float(ages.mean())
    log, beta = least_on_plane(loss, (np.log(0.05 * mean), 0.3), (np.log(20.0 * mean), 3.0), rounds=6)
    return float(np.exp(log)), float(beta)


def survival(run: CellRun, shear: SteadyShear, skip: float, generator: np.random.Generator) -> Memory | None:
    """tau from the ages of the contacts in the snapshots of a stage, or None."""
    window = shear.stage.skipped(skip)
    every = [one["age_strain"][one["age_strain"] < window] for one in cell_run.ages_of(run, shear.stage, skip)]
    every = [ages for ages in every if len(ages)]
    if sum(map(len, every)) < LEAST_AGES or not window > 0.0:
        return None
    ages = np.concatenate(every)
    gamma = exponential_age(float(ages.mean()), window)
    if not np.isfinite(gamma):
        return None
    sums, counts = np.array([one.sum() for one in every]), np.array([len(one) for one in every])
    drawn = generator.integers(0, len(every), (statistics.SAMPLES, len(every)))
    spread = [exponential_age(mean, window) for mean in sums[drawn].sum(axis=1) / counts[drawn].sum(axis=1)]
    scale, beta = stretched_age(ages, window)
    error = np.nanstd(spread) * np.sqrt(len(every) / max(len(every) - 1.0, 1.0))
    ages = np.sort(ages)
    curve = (ages, 1.0 - np.arange(len(ages)) / len(ages), scale)
    return memory("survival", shear, gamma, max(error, gamma / np.sqrt(len(ages))), beta=beta,
                  note=f"{len(ages)} ages of {len(every)} snapshots", curve=curve)


def memory(measure: str, shear: SteadyShear, strain: float, error: float, **more: Any) -> Memory:
    """A measurement of a steady shear."""
    return Memory(measure, shear.stage.name, shear.inertial, shear.rate, shear.pressure, float(strain), float(error),
                  **more)


def decay_fit(x: Array, y: Array, near: Array | None = None) -> Array:
    """r, q, scale and beta of r + (q - r) exp(-(x/scale)^beta) by least squares with q > r, searched everywhere or near
    the values of an earlier fit."""
    def basis(log: float, beta: float) -> Array:
        kept = np.exp(-(x / np.exp(log)) ** beta)
        return np.column_stack([1.0 - kept, kept])

    def loss(log: float, beta: float) -> float:
        (rest, first), squares = linear_fit(basis(log, beta), y, ones)
        return squares if first > rest else constant

    ones, constant = np.ones(len(x)), float(np.sum((y - y.mean()) ** 2))
    low, high = np.array([np.log(0.3 * max(x[0], 1.0e-3 * x[-1])), 0.3]), np.array([np.log(2.0 * x[-1]), 4.0])
    if near is None:
        log, beta = least_on_plane(loss, low, high)
    else:
        middle = np.array([np.log(near[2]), near[3]])
        log, beta = least_on_plane(loss, np.maximum(low, middle - 0.7), np.minimum(high, middle + 0.7),
                                   points=(9, 9), rounds=4)
    rest, first = linear_fit(basis(log, beta), y, ones)[0]
    return np.array([rest, first, np.exp(log), beta])


def decay_with_errors(x: Array, y: Array, generator: np.random.Generator) -> tuple[Array, Array, Array]:
    """A fit of a decay and its errors, from residuals that are resampled in blocks."""
    values = decay_fit(x, y)
    rest, first, scale, beta = values
    smooth = rest + (first - rest) * np.exp(-(x / scale) ** beta)
    left = y - smooth
    draws = [decay_fit(x, smooth + noise, values) for noise in drawn_noise(left, generator)]
    errors = np.std(draws, axis=0)
    errors[2] = max(errors[2], x[0])                     # resolution of the rows
    return values, errors, smooth


def drawn_noise(left: Array, generator: np.random.Generator) -> Iterator[Array]:
    """Series of residuals resampled in blocks."""
    length = max(1, len(left) // 20)
    for _ in range(DRAWS):
        begins = generator.integers(0, max(len(left) - length, 1), len(left) // length + 1)
        yield np.concatenate([left[begin:begin + length] for begin in begins])[:len(left)]


def return_fit(x: Array, y: Array, first: float) -> tuple[float, float]:
    """r and scale of r + (first - r) exp(-x/scale) by least squares."""
    def basis(log: float) -> Array:
        return np.asarray(1.0 - np.exp(-x / np.exp(log)))[:, None]

    def fit(log: float) -> tuple[Array, float]:
        return linear_fit(basis(log), y - first * (1.0 - basis(log)[:, 0]), ones)

    ones = np.ones(len(x))
    log = least_on_grid(lambda log: fit(log)[1], np.log(0.3 * x[0]), np.log(2.0 * x[-1]))
    return float(fit(log)[0][0]), float(np.exp(log))


def hold(run: CellRun, stage: Stage, shears: Sequence[SteadyShear], generator: np.random.Generator) -> Memory | None:
    """tau from the decay of the shear stress after a stop."""
    shear = next((one for one in shears if one.stage is run.before(stage)), None)
    if shear is None or len(stage.rows["time"]) < LEAST_ROWS:
        return None
    time = stage.middle()
    stress = np.sign(shear.stage.rate) * stage.rows["stress_xy"] / shear.stress
    values, errors, smooth = decay_with_errors(time, stress, generator)
    rest, first, scale, beta = values
    last = float(np.sign(shear.stage.rate) * shear.stage.rows["stress_xy"][-1] / shear.stress)
    # less than half of the decay is measured, or it is not this decay
    if first - rest < 0.5 * (last - rest) or first <= rest or scale < time[0]:
        rest = float(stress[-len(stress) // 10:].mean())
        return memory("hold", shear, time[0] * shear.rate, time[0] * shear.rate, residual=rest,
                      note=f"not resolved: the stress is gone within a row of the history; {100.0 * rest:.0f} % of "
                      "that of steady shear is there at the end", curve=(time, stress, np.full(len(time), np.nan)))
    note = (f"{100.0 * rest:.1f}({100.0 * errors[0]:.1f}) % of the stress of steady shear stays, "
            f"{100.0 * rest / first:.0f} % of that at the stop, exponent {beta:.2f}({errors[3]:.2f})")
    return memory("hold", shear, scale * shear.rate, errors[2] * shear.rate, beta=float(beta), residual=float(rest),
                  note=note, curve=(time, stress, smooth))


def reversal(run: CellRun, stage: Stage, shears: Sequence[SteadyShear], skip: float,
             generator: np.random.Generator) -> Memory | None:
    """gamma from the recovery of the shear stress after the shear was reversed."""
    shear = next((one for one in shears if one.stage is stage), None)
    before = run.before(stage)
    if shear is None or before is None or before.kind != "shear" or before.rate * stage.rate > 0.0:
        return None
    strain = abs(stage.rate) * stage.middle()
    chosen = strain < max(stage.skipped(skip), 0.5)
    if chosen.sum() < LEAST_ROWS:
        return None
    strain = strain[chosen]
    stress = np.sign(stage.rate) * stage.rows["stress_xy"][chosen] / shear.stress
    few = max(1, len(before.rows["time"]) // 100)
    first = float(np.sign(stage.rate) * before.rows["stress_xy"][-few:].mean() / shear.stress)
    rest, scale = return_fit(strain, stress, first)
    smooth = rest + (first - rest) * np.exp(-strain / scale)
    spread = np.std([return_fit(strain, smooth + noise, first)[1]
                     for noise in drawn_noise(stress - smooth, generator)])
    return memory("reversal", shear, scale, max(spread, strain[0]), beta=1.0, residual=rest,
                  curve=(strain, stress, smooth))


def correlation_time(values: Array, width: float) -> tuple[float, float, Array]:
    """Correlation time of a series of means over intervals of a width, and its error.

    The integral of the correlation is truncated at five times its value (A. Sokal). The variance of means over
    intervals is smaller than that of the quantity, by the factor 2 y^2 (1/y - 1 + exp(-1/y)) for exp(-t/tau) and y =
    tau/width; this is corrected for."""
    left = values - values.mean()
    count = len(left)
    size = 1 << (2 * count - 1).bit_length()
    power = np.abs(np.fft.rfft(left, size)) ** 2
    share = np.fft.irfft(power, size)[:count] / np.arange(count, 0, -1)
    share = share / share[0]
    total, last = 0.5, 1
    for last in range(1, count // 2):
        total += share[last]
        if last >= 5.0 * total:
            break
    total = max(total, 1.0e-3)

    def seen(y: float) -> float:
        return y / (2.0 * y * y * (1.0 / y + np.expm1(-1.0 / y))) if y > 1.0e-2 else 0.5

    log = least_on_grid(lambda log: abs(seen(np.exp(log)) - total), np.log(0.02), np.log(10.0 * count))
    tau = width * np.exp(log)
    return float(tau), float(tau * np.sqrt(2.0 * (2.0 * last + 1.0) / count)), share


def correlation(shear: SteadyShear, skip: float) -> Memory | None:
    """tau from the autocorrelation of the shear stress."""
    rows = shear.stage.steady(skip)
    if len(rows["time"]) < 2 * LEAST_ROWS:
        return None
    width = float(np.median(np.diff(rows["time"]))) * shear.rate
    tau, error, share = correlation_time(rows["stress_xy"], width)
    shown = min(len(share), max(20, int(12.0 * tau / width)))
    note = "shorter than two rows of the history" if tau < 2.0 * width else ""
    return memory("correlation", shear, tau, error, note=note, curve=(width * np.arange(shown), share[:shown]))


def normal(shear: SteadyShear) -> Memory:
    """tau from the first normal stress difference. A value not above twice its error is discarded."""
    note = "" if shear.normal > 2.0 * shear.normal_error else "not above twice its error"
    return memory("normal", shear, shear.normal, shear.normal_error, note=note)


def measure_memory(run: CellRun, shears: Sequence[SteadyShear], skip: float,
                   generator: np.random.Generator) -> list[Memory]:
    """All measurements of a run."""
    found = []
    for shear in shears:
        if shear.run is run:
            found += [survival(run, shear, skip, generator), normal(shear), correlation(shear, skip),
                      reversal(run, shear.stage, shears, skip, generator)]
    found += [hold(run, stage, shears, generator) for stage in run.stages_of("hold")]
    return [one for one in found if one is not None]


def spread_of(memories: Sequence[Memory], stage: str) -> tuple[float, float, int]:
    """Least and greatest strain of the four methods for a stage, of those with a result, and their number."""
    found = [one.strain for one in memories if one.stage == stage and one.measure in FOUR
             and one.strain > 2.0 * one.error]
    return (min(found), max(found), len(found)) if found else (float("nan"), float("nan"), 0)


def rate_law(memories: Sequence[Memory], measure: str) -> tuple[tuple[float, float], tuple[float, float]] | None:
    """1/tau = 1/tau_0 + rate/gamma_c for one method over the rates: (gamma_c, error), (1/tau_0, error), or None."""
    chosen = [one for one in memories if one.measure == measure and one.strain > 2.0 * one.error > 0.0]
    if len({round(one.rate, 9) for one in chosen}) < 3:
        return None
    rate = np.array([one.rate for one in chosen])
    value = np.array([1.0 / one.tau for one in chosen])
    error = np.array([one.tau_error / one.tau ** 2 for one in chosen])
    basis = np.column_stack([rate, np.ones_like(rate)])
    slope, base = linear_fit(basis, value, error)[0]
    scaled = basis / error[:, None]
    covariance = np.linalg.inv(scaled.T @ scaled)
    excess = linear_fit(basis, value, error)[1] / (len(rate) - 2)
    errors = np.sqrt(np.diag(covariance) * max(1.0, excess))
    return (1.0 / slope, errors[0] / slope ** 2), (base, errors[1])
