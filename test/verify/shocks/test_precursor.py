# SPDX-License-Identifier: BSD-3-Clause
"""Elastic precursor and plastic shock of four metals in five bars that hit a wall.

Would catch: plasticity that exceeds the elastic limit, pressure and deviator with different strains, plastic work that
is not in the energy, two waves that merge.

Exact jumps of a solid of von Mises without hardening (test/support/shocks.py): the elastic wave with logarithmic
strain Y/2G, and a second shock into the state behind it. Limits: elastic limit 2 %, its speed 1 %, plastic stress 0.5
%, its speed 1 %. Plateaus are means over the particles between the fronts. Viscosity bulk_q1 = 0.5, because weak shocks
oscillate with the default 0.06 (doc/theory/verification_bodies.md), whose results are printed too.
"""

import numpy as np
import pytest

import case
import measured
import shocks
import test_hugoniot

SMOOTH = "bulk_q1=0.5"
AL_2024 = shocks.Metal("al_2024", 2785.0, 5328.0, 1.338, 2.00, 27.6e9, 0.3e9)
AL_6061 = shocks.Metal("al_6061", 2703.0, 5350.0, 1.34, 1.97, 27.6e9, 0.29e9)
CU = shocks.Metal("cu", 8930.0, 3940.0, 1.49, 2.0, 45.0e9, 0.09e9)
BE = shocks.Metal("be", 1845.0, 7998.0, 1.124, 1.11, 151.0e9, 0.33e9)
# Metal, speed, and published values: elastic limit, plastic stress [GPa], their speeds [m/s].
ROWS = ((AL_2024, 400, (0.635879, 6.635879, 6490.4, 5908.5)), (AL_2024, 100, (0.635879, 1.629767, 6490.4, 5510.8)),
        (AL_6061, 250, (0.605479, 3.944893, 6538.3, 5730.8)), (CU, 20, (0.199030, 0.741591, 4722.2, 3976.9)),
        (BE, 100, (0.349343, 1.632366, 13167.0, 8127.5)))
CELLS, SIZE = 400, 0.1
DECK = test_hugoniot.DECK.replace("strength=.false.", "strength=.true.")


def strike(options, metal, speed, words, cells=CELLS):
    """Relative differences of one bar from the closed solution, and the scatter over the plateaus."""
    ahead, after = metal.precursor(), metal.plastic(speed)
    length = cells * SIZE * 1e-3
    end = float(0.95 * length / ahead["speed"])      # the bar moves towards the wave, so it takes L/U
    deck = DECK.format(box=length * 1e3 + 2.0, size=SIZE, length=length * 1e3, end=end * 1e6, first=0.3 * end * 1e6,
                       second=0.6 * end * 1e6, method=words, words=metal.words(), velocity=-speed / 1e3)
    run = case.Case(options, f"solid_{metal.name}_{speed}", deck).run("-q")
    states = []
    for time, snap in run.snapshots()[1:]:
        order = np.argsort(snap.fields["identity"])
        states.append((time, snap.points[order, 0], {key: values[order] for key, values in snap.fields.items()}))
    assert len(states[1][1]) == 4 * cells
    levels = (0.5 * ahead["stress"], 0.5 * (ahead["stress"] + after["stress"]))
    fronts = np.array([[test_hugoniot.front(places, -fields["stress"][:, 0], level) for level in levels]
                       for _, places, fields in states])
    pace = (fronts[1] - fronts[0]) / (states[1][0] - states[0][0]) + speed
    _, places, fields = states[1]
    width = fronts[1, 0] - fronts[1, 1]
    between = (places > fronts[1, 1] + 0.35 * width) & (places < fronts[1, 0] - 0.25 * width)
    behind = (places > 2.0e-3) & (places < fronts[1, 1] - 2.0e-3)
    stress = -fields["stress"][:, 0]
    return {"elastic": stress[between].mean() / ahead["stress"] - 1.0, "elastic speed": pace[0] / ahead["speed"] - 1.0,
            "plastic": stress[behind].mean() / after["stress"] - 1.0, "plastic speed": pace[1] / after["speed"] - 1.0,
            "density": (fields["mass"][behind].sum() / fields["volume"][behind].sum()) / after["density"] - 1.0,
            "scatter": (stress[between].std() / ahead["stress"], stress[behind].std() / after["stress"]),
            "counts": (between.sum(), behind.sum()), "energy": run.summary["ledger"]["energy_error"],
            "steps": run.summary["steps"]}


@pytest.mark.parametrize("metal, speed, known", ROWS, ids=[f"{metal.name}_{speed}" for metal, speed, _ in ROWS])
def test_precursor(options, sheet, metal, speed, known):
    """All five, with two viscosities."""
    name = f"{metal.name} at {speed} m/s"
    ahead, after = metal.precursor(), metal.plastic(speed)
    for value, right in zip((ahead["stress"] / 1e9, after["stress"] / 1e9, ahead["speed"], after["speed"]), known):
        sheet.near(f"{name}: closed solution", value, right, 2.0e-5)
    for label, words in (("smooth", SMOOTH), ("default", "")):
        found = strike(options, metal, speed, words)
        measured.show(f"{name}, {label}", {key: found[key] for key in (
            "elastic", "elastic speed", "plastic", "plastic speed", "density", "steps")})
        if label == "default":
            continue
        sheet.require(min(found["counts"]) > 40, f"{name}: both plateaus have particles")
        for key, limit in (("elastic", 0.02), ("elastic speed", 0.01), ("plastic", 0.005), ("plastic speed", 0.01),
                           ("density", 0.001), ("energy", 1.0e-12)):
            sheet.below(f"{name}: {key}", found[key], limit)
