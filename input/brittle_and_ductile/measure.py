# SPDX-License-Identifier: BSD-3-Clause
"""A brittle and a ductile bar with the plain method, GIMP and DDMP: where does the method matter?

    python input/brittle_and_ductile/measure.py --scree build/bin/scree
"""
import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "scripts"))
from scree_scene import Study, Table  # noqa: E402

METHODS = {"mpm": ("plain", {"run.method": "mpm"}),
           "gimp": ("GIMP", {"run.method": "mpm", "method.basis": "gimp"}),
           "ddmp": ("DDMP", {"run.method": "ddmp"})}
#: Deck, values for all, its cell size and those that are run [mm], all with the same mass a particle and cell.
BARS = {"glass": ("../glass_rod/scene.nml", {"time.t_end": 30.0, "body.velocity": "0,0,-0.2",
                                             "grid.hi": "30,0,65"}, (0.5, 0.25)),
        "copper": ("../taylor_copper/scene.nml", {}, (0.635, 0.3175))}
FINE = {"glass": 0.125, "copper": 0.15875}
SHARE = 0.9                            # of the mass, for radii that a few grains do not decide


def enclosing(radius, mass, share):
    """Radius that holds a share of the mass."""
    order = np.argsort(radius)
    total = np.cumsum(mass[order])
    return radius[order][np.searchsorted(total, share * total[-1])]


def glass(run):
    """Failed share; radii that hold 90 % of two slices; shares of energy in radial motion and noise."""
    snap = run.last()
    z, r, mass = snap.points[:, 2], snap.points[:, 0], snap.fields["mass"]
    found = {"failed share": snap.fields["failed"].mean()}
    for low, high in ((0.0, 5.0e-3), (5.0e-3, 10.0e-3)):
        chosen = (z >= low) & (z < high)
        found[f"radius at {1e3 * low:.0f} to {1e3 * high:.0f} mm"] = enclosing(r[chosen], mass[chosen], SHARE)
    found["length"] = enclosing(z, mass, 0.999)
    velocity = snap.fields["velocity"]
    found["radial over axial energy"] = (mass @ velocity[:, 0] ** 2) / (mass @ velocity[:, 2] ** 2)
    return found


def copper(run):
    """Length, foot and waist."""
    snap = run.last()
    z, r = snap.points[:, 2], snap.points[:, 0]
    waist = np.abs(z - 5.08e-3) < 0.5e-3
    return {"length": z.max(), "foot": r[z < 1.0e-3].max(), "waist": r[waist].max()}


def scatter(run):
    """Difference of the velocities of particles and their neighbours in the cell, rms over that of all."""
    snap = run.last()
    width = 2.0 * np.sqrt(np.median(snap.fields["volume"] / (2 * np.pi * np.maximum(snap.points[:, 0], 1e-9))))
    cell = np.floor(snap.points[:, [0, 2]] / width).astype(int)
    _, index = np.unique(cell, axis=0, return_inverse=True)
    index = index.ravel()
    count = np.bincount(index)
    total = 0.0
    for column in (0, 2):
        v = snap.fields["velocity"][:, column]
        total += ((v - (np.bincount(index, v) / count)[index])[count[index] > 1] ** 2).mean()
    speed = snap.fields["velocity"]
    return np.sqrt(total / (speed ** 2).sum(axis=1).mean())


MEASURES = {"glass": glass, "copper": copper}


def tables(runs):
    """Mean relative difference to the finest runs, by method and cells."""
    result = Table(["bar", "cells [mm]", "method", "off DDMP with half the cells", "off GIMP with half the cells",
                    "energy error"])
    detail = Table(["bar", "method", "cells [mm]", "quantity", "value"])
    for bar, (_, _, sizes) in BARS.items():
        fine = {name: MEASURES[bar](runs[f"{bar}_{name}_{FINE[bar]}"]) for name in ("ddmp", "gimp")}
        for size in sizes:
            for name, (title, _) in METHODS.items():
                run = runs[f"{bar}_{name}_{size}"]
                found = MEASURES[bar](run)
                off = [np.mean([abs(found[key] / right[key] - 1.0) for key in found]) for right in fine.values()]
                result.rows.append([bar, size, title, *(f"{100 * value:.1f} %" for value in off),
                                    f"{run.error('energy_error'):.0e}"])
                detail.rows += [[bar, title, size, key, f"{value:.4g}"] for key, value in found.items()]
    return [result, detail]


def cases():
    """All methods with all cells, and two with the finest."""
    made = {}
    for bar, (deck, values, sizes) in BARS.items():
        for size in (*sizes, FINE[bar]):
            for name, (_, method) in METHODS.items():
                if size != FINE[bar] or name != "mpm":
                    made[f"{bar}_{name}_{size}"] = (deck, {**values, **method, "grid.dx": size})
    return made


if __name__ == "__main__":
    Study(__file__, cases(), tables).main()
