# SPDX-License-Identifier: BSD-3-Clause
"""Brittle plates in plane strain, and bars in one dimension, on grids of three thicknesses.

Would catch: a thickness of the grid that does not count in the volume on which strength depends, or that counts twice
or for one model only; strength that does not scatter at all.

A body moves away from a wall that holds it, and the tension breaks it at the weakest of its particles. A slice n times
as thick (a bar of n times the cross-section) has n times the flaws, so it breaks the same particles if the given
strength is n**(1/m) times as high (Weibull), or if there are 1/n of the flaws per volume and cracks that must grow
through n times the volume are n**(1/3) times as fast (Grady and Kipp). With the same constants more particles break.
The masses differ by rounding, so damage that is still growing may differ by that, magnified: limit 1e-6.
"""
# tiers: smoke, full

import numpy as np
import pytest

import case

DECK = """
&run  dimension='{dimension}' /
&grid  lo=0,0,0  hi={hi}  dx=1e-3 /
&time  t_end=4e-6 /
&effects  damage=.true.  size_scatter=.true. /
&material  name='glass'  density=2500  bulk=45e9  shear=30e9  eos_model='linear'  {model} /
&region  name='plate'  shape='box'  lo=0,0,0  hi={body} /
&body  name='plate'  region='plate'  material='glass'  ppc={ppc}  velocity={velocity} /
&boundary  face='{face}'  type='stick' /
&output  name='p'  kind='particles'  count=1  precision='double'  fields='damage','scatter','identity' /
"""
#: The wave strains by 3.5e-3. The thinnest slices have flaws that grow at a mean strain of 3.2e-3. Weibull: a mean
#: strength of 250 MPa, of 290 MPa in the wave.
MODELS = {"grady_kipp": "damage_model='grady_kipp'  weibull_k={k:.17g}  weibull_m=6  crack_speed={speed:.17g}",
          "weibull": "damage_model='principal_stress'  failure_stress={stress:.17g}  weibull_m=6  "
                     "weibull_volume={volume}"}
SHAPES = {"plane_strain": {"hi": "8e-3,{0},12e-3", "body": "8e-3,{0},9e-3", "ppc": "2,1,2", "velocity": "0,0,20",
                           "face": "zlo"},
          "1d": {"hi": "24e-3,{0},{0}", "body": "20e-3,{0},{0}", "ppc": "2,1,1", "velocity": "20,0,0", "face": "xlo"}}
THICKNESSES = (0.3e-3, 1.0e-3, 4.0e-3)                          # [m], none a multiple of another


def run_slice(options, name, dimension, thickness, model, more):
    """Damage and strength of the particles after the run, with constants for `more` times the flaws of the first."""
    keys = {key: word.format(thickness) for key, word in SHAPES[dimension].items()}
    volume = 0.5e-3 * THICKNESSES[0] * (0.5e-3 if dimension == "plane_strain" else THICKNESSES[0])
    constants = MODELS[model].format(k=9.3e14 / volume / more, speed=0.15 * more ** (1.0 / 3.0), volume=volume,
                                     stress=250.0e6 * more ** (1.0 / 6.0))
    run = case.Case(options, name, DECK.format(dimension=dimension, model=constants, **keys)).run("-q")
    last = run.snapshots()[-1][1]
    order = np.argsort(last.fields["identity"])
    return last.fields["damage"][order], last.fields["scatter"][order]


@pytest.mark.parametrize("dimension", tuple(SHAPES))
@pytest.mark.parametrize("model", tuple(MODELS))
def test_thickness(options, sheet, model, dimension):
    """The damage of every particle, for each thickness against the first."""
    first, strength = run_slice(options, "first", dimension, THICKNESSES[0], model, 1.0)
    broken = np.mean(first >= 1.0)
    sheet.require(0.0 < broken < 0.9, "some particles break and some do not")
    for thickness in THICKNESSES[1:]:
        more = (thickness / THICKNESSES[0]) ** (1 if dimension == "plane_strain" else 2)
        damage, _ = run_slice(options, f"{thickness:g}", dimension, thickness, model, more)
        sheet.below(f"{thickness:g} m: change of the damage", np.abs(damage - first).max(), 1.0e-6)
    more = (THICKNESSES[1] / THICKNESSES[0]) ** (1 if dimension == "plane_strain" else 2)
    _, weak = run_slice(options, "weak", dimension, THICKNESSES[1], model, 1.0)
    sheet.below("strength of a thicker slice of the same constants against n**(-1/m)",
                np.abs(weak / strength * more ** (1.0 / 6.0) - 1.0).max(), 1.0e-12)
