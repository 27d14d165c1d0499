# SPDX-License-Identifier: BSD-3-Clause
"""TNT in water.

A sphere of TNT explodes in deep water. Axisymmetric quarter, ignited at the centre. *Peak* is the greatest pressure
at the distance, *impulse* its integral over the decay time of the law, means of three gauges between axis and
equator. Data: the law that T. L. Geers and K. S. Hunter (2002) give for measured waves of TNT, a fit through many
charges whose scatter was not read. Linear viscosity 0.5: with the default of 0.06 the pressure behind the shock rings.
Choice of the constants: the products of the preset `tnt` were fitted to expanding cylinders; water: Tait's equation
with an exponent of 7 and a bulk modulus of 2.2 GPa. Nothing was fitted to waves in water.
"""
import numpy as np

SUBJECT = "impacts"
QUANTITIES = {"peak": ("greatest pressure", "MPa"), "impulse": ("impulse of the first wave", "kPa s")}
CELLS = 12                             # in the radius of the charge
COARSER = 1.5


def measure(run, shot):
    """Means of the three gauges; the impulse from the time of half of the peak over the decay time of the law."""
    last, found = float(shot["decay"].split()[0]), []
    for name in ("gauge", "mid_gauge", "high_gauge"):
        table = run.tables[name]
        time, pressure = 1e3 * table["time"].to_numpy(), 1e-6 * table["pressure"].to_numpy()
        begin = time[np.nonzero(pressure > 0.5 * pressure.max())[0][0]]
        inside = (time >= begin) & (time <= begin + last)
        found.append((pressure.max(), np.trapezoid(pressure[inside], time[inside])))
    return dict(zip(("peak", "impulse"), np.mean(found, axis=0)))
