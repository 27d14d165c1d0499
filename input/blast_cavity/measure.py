# SPDX-License-Identifier: BSD-3-Clause
"""Pressure in the cavity, what the rock gains, and how far it breaks.

    python input/blast_cavity/measure.py --scree build/bin/scree
"""
import sys
from pathlib import Path

import numpy as np

sys.path[:0] = [str(Path(__file__).resolve().parents[2] / folder) for folder in ("scripts", "python/src")]
from scree_scene import Study, Table   # noqa: E402

RADIUS = 5.0                           # of the charge [mm]
ENERGY = 6.993e9                       # of TNT in a volume [Pa]
GAS = 1                                # number of the explosive in the field material
TIMES = (6.0e-6, 15.0e-6, 30.0e-6, 60.0e-6)
RINGS = np.arange(10.0, 160.0, 4.0)    # [mm]


def jwl(volume):
    """Pressure of the products of TNT with all of their energy at a volume over that of the charge [Pa]."""
    a, b, r1, r2, omega = 371.2e9, 3.21e9, 4.15, 0.95, 0.3
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
                    "with all energy in the gas [MPa]", "kinetic energy of the rock [J]",
                    "nine tenths of the rock have failed up to [mm]"])
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
    figure, panels = plot.subplots(1, 2, figsize=(12.0, 5.4), layout="constrained")
    for panel, (moment, what) in zip(panels, ((15.0e-6, "pressure"), (TIMES[-1], "failed"))):
        snap = runs["blast"].near(moment)
        gas, _, _, _ = state(snap)
        x, z = 1e3 * snap.points[:, 0], 1e3 * snap.points[:, 2]
        if what == "pressure":
            shown = panel.scatter(x, z, s=2.0, marker="s", c=1e-6 * snap.fields["pressure"], cmap="inferno", vmin=0,
                                  vmax=400, linewidths=0)
            figure.colorbar(shown, ax=panel, label="pressure [MPa]", shrink=0.8, extend="both")
        else:
            colour = np.where(gas, "#d55e00", np.where(snap.fields["failed"] > 0, "#f0c040", "#203050"))
            panel.scatter(x, z, s=2.0, marker="s", c=colour, linewidths=0)
        panel.set(title=f"{1e6 * snap.time:.0f} us", aspect="equal", xlabel="x [mm]", ylabel="z [mm]", xlim=(0, 165),
                  ylim=(0, 165))
    return figure


CASES = {"blast": ("scene.nml", {})}

if __name__ == "__main__":
    Study(__file__, CASES, tables, {"picture.png": draw}, as_it_stands="blast").main()
