# SPDX-License-Identifier: BSD-3-Clause
"""Order of convergence, extrapolated value and error bound of a number on three grids, and the cost of a smaller error.

From three values follow the observed order, the value for cells of size zero (L. F. Richardson 1911) and a bound of the
error of the finest run, the grid convergence index (P. J. Roache, J. Fluids Eng. 116 (1994) 405; I. B. Celik and
others, ibid. 130 (2008) 078001).
"""
from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

SAFE, CAUTIOUS = 1.25, 3.0               # safety factors: if the order is as expected, and if it is not
EXPECTED = (0.5, 2.5)                    # orders for which the smaller safety factor is used
UNCHANGED = 1.0e-12                      # relative changes below this are round-off


@dataclass(frozen=True)
class Verdict:
    """Results of a convergence analysis of three runs for one number."""

    kind: str                            # monotone, oscillating, not converging, does not change
    order: float                         # observed, NaN without one
    limit: float | None                  # extrapolated value, None where there is none
    error: float                         # bound of the error of the finest run
    safety: float                        # its safety factor


def observed_order(coarse: float, middle: float, ratio_fine: float, ratio_coarse: float) -> float:
    """Order p with (f3-f2)/(f2-f1) = r21^p (r32^p-1)/(r21^p-1); the right side increases with p.

    Arguments are the changes f3-f2 and f2-f1 and the two ratios of cell sizes, all above 1. The order is within -10
    and 20.
    """
    from scipy.optimize import brentq

    def excess(order: float) -> float:
        if abs(order) < 1.0e-9:
            return math.log(ratio_coarse) / math.log(ratio_fine) - coarse / middle
        fine = math.pow(ratio_fine, order)
        return fine * (math.pow(ratio_coarse, order) - 1.0) / (fine - 1.0) - coarse / middle

    low, high = -10.0, 20.0
    if excess(low) >= 0.0:
        return low
    return high if excess(high) <= 0.0 else float(brentq(excess, low, high, xtol=1.0e-12))


def judge(sizes: Sequence[float], values: Sequence[float]) -> Verdict:
    """The convergence analysis of a number from its values on three grids, coarse first."""
    coarse, middle, fine = values
    first, last = coarse - middle, middle - fine
    ratio_coarse, ratio_fine = sizes[0] / sizes[1], sizes[1] / sizes[2]
    spread = max(values) - min(values)
    if abs(last) <= UNCHANGED * max(map(abs, values)):
        return Verdict("does not change", math.nan, fine, CAUTIOUS * spread, CAUTIOUS)
    if first * last <= 0.0:
        return Verdict("oscillating", math.nan, None, CAUTIOUS * spread, CAUTIOUS)
    order = observed_order(first, last, ratio_fine, ratio_coarse)
    if order <= 0.05:
        return Verdict("not converging", order, None, math.inf, CAUTIOUS)
    safety = SAFE if EXPECTED[0] <= order <= EXPECTED[1] else CAUTIOUS
    gain = last / (ratio_fine ** min(order, EXPECTED[1]) - 1.0)
    return Verdict("monotone", order, fine - gain, safety * abs(gain), safety)


def cost_law(sizes: Sequence[float], seconds: Sequence[float], dimensions: int) -> tuple[float, float]:
    """Core-seconds for cells of size 1 if the cost grows as h^-(d+1), and the exponent found in the runs."""
    used = [(size, cost) for size, cost in zip(sizes, seconds) if cost > 0.0]
    if len(used) < 2:
        return math.nan, math.nan
    size, cost = np.log(used).T
    return float(np.exp(np.mean(cost + (dimensions + 1.0) * size))), -float(np.polyfit(size, cost, 1)[0])


def forecast(sizes: Sequence[float], seconds: Sequence[float], verdict: Verdict, tolerance: float,
             dimensions: int) -> tuple[float, float] | None:
    """Size of the cells for an error within a tolerance and their core-seconds; None without an order."""
    if verdict.kind != "monotone" or not verdict.error > 0.0:
        return None
    size = sizes[-1] * (tolerance / verdict.error) ** (1.0 / min(verdict.order, EXPECTED[1]))
    return size, cost_law(sizes, seconds, dimensions)[0] * size ** -(dimensions + 1.0)
