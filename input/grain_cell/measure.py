# SPDX-License-Identifier: BSD-3-Clause
"""The fitted law of grains on the path of its cell: start, reversal and stop, against its closed solution.

    python input/grain_cell/measure.py --scree build/bin/scree

Runs `continuum.nml`; the cell of discs itself is run and evaluated by `scree --grains` and `scree-post grains`.
"""
import sys
from pathlib import Path

import numpy as np

sys.path[:0] = [str(Path(__file__).resolve().parents[2] / folder) for folder in ("scripts", "python/src")]
from scree_scene import Study, Table   # noqa: E402

SHEAR, STRAIN = 2596.44, 0.100454      # G [Pa] and gamma_c of the material block
STEADY = SHEAR * STRAIN / (1.0 + STRAIN ** 2)
STAGES = {2: ("start, at a strain of 6", STEADY), 3: ("reversal, at a further strain of 4", -STEADY)}


def history(run):
    """Columns of the table of the cell."""
    return np.genfromtxt(run.folder / f"{run.case}_cell.csv", delimiter=",", names=True, deletechars="",
                         replace_space=" ")


def tables(runs):
    """Shear stress at the end of each part."""
    table = Table(["part", "shear stress [Pa]", "closed-form solution [Pa]", "pressure along z [Pa]"])
    rows = history(runs["continuum"])
    for stage, (name, closed) in STAGES.items():
        last = rows[rows["stage"] == stage][-1]
        table.rows.append([name, f"{last['stress_xz [Pa]']:.2f}", f"{closed:.2f}", f"{-last['stress_zz [Pa]']:.1f}"])
    return [table]


def draw(runs, plot):
    """Shear stress over time, with the steady stress of the closed solution."""
    figure, panel = plot.subplots(figsize=(8.0, 4.0), layout="constrained")
    rows = history(runs["continuum"])
    panel.plot(rows["time [s]"], rows["stress_xz [Pa]"], label="particles in a cell that deforms")
    for value in (STEADY, -STEADY):
        panel.axhline(value, color="0.6", linewidth=0.8, linestyle="--")
    panel.set(xlabel="time [s]", ylabel="shear stress [Pa]", title="Start, reversal and stop of the fitted law")
    panel.legend(frameon=False)
    return figure


CASES = {"continuum": ("continuum.nml", {})}

if __name__ == "__main__":
    Study(__file__, CASES, tables, {"continuum.png": draw}).main()
