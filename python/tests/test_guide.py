# SPDX-License-Identifier: BSD-3-Clause
"""The page doc/guide/python.md: its examples run, and it mentions every name of the package."""

from __future__ import annotations

import contextlib
import io
import re
from pathlib import Path

import pytest

import scree

PAGE = Path(__file__).resolve().parents[2] / "doc/guide/python.md"


def blocks() -> list[str]:
    """The blocks of Python code in the page."""
    return re.findall(r"^```python\n(.*?)^```", PAGE.read_text(encoding="utf-8"), re.M | re.S)


def test_example(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Would catch an example that does not run, is too long, or prints other text than the page shows."""
    example = blocks()[0]
    assert len(example.splitlines()) <= 40
    monkeypatch.chdir(tmp_path)
    said = io.StringIO()
    with contextlib.redirect_stdout(said):
        exec(compile(example, PAGE.name, "exec"), {})
    last = said.getvalue().splitlines()[-1]
    for block in blocks()[1:]:                           # these blocks read the results of the first example
        exec(compile("import scree\n" + block, PAGE.name, "exec"), {})
    assert f"`{last}`" in PAGE.read_text(encoding="utf-8")
    speed, slope = (float(word) for word in re.findall(r"\d+\.?\d*", last))
    assert speed == pytest.approx(3940, rel=0.01) and slope == pytest.approx(1.49, rel=0.02)
    for name in ("stress.png", "energies.png"):
        assert (tmp_path / "out/shock" / name).stat().st_size > 5000


def test_names_of_the_page() -> None:
    """Would catch a function that the page does not mention, and one that it mentions and that does not exist."""
    text = PAGE.read_text(encoding="utf-8")
    # classes of the attributes run.tables, run.snapshots and scree.plot
    left_out = {"Tables", "Snapshots", "plot"}
    for name in set(scree.__all__) - left_out:
        assert re.search(rf"\b{name}\b", text), f"{name} is not in {PAGE.name}"
    for name in re.findall(r"\bscree\.plot\.(\w+)\(", text):
        assert callable(getattr(scree.plot, name))
    for name in re.findall(r"\bscree\.(\w+)\(", text):
        assert name in scree.__all__
    for kind, word in ((scree.Run, "run"), (scree.Snapshot, "snap")):
        for name in re.findall(rf"\b{word}\.(\w+)", text):
            assert hasattr(kind, name) or name in ("folder", "case", "tables", "units", "file", "sh")
        public = {name for name in vars(kind) if not name.startswith("_")}
        assert public <= set(re.findall(rf"\b{word}\.(\w+)", text)), f"not all of {kind.__name__} is in the page"
    assert all(hasattr(scree, name) for name in scree.__all__) and set(scree.__all__) <= set(dir(scree))
    with pytest.raises(AttributeError, match="no attribute 'plots'"):
        _ = scree.plots
