# SPDX-License-Identifier: BSD-3-Clause
"""Draws the results of the runs in out/: energies over time, and the first and last particles.

    python3 plot.py [FOLDER ...]       # default: all folders in out/; writes CASE.png into each

Needs numpy, h5py and matplotlib. You can edit this script.
"""

import csv
import sys
from pathlib import Path

import h5py
import matplotlib
import numpy as np

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402


def history(path):
    """Columns of a history by name, and their units."""
    with open(path, newline="", encoding="utf-8") as lines:
        heading, *rows = csv.reader(lines)
    values = np.array(rows, dtype=float)
    names = [column.split(" [")[0] for column in heading]
    units = {name: column[len(name):].strip(" []") for name, column in zip(names, heading)}
    return dict(zip(names, values.T)), units


def snapshot(path):
    """Time, positions, what they are coloured by, its name, and the unit of length."""
    with h5py.File(path) as file:
        data = file["VTKHDF"]
        fields = data["PointData"]
        name = "plastic_strain" if "plastic_strain" in fields else "speed"
        colour = (fields["plastic_strain"][:] if name in fields
                  else np.linalg.norm(fields["velocity"][:], axis=1))
        unit = data["Points"].attrs["units"]
        unit = unit.decode() if isinstance(unit, bytes) else str(unit)
        return float(data["FieldData/TimeValue"][0]), data["Points"][:], colour, name, unit


def draw(folder):
    """One picture of one run."""
    case = next(folder.glob("*_history.csv")).name.removesuffix("_history.csv")
    columns, units = history(folder / f"{case}_history.csv")
    files = sorted(folder.glob(f"{case}_p_[0-9]*.hdf"))
    figure, axes = plt.subplots(1, 3, figsize=(13, 4.2), layout="constrained")
    for name in ("kinetic", "internal", "dissipated", "total"):
        axes[0].plot(columns["time"], columns[name], label=name)
    axes[0].set_xlabel(f"time [{units['time']}]")
    axes[0].set_ylabel(f"energy [{units['kinetic']}]")
    axes[0].legend()
    for axis, file in zip(axes[1:], (files[0], files[-1])):
        time, points, colour, name, unit = snapshot(file)
        dots = axis.scatter(points[:, 0], points[:, 2], c=colour, s=1.0, linewidths=0)
        axis.set_title(f"{name.replace('_', ' ')}, t = {time:.4g}")
        axis.set_aspect("equal")
        axis.set_xlabel(f"x [{unit}]")
        axis.set_ylabel(f"z [{unit}]")
        figure.colorbar(dots, ax=axis)
    figure.savefig(folder / f"{case}.png", dpi=120)
    print(f"wrote {folder / case}.png")


def main():
    """All folders that were named, or all that there are."""
    named = [Path(word) for word in sys.argv[1:]]
    folders = named or [path.parent for path in sorted(Path("out").glob("*/*_history.csv"))]
    if not folders:
        sys.exit("there is nothing in out/ yet: run a deck first")
    for folder in dict.fromkeys(folders):
        draw(folder)


if __name__ == "__main__":
    main()
