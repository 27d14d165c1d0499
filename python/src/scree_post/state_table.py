# SPDX-License-Identifier: BSD-3-Clause
"""Tables of an equation of state, as eos_model = 'table' reads them: p and e over density and temperature.

    axis(0.01, 10.0, 40)                          40 densities with equal ratios
    ideal_gas(densities, temperatures, 1.4, 717.5)
    mie_gruneisen(densities, temperatures, Solid(2785.0, 5328.0, 1.338, 2.0, 900.0))
    write(path, densities, temperatures, pressure, energy, "aluminium")
"""
from collections import namedtuple

import numpy as np

#: Constants of eos_model = 'mie_gruneisen', specific heat [J/(kg K)] and the temperature at which e = 0 [K].
Solid = namedtuple("Solid", "density sound slope gamma heat zero", defaults=(293.0,))
STEPS = 400              # of the integration of the cold energy between two densities


def axis(least, greatest, count):
    """Numbers with equal ratios, the ends exact."""
    numbers = np.geomspace(least, greatest, count)
    numbers[[0, -1]] = least, greatest
    return numbers


def ideal_gas(densities, temperatures, gamma, heat):
    """Pressure and energy (density, temperature) of p = (gamma - 1) rho e with e = c_v T."""
    density, temperature = np.meshgrid(densities, temperatures, indexing="ij")
    energy = heat * temperature
    return (gamma - 1.0) * density * energy, energy


def solid_curves(volume, solid):
    """Pressure without energy A and its growth with energy G of p = A + G e at a specific volume."""
    ratio = volume * solid.density                       # rho0/rho
    y, strain = 1.0 / ratio, 1.0 - ratio
    bulk = solid.density * solid.sound ** 2
    if y >= 1.0:
        hugoniot = bulk * strain / (1.0 - solid.slope * strain) ** 2
        return hugoniot * (1.0 - 0.5 * solid.gamma * strain), solid.gamma * solid.density
    d = 1.0 - y
    vapour = min(1.0, 2.0 * solid.gamma)
    heating = solid.density * y * (solid.gamma * (1.0 + d) - (2.0 * solid.gamma - vapour) * d * d)
    return -bulk * y * y * d - heating * 0.5 * solid.sound ** 2 * d * d, heating


def cold_energies(densities, solid):
    """Energy at the temperature at which e = 0 at rest, along the densities: of a free energy
    F = e_c(v) + c_v (T - T0 - T ln(T/T0) - T g(v)) with g' = G follow p = A + G e and rho**2 de/drho = p - T dp/dT,
    if -de_c/dv = A + G (e_c - c_v T0)."""
    def slope(volume, energy):
        cold, heating = solid_curves(volume, solid)
        return -(cold + heating * (energy - solid.heat * solid.zero))

    def run(start, energy, end):
        h = (end - start) / STEPS
        for n in range(STEPS):
            v = start + n * h
            a = slope(v, energy)
            b = slope(v + 0.5 * h, energy + 0.5 * h * a)
            c = slope(v + 0.5 * h, energy + 0.5 * h * b)
            energy += h / 6.0 * (a + 2.0 * b + 2.0 * c + slope(v + h, energy + h * c))
        return energy

    found = {}
    for part in (sorted(d for d in densities if d >= solid.density),
                 sorted((d for d in densities if d < solid.density), reverse=True)):
        place, energy = 1.0 / solid.density, 0.0
        for density in part:
            energy = run(place, energy, 1.0 / density)
            place = 1.0 / density
            found[density] = energy
    return np.array([found[density] for density in densities])


def mie_gruneisen(densities, temperatures, solid):
    """Pressure and energy (density, temperature) of a free energy whose p of density and energy is that of
    eos_model = 'mie_gruneisen', with a constant specific heat."""
    cold = cold_energies(densities, solid)
    curves = np.array([solid_curves(1.0 / density, solid) for density in densities])
    energy = cold[:, None] + solid.heat * (np.asarray(temperatures)[None, :] - solid.zero)
    return curves[:, :1] + curves[:, 1:] * energy, energy


def write(path, densities, temperatures, pressure, energy, title):
    """Write a table; densities and temperatures ascend."""
    with open(path, "w", encoding="ascii") as file:
        file.write(f"# {title}\n# {len(densities)} densities, each with {len(temperatures)} temperatures\n"
                   "density[kg/m3] temperature[K] pressure[Pa] energy[J/kg]\n")
        for i, density in enumerate(densities):
            for j, temperature in enumerate(temperatures):
                file.write(f"{density:.16e} {temperature:.16e} {pressure[i, j]:.16e} {energy[i, j]:.16e}\n")
