# SPDX-License-Identifier: BSD-3-Clause
# tiers: smoke
"""The page "geometry step by step" is run as written: its files are written and its commands run.

Would catch a deck or a command of the page that does not work, and a slope that moves although its initial stress
should keep it in equilibrium.
"""

import os
import re
import shutil
import subprocess
import sys

import case

PAGE = case.ROOT / "doc/guide/geometry.md"
BLOCK = re.compile(r"```(\w+)\n(.*?)```", re.DOTALL)


class TestPage:
    """The blocks of the page in their order."""

    def test_the_page(self, options):
        folder = options.work / "geometry"
        shutil.rmtree(folder, ignore_errors=True)
        folder.mkdir(parents=True)
        environment = {**os.environ, **case.OPEN_MPI, "OMP_NUM_THREADS": "1"}
        typed = 0
        for kind, text in BLOCK.findall(PAGE.read_text(encoding="utf-8")):
            if kind != "console":
                name = text.split("\n")[0].split()[1]
                assert name.split(".")[1] in ("nml", "py")
                (folder / name).write_text(text, encoding="utf-8")
                continue
            for line in text.splitlines():
                words = line.removeprefix("$ ").split()
                words[0] = {"scree": str(options.scree), "python": sys.executable}[words[0]]
                if "--check" in words:
                    words.append("--no-estimate")    # the page does not show the run time
                answer = subprocess.run(words, cwd=folder, env=environment, stdout=subprocess.PIPE,
                                        stderr=subprocess.STDOUT, text=True, timeout=200)
                assert answer.returncode == 0, f"{line}\n{answer.stdout[-3000:]}"
                if "--check" in line and "grains" not in line:
                    assert re.search(r"^mass +\S+ kg", answer.stdout, re.M)
                typed += 1
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
