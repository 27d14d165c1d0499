# SPDX-License-Identifier: BSD-3-Clause
"""Grains on a slope: the steady profile, the approach to it, and slopes without a steady flow.

Would catch: a law mu(I) with a wrong rate, pressure or root; friction that uses part of the rate of the previous step;
a base that slips; a free surface that loses weight or has drag; periodic boundaries that decelerate; noise or a
viscosity of the transfer that adds to the friction of the grains; layers that creep where they should be at rest.

P. Jop, Y. Forterre, O. Pouliquen, Nature 441 (2006) 727, glass beads of 0.5 mm, layer of 10 mm. Between 20.9 and
32.76 degrees the inertial number I is the same at all depths and the speed is
u = 2 I/(3 d) sqrt(phi g cos) [h^(3/2) - (h - z)^(3/2)]; limit 1 % of the speed of the surface for every particle.
The run at 24 degrees starts from rest, that at 22 degrees from 0.7 of the profile and that at 26 degrees from 1.2 times
the profile, so all must converge to it. At 34 degrees the layer accelerates; the mean speed follows finite volumes of
the same law (limit 2 %) between g (sin - mu_2 cos) and g (sin - mu_s cos). At 20 degrees a layer with the initial
velocity of one at 24 degrees stops earlier than with mu_s alone, and remains at rest: limit 1e-6 m in 0.4 s, below 1e-4
of the distance that it moved.

Tier long: a layer of 20 mm, with a surface speed of 0.77988 m/s, and one of 10 mm with half and twice the cells; they
start with 0.9 of the steady profile and approach it for four relaxation times. Would catch an inertial number that
depends on the height or on the cells, a viscosity of the transfer that grows with the number of steps. Limit 1 %, with
half the number of cells twice that.
"""
# tiers: smoke, full, long
# timeout long: 900

import numpy as np
import pytest

import flows


@pytest.mark.tiers("full", "long")
def test_steady(options, sheet):
    """Slopes with a steady flow."""
    for angle, start, end in ((22.0, 0.7, 2.0), (24.0, 0.0, 3.5), (26.0, 1.2, 3.0)):
        name = f"{angle:.0f} degrees"
        result = flows.incline(options, f"steady_{angle:.0f}", angle=angle, start=start, end=end, count=1)
        sheet.below(f"{name}: speed over that of the surface, worst particle", result["profile"], 0.01)
        sheet.below(f"{name}: mean speed", result["mean"], 0.01)
        sheet.near(f"{name}: shear over normal stress", result["ratio"], result["friction"], 0.003)
        drift = np.interp(result["ended"] - 0.3, result["time"], result["means"]) / result["means"][-1] - 1.0
        sheet.below(f"{name}: change in the last 0.3 s", drift, 0.01)
        begun = abs(result["means"][0] / result["means"][-1] - 1.0)
        sheet.above(f"{name}: it was off by that at the start", begun, 0.15)


def test_faster(options, sheet):
    """A slope that is too steep."""
    result = flows.incline(options, "steep", angle=34.0, end=0.6, count=1)
    time, exact = flows.slope_reference(34.0, 0.01, 0.6)
    late = result["time"] > 0.1
    off = result["means"][late] / np.interp(result["time"][late], time, exact) - 1.0
    sheet.below("34 degrees: mean speed against finite volumes", np.abs(off).max(), 0.02)
    slope = np.radians(34.0)
    least, most = (flows.GRAVITY * (np.sin(slope) - mu * np.cos(slope)) for mu in (flows.MU_2, flows.MU_S))
    speeds = np.interp(np.arange(0.1, 0.6, 0.05), result["time"], result["means"])
    gains = np.diff(speeds) / 0.05
    sheet.above("34 degrees: least acceleration [m/s2]", gains.min(), least)
    sheet.below("34 degrees: greatest acceleration [m/s2]", gains.max(), most)


@pytest.mark.tiers("full", "long")
def test_stopping(options, sheet):
    """A slope that is not steep enough."""
    result = flows.incline(options, "flat", angle=20.0, end=1.2, start=1.0, start_angle=24.0, count=24)
    slope = np.radians(20.0)
    time, speed = result["time"], result["means"]
    slowest = speed[0] / (flows.GRAVITY * (flows.MU_S * np.cos(slope) - np.sin(slope)))
    stopped = time[np.flatnonzero(speed < 1.0e-3 * speed[0])[0]]
    sheet.above("20 degrees: time to stop [s]", stopped, 0.1)
    sheet.below("20 degrees: time to stop [s], with mu_s alone the limit", stopped, slowest)
    places = [(when, snap.points[np.argsort(snap.fields["identity"]), 0]) for when, snap in result["run"].snapshots()]
    went = speed[time < stopped].mean() * stopped
    after = [place for when, place in places if when > 0.8]
    sheet.require(stopped < 0.8 and len(after) > 6, "20 degrees: it was at rest for 0.4 s")
    creep = max(np.abs(place - after[0]).max() for place in after)
    sheet.below("20 degrees: creep in 0.4 s [m]", creep, 1.0e-6)
    sheet.above("20 degrees: way before it stopped [m]", went, 0.01)


@pytest.mark.tiers("long")
def test_thick(options, sheet):
    """A thick layer, and a thin one with coarse and fine cells."""
    sheet.near("formula: speed of the surface [m/s]", flows.bagnold(0.02, 24.0, 0.02), 0.77988, 1.0e-5)
    for height, cells, end, limit in ((0.02, 20, 4.0, 0.01), (0.01, 20, 2.5, 0.01), (0.01, 5, 2.5, 0.02)):
        name = f"{1e3 * height:.0f} mm, {cells} cells"
        result = flows.incline(options, f"thick_{cells}_{1e3 * height:.0f}", height=height, cells=cells, start=0.9,
                               end=end, count=1)
        sheet.below(f"{name}: speed over that of the surface, worst particle", result["profile"], limit)
        sheet.below(f"{name}: mean speed", result["mean"], limit)
        sheet.above(f"{name}: change of the mean speed", result["means"][-1] / result["means"][0] - 1.0, 0.05)


TRANSFERS = {"flip 0.999": ("flip=0.999", {}), "flip 0.999, 20 cells": ("flip=0.999", {"cells": 20}),
             "flip 0.9999": ("flip=0.9999", {}), "flip 1": ("flip=1", {}), "apic": ("transfer='apic'", {}),
             "aflip 0.999": ("transfer='aflip' flip=0.999", {}),
             "soft": ("flip=0.9999", {"softness": 300.0})}


@pytest.mark.tiers("long")
def test_transfers(options, sheet):
    """Viscosity of the transfers: error of the mean speed after 1.2 s, from the steady profile."""
    found = {}
    for name, (words, more) in TRANSFERS.items():
        result = flows.incline(options, f"transfer {name}".replace(" ", "_"), words=words, start=1.0, end=1.2, count=1,
                               **more)
        found[name] = result["mean"]
    sheet.below("flip 0.9999: mean speed", found["flip 0.9999"], 0.01)
    sheet.below("error of the mean speed, 20 cells over 10, flip = 0.999",
                found["flip 0.999, 20 cells"] / found["flip 0.999"], 0.7)
