# SPDX-License-Identifier: BSD-3-Clause
"""Runs that are killed, or whose disk fails, at a chosen call that changes files; and tables that a disk has lost.

A preloaded library (support/interpose.c) counts the calls and makes the fault. `test_kill` kills at chosen times.
"""
# tiers: smoke, full, long
# timeout: 300
# timeout long: 1800

import random
import shlex
import shutil
import subprocess

import pytest

import case
import faults
import tier

KILLS = tier.choose(smoke=6, full=6, long=200)
ERRORS = tier.choose(smoke=4, full=4, long=200)
TABLES = ("history", "all_history", "forces", "gauge", "profile")
SEED = 3


@pytest.fixture(scope="module")
def whole(file_options):
    """The undisturbed run: calls, number of ranks and files of it."""
    if not shutil.which("cc"):
        pytest.skip("there is no C compiler")
    tools = faults.Faults(file_options)
    run = faults.fresh(file_options, "whole", faults.deck())
    run.calls = tools.count(run, "-q")
    run.tools, run.files = tools, faults.tables(run)
    assert run.calls > 500
    assert all(run.files[f"fault_{name}.csv"].count(b"\n") > 4 for name in TABLES)
    return run


def go_on(run, tools, *words):
    """Restart a run that has ended early, or start it again if it has no checkpoint; the exit code."""
    if faults.has_checkpoint(run):
        return tools.run(run, 0, "-q", "--restart", *words)
    for path in run.folder.iterdir():
        if path != run.deck:
            path.unlink()
    return tools.run(run, 0, "-q", *words)


def test_kills(options, sheet, whole):
    """Would catch rows that are doubled or lost by a kill at any call, also in the restart, and in particular after the
    last checkpoint, when the last rows are written without being due."""
    chance = random.Random(SEED)
    for number in range(KILLS):
        run = faults.fresh(options, "killed", faults.deck())
        call = whole.calls - 1 - number * (whole.calls - 2) // (KILLS - 1)
        codes = [whole.tools.run(run, call, "-q", action=chance.choice(["kill", "tear"]))]
        if faults.has_checkpoint(run):
            codes.append(whole.tools.run(run, chance.randrange(1, 150), "-q", "--restart"))
        sheet.require(codes[0] == -9, f"call {call}: killed, not {codes}")
        sheet.require(go_on(run, whole.tools) == 0, f"call {call}: the restart ends: {run.output[-500:]}")
        differs = faults.different(faults.tables(run), whole.files)
        sheet.require(not differs, f"call {call}: other files than those of the whole run: {differs}")
        sheet.require("F126" not in run.output, f"call {call}: nothing is lost: {run.output[-500:]}")


@pytest.mark.parametrize("ranks", tier.choose(smoke=(1,), full=(1,), long=(1, 2)))
def test_errors_that_last(options, sheet, whole, ranks):
    """Would catch a crash of the HDF5 library in its end, an exit code 0 with files that are not whole, a checkpoint
    that is damaged by later errors, and on two ranks a hang: one rank leaves a collective write that fails, the other
    stays in it, so that each run takes half a minute."""
    if ranks > 1:
        case.need_ranks(options.scree)
    chance = random.Random(SEED)
    count = ERRORS if ranks == 1 else 12
    for number in range(count):
        run = faults.fresh(options, "full", faults.deck(), ranks=ranks)
        call = 40 + number * (whole.calls - 60) // (count - 1) + chance.randrange(-15, 15)
        action = chance.choice(["28", "5", "122"])           # ENOSPC, EIO, EDQUOT
        code = whole.tools.run(run, call, "-q", action=action, reserve=chance.random() < 0.3, timeout=80 * ranks - 40)
        said = [line for line in run.output.splitlines() if "cannot " in line]
        sheet.require(code == 3, f"call {call}, error {action}: exit code {code}: {run.output[-500:]}")
        sheet.require(len(said) > 0 and str(run.folder) in said[-1], f"call {call}: names the file: {said}")
        sheet.require(go_on(run, whole.tools) == 0, f"call {call}: a restart ends: {run.output[-500:]}")
        differs = faults.different(faults.tables(run), whole.files)
        sheet.require(not differs, f"call {call}: other files than those of the whole run: {differs}")


def test_lost_rows(options, sheet, whole):
    """Would catch a gap in a table without a word, a restart that a damaged table stops, and a reader that refuses
    it."""
    scree = pytest.importorskip("scree")
    stopped = faults.fresh(options, "stopped", faults.deck())
    whole.tools.run(stopped, whole.calls - 60, "-q")          # killed after its last checkpoint
    lines = {name: stopped.path(f"_{name}.csv").read_bytes().splitlines(keepends=True) for name in TABLES}
    damages = {
        "cut": lambda rows: b"".join(rows[:-3])[:-5],
        "zeroed": lambda rows: b"".join([*rows[:3], bytes(len(rows[3])), *rows[4:]]),
        "heading": lambda rows: bytes(20) + b"".join(rows)[20:],
        "emptied": lambda rows: b"",
        "missing": None,
        "digit": lambda rows: b"".join(rows[:-1]) + rows[-1].replace(b"1", b"2"),
        "windows": lambda rows: b"".join(rows).replace(b"\n", b"\r\n"),
    }
    for damage, change in damages.items():
        run = faults.fresh(options, "damaged", faults.deck())
        shutil.copytree(stopped.folder, run.folder, dirs_exist_ok=True)
        for name in TABLES:
            path = run.path(f"_{name}.csv")
            if change:
                path.write_bytes(change(lines[name]))
            else:
                path.unlink()
        sheet.require(whole.tools.run(run, 0, "-q", "--restart") == 0, f"{damage}: ends: {run.output[-500:]}")
        log = run.path(".log").read_text(encoding="utf-8")
        result = scree.open(run.folder)
        for name in TABLES:
            path, table = run.path(f"_{name}.csv"), result.tables[name]
            told = f"'{path}'" in run.output
            same = path.read_bytes() == whole.files[path.name]
            sheet.require(same == (damage in ("windows", "heading") or not told) or damage == "digit",
                          f"{damage}: {name}: rows are lost if and only if this is told: {told}")
            sheet.require(told or damage in ("digit",), f"{damage}: {name} is told")
            sheet.require((len(table) > 0 or damage in ("emptied", "missing"))
                          and bool(table["step"].is_monotonic_increasing), f"{damage}: {name} is read")
        sheet.require(log.count("F126") >= 2 and log.rindex("F126") > log.rindex("step"),
                      f"{damage}: told at the start and at the end")
        sheet.require(run.summary["digest"] == whole.files["digest"], f"{damage}: the state is that of the whole run")
        if damage in ("cut", "zeroed"):
            sheet.require("has lost" in run.output and " between time [s] = " in run.output,
                          f"{damage}: names the times")


def test_standard_output(options, sheet, whole):
    """Would catch a text that is lost with exit code 0, and a closed stream whose number a file of the run gets: what
    is printed would be written to it."""
    for words in (["--template"], ["--help"], ["--explain", "grid.dx"], ["--check", whole.deck],
                  ["--job", "slurm", whole.deck]):
        command = shlex.join(str(word) for word in (options.scree, *words))
        for stream in ("> /dev/full", ">&-"):
            answer = subprocess.run(f"{command} {stream}", shell=True, capture_output=True, text=True, check=False)
            sheet.require(answer.returncode == 3 and "cannot write 'standard output'" in answer.stderr,
                          f"{words[0]} {stream}: exit code {answer.returncode}: {answer.stderr}")
    run = faults.fresh(options, "closed", faults.deck())
    command = shlex.join(map(str, run.command()))
    answer = subprocess.run(f"{command} >&- 2>&- <&-", shell=True, env=run.environment, check=False, timeout=60)
    sheet.require(answer.returncode == 0, f"a run with closed streams: exit code {answer.returncode}")
    differs = faults.different(faults.tables(run), whole.files)
    sheet.require(not differs, f"a run with closed streams: other files: {differs}")


def test_deck_from_a_pipe(options, whole):
    """Would catch a deck that is taken to be empty because a pipe has no length."""
    answer = subprocess.run([options.scree, "--check", "--no-estimate", "/dev/stdin"], input=faults.deck(), text=True,
                            capture_output=True, check=False)
    assert answer.returncode == 0, answer.stderr
    assert "particles" in answer.stdout
