# SPDX-License-Identifier: BSD-3-Clause
"""A clamped beam of nearly incompressible material bends under its weight.

Would catch: locking (without antilock the deflection of the tip is 40 % too small at nu = 0.49 with four cells across),
antilock that reduces the bending stiffness, pressure that jumps from cell to cell.

5 x 1 m, E = 1 MPa, 1000 kg/m3, plane strain, small deflection. The reference is in beams.py: finite elements without
locking for the static deflection, the modes of a beam for the first oscillation. Targets with eight cells across: tip 2
%, jumps of pressure from cell to cell and within a cell 5 % (H-11 in hard_cases.md). With four cells an error of
second order is four times as large, a jump twice. Where there is no locking, at nu = 0.3 without antilock and with
`mpm`, four cells must meet 2 % as well.

Tier long: nu from 0.3 to 0.4999, with and without antilock, on four grids; would catch antilock that works for
one ratio of the moduli only, and errors that do not decrease with the cell size. Wave speeds grow as the root of the
bulk modulus, so the last beams take 20 and 40 thousand steps. The order of the error with antilock must be at least
1.5; without it the deflection must be too small by more than the target from nu = 0.49 on; otherwise antilock is not
needed.
"""
# tiers: full, long
# timeout: 120
# timeout long: 5400

import pytest

import beams
import convergence
import measured

RATIOS = (0.3, 0.49, 0.499, 0.4999)
CELLS = (2, 3, 5, 7)                   # across the beam
TIP, JUMP = 0.02, 0.05                 # targets with cells of 0.125 m
CURE = "antilock='bbar'"


def judge(sheet, options, name, poisson, spacing, far=None, words=CURE, method="ddmp", undamped=None):
    """One beam against its reference; returns its error. A beam without antilock locks from nu = 0.49 on. `undamped`
    gets the jumps of pressure over their target where nothing damps waves of pressure."""
    expected, finer = beams.expected(poisson), spacing / 0.125
    result = beams.bend(options, name, poisson, spacing, words, method)
    error = result["fall"] / expected["fall"] - 1.0
    measured.record(name, {"fall of the tip": error})
    print(f"         {name}: fall of the tip {error:+.4f}, jumps {result['jump']:.3f}, pressures within a cell "
          f"{result['spread']:.3f}, {result['steps']} steps", flush=True)
    sheet.below(f"{name}: momentum", result["momentum"], 1.0e-12)
    if not words and poisson > 0.4:
        sheet.above(f"{name}: locks by", -error, TIP)
        return error
    far = far or TIP * finer ** 2
    sheet.below(f"{name}: fall of the tip", error, far)
    sheet.below(f"{name}: its time", result["when"] / expected["when"] - 1.0, far)
    if words and poisson > 0.4995:
        # Nothing damps waves of pressure with the default of elastic scenes. From half of it on it has no meaning.
        sheet.below(f"{name}: jumps of pressure", result["jump"], 0.5)
        undamped.append(result["jump"] / (JUMP * finer))
    elif spacing > 0.4 and poisson > 0.4:
        # With two cells across the jumps are those of an error of second order: a known miss.
        sheet.known(f"{name}: jumps of pressure", result["jump"], limit=JUMP * finer ** 2, target=JUMP * finer)
    else:
        sheet.below(f"{name}: jumps of pressure", result["jump"], JUMP * finer)
    if words:
        sheet.below(f"{name}: pressures within a cell", result["spread"], JUMP * finer)
    return error


@pytest.mark.tiers("long")
def test_study(options, sheet):
    """All ratios of the moduli, with and without antilock, four cell sizes."""
    options.timeout = 1500
    undamped = []
    for poisson in RATIOS:
        for words in ("", CURE):
            errors = [judge(sheet, options, f"{'even' if words else 'plain'}_{poisson}_{cells}", poisson, 1.0 / cells,
                            words=words, undamped=undamped) for cells in CELLS]
            if words:
                sheet.above(f"nu = {poisson}: order", convergence.order(CELLS, errors), 1.5)
    # half of the pressure over the target of the finest beam
    sheet.known("nu = 0.4999: jumps of pressure over their target, the worst", max(undamped),
                limit=0.5 / (JUMP * 8.0 / CELLS[-1]), target=1.0)


def test_reference(sheet):
    sheet.near("reference: at rest over that of Timoshenko", beams.elements(0.3),
               beams.timoshenko(0.3), 0.02)


@pytest.mark.parametrize("name, poisson, spacing, more", [
    ("plain_3", 0.3, 0.25, {"far": TIP, "words": ""}),
    ("plain_49", 0.49, 0.25, {"words": ""}),
    ("even_49_mpm", 0.49, 0.25, {"far": TIP, "method": "mpm"}),
    *((f"even_{poisson}_{spacing}", poisson, spacing, {}) for poisson in (0.3, 0.49) for spacing in (0.25, 0.125)),
])
def test_beam(options, sheet, name, poisson, spacing, more):
    """Coarse beams, one with eight cells across, one without antilock."""
    judge(sheet, options, name, poisson, spacing, **more)
