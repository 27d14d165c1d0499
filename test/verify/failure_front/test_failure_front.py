# SPDX-License-Identifier: BSD-3-Clause
"""Glass rods that collide: the elastic wave, the undisturbed material ahead of it, and a failure front on a rotated
grid.

Would catch: a wave of the wrong speed in a rod with a free lateral surface; failure or motion ahead of the wave, or
failure below the strength; a criterion or a delay that depends on the axes of the grid, so that a front propagates
faster along them; a failure flag other than 0 and 1.

Closed solution: the wave starts with c_L, since the free surface does not yet affect the centre of the rod, and
continues with the bar speed, sqrt(E/rho). Its head is then the integral of an Airy function; the point at a third of
its height travels at that speed (R. Skalak, J. Appl. Mech. 24 (1957) 59). Only one half of the pair is computed, so
speeds in the glass are the sum of the speed on the grid and that of the rod. Along the grid and at 30 degrees to it the
front of two rods in plane strain may differ by a cell.
"""

import numpy as np
import pytest

import case

DENSITY, YOUNG, POISSON = 2230.0, 64.0e9, 0.20
LONGITUDINAL = np.sqrt(YOUNG * (1.0 - POISSON) / ((1.0 + POISSON) * (1.0 - 2.0 * POISSON) * DENSITY))
BAR = np.sqrt(YOUNG / DENSITY)
SPEED = 8.0                            # of the elastic rods [m/s]
#: The greatest stresses are rho c v = 0.1 GPa of pressure, 0.05 GPa of shear and 0.02 GPa of tension.
ELASTIC = """
&run  dimension='axisymmetric' /
&units  system='mm-us-mg' /
&grid  lo=0,0,0  hi={width},0,{high}  dx={cell} /
&time  t_end={end} /
&effects  damage=.true. /
&material  name='g'  preset='glass_borosilicate'  failure_stress=0.15  failure_shear={shear}  failure_delay=0.1
  failure_delay_power=2 /
&region  name='rod'  shape='box'  lo=0,0,0  hi={radius},0,{length} /
&body  name='rod'  region='rod'  material='g'  ppc=2,1,2  velocity=0,0,-0.008 /
&boundary  face='xlo'  type='symmetry' /
&boundary  face='zlo'  type='symmetry' /
&output  name='p'  kind='particles'  dt={every}  precision='double'  fields='velocity','failed','damage' /
"""
CELL = 4.0e-4                          # of the rotated rods [m]
TURNED = """
&run  dimension='plane_strain' /
&units  system='mm-us-mg' /
&grid  lo=-26,0,-26  hi=26,1,26  dx=0.4 /
&time  t_end=4.4 /
&effects  damage=.true. /
&material  name='g'  preset='glass_borosilicate'  failure_stress=0.6  failure_shear=0.6  failure_delay=0.2
  failure_delay_power=1 /
&region  name='left'   shape='box'  lo=-24,0,-4  hi=0,1,4  rotate=0,{turn},0 /
&region  name='right'  shape='box'  lo=0,0,-4  hi=24,1,4  rotate=0,{turn},0 /
&body  name='left'   region='left'   material='g'  ppc=2,1,2  velocity={x:.15f},0,{z:.15f} /
&body  name='right'  region='right'  material='g'  ppc=2,1,2  velocity={mx:.15f},0,{mz:.15f} /
&output  name='p'  kind='particles'  dt=0.2  precision='double'  fields='failed','mass' /
"""
# A fragment of rubble and the remainder of a rod in a closed box for a hundred thousand steps.
BOX = """
&run  dimension='plane_strain' /
&units  system='mm-us-mg' /
&grid  lo=0,0,0  hi=2.5,1,2.5  dx=0.5 /
&time  t_end=1e5  max_steps=100000 /
&effects  damage=.true. /
&material  name='g'  preset='glass_borosilicate'  failure_delay=0.3  failure_delay_power=2 /
&region  name='rod'  shape='box'  lo=0,0,0  hi=1.5,1,2 /
&body  name='rod'  region='rod'  material='g'  ppc=2,1,2  velocity=0,0,-0.05 /
&boundary  face='xlo'  type='symmetry' /
&boundary  face='xhi'  type='symmetry' /
&boundary  face='zlo'  type='symmetry' /
&boundary  face='zhi'  type='symmetry' /
&output  name='p'  kind='particles'  every=5000  precision='double'  fields='identity','failed','damage' /
"""


def rows(snap, spacing, widest):
    """Positions [m] and mean axial velocities [m/s] of layers of particles, up to a radius."""
    inside = snap.points[:, 0] < widest
    layer = np.floor(snap.points[inside, 2] / spacing).astype(int)
    ring, height = snap.points[inside, 0], snap.points[inside, 2]
    weight = np.bincount(layer, weights=ring)
    used = weight > 0.0
    return [np.bincount(layer, weights=ring * values)[used] / weight[used]
            for values in (height, snap.fields["velocity"][inside, 2])]


def reached(snap, spacing, widest, share):
    """Highest position at which the velocity has changed by a fraction of the change in the impact [m], 0 if there is
    none."""
    height, velocity = rows(snap, spacing, widest)
    level = -SPEED * (1.0 - share)
    passed = np.nonzero(velocity > level)[0]
    if not len(passed) or passed[-1] + 1 == len(height):
        return 0.0
    i = passed[-1]
    return height[i] + (level - velocity[i]) / (velocity[i + 1] - velocity[i]) * (height[i + 1] - height[i])


def wave(options, sheet, name, share, between, right, **words):
    """An elastic rod: speed of the wave, and undisturbed material ahead of it."""
    box = case.Case(options, name, ELASTIC.format(shear=1.0, **words)).run("-q")
    cell, length = 1.0e-3 * words["cell"], 1.0e-3 * words["length"]
    snaps = box.snapshots()
    found = np.array([(time, reached(snap, 0.5 * cell, 0.2e-3 * words["radius"] if share == 0.5 else 1.0, share))
                      for time, snap in snaps])
    chosen = found[(found[:, 1] > between[0]) & (found[:, 1] < between[1])]
    sheet.require(len(chosen) > 8, f"{name}: the wave is seen on its way")
    sheet.near(f"{name}: speed of the wave", np.polyfit(*chosen.T, 1)[0] + SPEED, right, 0.01)
    far = [(snap, snap.points[:, 2] > length - SPEED * time - cell) for time, snap in snaps
           if LONGITUDINAL * time < length - 25.0 * cell]
    sheet.require(len(far) > 8 and min(rear.sum() for _, rear in far) > 10, f"{name}: the rear end is seen")
    text = f"{name}: motion of the rear end before the wave, 25 cells away, over that of the rod"
    moved = max(np.abs(snap.fields["velocity"][rear] - [0.0, 0.0, -SPEED]).max() for snap, rear in far) / SPEED
    if name == "bar":
        sheet.known(text, moved, limit=1.0e-5, target=1.0e-6)
    else:
        sheet.below(text, moved, 1.0e-6)
    sheet.require(all(not snap.fields["failed"].any() and not snap.fields["damage"].any() for _, snap in snaps),
                  f"{name}: nothing ages or fails below the strength")


def test_weak(options, sheet):
    """The same rod with half the shear strength that would prevent failure fails behind the wave and not ahead of
    it."""
    words = {"width": 4, "radius": 2.5, "high": 22, "length": 20, "cell": 0.5, "end": 2.5, "every": 0.25}
    box = case.Case(options, "weak", ELASTIC.format(shear=0.02, **words)).run("-q")
    places = []
    for time, snap in box.snapshots():
        failed = snap.fields["failed"]
        sheet.require(set(np.unique(failed)) <= {0.0, 1.0}, "the flag is 0 or 1")
        ahead = snap.points[:, 2] > LONGITUDINAL * time + 2.0e-3
        sheet.require(ahead.any() and not failed[ahead].any(), "nothing fails ahead of the wave")
        places.append(failed.mean())
    sheet.above("weak: share that fails", places[-1], 0.2)


def turned(options, turn):
    """Positions beyond which there is a hundredth of the broken mass on either side, at all times [m], and the broken
    mass at the end [kg]."""
    along = np.array([np.cos(np.radians(turn)), 0.0, -np.sin(np.radians(turn))])
    deck = TURNED.format(turn=turn, x=0.2 * along[0], z=0.2 * along[2], mx=-0.2 * along[0], mz=-0.2 * along[2])
    found = []
    for _, snap in case.Case(options, f"turned_{turn}", deck).run("-q").snapshots():
        broken = snap.fields["failed"] > 0.0
        places = snap.points[broken] @ along
        found.append(np.quantile(places, (0.01, 0.99)) if broken.sum() > 100 else (0.0, 0.0))
    return np.array(found), float(snap.fields["mass"][broken].sum())


def test_flags(options, sheet):
    """Failed particles remain failed, and flags are 0 or 1, compared in the order of identities."""
    before = 0.0
    box = case.Case(options, "box", BOX).run("-q")
    for _, snap in box.snapshots():
        failed = snap.fields["failed"][np.argsort(snap.fields["identity"])]
        sheet.require(np.isin(failed, (0.0, 1.0)).all() and np.all(failed >= before)
                      and np.array_equal(snap.fields["damage"] >= 1.0, snap.fields["failed"] > 0.0),
                      "flags are 0 or 1, are not taken back, and belong to their damage")
        before = failed
    sheet.require(box.summary["steps"] == 100000, "box: a hundred thousand steps")
    sheet.require(0.5 < failed.mean() < 1.0, "box: most of the glass fails, and not all")


@pytest.mark.parametrize("name, share, between, right, words", [
    ("beginning", 0.5, (4.0e-3, 8.0e-3), LONGITUDINAL, {
        "width": 12, "radius": 10, "high": 17, "length": 16, "cell": 0.25, "end": 1.6, "every": 0.05}),
    ("bar", 1.0 / 3.0, (30.0e-3, 50.0e-3), BAR, {
        "width": 4, "radius": 2.5, "high": 62, "length": 60, "cell": 0.5, "end": 10.5, "every": 0.25}),
])
def test_wave(options, sheet, name, share, between, right, words):
    wave(options, sheet, name, share, between, right, **words)


def test_angles(options, sheet):
    """Along the grid and at 30 degrees."""
    straight, mass = turned(options, 0)
    oblique, oblique_mass = turned(options, 30)
    sheet.above("front along the grid at the end [m]", straight[-1, 1], 0.018)
    print("         front along the grid, and how far it is off at 30 degrees [mm]: " + ", ".join(
        f"{1e3 * place:.2f} {1e3 * (other - place):+.2f}" for (_, place), (_, other) in zip(straight, oblique)))
    sheet.below("front at 30 degrees off that along the grid, in cells", np.abs(oblique - straight).max() / CELL, 1.0)
    sheet.near("broken mass at 30 degrees", oblique_mass, mass, 0.01)
