# SPDX-License-Identifier: BSD-3-Clause
"""Plates that spall.

A plate strikes a plate of the same metal about twice as thick; tension near the rear face of the target tears it.
In one dimension. *Peak* is the stress behind the shock; *spall* is half the density times the bulk speed of sound
times the pull-back of the rear face, by which papers infer the strength; those that take the longitudinal speed
find up to 10 % more. Choice of the constants: the presets as they are; their spall strengths were chosen below the
limit of D. E. Grady (1988), not from these shots.

Causes of the misses. (1) The strengths of the presets, of which the pull-back shows less: where tension is lost at
once, the release from there eats much of the short peak of tension before that arrives at the rear face. With a
strength of 1.2 GPa the pull-back of the copper plates shows 0.70 GPa so, and 0.77, 0.86 and 0.98 GPa if the tension
fades in 20, 50 (the presets) and 100 ns. A separate Lagrangian difference scheme of a fluid with the same equation of
state gives 0.66, 0.87, 1.03 and 1.11 GPa: the law is the cause, not the method. Without `damage` the tension stays at
its limit, and Scree gives 1.29 GPa. (2) In aluminium 6061 the strain to failure of
Johnson and Cook, -0.77 + 1.45 exp(-0.47 s), is negative where mean tension is above 1.35 times the yield stress. With
the least strain `jcd_min` the spall strength decides there, as in a run without that law: 0.89 and 0.90 GPa at 1335
m/s. With a least strain of 1e-6 the plates tore at 0.20 GPa.
"""
import numpy as np

SUBJECT = "metals"
QUANTITIES = {"peak": ("stress behind the shock", "GPa"), "spall": ("spall strength from the pull-back", "GPa")}
CELLS = 200                            # through the target


def measure(run, shot):
    """Means and least value over times after half of the signal, in times in which sound crosses the flyer twice."""
    metal, flyer = run.deck["material"], -run.deck["region"][0]["lo"][0]
    metal = metal[0] if isinstance(metal, list) else metal

    def signal(table, column, factor):
        found = factor * run.tables[table][column].to_numpy()
        time = run.tables[table]["time"].to_numpy()
        begin = time[np.nonzero(found > 0.5 * found.max())[0][0]]
        return (time - begin) * metal["mg_c0"] / (2.0 * flyer), found

    age, stress = signal("inside_gauge", "stress_xx", -1e-9)
    late, rear = signal("gauge", "velocity_x", 1.0)
    pull = np.median(rear[(late > 0.1) & (late < 0.35)]) - rear[(late > 0.4) & (late < 1.25)].min()
    return {"peak": stress[(age > 0.15) & (age < 0.5)].mean(),
            "spall": 0.5e-9 * metal["density"] * metal["mg_c0"] * pull}
