# SPDX-License-Identifier: BSD-3-Clause
"""Flows of grains with closed solutions or measured laws, which tests and figures share.

    import flows
    result = flows.incline(options, "slope", angle=24.0, height=0.01, end=4.0)
    result = flows.collapse(options, "pile", aspect=2.0)

As in bodies.py a result is a dict; a run that fails has only `code`, its exit code or "timeout".
"""

import bodies
import numpy as np

GRAVITY = 9.81                         # [m/s2]

# Grains on a slope --------------------------------------------------------------------------------

MU_S, MU_2, I0 = np.tan(np.radians(20.9)), np.tan(np.radians(32.76)), 0.279
DIAMETER, GRAIN_DENSITY, PACKING = 0.5e-3, 2450.0, 0.6
DENSITY = PACKING * GRAIN_DENSITY      # of the layer [kg/m3]

INCLINE = """
&run  dimension='plane_strain'  method='{method}' /
&grid  lo=0,0,0  hi={spacing!r},1,{top!r}  dx={spacing!r} /
&time  t_end={end!r} /
&method  {words} /
&effects  gravity=.true.  gravity_vector={along!r},0,{down!r} /
&material  name='beads'  density={density!r}  bulk={bulk!r}  shear={shear!r}  strength_model='mu_i'
  mu_s={mu_s!r}  mu_2={mu_2!r}  mu_i0={i0!r}  grain_diameter={diameter!r}  grain_density={grain_density!r} /
&boundary  face='xlo'  type='periodic' /
&boundary  face='xhi'  type='periodic' /
&boundary  face='zlo'  type='stick' /
"""


def bagnold(place, angle, height):
    """Steady speed at a height above the base [m/s] of a layer of a height on a slope of an angle in degrees."""
    slope = np.radians(angle)
    number = I0 * (np.tan(slope) - MU_S) / (MU_2 - np.tan(slope))
    return (2.0 * number / (3.0 * DIAMETER) * np.sqrt(PACKING * GRAVITY * np.cos(slope))
            * (height ** 1.5 - np.maximum(height - place, 0.0) ** 1.5))


def slope_reference(angle, height, end, layers=40):
    """Mean speed by time of a layer that starts from rest: the law of mu(I) in finite volumes, p hydrostatic.

    For slopes on which all of the layer flows, so that its friction is that of the flow everywhere.
    """
    slope, size = np.radians(angle), height / layers
    pressure = DENSITY * GRAVITY * np.cos(slope) * (height - np.arange(layers) * size)
    scale = DIAMETER * np.sqrt(GRAIN_DENSITY / pressure)
    stiffest = (MU_2 - MU_S) / I0 * (pressure * scale).max() / DENSITY     # greatest kinematic viscosity
    steps = int(np.ceil(end / (0.2 * size ** 2 / stiffest)))
    dt, speed, means = end / steps, np.zeros(layers), [0.0]
    for _ in range(steps):
        rate = np.diff(speed, prepend=0.0) / size
        rate[0] *= 2.0                 # the base is half a layer below the first one
        number = np.maximum(rate, 0.0) * scale
        friction = pressure * (MU_S + (MU_2 - MU_S) * number / (I0 + number))
        speed += dt * ((np.append(friction[1:], 0.0) - friction) / (size * DENSITY) + GRAVITY * np.sin(slope))
        means.append(speed.mean())
    return np.linspace(0.0, end, steps + 1), np.array(means)


def incline(options, name, method="ddmp", words="flip=0.9999", angle=24.0, height=0.01, cells=10, ppc=2, end=4.0,
            start=0.0, start_angle=None, softness=1000.0, count=4):
    """A layer of grains on a slope, one cell long and periodic, with a base that sticks and a free surface.

    It starts with `start` times the steady profile of its own or another angle. The bulk modulus is `softness`
    times the weight of the layer, so that the step is bounded by waves of sqrt(softness) sqrt(g h). The share
    of PIC, 1 - flip in each step, is a viscosity of about a tenth of (1 - flip) dx2/dt: with the default of
    0.001 and 10 cells it is 3 % of that of the grains, with 0.0001 a tenth of that.
    """
    slope, spacing, layers = np.radians(angle), height / cells, cells * ppc
    bulk = softness * DENSITY * GRAVITY * height
    deck = INCLINE.format(method=method, words=words, spacing=spacing, top=(cells + 4) * spacing, end=end,
                          along=float(GRAVITY * np.sin(slope)), down=float(-GRAVITY * np.cos(slope)),
                          density=DENSITY, bulk=bulk, shear=0.46 * bulk, mu_s=float(MU_S), mu_2=float(MU_2), i0=I0,
                          diameter=DIAMETER, grain_density=GRAIN_DENSITY)
    for n in range(layers):
        low, high = n * height / layers, (n + 1) * height / layers
        speed = start * bagnold(0.5 * (low + high), start_angle or angle, height) if start else 0.0
        deck += f"&region name='r{n}' shape='box' lo=0,0,{low!r} hi={spacing!r},1,{high!r} /\n"
        deck += (f"&body name='b{n}' region='r{n}' material='beads' ppc={ppc},1,{ppc} "
                 f"velocity={float(speed)!r},0,0 /\n")
    run, result = bodies.launch(options, name, deck, every=100, count=count)
    if result["code"]:
        return result
    time, last = run.snapshots()[-1]
    place, speed, stress = last.points[:, 2], last.fields["velocity"][:, 0], last.fields["stress"]
    table = run.history
    result.update(place=place, speed=speed, ratio=np.abs(stress[:, 5].mean() / stress[:, 2].mean()),
                  friction=np.tan(slope), time=table["time"], means=table["momentum_x"] / table["mass"],
                  kinetics=table["kinetic"], ended=time)
    if MU_S < np.tan(slope) < MU_2:
        exact, scale = bagnold(place, angle, height), bagnold(height, angle, height)
        result.update(profile=np.abs(speed - exact).max() / scale, rms=bodies.rms(speed - exact) / scale,
                      mean=speed.mean() / exact.mean() - 1.0, surface=scale)
    return result
