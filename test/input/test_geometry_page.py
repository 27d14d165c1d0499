# SPDX-License-Identifier: BSD-3-Clause
# tiers: smoke
"""The pages "geometry step by step" and "calibrate a material" are run as written: their files are written, their
commands run, and the lines below a command are its output.

Would catch a deck or a command of a page that does not work, a slope that moves although its initial stress should keep
it in equilibrium, and constants or values of a law that differ from those that the page prints.
"""

import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import case

BLOCK = re.compile(r"```(\w+)\n(.*?)```", re.DOTALL)


def run_page(options, page):
    """Write and run the blocks of a page in their order; the folder, and the number of commands and output lines."""
    folder = options.work / Path(page).stem
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    environment = {**os.environ, **case.OPEN_MPI, "OMP_NUM_THREADS": "1", "PYTHONPATH": str(case.ROOT / "python/src")}
    typed, shown, said = 0, 0, ""
    for kind, text in BLOCK.findall((case.ROOT / f"doc/guide/{page}").read_text(encoding="utf-8")):
        if kind != "console":
            name = text.split("\n")[0].split()[1]
            assert name.split(".")[1] in ("nml", "py")
            (folder / name).write_text(text, encoding="utf-8")
            continue
        for line in text.splitlines():
            if not line.startswith("$ "):
                assert line in said.splitlines(), f"{page} shows\n{line}\nbut the command before it prints\n{said}"
                shown += 1
                continue
            words = line.removeprefix("$ ").split()
            words[0] = {"scree": str(options.scree), "python": sys.executable}[words[0]]
            if "--check" in words:
                words.append("--no-estimate")    # the page does not show the run time
            answer = subprocess.run(words, cwd=folder, env=environment, stdout=subprocess.PIPE,
                                    stderr=subprocess.STDOUT, text=True, timeout=200)
            said = answer.stdout
            assert answer.returncode == 0, f"{line}\n{said[-3000:]}"
            if "--check" in line and "grains" not in line:
                assert re.search(r"^mass +\S+ kg", said, re.M)
            typed += 1
    return folder, typed, shown


class TestPage:
    """The blocks of the pages in their order."""

    def test_calibration(self, options):
        _, typed, shown = run_page(options, "calibrate.md")
        assert typed >= 12
        assert shown >= 13

    def test_the_page(self, options):
        folder, typed, _ = run_page(options, "geometry.md")
        assert typed >= 10
        tools = case.post()
        first = tools.snapshot(str(folder / "out/slope/slope_p_000000.hdf"))
        last = tools.snapshot(str(folder / "out/slope/slope_p_000001.hdf"))
        assert abs(first.fields["mass"].sum() - last.fields["mass"].sum()) <= 0.5e-6
        assert abs(first.fields["volume"].sum() / 60 - 1) < 0.002
        # in free fall its speed would be 0.5 m/s
        assert abs(last.fields["velocity"][:, 2]).max() < 0.1
        grains = tools.snapshot(str(sorted((folder / "out/grains").glob("grains_p_*.hdf"))[0]))
        assert len(grains.points) == 200
