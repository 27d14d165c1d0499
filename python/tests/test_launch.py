# SPDX-License-Identifier: BSD-3-Clause
"""Running the program: options, errors, interrupts, progress and sweeps."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from conftest import DECK, LINE

import scree
from scree import launch, study


def fake(folder: Path, code: str) -> Path:
    """A program of a few lines of shell that replaces scree."""
    path = folder / "scree"
    path.write_text(f"#!/bin/sh\n{code}\n", encoding="utf-8")
    path.chmod(0o755)
    return path


def test_values_of_keys() -> None:
    """Would catch a value of Python that the deck reads as a different value."""
    assert launch.deck_value(True) == ".true." and launch.deck_value(np.bool_(False)) == ".false."
    assert launch.deck_value((0, 0, -1.5)) == launch.deck_value(np.array([0.0, 0.0, -1.5])).replace("0.0", "0")
    assert launch.deck_value(1e-30) == "1e-30" and launch.deck_value(np.float64(0.1)) == "0.1"
    assert launch.deck_value("apic") == "apic" and launch.deck_value(7) == "7"


def test_settings_reach_the_program(deck: Path, tmp_path: Path) -> None:
    """Would catch settings, names and folders that do not reach the program."""
    run = scree.run(deck, {"grid.dx": 1.5, "body[left].velocity": (0.25, 0, 0), "method.transfer": "flip",
                           "effects.gravity": False}, outdir=tmp_path / "here", case="other", progress=False)
    assert (run.folder, run.case) == (tmp_path / "here", "other")
    assert run.deck["grid"]["dx"] == pytest.approx(1.5e-3) and run.deck["method"]["transfer"] == "flip"
    assert run.deck["effects"]["gravity"] is False and run.deck["body"][0]["velocity"][0] == pytest.approx(250.0)


def test_default_folder(deck: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Would catch results that are searched in another folder than that of the program."""
    monkeypatch.chdir(tmp_path)
    run = scree.run(deck.name, progress=False)
    assert run.case == "tiny" and (tmp_path / "out/tiny/tiny.log").exists()
    monkeypatch.chdir("/")
    assert run.summary["exit_code"] == 0 and len(run.snapshots) == 5


def test_ranks_and_threads(run: scree.Run, tmp_path: Path) -> None:
    """Would catch ranks or threads that are not started; the result has the same bits for any number of them."""
    both = scree.run(DECK, outdir=tmp_path, ranks=2, threads=2, progress=False)
    assert (both.summary["ranks"], both.summary["threads"]) == (2, 2)
    assert both.summary["digest"] == run.summary["digest"]


def test_deck_error(deck: Path, tmp_path: Path) -> None:
    """Would catch an error of the deck without the message of the program."""
    with pytest.raises(scree.DeckError, match=r"unknown key 'dy'; did you mean 'dx'") as caught:
        scree.run(deck, {"grid.dy": 1}, outdir=tmp_path / "out", progress=False)
    assert caught.value.code == 2 and "grid" in caught.value.messages[0]
    assert isinstance(caught.value, scree.ScreeError) and not (tmp_path / "out").exists()


def test_file_problem(deck: Path, tmp_path: Path) -> None:
    """Would catch results that are overwritten without a message, and a hint that names options of the command line
    only."""
    with pytest.raises(scree.FileProblem, match="cannot read"):
        scree.run(tmp_path / "absent.nml", progress=False)
    first = scree.run(deck, outdir=tmp_path / "out", progress=False)
    with pytest.raises(scree.FileProblem, match="overwrite=True"):
        scree.run(deck, {"grid.dx": 1.5}, outdir=tmp_path / "out", progress=False)
    assert scree.open(first.folder).deck["grid"]["dx"] == pytest.approx(1e-3)
    second = scree.run(deck, {"grid.dx": 1.5}, outdir=tmp_path / "out", overwrite=True, progress=False)
    assert second.deck["grid"]["dx"] == pytest.approx(1.5e-3)


def test_physics_error(deck: Path, tmp_path: Path) -> None:
    """Would catch a failed run that counts as successful, or whose results cannot be found."""
    with pytest.raises(scree.PhysicsError, match="below dt_min") as caught:
        scree.run(deck, {"time.dt_min": 10.0}, outdir=tmp_path / "out", progress=False)
    assert caught.value.code == 4 and scree.open(caught.value.folder).exit_code == 4


def test_messages_with_ranks(deck: Path, tmp_path: Path) -> None:
    """Would catch messages of the program that are lost among those of mpiexec, and errors of mpiexec itself that are
    left out."""
    with pytest.raises(scree.DeckError) as caught:
        scree.run(deck, {"grid.dy": 1}, outdir=tmp_path / "out", ranks=2, progress=False)
    assert "unknown key 'dy'" in str(caught.value) and "mpiexec" not in str(caught.value)
    rule = 70 * "-"
    assert launch.without_mpiexec(["a", rule, "There are not enough slots", rule, "b", rule, "Primary job  terminated",
                                   rule]) == ["a", "There are not enough slots", "b"]
    assert launch.without_mpiexec(["a", rule, "cut"]) == ["a", "cut"]


@pytest.mark.parametrize(("code", "kind", "text"), [
    ("echo 'internal error: sum' >&2; exit 5", scree.InternalError, "internal error: sum"),
    ("exit 7", scree.InternalError, "exit code 7 and printed no reason"),
    ("kill -KILL $$", scree.InternalError, "signal 9"),
    ("echo 'stopped' >&2; exit 75", scree.Interrupted, "restart=True")])
def test_other_ends(tmp_path: Path, code: str, kind: type[scree.ScreeError], text: str) -> None:
    """Would catch a wrong exception or message for an exit code or signal."""
    with pytest.raises(kind, match=text):
        scree.run(tmp_path / "a.nml", program=fake(tmp_path, code), progress=False)


def test_no_program(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Would catch a program that is used although another one was named, and a wrong order of search."""
    with pytest.raises(scree.FileProblem, match="no program"):
        scree.run(tmp_path / "a.nml", program=tmp_path / "absent", progress=False)
    mine = fake(tmp_path, "exit 0")
    monkeypatch.setenv("SCREE", str(mine))
    assert scree.find_program() == str(mine)
    monkeypatch.delenv("SCREE")
    monkeypatch.setattr("scree.program.beside_package", lambda: [])
    monkeypatch.setenv("PATH", str(tmp_path))
    assert scree.find_program() == str(mine)
    monkeypatch.setenv("PATH", "/")
    with pytest.raises(scree.FileProblem, match="environment variable SCREE"):
        scree.find_program()


def test_much_output(tmp_path: Path) -> None:
    """Would catch a program that waits for ever because one of its two output streams is not read."""
    code = "i=0; while [ $i -lt 3000 ]; do echo 'a long line of the standard error stream of the program' >&2; " \
           "echo 'and a line of its standard output'; i=$((i+1)); done; exit 4"
    with pytest.raises(scree.PhysicsError) as caught:
        scree.run(tmp_path / "a.nml", program=fake(tmp_path, code), progress=False)
    assert len(caught.value.messages) == 3000


def test_nothing_computed(deck: Path, tmp_path: Path) -> None:
    """Would catch results for an option with which the program computes nothing."""
    with pytest.raises(scree.DeckError, match="usage: scree"):
        scree.run(deck, outdir=tmp_path, options=["--help"], progress=False)


def test_text_of_other_results(tmp_path: Path) -> None:
    """Would catch a deck that is replaced although results of the previous deck exist."""
    scree.run(LINE, outdir=tmp_path, progress=False)
    with pytest.raises(scree.FileProblem, match="overwrite=True"):
        scree.run(LINE.replace("-500", "-400"), outdir=tmp_path, progress=False)
    assert (tmp_path / "deck.nml").read_text(encoding="utf-8") == LINE
    with pytest.raises(scree.FileProblem, match="already"):
        scree.run(LINE, outdir=tmp_path, progress=False)
    run = scree.run(LINE.replace("-500", "-400"), outdir=tmp_path, overwrite=True, progress=False)
    assert run.deck["body"]["velocity"][0] == -400.0


def test_text_needs_a_folder() -> None:
    """Would catch the text of a deck that is written into the current folder of the user."""
    with pytest.raises(ValueError, match="outdir"):
        scree.run(DECK, progress=False)
    with pytest.raises(ValueError, match="at least 1"):
        scree.run(DECK, outdir="x", ranks=0, progress=False)


def test_wall_limit_and_restart(tmp_path: Path) -> None:
    """Would catch a restart that begins from the start, and a stopped run that counts as complete."""
    long = {"grid.dx": 0.1, "time.t_end": 500.0, "output[all].count": 1}
    with pytest.raises(scree.Interrupted, match="restart=True") as caught:
        scree.run(DECK, {**long, "time.wall_limit": "00:00:01"}, outdir=tmp_path, progress=False)
    assert "wall_limit reached" in str(caught.value)
    stopped = scree.open(caught.value.folder).summary
    assert stopped["exit_code"] == 75 and stopped["steps"] > 0
    rest = scree.run(DECK, {**long, "time.t_end": 1.05e6 * stopped["time"]}, outdir=tmp_path, restart=True,
                     progress=False)
    assert rest.exit_code == 0 and rest.summary["steps"] > stopped["steps"]
    assert rest.history["time"].is_monotonic_increasing and rest.history["time"].iloc[0] == 0.0


def interrupt(call: str, folders: list[Path]) -> None:
    """Interrupt a call in a separate Python process after its runs have begun; each run must write a checkpoint."""
    # a shell starts background processes with this signal ignored
    code = "import signal; signal.signal(signal.SIGINT, signal.default_int_handler); import scree; long = " \
        f"{{'grid.dx': 0.1, 'time.t_end': 5000.0, 'time.wall_limit': '00:02:00', 'output[all].count': 1}}; {call}"
    # without the environment variables that MPI sets when it is started in this process, which Python does not see
    child = subprocess.Popen([sys.executable, "-c", code], stderr=subprocess.PIPE, text=True, env={**os.environ})
    end = time.monotonic() + 60.0
    while not all((folder / "tiny_p_000000.hdf").exists() for folder in folders):
        assert child.poll() is None and time.monotonic() < end, "the runs do not begin"
        time.sleep(0.05)
    time.sleep(0.3)
    child.send_signal(signal.SIGINT)
    try:
        _, said = child.communicate(timeout=60)
    finally:
        child.kill()
    assert "KeyboardInterrupt" in said and child.returncode != 0
    for folder in folders:
        assert scree.open(folder).exit_code == 75 and list(folder.glob("tiny_chk_*.h5"))


def test_interrupt_of_the_keyboard(deck: Path, tmp_path: Path) -> None:
    """Would catch an interrupt that leaves the program running, or without a checkpoint."""
    interrupt(f"scree.run({str(deck)!r}, {{**long}}, outdir={str(tmp_path / 'out')!r})", [tmp_path / "out"])
    interrupt(f"scree.run({str(deck)!r}, {{**long}}, outdir={str(tmp_path / 'two')!r}, ranks=2)", [tmp_path / "two"])


def test_interrupt_of_a_sweep(deck: Path, tmp_path: Path) -> None:
    """Would catch an interrupt that waits for the end of all runs, or after which waiting runs start."""
    interrupt(f"scree.sweep({str(deck)!r}, 'time.cfl', [0.3, 0.2, 0.1], lambda run: 0.0, jobs=2, set=long, "
              f"outdir={str(tmp_path / 'out')!r})", [tmp_path / "out/cfl_0.3", tmp_path / "out/cfl_0.2"])
    assert not (tmp_path / "out/cfl_0.1").exists()


def test_progress(deck: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch,
                  capfd: pytest.CaptureFixture[str]) -> None:
    """Would catch a progress bar that does not evaluate the lines of the program, or that is drawn without a
    terminal."""
    shares: list[str] = []
    line = launch.Progress.line

    def noted(self: launch.Progress, text: str) -> None:
        found = launch.SHARE.match(text)
        if found:
            shares.append(found.group(1))
        line(self, text)

    monkeypatch.setattr(launch.Progress, "line", noted)
    fast = {"log.progress_seconds": 0.01, "grid.dx": 0.25}
    scree.run(deck, fast, outdir=tmp_path / "a")
    assert len(shares) > 2 and "%" not in capfd.readouterr().err
    assert [float(share) for share in shares] == sorted(float(share) for share in shares)
    monkeypatch.setattr(launch, "bar_is_seen", lambda: True)
    scree.run(deck, fast, outdir=tmp_path / "b")
    said = capfd.readouterr().err
    assert "100 %" in said and "step" in said
    scree.run(deck, fast, outdir=tmp_path / "c", progress=False)
    assert "%" not in capfd.readouterr().err


def test_sweep(tmp_path: Path) -> None:
    """Would catch rows in the order in which runs end, a value that is not set, and numbers of another run."""
    speeds = [-800.0, -200.0, -500.0]

    def measured(run: scree.Run) -> dict[str, float]:
        behind = run.snapshots[-1].along((1e-3, 0, 0), (3e-3, 0, 0), "pressure")
        return {"speed": run.snapshots[0]["velocity_x"].min(), "pressure": behind["pressure"].mean()}

    table = scree.sweep(LINE, "body[bar].velocity", [(speed, 0, 0) for speed in speeds], measured, jobs=2,
                        set={"grid.dx": 0.25e-3}, outdir=tmp_path, progress=False)
    assert list(table.columns) == ["body[bar].velocity", "speed", "pressure", "folder", "error"]
    assert table["speed"].to_list() == speeds and (table["error"] == "").all()
    jumps = [8930 * speed * (3940 + 1.49 * speed) for speed in (800, 200, 500)]
    assert table["pressure"].to_list() == pytest.approx(jumps, rel=0.05)
    assert table["folder"].nunique() == 3


def test_sweep_resumes(tmp_path: Path) -> None:
    """Would catch completed runs that are repeated, combinations that are lost, and results of other settings that are
    used for this study."""
    keys = {"grid.dx": [1e-3, 2e-3], "time.cfl": [0.3, 0.2]}

    def study(**options: Any) -> dict[tuple[float, float], float]:
        table = scree.sweep(LINE, keys, measure=lambda run: run.summary["steps"], outdir=tmp_path, progress=False,
                            **options)
        return {(row["grid.dx"], row["time.cfl"]): row["value"] for _, row in table.iterrows()}

    first = study(resume=True)
    assert len(first) == 4 and first[1e-3, 0.2] > first[1e-3, 0.3] > first[2e-3, 0.3]
    summaries = sorted(tmp_path.glob("*/*.summary.json"))
    made = [path.stat().st_mtime_ns for path in summaries]
    summaries[0].write_text(summaries[0].read_text(encoding="utf-8").replace('"exit_code": 0', '"exit_code": 4'),
                            encoding="utf-8")
    assert study(resume=True) == first
    kept = [path.stat().st_mtime_ns for path in summaries]
    assert len(made) == 4 and kept[0] != made[0] and kept[1:] == made[1:]
    with pytest.raises(scree.FileProblem, match="of other values"):
        study(resume=True, set={"time.t_end": 2e-6})
    assert study(resume=True, overwrite=True, set={"time.t_end": 2e-6})[1e-3, 0.3] > first[1e-3, 0.3]
    with pytest.raises(ValueError, match="mapping"):
        scree.sweep(LINE, "grid.dx")


def test_sweep_with_failures(tmp_path: Path) -> None:
    """Would catch a sweep that loses its results because one run failed, and one that hides an invalid key."""
    table = scree.sweep(LINE, "time.dt_min", [1e-12, 1.0], lambda run: run.summary["steps"], outdir=tmp_path,
                        progress=False)
    assert table["value"].iloc[0] > 0 and np.isnan(table["value"].iloc[1])
    assert table["error"].iloc[0] == "" and "below dt_min" in table["error"].iloc[1]
    with pytest.raises(scree.DeckError, match="unknown key"):
        scree.sweep(LINE, "time.dt_mni", [1.0, 2.0], lambda run: 0.0, outdir=tmp_path, progress=False)
    with pytest.raises(ValueError, match="equal"):
        scree.sweep(LINE, "grid.dx", [1e-3, 1e-3], lambda run: 0.0, outdir=tmp_path, progress=False)
    with pytest.raises(scree.FileProblem, match="already"):
        scree.sweep(LINE, "time.dt_min", [1e-12], lambda run: 0.0, outdir=tmp_path, progress=False)
    assert study.folder_name({"body[bar].velocity": (-1.5, 0, 0)}) == "velocity_-1.5_0_0"
