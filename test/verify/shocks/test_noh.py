# SPDX-License-Identifier: BSD-3-Clause
"""Cold gas that converges to a plane, to an axis and to a point: Noh's problem.

Would catch: artificial viscosity that heats smoothly converging gas ahead of the shock; a hoop strain that counts as a
jump; a limiter that leaves the shock itself without viscosity.

W. F. Noh, J. Comput. Phys. 72 (1987) 78: gas of gamma = 5/3 without pressure, density 1 and speed 1. A shock goes out
with the speed 1/3; behind it the density is 4^d at rest, ahead of it (1 + t/r)^(d - 1), d = 1, 2, 3. Particles are
regular in radius and angle, unlike the grid. 100 cells per unit of length, until 0.6.

Limits. Behind the shock, from a quarter to 0.8 of its radius: the target for the axis is 10 % in density; for the plane
1 %, as in test_riemann.py. Ahead of it the flow is smooth and the target is 2 %, the change of (1 + t/r)^2 over half a
cell, 2 h/(r + t) at most. If viscosity resists all compression, it heats by (d - 1)^3 q2 h^2/(2 r^2) on the way to r,
work q D/rho of D = (d - 1)/r; the limiter must remove nine tenths of it. The scatter behind the shock must not be
larger with it. Known misses: the density behind the shock, held at (d - 1) times six cells over the radius of the
shock, the time that gas is hot before its convergence ends if a shock is six cells wide (H-10); without limiter at 1
for the sphere; in 1-D at twice the target.
"""
# tiers: full
# timeout: 600

import numpy as np
import pytest

import case
import measured

DECK = """
&run  dimension='{dimension}' /
&units  system='si' /
&grid  lo=0,0,0  hi={hi}  dx={size!r} /
&time  t_end=0.6  cfl=0.4 /
&method  {words} /
&effects  strength=.false. /
&material  name='gas'  density=1  eos_model='ideal_gas'  ig_gamma=1.6666666666666667 /
&region  name='gas'  shape='points'  file='gas.csv' /
&body  name='gas'  region='gas'  material='gas'  packing='file'  specific_energy=1e-9 /
&boundary  face='all'  type='slip' /
&output  name='p'  kind='particles'  count=1  precision='double'
  fields='pressure','density','velocity','volume','energy','mass' /
&output  name='h'  kind='history'  every=50 /
&checkpoint  at_end=.false. /
"""
END, SHOCK = 0.6, 0.2
PLAIN = "normalise='none'"
SMOOTH = "viscosity_limiter='smooth'"
BEST = "viscosity_limiter='smooth'  bulk_q2=2  heat_flux=2"
# Known misses of the density: the error due to a shock of six cells that began at the axis, d - 1 times 6 h over R
LIMITS = {1: (None, 0.02, 0.02), 2: (0.3, 0.3, None), 3: (1.0, 0.6, 0.6)}


def points(shape, cells, per_cell):
    """Positions, volumes and velocities of a converging gas with a radius of 1."""
    size = 1.0 / cells / per_cell
    if shape == "tube":                                  # rings of a slab 4 cells thick
        r = (np.arange(round(1.0 / size)) + 0.5) * size
        z = (np.arange(4 * per_cell) + 0.5) * size
        r, z = (a.ravel() for a in np.meshgrid(r, z))
        return np.column_stack((r, 0 * r, z, 2 * np.pi * r * size ** 2, -1 + 0 * r, 0 * r, 0 * r))
    if shape == "line":
        r = (np.arange(round(1.0 / size)) + 0.5) * size
        return np.column_stack((r, 0 * r, 0 * r, size + 0 * r, -1 + 0 * r, 0 * r, 0 * r))
    x = (np.arange(round(1.0 / size)) + 0.5) * size
    x, z = (a.ravel() for a in np.meshgrid(x, x))
    r = np.hypot(x, z)
    x, z, r = x[r < 1], z[r < 1], r[r < 1]
    volume = size ** 2 * (2 * np.pi * x if shape == "sphere" else 1.0 + 0 * x)
    return np.column_stack((x, 0 * x, z, volume, -x / r, 0 * x, -z / r))


SHAPES = {"line": ("1d", "1,1,1", 1), "plane": ("plane_strain", "1,1,1", 2),
          "tube": ("axisymmetric", "1,0,{slab!r}", 2),
          "sphere": ("axisymmetric", "1,0,1", 3)}


def noh(options, shape, cells=100, words="", per_cell=2, name=None):
    """Run a shape; its errors."""
    dimension, hi, d = SHAPES[shape]
    run = case.Case(options, name or shape, DECK.format(dimension=dimension, hi=hi.format(slab=4.0 / cells),
                                                        size=1.0 / cells, words=words))
    table = points(shape, cells, per_cell)
    np.savetxt(run.folder / "gas.csv", table, delimiter=",", header="x,y,z,volume,vx,vy,vz", comments="", fmt="%.17g")
    run.run("-q", timeout=900)
    snap = run.snapshots()[-1][1]
    place = snap.points
    r = place[:, 0] if shape in ("line", "tube") else np.hypot(place[:, 0], place[:, 2])
    density, volume, mass = (snap.fields[key] for key in ("density", "volume", "mass"))
    behind = (r > 0.25 * SHOCK) & (r < 0.8 * SHOCK)
    ahead = (r > 1.4 * SHOCK) & (r < 0.36)
    exact = (1.0 + END / r) ** (d - 1)
    # mass over volume, so that neither empty nor crowded regions are counted twice
    result = {"behind": mass[behind].sum() / volume[behind].sum() / 4.0 ** d - 1.0, "count": int(behind.sum()),
              "spread": density[behind].std() / density[behind].mean(),
              "ahead": (density[ahead] / exact[ahead]).mean() - 1.0,
              "heat": snap.fields["energy"][ahead].mean() / 0.5,
              "centre": density[r < 0.25 * SHOCK].mean() / 4.0 ** d - 1.0,
              "peak": density.max() / 4.0 ** d - 1.0,
              "volume": (mass[r < 0.8 * SHOCK].sum() / space(shape, 0.8 * SHOCK, cells)) / 4.0 ** d - 1.0,
              "energy": run.summary["ledger"]["energy_error"], "steps": run.summary["steps"]}
    measured.show(name or shape, result)
    return result


def space(shape, radius, cells):
    """Volume within a radius."""
    return {"line": radius, "plane": np.pi / 4 * radius ** 2, "tube": np.pi * radius ** 2 * 4 / cells,
            "sphere": 2 / 3 * np.pi * radius ** 3}[shape]


@pytest.mark.parametrize("shape", SHAPES)
def test_noh(options, sheet, shape):
    """The shapes with plain sums, without and with the limiter, and with all improvements. With normalised sums the
    limiter is not used, so it is tested with plain ones."""
    _, _, d = SHAPES[shape]
    plain, smooth, best = (noh(options, shape, words=words, name=f"{shape}_{number}")
                           for number, words in enumerate((PLAIN, SMOOTH, BEST)))
    target = 0.01 if shape == "line" else 0.1
    for name, result, held in (("plain", plain, LIMITS[d][0]), ("smooth", smooth, LIMITS[d][1]),
                               ("smooth, heat flux", best, LIMITS[d][2])):
        sheet.require(result["count"] > 20 * d, f"{shape}, {name}: particles behind the shock")
        if held is None:
            sheet.below(f"{shape}, {name}: density behind the shock", result["behind"], target)
        else:
            sheet.known(f"{shape}, {name}: density behind the shock", result["behind"], limit=held, target=target)
        sheet.below(f"{shape}, {name}: energy", result["energy"], 1.0e-12)
    for name, result in (("smooth", smooth), ("smooth, heat flux", best)):
        sheet.below(f"{shape}, {name}: density ahead of the shock", result["ahead"], 0.02)
        if d > 1:
            heated = (d - 1) ** 3 * 4.0 * 1.0e-4 / (2.0 * 0.3 ** 2)
            sheet.below(f"{shape}, {name}: energy ahead of the shock [1/2]", result["heat"], 0.1 * heated / 0.5)
    sheet.below(f"{shape}: scatter of density with the limiter over that without",
                smooth["spread"] / plain["spread"], 1.0)
