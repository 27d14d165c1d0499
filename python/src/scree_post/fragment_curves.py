# SPDX-License-Identifier: BSD-3-Clause
"""Statistics of fragments: cumulative curves, fits of distributions, and comparisons of two runs or ensembles."""
from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from scree.arrays import Array

    from .fragment_table import Fragments

FEWEST = 10              # fragments for a fit or a test
REPEATS = 199            # samples of the parametric bootstrap
SHAPES = (0.05, 10.0)    # range of the exponent of Weibull's distribution
ROUNDING = 1.0e-6        # masses that differ by less, relatively, are equal: files are in single precision
SHIFT = 0.05             # relative difference of masses that the second difference of curves allows
SIGNIFICANT = 0.05       # probability below which distributions differ


@dataclass
class Sample:
    """The fragments of one run, or of several runs with other seeds."""

    name: str
    runs: list[Fragments]
    seeds: list[int]                                     # of the runs; empty if they are not an ensemble

    def masses(self, least: float) -> Array:
        """Masses of at least `least` of all runs together [kg], the lightest first."""
        every = np.concatenate([one.masses for one in self.runs]) if self.runs else np.zeros(0)
        return np.sort(every[every >= least])

    def numbers(self, least: float) -> Array:
        """Number of fragments of at least this mass in each run."""
        return np.array([np.count_nonzero(one.masses >= least) for one in self.runs])


def resolved_mass(samples: Sequence[Sample], particles: int) -> float:
    """Mass from which fragments have at least `particles` particles in all runs [kg].

    Masses are multiples of that of a particle, so the limit is half a particle below.
    """
    return (particles - 0.5) * max((one.particle for sample in samples for one in sample.runs), default=0.0)


def number_above(masses: Array, points: Array) -> Array:
    """Number of fragments of at least each mass of `points`."""
    return len(masses) - np.searchsorted(np.sort(masses), points * (1.0 - ROUNDING), side="left")


def mass_share(runs: Sequence[Fragments], points: Array) -> Array:
    """Share of the mass of all runs in fragments up to each mass of `points`, or in none: failed material counts as
    lighter than any fragment."""
    total = max(sum(one.total for one in runs), 1.0e-300)
    masses = np.sort(np.concatenate([one.masses for one in runs]))
    heavier = np.concatenate([[0.0], np.cumsum(masses[::-1])])[::-1]
    above = heavier[np.searchsorted(masses, points * (1.0 + ROUNDING), side="right")]
    return np.asarray(1.0 - above / total)


def greatest_gap(one: Sample, other: Sample, least: float, shift: float) -> tuple[float, float]:
    """Greatest difference of the cumulative mass curves from the mass `least` on, as a share of the mass, and where.

    A difference counts only if it remains when masses of one curve change by the factor 1 + `shift`.
    """
    points = np.concatenate([[least], one.masses(least), other.masses(least)])       # a curve rises at its masses only
    gaps = [mass_share(a.runs, points) - mass_share(b.runs, points * (1.0 + shift + ROUNDING))
            for a, b in ((one, other), (other, one))]
    gap = np.maximum(np.maximum(*gaps), 0.0)
    at = int(gap.argmax())
    return float(gap[at]), float(points[at])


@dataclass
class Fit:
    """A distribution fitted to masses above a limit.

    The share of fragments heavier than m is exp(-(m^k - m0^k) / scale^k), with k -> 0 a power law (m / m0)^-exponent.
    """

    name: str
    shape: float                                         # k: 1 exponential, 1/2 Mott, 0 power law
    scale: float                                         # [kg]; for the power law its exponent [1]
    least: float                                         # m0 [kg]
    aic: float = 0.0                                     # Akaike's criterion, of masses over m0
    distance: float = 0.0                                # Kolmogorov-Smirnov distance to the sample
    probability: float = 0.0                             # of a greater distance, by parametric bootstrap

    def above(self, masses: Array) -> Array:
        """Share of the fragments that are heavier than each mass."""
        return np.asarray(np.exp(-stretched(masses / self.least, self.shape) / self.mean()))

    def mean(self) -> float:
        """Mean of the stretched masses, which are exponential."""
        if self.shape == 0.0:
            return 1.0 / self.scale
        return float((self.scale / self.least) ** self.shape / self.shape)


def stretched(ratio: Array, shape: float) -> Array:
    """Masses over m0 on the scale on which the distribution is exponential."""
    logarithm = np.log(ratio)
    return np.asarray(logarithm if shape == 0.0 else np.expm1(shape * logarithm) / shape)


def likelihood(ratio: Array, shape: float) -> float:
    """Greatest logarithm of the likelihood of masses over m0 for this exponent."""
    return float(-len(ratio) * (np.log(stretched(ratio, shape).mean()) + 1.0)
                 + (shape - 1.0) * np.log(ratio).sum())


def best_shape(ratio: Array) -> float:
    """Exponent of the greatest likelihood."""
    from scipy import optimize
    found = optimize.minimize_scalar(lambda shape: -likelihood(ratio, shape), bounds=SHAPES, method="bounded")
    return float(found.x)


def distance_of(ratio: Array, shape: float) -> float:
    """Kolmogorov-Smirnov distance of masses over m0 to the distribution that is fitted to them."""
    values = np.sort(stretched(ratio, shape))
    below = -np.expm1(-values / values.mean())
    steps = np.arange(len(values) + 1) / len(values)     # scipy.stats.kstest takes ten times as long for each sample
    return float(np.maximum(steps[1:] - below, below - steps[:-1]).max())


def fit(name: str, masses: Array, least: float, shape: float | None) -> Fit:
    """Fit by maximum likelihood; without a shape that of Weibull is fitted, too."""
    ratio, random = masses / least, np.random.default_rng(1)
    chosen = best_shape(ratio) if shape is None else shape
    mean = float(stretched(ratio, chosen).mean())
    distance, beyond = distance_of(ratio, chosen), 0
    for _ in range(REPEATS):
        drawn = random.exponential(mean, len(ratio))
        drawn = np.exp(drawn if chosen == 0.0 else np.log1p(chosen * drawn) / chosen)
        beyond += distance_of(drawn, best_shape(drawn) if shape is None else chosen) >= distance
    return Fit(name, chosen, 1.0 / mean if chosen == 0.0 else least * (chosen * mean) ** (1.0 / chosen), least,
               2.0 * (1 + (shape is None)) - 2.0 * likelihood(ratio, chosen), distance, (1 + beyond) / (REPEATS + 1))


def fits(masses: Array, least: float) -> list[Fit]:
    """The distributions of fragments, fitted to masses above `least`; empty if there are too few of them."""
    if len(masses) < FEWEST or masses[-1] <= masses[0] * (1.0 + ROUNDING):
        return []
    return [fit(name, masses, least, shape) for name, shape in (
        ("exponential", 1.0), ("Mott", 0.5), ("power law", 0.0), ("Weibull", None))]


@dataclass
class Comparison:
    """Differences of two samples."""

    numbers: tuple[str, str]                             # of fragments in a run, with the standard error
    paired: str                                          # mean difference of runs of the same seed
    distance: float                                      # Kolmogorov-Smirnov distance of the masses; NaN if too few
    probability: float                                   # of a greater one by chance
    gap: float                                           # greatest difference of the mass curves, share of the mass
    place: float                                         # where [kg]
    shifted: float                                       # the same if masses may differ by SHIFT


def with_error(values: Array) -> str:
    """Mean and standard error as text."""
    if len(values) < 2:
        return f"{values.mean():.5g}" if len(values) else "none"
    return f"{values.mean():.5g} +- {values.std(ddof=1) / np.sqrt(len(values)):.2g}"


def compared(one: Sample, other: Sample, least: float) -> Comparison:
    """Compare fragments of at least the mass `least` [kg]."""
    distance = probability = np.nan
    samples = one.masses(least), other.masses(least)
    if min(map(len, samples)) >= FEWEST:
        from scipy import stats
        test = stats.ks_2samp(*(np.array([float(f"{mass:.6g}") for mass in masses]) for masses in samples))
        distance, probability = float(test.statistic), float(test.pvalue)
    both = sorted(set(one.seeds) & set(other.seeds))
    paired = ""
    if len(both) > 1:
        numbers = [sample.numbers(least)[[sample.seeds.index(seed) for seed in both]] for sample in (one, other)]
        paired = with_error(numbers[1] - numbers[0])
    gap, place = greatest_gap(one, other, least, 0.0)
    return Comparison((with_error(one.numbers(least)), with_error(other.numbers(least))), paired, distance, probability,
                      gap, place, greatest_gap(one, other, least, SHIFT)[0])


def verdict(result: Comparison) -> str:
    """The comparison in a sentence."""
    mass = (f"the cumulative mass curves differ by at most {100.0 * result.gap:.1f} % of the mass, at "
            f"{result.place:.4g} kg, and by {100.0 * result.shifted:.1f} % if masses may shift by "
            f"{100.0 * SHIFT:.0f} %")
    if np.isnan(result.distance):
        return f"Too few fragments for a test of the masses (at least {FEWEST} are needed); {mass}."
    words = "differ" if result.probability < SIGNIFICANT else "do not differ beyond chance"
    return (f"The distributions of the masses {words} (Kolmogorov-Smirnov distance {result.distance:.3f}, "
            f"p = {result.probability:.2g}); {mass}.")
