# SPDX-License-Identifier: BSD-3-Clause
"""Opening results: cases, tables and decks."""

from __future__ import annotations

import shutil
from pathlib import Path

import numpy as np
import pytest

import scree


def test_ways_to_open(run: scree.Run) -> None:
    """Would catch a way to name results that finds no case, a wrong case, or a wrong output."""
    for place in (run.folder, str(run.folder), run.folder / "tiny", run.folder / "tiny_p.hdf.series",
                  run.folder / "tiny_p.vtkhdf"):
        found = scree.open(place)
        assert (found.case, found.folder) == ("tiny", run.folder)
        assert len(found.snapshots) == len(run.snapshots) == 5
    fast = scree.open(run.folder / "tiny_fast_p.hdf.series")
    assert fast.case == "tiny" and len(fast.snapshots[-1]) == len(run.snapshots[-1]) // 2
    assert fast.history.equals(run.history)


def test_what_cannot_be_opened(run: scree.Run, tmp_path: Path) -> None:
    """Would catch a Python traceback in place of a message that lists the existing results."""
    with pytest.raises(scree.FileProblem, match="holds no results"):
        scree.open(tmp_path)
    with pytest.raises(scree.FileProblem, match="did you mean 'tiny'"):
        scree.open(run.folder / "tinny")
    with pytest.raises(scree.FileProblem, match="no such file"):
        scree.open(run.folder / "tiny_q.hdf.series")
    for case in ("one", "two"):
        shutil.copy(run.folder / "tiny.summary.json", tmp_path / f"{case}.summary.json")
    with pytest.raises(scree.FileProblem, match=r"several cases.*one.*two"):
        scree.open(tmp_path)
    assert scree.open(tmp_path / "two").case == "two"
    for name in ("one_two.summary.json", "one_two_p.hdf.series", "one_two_p_000000.hdf"):
        shutil.copy(run.folder / name.replace("one_two", "tiny"), tmp_path / name)
    (tmp_path / "one_two_p.hdf.series").write_text('{"file-series-version": "1.0", "files": [{"name": '
                                                   '"one_two_p_000000.hdf", "time": 0.0}]}', encoding="utf-8")
    longer = scree.open(tmp_path / "one_two_p.hdf.series")
    assert longer.case == "one_two" and len(longer.snapshots) == 1
    (tmp_path / "one.summary.json").write_text('{"half', encoding="utf-8")
    with pytest.raises(scree.FileProblem, match="cannot read"):
        _ = scree.open(tmp_path / "one").summary


def test_run_without_end(run: scree.Run, tmp_path: Path) -> None:
    """Would catch an error on reading results of a program that is still running: there is no summary yet."""
    for ending in ("_history.csv", "_gauge.csv", ".echo.nml"):
        shutil.copy(run.path(ending), tmp_path)
    found = scree.open(tmp_path)
    assert found.case == "tiny" and found.history.equals(run.history) and len(found.snapshots) == 0
    with pytest.raises(scree.FileProblem, match="no snapshots"):
        found.snapshots.near(0.0)


def test_history_is_in_si(run: scree.Run) -> None:
    """Would catch columns in the units of the files, which are mm, us and mg; the summary is in SI."""
    end = run.summary["ledger"]["end"]
    last = run.history.iloc[-1]
    for name in ("kinetic", "total", "momentum_x", "mass"):
        assert last[name] == pytest.approx(end[name], rel=1e-12, abs=1e-300)
    assert end["kinetic"] > 1.0 and last["time"] == pytest.approx(run.summary["time"])
    units = run.history.attrs["units"]
    assert (units["kinetic"], units["momentum_x"], units["time"], units["mass_error"]) == ("J", "kg m/s", "s", "1")
    assert not any("[" in name for name in run.history.columns)


def test_tables(run: scree.Run) -> None:
    """Would catch a table that is not listed, has the name of another one, or is not in the given unit."""
    assert set(run.tables) == {"history", "gauge", "forces", "fragments"}
    assert len(run.tables) == 4 and "gauge" in run.tables and "nothing" not in run.tables
    gauge = run.tables["gauge"]
    assert gauge["velocity_x"].iloc[0] == pytest.approx(1000.0) and gauge.attrs["units"]["velocity_x"] == "m/s"
    units = run.tables["forces"].attrs["units"]
    assert (units["zlo_force_z"], units["zlo_impulse_z"], units["zlo_work"]) == ("N", "N s", "J")
    with pytest.raises(KeyError, match="did you mean 'gauge'"):
        _ = run.tables["gage"]
    pieces = run.fragments
    assert pieces is not None and pieces["mass"].iloc[:2].sum() == pytest.approx(run.history["mass"].iloc[0])
    assert pieces.attrs["units"]["mass"] == "kg"


def test_no_fragments(bar: scree.Run) -> None:
    """Would catch an error where a run wrote no such table, and a history that does not exist in the results."""
    assert bar.fragments is None
    with pytest.raises(scree.FileProblem, match="kind = 'history'"):
        _ = bar.history


def test_deck(run: scree.Run) -> None:
    """Would catch a deck without defaults, without the repeated groups, or in the units of the input."""
    assert run.deck["grid"]["dx"] == pytest.approx(1e-3)
    assert [body["name"] for body in run.deck["body"]] == ["left", "right"]
    assert run.deck["time"]["cfl"] > 0.0


def test_log(run: scree.Run, bar: scree.Run) -> None:
    """Would catch warnings that are lost, and other lines of the log that count as warnings."""
    assert run.exit_code == 0 and "ended" in run.log
    assert all(warning in run.log for warning in run.warnings)
    assert len(run.warnings) == run.log.count("\nwarning: ") + run.log.startswith("warning: ")


def test_half_line(run: scree.Run, tmp_path: Path) -> None:
    """Would catch a table that cannot be read while its last line is being written."""
    text = run.path("_history.csv").read_text(encoding="utf-8")
    path = tmp_path / "tiny_history.csv"
    path.write_text(text[:-200], encoding="utf-8")
    table = scree.read_table(path)
    assert len(table) == len(run.history) - 1
    assert np.array_equal(table["kinetic"], run.history["kinetic"][:-1])


GAUGE_FIRST = """
&run  case = 'order'  dimension = '1d' /
&grid  lo = 0, 0, 0  hi = 1, 1, 1  dx = 0.1 /
&time  t_end = 1e-3 /
&material  name = 'm'  density = 1000  young = 1e6  poisson = 0 /
&region  name = 'r'  shape = 'box'  lo = 0.2, 0, 0  hi = 0.8, 1, 1 /
&body  name = 'b'  region = 'r'  material = 'm'  velocity = 1, 0, 0 /
&output  name = 'g'  kind = 'gauge'  gauge = 'mean'  bodies = 'b'  every = 1  fields = 'velocity' /
"""
HISTORY = "&output  name = 'h'  kind = 'history'  every = 1 /\n"


def test_gauge_before_history(tmp_path: Path) -> None:
    """Would catch a history that is chosen by the order of the tables in the deck: the gauge in its place, or in place
    of the error that a run has none. Summaries of older versions name all tables history_N."""
    found = scree.run(GAUGE_FIRST + HISTORY, outdir=tmp_path / "both", progress=False)
    assert found.summary["files"] == {"gauge_1": "order_gauge.csv", "history_1": "order_history.csv"}
    assert found.history["kinetic"].iloc[-1] == pytest.approx(0.5 * 600)
    assert "velocity_x" in found.tables["gauge"] and "velocity_x" not in found.history
    text = found.path(".summary.json").read_text(encoding="utf-8")
    older = text.replace('"history_1"', '"history_2"').replace('"gauge_1"', '"history_1"')
    assert older != text
    found.path(".summary.json").write_text(older, encoding="utf-8")
    assert "kinetic" in scree.open(tmp_path / "both").history
    alone = scree.run(GAUGE_FIRST, outdir=tmp_path / "alone", progress=False)
    assert alone.history_name is None
    with pytest.raises(scree.FileProblem, match=r"no history of 'order'; its tables are: gauge; add &output kind"):
        _ = alone.history
