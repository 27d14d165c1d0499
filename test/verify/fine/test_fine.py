# SPDX-License-Identifier: BSD-3-Clause
"""The problems of test/support/bodies.py on fine grids with the defaults.

Would catch: errors that stop decreasing, or grow, where grids are finer than those of the short tests, as undamped
noise of particles does; all short tests may pass with it.

Limits: the targets of the short tests, halved for each halving of the cells where the error is of first order at least:
spinning disc 1e-3 per turn with 10 cells on the radius, so half of that with 20; two discs 1 % of the energy with 32
cells across, half of that with 64; stress of the column h/L; orders, by least squares over four grids, 1.8 for second
order, 0.85 for first order. Held bar: energy 1 %, period the dispersion of DDMP. Shear of grains: the waves of the
short test, 1 % with 5e-4 kg/m3, are proportional to the root of the density.
"""
# tiers: long
# timeout long: 2400

import numpy as np
import pytest

import bodies
import convergence
import measured


@pytest.mark.parametrize("ppc", [2, 3])
def test_spin(options, sheet, ppc):
    result = bodies.spin(options, f"spin_{ppc}", spacing=0.05, ppc=ppc)
    sheet.below(f"spin, {ppc} x {ppc}: angular momentum in a turn", result["drift"], 5.0e-4)
    sheet.below(f"spin, {ppc} x {ppc}: energy in a turn", result["energy"], 5.0e-4)
    sheet.below(f"spin, {ppc} x {ppc}: displacement", result["displacement"], 5.6e-4)


def test_two_discs(options, sheet):
    for name, limit, words in (("64 cells", 0.005, {"spacing": 0.00625}),
                               ("3 x 3 particles", 0.01, {"spacing": 0.0125, "ppc": 3}),
                               ("4 x 4 particles", 0.01, {"spacing": 0.0125, "ppc": 4}),
                               ("short steps", 0.01, {"spacing": 0.0125, "cfl": 0.1})):
        result = bodies.two_discs(options, "discs_" + name.replace(" ", "_"), **words)
        sheet.below(f"two discs, {name}: energy", result["energy"], limit)
        sheet.below(f"two discs, {name}: greatest energy", result["greatest"], 0.01)
        sheet.below(f"two discs, {name}: momentum", result["momentum"], 1.0e-13)


@pytest.mark.parametrize("speed", [0.1, 0.75])
def test_held_bar(options, sheet, speed):
    right = bodies.held_bar_reference(speed)["period"]
    errors, grids = [], (30, 40, 52, 92)
    for cells in grids:
        result = bodies.held_bar(options, f"held_{cells}_{speed}", cells=cells, speed=speed)
        errors.append(abs(result["period"] / right - 1.0))
        measured.record(f"held_{cells}_{speed}.lag", result["period"] / right - 1.0)
        sheet.below(f"held bar, {speed} m/s, {cells} cells: energy", result["energy"], 0.01)
        sheet.below(f"held bar, {speed} m/s, {cells} cells: period", errors[-1],
                    7 / 24 * (0.5 * np.pi / cells) ** 2)
    sheet.above(f"held bar, {speed} m/s: order of the period", convergence.order(grids, errors), 1.8)


def test_free_bar(options, sheet):
    runs = {parts: bodies.free_bar(options, f"bar_{2.0 / parts}", spacing=2.0 / parts) for parts in (3, 5, 7, 8)}
    for key in ("velocity", "displacement", "stress"):
        order = convergence.order(runs, [result[key] for result in runs.values()])
        measured.record(f"free bar: order of {key}", order)
        if key == "velocity":
            sheet.above("free bar: order of the velocity", order, 1.8)


def test_column(options, sheet):
    runs = {cells: bodies.column(options, f"column_{cells}", cells=cells) for cells in (50, 72, 110, 160)}
    for cells, result in runs.items():
        sheet.below(f"column, {cells} cells: stress over the weight on the foot", result["stress"], 1.0 / cells)
    sheet.above("column: order of the stress", convergence.order(runs, [result["stress"] for result in runs.values()]),
                0.85)


def test_cantilever(options, sheet):
    result = bodies.cantilever(options, "beam", spacing=0.125)
    sheet.near("cantilever, cells of 0.125 m: first minimum [m]", result["fall"], -3.27, 0.015)


def test_shear(options, sheet):
    result = bodies.shear(options, "shear", density=1.0e-4)
    sheet.below("shear of very light grains: shear stress", result["across"], 0.01 * 0.2 ** 0.5)
