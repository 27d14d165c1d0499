# SPDX-License-Identifier: BSD-3-Clause
"""Hole, fronts, shape, radiographs and fragments of the debris cloud, for sheets of several thicknesses.

    python input/debris_cloud/measure.py --scree build/bin/scree [--only scene]
"""
import sys
from pathlib import Path

import numpy as np

sys.path[:0] = [str(Path(__file__).resolve().parents[2] / folder) for folder in ("scripts", "python/src")]
import scree_post                      # noqa: E402
from scree.drawing.areal_density import radiograph      # noqa: E402
from scree.drawing.radiograph_page import exposure      # noqa: E402
from scree_post import panel           # noqa: E402
from scree_scene import Study, Table   # noqa: E402

DIAMETER, SPEED, DENSITY = 9.53e-3, 6710.0, 2785.0
#: Thickness of the sheet over the diameter of the sphere, and thickness [mm].
SHEETS = {"t049": (0.049, 0.465), "t084": (0.084, 0.80), "t163": (0.163, 1.55), "t233": (0.233, 2.22),
          "t504": (0.504, 4.80)}
SPHERE, SHEET = 1, 2                   # of the field body
AHEAD = 1.0e-3                         # share of the flying mass before the leading edge
TIMES = (5.0e-6, 10.0e-6, 15.0e-6, 20.0e-6)
PIXEL = 0.25e-3                        # of the radiographs [m]
PIECE = 8                              # particles that make a fragment worth counting


def hole(snap):
    """Diameter beyond which lies 99.95 % of the mass of the sheet that has not failed [m]: a single intact particle
    in the hole does not count."""
    whole = (snap.fields["body"] == SHEET) & (snap.fields["failed"] < 0.5)
    return 2.0 * reach(snap.points[whole, 0], snap.fields["mass"][whole], 0.9995)


def flying(snap):
    """Particles that move along the axis with a twentieth of the greatest speed or more."""
    velocity = snap.fields["velocity"][:, 2]
    return velocity > 0.05 * velocity.max()


def reach(values, mass, share):
    """Value beyond which a share of the mass lies."""
    order = np.argsort(values)[::-1]
    total = np.cumsum(mass[order])
    return values[order][np.searchsorted(total, share * total[-1])]


def places(snap):
    """Leading edge, centre of mass, rear and width of what flies behind the sheet [m]."""
    chosen = flying(snap) & (snap.points[:, 2] > 0.0)
    z, r, mass = snap.points[chosen, 2], snap.points[chosen, 0], snap.fields["mass"][chosen]
    return (reach(z, mass, AHEAD), np.average(z, weights=mass), -reach(-z, mass, AHEAD),
            2.0 * reach(r, mass, 10.0 * AHEAD))


def shape(snap):
    """Leading edge, length and width of what flies behind the sheet [m]."""
    front, _, rear, width = places(snap)
    return front, front - rear, width


def bodies(snap, number):
    """Places and speeds along the axis of the mass of a body: mean place [m], mean speed [m/s]."""
    chosen = snap.fields["body"] == number
    mass = snap.fields["mass"][chosen]
    return (np.average(snap.points[chosen, 2], weights=mass),
            np.average(snap.fields["velocity"][chosen, 2], weights=mass))


def front_speed(run):
    """Speed of the leading edge in the last quarter of the run [m/s]."""
    frames = run.series[-len(run.series) // 4:]
    first, last = (scree_post.snapshot(frames[place][1]) for place in (0, -1))
    return (shape(last)[0] - shape(first)[0]) / (last.time - first.time)


def maiden(ratio, speed=6.71):
    """Hole over the diameter of the sphere by Maiden and McMillan (1964)."""
    return 0.45 * speed * ratio ** (2.0 / 3.0) + 0.90


def tables(runs):
    """Sheets of all thicknesses; voids; the case of Hiermaier and others."""
    family = Table(["t/D", "hole [mm]", "fit", "leading edge / V", "sphere's mass / V", "shared momentum",
                    "length / width", "failed", "energy error"])
    for name, (ratio, _) in SHEETS.items():
        if name in runs:
            run, last = runs[name], runs[name].last_snapshot()
            front, length, width = shape(last)
            family.rows.append([
                ratio, f"{1e3 * hole(last):.1f}", f"{9.53 * maiden(ratio):.1f}",
                f"{front_speed(run) / SPEED:.2f}", f"{bodies(last, SPHERE)[1] / SPEED:.2f}",
                f"{1.0 / (1.0 + 1.5 * ratio):.2f}", f"{length / width:.2f}",
                f"{last.fields['failed'].mean():.2f}", f"{run.error('energy_error'):.0e}"])
    other = Table(["case", "hole [mm]", "leading edge [mm]", "length [mm]", "width [mm]", "length / width"])
    for name, title in (("t163", "scene, no voids"), ("open", "voids, open when failed"),
                        ("hiermaier", "10 mm sphere, 4 mm sheet, 6.18 km/s")):
        if name in runs:
            last = runs[name].last_snapshot()
            front, length, width = shape(last)
            other.rows.append([title, f"{1e3 * hole(last):.1f}", f"{1e3 * front:.1f}", f"{1e3 * length:.1f}",
                               f"{1e3 * width:.1f}", f"{length / width:.2f}"])
    return [family, travel(runs), other, pieces(runs)]


def travel(runs):
    """Where the cloud of the scene is at several times."""
    table = Table(["time [us]", "leading edge [mm]", "centre of mass [mm]", "rear [mm]", "width [mm]"])
    for moment in TIMES if "t163" in runs else ():
        snap = runs["t163"].near(moment)
        table.rows.append([f"{1e6 * snap.time:.0f}"] + [f"{1e3 * length:.1f}" for length in places(snap)])
    return table


def pieces(runs):
    """Pieces of the cloud in three dimensions: cells with matter that touch. Masses of the quarter of the model."""
    table = Table(["time [us]", "pieces behind the sheet", "single particles", f"of {PIECE} particles or more",
                   "heaviest [mg]", "second [mg]", "third [mg]", "mass in the heaviest", "round [%]"])
    if "quarter" not in runs:
        return table
    rows = scree_post.history(str(runs["quarter"].folder / "quarter_fragments.csv"))
    for moment in sorted(set(rows["time"])):
        behind = (rows["time"] == moment) & (rows["centre_z"] > 5.0e-3)
        number, mass = rows["particles"][behind], rows["mass"][behind]
        table.rows.append([f"{1e6 * moment:.0f}", behind.sum(), (number == 1).sum(), (number >= PIECE).sum(),
                           *(f"{1e6 * one:.2f}" for one in mass[:3]), f"{mass[0] / mass.sum():.2f}",
                           f"{100 * out_of_round(runs['quarter'].near(moment)):.2f}"])
    return table


def out_of_round(snap):
    """Fourth moment of the cloud round the axis, over the sum of m r^2: what the directions of the mesh leave in it."""
    x, y = snap.points[:, 0], snap.points[:, 1]
    share = snap.fields["mass"] * (x ** 2 + y ** 2) * (flying(snap) & (snap.points[:, 2] > 0.0))
    return np.sum(share * np.cos(4.0 * np.arctan2(y, x))) / np.sum(share)


def numbers(runs):
    """What the README says of the scene as it stands, and of the thickest sheet."""
    run, last = runs["t163"], runs["t163"].last_snapshot()
    ratio = SHEETS["t163"][0]
    particles = len(scree_post.snapshot(run.series[0][1]).points)
    errors = (abs(run.error(f"{name}_error")) for name in ("mass", "momentum", "energy"))
    large = 1e3 * hole(runs["t504"].last_snapshot()) / (9.53 * maiden(SHEETS["t504"][0])) - 1.0
    return {"particles": f"{particles:,}".replace(",", " "), "hole": f"{1e3 * hole(last):.1f}",
            "hole_fit": f"{9.53 * maiden(ratio):.1f}", "mean_speed": f"{bodies(last, SPHERE)[1] / SPEED:.2f}",
            "shared_speed": f"{1.0 / (1.0 + 1.5 * ratio):.2f}", "edge_speed": f"{front_speed(run) / SPEED:.2f}",
            "errors": ", ".join(f"{error:.0e}" for error in errors), "steps": str(run.summary["steps"]),
            "hole_thickest": f"{100.0 * large:.0f}",
            "hole_over": f"{100.0 * (1e3 * hole(last) / (9.53 * maiden(ratio)) - 1.0):.0f}",
            "edge_thinnest": f"{front_speed(runs['t049']) / SPEED:.2f}"}


def draw_films(runs, plot):
    """What a flash X-ray would see: a row a sheet, a column a time, flight to the right."""
    names = [name for name in SHEETS if name in runs]
    if not names:
        return None
    figure, panels = plot.subplots(len(names), len(TIMES), figsize=(10.5, 1.5 * len(names) + 0.4), squeeze=False,
                                   sharex=True, sharey=True, layout="constrained")
    absorption = exposure(radiograph(runs[names[len(names) // 2]].near(TIMES[-1]), PIXEL))
    for row, name in zip(panels, names):
        for axes, moment in zip(row, TIMES):
            frame = radiograph(runs[name].near(moment), PIXEL)
            axes.set_facecolor("white")
            axes.imshow(np.exp(-absorption * frame.sigma), extent=[1e3 * edge for edge in frame.box],
                        origin="lower", cmap="gray", vmin=0.0, vmax=1.0, interpolation="antialiased")
            axes.set(xlim=(-42, 148), ylim=(-52, 52))
            if name == names[0]:
                axes.set_title(f"{1e6 * frame.time:.0f} µs")
            if name == names[-1]:
                axes.set_xlabel("z [mm]")
        row[0].set_ylabel(f"t/D = {SHEETS[name][0]}\nr [mm]")
    return figure


def draw_sheets(runs, plot):
    """Clouds behind sheets of all thicknesses at the end, half by body and half by failure."""
    names = [name for name in SHEETS if name in runs]
    if not names:
        return None
    figure, panels = plot.subplots(1, len(names), figsize=(2.1 * len(names), 4.6), squeeze=False,
                                   sharey=True, layout="constrained")
    for axes, name in zip(panels[0], names):
        snap = runs[name].last_snapshot()
        sphere = snap.fields["body"] == SPHERE
        failed = snap.fields["failed"] > 0.5
        for chosen, side, colour in ((sphere, -1, "#d55e00"), (~sphere, -1, "#0072b2"),
                                     (failed, 1, "#999999"), (~failed, 1, "#000000")):
            panel.particles(axes, snap, colour, rows=chosen, sides=(side,))
        panel.window(axes, (-50, 50, -40, 135), "r [mm]", title=f"t/D = {SHEETS[name][0]}")
        axes.set_xticks((-40, 0, 40))
    panels[0, 0].set_ylabel("z [mm]")
    names = {"sphere": "#d55e00", "sheet": "#0072b2", "failed": "#999999", "intact": "#000000"}
    figure.legend(handles=panel.patches(names), loc="outside lower center", ncol=4)
    return figure


CASES = {name: ("scene.nml", {"region[plate].hi": f"31,0,{thickness}"})
         for name, (_, thickness) in SHEETS.items()}
CASES["quarter"] = ("quarter_3d.nml", {"grid.dx": 0.3875, "time.t_end": 10.0, "output[cloud].dt": 5.0})
CASES["open"] = ("scene.nml", {"effects.voids": ".true."})
CASES["hiermaier"] = ("scene.nml", {"region[plate].hi": "31,0,4.0", "region[ball].radius": 5.0,
                                    "region[ball].centre": "0,0,-5.035", "body[sphere].velocity": "0,0,6.18"})

if __name__ == "__main__":
    Study(__file__, CASES, tables, {"sheets.png": draw_sheets, "radiographs.png": draw_films},
          numbers={"README.md": numbers}, as_it_stands="t163").main()
