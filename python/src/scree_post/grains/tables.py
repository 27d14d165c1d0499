# SPDX-License-Identifier: BSD-3-Clause
"""CSV and JSON files of the numbers of a cell of grains, and the table for the screen."""
from __future__ import annotations

import json
import math
from collections.abc import Iterable, Mapping, Sequence
from typing import TYPE_CHECKING, Any

from . import memory
from .material import write_block

if TYPE_CHECKING:
    from .cell_run import CellRun
    from .memory import Memory
    from .rheology import SteadyShear

STAGES = ("case", "stage", "rate [1/s]", "pressure [Pa]", "inertial_number", "stress_xy [Pa]", "mu", "mu_error", "phi",
          "phi_error", "W", "W_error", "coordination_held", "drifts")
MEMORY = ("measure", "case", "stage", "rate [1/s]", "pressure [Pa]", "inertial_number", "tau [s]", "tau_error [s]",
          "strain", "strain_error", "beta", "residual", "note")
MODULI = ("case", "stage", "relaxed", "pressure [Pa]", "G [Pa]", "lambda [Pa]", "G_xy [Pa]", "anisotropy")

Row = tuple[Any, ...]


def stage_rows(shears: Sequence[SteadyShear]) -> list[Row]:
    """Rows of the table of steady shear."""
    return [(one.run.case, one.stage.name, one.rate, one.pressure, one.inertial, one.stress, one.mu, one.mu_error,
             one.phi, one.phi_error, one.normal, one.normal_error, one.coordination, one.drifting) for one in shears]


def memory_rows(results: Sequence[tuple[CellRun, Any]]) -> list[Row]:
    """Rows of the table of tau; `results` are pairs of a run and its measurements."""
    return [(one.measure, run.case, one.stage, one.rate, one.pressure, one.inertial, one.tau, one.tau_error,
             one.strain, one.error, one.beta, one.residual, one.note) for run, found in results for one in found]


def moduli_rows(results: Sequence[tuple[CellRun, Any]]) -> list[Row]:
    """Rows of the table of moduli; `results` are pairs of a run and its probes."""
    return [(run.case, one.stage, int(one.relaxed), one.pressure, one.shear, one.lame, one.shear_xy, one.anisotropy)
            for run, found in results for one in found]


def cell(value: Any) -> str:
    """A value of a CSV file."""
    if isinstance(value, str):
        return f'"{value}"' if "," in value or ";" in value else value
    return f"{value:.9g}"


def write_table(path: str, columns: Sequence[str], rows: Iterable[Row]) -> None:
    """Write comma separated values."""
    write_block(path, "\n".join([",".join(columns), *(",".join(map(cell, row)) for row in rows), ""]))


def plain(value: Any) -> Any:
    """A value of a JSON file: null where it is not finite."""
    if isinstance(value, float) and not math.isfinite(value):
        return None
    return float(value) if hasattr(value, "dtype") else value


def records(columns: Sequence[str], rows: Iterable[Row]) -> list[dict[str, Any]]:
    """Rows as objects."""
    return [{name: plain(value) for name, value in zip(columns, row)} for row in rows]


def write_json(path: str, parts: Mapping[str, Any]) -> None:
    """Write all numbers."""
    write_block(path, json.dumps(parts, indent=1) + "\n")


def with_error(value: float, error: float) -> str:
    """A number and its error as 0.0812(21)."""
    if not (math.isfinite(value) and math.isfinite(error) and error > 0.0):
        return f"{value:.4g}"
    if error < 1.0e-4 * abs(value):
        return f"{value:.5g}"
    places = max(0, 1 - math.floor(math.log10(error)))
    return f"{value:.{places}f}({error * 10 ** places:.0f})"


def four_ways(shears: Sequence[SteadyShear], memories: Sequence[Memory]) -> list[str]:
    """Lines: tau rate of each stage by each method, and the spread of the four."""
    names = (*memory.FOUR, "reversal")
    lines = [f"{'tau rate of stage':<20} {'I':>7} " + " ".join(f"{name:>13}" for name in names) + "  greatest/least"]
    for shear in shears:
        found = {one.measure: one for one in memories if one.stage == shear.stage.name}
        cells = [with_error(found[name].strain, found[name].error) if name in found else "-" for name in names]
        low, high, count = memory.spread_of(memories, shear.stage.name)
        ratio = high / low
        spread = f"{ratio:.{0 if ratio >= 10.0 else 1}f} of {count}" if count > 1 else "-"
        lines.append(f"{shear.stage.name:<20} {shear.inertial:7.4f} " + " ".join(f"{text:>13}" for text in cells)
                     + f"  {spread}")
    return lines
