# SPDX-License-Identifier: BSD-3-Clause
"""G and lambda from the probes of CASE_moduli.csv: the isotropic part of the measured stiffness.

Discs: K = (C11 + C22 + C12 + C21)/4 in the plane, G = (C11 + C22 - C12 - C21 + 4 C44)/8, lambda = K - G.
Spheres (the average over directions after W. Voigt): K = sum of C11 ... C33 over 9,
G = (C11 + C22 + C33 - C12 - C23 - C13 + 3 (C44 + C55 + C66))/15, lambda = K - 2 G/3.
C44, C55 and C66 are stresses per shear such as du_x/dy. An elastic stiffness is symmetric, C12 = C21, and resists
shear; a relaxed probe in which grains rearranged is not elastic, and is not used for a block.
"""
from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from scree.errors import ScreeError

if TYPE_CHECKING:
    from scree.arrays import Bools
    from scree.files import History

    from .cell_run import CellRun

#: Difference of C12 and C21 over C11 up to which a probe counts as elastic.
ASYMMETRY = 0.1
COMPONENTS = ("xx", "yy", "zz", "xy", "xz", "yz")


@dataclass
class Moduli:
    """Isotropic moduli of one probe."""

    stage: int
    relaxed: bool
    pressure: float                                      # [Pa]
    shear: float                                         # G [Pa]
    lame: float                                          # lambda [Pa]
    shear_xy: float                                      # C44 alone [Pa]
    anisotropy: float                                    # C44 over (C11 + C22 - C12 - C21)/4 [1]
    asymmetry: float                                     # |C12 - C21| over the mean of C11 and C22 [1]

    @property
    def elastic(self) -> bool:
        """True if the state of the probe is elastic."""
        return self.shear > 0.0 and self.asymmetry < ASYMMETRY


def moduli_of(run: CellRun) -> list[Moduli]:
    """All probes of a run, in the order of the file."""
    table = run.moduli
    if table is None:
        return []
    missing = [name for name in ("stage", "relaxed", "component", "pressure", *COMPONENTS) if name not in table]
    if missing:
        raise ScreeError(f"{run.path('_moduli.csv')} has no column {', '.join(missing)}")
    found = []
    for stage in np.unique(table["stage"]):
        for relaxed in (0, 1):
            chosen = (table["stage"] == stage) & (table["relaxed"] == relaxed)
            if chosen.any():
                found.append(isotropic(table, chosen, int(stage), bool(relaxed)))
    return found


def isotropic(table: History, chosen: Bools, stage: int, relaxed: bool) -> Moduli:
    """The isotropic part of one stiffness."""
    rows = {int(component): index for component, index in zip(table["component"][chosen], np.flatnonzero(chosen))}

    def c(strain: int, stress: int) -> float:
        """Stress component per strain component, both 1 to 6; absent ones are 0."""
        return float(table[COMPONENTS[stress - 1]][rows[strain]]) if strain in rows else 0.0

    pressure = float(table["pressure"][chosen][0])
    push, cross = c(1, 1) + c(2, 2), c(1, 2) + c(2, 1)
    if 3 in rows:
        push, cross = push + c(3, 3), cross + c(1, 3) + c(3, 1) + c(2, 3) + c(3, 2)
        bulk = (push + cross) / 9.0
        shear = (push - 0.5 * cross + 3.0 * (c(4, 4) + c(5, 5) + c(6, 6))) / 15.0
        lame = bulk - 2.0 * shear / 3.0
    else:
        shear = (push - cross + 4.0 * c(4, 4)) / 8.0
        lame = (push + cross) / 4.0 - shear
    plane = (c(1, 1) + c(2, 2) - c(1, 2) - c(2, 1)) / 4.0
    return Moduli(stage, relaxed, pressure, shear, lame, c(4, 4), c(4, 4) / plane if plane else float("nan"),
                  2.0 * abs(c(1, 2) - c(2, 1)) / abs(c(1, 1) + c(2, 2)))
