# SPDX-License-Identifier: BSD-3-Clause
"""Draw the figures of doc/theory/verification_bodies.md.

    python test/verify/draw_bodies.py --scree build/bin/scree --work FOLDER [--only WORD]

runs the problems of test/support/bodies.py and of the tests of shocks, and writes doc/theory/figures/bodies_*.png.
"""

import argparse

import matplotlib
import matplotlib.ticker
import numpy as np
from matplotlib import pyplot

import _support
import bodies
import case
import compare_methods

matplotlib.use("Agg")

STYLE = {"font.size": 8, "axes.grid": True, "grid.alpha": 0.3, "lines.linewidth": 1.2, "figure.dpi": 100,
         "legend.fontsize": 7, "axes.axisbelow": True}


def save(figure, name):
    """Write one figure."""
    for axes in figure.axes:          # numbers between the decades would overlap
        if axes.get_xscale() == "log":
            axes.xaxis.set_minor_formatter(matplotlib.ticker.NullFormatter())
    _support.save(figure, f"bodies_{name}")


def slope(axes, places, errors, order):
    """A line with the slope of an order through the last point."""
    places = np.asarray(places, float)
    axes.loglog(places, errors[-1] * (places / places[-1]) ** order, "k:", label=f"order {order}")


def spin(options):
    """Stress of the disc; angular momentum by transfer."""
    figure, (left, middle, right) = pyplot.subplots(1, 3, figsize=(9.5, 2.9))
    usual = bodies.spin(options, "spin", ppc=3)
    _, last = usual["run"].snapshots()[-1]
    x, z = last.points[:, 0], last.points[:, 2]
    stress = last.fields["stress"]
    shown = left.scatter(x, z, c=(stress[:, 0] + stress[:, 2]) / 1e3, s=1.5, vmin=0.0, vmax=90.0, cmap="viridis")
    figure.colorbar(shown, ax=left, label="$\\sigma_{xx}+\\sigma_{zz}$ [kPa]", shrink=0.8)
    left.set_aspect("equal")
    left.set(xlabel="x [m]", ylabel="z [m]", title="after one turn")
    radius = np.hypot(x, z)
    middle.plot(radius, (stress[:, 0] + stress[:, 2]) / 1e3, ".", markersize=1.5, label="particles")
    ratio = 0.3 / 0.7
    line = np.linspace(0.0, 1.0, 100)
    exact = 1000.0 * 100.0 / 8.0 * (2.0 * (3.0 + ratio) - (4.0 + 4.0 * ratio) * line ** 2)
    middle.plot(line, exact / 1e3, "k", label="exact")
    middle.set(xlabel="r [m]", ylabel="$\\sigma_{xx}+\\sigma_{zz}$ [kPa]", title="stress", ylim=(-20.0, 130.0))
    middle.legend()
    for name in ("rflip", "apic", "aflip", "flip", "pic"):
        result = bodies.spin(options, name, words=f"transfer='{name}'")
        right.semilogy(result["time"] / (0.2 * np.pi), np.maximum(abs(result["turning"] - 1.0), 1e-7))
        apart = {"rflip": 0.7, "aflip": 1.3}   # so that names do not overlap
        right.text(1.03, max(abs(result["drift"]), 1e-7) * apart.get(name, 1.0), name,
                   color=right.lines[-1].get_color(), va="center", fontsize=7)
    right.axhline(1e-3, color="k", linestyle=":")
    right.set(xlabel="turns", ylabel="|L/L0 - 1|", title="angular momentum", ylim=(1e-6, 3.0), xlim=(-0.05, 1.22))
    save(figure, "spin")


def free_bar(options):
    """Energy of the vibration; orders."""
    figure, (left, right) = pyplot.subplots(1, 2, figsize=(8.0, 3.0))
    for name, method, words in (("ddmp", "ddmp", ""), ("ddmp usf", "ddmp", "stress_update='usf'"),
                                ("quadratic", "mpm", "basis='quadratic'"), ("gimp", "mpm", "basis='gimp'"),
                                ("mpm", "mpm", "")):
        result = bodies.free_bar(options, "bar", method, words)
        left.plot(result["time"], result["energies"] / result["energies"][0], label=name)
    left.set(xlabel="t [s]", ylabel="energy of the vibration / initial energy", ylim=(0.95, 1.1),
             title="translation through 36 cells")
    left.legend()
    spacings = (2.0, 1.0, 0.5, 0.25)
    runs = [bodies.free_bar(options, "bar", spacing=spacing) for spacing in spacings]
    for key in ("velocity", "displacement", "stress"):
        errors = [result[key] for result in runs]
        right.loglog(spacings, errors, "o-", label=key)
    slope(right, spacings, errors, 2)
    right.set(xlabel="cell size [m]", ylabel="error / amplitude", title="ddmp")
    right.legend()
    save(figure, "free_bar")


def held_bar(options):
    """Mean velocity over ten periods; order of the period."""
    figure, (left, right) = pyplot.subplots(1, 2, figsize=(8.0, 3.0))
    exact = bodies.held_bar_reference(0.75)
    left.plot(exact["time"], exact["mean"], "k", label="finite elements")
    for name, method in (("ddmp", "ddmp"), ("mpm", "mpm")):
        result = bodies.held_bar(options, "held", method, cells=26, speed=0.75)
        left.plot(result["time"], result["velocity"], label=name)
    left.set(xlabel="t [s]", ylabel="mean velocity [m/s]", xlim=(60.0, 100.0), title="initial speed 0.75 m/s")
    left.legend(loc="upper left")
    cells = (13, 26, 52, 104)
    for speed in (0.1, 0.75):
        period = bodies.held_bar_reference(speed)["period"]
        errors = [abs(bodies.held_bar(options, "held", cells=n, speed=speed)["period"] / period - 1.0) for n in cells]
        right.loglog([25.0 / n for n in cells], errors, "o-", label=f"{speed} m/s")
    slope(right, [25.0 / n for n in cells], errors, 2)
    right.set(xlabel="cell size [m]", ylabel="error of the period", title="ddmp")
    right.legend()
    save(figure, "held_bar")


def two_discs(options):
    """Four states and the energies."""
    figure, axes = pyplot.subplots(1, 4, figsize=(10.0, 2.8), width_ratios=(1, 1, 1, 1.5))
    result = bodies.two_discs(options, "discs", spacing=0.0125, count=70)
    series = result["run"].snapshots()
    for place, wanted in zip(axes, (0.0, 2.2, 3.5)):
        time, snap = min(series, key=lambda pair: abs(pair[0] - wanted))
        stress = snap.fields["stress"]
        mises = np.sqrt(((stress[:, 0] - stress[:, 2]) / 2) ** 2 + stress[:, 5] ** 2)
        place.scatter(snap.points[:, 0], snap.points[:, 2], c=mises, s=0.4, vmin=0.0, vmax=100.0, cmap="magma_r")
        place.set(xlim=(-0.5, 0.5), ylim=(-0.5, 0.5), title=f"t = {time:.2f} s", aspect="equal")
    last = axes[3]
    last.plot(result["time"], result["kinetics"], label="kinetic, 32 cells across")
    last.plot(result["time"], result["totals"], label="total, 32 cells")
    coarse = bodies.two_discs(options, "discs")
    last.plot(coarse["time"], coarse["totals"], "--", label="total, 16 cells")
    last.axvline(bodies.CONTACT, color="k", linestyle=":")
    last.set(xlabel="t [s]", ylabel="energy / initial kinetic energy", ylim=(0.0, 1.1))
    last.legend()
    save(figure, "two_discs")


def column(options):
    """Stress after one and a half periods, and orders."""
    figure, (left, right) = pyplot.subplots(1, 2, figsize=(8.0, 3.0))
    exact = bodies.column_reference()
    for name, method, words in (("mpm", "mpm", ""), ("quadratic", "mpm", "basis='quadratic'"), ("ddmp", "ddmp", "")):
        result = bodies.column(options, "column", method, words, cells=40)
        left.plot(result["rest"], result["stresses"] / 1e3, ".", markersize=3, label=name)
    left.plot(exact["middle"], exact["stress"] / 1e3, "k", label="finite elements")
    left.set(xlabel="initial position [m]", ylabel="stress [kPa]", ylim=(-250.0, 50.0), title="t = 1.8 s")
    left.legend()
    cells = (20, 40, 80, 160)
    runs = [bodies.column(options, "column", cells=n) for n in cells]
    for key, scale in (("stress", 1.0), ("velocity", 1.0), ("displacement", 1.0)):
        errors = [result[key] * scale for result in runs]
        right.loglog([10.0 / n for n in cells], errors, "o-", label=key)
    slope(right, [10.0 / n for n in cells], [result["stress"] for result in runs], 1)
    right.set(xlabel="cell size [m]", ylabel="error", title="ddmp")
    right.legend()
    save(figure, "column")


def cantilever(options):
    """Shapes and the path of the tip."""
    figure, (left, right) = pyplot.subplots(1, 2, figsize=(8.0, 3.2))
    for name, method, words in (("ddmp", "ddmp", ""), ("gimp", "mpm", "basis='gimp'"), ("mpm", "mpm", "")):
        result = bodies.cantilever(options, "beam", method, words, end=1.3, count=65)
        right.plot(result["time"], result["falls"], label=name)
        if name == "ddmp":
            for wanted in (0.0, 0.4, 0.7, 1.06):
                time, snap = min(result["run"].snapshots(), key=lambda pair: abs(pair[0] - wanted))
                left.plot(snap.points[:, 0], snap.points[:, 2], ".", markersize=2, label=f"{time:.2f} s")
    right.errorbar([1.045], [-3.28], xerr=[0.015], fmt="ko", markersize=4, label="finite elements")
    left.set(xlabel="x [m]", ylabel="z [m]", aspect="equal", title="ddmp, cells of 0.25 m")
    left.legend(loc="lower left")
    right.set(xlabel="t [s]", ylabel="corner of the tip [m]")
    right.legend()
    save(figure, "cantilever")


def shear(options):
    """Stress at the start of the shear."""
    figure, (left, right) = pyplot.subplots(1, 2, figsize=(8.0, 3.0))
    for axes, relaxation, more in ((left, 0.35, {"density": 5e-4}), (right, 0.7, {"started": True, "density": 0.1})):
        result = bodies.shear(options, "shear", relaxation=relaxation, **more)
        time = np.linspace(0.0, 1.3, 200)
        for exact in bodies.shear_stress(time, relaxation):
            axes.plot(time, exact, "k", linewidth=0.8)
        curve = result["curve"]
        axes.plot(curve[:, 0], curve[:, 1], "o", markersize=3, label="$\\sigma_{xz}$")
        axes.plot(curve[:, 0], curve[:, 2], "s", markersize=3, label="$\\sigma_{xx}$")
        begin = "initially in uniform shear" if more.get("started") else "driven by the boundaries"
        axes.set(xlabel="t [s]", ylabel="stress [Pa]", title=f"$\\tau$ = {relaxation} s, {begin}")
        axes.legend()
    save(figure, "shear")


def shocks(options):
    """Sod, a shock in a fluid, and precursor and plastic shock in a solid."""
    figure, (first, second, third) = pyplot.subplots(1, 3, figsize=(10.0, 3.0))
    module = compare_methods.load("sod/test_sod.py")
    run = case.Case(options, "sod", module.DECK.format(spacing=0.005)).run("-q")
    _, last = run.snapshots()[-1]
    place = np.linspace(0.0, 1.0, 1000)
    first.plot(last.points[:, 0], last.fields["density"], ".", markersize=1.5)
    first.plot(place, module.density(place), "k", linewidth=0.8)
    first.set(xlabel="x [m]", ylabel="density [kg/m3]", title="Sod, 200 cells")
    module = compare_methods.load("piston/test_piston.py")
    for axes, solid, words, title in ((second, False, "", "fluid, 400 m/s"),
                                      (third, True, module.SMOOTH, "solid, 400 m/s, bulk_q1 = 0.5")):
        end = 4.8 if solid else 2.6
        states, _ = module.strike(options, "piston", 400, end, solid, words)
        time, places, fields = states[1]
        axes.plot(1e3 * places, -fields["stress"][:, 0] / 1e9, ".", markersize=1.5)
        shock, stress, _ = module.hugoniot(400.0)
        steps = [(0.0, stress), ((shock - 400.0) * time, stress), ((shock - 400.0) * time, 0.0), (places[-1], 0.0)]
        if solid:
            ahead, after = module.precursor(), module.plastic(400.0)
            one, two = (after["speed"] - 400.0) * time, (ahead["speed"] - 400.0) * time
            steps = [(0.0, after["stress"]), (one, after["stress"]), (one, ahead["stress"]), (two, ahead["stress"]),
                     (two, 0.0), (places[-1], 0.0)]
        steps = np.array(steps)
        axes.plot(1e3 * steps[:, 0], steps[:, 1] / 1e9, "k", linewidth=0.8)
        axes.set(xlabel="x [mm]", ylabel="pressure [GPa]" if not solid else "axial stress [GPa]", title=title)
    save(figure, "shocks")


def main():
    """All figures, or those whose name contains a word."""
    options = case.arguments()
    parser = argparse.ArgumentParser()
    parser.add_argument("--only", default="")
    only = parser.parse_args().only
    with matplotlib.rc_context(STYLE):
        for draw in (spin, free_bar, held_bar, two_discs, column, cantilever, shear, shocks):
            if only in draw.__name__:
                draw(options)


if __name__ == "__main__":
    main()
