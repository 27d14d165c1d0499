# SPDX-License-Identifier: BSD-3-Clause
"""The problems of test/support/bodies.py on fine grids with the defaults.

Would catch: errors that stop decreasing, or grow, where grids are finer than those of the short tests, as undamped
noise of particles does; all short tests may pass with it.

Limits: the targets of the short tests, halved for each halving of the cells where the error is of first order at
least: spinning disc 1e-3 per turn with 10 cells on the radius, so half of that with 20; two discs 1 % of the energy
with 32 cells across, half of that with 64; stress of the column h/L; orders 1.8 for second order, 0.85 for first order.
Held bar: energy 1 %, period the dispersion of DDMP. Shear of grains: the waves of the short test, 1 % with 5e-4 kg/m3,
are proportional to the root of the density.
"""
# tiers: long
# timeout long: 2400

import numpy as np
import pytest

import bodies
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
    errors = []
    for cells in (26, 52, 104):
        result = bodies.held_bar(options, f"held_{cells}_{speed}", cells=cells, speed=speed)
        errors.append(abs(result["period"] / right - 1.0))
        measured.record(f"held_{cells}_{speed}.lag", result["period"] / right - 1.0)
        sheet.below(f"held bar, {speed} m/s, {cells} cells: energy", result["energy"], 0.01)
        sheet.below(f"held bar, {speed} m/s, {cells} cells: period", errors[-1],
                    7 / 24 * (0.5 * np.pi / cells) ** 2)
    for cells, rate in zip((52, 104), bodies.rates(errors)):
        sheet.above(f"held bar, {speed} m/s: rate of the period to {cells} cells", rate, 1.8)


def test_free_bar(options, sheet):
    runs = [bodies.free_bar(options, f"bar_{spacing}", spacing=spacing) for spacing in (1.0, 0.5, 0.25)]
    for key in ("velocity", "displacement", "stress"):
        first, second = bodies.rates([result[key] for result in runs])
        measured.record(f"free bar: rate of {key}", second)
        if key == "velocity":
            sheet.above("free bar: rate of the velocity, coarse", first, 1.8)
            sheet.above("free bar: rate of the velocity, fine", second, 1.8)


def test_column(options, sheet):
    runs = [bodies.column(options, f"column_{cells}", cells=cells) for cells in (40, 80, 160)]
    for cells, result in zip((40, 80, 160), runs):
        sheet.below(f"column, {cells} cells: stress over the weight on the foot", result["stress"], 1.0 / cells)
    for rate in bodies.rates([result["stress"] for result in runs]):
        sheet.above("column: rate of the stress", rate, 0.85)


def test_cantilever(options, sheet):
    result = bodies.cantilever(options, "beam", spacing=0.125)
    sheet.near("cantilever, cells of 0.125 m: first minimum [m]", result["fall"], -3.27, 0.015)


def test_shear(options, sheet):
    result = bodies.shear(options, "shear", density=1.0e-4)
    sheet.below("shear of very light grains: shear stress", result["across"], 0.01 * 0.2 ** 0.5)
