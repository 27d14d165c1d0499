# SPDX-License-Identifier: BSD-3-Clause
"""The notebooks in doc/learn/notebooks run from the first cell to the last and draw the figures that their text
describes."""
from __future__ import annotations

import base64
import io
from pathlib import Path
from typing import Any

import matplotlib.image
import numpy as np
import pytest

nbformat = pytest.importorskip("nbformat", reason="nbformat is not installed; scripts/setup.sh installs it")
nbclient = pytest.importorskip("nbclient", reason="nbclient is not installed; scripts/setup.sh installs it")

FOLDER = Path(__file__).resolve().parents[2] / "doc/learn/notebooks"
BOOKS = sorted(FOLDER.glob("*.ipynb"))
# Least number of pictures, and words of the printed results.
EXPECTED = {"shock_in_copper": (2, "the deck has 3940 m/s"), "debris_cloud": (4, ""),
            "glass_rod": (2, "m/s in the glass"), "column_collapse": (3, "measured"),
            "taylor_bar": (2, "the deck has 157 MPa"), "driven_plate": (2, "Gurney")}


def test_all_notebooks_are_known() -> None:
    """Would catch a notebook without an expected result, and an expected result without a notebook."""
    assert {book.stem for book in BOOKS} == set(EXPECTED)


@pytest.mark.parametrize("path", BOOKS, ids=lambda path: path.stem)
def test_notebook(path: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Would catch a cell that fails, an empty picture, results stored in the file, and more than 40 lines of code."""
    book: Any = nbformat.read(path, as_version=4)
    code = [cell for cell in book.cells if cell.cell_type == "code"]
    assert all(not cell.outputs and cell.execution_count is None for cell in code), "clear the outputs"
    assert sum(len(cell.source.splitlines()) for cell in code) <= 40
    monkeypatch.delenv("MPLBACKEND", raising=False)      # pictures into the notebook
    nbclient.NotebookClient(book, timeout=300, resources={"metadata": {"path": str(tmp_path)}}).execute()
    outputs = [output for cell in code for output in cell.outputs]
    pictures = [output.data["image/png"] for output in outputs if "image/png" in output.get("data", {})]
    text = "".join(output.get("text", "") + str(output.get("data", {}).get("text/plain", "")) for output in outputs)
    fewest, words = EXPECTED[path.stem]
    assert len(pictures) >= fewest and words in text
    for picture in pictures:
        grey = matplotlib.image.imread(io.BytesIO(base64.b64decode(picture)))[..., :3].mean(axis=2)
        assert np.mean(grey < 0.9) > 0.002, "an empty picture"
