# SPDX-License-Identifier: BSD-3-Clause
"""Boundaries with a prescribed temperature: a slab between a hot and a cold one, and the heat that they exchange.

Would catch: a boundary that prescribes the temperature of the particles beside it instead of the nodes on it, which
shifts it by part of a cell; a flux through such a boundary that is set to zero as on an insulated one; heat that enters
and is not recorded, or is recorded by each tile at the boundary; a boundary that also acts on its neighbours.

A slab at 400 K between 500 K and 300 K tends to a linear profile; the difference from it is the sum over even n of
-400/(n pi) sin(n pi x) exp(-a (n pi)^2 t) (H. S. Carslaw, J. C. Jaeger, Conduction of Heat in Solids, 1959, 3.4).
"""

import numpy as np

import case
import convergence
import test_conduction

DIFFUSIVITY = 0.1
CELLS = (19, 27, 39, 56)
FACES = """
&boundary  face='xlo'  type='symmetry'  temperature=500 /
&boundary  face='xhi'  type='symmetry'  temperature={right} /
&boundary  face='all'  type='symmetry' /
&output  name='h'  kind='history'  every=20 /
"""


def slab(dimension, method, words, cells, end, right):
    """The deck."""
    high = {"1d": "1,1,1", "3d": f"1,{4 / cells},{4 / cells}"}[dimension]
    text = test_conduction.HEAD.format(dimension=dimension, method=method, words=words, spacing=1.0 / cells, end=end,
                                       thermal=".true.", high=high)
    text = text.replace("&boundary  face='all'  type='symmetry' /\n", FACES.format(right=right))
    text += test_conduction.material("m", DIFFUSIVITY * test_conduction.DENSITY * test_conduction.HEAT)
    return text + test_conduction.BODY.format(name="b", material="m", points="2,2,2" if dimension == "3d" else "2,1,1",
                                              low="0,0,0", high=high, temperature=400.0)


def exact(place, time):
    """Temperature of the slab [K]."""
    result = 500.0 - 200.0 * place
    for n in range(2, 400, 2):
        wave = n * np.pi
        result = result - 400.0 / wave * np.sin(wave * place) * np.exp(-DIFFUSIVITY * wave ** 2 * time)
    return result


def test_held_faces(options, sheet):
    """Successively finer slabs at two times, and the balances in one and three dimensions."""
    for name, (method, words) in test_conduction.METHODS.items():
        errors = []
        for cells in CELLS:
            run = case.Case(options, f"held_{name}_{cells}", slab("1d", method, words, cells, 0.125, 300)).run("-q")
            time, last = run.snapshots()[-1]
            off = last.fields["temperature"] - exact(last.points[:, 0], time)
            errors.append(np.sqrt(np.mean(off ** 2)) / 100.0)
        print(f"         {name}: errors {errors}")
        sheet.below(f"{name}: error of the temperature over 100 K", errors[-1], 2.0e-3)
        sheet.above(f"{name}: order", convergence.order(CELLS, errors), 1.4)
    for dimension, cells, method in (("1d", 32, "ddmp"), ("3d", 16, "ddmp"), ("3d", 16, "mpm")):
        run = case.Case(options, f"books_{dimension}_{method}", slab(dimension, method, "", cells, 0.05, 400)).run("-q")
        first, last = run.snapshots()[0][1], run.snapshots()[-1][1]
        rise = test_conduction.heat_of(last) - test_conduction.heat_of(first)
        given = run.history["external_work"][-1]
        sheet.near(f"{dimension} {method}: heat that is booked over the rise of the heat", given, rise, 1.0e-11)
        sheet.above(f"{dimension} {method}: rise over that of the whole by 1 K",
                    rise / (test_conduction.HEAT * first.fields["mass"].sum()), 5.0)
        sheet.below(f"{dimension} {method}: energy error", run.summary["ledger"]["energy_error"], 1.0e-11)
