# SPDX-License-Identifier: BSD-3-Clause
"""scree.accuracy: orders, extrapolated values and costs of numbers from refined grids."""
from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from conftest import LINE

import scree
from scree.causes import causes_of
from scree.convergence import cost_law, forecast, judge
from scree.grids import grid_of
from scree.launch import echo_of
from scree.program import find_program

SET = {"grid.dx": 0.001}


def shock_mean(run: scree.Run) -> dict[str, float]:
    """Mean pressure near the wall, and the number of particles as a quantity without error."""
    near = run.snapshots[-1].along((0, 0, 0), (0.002, 0, 0), "pressure")
    return {"pressure": float(near["pressure"].mean()), "length": 0.018}


def test_accuracy_of_measured_numbers(tmp_path: Path) -> None:
    """Would catch grids in a wrong order, numbers of functions that are lost, and cell sizes that are not in SI."""
    found = scree.accuracy(LINE, shock_mean, factors=(2, 1, 0.5), set=SET, outdir=tmp_path, progress=False)
    assert found.table["cell_size"].tolist() == pytest.approx([0.002, 0.001, 0.0005])
    assert found.table["particles"].tolist() == [18, 36, 72]
    assert list(found.verdicts) == ["pressure", "length"]
    assert found.verdicts["length"].kind == "does not change"
    assert found.table["pressure"].iloc[-1] == pytest.approx(2.1e10, rel=0.2)
    assert found.table.attrs["units"]["cell_size"] == "m" and len(found.folders) == 3
    assert [axes.get_xlabel() for axes in found.plot().axes[:1]] == ["edge of a cell [mm]"]


def test_failures_are_errors_of_the_package(tmp_path: Path) -> None:
    """Would catch an invalid deck that is run, and an exception of another class than that of scree.run."""
    with pytest.raises(scree.DeckError, match="the deck is not accepted"):
        scree.accuracy(LINE, shock_mean, factors=(2, 1, 0.5), set={"grid.dxx": 1}, outdir=tmp_path, progress=False)
    with pytest.raises(scree.DeckError, match="name three of these"):
        scree.accuracy(LINE, shock_mean, factors=(1, 1.001, 1.002), outdir=tmp_path, progress=False)
    assert not list(tmp_path.glob("accuracy_*"))


@pytest.mark.parametrize("order", [0.7, 1.0, 2.0, 2.4])
@pytest.mark.parametrize("sizes", [(2.0, 1.4, 1.0), (4.0, 2.0, 1.0), (3.0, 2.7, 0.9)])
def test_power_laws(order: float, sizes: tuple[float, float, float]) -> None:
    """Would catch a wrong order, extrapolated value or cost estimate."""
    verdict = judge(sizes, [5.0 - 0.3 * size ** order for size in sizes])
    assert verdict.order == pytest.approx(order, abs=1e-9) and verdict.limit == pytest.approx(5.0, abs=1e-9)
    seconds = [7.0 * size ** -3.0 for size in sizes]
    assert cost_law(sizes, seconds, 2) == pytest.approx((7.0, 3.0))
    plan = forecast(sizes, seconds, verdict, 0.5 * verdict.error, 2)
    assert plan is not None
    assert plan[0] == pytest.approx(sizes[-1] * 0.5 ** (1.0 / order))
    assert plan[1] == pytest.approx(7.0 * plan[0] ** -3.0)


@pytest.mark.parametrize(("system", "grid", "key"), [
    ("si", "lo = 0 0 0  hi = 20 mm, 1 mm, 2 mm  dx = 1 mm", "dx"),
    ("mm-us-mg", "lo = 0 0 0  hi = 2 cm, {0.05 + 0.05} cm, 0.2 cm  dx = {1e3} um  ! 3 m\n", "dx"),
    ("mm-us-mg", "lo = 0, 0, 0  hi = {2*h} 1 2  dx = {h/10}", "dx"),
    ("mm-us-mg", "lo = 3*0  hi = 20 1 2  cells = {2*h}, 1, 1", "cells")])
def test_grid_of_a_deck(tmp_path: Path, system: str, grid: str, key: str) -> None:
    """Would catch cells that are wrong by a power of ten, or not found, in a deck with units and expressions, and a
    setting for finer cells that is read in the units of the deck."""
    deck = tmp_path / "deck.nml"
    deck.write_text(f"""&run dimension = '1d'  title = 'a bar of 2 m' /
&units system = '{system}' /
&define h = 10 /
&grid {grid} /
&time t_end = 15 us  dt_max = 3 us /
&material name = 'rock'  density = 2.7 g/cm3  bulk = 30 GPa  shear = 30 GPa /
&region name = 'bar'  shape = 'box'  lo = 3*0 mm  hi = 3*10 mm /
&body name = 'bar'  region = 'bar'  material = 'rock' /
""", encoding="utf-8")
    program = find_program()
    found = grid_of(echo_of(program, deck, {}))
    assert found.cells == (20, 1, 1) and found.key == key
    assert found.spacing == pytest.approx(1.0e-3, rel=1e-12)
    finer = grid_of(echo_of(program, deck, found.setting(40)))
    assert finer.cells == (40, 1, 1) and finer.spacing == pytest.approx(0.5e-3, rel=1e-12)


@pytest.mark.parametrize(("values", "kind"), [
    ((1.0, 1.2, 1.1), "oscillating"), ((352.0, 419.0, 490.0), "not converging"), ((1.0, 2.0, 4.0), "not converging")])
def test_no_limit(values: tuple[float, float, float], kind: str) -> None:
    """Would catch an extrapolated value where none exists."""
    verdict = judge((4.0, 2.0, 1.0), values)
    assert verdict.kind == kind and verdict.limit is None
    assert kind == "oscillating" or verdict.error == np.inf


@pytest.mark.parametrize(("effects", "keys", "named"), [
    ("damage = .true.", "damage_model = 'principal_stress'", "principal_stress"),
    ("damage = .true.", "damage_model = 'none' spall = 1.0e9", "by spall"),
    ("damage = .true.", "damage_model = 'principal_stress' fracture_energy = 20.0", ""),
    ("damage = .true.", "damage_model = 'principal_strain' failure_delay = 1.0e-6", ""),
    ("damage = .true.", "damage_model = 'grady_kipp'", ""), ("damage = .false.", "spall = 1.0e9", "")])
def test_causes(effects: str, keys: str, named: str) -> None:
    """Would catch a failure without a length that is not named as a reason of values that do not converge, and a
    material with one, or without damage, that is."""
    found = causes_of(f"&effects {effects} /\n&material name = 'rock' {keys} /\n")
    assert bool(found) == bool(named)
    assert not named or ("'rock'" in found[0] and named in found[0])


def test_cost_needs_an_order() -> None:
    """Would catch a cost estimate from values that oscillate."""
    verdict = judge((2.0, 1.4, 1.0), (1.0, 1.2, 1.1))
    assert forecast((2.0, 1.4, 1.0), (1.0, 2.0, 4.0), verdict, 1e-3, 3) is None
    assert np.isnan(verdict.order)
