# SPDX-License-Identifier: BSD-3-Clause
# tiers: smoke, full
# timeout: 120
"""The page on own strength laws (doc/guide/own_law.md): its code is compiled by its command, and its deck runs.

Would catch a page whose code differs from the example of the sources, whose command does not find the header or warns,
whose deck is refused, whose number is not that of the run, and a header whose structures differ from those of the
program or of scree_law.f90: a column in another place gives another stress.
"""

import math
import os
import re
import shutil
import subprocess

import numpy as np
import pytest

import case
import law_libraries

PAGE = case.ROOT / "doc/guide/own_law.md"


def blocks(language):
    """Contents of the fenced blocks of a language."""
    return re.findall(rf"^```{language}\n(.*?)^```", PAGE.read_text(encoding="utf-8"), re.M | re.S)


def names(text, start, end, pattern):
    """Names of components between two lines of a source."""
    part = text[text.index(start):]
    return [name for found in re.findall(pattern, part[:part.index(end)], re.M) for name in re.findall(r"\w+", found)]


def test_page(options, sheet):
    """All commands of the page in their order, in an empty folder."""
    if not shutil.which("cc"):
        pytest.skip("there is no compiler of C")
    code, = blocks("c")
    deck, = blocks("fortran")
    assert code == (law_libraries.LAWS / "voce.c").read_text(encoding="utf-8")
    (options.work / "voce.c").write_text(code, encoding="utf-8")
    (options.work / "steel.nml").write_text(deck, encoding="utf-8")
    environment = {**os.environ, **case.OPEN_MPI, "PATH": f"{options.scree.parent}:{os.environ['PATH']}"}
    commands = "".join(blocks("console"))
    assert commands.startswith("cc ") and "scree --point" in commands
    answer = subprocess.run(["bash", "-ec", commands], cwd=options.work, env=environment, capture_output=True,
                            text=True, check=False)
    assert answer.returncode == 0 and not answer.stderr, answer.stdout + answer.stderr
    values = np.genfromtxt(options.work / "out/steel/steel_point.csv", delimiter=",", names=True)
    exact = 300.0 + 200.0 * (1.0 - math.exp(-12.0 * 0.3 / math.sqrt(3.0)))
    assert f"= {exact:.0f} MPa" in PAGE.read_text(encoding="utf-8")
    # an explicit step, and the elastic strain
    sheet.near("stress at the end [MPa]", values["mises"][-1] / 1e6, exact, 200.0 * 12.0 * (0.3 / 300 + 0.004))
    sheet.near("field at the end [MPa]", values["voce_r"][-1] / 1e6, values["mises"][-1] / 1e6 - 300.0, 1e-6)


def test_three_interfaces():
    """The structures of C, of Fortran for libraries, and of the program have the same components in the same order."""
    header = (law_libraries.LAWS / "scree_law.h").read_text(encoding="utf-8")
    header = re.sub(r"/\*.*?\*/", "", header, flags=re.S)
    module = (law_libraries.LAWS / "scree_law.f90").read_text(encoding="utf-8")
    program = (case.ROOT / "src/material/law/material_library.f90").read_text(encoding="utf-8")
    rows = names(header, "typedef struct scree_rows", "} scree_rows", r"([\w\[\]]+);")
    rows = [name for name in rows if not name.isdigit()]
    assert len(rows) == 22, rows
    for text, kind in ((module, "scree_rows_t"), (program, "library_rows_t")):
        assert names(text, f"type, bind(c) :: {kind}", f"end type {kind}", r"^ +[\w()]+ :: (\w+)") == rows
    tools = names(header, "typedef struct scree_tools", "} scree_tools", r"\(\*(\w+)\)")
    assert len(tools) == 4
    for text, kind in ((module, "scree_tools_t"), (program, "library_tools_t")):
        assert names(text, f"type, bind(c) :: {kind}", f"end type {kind}", r"^ +[\w()]+ :: (\w+)") == tools
    version = re.search(r"SCREE_LAW_INTERFACE (\d+)", header).group(1)
    assert f"scree_law_version = {version}_c_int32_t" in module
    assert f"interface_version = {version} " in program
