# SPDX-License-Identifier: BSD-3-Clause
"""The shock in front of a rigid wall becomes thinner with the cell size.

Would catch: artificial viscosity that does not scale with the cell size, a wall that heats more and more of the bar, a
shock of the wrong speed: the error would not decrease.

Bars of Al-2024 at 400 m/s of test_piston.py. Error: sum of |rho - exact| times volume, over the length of the
shocked bar and the jump of the density, for 5, 7, 11 and 16 cells per mm; the fluid against the shock of
Rankine and Hugoniot, the solid against precursor and plastic shock. A shock is spread over a fixed number of
cells, so the best order is 1.

The density is that of the four particles that began in one cell together. Single particles keep a scatter
of 3 % of the jump behind the shock, which does not decrease with the cell size (the order computed from them is 0.4,
both are printed); their mean has an error of 1e-4. The solid has bulk_q1 = 0.5 as in test_piston.py, and the default.

Limits. Order of the error: at least 1/2, as the heated wall is a contact discontinuity, which schemes of first order
resolve at that order. The mean of a cell must be more accurate than single
particles. Error of the finest run: the scatter of 3 % of single particles.
"""
# tiers: smoke, full

import numpy as np
import pytest

import case
import convergence
import measured
import test_piston
import tier

SPEED = 400.0
CELLS = tier.choose((5, 7, 11, 16), smoke=(5,))       # per mm


def strike(options, name, spacing, solid, words):
    """One bar; errors of the density of cells, and of particles."""
    end, length = (3.0, 24) if solid else (2.0, 16)      # [us], [mm]
    law = "shear=27.6 strength_model='von_mises' yield=0.3" if solid else ""
    deck = test_piston.DECK.format(method="ddmp", end=end, half=0.6 * end, velocity=-SPEED / 1000.0, ppc=4, cfl=0.4,
                                   strength=".true." if solid else ".false.", law=law, words=words,
                                   length=length, box=length + 2)
    run = case.Case(options, name, deck).run("-q", "--set", f"grid.dx={spacing}")
    time, last = run.snapshots()[-1]
    places, fields = last.points[:, 0], last.fields
    order = np.argsort(places)
    mass, volume = fields["mass"][order], fields["volume"][order]
    shock, _, behind = test_piston.hugoniot(SPEED)
    fronts, levels = [(shock - SPEED) * time], [behind]
    if solid:
        ahead, after = test_piston.precursor(), test_piston.plastic(SPEED)
        fronts = [(after["speed"] - SPEED) * time, (ahead["speed"] - SPEED) * time]
        levels = [after["density"], ahead["density"]]
    errors = []
    for number in (4, 1):
        middle = places[order].reshape(-1, number).mean(axis=1)
        room = volume.reshape(-1, number).sum(axis=1)
        density = mass.reshape(-1, number).sum(axis=1) / room
        exact = np.select([middle < front for front in fronts], levels, test_piston.DENSITY)
        error = (abs(density - exact) * room).sum() / 1.0e-6
        errors.append(error / (fronts[0] * (levels[0] - test_piston.DENSITY)))
    return errors


CASES = (("fluid", False, ""), ("solid", True, test_piston.SMOOTH), ("solid default", True, ""))


@pytest.fixture(scope="module")
def errors_of(file_options):
    """Errors by cells and by particles for each cell size, of each case; the lines show them."""
    found = {}
    for name, solid, words in tier.choose(CASES, smoke=CASES[:1]):
        found[name] = []
        for cells in CELLS:
            found[name].append(strike(file_options, f"{name.replace(' ', '_')}_{cells}", 1.0 / cells, solid, words))
    return found


def test_cells(errors_of, sheet):
    """Means over cells against particles. Pressures in a cell are relaxed to each other, so the mean has no effect."""
    worst = max(one / two for errors in errors_of.values() for one, two in errors)
    sheet.known("error of cells over that of particles, the worst", worst, limit=1.1, target=1.0)


@pytest.mark.parametrize("name", [row[0] for row in tier.choose(CASES, smoke=CASES[:1])])
def test_rate(errors_of, sheet, name):
    """Fluid and solid."""
    errors = errors_of[name]
    for cells, row in zip(CELLS, errors):
        measured.show(f"{name}, {cells} per mm", dict(zip(("cells", "particles"), row)))
    sheet.require(all(error > 0.0 for row in errors for error in row), f"{name}: errors are measured")
    if tier.NAME == "smoke":
        return
    orders = [convergence.order(CELLS, column) for column in zip(*errors)]
    measured.record(f"{name}.order of", dict(zip(("cells", "particles"), orders)))
    sheet.above(f"{name}: order of the density", orders[0], 0.5)
    sheet.below(f"{name}: error of the density", errors[-1][0], 0.03)
