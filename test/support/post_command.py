# SPDX-License-Identifier: BSD-3-Clause
"""Run the command scree-post inside a test, and small runs of the program as its input.

    import post_command
    answer = post_command.call("info", path)     # answer.returncode, answer.stdout, answer.stderr

Starting Python for each call would take most of the time of the tests; that the command also starts by itself is tested
once.
"""

import contextlib
import io
import os
import shutil
import subprocess
import sys
from pathlib import Path
from types import SimpleNamespace

import case

PACKAGES = case.ROOT / "python/src"
INPUT = case.ROOT / "input"
# Small runs: options of the program by the name of the folder of their results.
RUNS = {
    "two_discs": ("two_discs/scene.nml", ("grid.dx=0.05", "output[discs].dt=0.5")),
    "coarse": ("two_discs/scene.nml", ("grid.dx=0.1",)),
    "debris_cloud": ("debris_cloud/scene.nml", ("grid.dx=0.775", "time.t_end=10.5",
                                                "output[cloud].dt=1.5")),
    "debris_cloud_3d": ("debris_cloud/quarter_3d.nml", (
        "grid.dx=1.55", "time.t_end=4", "body[sphere].velocity=0,0,3",
        "region[plate].hi=12.4,12.4,3.1")),
    "grain_cell": ("grain_cell/scene.nml", ("grains.number=64", *(
        f"stage[{name}].{key}" for name in ("middle_1", "middle_2", "slow_1", "reverse", "slow_2")
        for key in (f"inertial_number={-0.1 if name == 'reverse' else 0.1}", "strain=3")),
        "stage[fast_1].strain=3", "stage[fast_2].strain=3")),
}


def call(*words, folder="/"):
    """Exit code and output of scree-post, in this process, called from another folder."""
    from scree_post import command
    out, errors, here, saved = io.StringIO(), io.StringIO(), os.getcwd(), sys.argv
    sys.argv = ["scree-post", *map(str, words)]
    code = 0
    try:
        os.chdir(folder)
        with contextlib.redirect_stdout(out), contextlib.redirect_stderr(errors):
            command.run()
    except SystemExit as leave:
        code = leave.code
    finally:
        os.chdir(here)
        sys.argv = saved
    return SimpleNamespace(returncode=code, stdout=out.getvalue(), stderr=errors.getvalue())


def process(*words, folder="/"):
    """The same in a separate process and without a display."""
    environment = {key: value for key, value in os.environ.items() if key != "DISPLAY"}
    environment["PYTHONPATH"] = str(PACKAGES)
    return subprocess.run([sys.executable, "-m", "scree_post", *map(str, words)], cwd=folder,
                          env=environment, text=True, capture_output=True, check=False)


def run_cases(options, *names):
    """Run the named small cases into WORK/out/NAME; the result is the folder WORK."""
    for name in names:
        deck, settings = RUNS[name]
        folder = options.work / "out" / name
        shutil.rmtree(folder, ignore_errors=True)
        folder.parent.mkdir(parents=True, exist_ok=True)
        words = [options.scree, "--quiet", "--case", name, "--outdir", folder]
        for setting in settings:
            words += ["--set", setting]
        if "\n&grains" in (INPUT / deck).read_text(encoding="utf-8"):
            words.append("--grains")
        answer = subprocess.run([str(word) for word in [*words, INPUT / deck]],
                                capture_output=True, text=True,
                                env={**os.environ, **case.OPEN_MPI, "OMP_NUM_THREADS": "1"})
        if answer.returncode != 0:
            raise AssertionError(f"{name}: {answer.returncode} {answer.stdout}{answer.stderr}")
    return options.work


def series(work, name):
    """The series of a small case."""
    return str(Path(work) / "out" / name / f"{name}_p.hdf.series")
