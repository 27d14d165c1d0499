# SPDX-License-Identifier: BSD-3-Clause
"""Runs of small decks, made once for all tests."""

from __future__ import annotations

import os
from collections.abc import Iterator
from pathlib import Path

import pytest

os.environ["MPLBACKEND"] = "Agg"
import matplotlib.pyplot

import scree

# Two blocks meet in plane strain. Units of the files are mm, us and mg, so that a number that is not converted to SI is
# wrong by orders of magnitude.
DECK = """
&run  case = 'tiny'  dimension = 'plane_strain' /
&units  system = 'mm-us-mg'  output_units = 'deck' /
&grid  lo = 0, 0, 0  hi = 12, 2, 6  dx = 1 /
&time  t_end = 1 /
&material  name = 'copper'  density = 8.93  bulk = 140  shear = 45 /
&region  name = 'left'  shape = 'box'  lo = 2, 0, 1  hi = 5, 2, 4 /
&region  name = 'right'  shape = 'box'  lo = 6, 0, 1  hi = 9, 2, 4 /
&body  name = 'left'  region = 'left'  material = 'copper'  ppc = 2, 1, 2  velocity = 1, 0, 0 /
&body  name = 'right'  region = 'right'  material = 'copper'  ppc = 2, 1, 2 /
&boundary  face = 'zlo'  type = 'slip' /
&output  name = 'all'  kind = 'particles'  count = 4  fields = 'default', 'stress'  precision = 'double' /
&output  name = 'fast'  kind = 'particles'  dt = 1  bodies = 'left' /
&output  name = 'energy'  kind = 'history'  every = 1 /
&output  name = 'spot'  kind = 'gauge'  every = 1  point = 3.5, 1, 2.5  fields = 'velocity' /
&output  name = 'load'  kind = 'forces'  every = 1 /
&output  name = 'pieces'  kind = 'fragments'  count = 2 /
"""
# A bar that hits a wall.
LINE = """
&run  case = 'bar'  dimension = '1d' /
&grid  lo = 0, 0, 0  hi = 0.02, 0.001, 0.002  dx = 0.001 /
&time  t_end = 1e-6 /
&effects  strength = .false. /
&material  name = 'copper'  density = 8930  eos_model = 'mie_gruneisen'  mg_c0 = 3940  mg_s = 1.49  mg_gamma = 1.96 /
&region  name = 'bar'  shape = 'box'  lo = 0, 0, 0  hi = 0.018, 0.001, 0.002 /
&body  name = 'bar'  region = 'bar'  material = 'copper'  ppc = 2, 1, 1  velocity = -500, 0, 0 /
&boundary  face = 'xlo'  type = 'slip' /
&output  name = 'bar'  kind = 'particles'  count = 2 /
"""


@pytest.fixture(scope="session")
def run(tmp_path_factory: pytest.TempPathFactory) -> scree.Run:
    """The run of the two blocks."""
    return scree.run(DECK, outdir=tmp_path_factory.mktemp("tiny"), progress=False)


@pytest.fixture(scope="session")
def bar(tmp_path_factory: pytest.TempPathFactory) -> scree.Run:
    """The run of the bar in one dimension."""
    return scree.run(LINE, outdir=tmp_path_factory.mktemp("bar"), progress=False)


@pytest.fixture
def deck(tmp_path: Path) -> Path:
    """The deck of the two blocks in an empty folder."""
    path = tmp_path / "tiny.nml"
    path.write_text(DECK, encoding="utf-8")
    return path


@pytest.fixture(autouse=True)
def no_figures() -> Iterator[None]:
    """Close all figures after each test."""
    yield
    matplotlib.pyplot.close("all")
