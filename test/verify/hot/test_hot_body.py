# SPDX-License-Identifier: BSD-3-Clause
# timeout: 120
"""Initial temperature and energy of bodies.

Would catch a hot solid under the pressure of an oven that it filled while cold, or one of the density of the cold one;
a specific energy that sets no pressure or temperature; one that starts with the energy but without its stress; a
temperature that a specific energy contradicts without a word; and a state that a restart, or the driver of one
material point, does not have. Densities: the root of the pressure of the law, found here, and the coefficient of
thermal expansion of copper, 3 x 16.5e-6/K of handbooks, within 5 %.
"""

import csv
import math

import pytest

import case

DECK = """
&run  dimension='1d' /
&grid  lo=0,0,0  hi=0.1,1,1  dx=0.005 /
&time  t_end=2e-5 /
&effects  thermal=.true.  strength={strength} /
&material  name='m'  density={density!r}  specific_heat={heat!r}  {law} /
&region  name='r'  shape='box'  lo=0,0,0  hi=0.1,1,1 /
&body  name='b'  region='r'  material='m'  {body} /
&boundary  face='xlo'  type='slip' /
&boundary  face='xhi'  type='slip' /
&output  name='p'  kind='particles'  count=2  precision='double'
  fields='pressure','temperature','velocity'{more} /
"""
MIE = "eos_model='mie_gruneisen'  mg_c0=5350  mg_s=1.34  mg_gamma=2.0"
TILLOTSON = ("eos_model='tillotson'  till_a=0.5  till_b=1.63  till_bulk=75.2e9  till_square=65.0e9"
             "  till_e0=5.0e6  till_eiv=3.0e6  till_ecv=13.9e6  till_alpha=5.0  till_beta=5.0")
JWL = ("eos_model='jwl'  jwl_a=371.2e9  jwl_b=3.231e9  jwl_r1=4.15  jwl_r2=0.95  jwl_omega=0.3  jwl_e0=7.0e9")
HEAT, RISE = 900.0, 100.0
ENERGY = HEAT * RISE


def jwl_pressure():
    """Pressure of the products of TNT in the volume of the explosive, with the energy of the rise."""
    energy = 7.0e9 + 1630.0 * ENERGY
    return (371.2e9 * (1 - 0.3 / 4.15) * math.exp(-4.15) + 3.231e9 * (1 - 0.3 / 0.95) * math.exp(-0.95) + 0.3 * energy)


# density, law, pressure at t_ref + 100 K from the equation of the law, whether it carries the energy, strength
LAWS = {
    "mie_gruneisen": (2700.0, MIE, 2.0 * 2700 * ENERGY, True, ".false."),
    "mie_gruneisen with strength": (2700.0, MIE + "  shear=26.0e9  strength_model='von_mises'  yield=1.0e8",
                                    2.0 * 2700 * ENERGY, True, ".true."),
    "tillotson": (2700.0, TILLOTSON, (0.5 + 1.63 / (ENERGY / 5.0e6 + 1)) * 2700 * ENERGY, True, ".false."),
    "ideal_gas": (1.2, "eos_model='ideal_gas'  ig_gamma=1.4", 0.4 * 1.2 * HEAT * 393.0, True, ".false."),
    "jwl": (1630.0, JWL, jwl_pressure(), True, ".false."),
    # laws without thermal expansion
    "linear": (2700.0, "eos_model='linear'  bulk=76.0e9", 0.0, False, ".false."),
    "tait": (1000.0, "eos_model='tait'  tait_n=7  bulk=2.2e9", 0.0, False, ".false."),
    "elastic": (2700.0, "young=70.0e9  poisson=0.3", 0.0, False, ".true."),
}


EXPANDS = ("mie_gruneisen", "mie_gruneisen with strength", "tillotson")


def text(name, body="temperature=393", extra=""):
    """Deck of a law."""
    density, law, _, energy, strength = LAWS[name]
    return DECK.format(density=density, law=law + extra, body=body, heat=HEAT, strength=strength,
                       more=",'energy'" if energy else "")


@pytest.mark.parametrize("name", LAWS)
def test_laws(options, sheet, name):
    """Pressure at the start and after many steps: a clamped body of uniform temperature stays at rest."""
    pressure = LAWS[name][2]
    deck = text(name, f"specific_energy={ENERGY!r}") if name in EXPANDS else text(name)
    if name == "jwl":
        # burnt everywhere from the start: the centre of the detonation is in the past
        deck += "&detonation  point=0.05,0,0  time=-1 /\n"
    run = case.Case(options, name.replace(" ", "_"), deck).run("-q")
    first, last = run.snapshots()[0][1], run.snapshots()[-1][1]
    scale = max(abs(pressure), 1.0)
    for when, snap in (("start", first), ("end", last)):
        sheet.below(f"{name}: pressure at the {when}, relative error",
                    abs(snap.fields["pressure"] - pressure).max() / scale, 1e-9)
        sheet.below(f"{name}: temperature at the {when} [K]", abs(snap.fields["temperature"] - 393.0).max(), 1e-6)
        sheet.below(f"{name}: speed at the {when}", abs(snap.fields["velocity"]).max(), 1e-6)
    sheet.require(run.summary["steps"] > 2, f"{name}: makes steps")


def root(function, low, high):
    """Where a function that falls from low to high is zero."""
    for _ in range(200):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if function(middle) > 0.0 else (low, middle)
    return middle


def strain_pressure(name, strain):
    """Pressure at an expansion 1 - density over that at rest, and the energy of the rise."""
    if name == "tillotson":
        ratio = 1.0 - strain
        share = 1.0 + ENERGY / (5.0e6 * ratio ** 2)
        return (0.5 + 1.63 / share) * 2700 * ratio * ENERGY - 0.5 * 75.2e9 * ratio * (ratio + 1.0) * strain
    gamma = 2.0 * (1.0 + strain) - 3.0 * strain ** 2        # to its value of 1 in the vapour
    cold = 5350.0 ** 2 * strain
    return 2700 * (1.0 - strain) * (gamma * (ENERGY - 0.5 * cold * strain) - cold * (1.0 - strain))


@pytest.mark.parametrize("name", EXPANDS)
def test_expansion(options, sheet, name):
    """A hot solid starts without pressure and stays so, with the density at its temperature."""
    deck = text(name).replace("'energy'", "'energy','density'")
    run = case.Case(options, "hot_" + name.replace(" ", "_"), deck).run("-q")
    strain = root(lambda e: strain_pressure(name, e), 0.0, 0.1)
    for snap in (run.snapshots()[0][1], run.snapshots()[-1][1]):
        pressure = abs(snap.fields["pressure"]).max() / LAWS[name][2]
        sheet.below(f"{name}: pressure over the thermal stress", pressure, 1e-9)
        sheet.below(f"{name}: speed", abs(snap.fields["velocity"]).max(), 1e-6)
        sheet.below(f"{name}: temperature", abs(snap.fields["temperature"] - 393.0).max(), 1e-6)
        sheet.below(f"{name}: expansion, relative error",
                    abs((1.0 - snap.fields["density"] / 2700.0) / strain - 1.0).max(), 2e-3)
    sheet.require(run.summary["steps"] > 2, f"{name}: makes steps")


def test_copper(options, sheet):
    """The preset expands as copper does."""
    deck = text("mie_gruneisen", "temperature=393", "").replace("'energy'", "'energy','density'")
    head, tail = deck.split("&material")
    deck = head + "&material  name='m'  preset='cu_ofhc'" + tail[tail.index(" /\n&region"):]
    run = case.Case(options, "copper", deck).run("-q")
    expansion = 8930.0 / run.snapshots()[0][1].fields["density"] - 1.0
    sheet.near("expansion of copper by 100 K", float(expansion.mean()), 3 * 16.5e-6 * 100, 0.05)


def test_reference(options, sheet):
    """At t_ref, given or not, a solid has no pressure; t_ref moves the state."""
    for name, body, extra, pressure in (("given", "temperature=293", "", 0.0), ("default", "", "", 0.0),
                                        ("default at t_ref", "", "  t_ref=350", 0.0),
                                        ("above t_ref", "temperature=350", "  t_ref=300", 0.0)):
        run = case.Case(options, name.replace(" ", "_"), text("mie_gruneisen", body, extra)).run("-q")
        snap = run.snapshots()[-1][1]
        sheet.below(f"{name}: pressure", abs(snap.fields["pressure"] - pressure).max(), 1e-9 * 486e6)
        sheet.below(f"{name}: temperature", abs(snap.fields["temperature"] - (
            350.0 if "t_ref" in name else 293.0)).max(), 1e-6)


def test_energy(options, sheet):
    """specific_energy sets pressure and temperature; together with another temperature it is reported."""
    for name, body, pressure, temperature in (("mie_gruneisen", "specific_energy=9.0e4", 486.0e6, 393.0),
                                              ("ideal_gas", "specific_energy=3.6e5", 0.4 * 1.2 * 3.6e5, 400.0)):
        run = case.Case(options, f"energy_{name}", text(name, body)).run()
        snap = run.snapshots()[0][1]
        sheet.below(f"{name}: pressure, relative error", abs(snap.fields["pressure"] / pressure - 1).max(), 1e-12)
        sheet.below(f"{name}: temperature", abs(snap.fields["temperature"] - temperature).max(), 1e-9)
        sheet.require("D450" not in run.output, f"{name}: one of the keys alone is no contradiction")
        both = case.Case(options, f"both_{name}", text(name, body + "  temperature=500")).run()
        sheet.require("[D450]" in both.output and f"belongs to {temperature:g} K, not to temperature = 500 K"
                      in both.output, f"{name}: the contradiction is reported: {both.output[:400]}")


def test_bits(options, sheet):
    """Ranks and a restart."""
    deck = text("mie_gruneisen", f"specific_energy={ENERGY!r}").replace("hi=0.1,1,1 /\n&body", "hi=0.06,1,1 /\n&body")
    one = case.Case(options, "one", deck).run("-q").summary["digest"]
    sheet.require(case.Case(options, "two", deck, ranks=2).run("-q").summary["digest"] == one, "two ranks")
    run = case.Case(options, "stopped", deck).run("-q", "-s", "time.max_steps=5")
    sheet.require(run.summary["digest"] != one, "the middle is not the end")
    sheet.require(run.run("-q", "--restart").summary["digest"] == one, "restart")


def test_point(options, sheet):
    """The driver of one material point starts with the same state."""
    run = case.Case(options, "point", f"""
&effects  thermal=.true.  strength=.false. /
&material  name='m'  density=2700  specific_heat={HEAT}  {MIE} /
&point  path='hydrostatic'  strain=1e-9  steps=1  temperature=393 /
""").run("--point", "-q")
    with open(run.folder / "point_point.csv", encoding="utf-8") as file:
        rows = list(csv.reader(line for line in file if not line.startswith("#")))
    head = [word.split(" ")[0].split("[")[0].strip() for word in rows[0]]
    pressure = float(rows[1][head.index("pressure")])
    sheet.below("pressure over the thermal stress", abs(pressure) / 486.0e6, 1e-6)
