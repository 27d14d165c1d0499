# SPDX-License-Identifier: BSD-3-Clause
# tiers: smoke
"""The same scene with other units, as a mirror image, or in a shifted box gives the same numbers.

Would catch: a key that is not converted, absolute tolerances, a direction or a side that is treated differently from
the opposite one, positions relative to a wrong origin. usavg, the default of elastic material, averages rotations over
tiles, so its grids end at edges of tiles, which are images of each other. Limits 1e-12, because rounding differs;
control: the scene moves, fails and flows.
"""

import numpy as np
import pytest

import case

LIMIT = 1.0e-12

UNITS = """
&run  dimension='plane_strain' /
&units  system='{system}' /
&grid  lo={lo}  hi={hi}  dx={dx} /
&time  t_end={end}  max_steps={steps} /
&effects  thermal=.true.  melting=.true.  damage=.true. /
&material  name='al'  density={density}  eos_model='mie_gruneisen'  mg_c0={sound}  mg_s=1.338
  mg_gamma=2  shear={shear}  specific_heat={heat}  strength_model='johnson_cook'  jc_a={a}  jc_b={b}
  jc_n=0.34  jc_c=0.015  jc_m=1  jc_rate={rate}  t_ref=293  t_melt=775
  damage_model='johnson_cook'  jcd=0.13,0.13,-1.5,0.011,0  spall={spall} /
&region  name='ball'   shape='sphere'  centre={centre}  radius={radius} /
&region  name='plate'  shape='box'  lo={low}  hi={high} /
&body  name='ball'   region='ball'   material='al'  velocity={speed} /
&body  name='plate'  region='plate'  material='al' /
&boundary  face='xlo'  type='slip' /
&output  name='p'  kind='particles'  count=1  precision='double'
  fields='identity','velocity','stress','volume','mass','energy','temperature','failed' /
&checkpoint  at_end=.false. /
"""
SI = {"system": "si", "lo": "0,0,-0.008", "hi": "0.016,0.001,0.008", "dx": "0.0005", "end": "1",
      "steps": "150", "density": "2785", "sound": "5328", "shear": "27.6e9", "heat": "875",
      "a": "265e6", "b": "426e6", "rate": "1", "spall": "1.2e9", "centre": "0.006,0,-0.0031",
      "radius": "0.003", "low": "0,0,0", "high": "0.012,0.001,0.0015", "speed": "300,0,4000"}
MM = {"system": "mm-us-mg", "lo": "0,0,-8", "hi": "16,1,8", "dx": "0.5", "end": "1e6",
      "steps": "150", "density": "2.785", "sound": "5.328", "shear": "27.6", "heat": "8.75e-4",
      "a": "0.265", "b": "0.426", "rate": "1e-6", "spall": "1.2", "centre": "6,0,-3.1",
      "radius": "3", "low": "0,0,0", "high": "12,1,1.5", "speed": "0.3,0,4"}

MIRROR = """
&run  dimension='3d' /
&grid  lo={lo},0,0  hi={hi},8,8  dx=1 /
&time  t_end=1  max_steps=60 /
&method  {words} /
&effects  gravity=.true.  gravity_vector={gravity},0,-300 /
&material  name='rubber'  density=1000  young=1.0e6  poisson=0.3 /
&region  name='ball'  shape='sphere'  centre={left},4.1,2.2  radius=1.9 /
&region  name='box'   shape='box'  lo={low},1.1,5.0  hi={high},5.2,7.1 /
&body  name='ball'  region='ball'  material='rubber'  velocity={fast},2,3  spin=4,{turn} /
&body  name='box'   region='box'   material='rubber'  velocity={slow},1,-6 /
&boundary  face='{face}'  type='slip' /
&boundary  face='zlo'  type='stick' /
&output  name='p'  kind='particles'  count=1  precision='double'
  fields='identity','velocity','stress','volume','mass' /
&checkpoint  at_end=.false. /
"""
SCENE = {"lo": 0, "hi": 9, "gravity": 50.0, "left": 3.15, "low": 4.1, "high": 7.4, "fast": 14.0,
         "turn": "5,-3", "slow": -8.0, "face": "xlo", "words": ""}
# spin is an axial vector: its x component is unchanged, the others change sign
IMAGE = {"lo": -9, "hi": 0, "gravity": -50.0, "left": -3.15, "low": -7.4, "high": -4.1,
         "fast": -14.0, "turn": "-5,3", "slow": 8.0, "face": "xhi", "words": ""}


def last(options, name, deck):
    """First and last snapshot and the steps."""
    run = case.Case(options, name, deck).run("-q")
    (_, first), (_, snap) = run.snapshots()
    return first, snap, run.summary["steps"]


def test_units(options, sheet):
    """SI and mm-us-mg."""
    first, one, steps = last(options, "units_si", UNITS.format(**SI))
    _, two, _ = last(options, "units_mm", UNITS.format(**MM))
    sheet.require(steps == 150 and len(one.points) == len(two.points), "units: both run")
    sheet.require(one.fields["failed"].sum() > 5, "units: particles fail")
    sheet.require(one.fields["temperature"].max() > 400.0, "units: particles get hot")
    orders = [np.argsort(snap.fields["identity"]) for snap in (one, two)]
    sheet.below("units: time", one.time / two.time - 1.0, LIMIT)
    for name in ("velocity", "stress", "volume", "mass", "energy", "temperature", "failed"):
        values = [snap.fields[name][order] for snap, order in zip((one, two), orders)]
        scale = max(np.abs(values[0]).max(), 1.0e-300)
        sheet.below(f"units: {name}", np.abs(values[0] - values[1]).max() / scale, LIMIT)
    away = np.abs(one.points[orders[0]] - two.points[orders[1]]).max() / 0.016
    sheet.below("units: places", away, LIMIT)


def nearest(points, others):
    """For each point of one set the index of the nearest point of the other set."""
    return np.array([np.argmin(((others - point) ** 2).sum(axis=1)) for point in points])


@pytest.mark.parametrize("name, words", [
    ("default", ""),
    ("usl", "stress_update='usl'"),
    ("musl", "stress_update='musl'"),
    ("apic", "transfer='apic'"),
])
def test_mirror(options, sheet, name, words):
    """A scene and its image in the plane x = 0."""
    edge = 12 if name == "default" else 9       # a tile has 6 cells along an edge
    _, one, steps = last(options, f"scene_{name}", MIRROR.format(**{**SCENE, "hi": edge, "words": words}))
    _, two, _ = last(options, f"image_{name}", MIRROR.format(**{**IMAGE, "lo": -edge, "words": words}))
    sheet.require(steps == 60 and len(one.points) == len(two.points) > 300, f"{name}: both run")
    points = two.points * (-1, 1, 1)
    order = nearest(one.points, points)
    sheet.require(len(set(order)) == len(order), f"{name}: every particle has an image")
    stress = one.fields["stress"]
    sheet.require(np.abs(stress).max() > 1.0e3, f"{name}: there is stress")
    pairs = {"places": (one.points, points[order], 9.0),
             "velocity": (one.fields["velocity"], two.fields["velocity"][order] * (-1, 1, 1), 20.0),
             "volume": (one.fields["volume"], two.fields["volume"][order],
                        one.fields["volume"].max()),
             "stress": (stress, two.fields["stress"][order] * (1, 1, 1, -1, 1, -1),
                        np.abs(stress).max())}
    for key, (mine, other, scale) in pairs.items():
        sheet.below(f"mirror {name}: {key}", np.abs(mine - other).max() / scale, LIMIT)
