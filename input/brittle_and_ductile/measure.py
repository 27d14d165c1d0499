# SPDX-License-Identifier: BSD-3-Clause
"""A brittle and a ductile bar with the plain method, GIMP and DDMP: where does the method matter?

    python input/brittle_and_ductile/measure.py --scree build/bin/scree
"""
import sys
from pathlib import Path

import numpy as np

ROOT = Path(__file__).resolve().parents[2]
sys.path[:0] = [str(ROOT / "scripts"), str(ROOT / "python/src"), str(ROOT / "test/support")]
import scree_post                      # noqa: E402
import taylor                          # noqa: E402
from scree.drawing import look     # noqa: E402
from scree_post import panel     # noqa: E402
from scree_scene import Study, Table   # noqa: E402

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
    snap = run.last_snapshot()
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
    series = run.series
    found = taylor.measure(taylor.MEASURED, *(scree_post.snapshot(series[place][1]) for place in (0, -1)))
    return {name: found[name] for name in ("length", "foot", "waist")}


MEASURES = {"glass": glass, "copper": copper}


def off(runs, bar, method, size):
    """Mean relative difference to the finest run of DDMP, and to that of GIMP."""
    found = MEASURES[bar](runs[f"{bar}_{method}_{size}"])
    fine = (MEASURES[bar](runs[f"{bar}_{name}_{FINE[bar]}"]) for name in ("ddmp", "gimp"))
    return np.array([np.mean([abs(found[key] / right[key] - 1.0) for key in found]) for right in fine])


def tables(runs):
    """Mean relative difference to the finest runs, by method and cells."""
    result = Table(["bar", "cells [mm]", "method", "difference from DDMP with the finest cells",
                    "difference from GIMP with the finest cells", "energy error"])
    for bar, (_, _, sizes) in BARS.items():
        for size in sizes:
            for name, (title, _) in METHODS.items():
                result.rows.append([bar, size, title, *(f"{100 * value:.1f} %" for value in off(runs, bar, name, size)),
                                    f"{runs[f'{bar}_{name}_{size}'].error('energy_error'):.0e}"])
    return [result]


def numbers(runs):
    """How much farther off other methods are than DDMP, and what half the cells take of the error."""
    found = {bar: np.array([[off(runs, bar, name, size) for name in METHODS] for size in sizes])
             for bar, (_, _, sizes) in BARS.items()}         # by cells, method and what serves as the finest
    farther = {bar: values[:, :2] / values[:, 2:] for bar, values in found.items()}
    apart = {bar: 100.0 * np.ptp(values, axis=1) for bar, values in found.items()}
    taken = {bar: 100.0 * (1.0 - values[1] / values[0]) for bar, values in found.items()}
    plain = farther["copper"][:, 0]
    glass = farther["glass"]
    found = {"plain_least": f"{plain.min():.1f}", "plain_most": f"{plain.max():.1f}",
             "glass_least": f"{glass.min():.1f}", "glass_most": f"{glass.max():.1f}"}
    for bar, values in taken.items():
        found |= {f"apart_{bar}": f"{apart[bar].max():.1f}", f"halved_{bar}_least": f"{values.min():.0f}",
                  f"halved_{bar}_most": f"{values.max():.0f}"}
    return found


def draw(runs, plot):
    """The bars at the end by method, and how far they are off."""
    figure, panels = plot.subplots(1, 7, figsize=(11.0, 4.6), width_ratios=(1, 1, 1, 0.9, 0.9, 0.9, 2.4),
                                   layout="constrained")
    for bar, first, limits in (("glass", 0, (-18, 18, 0, 58)), ("copper", 3, (-8, 8, 0, 17))):
        for axes, (name, (title, _)) in zip(panels[first:first + 3], METHODS.items()):
            snap = runs[f"{bar}_{name}_{BARS[bar][2][1]}"].last_snapshot()
            if bar == "glass":
                values, top, colours = snap.fields["velocity"][:, 0], 300.0, look.HEAT
            else:
                values, top, colours = snap.fields["plastic_strain"], 1.2, look.SEQUENTIAL
            shown = panel.particles(axes, snap, values, low=0.0, high=top, colours=colours, sides=(-1, 1))
            panel.window(axes, limits, "r [mm]", title=title)
            if name != "mpm":
                axes.set_yticks([])
        panels[first].set_ylabel(f"{bar}: z [mm]")
        figure.colorbar(shown, ax=list(panels[first:first + 3]), location="bottom", shrink=0.8, extend="max",
                        label="radial speed [m/s]" if bar == "glass" else "plastic strain")
    places, heights, colours = [], [], ("#d55e00", "#e69f00", "#0072b2")
    for number, bar in enumerate(BARS):
        for place, name in enumerate(METHODS):
            places.append(4 * number + place)
            heights.append(100 * off(runs, bar, name, BARS[bar][2][1])[1])
    panels[6].bar(places, heights, color=colours * 2)
    panels[6].set(xticks=places, xticklabels=[title for title, _ in METHODS.values()] * 2,
                  ylabel="off the finest GIMP [%]", title="glass          copper")
    panels[6].tick_params(axis="x", rotation=60)
    return figure


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
    Study(__file__, cases(), tables, {"picture.png": draw}, numbers={"README.md": numbers}).main()
