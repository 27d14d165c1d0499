# SPDX-License-Identifier: BSD-3-Clause
"""scree --grains far from contact: elastic gases and cooling gases.

Would catch a stress without its kinetic part, with half of the contacts or another volume, a restitution that differs
in dense systems, energy created in collisions, and pairs that are found too late.
"""
# tiers: full, long
# timeout: 200
# timeout long: 2400

import numpy as np
import pytest

import case
import tier

GAS = """&grains  shape = '{shape}'  number = {number}  diameter = 1e-3  spread = 0  density = 2500
  stiffness = {stiffness}  restitution = {restitution}  friction = 0 /
&cell  volume_fraction = {solid}  speed = 0.03  seed = {seed} /
&stage  name = 'mix'  duration = {mix}  rows = 1  snapshots = 0 /
&stage  name = 'gas'  duration = {time}  rows = {rows}  snapshots = 0 /
"""
SPEED, DIAMETER, DENSITY = 0.03, 1e-3, 2500.0


def hard(shape, solid):
    """Compressibility factor and pair distribution at contact: Henderson for discs, Carnahan and Starling for
    spheres."""
    if shape == "discs":
        return (1 + solid**2 / 8) / (1 - solid)**2, (1 - 7 * solid / 16) / (1 - solid)**2
    return (1 + solid + solid**2 - solid**3) / (1 - solid)**3, (1 - solid / 2) / (1 - solid)**3


@pytest.mark.parametrize("shape, solid, number, stiffness", [
    ("discs", 0.5, 400, 4e6),
    ("spheres", 0.3, 343, 3e3),
])
def test_elastic(options, sheet, shape, solid, number, stiffness):
    """Pressure over kinetic pressure. Overlaps of s diameters reduce the effective diameter of the grains by about s; s
    follows from the collision speed, and the stiffness is chosen such that it changes the factor by less than a
    third of 1 %."""
    factors, worst = [], 0.0
    for seed in range(1, tier.choose(full=4, long=16)):
        one = case.Case(options, f"{shape}_{seed}", GAS.format(
            shape=shape, number=number, stiffness=stiffness, restitution=1, solid=solid, seed=seed, mix=0.02,
            time=tier.choose(full=0.15, long=0.6), rows=1)).run("--grains", "--quiet")
        history = one.history
        factors.append(history["pressure"][-1] / history["kinetic_pressure"][-1])
        worst = max(worst, abs(history["energy_error"][-1] / history["kinetic"][-1]))
    error = np.std(factors, ddof=1) / np.sqrt(len(factors))
    exact = hard(shape, solid)[0]
    sheet.note(f"{shape}, {solid}: factor {np.mean(factors):.4f} +- {error:.4f}, exact", exact)
    sheet.below(f"{shape}: difference from the factor, beyond two standard errors, over it",
                max(abs(np.mean(factors) - exact) - 2 * error, 0.0) / exact, 0.01)
    sheet.below(f"{shape}: standard error over the factor", error / exact, tier.choose(full=0.02, long=0.005))
    sheet.below(f"{shape}: error of the energy over the energy", worst, 1e-4)


def beyond_maxwell(e, d):
    """Second Sonine coefficient of a cooling gas."""
    return 16 * (1 - e) * (1 - 2 * e**2) / (9 + 24 * d + 8 * d * e - 41 * e + 30 * e**2 * (1 - e))


@pytest.mark.parametrize("shape, solid, number, stiffness, duration", [
    pytest.param("discs", 0.2, 225, 1e6, 1.0, marks=pytest.mark.tiers("long")),
    pytest.param("spheres", 0.15, 216, 7e2, 1.0, marks=pytest.mark.tiers("long")),
])
def test_cooling(options, sheet, shape, solid, number, stiffness, duration):
    """Temperature of a gas that cools by collisions, P. K. Haff, J. Fluid Mech. 134 (1983) 401, with the time of
    the Enskog kinetic theory: 1/t_H = (1 - e^2)/(2 d) times the collision frequency of a grain, times 1 + 3 a/16 for a
    velocity distribution that is not Maxwellian (T. P. C. van Noije, M. H. Ernst, Granular Matter 1 (1998) 57, quoted
    from memory): half a percent. Without this factor the final temperature of the spheres is off by 2.2 % more than two
    standard errors."""
    restitution, d = 0.9, 2 if shape == "discs" else 3
    solid_volume = np.pi / 4 * DIAMETER**2 if d == 2 else np.pi / 6 * DIAMETER**3
    ratios = []
    for seed in range(1, 21):
        history = case.Case(options, f"haff_{shape}_{seed}", GAS.format(
            shape=shape, number=number, stiffness=stiffness, restitution=restitution, solid=solid, seed=seed,
            mix=0.02, time=duration, rows=8)).run("--grains", "--quiet").history
        temperature = 2 * history["kinetic"] / (d * number * DENSITY * solid_volume)
        temperature, time = temperature[1:], history["time"][1:] - history["time"][1]
        sphere = (2 * np.sqrt(np.pi) * DIAMETER if d == 2 else 4 * np.sqrt(np.pi) * DIAMETER**2)
        frequency = sphere * hard(shape, solid)[1] * solid / solid_volume * np.sqrt(temperature[0])
        rate = (1 - restitution**2) / (2 * d) * frequency * (1 + 3 / 16 * beyond_maxwell(restitution, d))
        ratios.append(temperature * (1 + rate * time)**2 / temperature[0])
    mean, error = np.mean(ratios, axis=0), np.std(ratios, axis=0, ddof=1) / np.sqrt(len(ratios))
    sheet.require((rate * time)[-1] > 1.0, f"{shape}: the gas has cooled, t/t_H = {(rate * time)[-1]}")
    sheet.note(f"{shape}: T over Haff's law at the end", f"{mean[-1]:.4f} +- {error[-1]:.4f}")
    sheet.below(f"{shape}: greatest difference from Haff's law, beyond two standard errors",
                np.maximum(np.abs(mean - 1.0) - 2 * error, 0.0).max(), 0.02)
    sheet.below(f"{shape}: standard error of the mean", error.max(), 0.02)
