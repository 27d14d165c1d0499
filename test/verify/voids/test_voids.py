# SPDX-License-Identifier: BSD-3-Clause
"""Voids of failed material open and close in whole runs; heat and shear change them as in closed solutions.

Would catch: the volume of the motion where that of the material is needed, voids whose opening requires work, that do
not close where they opened, or leave a pressure behind; a solid fraction that is lost in a restart; a wrong sign or
factor of B, and heat that is conducted but does not expand grains.

Closed solutions: material that opens without pressure keeps theta V; closed voids leave the pressure K (V0/V - 1) of
intact material; crushing with alpha = (theta - c)/(1 - c) integrates to (1 - theta)/theta = (1 - theta_0)/theta_0
(V/V0)**(1/(1 - c)); heating by dT gives theta exp(b dT), shear by g of compressed grains theta exp(-b g), both at
constant volume. The fraction alpha follows the state of the previous step, so it is late by one step: crushing may be
off by the change of one step, shear is off by that.
"""
# timeout: 120

import subprocess

import numpy as np

import case
import convergence

DENSITY, BULK, SHEAR = 1000.0, 1.0e9, 6.0e8
# One cell between a wall and a moving boundary: the strain of a step is -1e-4 or 1e-4 for all particles.
CYCLE = """
&run  dimension='1d'  method='{method}' /
&units  system='si' /
&grid  lo=0,0,0  hi=1,1,1  dx=1 /
&time  t_end=0.05  dt_fixed=1.0e-3 /
&effects  damage={damage}  voids={damage}  artificial_viscosity=.false. /
{update}
&material  name='m'  density=1000  bulk=1.0e9  shear=6.0e8  {words} /
&region  name='b'  shape='box'  lo=0,0,0  hi=1,1,1 /
&body  name='b'  region='b'  material='m'  ppc=2,1,1 /
&boundary  face='xlo'  type='slip' /
&boundary  face='xhi'  type='velocity'  velocity=0.1,0,0 /
&output  name='p'  kind='particles'  every=2  precision='double'
  fields='failed','volume','stress','mass'{fields} /
"""
FAILS = "damage_model='principal_stress'  failure_stress=1.0e5"
OVEN = """
&run  dimension='1d' /
&units  system='si' /
&grid  lo=0,0,0  hi=1,1,1  dx=0.125 /
&time  t_end=2.0 /
&effects  voids=.true.  thermal=.true.  artificial_viscosity=.false. /
&material  name='m'  density=600  bulk=1000  shear=500  strength_model='drucker_prager'  friction_angle=30
  solid_fraction=0.6  critical_packing=0.8  b_thermal=1.0e-4  specific_heat=500  conductivity=3.0e4 /
&region  name='cold'  shape='box'  lo=0,0,0  hi=0.5,1,1 /
&region  name='hot'  shape='box'  lo=0.5,0,0  hi=1,1,1 /
&body  name='cold'  region='cold'  material='m'  ppc=2,1,1  temperature=300 /
&body  name='hot'  region='hot'  material='m'  ppc=2,1,1  temperature=900 /
&boundary  face='all'  type='symmetry' /
&output  name='p'  kind='particles'  count=1  precision='double'  fields='temperature','solid_fraction' /
"""
SHEARED = """
&effects  voids=.true. /
&material  name='m'  density=700  bulk=1.0e9  shear=1.0e7  strength_model='drucker_prager'  friction_angle=30
  solid_fraction=0.7  critical_packing=0.5  b_shear={factor} /
&point  path='free'  velocity_gradient={press},0,0,1,{press},0,0,0,{press}  strain=0.2  steps={steps} /
"""


def pressure(snapshot):
    """Mean pressure of the particles [Pa]."""
    return -snapshot.fields["stress"][:, :3].sum(axis=1) / 3.0


def cycle(options, name, method, words, damage=".true."):
    """Expand by half a percent, then compress to 1.5 % less than the initial volume; the snapshots of both."""
    fields = ",'solid_fraction'" if damage == ".true." else ""
    # both with the update of material that fails
    update = "&method stress_update='usl' /" if method == "ddmp" else ""
    text = CYCLE.format(method=method, words=words, damage=damage, fields=fields, update=update)
    if damage == ".false.":
        text = text.replace("'failed',", "")
    run = case.Case(options, name, text).run("-q", "--force")
    run.run("-q", "--force", "--restart", "-s", "boundary[2].velocity=-0.1,0,0", "-s", "time.t_end=0.25", "-s",
            "output.every=10")
    return [snapshot for _, snapshot in run.snapshots()]


def test_open_and_close(options, sheet):
    """The rules of voids, with rubble and with a law of failed material."""
    for method in ("ddmp", "mpm"):
        intact = cycle(options, f"intact_{method}", method, "", ".false.")
        volume = intact[-1].fields["volume"]
        exact = BULK * (0.5 / volume - 1.0)
        sheet.below(f"{method}: pressure of intact matter", np.abs(pressure(intact[-1]) / exact - 1.0).max(), 1.0e-12)
        for rule in ("one", "open_when_failed", "crush") if method == "ddmp" else ("open_when_failed",):
            for remains in ("rubble", "granular"):
                name = f"{method}_{rule}_{remains}"
                words = f"{FAILS}  alpha_m='{rule}'  failed_as='{remains}'"
                words += "  failed_gamma_c=0.3" if remains == "granular" else ""
                check_cycle(sheet, name, cycle(options, name, method, words), intact, rule)


def check_cycle(sheet, name, states, intact, rule):
    """Mass, work, solid fraction and pressure along a cycle."""
    broken = [n for n, state in enumerate(states) if np.all(state.fields["failed"] == 1)]
    widest = int(np.argmax([state.fields["volume"][0] for state in states]))
    sheet.require(0 < broken[0] < 5 and widest > 20, f"{name}: fails early, then opens")
    sheet.require(all(np.array_equal(state.fields["mass"], states[0].fields["mass"]) for state in states),
                  f"{name}: the mass is the same to the last bit")
    sheet.require(np.array_equal(states[-1].fields["volume"], intact[-1].fields["volume"]),
                  f"{name}: volumes are those of intact matter")
    opening = closing = 0.0
    for n in range(broken[0], len(states) - 1):
        one, two = states[n].fields, states[n + 1].fields
        work = -np.sum(0.5 * (pressure(states[n]) + pressure(states[n + 1])) * (two["volume"] - one["volume"]))
        opening += abs(work) * (n < widest)
        closing += work * (n >= widest)
    elastic = 0.5 * BULK * 0.01 ** 2
    sheet.below(f"{name}: work of opening over that of closing", opening / closing, 1.0e-12)
    sheet.above(f"{name}: work of closing", closing, elastic)
    kept = [state.fields["solid_fraction"] * state.fields["volume"] for state in states[broken[0]:]]
    theta = states[-1].fields["solid_fraction"]
    if rule == "one":
        sheet.require(all(np.all(state.fields["solid_fraction"] == 1.0) for state in states), f"{name}: no voids")
    else:
        sheet.below(f"{name}: theta V while open", np.abs(kept[widest - broken[0]] / kept[0] - 1.0).max(), 1.0e-13)
        sheet.require(states[widest].fields["solid_fraction"].max() < 0.996, f"{name}: voids open")
        sheet.require(np.all(theta == 1.0), f"{name}: voids close")
    last = pressure(states[-1])
    sheet.below(f"{name}: pressure after closing over that of intact matter",
                np.abs(last / pressure(intact[-1]) - 1.0).max(), 1.0e-12)
    density = DENSITY * (1.0 + last / (BULK * theta))
    mass = theta * density * states[-1].fields["volume"]
    sheet.below(f"{name}: theta rho V over m", np.abs(mass / states[-1].fields["mass"] - 1.0).max(), 1.0e-13)


def test_crushing(options, sheet):
    """Loose grains that are compressed: voids that close permanently, against the integral."""
    share, rest = 0.8, 0.2
    words = f"{FAILS}  alpha_m='crush'  solid_fraction=0.8"
    states = cycle(options, "crushed", "ddmp", words)
    last, begin = states[-1].fields, 0.5
    theta = last["solid_fraction"]
    # below the initial volume grains touch
    void = (1.0 - share) / share * (last["volume"] / begin) ** (1.0 / rest)
    step = 1.0e-4 * (1.0 - share) / rest           # strain of a step times d ln theta/d ln V at the start
    sheet.below("share of crushed grains", np.abs(theta * (1.0 + void) - 1.0).max(), step)
    sheet.require(np.all(theta > share + 1.0e-3), "grains are crushed")
    matter = share * begin / (theta * last["volume"])
    expected = theta * BULK * (matter - 1.0)
    sheet.below("pressure of crushed grains", np.abs(pressure(states[-1]) / expected - 1.0).max(), 1.0e-9)


def test_fractured(options, sheet):
    """Glass with JH-2: opens without work, and closes to the pressure of its density and of bulking."""
    glass = ("density=2530  shear=30.4e9  eos_model='jh2'  strength_model='jh2'  damage_model='jh2'  jh2_k1=45.4e9  "
             "jh2_k2=-138e9  jh2_k3=290e9\n jh2_a=0.93  jh2_n=0.77  jh2_b=0.088  jh2_m=0.35  jh2_c=0.003\n "
             "jh2_t=0.15e9  jh2_fmax=0.5\n jh2_hel=5.95e9  jh2_phel=2.92e9  jh2_d1=0.0053  jh2_d2=0.85  jh2_beta=1")
    text = CYCLE.replace("density=1000  bulk=1.0e9  shear=6.0e8", "").replace(
        "t_end=0.05", "t_end=0.6").replace("velocity=0.1,", "velocity=-0.3,").replace("every=2", "every=50")
    text = text.format(method="ddmp", words=glass, damage=".true.", update="", fields=",'solid_fraction','bulking'")
    run = case.Case(options, "glass", text).run("-q", "--force")
    for speed, end in ((0.3, 1.4), (-0.3, 2.1)):
        run.run("-q", "--force", "--restart", "-s", f"boundary[2].velocity={speed},0,0", "-s", f"time.t_end={end}")
    states = [snapshot.fields for _, snapshot in run.snapshots()]
    volumes = [state["volume"][0] for state in states]
    widest = int(np.argmax(volumes))
    sheet.require(np.all(states[-1]["failed"] == 1) and np.all(states[-1]["bulking"] > 1.0e7), "glass makes pressure")
    sheet.require(np.all(states[widest]["solid_fraction"] < 0.99), "voids open between its pieces")
    sheet.below("stress of glass that is open [Pa]", np.abs(states[widest]["stress"][:, :3].sum(axis=1)).max(), 0.0)
    last = states[-1]
    mu = 0.5 / last["volume"] - 1.0
    expected = 45.4e9 * mu - 138e9 * mu ** 2 + 290e9 * mu ** 3 + last["bulking"]
    found = -last["stress"][:, :3].sum(axis=1) / 3.0
    sheet.require(np.all(last["solid_fraction"] == 1.0) and np.all(mu > 0.02), "voids close")
    sheet.below("pressure of closed glass", np.abs(found / expected - 1.0).max(), 1.0e-12)


def test_heated(options, sheet):
    """Grains that conduct heat to each other expand into their voids; nothing moves."""
    run = case.Case(options, "oven", OVEN).run("-q", "--force")
    last = run.snapshots()[-1][1]
    first = np.where(last.points[:, 0] < 0.5, 300.0, 900.0)
    change = last.fields["temperature"] - first
    sheet.above("temperatures change [K]", np.ptp(change), 300.0)
    expected = 0.6 * np.exp(1.0e-4 * change)
    sheet.below("share of heated grains", np.abs(last.fields["solid_fraction"] / expected - 1.0).max(), 1.0e-6)


def point(options, name, deck):
    """The table of a path of one point."""
    folder = options.work / name
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "path.nml").write_text(deck, encoding="ascii")
    done = subprocess.run([options.scree, "--point", "path.nml"], cwd=folder, text=True, capture_output=True,
                          check=False)
    if done.returncode != 0:
        raise SystemExit(f"{name}: exit code {done.returncode}\n{done.stdout}{done.stderr}")
    return np.genfromtxt(folder / "out" / "path" / "path_point.csv", delimiter=",", names=True)


def test_sheared(options, sheet):
    """Compressed grains dilate in shear: theta decreases with shear, the density of the material increases."""
    factor, press, errors, grids = 0.5, -0.05, [], (150, 220, 290, 400)
    for steps in grids:
        table = point(options, f"shear_{steps}", SHEARED.format(factor=factor, press=press, steps=steps))
        errors.append(table["solid_fraction"][-1] / (0.7 * np.exp(-factor * 0.2)) - 1.0)
        volume = np.exp(3.0 * press * 0.2)
        matter = 1.0 / volume * 0.7 / table["solid_fraction"][-1]
        sheet.near(f"pressure with {steps} steps", table["pressure"][-1],
                   table["solid_fraction"][-1] * BULK / 1.0 * (matter - 1.0), 1.0e-9)
    print("sheared: errors of the share", *[f"{error:.2e}" for error in errors])
    for steps, error in zip(grids, errors):
        # grains have no pressure in the first step, so they do not dilate in it
        sheet.near(f"share of sheared grains, {steps} steps: its error", error, np.expm1(factor * 0.2 / steps), 1.0e-3)
    sheet.above("order of the share", convergence.order(grids, errors), 0.95)
