# SPDX-License-Identifier: BSD-3-Clause
"""Means with error bars from correlated rows, drift, bootstrap, and fits by separated variables."""
from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    from scree.arrays import Array

SAMPLES = 400            # of a bootstrap
FEWEST_BLOCKS = 8        # fewest blocks for an error bar


def blocks(values: Array, count: int) -> Array:
    """Means of `count` blocks of equal length; a remainder at the start is excluded."""
    values = np.asarray(values, dtype=float)
    length = len(values) // count
    return np.asarray(values[len(values) - length * count:].reshape(count, length, *values.shape[1:]).mean(axis=1))


def block_counts(rows: int) -> list[int]:
    """Numbers of blocks, halved down to the smallest."""
    counts, count = [], rows
    while count >= FEWEST_BLOCKS:
        counts.append(count)
        count //= 2
    return counts or [max(rows, 1)]


def mean_error(values: Array) -> float:
    """Standard error of the mean of a correlated series: the greatest over lengths of blocks (H. Flyvbjerg,
    H. G. Petersen, J. Chem. Phys. 91 (1989) 461)."""
    if len(values) < 2:
        return float("nan")
    errors = [np.std(blocks(values, count), ddof=1) / np.sqrt(count) for count in block_counts(len(values))
              if count > 1]
    return float(max(errors))


def fitting_blocks(values: Array) -> int:
    """The number of blocks with the greatest error bar: the means of these blocks count as independent."""
    counts = [count for count in block_counts(len(values)) if count > 1]
    if not counts:
        return 1
    return max(counts, key=lambda count: np.std(blocks(values, count), ddof=1) / np.sqrt(count))


def drift(values: Array) -> tuple[float, float]:
    """Difference of the means of the second and the first half, and its standard error."""
    half = len(values) // 2
    if half < 4:
        return 0.0, float("nan")
    first, second = values[:half], values[half:]
    return float(second.mean() - first.mean()), float(np.hypot(mean_error(first), mean_error(second)))


def drifts(values: Array, share: float = 0.05) -> bool:
    """True if a mean changes over the rows: by more than three error bars and more than a fraction of itself."""
    change, error = drift(values)
    return bool(np.isfinite(error) and abs(change) > 3.0 * error and abs(change) > share * abs(np.mean(values)))


def resampled_means(columns: Any, generator: np.random.Generator, samples: int = SAMPLES) -> Array:
    """Means (sample, column) of rows resampled in blocks, the same blocks for all columns."""
    columns = np.asarray(columns, dtype=float)
    count = max(fitting_blocks(column) for column in columns[:1])
    count = min([count, *(fitting_blocks(column) for column in columns[1:])])
    means = blocks(columns.T, max(count, 1))
    drawn = generator.integers(0, len(means), (samples, len(means)))
    # the spread of resampled means of n blocks is too small by sqrt((n - 1)/n)
    result = means[drawn].mean(axis=1)
    stretch = np.sqrt(len(means) / max(len(means) - 1.0, 1.0))
    return np.asarray(means.mean(axis=0) + stretch * (result - means.mean(axis=0)))


def weights_of(errors: Array) -> Array:
    """Weights of a least-squares fit; without error bars all are equal."""
    errors = np.asarray(errors, dtype=float)
    good = np.isfinite(errors) & (errors > 0.0)
    if not good.all():
        return np.ones(len(errors))
    return 1.0 / errors


def linear_fit(basis: Array, values: Array, errors: Array) -> tuple[Array, float]:
    """Coefficients of the columns of `basis`, and the sum of weighted squares."""
    weights = weights_of(errors)
    scaled, target = basis * weights[:, None], values * weights
    square = scaled.T @ scaled
    # the normal equations are fast; where they lose digits the slower method is used
    if np.linalg.det(square) > 1.0e-8 * np.prod(np.diag(square)):
        found = np.linalg.solve(square, scaled.T @ target)
    else:
        found = np.linalg.lstsq(scaled, target, rcond=None)[0]
    return found, float(np.sum((scaled @ found - target) ** 2))


def least_on_grid(function: Callable[[float], float], low: Any, high: Any, points: int = 41, rounds: int = 6) -> float:
    """Position of the minimum of a function of one number, by successively refined grids."""
    ends = low, high
    best = low
    for _ in range(rounds):
        grid = np.linspace(low, high, points)
        best = grid[int(np.argmin([function(x) for x in grid]))]
        width = (high - low) / (points - 1)
        low, high = max(ends[0], best - 2.0 * width), min(ends[1], best + 2.0 * width)
    return float(best)


def least_on_plane(function: Callable[[float, float], float], low: Any, high: Any, points: tuple[int, int] = (25, 13),
                   rounds: int = 7) -> tuple[float, float]:
    """The same for two numbers."""
    low, high = np.array(low, dtype=float), np.array(high, dtype=float)
    ends = low.copy(), high.copy()
    best = low
    for _ in range(rounds):
        axes = [np.linspace(low[k], high[k], points[k]) for k in (0, 1)]
        values = np.array([[function(x, y) for y in axes[1]] for x in axes[0]])
        row, column = np.unravel_index(int(np.argmin(values)), values.shape)
        best = np.array([axes[0][row], axes[1][column]])
        width = 2.0 * (high - low) / (np.array(points) - 1)
        low, high = np.maximum(ends[0], best - width), np.minimum(ends[1], best + width)
    return float(best[0]), float(best[1])
