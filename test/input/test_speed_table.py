# SPDX-License-Identifier: BSD-3-Clause
# tiers: smoke
"""The comparison of test/bench/table.py, with made-up numbers: no time of a run is judged.

Would catch: a slowdown that is not told or one that is told of a slower machine, a row without a reference that
passes in silence, ratios of other rows, nanoseconds from the slowest of the runs, phases that do not add up, rows that
are planned twice or whose deck the program no longer takes.
"""

import argparse
import json
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "bench"))
sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "support"))
import case    # noqa: E402
import report  # noqa: E402
import table   # noqa: E402


def summary(nanoseconds):
    """What a run with a million updates says of itself."""
    return {"processor_s": 1.0e-3 * nanoseconds, "particle_updates": 1000000, "particles": 50000, "steps": 20,
            "bytes_per_particle": 300.0, "particle_updates_per_s": 1.0e9 / nanoseconds,
            "timers": {"points to nodes": {"avg": 1.0}, "grid": {"avg": 0.5}, "nodes to points": {"avg": 1.5},
                       "eos": {"avg": 0.4}, "strength": {"avg": 0.6}, "output": {"avg": 100.0}}}


def rows(shift=1.0, bandwidth=20.0, flat=1.0, plastic=1.0):
    """Rows of one method; `shift` makes all slower, `flat` those of two dimensions, `plastic` those of metal."""
    made = []
    for dimension, law, spent in (("3d", "elastic", 300.0), ("plane_strain", "elastic", 120.0 * flat),
                                  ("3d", "von_mises", 360.0 * plastic)):
        runs = [summary(shift * spent * more) for more in (1.3, 1.0, 2.0)]
        made.append(table.row_of(("ddmp", dimension, law, "1x1"), runs, bandwidth))
    return made


def judge_rows(sheet):
    """One row."""
    row = rows()[0]
    sheet.near("the least of the runs [ns]", row["ns"], 300.0, 1e-12)
    sheet.near("phases add up [ns]", sum(row[f"ns {short}"] for short in table.COLUMNS), 300.0, 1e-12)
    sheet.near("output is no phase of the steps [ns]", row["ns to particles"], 300.0 * 1.5 / 4.0, 1e-12)
    sheet.near("effects of matter add up [ns]", row["ns matter"], 300.0 * 1.0 / 4.0, 1e-12)
    sheet.near("share of the bandwidth", row["bandwidth"], 2.0 * 300.0 / 300.0 / 20.0, 1e-12)
    sheet.near("ratio to 8 bytes", row["ratio"], 300.0 / 0.4, 1e-12)
    text = table.markdown(rows(), {"copy": 18.0, "triad": 20.0})
    sheet.require("| ddmp | 3d | elastic | 1x1 | 3.33 | 300 |" in text, f"the readable table: {text}")


def judge_comparison(sheet):
    """Against a reference."""
    stored = {table.key_of(row): row["ratio"] for row in rows()}
    sheet.require(table.slower(rows(), stored) == [], "the same is no slowdown")
    sheet.require(table.slower(rows(shift=1.24), stored) == [], "a little more is none")
    sheet.require(len(table.slower(rows(shift=1.26), stored)) == 3, "too much is told of each row")
    sheet.require(table.slower(rows(shift=2.0, bandwidth=10.0), stored) == [], "a slower machine is no slowdown")
    told = table.slower(rows(plastic=1.5), stored)
    sheet.require(len(told) == 1 and told[0].startswith("ddmp 3d von_mises 1x1: 1.50 times slower"), f"one: {told}")
    del stored["ddmp 3d elastic 1x1"]
    sheet.require(table.slower(rows(), stored) == ["ddmp 3d elastic 1x1: no reference; --store makes one"], "new row")


def judge_shares(sheet):
    """Rates beside one another."""
    told, seen = table.shortfalls(rows())
    sheet.require(told == [] and len(seen) == 2, f"good rates: {told}, {seen}")
    sheet.near("J2 over elastic", seen["ddmp 3d von_mises 1x1", "ddmp 3d elastic 1x1"], 300.0 / 360.0, 1e-12)
    sheet.require(len(table.shortfalls(rows(flat=1.3))[0]) == 1, "two dimensions are too slow")
    sheet.require(len(table.shortfalls(rows(plastic=1.3))[0]) == 1, "a law is too slow")


def judge_plan(options, sheet):
    """The rows that are made, a few of them with few steps, and the reference."""
    names = table.plan()
    sheet.require(len(names) == len(set(names)), "no row is planned twice")
    stored = json.loads(table.REFERENCE.read_text(encoding="utf-8"))
    missing = [" ".join(name) for name in names if " ".join(name) not in stored]
    sheet.require(not missing, f"rows without a reference: {missing}")
    short = argparse.Namespace(scree=options.scree, work=options.work)
    for name in (("ddmp", "3d", "elastic", "1x1"), ("cpdi", "1d", "elastic", "1x1"),
                 ("ddmp", "axisymmetric", "johnson_cook", "1x1"), ("ddmp", "plane_strain", "drucker_prager", "1x1")):
        size = list(table.DIMENSIONS[name[1]])
        table.DIMENSIONS[name[1]] = (*size[:-1], 3)
        row = table.row_of(name, [table.run(short, name)], 20.0)
        sheet.require(row["particles"] > 10000 and row["ns"] > 0.0 and row["bytes"] > 100.0, f"{name}: {row}")


def main():
    """Numbers, then a few steps."""
    options = case.arguments()
    sheet = report.Report()
    judge_rows(sheet)
    judge_comparison(sheet)
    judge_shares(sheet)
    judge_plan(options, sheet)
    sheet.end()


if __name__ == "__main__":
    main()
