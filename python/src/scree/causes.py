# SPDX-License-Identifier: BSD-3-Clause
"""Causes in a deck, from its echo, of results that depend on the size of cells however small these are."""
from __future__ import annotations

from .echo import groups


def causes_of(echo: str) -> list[str]:
    """A sentence for each material whose failure has no length of its own.

    Where such a material fails, the strain concentrates in a band as wide as a cell. The energy that is dissipated per
    area of a crack is then the energy per volume times the size of the cells, which tends to zero with it (Z. P. Bazant
    and B. H. Oh, Materials and Structures 16 (1983) 155).
    """
    (effects,) = groups(echo, "effects") or [{}]
    if not effects.get("damage"):
        return []
    found = []
    for material in groups(echo, "material"):
        model = str(material.get("damage_model", "none"))
        by = [f"damage_model = '{model}'"] * (model in ("johnson_cook", "jh2", "hjc", "porosity") or (
            model in ("principal_stress", "principal_strain") and "fracture_energy" not in material
            and not material.get("failure_delay")))
        by += ["spall"] * ("spall" in material)
        if by:
            found.append(f"material '{material['name']}' fails by {' and '.join(by)} without a length: failure "
                         "concentrates in single cells, and the energy that it dissipates decreases with their size")
    if found:
        found.append("damage_model = 'principal_stress' or 'principal_strain' with fracture_energy has a length; "
                     "otherwise compare runs with cells of the same size")
    return found
