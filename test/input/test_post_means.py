# SPDX-License-Identifier: BSD-3-Clause
# tiers: smoke
"""scree-post means: means of tables and of fields on the grid.

Would catch rows outside of the time window, an error bar of correlated rows that is that of independent ones, a drift
that is not reported, and grids of another extent that are added to the wrong cells.
"""

import h5py
import numpy as np

import case
import post_command

# A block that flies through cells: the smallest box of cells that contains it moves with it.
DECK = """
&run  dimension='plane_strain' /
&grid  lo=0,0,0  hi=3,1,1  dx=0.1 /
&time  t_end=0.5 /
&material  name='m'  density=1000  young=1e6  poisson=0.3 /
&region  name='r'  shape='box'  lo=0.2,0,0.2  hi=0.6,1,0.6 /
&body  name='b'  region='r'  material='m'  velocity=2,0,0 /
&output  name='g'  kind='grid'  dt=0.05  fields='density' /
"""
ROWS, MEMORY = 20000, 0.9


def test_tables(options, sheet):
    """A correlated series with a known error, and one with a drift."""
    noise = np.random.default_rng(1).standard_normal(ROWS)
    values = np.zeros(ROWS)
    for row in range(1, ROWS):
        values[row] = MEMORY * values[row - 1] + noise[row]
    time = np.arange(ROWS) * 1e-3
    path = options.work / "series.csv"
    late = time >= 2.0
    lines = [f"{t!r},{n},{v + 3 if t >= 2 else 1e6!r},{t!r}" for n, (t, v) in
             enumerate(zip(time.tolist(), values.tolist()))]
    path.write_text("time [s],step,level [Pa],ramp [J]\n" + "\n".join(lines) + "\n", encoding="utf-8")
    out = options.work / "means.csv"
    said = post_command.call("means", path, "--from", "2s", "--out", out).stdout
    sheet.require("ramp" in said and said.splitlines()[-1].endswith("drifts"), f"the ramp drifts: {said}")
    table = np.genfromtxt(out, delimiter=",", names=True, dtype=None, encoding="utf-8")
    # the error of a mean of n rows with memory m per row is sigma/(1 - m)/sqrt(n); averaging over blocks finds most of
    # it
    sheet.near("mean of the level", table["mean"][0], 3 + values[late].mean(), 1e-12)
    sheet.near("its error", table["error"][0], 10 / np.sqrt(late.sum()), 0.35)


def test_grids(options, sheet):
    """Cells keep their positions although the files have different boxes."""
    run = case.Case(options, "flight", DECK).run("-q")
    out = options.work / "mean.hdf"
    post_command.call("means", run.path("_g.hdf.series"), "--out", out)
    total = {}
    files = sorted(run.folder.glob("flight_g_*.hdf"))
    for path in files:
        with h5py.File(path) as handle:
            first = handle["VTKHDF"].attrs["Origin"][0]
            for n, value in enumerate(handle["VTKHDF/PointData/density"][2, 0, :]):
                key = round((first + 0.1 * n) * 100)
                total[key] = total.get(key, 0.0) + value / len(files)
    with h5py.File(out) as handle:
        first, mean = handle["VTKHDF"].attrs["Origin"][0], handle["VTKHDF/PointData/density"][2, 0, :]
        error = handle["VTKHDF/PointData/density_error"][2, 0, :]
    sheet.require(len(mean) == len(total) > 10, f"the image spans the flight: {len(mean)} cells")
    wrong = max(abs(total[round((first + 0.1 * n) * 100)] - value) for n, value in enumerate(mean))
    sheet.below("mean density of a row of cells over that of the block", wrong / 1000.0, 1e-6)
    sheet.require(error.max() > 10.0, "cells that are empty at times have an error")
