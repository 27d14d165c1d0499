# SPDX-License-Identifier: BSD-3-Clause
"""The page doc/guide/in_process.md: its examples run and print the text of the page, and it mentions every member."""

from __future__ import annotations

import contextlib
import io
import re
from pathlib import Path

import pytest

import scree
from scree import library
from scree.simulation import Simulation

try:
    library.find_library()
except scree.FileProblem as error:
    pytest.skip(str(error), allow_module_level=True)

PAGE = Path(__file__).resolve().parents[2] / "doc/guide/in_process.md"


def test_examples(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Would catch an example that does not run, or results that differ from the page: a material model without stress
    relaxation, a spring with a wrong period, a piston that does not reach its stress."""
    text = PAGE.read_text(encoding="utf-8")
    monkeypatch.chdir(tmp_path)
    said = io.StringIO()
    names: dict[str, object] = {}
    with contextlib.redirect_stdout(said):
        for block in re.findall(r"^```python\n(.*?)^```", text, re.M | re.S):
            exec(compile(block, PAGE.name, "exec"), names)
    lines = said.getvalue().splitlines()
    assert "t_end reached 3" in lines
    for line in re.findall(r"`(elastic: .*?)` and `(relaxed: .*?)`", text)[0]:
        assert line in lines
    spring = next(line for line in lines if line.startswith("after a quarter"))
    speed, exact = (float(word) for word in re.findall(r"-\d\.\d+", spring))
    assert speed == pytest.approx(exact, rel=1e-3)
    assert any(line.startswith("stress -100.0 MPa") for line in lines)


def test_names() -> None:
    """Would catch a member that the page does not explain, and one that does not exist any more."""
    text = PAGE.read_text(encoding="utf-8")
    used = set(re.findall(r"\bsim\.(\w+)", text))
    public = {name for name in vars(Simulation) if not name.startswith("_")} | {"stores", "controls"}
    assert used <= public and public - used <= {"generation"}
    assert scree.Simulation is Simulation
