# SPDX-License-Identifier: BSD-3-Clause
"""Pressure in the cavity, what the rock gains, and how far it breaks.

    python input/blast_cavity/measure.py --scree build/bin/scree
"""
import sys
from pathlib import Path

import numpy as np

sys.path[:0] = [str(Path(__file__).resolve().parents[2] / folder) for folder in ("scripts", "python/src")]
from scree_post import panel     # noqa: E402
from scree_scene import Study, Table   # noqa: E402

RADIUS = 5.0                           # of the charge [mm]
ENERGY = 7.0e9                       # of TNT in a volume [Pa]
GAS = 1                                # number of the explosive in the field material
TIMES = (6.0e-6, 15.0e-6, 30.0e-6, 60.0e-6)
RINGS = np.arange(10.0, 160.0, 4.0)    # [mm]


def jwl(volume):
    """Pressure of the products of TNT with all of their energy at a volume over that of the charge [Pa]."""
    a, b, r1, r2, omega = 371.2e9, 3.231e9, 4.15, 0.95, 0.3
    return (a * (1.0 - omega / (r1 * volume)) * np.exp(-r1 * volume)
            + b * (1.0 - omega / (r2 * volume)) * np.exp(-r2 * volume) + omega * ENERGY / volume)


def state(snap):
    """Gas, volume over that of the charge, mean pressure [Pa], radii [mm]."""
    gas = snap.fields["material"] == GAS
    volume = snap.fields["volume"]
    charge = 0.25 * np.pi * (1e-3 * RADIUS) ** 2 * 1e-3
    pressure = np.average(snap.fields["pressure"][gas], weights=volume[gas])
    return gas, volume[gas].sum() / charge, pressure, 1e3 * np.hypot(snap.points[:, 0], snap.points[:, 2])


def crushed(snap, gas, radius):
    """Radius up to which nine tenths of the rock have failed [mm]."""
    mass = np.where(gas, 0.0, snap.fields["mass"])
    whole = np.histogram(radius, RINGS, weights=mass)[0]
    failed = np.histogram(radius, RINGS, weights=mass * (snap.fields["failed"] > 0))[0]
    full = np.flatnonzero(failed < 0.9 * whole)
    return RINGS[full[0]] if full.size else RINGS[-1]


def tables(runs):
    """The course of the blast."""
    course = Table(["time [us]", "volume of the gas over the charge", "radius of the cavity [mm]", "pressure [MPa]",
                    "pressure with all energy in the gas [MPa]", "kinetic energy of the rock [J]",
                    "radius within which 90 % of the rock has failed [mm]"])
    for moment in TIMES:
        snap = runs["blast"].near(moment)
        gas, volume, pressure, radius = state(snap)
        speed = np.where(gas, 0.0, (snap.fields["velocity"] ** 2).sum(axis=1))
        course.rows.append([f"{1e6 * snap.time:.0f}", f"{volume:.1f}", f"{RADIUS * np.sqrt(volume):.1f}",
                            f"{1e-6 * pressure:.0f}", f"{1e-6 * jwl(volume):.0f}",
                            f"{0.5 * (snap.fields['mass'] * speed).sum():.1f}", f"{crushed(snap, gas, radius):.0f}"])
    return [course]


def draw(runs, plot):
    """Pressure while the wave runs, and failed rock at the end."""
    figure, panels = plot.subplots(1, 2, figsize=(9.6, 5.0), sharey=True, layout="constrained")
    for axes, (moment, what) in zip(panels, ((15.0e-6, "pressure"), (TIMES[-1], "failed"))):
        snap = runs["blast"].near(moment)
        gas, _, _, _ = state(snap)
        if what == "pressure":
            shown = panel.particles(axes, snap, 1e-6 * snap.fields["pressure"], low=0.0, high=400.0)
            figure.colorbar(shown, ax=axes, label="pressure [MPa]", location="bottom", shrink=0.8, extend="both")
        else:
            failed = ~gas & (snap.fields["failed"] > 0)
            names = {"products": "#d55e00", "failed rock": "#f0c040", "intact rock": "#203050"}
            for chosen, tint in zip((gas, failed, ~gas & ~failed), names.values()):
                panel.particles(axes, snap, tint, rows=chosen)
            figure.legend(handles=panel.patches(names), loc="lower right", bbox_to_anchor=(0.95, 0.06), ncol=3)
        panel.window(axes, (0, 165, 0, 165), "x [mm]", title=f"{1e6 * snap.time:.0f} µs")
    panels[0].set_ylabel("z [mm]")
    return figure


CASES = {"blast": ("scene.nml", {})}

if __name__ == "__main__":
    Study(__file__, CASES, tables, {"picture.png": draw}, as_it_stands="blast").main()
