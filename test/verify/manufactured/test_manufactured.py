# SPDX-License-Identifier: BSD-3-Clause
"""Waves of large amplitude across many cells: errors and orders of convergence.

Would catch: forces of particles that change when they cross cells, so that errors grow with smaller cells; a mean
stress that is subtracted and added with different weights; a body force or an initial state that does not belong to the
solution; steps of first order.

P. C. Wallstedt, J. E. Guilkey, J. Comput. Phys. 227 (2008) 9628, on a line for half a period:
material moves out and back, so that at A = 0.1 a particle crosses up to 24 cells of 240. Greatest error in the run over
the greatest displacement; 4 particles per cell unless stated, no artificial viscosity, cfl = 0.2. The errors are in
doc/theory/verification.md.

A whole period doubles these errors: they are phase errors. Methods other than ddmp run with the stress update of ddmp
and flip = 1; with their defaults the results are similar except for cpgimp and cpdi, whose errors grow at 240 cells.

Limits. Errors: the dispersion of the schemes in closed form (test/support/manufactured.py). At A = 1e-4, where no
particle crosses a cell face, it must be met within 5 % by linear functions, splines and boxes, and is a bound for ddmp,
whose weight of the mean gradient is in between. At A = 0.1 cells are stretched by up to 1 + pi A and it is a bound for
all methods that converge. Orders, by least squares over at least four grids: 1.9 instead of 2 where particles do not
cross or crossing has no effect on the scheme (1.85 and 1.8 with few cells or few particles per cell). Methods whose
force jumps at crossings must fail: their errors grow with finer cells (linear, gimp), or do not fall by half
(quadratic), and are greater than that of the default at 115 cells.
"""
# tiers: smoke, full, long
# timeout: 300

import math

import pytest

import manufactured
import measured

STIFF = (1.0 - 0.3) / ((1.0 + 0.3) * (1.0 - 2.0 * 0.3))   # modulus of a pressure wave over Young's modulus, nu = 0.3
WIDE = (18, 31, 55, 115, 240)
SHORT = (18, 31, 55, 115)
FULL = pytest.mark.tiers("full", "long")


def judge_default(options, sheet):
    """The error of the default is small on all grids."""
    line = manufactured.waves(options, "default", cells=sorted({*WIDE, 24, 42}))
    sheet.below("default: error at 55 cells", line.error(55), manufactured.dispersion("ddmp", 55, amplitude=0.1))
    sheet.above("default: order from 18 to 55", line.order(18, 55), 1.9)
    sheet.require(line.error(240) <= line.error(115) <= line.error(55),
                  "default: the error does not grow to 240 cells")
    return line


@FULL
def test_control(options, sheet):
    """Second order on all grids with the control variate."""
    for ppc in (4, 2):
        line = manufactured.waves(options, "control", words=manufactured.CONTROL, ppc=ppc, cells=WIDE)
        sheet.above(f"control, {ppc} a cell: order", line.order(), 1.9)
        sheet.below(f"control, {ppc} a cell: error at 240 cells", line.error(240),
                    manufactured.dispersion("ddmp", 240, amplitude=0.1))


@FULL
@pytest.mark.parametrize("dimension, cells", [("1d", WIDE), ("plane_strain", (11, 17, 25, 38)), ("3d", (6, 8, 11, 15))])
def test_two_velocities(options, sheet, dimension, cells):
    """Second order with two particles a cell along each direction: `usavg` with its default, the control variate."""
    line = manufactured.waves(options, "usavg", words="stress_update='usavg'", ppc=2, cells=cells, dimension=dimension)
    sheet.above(f"usavg, {dimension}: order", line.order(), 1.9)
    for coarse, fine in zip(cells, cells[1:]):
        order = math.log(line.error(coarse) / line.error(fine)) / math.log(fine / coarse)
        sheet.above(f"usavg, {dimension}: order from {coarse} to {fine} cells", order, 1.9)


def judge_others(options, sheet, default):
    """Methods that fail in this case, and methods that do not."""
    lines = {basis: manufactured.waves(options, basis, "mpm",
                                       f"basis='{basis}'  {manufactured.PLAIN}", cells=SHORT)
             for basis in ("linear", "gimp", "quadratic", "cpgimp", "cpdi", "cubic")}
    sheet.above("linear: growth of the error from 18 to 115", lines["linear"].error(115)
                / lines["linear"].error(18), 1.0)
    sheet.above("gimp: error at 115 over that at 31", lines["gimp"].error(115)
                / lines["gimp"].error(31), 1.0)
    sheet.above("quadratic: error at 115 over that at 55", lines["quadratic"].error(115)
                / lines["quadratic"].error(55), 0.5)
    for basis in ("cpgimp", "cpdi", "cubic"):
        sheet.above(f"{basis}: order", lines[basis].order(), 1.9)
        sheet.below(f"{basis}: error at 115 cells", lines[basis].error(115),
                    manufactured.dispersion(basis, 115, amplitude=0.1))
    for basis in ("linear", "gimp", "quadratic"):
        sheet.above(f"{basis}: error at 115 over that of the default", lines[basis].error(115)
                    / default.error(115), 1.0)


@FULL
def test_small(options, sheet):
    """Without crossings every method is of second order."""
    runs = [("small default", "ddmp", ""), ("small control", "ddmp", manufactured.CONTROL)]
    runs += [(f"small {basis}", "mpm", f"basis='{basis}'")
             for basis in ("linear", "gimp", "cpgimp", "quadratic", "cubic")]
    for name, method, words in runs:
        line = manufactured.waves(options, name, method, words, amplitude=1.0e-4, cells=SHORT)
        sheet.above(f"{name}: order", line.order(), 1.9)
        basis = name.split()[1]
        measured.record(f"{name}.kappa",
                        line.error(115) / manufactured.dispersion("ddmp", 115) * manufactured.KAPPA["ddmp"])
        if basis in manufactured.KAPPA:
            sheet.near(f"{name}: error at 115 cells", line.error(115), manufactured.dispersion(basis, 115), 0.05)
        else:
            sheet.below(f"{name}: error at 115 cells", line.error(115), manufactured.dispersion("ddmp", 115))
            sheet.above(f"{name}: the same", line.error(115), manufactured.dispersion("linear", 115))


@pytest.mark.tiers("long")
def test_table(options, sheet):
    """The methods of the table in doc/theory/verification.md that no other test runs, and 240 cells for all."""
    lines = {}
    for name, method, words, ppc in (
            ("alpha", "ddmp", "alpha_0=0.5", 4), ("sub points", "ddmp", "quadrature='sub_points'", 4),
            ("sub points", "ddmp", "quadrature='sub_points'", 2),
            *((f"table {basis}", "mpm", f"basis='{basis}'  {manufactured.PLAIN}", 4)
              for basis in ("linear", "gimp", "quadratic", "cubic"))):
        lines[name] = manufactured.waves(options, name, method, words, ppc=ppc, cells=WIDE)
    for name in ("alpha", "sub points", "table cubic"):
        sheet.above(f"{name}: order", lines[name].order(), 1.8)
    for basis in ("linear", "gimp", "quadratic"):
        sheet.above(f"{basis}: error at 240 cells over that at 115",
                    lines[f"table {basis}"].error(240) / lines[f"table {basis}"].error(115), 1.0)


@FULL
def test_middle(options, sheet):
    """Few crossings: the amplitude is 2 of 115 cells."""
    for name, words in (("middle default", ""), ("middle control", manufactured.CONTROL)):
        for ppc in (4, 2):
            line = manufactured.waves(options, name, words=words, amplitude=0.02, ppc=ppc, cells=SHORT)
            sheet.above(f"{name}, {ppc} a cell: order", line.order(), 1.85)


@FULL
def test_cube(options, sheet):
    """Three waves with different phases, for a sixth of a period; 2 x 2 x 2 particles per cell."""
    limit, _ = manufactured.forced("ddmp", 19, math.pi / 3.0, STIFF, 0.05)
    for name, words in (("cube default", ""), ("cube control", manufactured.CONTROL)):
        cube = manufactured.waves(options, name, words=words, amplitude=0.05, cells=(6, 9, 13, 19), ppc=2,
                                  dimension="3d", end=manufactured.PERIOD / 6, cfl=0.4)
        sheet.above(f"{name}: order", cube.order(), 1.8)
        sheet.below(f"{name}: error at 19 cells", cube.error(19), limit)


@pytest.mark.tiers("smoke")
def test_few(options, sheet):
    """The runs of the tier smoke."""
    line = manufactured.waves(options, "default", cells=(16, 20, 26, 33))
    for cells in line.cells:
        sheet.below(f"default: error at {cells} cells", line.error(cells),
                    manufactured.dispersion("ddmp", cells, amplitude=0.1))
    sheet.above("default: order from 16 to 33", line.order(), 1.9)


@FULL
def test_waves(options, sheet):
    """The default, and other methods."""
    judge_others(options, sheet, judge_default(options, sheet))
