# SPDX-License-Identifier: BSD-3-Clause
"""Presets of materials against published values (published.csv): sound speeds, shocks, elastic limits, detonations.

Would catch: constants of another material or another phase (the Hugoniot of iron above 13 GPa as that of steel), sets
mixed from two sources, a shear modulus that does not fit the bulk modulus, a failure stress that does not give the
elastic limit it is derived from, a preset without any check.

Moduli and shocks come from `scree --point`, so the whole path from the preset to the law is tested. Limits: 5 % for
sound speeds, whose tables are for typical specimens; 2 % for shock speeds up to 50 GPa, a target, against other authors
than those of the preset; 0.02 for Poisson's ratio; 1 % for densities and melting temperatures; half a unit of the last
printed digit for detonations and the elastic limit of borosilicate glass. Spall strengths stay below the ductile limit
of D. E. Grady (J. Mech. Phys. Solids 36 (1988) 353), (2 K Y 0.15)**0.5. For alloys without points of their own the
shocks are those of a relative: aluminium 1100, and the steels 304 and 347, which have no transition.
"""

import csv
import subprocess
from pathlib import Path

import numpy as np
import pytest

ROWS = [row for row in csv.DictReader(line for line in (Path(__file__).parent / "published.csv").open(encoding="ascii")
                                      if not line.startswith("#"))]
METALS = ("al_2024_t351", "al_2017_t4", "al_6061_t6", "cu_ofhc", "steel_4340", "lead", "steel_1006",
          "steel_weldox_700e", "tungsten_alloy", "ti_6al_4v")
STONES, EXPLOSIVES = ("granite", "concrete_c40"), ("tnt", "comp_b", "pbx_9404")
SOLIDS = (*METALS, "glass_soda_lime", "glass_borosilicate", *STONES)
PRESETS = (*SOLIDS, "concrete_48", "sand_dry", "glass_beads", *EXPLOSIVES)
DECK = """
&effects  damage={damage} /
&material  name='m'  preset='{preset}' /
&point  {path} /
"""
SMALL = 1.0e-7                          # strain of an elastic test
DIGIT = {"detonation": 5.0, "pressure": 0.05e9}


def point(options, preset, name, path, damage=False):
    """Table of `scree --point` by column."""
    folder = options.work / f"{preset}_{name}"
    folder.mkdir(parents=True, exist_ok=True)
    deck = DECK.format(preset=preset, path=path, damage=f".{str(damage).lower()}.")
    (folder / "path.nml").write_text(deck, encoding="ascii")
    subprocess.run([options.scree, "--point", "path.nml"], cwd=folder, check=True, capture_output=True, timeout=60)
    return np.genfromtxt(folder / "out" / "path" / "path_point.csv", delimiter=",", names=True)


def constants(options, preset):
    """Numbers of a preset by key, from `scree --explain`."""
    said = subprocess.run([options.scree, "--explain", preset], text=True, check=True, capture_output=True).stdout
    found = {}
    for line in said.splitlines():
        key, equals, rest = line.strip().partition(" = ")
        if equals:
            try:
                found[key] = float(rest.split()[0])
            except ValueError:
                pass
    return found


def moduli(options, preset):
    """Longitudinal and shear modulus at rest [Pa]."""
    along = point(options, preset, "along", f"path='uniaxial_strain'  strain=-{SMALL}  rate=1  steps=1")
    across = point(options, preset, "across", f"path='shear'  strain={SMALL}  rate=1  steps=1")
    return (abs(np.atleast_1d(along["xx"])[-1]) / SMALL,
            abs(np.atleast_1d(across["xy"])[-1]) / SMALL)


def published(preset, *kinds):
    """Published rows of a preset."""
    return [row for row in ROWS if row["preset"] == preset and row["quantity"] in kinds]


def test_all_presets_have_rows(options, sheet):
    """Would catch a new preset without an identity, and a row for a preset that does not exist."""
    listed = subprocess.run([options.scree, "--list", "materials"], text=True, check=True, capture_output=True).stdout
    names = {line.split()[0] for line in listed.partition("preset:")[2].splitlines() if line.strip()}
    sheet.require(names == set(PRESETS), f"presets of this test and of the program: {names ^ set(PRESETS)}")
    sheet.require({row["preset"] for row in ROWS} == set(PRESETS) - {"glass_beads"}, "each preset has published rows")


@pytest.mark.parametrize("preset", SOLIDS[:-1])
def test_sound(options, sheet, preset):
    """Sound speeds and Poisson's ratio of solids, density, melting."""
    set_of = constants(options, preset)
    along, across = moduli(options, preset)
    bulk = along - 4.0 / 3.0 * across
    own = {"longitudinal": np.sqrt(along / set_of["density"]), "shear": np.sqrt(across / set_of["density"]),
           "pure_shear": np.sqrt(across / set_of["density"]), "density": set_of["density"],
           "melting": set_of["t_melt"]}
    if "mg_c0" in set_of:
        sheet.near(f"{preset}: bulk modulus", bulk, set_of["density"] * set_of["mg_c0"] ** 2, 1.0e-5)
    for row in published(preset, *own):
        name = f"{preset}: {row['quantity']} of {row['of']}"
        value, kind = float(row["value"]), row["quantity"]
        if kind == "pure_shear":
            sheet.known(name, abs(own[kind] / value - 1.0), 0.25, 0.05)
        else:
            sheet.near(name, own[kind], value, 0.05 if kind in ("longitudinal", "shear") else 0.01)
    for row in published(preset, "range_longitudinal", "range_shear", "range_density"):
        name = row["quantity"].removeprefix("range_")
        sheet.require(float(row["at"]) <= own[name] <= float(row["value"]), f"{preset}: {name} {own[name]} in range")
    for row in published(preset, "poisson"):
        ratio = (3.0 * bulk - 2.0 * across) / (2.0 * (3.0 * bulk + across))
        sheet.below(f"{preset}: Poisson's ratio", abs(ratio - float(row["value"])), 0.02)


@pytest.mark.parametrize("preset", METALS[:-1])
def test_shocks(options, sheet, preset):
    """Shock speeds at published particle speeds. For titanium no points of other authors were read."""
    rows = published(preset, "shock", "dense")
    sheet.require(len(rows) >= 2, f"{preset}: there are published shocks")
    worst = 0.0
    for row in rows:
        speed = float(row["at"])
        found = point(options, preset, f"shock_{row['at']}", f"path='hugoniot'  speed={speed}  steps=1")
        error = abs(float(found["shock_speed"]) / float(row["value"]) - 1.0)
        if row["quantity"] == "shock":
            sheet.below(f"{preset}: shock speed of {row['of']} at {speed:.0f} m/s", error, 0.02)
            sheet.require(float(found["pressure"]) < 5.1e10, f"{preset}: up to 50 GPa")
        else:
            worst = max(worst, error)
    if worst:
        sheet.known(f"{preset}: shock speed above 13 GPa, of the dense phase of iron", worst, 0.2, 0.02)


@pytest.mark.parametrize("preset", METALS)
def test_spall(options, sheet, preset):
    """The spall strength is below the ductile limit, that of lead equals it."""
    set_of = constants(options, preset)
    limit = np.sqrt(0.3 * set_of["density"] * set_of["mg_c0"] ** 2 * set_of.get("jc_a", set_of.get("yield")))
    sheet.below(f"{preset}: spall strength over ductile limit", set_of["spall"] / limit, 1.0)
    if preset == "lead":
        sheet.near("lead: spall strength, two digits of the ductile limit", set_of["spall"], limit, 0.015)


@pytest.mark.parametrize("preset", STONES)
def test_cone(options, sheet, preset):
    """Strength without confinement, two digits, and slope of the cone; the failure stress is below both."""
    set_of = constants(options, preset)
    sine = np.sin(np.radians(set_of["friction_angle"]))
    found = {"strength": 2.0 * set_of["cohesion"] * np.sqrt(1.0 - sine ** 2) / (1.0 - sine),
             "slope": 6.0 * sine / (3.0 - sine) / 27.0 ** 0.5}
    rows = published(preset, *found)
    sheet.require(len(rows) > 0, f"{preset}: there are published strengths")
    for row in rows:
        sheet.near(f"{preset}: {row['quantity']}", found[row["quantity"]], float(row["value"]), 0.005)
    sheet.below(f"{preset}: failure stress over the strength", set_of["failure_stress"] / found["strength"], 0.1)


def test_crushed_concrete(options, sheet):
    """Strength of concrete in slow uniaxial compression, the greatest stress of a path with damage: above that of its
    cylinders, which is the unit of its published constants."""
    row, = published("concrete_48", "strength")
    path = point(options, "concrete_48", "press", "path='triaxial'  strain=-0.02  rate=1  steps=1000", damage=True)
    sheet.require(path["damage"][-1] > 0.5, "the damage grows on the path")
    sheet.known("concrete_48: strength in uniaxial compression over that of cylinders, less one",
                abs(path["xx"]).max() / float(row["value"]) - 1.0, 1.05, 0.05)


def test_elastic_limit(options, sheet):
    """Stress at which borosilicate glass fails in uniaxial strain, and the elastic limit of the set of soda-lime."""
    row, = published("glass_borosilicate", "hel")
    path = point(options, "glass_borosilicate", "limit", "path='uniaxial_strain'  strain=-0.15  rate=1e5  steps=3000",
                 damage=True)
    whole = path["failed"] < 0.5
    sheet.require(whole[0] and not whole[-1], "the glass fails on the path")
    sheet.near("glass_borosilicate: elastic limit", abs(path["xx"][whole]).max(), float(row["value"]),
               0.05 / 7.5)
    row, = published("glass_soda_lime", "measured_hel")
    found = constants(options, "glass_soda_lime")
    sheet.known("glass_soda_lime: elastic limit of the set against that measured later",
                abs(found["jh2_hel"] / float(row["value"]) - 1.0), 0.25, 0.04)


@pytest.mark.parametrize("preset", EXPLOSIVES)
def test_detonation(options, sheet, preset):
    """Speed and pressure of the slowest detonation that the constants allow."""
    set_of = constants(options, preset)
    path = point(options, preset, "detonation", "path='hugoniot'  speed=2600  steps=5200")
    slowest = np.argmin(path["shock_speed"])
    sheet.require(0 < slowest < len(path) - 1, f"{preset}: the minimum is inside the path")
    found = {"detonation": path["shock_speed"][slowest], "pressure": path["pressure"][slowest]}
    for row in published(preset, *found):
        value = float(row["value"])
        sheet.near(f"{preset}: {row['quantity']}", found[row["quantity"]], value, DIGIT[row["quantity"]] / value)
    sheet.near(f"{preset}: detonation_speed", set_of["detonation_speed"], found["detonation"], 1.0e-3)


def test_grains(options, sheet):
    """Packing, friction and sound speed of grains follow from the numbers of their sources."""
    sand, beads = constants(options, "sand_dry"), constants(options, "glass_beads")
    row, = published("sand_dry", "bulk")
    sheet.near("sand_dry: bulk sound speed", np.sqrt(sand["bulk"] / sand["density"]), float(row["value"]), 0.01)
    sheet.near("sand_dry: solid fraction", sand["solid_fraction"], sand["density"] / 2641.0, 0.001)
    sine = np.sin(np.radians(sand["friction_angle"]))
    sheet.near("sand_dry: first point of the yield curve", 6.0 * sine / (3.0 - sine), 4.235 / 3.401, 0.005)
    sheet.near("glass_beads: density", beads["density"], beads["solid_fraction"] * beads["grain_density"], 1.0e-6)
    for key, angle in (("mu_s", 20.9), ("mu_2", 32.76)):
        sheet.near(f"glass_beads: {key}", beads[key], np.tan(np.radians(angle)), 0.002)
