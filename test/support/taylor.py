# SPDX-License-Identifier: BSD-3-Clause
"""Taylor's test of copper bars, from the decks of input/taylor_copper.

    import taylor
    result = taylor.strike(options, "coarse", taylor.MEASURED, spacing=0.635)   # a dict of figures
    result["length"], result["foot"], result["waist"]                          # [m]

The surface of a bar is half a lattice distance outside of its outer particles. Identities show which particles were
neighbours at the start, so each line of the lattice is extrapolated by half a step to the surface, however flat the
particles there are.
"""

import dataclasses

import numpy as np

import case
import measured

FOLDER = case.ROOT / "input" / "taylor_copper"
MILLIMETRE = 1.0e-3


@dataclasses.dataclass(frozen=True)
class Bar:
    """A deck and the bar in it, in mm."""

    deck: str
    length: float
    radius: float


MEASURED = Bar("scene.nml", 25.4, 3.81)
CLASSIC = Bar("classic.nml", 32.4, 3.2)
# Length, diameter of the foot and intermediate diameter in experiments, by G. R. Johnson and T. J. Holmquist (1988)
# [mm].
EXPERIMENT = (16.2, 13.5, 10.1)


@dataclasses.dataclass(frozen=True)
class Shot:
    """A measured copper bar: length and diameter [mm], speed [m/s], final over initial length."""

    length: float
    diameter: float
    speed: float
    ratio: float


#: OFHC copper by G. R. Johnson, W. H. Cook, T. J. Holmquist; copper by M. L. Wilkins, M. W. Guinan (1973); all as
#: tabulated in HighRateExptData of B. Banerjee.
SHOTS = {"johnson_130": Shot(25.4, 7.62, 130.0, 19.56 / 25.4), "johnson_190": Shot(25.4, 7.62, 190.0, 16.21 / 25.4),
         "wilkins_210": Shot(23.47, 7.62, 210.0, 0.643)}
SHOT = """
&run  dimension='axisymmetric' /
&grid  lo=0,0,0  hi={width},0,{height}  dx={spacing} /
&time  t_end=100e-6 /
&effects  thermal=.true.  {effects} /
&material  name='copper'  preset='cu_ofhc' /
&region  name='bar'  shape='box'  lo=0,0,0  hi={radius},0,{length} /
&body  name='bar'  region='bar'  material='copper'  ppc=2,1,2  velocity=0,0,-{speed}  temperature=298 /
&boundary  face='xlo'  type='symmetry' /
&boundary  face='zlo'  type='slip' /
&output  name='bar'  kind='particles'  count=2  precision='double' /
"""


def extend(line):
    """Extrapolate half a step beyond the last position of a line of the lattice, from the last three positions."""
    return line[-1] + 0.5 * (1.5 * (line[-1] - line[-2]) - 0.5 * (line[-2] - line[-3]))


def outline(first, last):
    """Side and ends of the bar at the end: positions (r, z) in order of the lattice, from snapshots at start and
    end."""
    begin = first.points[np.argsort(first.fields["identity"])]
    now = last.points[np.argsort(last.fields["identity"])][:, [0, 2]]
    columns, rows = (np.unique(begin[:, k].round(9), return_inverse=True)[1] for k in (0, 2))
    lattice = np.full((columns.max() + 1, rows.max() + 1, 2), np.nan)
    lattice[columns, rows] = now
    assert np.isfinite(lattice).all(), "the bar is no whole lattice any more"
    return {"lattice": lattice, "side": extend(lattice), "rear": extend(lattice.swapaxes(0, 1)),
            "foot": extend(lattice[:, ::-1].swapaxes(0, 1))}


def measure(bar, first, last):
    """Length, greatest radius of the foot and diameter at a fifth of the initial length above the wall [m]."""
    shape = outline(first, last)
    side, rear = shape["side"], shape["rear"]
    waist = np.interp(0.2 * bar.length * MILLIMETRE, side[:, 1], side[:, 0])
    return {"length": rear[:, 1].max(), "foot": max(side[:, 0].max(), shape["foot"][:, 0].max()),
            "waist": 2.0 * waist, "shape": shape}


@measured.recorded
def strike(options, name, bar, spacing=None, words="", method="ddmp", settings=(), timeout=250):
    """Run a deck with another cell size [mm] and other keys of &method; sizes, strain and balances."""
    deck = (FOLDER / bar.deck).read_text(encoding="utf-8")
    if words:
        deck += f"&method  {words} /\n"
    change = [f"run.method={method}", *([f"grid.dx={spacing}"] if spacing else []), *settings]
    run = case.Case(options, name, deck)
    run.run("-q", *[part for word in change for part in ("-s", word)], timeout=timeout)
    snaps = [snap for _, snap in run.snapshots()]
    result = measure(bar, snaps[0], snaps[-1])
    books, table = run.summary["ledger"], run.history
    result.update(
        run=run, snapshots=snaps, strain=snaps[-1].fields["plastic_strain"].max(),
        kinetic=table["kinetic"][-1] / table["kinetic"][0], steps=run.summary["steps"],
        particles=run.summary["particles"], energy=books["energy_error"], momentum=books["momentum_error"],
        mass=books["mass_error"], seconds=run.summary["wall_s"])
    if bar is MEASURED:
        result["mean error"] = difference(result)
    print(f"{name:24s} L {1e3 * result['length']:.3f}  R {1e3 * result['foot']:.3f}  "
          f"W {1e3 * result['waist']:.3f} mm  strain {result['strain']:.2f}  kinetic {result['kinetic']:.1e}  "
          f"energy {result['energy']:+.1e}  momentum {result['momentum']:.1e}  {result['steps']} steps  "
          f"{result['seconds']:.1f} s", flush=True)
    return result


def difference(result):
    """Mean relative error of length, diameter of the foot and intermediate diameter against the measured ones."""
    found = result["length"], 2.0 * result["foot"], result["waist"]
    return float(np.mean([abs(value / MILLIMETRE / right - 1.0) for value, right in zip(found, EXPERIMENT)]))


@measured.recorded
def shoot(options, name, shot, effects="", cells=6):
    """Sizes at the end of a measured bar of the preset cu_ofhc, with `ratio`, the final over the initial length."""
    radius = 0.5 * shot.diameter * MILLIMETRE
    spacing = radius / cells
    deck = SHOT.format(radius=radius, spacing=spacing, width=3 * radius, length=shot.length * MILLIMETRE,
                       height=spacing * round(1.05 * shot.length * MILLIMETRE / spacing), speed=shot.speed,
                       effects=effects)
    snaps = [snap for _, snap in case.Case(options, name, deck).run("-q").snapshots()]
    bar = Bar("", shot.length, 0.5 * shot.diameter)
    result = measure(bar, snaps[0], snaps[-1])
    result["ratio"] = result["length"] / measure(bar, snaps[0], snaps[0])["length"]
    result["error"] = result["ratio"] / shot.ratio - 1.0
    return result
