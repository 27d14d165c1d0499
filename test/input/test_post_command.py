# SPDX-License-Identifier: BSD-3-Clause
# tiers: smoke, full
# timeout: 600
"""Tests of scree-post on small runs: info, plot, compare, sweep, and messages about mistakes.

The first line of each test states which bug it would catch.
"""

import contextlib
import csv
import re
import shutil
import sys
from pathlib import Path

import h5py
import numpy as np
import pytest

import case
import report
import scree_post
import tier
from post_command import INPUT, PACKAGES, call, process, run_cases, series
from scree_post import fragment_table, progress

DISCS = INPUT / "two_discs" / "scene.nml"


@pytest.fixture(scope="module")
def options(file_options):
    """Small runs in a folder that all tests use."""
    run_cases(file_options, *tier.choose(("two_discs", "coarse", "debris_cloud"), smoke=("two_discs", "coarse")))
    return file_options


def good(answer):
    """Output of a call that must succeed without a warning."""
    assert answer.returncode == 0 and not answer.stderr, f"{answer.returncode} {answer.stderr}"
    return answer.stdout


def refused(answer, code, *parts):
    """A call that must end with one line on standard error that contains some words."""
    said = answer.stderr.strip().splitlines()
    assert answer.returncode == code, f"exit {answer.returncode}, wanted {code}: {said}"
    assert len(said) == 1, f"{len(said)} lines: {said}"
    assert all(part in said[0] for part in parts), f"{parts} not in: {said[0]}"


@pytest.mark.tiers("full", "long")
def test_info(options):
    """Ranges of another snapshot, masses of bodies exchanged, an unknown kind of file."""
    folder = options.work / "out" / "debris_cloud"
    text = good(call("info", folder))
    snap = scree_post.snapshot(scree_post.series(series(options.work, "debris_cloud"))[-1][1])
    heavy = snap.fields["mass"][snap.fields["body"] == 2].sum(dtype="f8")
    line = next(line for line in text.splitlines() if line.startswith("sheet "))
    assert abs(float(line.split()[2]) / heavy - 1.0) < 1.0e-5, line
    line = next(line for line in text.splitlines() if line.startswith("temperature "))
    assert float(line.split()[4]) == float(f"{snap.fields['temperature'].max():.5g}"), line
    assert "dimension    axisymmetric" in text and "symmetry     xlo" in text
    assert "history of" in text and "always zero: " in text and "debris_cloud_chk_0001.h5" in text
    early = good(call("info", series(options.work, "debris_cloud"), "--time", "3us"))
    assert "time         3.0" in early, early
    every = good(call("info", series(options.work, "debris_cloud"), "--all"))
    found = [float(re.search(r"^temperature .*", words, re.M).group().split()[4])
             for words in (early, every, text)]
    assert found[1] >= max(found[0], found[2]), f"ranges over all times: {found}"
    kept = good(call("info", folder / "debris_cloud_chk_0001.h5"))
    for body, material in ((1, "al_2017"), (2, "al_6061")):
        count = (snap.fields["body"] == body).sum()
        assert f"material {material}: {count} particles" in kept and "1/s" in kept, kept


def test_deck(options):
    """A deck that is not the one of the run, or a file that is not a deck."""
    for name in ("coarse_p_000002.hdf", "coarse_p.hdf.series", "coarse_chk_0001.h5"):
        text = good(call("info", options.work / "out" / "coarse" / name, "--deck"))
        assert text.rstrip("\n") == DISCS.read_text(encoding="utf-8").rstrip("\n"), name
    refused(call("info", options.work / "out" / "coarse" / "coarse_history.csv", "--deck"), 2,
            "a history contains no deck")


@pytest.mark.tiers("full", "long")
def test_grids(options):
    """A folder with fields on the grid, slices and fragments whose kinds are not recognised."""
    deck = DISCS.read_text(encoding="utf-8") + "".join(
        f"&output\n  name = '{name}'  kind = '{name}'  dt = 3  {more}\n/\n" for name, more in (
            ("grid", "fields = 'density', 'velocity'"), ("slice", "axis = 'x'  at = -0.3"),
            ("fragments", "")))
    box = case.Case(options, "kinds", deck).run("--quiet", "--set", "grid.dx=0.1")
    text = good(call("info", box.folder))
    assert "kinds_g.hdf.series: 3 grids" in text and "kinds_s.hdf.series: 3 snapshots" in text
    with h5py.File(box.path("_g_000002.hdf")) as handle:
        greatest = handle["VTKHDF/PointData/density"][...].max()
    row = next(line.split() for line in text.splitlines() if line.startswith("density "))
    assert row[1:3] == ["kg/m3", "1"] and float(row[4]) == float(f"{greatest:.5g}"), row
    table = scree_post.history(str(box.path("_fragments.csv")))
    found = fragment_table.fragments_of(box.snapshots()[-1][1], cell=0.1)
    last = table["time"] == table["time"][-1]
    assert abs(np.sort(table["mass"][last]) - np.sort(found.masses)).max() < 1.0e-6 * 130.0
    assert set(title.split(" [")[0] for title in fragment_table.COLUMNS) <= {
        *table.order, "size", "body", "temperature", *(f"{name}_{axis}" for name in ("spin", "long", "short", "axis")
                                                       for axis in "xyz123")}, "other names of columns than the program"
    refused(call("info", box.path("_g_000001.hdf.serie")), 3, "no such file")


def lines_drawn(function, *words):
    """The figure that a call of plot saves."""
    from scree.drawing import look
    kept, saved = [], look.save
    look.save = lambda figure, path, dpi: kept.append(figure) or saved(figure, path, dpi)
    try:
        text = good(function(*words))
    finally:
        look.save = saved
    return kept[0], text


def test_plot(options):
    """Another column than the requested one, a unit lost, histories mixed up, a zero on a logarithmic axis."""
    work = options.work
    figure, text = lines_drawn(call, "plot", work / "out" / "two_discs", "--y",
                               "kinetic,internal,momentum_error", "--out", work / "y.png")
    table = scree_post.history(str(work / "out" / "two_discs" / "two_discs_history.csv"))
    upper, lower = figure.axes
    assert upper.get_ylabel() == "energy [J]", upper.get_ylabel()
    assert lower.get_ylabel().startswith("momentum error [10"), lower.get_ylabel()
    assert lower.get_xlabel() == "time [s]"
    for line, name in zip(upper.lines, ("kinetic", "internal")):
        assert line.get_label() == name
        assert np.array_equal(line.get_ydata(), table[name]), name
        assert np.array_equal(line.get_xdata(), table["time"])
    worst = abs(table["energy_error"]).max()
    assert f"largest relative error of total energy: {worst:.2e}" in text, text
    figure, _ = lines_drawn(call, "plot", work / "out" / "two_discs", work / "out" / "coarse",
                            "--y", "energy_error", "--x", "step", "--log", "--out", work / "e.png")
    (axes,) = figure.axes
    assert axes.get_yscale() == "log" and len(axes.lines) == 2
    assert axes.get_ylabel() == "size of energy error" and axes.get_xlabel() == "step"
    assert [line.get_label() for line in axes.lines] == ["two_discs: energy error",
                                                         "coarse: energy error"]
    shown = axes.lines[0].get_ydata()
    assert np.nanmin(shown) > 0.0 and np.isnan(shown[0]), "a zero stands on the log axis"
    assert len({line.get_color() for line in axes.lines}) == 2


@pytest.mark.tiers("full", "long")
def test_compare(options):
    """Differences that are missed or wrong: a run equals itself, and one number differs by a known amount."""
    work = options.work
    one = work / "out" / "coarse"
    other = work / "out" / "changed"
    shutil.rmtree(other, ignore_errors=True)
    shutil.copytree(one, other)
    assert "the same within 0" in good(call("compare", one, other))
    frames = scree_post.series(str(other))
    with h5py.File(frames[3][1], "r+") as handle:
        values = handle["VTKHDF/PointData/pressure"]
        order = np.arange(len(values))[::-1]             # the order of particles must have no effect
        for name in handle["VTKHDF/PointData"]:
            data = handle["VTKHDF/PointData"][name]
            data[...] = data[...][order]
        points = handle["VTKHDF/Points"]
        points[...] = points[...][order]
        values[5] += 40.0
    answer = call("compare", one, other)
    assert answer.returncode == 1 and not answer.stderr, answer.stderr
    rows = {line.split()[0]: line.split() for line in answer.stdout.splitlines() if line}
    scale = max(abs(scree_post.snapshot(file).fields["pressure"]).max()
                for _, file in scree_post.series(str(one)))
    assert abs(float(rows["pressure"][2]) - 40.0) < 1.0e-3, rows["pressure"]
    assert abs(float(rows["pressure"][3]) * scale / 40.0 - 1.0) < 1.0e-3, rows["pressure"]
    count = len(frames) * len(order)
    assert abs(float(rows["pressure"][4]) * count ** 0.5 / 40.0 - 1.0) < 1.0e-3, rows["pressure"]
    assert float(rows["pressure"][-1]) == float(f"{frames[3][0]:.6g}"), "time of the difference"
    assert float(rows["velocity"][2]) == 0.0 and float(rows["position"][2]) == 0.0
    assert call("compare", one, other, "--fields", "velocity,position").returncode == 0
    assert call("compare", one, other, "--tolerance", 1.01 * 40.0 / scale).returncode == 0
    assert call("compare", one, other, "--tolerance", 0.99 * 40.0 / scale).returncode == 1
    with h5py.File(frames[3][1], "r+") as handle:
        handle["VTKHDF/PointData/identity"][7] = 1000000
        handle["VTKHDF/PointData/mass"][0] = np.nan
    text = call("compare", one, other).stdout
    assert "1 particles" in text and "in A only" in text and "in B only" in text, text
    assert re.search(r"^mass .* inf ", text, re.M), "a number against not-a-number is a difference"


@pytest.mark.tiers("full", "long")
def test_compare_histories(options):
    """Rows of different times compared with each other, a tolerance ignored."""
    names = ("two_discs", "coarse")
    one, two = (options.work / "out" / name / f"{name}_history.csv" for name in names)
    assert "the same within 0" in good(call("compare", one, one))
    refused(call("compare", one, two), 2, "--interpolate")
    answer = call("compare", one, two, "--interpolate", "--fields", "kinetic")
    assert answer.returncode == 1
    a, b = scree_post.history(str(one)), scree_post.history(str(two))
    off = abs(np.interp(a["time"], b["time"], b["kinetic"]) - a["kinetic"]).max()
    row = next(line.split() for line in answer.stdout.splitlines() if line.startswith("kinetic"))
    assert abs(float(row[2]) / off - 1.0) < 1.0e-4, f"{row} {off}"
    refused(call("compare", one, options.work / "out" / "coarse"), 2, "only be compared with a")


def sweep(options, *words):
    """Call sweep on the discs."""
    return call("sweep", DISCS, "--scree", options.scree, "--outdir", options.work / "sweep",
                "--threads", "1", "--set", "grid.dx=0.1,0.2", *words)


@pytest.mark.tiers("full", "long")
def test_sweep(options):
    """Values of one run shown for another, a failure that is not reported, a study that starts again, rows that are
    lost."""
    shutil.rmtree(options.work / "sweep", ignore_errors=True)
    words = ("--set", "material.poisson=0.2,0.7,0.3", "--take", "steps,kinetic,kinetic.min",
             "--jobs", "2")
    assert len(good(sweep(options, *words, "--list")).splitlines()) == 6
    assert not (options.work / "sweep").exists(), "--list must make nothing"
    answer = sweep(options, *words)
    assert answer.returncode == 1 and not answer.stderr, answer.stdout + answer.stderr
    assert "4 of 6 runs finished" in answer.stdout and answer.stdout.count("FAILED") == 2
    with open(options.work / "sweep" / "sweep.csv", newline="", encoding="utf-8") as handle:
        rows = list(csv.DictReader(handle))
    assert [(row["grid.dx"], row["material.poisson"]) for row in rows] == [
        (dx, nu) for dx in ("0.1", "0.2") for nu in ("0.2", "0.7", "0.3")]
    for row in rows:
        if row["material.poisson"] == "0.7":
            assert row["exit_code"] == "2" and "poisson = 0.7" in row["reason"], row
            assert row["kinetic [J]"] == ""
            continue
        (path,) = Path(row["folder"]).glob("*_history.csv")
        table = scree_post.history(str(path))
        assert int(row["steps"]) == table["step"][-1]
        assert float(row["kinetic [J]"]) == float(f"{table['kinetic'][-1]:.9g}")
        assert float(row["kinetic.min [J]"]) == float(f"{table['kinetic'].min():.9g}")
    assert len({row["steps"] for row in rows}) == 5, "runs do not differ"
    stamps = {path: path.stat().st_mtime_ns for path in
              (options.work / "sweep").glob("*/*.summary.json")}
    again = sweep(options, *words)
    assert again.stdout.count("there ") == 4 and again.stdout.count("FAILED") == 2, again.stdout
    assert stamps == {path: path.stat().st_mtime_ns for path in stamps}, "a run was made again"
    more = sweep(options, "--set", "material.poisson=0.25", "--take", "steps,kinetic")
    assert "with 4 runs of earlier sweeps" in more.stdout and "2 earlier runs" in more.stdout, more.stdout
    with open(options.work / "sweep" / "sweep.csv", newline="", encoding="utf-8") as handle:
        kept = {(row["grid.dx"], row["material.poisson"]): row["kinetic [J]"] for row in csv.DictReader(handle)}
    assert set(kept) == {(dx, nu) for dx in ("0.1", "0.2") for nu in ("0.2", "0.25", "0.3")}, kept
    assert all(kept[row["grid.dx"], row["material.poisson"]] == row["kinetic [J]"] for row in rows
               if row["exit_code"] == "0"), "rows of earlier sweeps have changed"
    first = Path(rows[0]["folder"])
    text = (first / "sweep.json").read_text(encoding="utf-8")
    (first / "sweep.json").write_text(text.replace('"deck": "', '"deck": "0'), encoding="utf-8")
    refused(sweep(options, *words), 3, "results of another deck", "--overwrite")
    assert stamps == {path: path.stat().st_mtime_ns for path in stamps}, "results of another deck are replaced"
    assert sweep(options, *words, "--overwrite").stdout.count("done ") == 1, "another deck, and not run again"


@pytest.mark.tiers("full", "long")
def test_sweep_restart(options):
    """A run that was stopped with a checkpoint starts from the beginning, or is taken for finished."""
    folder = options.work / "stopped"
    shutil.rmtree(folder, ignore_errors=True)
    words = ("sweep", DISCS, "--scree", options.scree, "--outdir", folder, "--threads", "1",
             "--set", "grid.dx=0.1", "--set", "time.max_steps=40")
    good(call(*words))
    (run,) = (path for path in folder.iterdir() if path.is_dir())
    (summary,) = run.glob("*.summary.json")
    text = summary.read_text(encoding="utf-8")
    summary.write_text(text.replace('"exit_code": 0', '"exit_code": 75'), encoding="utf-8")
    assert "done " in good(call(*words))
    (log,) = run.glob("*.log")
    assert "restart" in log.read_text(encoding="utf-8").lower(), "the run did not go on"


@pytest.mark.tiers("full", "long")
def test_mistakes(options):
    """A traceback instead of a message, no suggestion, a wrong exit code, files left behind."""
    work, discs = options.work, series(options.work, "two_discs")
    shutil.rmtree(work / "wrong", ignore_errors=True)
    table = discs.replace("_p.hdf.series", "_history.csv")
    cases = [
        (("inof", discs), 2, "no command 'inof'", "did you mean 'info'"),
        ((), 2, "scree-post --help"),
        (("info",), 2, "FILE"),
        (("info", discs.replace("series", "serie")), 3, "no such file", "did you mean"),
        (("info", INPUT), 3, "no series"),
        (("info", __file__), 3, "cannot open"),
        (("plot", table, "--y", "kinetik"), 2, "'kinetik'", "did you mean 'kinetic'"),
        (("plot", table, "--y", "kinetic", "--x", "tme"), 2, "did you mean 'time'"),
        (("plot", table, table), 2, "--y"),
        (("plot", table, "--y", "lost_mass", "--log"), 2, "zero"),
        (("plot", table, "--lgo"), 2, "did you mean '--log'"),
        (("plot", table, "--out", work / "none" / "a.png"), 3, "no folder"),
        (("compare", discs, discs, "--fields", "presure"), 2, "did you mean 'pressure'"),
        (("compare", discs, discs, "--tolerance", "-1"), 2, "below 0"),
        (("compare", discs, table), 2, "history"),
        (("sweep", DISCS, "--set", "dx=1"), 2, "GROUP.KEY"),
        (("sweep", DISCS, "--set", "grid.dx="), 2, "no value"),
        (("sweep", DISCS, "--set", "grid.dx=1,1"), 2, "twice"),
        (("sweep", DISCS, "--set", "grid.dx=1", "--set", "grid.dx=2"), 2, "given twice"),
        (("sweep", DISCS, "--set", "grid.dx=1", "--take", "kinetic.maks"), 2, "did you mean 'kinetic'?"),
        (("sweep", DISCS, "--set", "grid.dx=1", "--scree", "/none"), 3, "no program"),
        (("sweep", "none.nml", "--set", "grid.dx=1"), 3, "no such file"),
        (("sweep", DISCS, "--set", "grid.dx=0.2", "--take", "kinetik", "--scree", options.scree,
          "--outdir", work / "wrong"), 2, "did you mean 'kinetic'"),
        (("check", discs, "--verbos"), 2, "did you mean '--verbose'")]
    for words, code, *parts in cases:
        refused(call(*words), code, *parts)
    mine = work / "not_mine" / "dx_0.2"
    mine.mkdir(parents=True, exist_ok=True)
    (mine / "letter").write_text("keep me", encoding="ascii")
    refused(call("sweep", DISCS, "--set", "grid.dx=0.2", "--scree", options.scree, "--outdir",
                 mine.parent), 3, "not made by a sweep")
    assert (mine / "letter").exists(), "a folder of somebody else was removed"


def test_command(options):
    """A command that does not start by itself, help that omits a command, another version."""
    answer = process("--help")
    assert answer.returncode == 0 and not answer.stderr, answer.stderr
    from scree_post.commands import COMMANDS
    there = {path.stem for path in (PACKAGES / "scree_post" / "commands").glob("[a-z]*.py")}
    assert there == set(COMMANDS), "a module without a word in the list, or the reverse"
    for name in COMMANDS:
        assert re.search(rf"^  {name} +\w", answer.stdout, re.M), f"{name} is not in the help"
        text = good(call(name, "--help"))
        assert text.startswith(f"usage: scree-post {name}") and "\nexamples:\n  scree-post " in text
        assert max(len(line) for line in text.splitlines()) <= 100, f"wide help of {name}"
    version = re.search(r"scree VERSION (\S+)", (case.ROOT / "CMakeLists.txt").read_text()).group(1)
    assert good(call("--version")) == f"scree-post {version}\n"
    installed = Path(sys.executable).parent / "scree-post"
    if installed.exists():
        import subprocess
        answer = subprocess.run([installed, "--version"], cwd="/", capture_output=True, text=True)
        assert answer.stdout == f"scree-post {version}\n", answer.stderr
    else:
        report.skipped("scree-post by its name", "scripts/setup.sh has not installed it beside this Python")


def test_progress():
    """A progress bar in a pipe or a file, and one that is not removed."""
    class Screen:
        """A terminal that stores what is written to it."""

        def __init__(self, loud):
            self.text, self.loud = "", loud

        def isatty(self):
            return self.loud

        def write(self, text):
            self.text += text

        def flush(self):
            pass

    pipe, screen = Screen(False), Screen(True)
    for stream in (pipe, screen):
        with contextlib.redirect_stderr(stream), progress.Progress(4, "drawing") as bar:
            for _ in range(4):
                bar.step()
    assert pipe.text == "", f"words in a pipe: {pipe.text!r}"
    assert "drawing" in screen.text and "0/4" in screen.text
    assert not screen.text.split("\r")[-1].strip(), "the bar is still there"
