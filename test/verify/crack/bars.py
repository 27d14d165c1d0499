# SPDX-License-Identifier: BSD-3-Clause
"""Bars of concrete that are pulled until they break, for tests and figures.

E = 30 GPa, strength 3 MPa, but 2.7 MPa in one cell in the middle, where the crack opens, 100 J/m2. The bar of 0.4 m is
fixed at a symmetry plane and pulled by a wall at 0.01 m/s, 4 wave transits per mm/s of its speed.
"""

import case

ENERGY, WEAK, YOUNG, LENGTH = 100.0, 2.7e6, 30.0e9, 0.4

DECK = """
&run  dimension='{dimension}'  method='{method}' /
&method  {words} /
&grid  lo=0,{ylo},{zlo}  hi=0.4,{yhi},{zhi}  dx={h!r} /
&time  t_end={end!r} /
&effects  damage=.true.  artificial_viscosity=.false.  {effects} /
&material  name='m'     density=2400  {law}  damage_model='principal_stress'
  failure_stress=3.0e6  fracture_energy=100  softening='{curve}' /
&material  name='weak'  density=2400  {law}  damage_model='principal_stress'
  failure_stress=2.7e6  fracture_energy=100  softening='{curve}' /
&region  name='a'  shape='box'  lo=0,{ya},{za}      hi=0.2,{yb},{zb} /
&region  name='b'  shape='box'  lo=0.2,{ya},{za}    hi={right!r},{yb},{zb} /
&region  name='c'  shape='box'  lo={right!r},{ya},{za}  hi=0.4,{yb},{zb} /
&body  name='a'  region='a'  material='m'     ppc={ppc} /
&body  name='b'  region='b'  material='weak'  ppc={ppc} /
&body  name='c'  region='c'  material='m'     ppc={ppc} /
&boundary  face='xlo'  type='symmetry' /
&boundary  face='xhi'  type='velocity'  velocity={speed},0,0 /
&output  name='h'  kind='history'  every=20 /
&output  name='p'  kind='particles'  count=1  precision='double'  fields='damage','failed','stress','volume' /
&checkpoint  at_end=.false. /
"""


def pull(options, name, cells=8, dimension="1d", ppc=2, poisson=0.0, speed=0.01, end=0.014, thick=0.1, **words):
    """One bar: energy of its crack per area, and the run.

    `cells` along the bar; in planes and in 3-D it has the thickness `thick` [m] with a free cell around it.
    """
    h = LENGTH / cells
    moduli = f"young=30e9  poisson={poisson}"
    side = {"1d": (0, 0, 1.0, 1.0), "plane_strain": (0.0, h, 1.0, thick), "3d": (h, h, thick, thick)}[dimension]
    per_cell = {"1d": f"{ppc},1,1", "plane_strain": f"{ppc},1,{ppc}", "3d": f"{ppc},{ppc},{ppc}"}[dimension]
    run = case.Case(options, name, DECK.format(
        dimension=dimension, method=words.get("method", "ddmp"), words=words.get("words", ""), h=h, end=end,
        speed=speed, effects=words.get("effects", ""), law=words.get("law", moduli),
        curve=words.get("curve", "linear"), right=0.2 + h, ppc=per_cell, ylo=0, zlo=0, yhi=repr(2 * side[0] + side[2]),
        zhi=repr(2 * side[1] + side[3]), ya=repr(side[0]), yb=repr(side[0] + side[2]), za=repr(side[1]),
        zb=repr(side[1] + side[3]))).run("-q")
    area = side[2] * side[3]
    history = run.history
    return {"energy": float(history["plastic"][-1]) / area, "area": area, "run": run, "history": history,
            "ledger": run.summary["ledger"], "failed": float(run.snapshots()[-1][1].fields["failed"].sum())}


def load(result, speed=0.01):
    """Displacement [m] of the end and load per area [Pa], from the work of the wall over small increments of the
    displacement."""
    history = result["history"]
    way = history["time"] * speed
    gain = (history["external_work"][4:] - history["external_work"][:-4]) / (way[4:] - way[:-4])
    return way[2:-2], gain / result["area"]


def exact(way):
    """Load per area of a bar whose crack follows the linear curve, as a function of the displacement of its end."""
    peak, last = WEAK * LENGTH / YOUNG, 2.0 * ENERGY / WEAK
    opening = (way - peak) / (1.0 - peak / last)
    return [YOUNG / LENGTH * x if x < peak else max(0.0, WEAK * (1.0 - o / last)) for x, o in zip(way, opening)]
