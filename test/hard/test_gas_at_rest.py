# SPDX-License-Identifier: BSD-3-Clause
"""Gas of randomly placed particles: at rest, under a slow piston, and after a point explosion.

Would catch: sums over particles that are not divided by the sums of their weights, so that uniform pressure exerts
forces (a gas at rest then reached the speed of sound and nine times its volume); factors of the force that differ from
those of strain and work; walls inside the grid that count as free surfaces, because tiles behind them have no particles
or cells beyond the box are empty; thin cut cells at such walls that push the few particles in them along the wall;
particles whose volumes exceed the available volume (two hundred million times the box after an explosion, exit code 4).

At rest: closed box, uniform pressure, jittered particles, ten thousand steps on a line, in a plane and in space; and
300 steps in a plane behind a wall that cuts a row of cells at a tenth to nine tenths of them.
Rounding errors of 1e-16 of the pressure in each step, all with one sign, add up to 1e4 1e-16 = 1e-12 of the speed of
sound; limit 1e-10 of it. The same gas without normalised sums must move by more than 1e-3 of it within 300 steps;
otherwise the scene shows nothing. With the mean stress of the nodes (`control`) it stays at rest without these sums.
Slow piston: 7.5 m/s against 340 m/s, to 40 % of the length: shocks of Mach 0.02 produce negligible entropy, so the
pressure is that of the adiabat, p V^1.4 constant; target 1 % for the mean over the volume and 2 % for the deviation
from it, of which 0.5 % is the sound wave of the start that travels back and forth; on a line, in a plane and in space,
also with other transfers. The sum of the volumes equals the volume in front of the piston within 1e-3 of it, the volume
that the piston sweeps in a step or half of one. The same bits for any ranks and threads and after a restart while the
piston moves. In axisymmetry material converges beside the wall, so particles are lost to cut cells without particles: 1
% of the volume there. Explosion: radius of the shock by J. R. Kamm, F. X. Timmes, LA-UR-07-2849 (2007), gamma = 1.4,
which is 0.75 at time 1 for the cylinder and 1 for the sphere. A shock may be spread over six cells (H-10 in
hard_cases.md); the position at which the density of such a peak has half its greatest value is outside of it by
at most a quarter of that width, 1.5 cells. Particles that have become long are split, so no cell is empty and their
volumes sum up to the box: 1e-3, the error of second order of strains of 0.3 in a step. Energy in all scenes: rounding,
1e-12.
"""
# tiers: smoke, full
# timeout: 600

import numpy as np
import pytest

import case
import tier

DENSITY, PRESSURE, GAMMA = 1.225, 101325.0, 1.4
ENERGY, SOUND = PRESSURE / ((GAMMA - 1.0) * DENSITY), np.sqrt(GAMMA * PRESSURE / DENSITY)
STILL, MOVES, BOOKS = 1.0e-10, 1.0e-3, 1.0e-12
FULL = pytest.mark.tiers("full", "long")
DECK = """
&run  dimension='{dimension}' /
&grid  lo=0,0,0  hi={hi}  dx={size!r} /
&time  t_end={end!r}  {steps} /
&effects  strength=.false. /
&method  {words} /
&material  name='gas'  density={density!r}  eos_model='ideal_gas'  ig_gamma={gamma!r} /
{bodies}
&boundary  face='all'  type='slip' /
&output  name='p'  kind='particles'  count=1  precision='double'  fields='pressure','velocity','volume','mass' /
&output  name='h'  kind='history'  every=100 /
&checkpoint  at_end=.false. /
"""
BODY = """
&region  name='{name}'  shape='box'  lo=0,0,0  hi={hi} /
&body  name='{name}'  region='{name_of}'  material='gas'  ppc={ppc}  packing='{packing}'  specific_energy={energy!r} /
"""
PISTON = """
&region  name='wall'  shape='box'  lo={length!r},-1,-1  hi=9,3,3 /
&boundary  region='wall'  type='slip'  velocity=-7.5,0,0 /
"""
SCENES = {"1d": ("1,1,1", 0.05, "3,1,1"), "plane_strain": ("0.4,0.3,0.3", 0.05, "3,1,3"),
          "axisymmetric": ("0.4,1,0.3", 0.05, "3,1,3"), "3d": ("0.2,0.2,0.15", 0.05, "3,3,3")}


def gas(hi, ppc, packing, energy=ENERGY, name="gas", name_of=None):
    """A box of gas."""
    return BODY.format(hi=hi, ppc=ppc, packing=packing, energy=energy, name=name, name_of=name_of or name)


def run(options, name, dimension, hi, size, bodies, end=1.0, steps="", words="", density=DENSITY):
    """Run one deck; the case and its last snapshot."""
    box = case.Case(options, name, DECK.format(
        dimension=dimension, hi=hi, size=size, end=end, steps=steps, words=words, density=density, gamma=GAMMA,
        bodies=bodies))
    box.run(timeout=500)
    return box, box.snapshots()[-1][1]


@pytest.mark.parametrize("dimension", SCENES)
def test_rest(options, sheet, dimension):
    """Gas at rest remains at rest, and would not without normalised sums."""
    hi, size, ppc = SCENES[dimension]
    for label, words, number in (("", "", tier.choose(10000, smoke=300)), ("_none", "normalise='none'", 300),
                                 ("_control", "normalise='none'  quadrature='control'", 600)):
        name = f"rest_{dimension}{label}"
        box, last = run(options, name, dimension, hi, size, gas(hi, ppc, "jitter"), end=100.0,
                        steps=f"max_steps={number}", words=words)
        velocity, volume, pressure = last.need("velocity", "volume", "pressure")
        speed = np.abs(velocity).max() / SOUND
        sheet.below(f"{name}: energy", box.summary["ledger"]["energy_error"], BOOKS)
        if label == "_none":
            sheet.above(f"{name}: speed over that of sound", speed, MOVES)
            continue
        sheet.require(box.summary["steps"] == number, f"{name}: all steps are done")
        room = room_of(dimension, *(float(edge) for edge in hi.split(",")))
        sheet.below(f"{name}: speed over that of sound", speed, STILL)
        sheet.below(f"{name}: sum of volumes", volume.sum() / room - 1.0, STILL)
        sheet.below(f"{name}: pressure", np.abs(pressure / PRESSURE - 1.0).max(), STILL)


def room_of(dimension, length, across, height):
    """Volume of a box; in axisymmetry that around the axis, with its length as radius [m3]."""
    return np.pi * length ** 2 * height if dimension == "axisymmetric" else length * across * height


def cut(options, sheet, share, dimension="plane_strain"):
    """Gas at rest behind a wall that leaves a fraction of a row of cells; tiles behind it have no particles."""
    size, across = 0.05, 0.7
    length, name = (9.0 + share) * size, f"cut_{dimension[:5]}_{share}"
    wall = PISTON.format(length=length).replace("velocity=-7.5,0,0", "")
    box, last = run(options, name, dimension, f"0.8,0.1,{across}", size,
                    gas(f"{length!r},0.1,{across}", "3,1,3", "jitter") + wall, end=100.0, steps="max_steps=300")
    velocity, pressure = last.need("velocity", "pressure")
    sheet.require(box.summary["steps"] == 300, f"{name}: all steps are done")
    sheet.below(f"{name}: speed over that of sound", np.abs(velocity).max() / SOUND, STILL)
    sheet.below(f"{name}: pressure", np.abs(pressure / PRESSURE - 1.0).max(), STILL)


@pytest.mark.parametrize("name, dimension, packing, words", [
    ("piston", "1d", "jitter", ""),
    ("piston_plane", "plane_strain", "jitter", ""),
    ("piston_around", "axisymmetric", "jitter", ""),
    pytest.param("piston_flip", "plane_strain", "lattice", "transfer='flip'  flip=0.99", marks=FULL),
    pytest.param("piston_pic", "plane_strain", "jitter", "transfer='pic'", marks=FULL),
    pytest.param("piston_space", "3d", "jitter", "", marks=FULL),
])
def test_press(options, sheet, name, dimension, packing, words):
    """A piston compresses a gas to 40 % of its length."""
    length, size, ppc, across = {"1d": (1.0, 0.05, "3,1,1", 1.0), "plane_strain": (0.5, 0.05, "3,1,3", 0.2),
                                 "axisymmetric": (0.5, 0.025, "3,1,3", 0.2),
                                 "3d": (0.5, 0.05, "2,2,2", 0.2)}[dimension]
    hi = f"{length + 4 * size!r},{across},{across}"
    box, last = run(options, name, dimension, hi, size, gas(f"{length},{across},{across}", ppc, packing)
                    + PISTON.format(length=length), end=0.6 * length / 7.5, words=words)
    pressure, volume = last.need("pressure", "volume")
    share = volume / volume.sum()
    mean = (share * pressure).sum()
    spread = np.sqrt((share * (pressure - mean) ** 2).sum()) / mean
    room, whole = (room_of(dimension, part * length, across, across) for part in (0.4, 1.0))
    off = mean / (PRESSURE * (room / whole) ** -GAMMA) - 1.0
    sheet.below(f"{name}: energy", box.summary["ledger"]["energy_error"], BOOKS)
    sheet.below(f"{name}: pressure over the adiabat", off, 0.01)
    sheet.below(f"{name}: its deviation", spread, 0.02)
    # in axisymmetry material converges beside the wall, and particles are lost to cut cells without particles
    sheet.below(f"{name}: sum of volumes", volume.sum() / room - 1.0, 0.01 if dimension == "axisymmetric" else 1.0e-3)


def test_layouts(options, sheet):
    """The same bits for any ranks and threads and after a restart."""
    size, hi = 0.05, "0.7,0.4,0.4"
    bodies = gas("0.5,0.4,0.4", "3,1,3", "jitter") + PISTON.format(length=0.5)
    deck = DECK.format(dimension="plane_strain", hi=hi, size=size, end=1.0, steps="max_steps=80",
                       words="", density=DENSITY, gamma=GAMMA, bodies=bodies)
    deck = deck.replace("at_end=.false.", "at_end=.true.")
    digests = [case.Case(options, f"layout_{ranks}_{threads}", deck, ranks, threads).run("-q").summary["digest"]
               for ranks, threads in ((1, 1), (1, 2), (3, 1))]
    again = case.Case(options, "layout_again", deck, 2)
    again.run("-q", "-s", "time.max_steps=40")
    again.run("-q", "--restart")
    sheet.require(len({*digests, again.summary["digest"]}) == 1, f"one digest for any layout: {digests}")


@FULL
@pytest.mark.parametrize("cells, dimension", [(50, "plane_strain"), (50, "axisymmetric")])
def test_explode(options, sheet, cells, dimension):
    """The shock of an explosion in a plane or in space: position at which the density has half its greatest value."""
    size = 1.2 / cells
    hot, edge = 2.0 * size, "1.2,1,1.2"
    around = dimension == "axisymmetric"
    energy, exact = (0.851072 / 2.0, 1.0) if around else (0.311357 / 4.0, 0.75)
    bodies = (gas(f"{hot!r},1,{hot!r}", "2,1,2", "lattice", energy / room_of(dimension, hot, 1.0, hot), "hot")
              + "&region  name='rest'  shape='difference'  of='cold','hot' /\n"
              + gas(edge, "2,1,2", "lattice", 1.0e-6, "cold", "rest"))
    name = f"explosion_{dimension[:5]}_{cells}"
    box, last = run(options, name, dimension, edge, size, bodies, density=1.0)
    mass, volume = last.need("mass", "volume")
    radii = np.hypot(last.points[:, 0], last.points[:, 2])
    places = size * np.arange(cells + 1)
    shells = np.diff(2.0 / 3.0 * np.pi * places ** 3 if around else 0.25 * np.pi * places ** 2)
    density = np.histogram(radii, places, weights=mass)[0] / shells
    level = 0.5 * (1.0 + density.max())
    last_one = np.flatnonzero(density > level)[-1]
    radius = 0.5 * (places[last_one] + places[last_one + 1]) \
        + size * (density[last_one] - level) / (density[last_one] - density[last_one + 1])
    sheet.below(f"{name}: energy", box.summary["ledger"]["energy_error"], BOOKS)
    sheet.near(f"{name}: radius of the shock", radius, exact, 1.5 * size / exact)
    off = abs(volume.sum() / room_of(dimension, 1.2, 1.0, 1.2) - 1.0)
    if around:
        sheet.known(f"{name}: sum of volumes over the box", off, limit=1.0e-2, target=1.0e-3)
    else:
        sheet.below(f"{name}: sum of volumes over the box", off, 1.0e-3)


@pytest.mark.parametrize("share, dimension", [(share, dimension) for share in tier.choose(
    (0.1, 0.3, 0.5, 0.7, 0.9), smoke=(0.7,)) for dimension in ("plane_strain", "axisymmetric")])
def test_cut(options, sheet, share, dimension):
    cut(options, sheet, share, dimension)
