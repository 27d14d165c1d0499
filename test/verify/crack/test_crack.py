# SPDX-License-Identifier: BSD-3-Clause
"""The energy that a crack dissipates per area, for cell sizes of h to h/8.

Would catch: softening that does not depend correctly on the cell size, the crack band of the basis, the direction of
the crack or the number of particles in a cell; a crack that dissipates its energy twice because two bands open; energy
that is not recorded; a crack whose energy depends on its direction; a deck with cells too large for the material that
is accepted.

A bar is fixed at one end, and the other end is pulled slowly. With 100 J/m2, E = 30 GPa and 2.7 MPa in its weakest cell
the load rises to 2.7 MPa at 36 um and, with the linear curve, vanishes at 74 um. The energy of the crack is the
recorded plastic work, because nothing flows.

Limits. Energy: target 10 % for all (H-22 in hard_cases.md), 2 % where the band is as wide as the crack band
theory says, which holds for bases of points of one cell. Load against the curve, mean error over the strength: target 2
%. With an internal energy the balance closes to rounding; without, it lacks the damping of the transfer: target 1 %.
With ddmp, whose gradient strains particles beside the crack too, the load is a known miss, held at 10 %, and the energy
with four particles per cell is held at twice the target.

A bar oblique to the grid is torn by its two halves, which move apart. Crack bands prefer the axes of the grid, a known
limitation of all crack band methods (J. G. Rots, thesis, Delft 1988): at 20 and 45 degrees the energy misses its
target, and is held at twice that.
"""
# tiers: smoke, full
# timeout: 180

import numpy as np
import pytest

import bars
import case
import measured
import tier

TARGET = 0.1                           # of the energy of a crack
CLOSE = 0.02                           # of the energy where the width of the band is known, and of the load

HEAT = "eos_model='mie_gruneisen'  mg_c0=2500  mg_s=1.3  mg_gamma=1  shear=12.5e9  specific_heat=800"

OBLIQUE = """
&run  dimension='plane_strain'  method='{method}' /
&grid  lo=-0.3,0,-0.3  hi=0.3,1,0.3  dx=0.0125 /
&time  t_end=0.0004 /
&effects  damage=.true.  artificial_viscosity=.false. /
&material  name='m'     density=2400  young=30e9  poisson=0.2 /
&material  name='weak'  density=2400  young=30e9  poisson=0.2  damage_model='principal_stress'
  failure_stress=2.7e6  fracture_energy=100 /
&region  name='a'  shape='box'  lo=-0.2,0,-0.05      hi=-0.01875,1,0.05  rotate=0,{angle},0 /
&region  name='b'  shape='box'  lo=-0.01875,0,-0.05  hi=0,1,0.05         rotate=0,{angle},0 /
&region  name='c'  shape='box'  lo=0,0,-0.05         hi=0.2,1,0.05       rotate=0,{angle},0 /
&body  name='a'  region='a'  material='m'     ppc=2,1,2  packing='cut'  velocity={left} /
&body  name='b'  region='b'  material='weak'  ppc=2,1,2  packing='cut'  velocity={left} /
&body  name='c'  region='c'  material='m'     ppc=2,1,2  packing='cut'  velocity={right} /
&output  name='h'  kind='history'  every=20 /
&checkpoint  at_end=.false. /
"""

# concrete is thrown apart with three times the energy of the cracks in all of its cells
CONE = """
&run  dimension='1d' /
&grid  lo=0,0,0  hi=0.03,0.0005,0.0005  dx=0.0005 /
&time  t_end=40e-6 /
&effects  damage=.true. /
&material  name='m'  preset='concrete_c40' /
&region  name='bar'  shape='box'  lo=0.012,0,0  hi=0.018,1,1 /
&body  name='b'  region='bar'  material='m'  velocity_formula='10000*(x - 0.015)','0','0' /
&output  name='h'  kind='history'  every=20 /
&checkpoint  at_end=.false. /
"""


def test_cells(options, sheet):
    """Four cell sizes, and the load of the last three against the curve."""
    for method, words, ppc, least in (("mpm", "", 2, 8), ("ddmp", "", 2, 8), ("ddmp", "", 4, 8),
                                      ("mpm", "basis='gimp'", 4, 8)):
        label = f"{words[7:-1] or method}, {ppc} a cell"
        energies, loads = [], []
        if tier.NAME == "smoke" and (ppc == 4 or words):
            continue
        for count in tier.choose((8, 16, 32, 64), smoke=(8, 16)):
            if count == 64 and (ppc == 4 or words):
                continue
            result = bars.pull(options, f"bar_{label[:4]}_{ppc}_{count}".replace(",", ""), cells=count, method=method,
                               words=words, ppc=ppc)
            energies.append(result["energy"] / bars.ENERGY - 1.0)
            way, load = bars.load(result)
            loads.append(np.abs(load - np.array(bars.exact(way))).mean() / bars.WEAK)
            measured.show(f"{label}, {count} cells", {"energy": result["energy"], "load": loads[-1]})
            sheet.below(f"{label}, {count} cells: energy that is in no books", result["ledger"]["energy_error"], 0.01)
            sheet.require(result["failed"] == ppc, f"{label}, {count} cells: one cell breaks")
        worst = max(energies, key=abs)
        if method == "mpm":
            sheet.below(f"{label}: error of the energy, the worst", worst, CLOSE)
            sheet.below(f"{label}: mean error of the load over the strength, the worst", max(loads), CLOSE)
            continue
        if ppc == 2:
            sheet.below(f"{label}: error of the energy, the worst", worst, TARGET)
            sheet.below(f"{label}: the same, finest over coarsest", energies[-1] / energies[0], 0.5)
        else:
            sheet.known(f"{label}: error of the energy, the worst", worst, limit=2.0 * TARGET, target=TARGET)
        sheet.known(f"{label}: mean error of the load over the strength, the worst", max(loads), limit=0.1,
                    target=CLOSE)


@pytest.mark.tiers("full", "long")
def test_others(options, sheet):
    """Planes and 3-D, smoother functions, the other curve, and an internal energy."""
    fast = {"speed": 0.02, "end": 0.007, "poisson": 0.2}
    for name, words in (("plane", {"dimension": "plane_strain", **fast}), ("space", {"dimension": "3d", **fast})):
        for method, limit in (("mpm", CLOSE), ("ddmp", TARGET)):
            result = bars.pull(options, f"{name}_{method}", method=method, **words)
            sheet.near(f"{name}, {method}: energy of the crack", result["energy"], bars.ENERGY, limit)
    for basis in ("quadratic", "cubic"):
        result = bars.pull(options, basis, method="mpm", words=f"basis='{basis}'", cells=16, end=0.02)
        sheet.near(f"{basis}: energy of the crack", result["energy"], bars.ENERGY, TARGET)
    result = bars.pull(options, "curve", method="mpm", cells=16, curve="exponential", end=0.03)
    sheet.near("exponential: energy of the crack", result["energy"], bars.ENERGY, TARGET)
    for method in ("mpm", "ddmp"):
        result = bars.pull(options, f"heat_{method}", method=method, cells=16, law=HEAT, effects="thermal=.true.")
        off = result["energy"] / bars.ENERGY - 1.0
        title = f"with internal energy, {method}: error of the energy of the crack"
        if method == "ddmp":
            sheet.known(title, off, limit=2.0 * TARGET, target=TARGET)
        else:
            sheet.below(title, off, TARGET)
        sheet.below(f"with internal energy, {method}: energy in no books", result["ledger"]["energy_error"], 1.0e-13)


@pytest.mark.tiers("full", "long")
def test_oblique(options, sheet):
    """Cracks in directions other than those of the grid."""
    for angle in (0, 20, 45):
        turn = np.radians(angle)
        ahead = f"{0.8 * np.cos(turn)!s},0,{-0.8 * np.sin(turn)!s}"
        back = f"{-0.8 * np.cos(turn)!s},0,{0.8 * np.sin(turn)!s}"
        run = case.Case(options, f"oblique_{angle}", OBLIQUE.format(method="mpm", angle=angle, left=back,
                                                                    right=ahead)).run("-q")
        off = float(run.history["plastic"][-1]) / 0.1 / bars.ENERGY - 1.0
        sheet.below(f"oblique by {angle} degrees: momentum", run.summary["ledger"]["momentum_error"], 1.0e-13)
        if angle:
            sheet.known(f"oblique by {angle} degrees: error of the energy", off, limit=2.0 * TARGET, target=TARGET)
        else:
            sheet.below(f"oblique by {angle} degrees: error of the energy", off, TARGET)


def test_cone(options, sheet):
    """Would catch a cone whose apex bounds the stress without cracks: they would stop opening, the bar would never
    break, and energy would be made. Limits: half of the bar fails; the energy balance closes to 1 %; the recorded
    plastic work is at most that of a crack in each of the 12 cells."""
    run = case.Case(options, "cone", CONE).run("-q")
    last = {name: float(values[-1]) for name, values in run.history.items()}
    sheet.above("cone: failed part of the bar", last["failed_mass"] / last["mass"], 0.5)
    sheet.below("cone: error of energy", last["energy_error"], CLOSE / 2)
    sheet.below("cone: plastic work over that of all cracks", last["plastic"] / (12 * 93.5 * 0.0005**2), 1.0)


def test_too_large(options, sheet):
    """A cell beyond 2 E Gf/f^2 is refused, and the message states the allowed size."""
    deck = bars.DECK.replace("fracture_energy=100", "fracture_energy=5").format(
        dimension="1d", method="mpm", words="", h=0.05, end=0.01, speed=0.01, effects="",
        law="young=30e9  poisson=0", curve="linear", right=0.25, ppc="2,1,1", ylo=0, zlo=0, yhi=1, zhi=1, ya=0, yb=1,
        za=0, zb=1)
    run = case.Case(options, "large", deck).run("--check", expect=2)
    sheet.require("dx must be at most 0.0333333 m" in run.output, "too large a cell is refused, and the limit named")
