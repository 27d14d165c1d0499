# SPDX-License-Identifier: BSD-3-Clause
"""Problems with closed solutions that tests and the comparison of methods share.

    import bodies
    result = bodies.spin(options, "default")                          # a dict of figures
    result = bodies.spin(options, "apic", method="mpm", words="basis='quadratic' transfer='apic'")

Every problem takes the method and the keys of &method, so all methods are tested with the same set-up. A run that does
not end with exit code 0 and finite energies fails the test. With `may_fail` it does not: the result then has only
`name`, `run` and `code` (the exit code, "timeout", "too many steps" or "not finite"), and the caller evaluates the
code.
"""

import subprocess

import numpy as np

import case
import measured

END = """
&output  name='h'  kind='history'  every={every} /
&output  name='p'  kind='particles'  count={count}  precision='double'
  fields={fields} /
&checkpoint  at_end=.false. /
"""


# two rings of a material `rubber` that collide at 60 m/s
RINGS = """
&region  name='a'  shape='sphere'  centre=-0.06,0,0  radius=0.04 /
&region  name='b'  shape='sphere'  centre=-0.06,0,0  radius=0.03 /
&region  name='c'  shape='sphere'  centre= 0.06,0,0  radius=0.04 /
&region  name='d'  shape='sphere'  centre= 0.06,0,0  radius=0.03 /
&region  name='l'  shape='difference'  of='a','b' /
&region  name='r'  shape='difference'  of='c','d' /
&body  name='l'  region='l'  material='rubber'  velocity= 30,0,0 /
&body  name='r'  region='r'  material='rubber'  velocity=-30,0,0 /
"""
FIELDS = "'identity','velocity','stress'"


def launch(options, name, deck, every=1, count=1, fields=FIELDS, may_fail=False):
    """Run a deck; the case and a dict with its exit code.

    `options` may contain a `timeout` in seconds, and the number of `steps` at which a run that may fail counts as
    failed.
    """
    run = case.Case(options, name, deck + END.format(every=every, count=count, fields=fields))
    most = getattr(options, "steps", None)
    words = ["-s", f"time.max_steps={most}"] if most else []
    try:
        run.run("-q", *words, expect=None, timeout=getattr(options, "timeout", 250))
    except subprocess.TimeoutExpired:
        run.code = "timeout"
    result = {"name": name, "code": run.code, "run": run}
    if not run.code:
        books = run.summary["ledger"]
        result.update(steps=run.summary["steps"], momentum=books["momentum_error"],
                      angular=books["angular_momentum_error"], mass=books["mass_error"],
                      particles=run.summary["particles"])
        if most and result["steps"] >= most:
            result["code"] = "too many steps"
        if not np.isfinite(run.history["kinetic"]).all():
            result["code"] = "not finite"
    if result["code"] and not may_fail:
        raise AssertionError(f"{name}: the run ended with {result['code']}\n{run.output[-4000:]}")
    return run, result


def rms(values):
    """Root of the mean square."""
    return float(np.sqrt((np.asarray(values) ** 2).mean()))


def crossings(time, values):
    """Times at which values rise through zero, by linear interpolation."""
    before = np.flatnonzero((values[:-1] < 0.0) & (values[1:] >= 0.0))
    share = values[before] / (values[before] - values[before + 1])
    return time[before] + share * (time[before + 1] - time[before])


def period(time, values):
    """Mean time between the first and the last of such crossings."""
    seen = crossings(time, values)
    return (seen[-1] - seen[0]) / (len(seen) - 1) if len(seen) > 1 else float("nan")


def chain(length, young, density, end, speed=None, gravity=0.0, elements=400, cfl=0.5):
    """A neo-Hookean bar without lateral strain, fixed at 0: P = E (F - 1/F)/2, by finite elements.

    The reference for finite strains: linear elements in material coordinates, lumped mass, leapfrog; 400 elements and
    another scheme than that of the program, so its own error is far below the errors that are measured. `speed` gives
    the initial velocity at a position. Returns time and mean velocity of all steps (velocities half a step behind),
    initial positions, current positions and stress at the end.
    """
    size = length / elements
    rest = np.linspace(0.0, length, elements + 1)
    place = rest.copy()
    mass = np.full(elements + 1, density * size)
    mass[[0, -1]] *= 0.5
    steps = int(np.ceil(end / (cfl * size / np.sqrt(young / density))))
    dt = end / steps
    velocity = speed(rest) if speed else np.zeros_like(rest)
    mean = np.empty(steps + 1)
    mean[0] = (mass * velocity).sum() / mass.sum()
    for step in range(steps + 1):
        stretch = np.diff(place) / size
        stress = 0.5 * young * (stretch - 1.0 / stretch)
        force = -mass * gravity
        force[:-1] += stress
        force[1:] -= stress
        kick = dt * force / mass
        velocity = velocity + (0.5 * kick if step == 0 else kick)
        velocity[0] = 0.0
        if step == steps:
            break
        place = place + dt * velocity
        mean[step + 1] = (mass * velocity).sum() / mass.sum()
    return {"time": np.concatenate(([0.0], (np.arange(steps) + 0.5) * dt)), "mean": mean, "rest": rest,
            "place": place, "stress": stress, "middle": 0.5 * (rest[1:] + rest[:-1])}


# Spinning disc -----------------------------------------------------------------------------------

SPIN = """
&run  dimension='plane_strain'  method='{method}' /
&grid  lo=-1.5,0,-1.5  hi=1.5,1,1.5  dx={spacing} /
&time  t_end={end!r} /
&method  {words} /
&effects  artificial_viscosity=.false. /
&material  name='disc'  density=1000  young=1.0e7  poisson=0.3 /
&region  name='disc'  shape='cylinder'  axis=0,1,0  centre=0,0.5,0  radius=1  height=4 /
&body  name='disc'  region='disc'  material='disc'  ppc={ppc},1,{ppc}  {body} /
{exact}
"""


@measured.recorded
def spin(options, name, method="ddmp", words="", spacing=0.1, ppc=2, speed=10.0, turns=1.0, strained=True,
         may_fail=False):
    """An elastic disc rotates; changes of angular momentum and of energy per turn."""
    exact = f"&exact  solution='spinning_disc'  angular_speed={speed}  disc_radius=1 /" if strained else ""
    body = "" if strained else f"spin=0,{speed},0"
    deck = SPIN.format(method=method, words=words, spacing=spacing, ppc=ppc, exact=exact, body=body,
                       end=float(turns * 2.0 * np.pi / speed))
    run, result = launch(options, name, deck, every=10, may_fail=may_fail)
    if result["code"]:
        return result
    table = run.history
    energy, turning = table["kinetic"] + table["internal"], table["angular_momentum_y"]
    result.update(time=table["time"], turning=turning / turning[0], drift=(turning[-1] / turning[0] - 1.0) / turns,
                  energy=(energy[-1] / energy[0] - 1.0) / turns, start=turning[0] / (0.5 * table["mass"][0] * speed))
    if strained:
        seen = run.summary["exact"]
        result.update(displacement=seen["displacement_error"] / seen["greatest_displacement"],
                      velocity=seen["velocity_error"] / speed, stress=seen["stress_error"] / STRESS / speed ** 2)
    return result


# In plane strain the hoop stress at the centre is (3 + n) rho w2 R2/8 with n = nu/(1 - nu).
STRESS = (3.0 + 0.3 / 0.7) * 1000.0 / 8.0


# Bars --------------------------------------------------------------------------------------------

FLIGHT = """
&run  dimension='1d'  method='{method}' /
&grid  lo=0,0,0  hi=50,1,1  dx={spacing!r} /
&time  t_end=9 /
&method  {words} /
&effects  {effects} /
&material  name='bar'  density=1  young=100  poisson=0 /
&region  name='bar'  shape='box'  lo=2,0,0  hi=27,1,1 /
&body  name='bar'  region='bar'  material='bar'  ppc={ppc},1,1 /
&exact  solution='bar_mode'  bar_length=25  ends='free_free'  mode_speed=0.05  flight_speed=2  origin=2,0,0 /
"""
DRY = "artificial_viscosity=.false."


@measured.recorded
def free_bar(options, name, method="ddmp", words="", spacing=0.5, ppc=2, effects=DRY, may_fail=False):
    """A bar without supports vibrates and flies through 36 cells of half a metre; energy of the vibration."""
    deck = FLIGHT.format(method=method, words=words, spacing=spacing, ppc=ppc, effects=effects)
    run, result = launch(options, name, deck, count=1, may_fail=may_fail)
    if result["code"]:
        return result
    table, seen = run.history, run.summary["exact"]
    flight = 0.5 * table["momentum_x"] ** 2 / table["mass"]
    whole = 0.25 * 0.05 ** 2 * 25.0
    energy = (table["kinetic"] + table["internal"] - flight) / whole
    _, last = run.snapshots()[-1]
    result.update(time=table["time"], energies=energy, start=energy[0], energy=energy[-1] / energy[0] - 1.0,
                  books=(energy[-1] + table["viscous"][-1] / whole) / energy[0] - 1.0,
                  greatest=(energy / energy[0]).max() - 1.0, velocity=seen["velocity_error"] / 0.05 * 2 ** 0.5,
                  stress=seen["stress_error"] / (0.05 * 10.0 / 2 ** 0.5),
                  displacement=seen["displacement_error"] / (0.05 / (np.pi * 10.0 / 25.0)) * 2 ** 0.5,
                  flown=(last.points[:, 0].mean() - 14.5) / 0.5)
    return result


HELD = """
&run  dimension='1d'  method='{method}' /
&grid  lo=0,0,0  hi={box!r},1,1  cells={cells},1,1 /
&time  t_end={end!r} /
&method  {words} /
&effects  artificial_viscosity=.false. /
&material  name='bar'  density=1  young=100  poisson=0  strength_model='neo_hookean' /
&region  name='bar'  shape='box'  lo=0,0,0  hi=25,1,1 /
&body  name='bar'  region='bar'  material='bar'  ppc={ppc},1,1 /
&boundary  face='xlo'  type='symmetry' /
&exact  solution='bar_mode'  bar_length=25  ends='fixed_free'  mode_speed={speed} /
"""


@measured.recorded
def held_bar(options, name, method="ddmp", words="", cells=26, ppc=4, speed=0.1, periods=10, may_fail=False):
    """A bar held at one end vibrates for ten periods."""
    extra = 2 + int(np.ceil(0.08 * cells))
    deck = HELD.format(method=method, words=words, box=25.0 * (cells + extra) / cells, cells=cells + extra, ppc=ppc,
                       speed=speed, end=10.0 * periods)
    run, result = launch(options, name, deck, count=1, may_fail=may_fail)
    if result["code"]:
        return result
    table = run.history
    energy = table["kinetic"] + table["internal"]
    # the kinetic energy is half a step behind, so the energy oscillates by a fraction of the step
    part = len(energy) // periods
    result.update(time=table["time"], velocity=table["momentum_x"] / table["mass"],
                  period=period(table["time"], table["momentum_x"]),
                  energies=energy / (0.25 * speed ** 2 * 25.0),
                  energy=energy[-part:].mean() / energy[:part].mean() - 1.0,
                  waver=energy.max() / energy.min() - 1.0)
    return result


def held_bar_reference(speed, periods=10):
    """Period of the same bar from `chain`, and its mean velocity."""
    answer = chain(25.0, 100.0, 1.0, 10.0 * periods, lambda x: speed * np.sin(np.pi * x / 50.0))
    answer["period"] = period(answer["time"], answer["mean"])
    return answer


# Two discs ---------------------------------------------------------------------------------------

DISCS = """
&run  dimension='plane_strain'  method='{method}' /
&grid  lo=-0.5,0,-0.5  hi=0.5,1,0.5  dx={spacing} /
&time  t_end=3.5  cfl={cfl} /
&method  {words} /
&effects  {effects} /
&material  name='rubber'  density=1000  young=1000  poisson=0.3  strength_model='neo_hookean' /
&region  name='lower'  shape='sphere'  centre=-0.3,0,-0.3  radius=0.2 /
&region  name='upper'  shape='sphere'  centre= 0.3,0, 0.3  radius=0.2 /
&body  name='left'   region='lower'  material='rubber'  ppc={ppc},1,{ppc}  velocity= 0.1,0, 0.1 /
&body  name='right'  region='upper'  material='rubber'  ppc={ppc},1,{ppc}  velocity=-0.1,0,-0.1 /
"""
CONTACT = 1.585786                     # discs of radius 0.2 m touch [s]


@measured.recorded
def two_discs(options, name, method="ddmp", words="", spacing=0.025, ppc=2, cfl=0.4, effects=DRY, count=1,
              may_fail=False):
    """Two elastic discs meet and rebound."""
    deck = DISCS.format(method=method, words=words, spacing=spacing, ppc=ppc, cfl=cfl, effects=effects)
    run, result = launch(options, name, deck, every=2, count=count, fields=FIELDS + ",'body'", may_fail=may_fail)
    if result["code"]:
        return result
    table = run.history
    kinetic = table["kinetic"] / table["kinetic"][0]
    total = (table["kinetic"] + table["internal"]) / table["kinetic"][0]
    felt = np.flatnonzero(kinetic < 0.99)
    felt = table["time"][felt[0]] if len(felt) else float("nan")
    result.update(time=table["time"], kinetics=kinetic, totals=total, kinetic=kinetic[-1], least=kinetic.min(),
                  energy=total[-1] - 1.0, greatest=total.max() - 1.0,
                  books=total[-1] + table["viscous"][-1] / table["kinetic"][0] - 1.0,
                  early=(CONTACT - felt) * np.sqrt(0.08) / spacing)
    return result


# Column and cantilever ---------------------------------------------------------------------------

COLUMN = """
&run  dimension='1d'  method='{method}' /
&grid  lo=0,0,0  hi={top!r},1,1  dx={spacing!r} /
&time  t_end={end!r} /
&method  {words} /
&effects  gravity=.true.  gravity_vector=-10,0,0  artificial_viscosity=.false. /
&material  name='m'  density=1000  young=1.0e6  poisson=0  strength_model='neo_hookean' /
&region  name='column'  shape='box'  lo=0,0,0  hi=10,1,1 /
&body  name='column'  region='column'  material='m'  ppc={ppc},1,1 /
&boundary  face='xlo'  type='slip' /
"""
COLUMN_END = 1.8                       # [s], one and a half periods: compressed for the second time


@measured.recorded
def column(options, name, method="ddmp", words="", cells=40, ppc=4, may_fail=False):
    """An elastic column under suddenly applied gravity; its foot is strained by a fifth."""
    spacing = 10.0 / cells
    top = 10.0 + float(np.ceil(1.0 / spacing - 1.0e-9)) * spacing      # at least 1 m more than the column
    deck = COLUMN.format(method=method, words=words, spacing=spacing, top=top, ppc=ppc, end=COLUMN_END)
    run, result = launch(options, name, deck, count=1, may_fail=may_fail)
    if result["code"]:
        return result
    table = run.history
    (_, first), (_, last) = run.snapshots()
    exact = column_reference()
    # one material, one direction: particles keep their order
    rest, place = np.sort(first.points[:, 0]), np.sort(last.points[:, 0])
    order = np.argsort(last.points[:, 0])
    stress = last.fields["stress"][order, 0]
    scale = 1.0e5                      # weight of the column on its foot [Pa]
    mean = np.interp(table["time"], exact["time"], exact["mean"])
    velocity = table["momentum_x"] / table["mass"]
    result.update(time=table["time"], means=velocity, rest=rest, stresses=stress,
                  displacement=rms(place - np.interp(rest, exact["rest"], exact["place"])),
                  stress=rms(stress - np.interp(rest, exact["middle"], exact["stress"])) / scale,
                  velocity=rms(velocity - mean) / np.abs(mean).max(),
                  crossed=np.abs(place - rest).max() * cells / 10.0)
    return result


def column_reference(kept={}):
    """The solution of `chain` under gravity, computed once."""
    if not kept:
        kept.update(chain(10.0, 1.0e6, 1000.0, COLUMN_END, gravity=10.0, elements=1000))
    return kept


CANTILEVER = """
&run  dimension='plane_strain'  method='{method}' /
&grid  lo=0,0,-4  hi=5,1,2  dx={spacing!r} /
&time  t_end={end} /
&method  {words} /
&effects  gravity=.true.  gravity_vector=0,0,-10  artificial_viscosity=.false. /
&material  name='rubber'  density=1050  young=1.0e6  poisson=0.3  strength_model='neo_hookean' /
&region  name='beam'  shape='box'  lo=0,0,0  hi=4,1,1 /
&body  name='beam'  region='beam'  material='rubber'  ppc={ppc},1,{ppc} /
&boundary  face='xlo'  type='stick' /
"""


@measured.recorded
def cantilever(options, name, method="ddmp", words="", spacing=0.25, ppc=3, end=1.3, count=65, may_fail=False):
    """A soft beam bends under its weight; displacement of the lower corner of its tip."""
    deck = CANTILEVER.format(method=method, words=words, spacing=spacing, ppc=ppc, end=end)
    run, result = launch(options, name, deck, every=10, count=count, may_fail=may_fail)
    if result["code"]:
        return result
    times, falls, corner = [], [], None
    for time, snap in run.snapshots():
        if corner is None:             # the particle in the corner, and its neighbours inside
            places, step = snap.points[:, [0, 2]], spacing / ppc
            wanted = np.array([[4.0, 0.0]]) + step * np.array([[-0.5, 0.5], [-1.5, 0.5], [-0.5, 1.5]])
            nearest = [np.argmin(((places - here) ** 2).sum(axis=1)) for here in wanted]
            corner = snap.fields["identity"][nearest]
        order = np.argsort(snap.fields["identity"])
        found = order[np.searchsorted(snap.fields["identity"], corner, sorter=order)]
        own, left, above = snap.points[found, 2]
        times.append(time)
        falls.append(own + 0.5 * (own - left) + 0.5 * (own - above))
    falls = np.array(falls) - falls[0]
    lowest = int(np.argmin(falls))
    table = run.history
    energy = table["kinetic"] + table["internal"] - table["external_work"]
    result.update(time=np.array(times), falls=falls, fall=falls[lowest], when=times[lowest],
                  energy=np.abs(energy).max() / table["external_work"].max())
    return result


# Shear of granular material ----------------------------------------------------------------------

SHEAR = """
&run  dimension='plane_strain'  method='{method}' /
&grid  lo=0,0,0  hi=0.5,1,1  dx={spacing} /
&time  t_end={end!r} /
&method  {words} /
&effects  artificial_viscosity=.false. /
&material  name='grains'  density={density}  bulk=5  shear=3  strength_model='granular'  gr_mode='total'
  {law} /
&boundary  face='xlo'  type='periodic' /
&boundary  face='xhi'  type='periodic' /
&boundary  face='zlo'  type='velocity'  velocity={low!r},0,0 /
&boundary  face='zhi'  type='velocity'  velocity={high!r},0,0 /
"""
SHEAR_RATE, SHEAR_MODULUS = 2.0, 3.0


def shear_stress(time, relaxation, rate=SHEAR_RATE):
    """Shear stress and half the first normal stress difference in simple shear that starts from rest."""
    w = rate * relaxation
    scale, angle, fade = SHEAR_MODULUS * w / (1.0 + w * w), rate * time, np.exp(-time / relaxation)
    return (scale * (1.0 - fade * (np.cos(angle) - w * np.sin(angle))),
            scale * (w - fade * (w * np.cos(angle) + np.sin(angle))))


@measured.recorded
def shear(options, name, method="ddmp", words="", cells=8, ppc=2, density=1.0e-4, relaxation=0.35,
          started=False, rate=SHEAR_RATE, survival=None, may_fail=False):
    """Plane shear between two boundaries that move parallel to themselves.

    The grains are at rest when the boundaries begin to move, or, with `started`, each layer has its steady velocity.
    They are so light that the first wave, which the formula does not include, has a stress of sqrt(G rho) V = 1.2 % of
    G/2. The strain is 2.6 at any `rate`. With `survival`, the strain that a contact survives, in place of `relaxation`,
    the stress does not depend on the rate. If rate times relaxation is above 1, the law itself gives a lower stress for
    a higher shear rate, and may split a uniform flow into shear bands.
    """
    relaxation = survival / rate if survival else relaxation
    law = f"gr_gamma_c={survival!r}" if survival else f"gr_tau={relaxation!r}"
    deck = SHEAR.format(method=method, words=words, spacing=1.0 / cells, density=density, law=law,
                        end=2.6 / rate, low=-0.5 * rate, high=0.5 * rate)
    layers = cells * ppc if started else 1
    for n in range(layers):
        low, high = n / layers, (n + 1) / layers
        speed = rate * (0.5 * (low + high) - 0.5)
        deck += f"&region name='r{n}' shape='box' lo=0,0,{low!r} hi=0.5,1,{high!r} /\n"
        deck += (f"&body name='b{n}' region='r{n}' material='grains' ppc={ppc},1,{ppc} "
                 f"velocity={speed!r},0,0 /\n")
    run, result = launch(options, name, deck, every=20, count=26, may_fail=may_fail)
    if result["code"]:
        return result
    seen, errors = [], []
    for time, snap in run.snapshots():
        stress = snap.fields["stress"]
        across, along = stress[:, 5 if stress.shape[1] == 6 else 2], stress[:, 0]
        exact = shear_stress(time, relaxation, rate)
        seen.append((time, across.mean(), along.mean(), *exact))
        errors.append((rms(across - exact[0]), rms(along - exact[1])))
    scale = SHEAR_MODULUS / 2.0        # the greatest steady shear stress
    errors = np.array(errors) / scale
    seen = np.array(seen)
    result.update(curve=seen, across=errors[:, 0].max(), along=errors[:, 1].max(),
                  mean=np.abs(seen[:, 1:3] - seen[:, 3:5]).max() / scale)
    return result
