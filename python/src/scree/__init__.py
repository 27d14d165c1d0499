# SPDX-License-Identifier: BSD-3-Clause
"""Runs decks of the material point code Scree, and reads, draws and compares its results.

    import scree
    run = scree.run("scene.nml", set={"grid.dx": 0.05})        # or scree.open("out/scene")
    run.history["kinetic"], run.history.attrs["units"]["kinetic"]
    run.snapshots[-1]["velocity"]
    scree.plot.field(run.snapshots[-1], "pressure").savefig("pressure.png")

All values are in SI, for files in any units. Modules are imported when a name is used, so that the commands of
scree_post start fast.
"""
from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from . import plot as plot
    from .errors import DeckError, FileProblem, InternalError, Interrupted, PhysicsError, ScreeError, StaleView
    from .launch import run
    from .pictures import Radiograph, picture, radiograph
    from .program import example, find_program
    from .refinement import Accuracy, accuracy
    from .results import Run, Tables, read_table
    from .results import open_run as open
    from .simulation import Simulation
    from .snapshot import Snapshot, Snapshots
    from .study import sweep

__version__ = "0.1.0"
__all__ = ["Accuracy", "DeckError", "FileProblem", "InternalError", "Interrupted", "PhysicsError", "Radiograph", "Run",
           "ScreeError", "Simulation", "Snapshot", "Snapshots", "StaleView", "Tables", "accuracy", "example",
           "find_program", "open", "picture", "plot", "radiograph", "read_table", "run", "sweep"]

_MODULES = {
    "errors": ("DeckError", "FileProblem", "InternalError", "Interrupted", "PhysicsError", "ScreeError", "StaleView"),
    "launch": ("run",), "pictures": ("Radiograph", "picture", "radiograph"), "program": ("example", "find_program"),
    "refinement": ("Accuracy", "accuracy"),
    "results": ("Run", "Tables", "open_run", "read_table"), "simulation": ("Simulation",),
    "snapshot": ("Snapshot", "Snapshots"), "study": ("sweep",),
}
_HOME = {name: module for module, names in _MODULES.items() for name in names}


def __getattr__(name: str) -> Any:
    if name == "open":                                   # within this package `open` is the function of Python
        name = "open_run"
    if name in _HOME:
        return getattr(importlib.import_module(f"{__name__}.{_HOME[name]}"), name)
    if name == "plot":
        return importlib.import_module(f"{__name__}.plot")
    raise AttributeError(f"module '{__name__}' has no attribute '{name}'")


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})
