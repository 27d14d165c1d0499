# SPDX-License-Identifier: BSD-3-Clause
"""Heat conduction on the grid: a decaying wave, two bodies in contact, the time step, the balances.

Would catch: a flux with another gradient than its divergence, a heat capacity or conductivity that
is not that of the particle, heat lost at a boundary, at the edge of a tile or between materials, a step beyond the
stable one, temperature differences that nodes do not resolve and that do not decay, a material without a conductivity
that is heated, and any cost where no conductivity is given.

Closed solutions: cos(2 pi x) in an insulated slab decays as exp(-4 a pi**2 t), J0(w r) in an insulated cylinder as
exp(-a w**2 t); two half spaces in contact have the temperature (e1 T1 + e2 T2)/(e1 + e2) at the interface, e = sqrt(k
rho c), with error functions on both sides (H. S. Carslaw, J. C. Jaeger, Conduction of Heat in Solids, 1959, 2.15).
"""
# timeout: 120

import math

import numpy as np

import case
import convergence
import measured

# soft material, so that sound does not limit the step much
DENSITY, HEAT, BULK = 1000.0, 500.0, 1000.0
MEAN, WAVE = 400.0, 100.0
WAVE_CELLS, CYLINDER_CELLS = (19, 27, 39, 56), (13, 17, 22, 30)
METHODS = {
    "ddmp": ("ddmp", ""),
    "sub_points": ("ddmp", "quadrature='sub_points'"),
    "mpm": ("mpm", ""),
    "gimp": ("mpm", "basis='gimp'"),
}

HEAD = """
&run  dimension='{dimension}'  method='{method}' /
&units  system='si' /
&method  {words} /
&grid  lo=0,0,0  hi={high}  dx={spacing!r} /
&time  t_end={end!r} /
&effects  strength=.false.  thermal={thermal}  artificial_viscosity=.false. /
&boundary  face='all'  type='symmetry' /
&output  name='p'  kind='particles'  count=1  precision='double'
  fields='temperature','mass','volume' /
&checkpoint  at_end=.false. /
"""
MATERIAL = """
&material  name='{name}'  density={density!r}  eos_model='linear'  bulk={bulk!r}  specific_heat={heat!r}
  {more} /
"""
BODY = """
&region  name='{name}'  shape='box'  lo={low}  hi={high} /
&body  name='{name}'  region='{name}'  material='{material}'  ppc={points}  temperature={temperature!r} /
"""


def material(name, conductivity, density=DENSITY, heat=HEAT):
    """A material; with conductivity None it does not conduct heat."""
    more = "" if conductivity is None else f"conductivity={conductivity!r}"
    # the same speed of sound for all
    return MATERIAL.format(name=name, density=density, bulk=BULK * density / DENSITY, heat=heat, more=more)


def slab(cells, axis, method, words, diffusivity, end, dimension):
    """A slab with a thickness of one cell along an axis; every particle is a body with its own temperature."""
    spacing = 1.0 / cells
    size = [1.0 if place == axis else spacing * (place == 0 or dimension != "1d") or 1.0 for place in range(3)]
    text = HEAD.format(dimension=dimension, method=method, words=words, spacing=spacing, end=end,
                       thermal=".true.", high=",".join(map(repr, size)))
    text += material("m", diffusivity * DENSITY * HEAT)
    for site in range(2 * cells):
        place = (site + 0.5) / (2 * cells)
        low, high = [0.0] * 3, list(size)
        low[axis], high[axis] = site / (2 * cells), (site + 1) / (2 * cells)
        text += BODY.format(name=f"b{site}", material="m", points="2,2,2" if dimension == "3d" else "2,1,1",
                            low=",".join(map(repr, low)), high=",".join(map(repr, high)),
                            temperature=MEAN + WAVE * math.cos(2.0 * math.pi * place))
    return text


def heat_of(snapshot, capacity=HEAT):
    """Sum of m c T [J]."""
    return math.fsum(snapshot.fields["mass"] * capacity * snapshot.fields["temperature"])


def test_fading(options, sheet):
    """The wave on successively finer grids, for methods with different gradients."""
    diffusivity, end = 0.1, 0.125
    for name, (method, words) in METHODS.items():
        errors = []
        for cells in WAVE_CELLS:
            run = case.Case(options, f"wave_{name}_{cells}",
                            slab(cells, 0, method, words, diffusivity, end, "1d")).run("-q")
            (_, first), (_, last) = run.snapshots()[0], run.snapshots()[-1]
            place = last.points[:, 0]
            exact = MEAN + WAVE * math.exp(-4.0 * diffusivity * math.pi ** 2 * end) * np.cos(
                2.0 * math.pi * place)
            errors.append(np.sqrt(np.mean((last.fields["temperature"] - exact) ** 2)) / WAVE)
            moved = math.fsum(last.fields["mass"] * HEAT * np.abs(
                last.fields["temperature"] - first.fields["temperature"]))
            sheet.below(f"{name} {cells}: change of the heat", (heat_of(last) - heat_of(first)) / moved, 1.0e-12)
            sheet.below(f"{name} {cells}: change of the heat over the heat",
                        heat_of(last) / heat_of(first) - 1.0, 1.0e-13)
            sheet.require(np.abs(last.points - first.points).max() < 1.0e-12, "nothing moves")
        measured.show(f"{name}, errors", dict(enumerate(errors)))
        sheet.above(f"{name}: order", convergence.order(WAVE_CELLS, errors), 1.8)
        sheet.below(f"{name}: error on the finest grid", errors[-1], 3.0e-3)


def test_other_axes(options, sheet):
    """The same slab along y and z: the same numbers, so no component of the flux is exchanged with another."""
    for name in ("ddmp", "mpm"):
        method, words = METHODS[name]
        result = []
        for axis in range(3):
            deck = slab(8, axis, method, words, 0.1, 0.125, "3d")
            last = case.Case(options, f"axis_{name}_{axis}", deck).run("-q").snapshots()[-1][1]
            order = np.lexsort(np.delete(last.points, axis, axis=1).T.tolist() + [last.points[:, axis]])
            result.append(last.fields["temperature"][order])
        for axis in (1, 2):
            sheet.below(f"{name}: axis {axis}", np.abs(result[axis] - result[0]).max() / WAVE, 1.0e-13)
        sheet.above(f"{name}: what is left differs along the axis", np.ptp(result[0]) / WAVE, 0.5)


def bessel(x):
    """J0 by its series, exact enough up to x = 4."""
    return sum((-0.25 * x * x) ** n / math.factorial(n) ** 2 for n in range(25))


def test_cylinder(options, sheet):
    """A wave in an insulated cylinder: J0(w r) decays as exp(-a w**2 t), w the first zero of J1."""
    wave, diffusivity, end = 3.8317059702075123, 0.1, 0.3
    for name in ("ddmp", "mpm"):
        method, words = METHODS[name]
        errors = []
        for cells in CYLINDER_CELLS:
            spacing = 1.0 / cells
            text = HEAD.format(dimension="axisymmetric", method=method, words=words, spacing=spacing, end=end,
                               thermal=".true.", high=f"1,1,{spacing!r}").replace(
                "face='all'  type='symmetry'", "face='all'  type='slip'")
            text += material("m", diffusivity * DENSITY * HEAT)
            for site in range(2 * cells):
                place = (site + 0.5) / (2 * cells)
                text += BODY.format(name=f"b{site}", material="m", points="2,1,2", low=f"{site / (2 * cells)},0,0",
                                    high=f"{(site + 1) / (2 * cells)},1,{spacing!r}",
                                    temperature=MEAN + WAVE * bessel(wave * place))
            run = case.Case(options, f"cylinder_{name}_{cells}", text).run("-q")
            first, last = run.snapshots()[0][1], run.snapshots()[-1][1]
            exact = MEAN + WAVE * math.exp(-diffusivity * wave ** 2 * end) * bessel(wave * last.points[:, 0])
            errors.append(np.sqrt(np.average((last.fields["temperature"] - exact) ** 2,
                                             weights=last.fields["mass"])) / WAVE)
            sheet.below(f"cylinder {name} {cells}: change of the heat", heat_of(last) / heat_of(first) - 1.0, 1.0e-13)
        measured.show(f"cylinder {name}, errors", dict(enumerate(errors)))
        sheet.below(f"cylinder {name}: error", errors[-1], 2.0e-3)
        sheet.above(f"cylinder {name}: order", convergence.order(CYLINDER_CELLS, errors), 1.5)


def test_halves(options, sheet):
    """Two materials in contact, with effusivities 2 to 1 and a third body that insulates."""
    cells, end = 64, 0.04
    # conductivity, density, specific heat, temperature
    sides = ((50000.0, 1000.0, 500.0, 300.0), (12500.0, 1000.0, 500.0, 600.0))
    effusivity = [math.sqrt(side[0] * side[1] * side[2]) for side in sides]
    contact = sum(e * side[3] for e, side in zip(effusivity, sides)) / sum(effusivity)
    for name in METHODS:
        method, words = METHODS[name]
        text = HEAD.format(dimension="1d", method=method, words=words, spacing=1.0 / cells, end=end,
                           thermal=".true.", high="1.25,1,1")
        for number, side in enumerate(sides):
            text += material(f"m{number}", *side[:3])
            text += BODY.format(name=f"b{number}", material=f"m{number}", points="2,1,1",
                                low=f"{0.5 * number},0,0", high=f"{0.5 * number + 0.5},1,1", temperature=side[3])
        text += material("cover", None) + BODY.format(
            name="cover", material="cover", points="2,1,1", low="1,0,0", high="1.25,1,1", temperature=1000.0)
        run = case.Case(options, f"halves_{name}", text).run("-q")
        first, last = run.snapshots()[0][1], run.snapshots()[-1][1]
        place, found = last.points[:, 0] - 0.5, last.fields["temperature"]
        exact = np.empty_like(found)
        for number, side in enumerate(sides):
            length = 2.0 * math.sqrt(side[0] / (side[1] * side[2]) * end)
            here = (place >= 0.0) == (number == 1)
            exact[here] = contact + (side[3] - contact) * np.array(
                [math.erf(abs(x) / length) for x in place[here]])
        cover = place > 0.5
        jump = sides[1][3] - sides[0][3]
        error = np.abs(found - exact)[~cover] / jump
        near = np.argsort(np.abs(place))[:2]
        sheet.below(f"{name}: temperature where they touch", (found[near].mean() - contact) / jump, 0.01)
        sheet.below(f"{name}: greatest error", error.max(), 0.03)
        sheet.require(np.all(found[cover] == 1000.0), f"{name}: the cover keeps its temperature to the last bit")
        sheet.below(f"{name}: change of the heat", heat_of(last) / heat_of(first) - 1.0, 1.0e-13)


def test_longest_step(options, sheet):
    """Random temperatures at the greatest step: their differences only decrease. The limit of the step is named."""
    cells, diffusivity = 8, 100.0
    spacing = 1.0 / cells
    step = spacing ** 2 / (4.0 * diffusivity)
    head = dict(dimension="plane_strain", spacing=spacing, thermal=".true.", high=f"1,{spacing},1", end=300.0 * step)
    random = np.random.default_rng(5)
    body = material("m", diffusivity * DENSITY * HEAT)
    for site in range(cells * cells):
        x, z = site % cells * spacing, site // cells * spacing
        body += BODY.format(name=f"b{site}", material="m", points="1,1,2", low=f"{x},0,{z}",
                            high=f"{x + spacing},{spacing},{z + spacing}",
                            temperature=float(random.uniform(300.0, 500.0)))
    for name in METHODS:
        method, words = METHODS[name]
        text = HEAD.format(method=method, words=words, **head) + body
        run = case.Case(options, f"step_{name}", text)
        run.run("--check")
        sheet.require("s (heat conduction);" in run.output, f"{name}: --check names the cause of the step")
        run.run("-q")
        sheet.require(run.summary["steps"] == 300, f"{name}: {run.summary['steps']} steps of the greatest length")
        first, last = run.snapshots()[0][1].fields["temperature"], run.snapshots()[-1][1].fields["temperature"]
        sheet.below(f"{name}: spread after over before", np.std(last) / np.std(first), 1.0e-3)
    run = case.Case(options, "step_short", text.replace("&time ", f"&time  dt_min={2.0 * step!r} ")).run(
        "-q", expect=None)
    sheet.require(run.code != 0 and "heat conduction limits it" in " ".join(run.output.split()),
                  f"the message names the cause: {run.output}")


DISCS = """
&run  dimension='plane_strain'  method='{method}' /
&units  system='si' /
&method  {words} /
&grid  lo=0,0,0  hi=2,1,1  dx=0.0625 /
&time  t_end=3.0e-4 /
&effects  thermal=.true.  artificial_viscosity=.false. /
&material  name='energy'  density=1000  eos_model='mie_gruneisen'  mg_c0=2000  mg_s=1.5  mg_gamma=2  t_ref=300
  shear=1.0e9  strength_model='von_mises'  yield=1.0e8  specific_heat=500  {first} /
&material  name='other'  density=2000  specific_heat=800  t_ref=600  {second} /
&region  name='a'  shape='sphere'  centre=0.7,0,0.5  radius=0.28 /
&region  name='b'  shape='sphere'  centre=1.3,0,0.5  radius=0.28 /
&body  name='a'  region='a'  material='energy'  temperature=300  velocity=200,0,0 /
&body  name='b'  region='b'  material='other'  temperature=600  velocity=-200,0,0 /
&output  name='p'  kind='particles'  count=1  precision='double'  fields='temperature','mass','body','volume' /
&checkpoint  at_end=.false. /
"""


def test_collision(options, sheet):
    """Discs that collide: the energy is conserved, and heat of material without an internal energy is recorded."""
    energy = "eos_model='mie_gruneisen'  mg_c0=2000  mg_s=1.5  mg_gamma=1.5  shear=1.0e9"
    bare = "eos_model='linear'  young=5.0e9  poisson=0.3"
    for name in METHODS:
        # all of flip, for the recorded heat of the elastic disc is that of conduction only
        words = {"method": METHODS[name][0], "words": f"{METHODS[name][1]} flip=1"}
        with_flow = case.Case(options, f"discs_{name}", DISCS.format(
            first="conductivity=5.0e7", second=f"conductivity=1.0e8 {energy}", **words)).run("-q")
        without = case.Case(options, f"discs_{name}_off", DISCS.format(
            first="", second=energy, **words)).run("-q")
        ledger = with_flow.summary["ledger"]
        sheet.below(f"{name}: energy", ledger["energy_error"], 1.0e-12)
        hot = [run.snapshots()[-1][1].fields["temperature"].max() for run in (with_flow, without)]
        sheet.below(f"{name}: the hot disc cools [K]", hot[0], hot[1] - 10.0)
        mixed = case.Case(options, f"discs_{name}_bare", DISCS.format(
            first="conductivity=5.0e7", second=f"conductivity=1.0e8 {bare}", **words)).run("-q")
        # elastic material without a Grueneisen number changes its temperature by conduction only
        last = mixed.snapshots()[-1][1]
        other = last.fields["body"] == last.fields["body"].max()
        heat = math.fsum((last.fields["mass"] * 800.0 * (last.fields["temperature"] - 600.0))[other])
        ledger = mixed.summary["ledger"]
        booked = ledger["end"]["dissipated"]
        sheet.above(f"{name}: heat that crossed over the kinetic energy", -booked / ledger["start"]["kinetic"], 0.01)
        sheet.below(f"{name}: booked heat", booked / heat - 1.0, 1.0e-11)
        sheet.require("heat conduction" in with_flow.summary["timers"], "a row in the table of times")
        sheet.require("heat conduction" not in without.summary["timers"], "no row without a conductivity")
        sheet.above("bytes of the fields", with_flow.summary["bytes_per_particle"],
                    without.summary["bytes_per_particle"] + 8.0)
