# SPDX-License-Identifier: BSD-3-Clause
"""Draw the figures of doc/theory/verification_granular.md.

    python test/verify/draw_granular.py --scree build/bin/scree --work FOLDER [--only WORD]

runs the flows of test/support/flows.py and writes doc/theory/figures/granular_*.png. The run-out takes some minutes.
"""

import argparse

import matplotlib
import matplotlib.ticker
import numpy as np
from matplotlib import pyplot

import _support
import bodies
import case
import flows
from draw_bodies import STYLE

matplotlib.use("Agg")



def incline(options):
    """Steady profiles; mean speed over time on slopes with different angles."""
    figure, (left, right) = pyplot.subplots(1, 2, figsize=(8.0, 3.0))
    heights = np.linspace(0.0, 0.01, 100)
    for angle, start, end in ((22.0, 0.7, 2.0), (24.0, 0.0, 3.5), (26.0, 1.2, 3.0)):
        result = flows.incline(options, "slope", angle=angle, start=start, end=end, count=1)
        shown = left.plot(result["speed"], 1e3 * result["place"], "o", markersize=3, label=f"{angle:.0f} degrees")
        left.plot(flows.bagnold(heights, angle, 0.01), 1e3 * heights, color=shown[0].get_color(), linewidth=0.8)
        right.plot(result["time"], result["means"], color=shown[0].get_color(), label=f"{angle:.0f} degrees")
    for angle, words in ((34.0, {"end": 0.6}), (20.0, {"end": 1.2, "start": 1.0, "start_angle": 24.0})):
        result = flows.incline(options, "slope", angle=angle, count=1, **words)
        right.plot(result["time"], result["means"], color="C3" if angle > 30.0 else "C4", label=f"{angle:.0f} degrees")
    time, exact = flows.slope_reference(34.0, 0.01, 0.6)
    right.plot(time, exact, "k:", label="finite volumes")
    left.set(xlabel="speed [m/s]", ylabel="height above the base [mm]", title="steady flow, lines: closed form")
    right.set(xlabel="t [s]", ylabel="mean speed [m/s]", xlim=(0.0, 2.5), ylim=(0.0, 0.6),
              title="approach to the steady flow")
    left.legend()
    right.legend()
    _support.save(figure, "granular_incline")


def contacts(options):
    """Rate independence and decaying waves."""
    figure, (left, right) = pyplot.subplots(1, 2, figsize=(8.0, 3.0))
    time = np.linspace(0.0, 1.3, 200)
    for exact in bodies.shear_stress(time, 0.15):
        left.plot(2.0 * time, exact, "k", linewidth=0.8)
    for rate, density, mark in ((2.0, 1.0e-4, "o"), (20.0, 1.0e-6, "+")):
        curve = bodies.shear(options, "shear", density=density, survival=0.3, rate=rate)["curve"]
        left.plot(rate * curve[:, 0], curve[:, 1], mark, markersize=4, label=f"$\\sigma_{{xz}}$, {rate:g} /s")
        left.plot(rate * curve[:, 0], curve[:, 2], mark, markersize=4, label=f"$\\sigma_{{xx}}$, {rate:g} /s")
    left.set(xlabel="shear strain", ylabel="stress [Pa]", title="$\\gamma_c$ = 0.3, driven by the boundaries")
    left.legend(loc="center right")
    time = np.linspace(0.0, 0.6, 300)
    for relaxation in (0.2, 0.04):
        result = flows.wave(options, "wave", relaxation=relaxation)
        right.plot(time, flows.fading(time, relaxation)[0], "k", linewidth=0.8)
        right.plot(result["curve"][:, 0], result["curve"][:, 1], "o", markersize=3, label=f"$\\tau$ = {relaxation} s")
    right.set(xlabel="t [s]", ylabel="speed / initial speed", title="standing wave of shear")
    right.legend()
    _support.save(figure, "granular_contacts")


def runout(options):
    """Run-out and height of columns by aspect ratio."""
    figure, axes = pyplot.subplots(1, 3, figsize=(10.0, 3.2))
    line = np.geomspace(0.4, 20.0, 100)
    options.timeout = 600
    for axisymmetric, place in ((False, axes[0]), (True, axes[1])):
        aspects = (0.5, 1.0, 2.0, 4.0, 8.0, 16.0)
        runs = [flows.collapse(options, "column", aspect=aspect, axisymmetric=axisymmetric) for aspect in aspects]
        least, law = np.array([flows.runout_laws(aspect, axisymmetric) for aspect in line]).T
        law[least < law] = np.nan      # no law there
        place.fill_between(line, 0.85 * law, 1.15 * law, color="0.9", label="15 %")
        place.loglog(line, law, "k", linewidth=0.8, label="Lube and others")
        place.loglog(aspects, [run["runout"] for run in runs], "o", label="here")
        place.set(xlabel="height over half width" if not axisymmetric else "height over radius",
                  ylabel="run-out over the same", title="round" if axisymmetric else "plane")
        place.legend()
        heights = [flows.measured_height(aspect, axisymmetric) for aspect in line]
        shown = axes[2].loglog(aspects, [run["height"] for run in runs], "s" if axisymmetric else "o",
                               label=place.get_title())
        axes[2].loglog(line, heights, color=shown[0].get_color(), linewidth=0.8)
    axes[2].set(xlabel="aspect ratio", ylabel="height of the deposit over half width", title="height, lines measured")
    axes[2].legend()
    for place, least, most in zip(axes, (0.4, 0.4, 0.4), (20.0, 10.0, 3.0)):
        place.set(xlim=(0.4, 20.0), ylim=(least, most))
        for axis in (place.xaxis, place.yaxis):
            axis.set_major_locator(matplotlib.ticker.FixedLocator((0.5, 1, 2, 4, 8, 16)))
            axis.set_major_formatter("{x:g}")
            axis.set_minor_locator(matplotlib.ticker.NullLocator())
    _support.save(figure, "granular_runout")


def main():
    """All figures, or those whose name contains a word."""
    options = case.arguments()
    parser = argparse.ArgumentParser()
    parser.add_argument("--only", default="")
    only = parser.parse_args().only
    with matplotlib.rc_context(STYLE):
        for draw in (incline, contacts, runout):
            if only in draw.__name__:
                draw(options)


if __name__ == "__main__":
    main()
