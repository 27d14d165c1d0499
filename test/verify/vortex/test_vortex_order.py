# SPDX-License-Identifier: BSD-3-Clause
"""The vortex with DDMP: order of convergence, and the error compared with that of quadratic splines.

Would catch: gradients that lose their order where a ring rotates and shears across the cells, a mean stress that is
truncated wrongly at free rims, linear velocity fields that are not rotated with the material, rims with a wrong volume
(the ring then drifts as a whole).

Greatest error in the run over the greatest displacement, 10, 12, 14 and 18 cells a unit of length, which
are half as many across the width of the ring, 4 x 4 particles per cell, particles cut at the rims. The errors are in
doc/theory/verification.md; half of the improvement is due to the transfer.

Limits: order 1.8 by least squares; 5 % with 10 cells, the error down to which second order is required, and on all
grids that error changed at order 1.8; a third of the error of quadratic splines with their defaults at 18 cells, which
is the target. A twist of 1 misses all of them and does not converge: known misses.
Errors are held at 10 %, twice the limit with 10 cells, growth at the square of the cells, as of noise in two
dimensions. On 10 and 20 cells, the second twice as fine as the first, it seems to be of second order. When the ring
rotates back from a twist of 1, DDMP fails, and so do quadratic splines; see doc/theory/verification.md.
"""
# tiers: full, long
# timeout: 200
# timeout long: 900

import pytest

import manufactured


@pytest.mark.parametrize("transfer, twist, end", [
    ("aflip", 0.3, 1.0),
    ("apic", 1.0, 0.5),
])
def test_judge(options, sheet, transfer, twist, end):
    """DDMP compared with quadratic splines."""
    setting = {"twist": twist, "end": end, "ppc": 4, "body": "packing='cut'"}
    dual = manufactured.vortex(options, f"ddmp {transfer}", words=f"{manufactured.CONTROL}  "
                               f"transfer='{transfer}'", **setting)
    spline = manufactured.vortex(options, "quadratic", "mpm", "basis='quadratic'", cells=(18,), **setting)
    ratio = f"twist {twist}: error over that of quadratic splines", dual.error(18) / spline.error(18)
    known = twist == 1.0
    if known:
        sheet.known(f"twist {twist}: 1.8 less the order", max(0.0, 1.8 - dual.order()), limit=3.8, target=0.0)
        sheet.known(*ratio, limit=10.0, target=1.0 / 3.0)
    else:
        sheet.above(f"twist {twist}: order", dual.order(), 1.8)
        sheet.below(*ratio, 1.0 / 3.0)
    for cells in dual.cells:
        name, limit = f"twist {twist}: error at {cells} cells", 0.05 * (10.0 / cells) ** 1.8
        if known:
            sheet.known(name, dual.error(cells), limit=0.1, target=limit)
        else:
            sheet.below(name, dual.error(cells), limit)
    sheet.above(f"twist {twist}: error of quadratic splines", spline.error(18), 0.01)


ROWS = {"ddmp": ("ddmp", ""), "ddmp aflip": ("ddmp", "transfer='aflip'"), "control": ("ddmp", manufactured.CONTROL),
        "quadratic flip": ("mpm", "basis='quadratic'  transfer='flip'"),
        "quadratic rflip": ("mpm", "basis='quadratic'  transfer='rflip'")}


@pytest.mark.tiers("long")
@pytest.mark.parametrize("twist", [0.1, 0.3])
def test_table(options, sheet, twist):
    """The table of doc/theory/verification.md: a whole period, 3 x 3 particles."""
    lines = {name: manufactured.vortex(options, name, method, words, twist=twist, body="packing='cut'", may_fail=True)
             for name, (method, words) in ROWS.items()}
    for name in ("control", "quadratic flip", "quadratic rflip"):
        if (name, twist) == ("control", 0.1):
            sheet.known(f"{name}, twist {twist}: 1.8 less the order", 1.8 - lines[name].order(), limit=0.3, target=0.0)
        else:
            sheet.above(f"{name}, twist {twist}: order", lines[name].order(), 1.8)


@pytest.mark.tiers("long")
@pytest.mark.parametrize("transfer, twist, end", [("aflip", 0.3, 1.0), ("apic", 1.0, 0.5)])
def test_affine_splines(options, sheet, transfer, twist, end):
    """Quadratic splines with the transfer of test_judge: half of the improvement is due to the transfer."""
    line = manufactured.vortex(options, f"quadratic {transfer}", "mpm", f"basis='quadratic'  transfer='{transfer}'",
                               twist=twist, end=end, ppc=4, body="packing='cut'", cells=(20,))
    sheet.below(f"quadratic {transfer}, twist {twist}: error at 20 cells", line.error(20), 0.02)
