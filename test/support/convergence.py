# SPDX-License-Identifier: BSD-3-Clause
"""Observed order of convergence over a series of grids.

    import convergence
    rate = convergence.order((16, 22, 30, 42), errors)

The order is the slope of a least-squares line through the logarithms of all errors. At least four grids are needed, and
none may have a power of two times the cells of another: on such grids particles keep their places relative to cells
and faces, so an error that depends on these places may fall, or stay, on all of them alike.
"""

import math

LEAST = 4


def check(cells):
    """The numbers of cells must be fit for an order."""
    cells = sorted(float(number) for number in cells)
    assert len(cells) >= LEAST, f"{len(cells)} grids, at least {LEAST} are needed: {cells}"
    for number, coarse in enumerate(cells):
        for fine in cells[number + 1:]:
            doublings = math.log2(fine / coarse)
            assert abs(doublings - round(doublings)) > 0.02, f"{fine:g} cells are a power of two times {coarse:g}"


def order(cells, errors):
    """Order of the absolute values of the errors, by least squares over all grids; minus infinity if one of them is not
    finite, infinity if one is zero."""
    cells, sizes = list(cells), [abs(error) for error in errors]
    check(cells)
    assert len(cells) == len(sizes), f"{len(cells)} grids, {len(sizes)} errors"
    if not all(math.isfinite(size) for size in sizes):
        return -math.inf
    if 0.0 in sizes:
        return math.inf
    x, y = [math.log(number) for number in cells], [math.log(size) for size in sizes]
    middle, height = sum(x) / len(x), sum(y) / len(y)
    return -sum((a - middle) * (b - height) for a, b in zip(x, y)) / sum((a - middle) ** 2 for a in x)
