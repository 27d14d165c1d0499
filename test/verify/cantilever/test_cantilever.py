# SPDX-License-Identifier: BSD-3-Clause
"""A soft beam, clamped at one end, falls under its own weight and oscillates.

Would catch: bending that is too stiff (locking) or too soft, a clamp that moves, large rotations with the wrong stress,
corners of particles in the wrong positions.

A. Sadeghirad, R. M. Brannon, J. Burghardt, Int. J. Numer. Methods Eng. 86 (2011) 1435: 4 x 1 m, Neo and Hooke,
E = 1 MPa, nu = 0.3, rho = 1050 kg/m3, g = 10 m/s2, plane strain, cells of 0.25 m, 3 x 3 particles. Finite
elements give for the lower corner of the tip a first minimum of -3.27 m (-3.28 by others) at 1.03 to
1.06 s. There is no closed solution, and so no rate. The corner is extrapolated from the three particles
beside it. The motion after the minimum is not compared: the tip then swings to the left and shares nodes with the wall
that clamps the beam, which extends above and below the beam here but not in the finite elements.

Limits: deflection 1.5 % and time 5 %, the differences between references; error of the energy balance 3 % of the work
of gravity: w dt/2 = 0.4 % is that of the half step between velocities and stresses, the rest is a target. The plain
method misses the last: a known miss, held at twice the target.
"""

import pytest

import bodies
import measured

FALL, WHEN = -3.27, 1.045              # [m], [s]


@pytest.mark.parametrize("name, words", [
    ("ddmp", ()),
    ("control", ("ddmp", "quadrature='control'")),
    ("gimp", ("mpm", "basis='gimp'")),
    ("cpdi", ("mpm", "basis='cpdi'")),
    ("mpm", ("mpm", "")),
    ("quadratic", ("mpm", "basis='quadratic'")),
])
def test_bend(options, sheet, name, words):
    """One beam and its limits."""
    result = bodies.cantilever(options, name, *words)
    measured.show(name, {key: result[key] for key in ("fall", "when", "energy", "steps")})
    sheet.near(f"{name}: first minimum of the tip [m]", result["fall"], FALL, 0.015)
    sheet.near(f"{name}: its time [s]", result["when"], WHEN, 0.05)
    if name == "mpm":
        sheet.known("mpm: energy in the books", result["energy"], limit=0.06, target=0.03)
    else:
        sheet.below(f"{name}: energy in the books", result["energy"], 0.03)
