# SPDX-License-Identifier: BSD-3-Clause
"""Sod's shock tube: two gases at rest with a pressure ratio of ten.

Would catch: bodies without their initial internal energy, an initial pressure that is not that of the equation of
state, a first time step as for a material at rest without pressure, work that does not heat the gas.

G. A. Sod, J. Comput. Phys. 27 (1978) 1: gamma = 1.4, density 1 and pressure 1 beside 0.125 and 0.1.
Exact: p* = 0.3031302, u* = 0.9274526, densities beside the contact 0.4263194 and 0.2655737, shock
1.7521557, head and tail of the fan -1.1832160 and -0.0702728. Four particles a cell, t = 0.2, error of
density as the sum of |rho - exact| times volume.

Limits: the order of the error must be that of the ratio of 0.6 per doubling of the cells that Athena++ requires of a
Godunov method, 0.74. The error may
be 0.011 with 128 cells, that of such methods, and 0.6 of it per doubling: 0.013 with 100 and 0.0084 with 184 cells.
Pressure and velocity between fan and shock: target 1 %. Total energy: rounding, since the energy loss of the transfer
becomes heat.
"""
# tiers: smoke, full

import numpy as np

import case
import convergence
import measured

DECK = """
&run  dimension='1d' /
&units  system='si' /
&grid  lo=0,0,0  hi=1,1,1  dx={spacing} /
&time  t_end=0.2 /
&effects  strength=.false. /
&material  name='dense'  density=1      eos_model='ideal_gas'  ig_gamma=1.4 /
&material  name='thin'   density=0.125  eos_model='ideal_gas'  ig_gamma=1.4 /
&region  name='left'   shape='box'  lo=0,0,0    hi=0.5,1,1 /
&region  name='right'  shape='box'  lo=0.5,0,0  hi=1,1,1 /
&body  name='left'   region='left'   material='dense'  ppc=4,1,1  specific_energy=2.5 /
&body  name='right'  region='right'  material='thin'   ppc=4,1,1  specific_energy=2.0 /
&boundary  face='all'  type='symmetry' /
&output  name='p'  kind='particles'  count=1  precision='double'
  fields='pressure','density','velocity','volume','energy' /
&output  name='h'  kind='history'  every=1 /
"""

TIME, GAMMA = 0.2, 1.4
HEAD, TAIL, CONTACT, SHOCK = -1.1832160, -0.0702728, 0.9274526, 1.7521557
STAR = 0.3031302


def density(place):
    """Exact density at a time of 0.2."""
    speed = (place - 0.5) / TIME
    sound = -HEAD
    fan = (2.0 / (GAMMA + 1.0) - (GAMMA - 1.0) / (GAMMA + 1.0) / sound * speed) ** (2.0 / (GAMMA - 1.0))
    return np.select([speed < HEAD, speed < TAIL, speed < CONTACT, speed < SHOCK],
                     [1.0, fan, 0.4263194, 0.2655737], 0.125)


def burst(options, cells):
    """Error of density, mean pressure and velocity between fan and shock, and the first state."""
    run = case.Case(options, f"sod_{cells}", DECK.format(spacing=1.0 / cells)).run("-q")
    (_, first), (_, last) = run.snapshots()
    place = last.points[:, 0]
    error = (abs(last.fields["density"] - density(place)) * last.fields["volume"]).sum()
    star = (place > 0.54) & (place < 0.8)
    result = {"error": error, "pressure": last.fields["pressure"][star].mean(),
              "velocity": last.fields["velocity"][star, 0].mean(),
              "energy": run.summary["ledger"]["energy_error"],
              "begin": np.unique(first.fields["pressure"].round(12)), "first_dt": run.history["dt"][1],
              "steps": run.summary["steps"]}
    measured.show(f"{cells} cells", {key: result[key] for key in ("error", "pressure", "velocity", "energy", "steps")})
    return result


def test_sod(options, sheet):
    """Four resolutions."""
    runs = {cells: burst(options, cells) for cells in (76, 100, 136, 184)}
    fine = runs[184]
    sheet.require(list(fine["begin"]) == [0.1, 1.0], "the tube starts with both pressures")
    sheet.near("first step", fine["first_dt"], 0.4 / 184 / -HEAD, 1.0e-6)
    for cells, result in runs.items():
        sheet.below(f"error of density with {cells} cells", result["error"], 0.011 * 0.6 ** np.log2(cells / 128))
    order = convergence.order(runs, [result["error"] for result in runs.values()])
    measured.record("order", order)
    sheet.above("order of the error", order, -np.log2(0.6))
    sheet.near("pressure between fan and shock", fine["pressure"], STAR, 0.01)
    sheet.near("velocity between fan and shock", fine["velocity"], CONTACT, 0.01)
    sheet.below("energy", fine["energy"], 1.0e-12)
