# SPDX-License-Identifier: BSD-3-Clause
"""Metal bars on a wall.

A bar strikes a hard wall, and its foot is flattened (G. I. Taylor 1948). Axisymmetric, smooth rigid wall, material of
the library with the law of Johnson and Cook, without failure. Choice of the constants: Johnson and Cook fitted them
to torsion and tension tests, not to these bars. *Waist* is the diameter at a fifth of the initial length. The error
of the lengths was not read in any source, nor was the temper of the copper of Wilkins, Gust, House and Zelepugin, on
which its yield stress depends. Relative to the shortening, a deviation of the length is 1/(1 - ratio) times as large.
"""
import numpy as np

SUBJECT = "metals"
QUANTITIES = {"ratio": ("final over initial length", "1"), "foot": ("diameter of the foot", "mm"),
              "waist": ("diameter of the waist", "mm")}
CELLS = 12                             # on the radius


def extend(line):
    """Half a step beyond the last position of a line of the lattice, from the last three: the surface of the bar."""
    return line[-1] + 0.5 * (1.5 * (line[-1] - line[-2]) - 0.5 * (line[-2] - line[-3]))


def lattice(begin, end):
    """Positions (r, z) at the end by column and row of the lattice at the start."""
    first = begin.points[np.argsort(begin["identity"])]
    columns, rows = (np.unique(first[:, axis].round(9), return_inverse=True)[1] for axis in (0, 2))
    found = np.full((columns.max() + 1, rows.max() + 1, 2), np.nan)
    found[columns, rows] = end.points[np.argsort(end["identity"])][:, [0, 2]]
    return found


def measure(run, shot):
    """Length and diameters at the end."""
    start, end = (lattice(run.snapshots[0], run.snapshots[place]) for place in (0, -1))
    length = extend(start.swapaxes(0, 1))[:, 1].max()
    side, foot = extend(end), extend(end[:, ::-1].swapaxes(0, 1))
    return {"ratio": extend(end.swapaxes(0, 1))[:, 1].max() / length,
            "foot": 2.0e3 * max(side[:, 0].max(), foot[:, 0].max()),
            "waist": 2.0e3 * np.interp(0.2 * length, side[:, 1], side[:, 0])}
