# SPDX-License-Identifier: BSD-3-Clause
"""Granular flows with closed solutions or measured laws, which tests and figures share.

    import flows
    result = flows.incline(options, "slope", angle=24.0, height=0.01, end=4.0)
    result = flows.collapse(options, "pile", aspect=2.0)

As in bodies.py a result is a dict, and a run that fails is a failed test.
"""

import numpy as np

import bodies
import measured

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
    """Steady speed at a height above the base [m/s] of a layer of a given height on a slope of a given angle in
    degrees."""
    slope = np.radians(angle)
    number = I0 * (np.tan(slope) - MU_S) / (MU_2 - np.tan(slope))
    return (2.0 * number / (3.0 * DIAMETER) * np.sqrt(PACKING * GRAVITY * np.cos(slope))
            * (height ** 1.5 - np.maximum(height - place, 0.0) ** 1.5))


def slope_reference(angle, height, end, layers=40):
    """Mean speed over time of a layer that starts from rest: the law mu(I) in finite volumes with hydrostatic p.

    For slopes on which the whole layer flows, so that its friction is that of the flow everywhere.
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


@measured.recorded
def incline(options, name, method="ddmp", words="flip=0.9999", angle=24.0, height=0.01, cells=10, ppc=2, end=4.0,
            start=0.0, start_angle=None, softness=1000.0, count=4):
    """A layer of grains on a slope, one cell long and periodic, with a base that sticks and a free surface.

    It starts with `start` times the steady profile of its own or another angle. The bulk modulus is `softness`
    times the weight of the layer, so that the step is limited by waves of speed sqrt(softness) sqrt(g h). The PIC
    fraction, 1 - flip in each step, acts as a viscosity of about a tenth of (1 - flip) dx2/dt: with the default of
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


# A block on a slope -------------------------------------------------------------------------------

BLOCK = """
&run  dimension='plane_strain'  method='{method}' /
&grid  lo=0,0,0  hi={width!r},1,2  dx={spacing!r} /
&time  t_end={end!r} /
&method  {words} /
&effects  gravity=.true.  gravity_vector={along!r},0,{down!r} /
&material  name='stone'  density=1000  young=1.0e8  poisson=0.3 /
&region  name='block'  shape='box'  lo=1,0,0  hi=2,1,1 /
&body  name='block'  region='block'  material='stone'  ppc={ppc},1,{ppc} /
&boundary  face='zlo'  type='friction'  friction={friction!r} /
"""


@measured.recorded
def block(options, name, method="ddmp", words="", angle=24.0, friction=float(np.tan(np.radians(15.0))),
          spacing=0.25, ppc=2, end=1.0):
    """A block of 1 m slides down a slope with friction; mean distance and speed over time, in the direction of the
    slope.

    It starts without stress, so it bounces a little, and while it is lifted off there is no friction: an error of the
    order of mu L/c in the speed with the length L of the block and the speed c of its waves.
    """
    slope = np.radians(angle)
    width = spacing * np.ceil((2.5 + 0.5 * GRAVITY * end ** 2 * np.sin(slope)) / spacing)
    deck = BLOCK.format(method=method, words=words, spacing=spacing, ppc=ppc, end=end, width=float(width),
                        along=float(GRAVITY * np.sin(slope)), down=float(-GRAVITY * np.cos(slope)), friction=friction)
    run, result = bodies.launch(options, name, deck, every=10, count=20)
    table, series = run.history, run.snapshots()
    places = np.array([snap.points[:, 0].mean() for _, snap in series]) - 1.5
    result.update(time=table["time"], speeds=table["momentum_x"] / table["mass"], places=places,
                  when=np.array([when for when, _ in series]), energies=table["energy_error"],
                  expected=GRAVITY * max(0.0, np.sin(slope) - friction * np.cos(slope)))
    return result


# Collapse of columns ------------------------------------------------------------------------------

COLLAPSE = """
&run  dimension='{dimension}'  method='{method}' /
&grid  lo=0,0,0  hi={width!r},1,{top!r}  dx={spacing!r} /
&time  t_end={end!r} /
&method  {words} /
&effects  gravity=.true.  gravity_vector=0,0,-9.81 /
&material  name='sand'  density=1500  bulk={bulk!r}  shear={shear!r}  {law} /
&region  name='column'  {shape} /
&body  name='column'  region='column'  material='sand'  ppc={ppc},1,{ppc} /
&boundary  face='xlo'  type='symmetry' /
&boundary  face='zlo'  type='stick' /
&boundary  face='xhi'  type='outflow' /
"""
SAND = "strength_model='drucker_prager'  friction_angle=45  dp_cone='plane_strain'"
COLUMN_CELLS = {0.5: 32, 1.0: 24, 1.5: 20, 2.0: 16, 4.0: 12, 8.0: 8, 16.0: 8}   # cells on the width, by aspect ratio
HALF_WIDTH = 0.1                       # of the column, or its radius [m]


def runout_laws(aspect, axisymmetric=False):
    """Run-out over the half width or radius in the experiments of Lube and others (2004, 2005), as two bounds.

    Plane columns of aspect ratios between 1.8 and 2.8 follow neither law; the laws for lower and taller columns are
    the bounds there. Elsewhere both bounds are the same number.
    """
    if axisymmetric:
        return (1.24 * aspect if aspect < 1.7 else 1.6 * aspect ** 0.5,) * 2
    lower, taller = 1.2 * aspect, 1.9 * aspect ** (2.0 / 3.0)
    return (lower if aspect < 2.8 else taller, taller if aspect > 1.8 else lower)


def beads_runout(aspect):
    """Run-out of plane columns of glass beads (Lajeunesse and others 2005, as Lagree and others 2011 cite them)."""
    return 1.8 * aspect if aspect < 3.0 else 2.3 * aspect ** (2.0 / 3.0)


def continuum(aspect):
    """Run-out and height of plane columns by finite volumes with the law mu(I) (P.-Y. Lagree, L. Staron, S. Popinet,
    J. Fluid Mech. 686 (2011) 378)."""
    return 2.2 * aspect if aspect < 7.0 else 3.9 * aspect ** 0.7, 0.65 * aspect ** 0.35


def measured_height(aspect, axisymmetric=False):
    """Height of the deposit over the half width (Lajeunesse and others 2005) or the radius (Lube and others 2004)."""
    if axisymmetric:
        return aspect if aspect < 0.86 else 0.88 * aspect ** (1.0 / 6.0)
    return aspect if aspect < 0.7 else 0.79 * aspect ** (1.0 / 3.0)


def thickness(snap, aspect, axisymmetric):
    """Centres of columns and the thickness of the grains there, in half widths, at their initial density."""
    wide = HALF_WIDTH * aspect ** 0.5 / 16.0
    place = snap.points[:, 0] / wide + 0.5     # a particle is shared between two columns, at 0 with its image
    column, volume = place.astype(int), snap.fields["mass"] / 1500.0
    edges = np.arange(-1, column.max() + 3) * wide
    area = np.pi * np.diff(edges * np.abs(edges)) if axisymmetric else np.diff(edges)
    share = (np.bincount(column, volume * (column + 1.0 - place), len(area))
             + np.bincount(column + 1, volume * (place - column), len(area)))
    share[1] += share[0]
    return 0.5 * (edges[2:] + edges[1:-1]) / HALF_WIDTH, share[1:] / area[1:] / HALF_WIDTH


def front(snap, aspect, axisymmetric):
    """Run-out over the half width: the position at which the pile becomes thinner than 2 % of the root of half its
    section.

    This is about a grain of the experiments; single grains ahead of the pile are not counted.
    """
    middle, thick = thickness(snap, aspect, axisymmetric)
    least = 0.02 * aspect ** 0.5
    j = int(np.flatnonzero(thick < least)[0])
    share = (thick[j - 1] - least) / (thick[j - 1] - thick[j])
    return middle[j - 1] + share * (middle[j] - middle[j - 1]) - 1.0


@measured.recorded
def collapse(options, name, method="ddmp", words="", aspect=1.0, axisymmetric=False, cells=None,
             ppc=2, law=SAND, softness=100.0, ends=1.6, count=48):
    """A column of dry sand with the aspect ratio `aspect`, height over half width, is released on a rough plane.

    The law of Drucker and Prager has no length and no time scale, so run-outs depend on the aspect ratio alone, as in
    the experiments. The angle of 45 degrees with the plane strain cone is a coefficient of friction of 0.65 in simple
    shear without dilation, tan 33 degrees. It was fitted to the run-outs within the angles of repose of sand. The base
    sticks, so grains slide on grains; in the experiments the material of the base had no effect. The bulk modulus is
    `softness` times the weight of the column.
    """
    height, cells = aspect * HALF_WIDTH, cells or COLUMN_CELLS[aspect]
    spacing, unit = HALF_WIDTH / cells, np.sqrt(height / GRAVITY)
    width = HALF_WIDTH * (1.0 + 2.5 * runout_laws(aspect, axisymmetric)[0])
    bulk, time = softness * 1500.0 * GRAVITY * height, 3.0 if axisymmetric else 3.3
    shape = f"shape='box'  lo=0,0,0  hi={HALF_WIDTH!r},1,{height!r}"
    if axisymmetric:
        shape = (f"shape='cylinder'  centre=0,0,{0.5 * height!r}  radius={HALF_WIDTH!r}  height={height!r}"
                 "  axis=0,0,1")
    deck = COLLAPSE.format(dimension="axisymmetric" if axisymmetric else "plane_strain", method=method, words=words,
                           width=float(spacing * np.ceil(width / spacing)), spacing=spacing,
                           top=float(spacing * np.ceil(1.1 * height / spacing + 2.0)), end=float(ends * time * unit),
                           bulk=bulk, shear=0.46 * bulk, law=law, shape=shape, ppc=ppc)
    run, result = bodies.launch(options, name, deck, every=20, count=count,
                                fields="'identity','velocity','mass','volume'")
    series = run.snapshots()
    fronts = np.array([front(snap, aspect, axisymmetric) for _, snap in series])
    times = np.array([when for when, _ in series])
    last = int(np.flatnonzero(fronts < 0.97 * fronts[-1])[-1])
    arrived = np.interp(0.97 * fronts[-1], fronts[last:last + 2], times[last:last + 2])
    middle, thick = thickness(series[-1][1], aspect, axisymmetric)
    places = series[-1][1].points
    top = places[places[:, 0] < 0.2 * HALF_WIDTH, 2].max() + 0.5 * spacing / ppc
    result.update(runout=fronts[-1], fronts=fronts, times=times / unit, arrived=arrived / unit, time=time,
                  height=top / HALF_WIDTH, middle=middle, thick=thick, unit=unit,
                  kinetic=run.history["kinetic"][-1] / run.history["kinetic"].max(),
                  began=len(np.unique(series[0][1].fields["identity"])), lost=run.summary["ledger"]["mass_error"])
    return result


# Decaying waves -----------------------------------------------------------------------------------

WAVE = """
&run  dimension='plane_strain'  method='{method}' /
&grid  lo=0,0,0  hi={wide!r},1,1  dx={spacing!r} /
&time  t_end={end!r} /
&method  {words} /
&effects  artificial_viscosity=.false. /
&material  name='grains'  density=1  bulk=5  shear=3  strength_model='granular'  gr_tau={relaxation!r} /
&boundary  face='xlo'  type='periodic' /
&boundary  face='xhi'  type='periodic' /
&boundary  face='zlo'  type='periodic' /
&boundary  face='zhi'  type='periodic' /
"""
WAVE_SPEED = 1.0e-3                    # greatest speed; the strain is below a thousandth [m/s]


def fading(time, relaxation):
    """Amplitude of a standing shear wave and of its stress over G/c, for an initial speed of 1 and no initial stress.

    u'' + u'/tau + (c k)**2 u = 0: it oscillates where tau is long, and decays as in a viscous fluid where tau is short.
    """
    turn, fade = 2.0 * np.pi * np.sqrt(3.0), 0.5 / relaxation
    root = np.sqrt(complex(turn ** 2 - fade ** 2))
    speed = np.exp(-fade * time) * (np.cos(root * time) + fade / root * np.sin(root * time))
    stress = np.exp(-fade * time) * turn / root * np.sin(root * time)
    return speed.real, stress.real


@measured.recorded
def wave(options, name, method="ddmp", words="", cells=64, ppc=2, relaxation=0.2, end=0.6):
    """A standing shear wave in grains whose stress relaxes; amplitudes over time."""
    spacing, layers = 1.0 / cells, cells * ppc
    deck = WAVE.format(method=method, words=words, wide=spacing, spacing=spacing, end=end, relaxation=relaxation)
    for n in range(layers):
        low, high = n / layers, (n + 1) / layers
        speed = WAVE_SPEED * np.sin(np.pi * (low + high))
        deck += f"&region name='r{n}' shape='box' lo=0,0,{low!r} hi={spacing!r},1,{high!r} /\n"
        deck += (f"&body name='b{n}' region='r{n}' material='grains' ppc={ppc},1,{ppc} "
                 f"velocity={float(speed)!r},0,0 /\n")
    run, result = bodies.launch(options, name, deck, count=30)
    seen = []
    for time, snap in run.snapshots():
        sine, cosine = (2.0 * call(2.0 * np.pi * snap.points[:, 2]) / len(snap.points) for call in (np.sin, np.cos))
        seen.append((time, (sine * snap.fields["velocity"][:, 0]).sum() / WAVE_SPEED,
                     (cosine * snap.fields["stress"][:, 5]).sum() / (WAVE_SPEED * np.sqrt(3.0))))
    seen = np.array(seen)
    # velocities are half a step behind the stresses
    step = np.where(seen[:, 0] > 0.0, np.interp(seen[:, 0], run.history["time"], run.history["dt"]), 0.0)
    exact = np.array([fading(seen[:, 0] - 0.5 * step, relaxation)[0], fading(seen[:, 0], relaxation)[1]])
    result.update(curve=seen, exact=exact, speed=np.abs(seen[:, 1] - exact[0]).max(),
                  stress=np.abs(seen[:, 2] - exact[1]).max())
    return result
