# SPDX-License-Identifier: BSD-3-Clause
# tiers: smoke, full
# timeout: 600
"""scree-post grains recovers the constants of synthetic runs within its own error bars, and refuses damaged runs.

Would catch: the start of a stage included in steady shear, a sign lost in reversed shear, error bars of correlated rows
that are too small, ages of contacts of an earlier stage included in those of a later one, a stress decay fitted by an
exponential to zero, means over intervals taken for instantaneous values, G of one component alone, and a &material
block that the program refuses or that does not give the fitted stress.
"""

import csv
import json
import os
import subprocess

import h5py
import numpy as np
import pytest

import case
import synthetic_cell as cell
from post_command import call
from scree_post.grains import material, memory, relaxation, rheology, statistics

BARS = 4.0               # greatest deviation of a value in error bars


def table(path):
    """Rows of a CSV file as dicts."""
    with open(path, newline="", encoding="utf-8") as handle:
        return list(csv.DictReader(handle))


def within(name, value, error, truth, widest):
    """A value agrees within its error bars, and the error bars are small enough to be useful."""
    assert 0.0 < error < widest * abs(truth), f"{name}: error bar {error:.3g} of {truth:.3g}"
    assert abs(value - truth) < BARS * error, f"{name}: {value:.5g} +- {error:.2g}, true {truth:.5g}"


def fitted(options, name="run", *words, **how):
    """A synthetic run and the results of the command."""
    folder = cell.write(options.work / name, **how)
    answer = call("grains", folder, *words)
    assert answer.returncode == 0 and not answer.stderr, answer.stderr
    return folder, answer.stdout


def test_constants(options):
    """A constant that differs from that of the run, or a useless error bar."""
    folder, said = fitted(options)
    numbers = json.loads((folder / f"{cell.CASE}_fit.json").read_text(encoding="utf-8"))
    for name, truth, widest in (("mu_s", cell.MU_S, 0.05), ("a", cell.A, 0.3), ("phi_c", cell.PHI_C, 0.01),
                                ("b", cell.B, 0.2)):
        within(name, *numbers["fits"][name], truth, widest)
    shear = {row["stage"]: row for row in table(folder / f"{cell.CASE}_shear.csv")}
    assert float(shear["reverse"]["mu"]) > 0.0 and "drift" in said
    found = table(folder / f"{cell.CASE}_tau.csv")
    truths = {"survival": (cell.AGE, 0.1), "correlation": (cell.CORRELATION, 0.5), "normal": (cell.W, 0.1),
              "reversal": (cell.RETURN, 0.5)}
    for row in found:
        if row["measure"] in truths:
            truth, widest = truths[row["measure"]]
            within(f"{row['measure']} of {row['stage']}", float(row["strain"]),
                   max(float(row["strain_error"]), 1.0e-3 * truth), truth, widest)
    count = {name: sum(row["measure"] == name for row in found) for name in (*truths, "hold")}
    assert count == {"survival": 4, "correlation": 4, "normal": 4, "reversal": 1, "hold": 1}, count
    (stop,) = (row for row in found if row["measure"] == "hold")
    within("tau of the stop", float(stop["tau [s]"]), float(stop["tau_error [s]"]), cell.HOLD_TAU, 0.1)
    assert abs(float(stop["beta"]) - cell.HOLD_BETA) < 0.1 and abs(float(stop["residual"]) - cell.HOLD_REST) < 0.02
    for row in (row for row in found if row["measure"] == "survival"):
        assert abs(float(row["beta"]) - 1.0) < 0.1, f"exponent {row['beta']} of an exponential"
    elastic = table(folder / f"{cell.CASE}_elastic.csv")
    for row, factor in zip(elastic, (1.0, 2.0)):
        assert abs(float(row["G [Pa]"]) / cell.SHEAR / factor - 1.0) < 1.0e-6, row
        assert abs(float(row["lambda [Pa]"]) / cell.LAME / factor - 1.0) < 1.0e-6, row
    for ending in ("rheology", "memory", "loop", "chains"):
        assert (folder / f"{cell.CASE}_{ending}.png").stat().st_size > 10000, ending


@pytest.mark.tiers("full", "long")
def test_error_bars(options):
    """Error bars of correlated rows that are too small or far too large: 60 runs, deviation over error bar."""
    generator = np.random.default_rng(3)
    off = []
    for _ in range(60):
        values = cell.noise(generator, 1000, 0.01)
        off.append(values.mean() / statistics.mean_error(values))
    size = float(np.sqrt(np.mean(np.square(off))))
    assert 0.5 < size < 1.4, f"deviations are {size:.2f} error bars"
    drifting = np.linspace(1.0, 1.5, 1000) + 0.05 * cell.noise(generator, 1000, 0.01)
    assert statistics.drifts(drifting) and not statistics.drifts(1.0 + 0.05 * cell.noise(generator, 1000, 0.01))


@pytest.mark.tiers("full", "long")
def test_curve(options):
    """Another function than mu_s + (mu_2 - mu_s)/(1 + I_0/I)."""
    x = np.array([0.003, 0.01, 0.03, 0.1, 0.3])
    y = 0.26 + 0.6 / (1.0 + 0.3 / x)
    found = rheology.curved(x, y, np.full(5, 1.0e-3))
    assert np.allclose(found, (0.26, 0.86, 0.3), rtol=1.0e-3), found


@pytest.mark.tiers("full", "long")
def test_laws_of_age(options):
    """An exponent that is not that of the ages, a time window that is ignored."""
    generator = np.random.default_rng(5)
    for beta in (0.6, 1.0, 1.6):
        # ages a of density exp(-a^beta): a^beta has the gamma distribution of 1/beta
        ages = 0.1 * generator.gamma(1.0 / beta, 1.0, 20000) ** (1.0 / beta)
        scale, found = memory.stretched_age(ages[ages < 0.5], 0.5)
        assert abs(found - beta) < 0.06 and abs(scale / 0.1 - 1.0) < 0.15, (beta, found, scale)
    for window in (0.1, 0.3, 1.0):
        assert abs(memory.exponential_age(memory.truncated_mean(0.1, window), window) / 0.1 - 1.0) < 1.0e-6


@pytest.mark.tiers("full", "long")
def test_block(options):
    """A block that no deck accepts, or whose stress is not that of the cell or of the analytical solution."""
    folder, _ = fitted(options, "block", "--stage", "slow")
    keys = json.loads((folder / f"{cell.CASE}_fit.json").read_text(encoding="utf-8"))["material"]
    text = (folder / f"{cell.CASE}_material.nml").read_text(encoding="utf-8")
    assert "! Stage slow: I = 0.01" in text and "reversal" not in text
    rate = cell.rate_of(0.01)
    deck = folder / "deck.nml"
    deck.write_text(
        "&run title = 'block' dimension = 'plane_strain' /\n&grid lo = 0,0,0 hi = 1,0.1,1 dx = 0.1 /\n"
        f"&time t_end = 0.02 /\n&include file = '{cell.CASE}_material.nml' /\n"
        "&region name = 'r' shape = 'box' lo = 0,0,0 hi = 0.5,0.1,0.5 /\n"
        f"&body name = 'b' region = 'r' material = '{material.name_of(cell.CASE)}' /\n"
        "&output name = 'h' kind = 'history' every = 10 /\n"
        f"&point path = 'shear' rate = {rate} strain = 2 steps = 40 /\n",
        encoding="utf-8")
    for words in (["--check"], ["--point", "--outdir", folder / "point"]):
        answer = subprocess.run([str(word) for word in (options.scree, *words, deck)], capture_output=True, text=True,
                                env={**os.environ, **case.OPEN_MPI, "OMP_NUM_THREADS": "1"}, check=False)
        assert answer.returncode == 0, answer.stdout + answer.stderr
        assert words[0] != "--check" or "0 errors, 0 warnings" in answer.stdout, answer.stdout
    (path,) = (folder / "point").glob("*_point.csv")
    rows = table(path)
    times = np.array([float(row["time"]) for row in rows])
    law = relaxation.follow(0.0, rate, times, keys["shear"], keys["gr_gamma_c"])
    shear = np.array([float(row["xy"]) for row in rows])
    assert np.abs(shear - law.imag).max() < 1.0e-4 * shear[-1], "the closed solution is not that of the program"
    (slow,) = (row for row in table(folder / f"{cell.CASE}_shear.csv") if row["stage"] == "slow")
    steady = float(slow["stress_xy [Pa]"])
    assert abs(shear[-1] / steady - 1.0) < 1.0e-4, f"{shear[-1]} Pa, cell {steady} Pa"
    answer = call("grains", folder, "--law", "mu_i", "--out", folder / "mu_i.nml")
    text = (folder / "mu_i.nml").read_text(encoding="utf-8")
    assert answer.returncode == 0 and "strength_model = 'mu_i'" in text and "grain_diameter = 0.001" in text, text
    deck.write_text(deck.read_text(encoding="utf-8").replace(f"{cell.CASE}_material", "mu_i"), encoding="utf-8")
    answer = subprocess.run([str(options.scree), "--check", str(deck)], capture_output=True, text=True,
                            env={**os.environ, **case.OPEN_MPI}, check=False)
    assert answer.returncode == 0, answer.stderr


@pytest.mark.tiers("full", "long")
def test_several_runs(options):
    """Two runs of one stage each that are not fitted together, or stages of the same name mixed up."""
    one, two = (cell.write(options.work / f"alone_{n}", n, (cell.STAGES[0], ("shear", inertial, 12.0, 1200)))
                for n, inertial in ((1, 0.02), (2, 0.1)))
    answer = call("grains", one, two)
    assert answer.returncode == 0 and "one inertial number" not in answer.stdout, answer.stderr
    numbers = json.loads((one / f"{cell.CASE}_fit.json").read_text(encoding="utf-8"))
    within("mu_s", *numbers["fits"]["mu_s"], cell.MU_S, 0.1)
    assert len(numbers["tau"]) == 6, len(numbers["tau"])
    assert "one inertial number" in call("grains", one).stdout
    summary = one / f"{cell.CASE}.summary.json"
    for text, reason in (('{"exit_code": 75, "reason": "signal USR1"}', "signal USR1"), (None, "no summary yet")):
        summary.unlink()
        if text:
            summary.write_text(text, encoding="utf-8")
        said = call("grains", one).stdout
        assert f"is not finished ({reason}" in said or f"is not finished (it has {reason}" in said, said


@pytest.mark.tiers("full", "long")
def test_unnamed_stages(options):
    """Stages without names that are treated as one."""
    folder, _ = fitted(options, "unnamed", stages=(cell.STAGES[0], ("stage", 0.1, 6.0, 600), ("stage", 0.05, 6.0, 600)))
    rows = table(folder / f"{cell.CASE}_shear.csv")
    assert [row["stage"] for row in rows] == ["stage 2", "stage 3"], rows
    assert "! Stage stage 3: I = 0.05" in (folder / f"{cell.CASE}_material.nml").read_text(encoding="utf-8")


def refused(code, folder, *parts, words=()):
    """One line on standard error, with an exit code and some words."""
    answer = call("grains", folder, *words)
    said = answer.stderr.strip().splitlines()
    assert answer.returncode == code, f"exit {answer.returncode}, wanted {code}: {said}"
    assert len(said) == 1 and all(part in said[0] for part in parts), f"{parts} not in {said}"


def test_refusals(options):
    """A traceback or a number for an incomplete run: no folder, an empty one, no shear, a missing column or file."""
    work = options.work
    refused(3, work / "absent", "no such folder", "scree --grains")
    (work / "empty").mkdir(exist_ok=True)
    refused(3, work / "empty", "no *_history.csv", "scree --grains DECK")
    folder = cell.write(work / "rest", stages=cell.STAGES[:1])
    refused(3, folder, "no stage has a shear rate", "inertial_number")
    folder = cell.write(work / "broken", snapshots=2)
    history = folder / f"{cell.CASE}_history.csv"
    good = history.read_text(encoding="utf-8")
    history.write_text(good.replace("stress_xy", "other"), encoding="utf-8")
    refused(3, folder, "not a history of scree --grains", "stress_xy")
    history.write_text(good.replace(",3\n", ",nan\n").replace(",-1000,", ",nan,"), encoding="utf-8")
    refused(3, folder, "column stress_", "is not finite")
    history.write_text(good.replace(",-1000,", ",0,"), encoding="utf-8")
    refused(3, folder, "has no stress", "compress the cell first")
    history.write_text(good, encoding="utf-8")
    refused(2, folder, "no shear stage 'slw'", "did you mean 'slow'", words=("--stage", "slw"))
    refused(2, folder, "no reversal was measured in stage 'fast'", words=("--stage", "fast", "--tau", "reversal"))
    refused(2, folder, "--skip -1", words=("--skip", "-1"))
    refused(3, folder, "no folder", words=("--out", folder / "none" / "x.nml"))
    contacts = sorted(folder.glob("*_contacts_*.hdf"))[1]
    with h5py.File(contacts, "r+") as handle:
        del handle["VTKHDF/CellData/age_strain"]
    refused(3, folder, "is not a file of contacts", "age_strain")
    for file in folder.glob("*contacts*"):
        file.unlink()
    refused(2, folder, "no survival was measured", "snapshots")
    (folder / f"{cell.CASE}.echo.nml").unlink()
    refused(3, folder, "no such file", "echo.nml")
