# SPDX-License-Identifier: BSD-3-Clause
"""Tables of an equation of state for eos_model = 'table': p and e over density and temperature.

    axis(0.01, 10.0, 40)                          40 densities with equal ratios
    ideal_gas(densities, temperatures, 1.4, 717.5)
    mie_gruneisen(densities, temperatures, Solid(2785.0, 5328.0, 1.338, 2.0, 900.0))
    write(path, densities, temperatures, pressure, energy, "aluminium")
"""
from __future__ import annotations

from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

if TYPE_CHECKING:
    from scree.arrays import Array


class Solid(NamedTuple):
    """Constants of eos_model = 'mie_gruneisen', specific heat, and the temperature at which e = 0."""

    density: float                                       # at rest [kg/m3]
    sound: float                                         # [m/s]
    slope: float
    gamma: float
    heat: float                                          # specific heat [J/(kg K)]
    zero: float = 293.0                                  # temperature at which e = 0 [K]



def axis(least: float, greatest: float, count: int) -> Array:
    """Numbers with equal ratios and exact end values."""
    numbers = np.geomspace(least, greatest, count)
    numbers[[0, -1]] = least, greatest
    return numbers


def ideal_gas(densities: Array, temperatures: Array, gamma: float, heat: float) -> tuple[Array, Array]:
    """Pressure and energy (density, temperature) of p = (gamma - 1) rho e with e = c_v T."""
    density, temperature = np.meshgrid(densities, temperatures, indexing="ij")
    energy = heat * temperature
    return (gamma - 1.0) * density * energy, energy


def solid_curves(volume: float, solid: Solid) -> tuple[float, float]:
    """Pressure at zero energy A and its derivative with respect to the energy G, p = A + G e, at a specific volume."""
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


def cold_energies(densities: Array, solid: Solid) -> Array:
    """Energy along the densities at the temperature at which e = 0 at rest: a free energy F = e_c(v) + c_v (T - T0 - T
    ln(T/T0) - T g(v)) with g' = G gives p = A + G e and rho**2 de/drho = p - T dp/dT, if -de_c/dv = A + G (e_c - c_v
    T0)."""
    from scipy.integrate import solve_ivp

    def slope(volume: float, energy: Array) -> Array:
        cold, heating = solid_curves(volume, solid)
        return np.asarray(-(cold + heating * (energy - solid.heat * solid.zero)))

    rest = 1.0 / solid.density
    volumes = 1.0 / np.asarray(densities, dtype=np.float64)
    found = np.zeros(len(volumes))
    for side in (volumes < rest, volumes > rest):        # the curves have a kink at the state of rest
        if side.any():
            order = np.flatnonzero(side)[np.argsort(np.abs(volumes[side] - rest))]
            found[order] = solve_ivp(slope, (rest, volumes[order[-1]]), [0.0], "DOP853", volumes[order], rtol=1.0e-12,
                                     atol=1.0e-12 * solid.sound ** 2).y[0]
    return found


def mie_gruneisen(densities: Array, temperatures: Array, solid: Solid) -> tuple[Array, Array]:
    """Pressure and energy (density, temperature) of a free energy with constant specific heat, whose pressure as a
    function of density and energy is that of eos_model = 'mie_gruneisen'."""
    cold = cold_energies(densities, solid)
    curves = np.array([solid_curves(1.0 / density, solid) for density in densities])
    energy = cold[:, None] + solid.heat * (np.asarray(temperatures)[None, :] - solid.zero)
    return curves[:, :1] + curves[:, 1:] * energy, energy


def write(path: str, densities: Array, temperatures: Array, pressure: Array, energy: Any, title: str) -> None:
    """Write a table; densities and temperatures ascend."""
    with open(path, "w", encoding="ascii") as file:
        file.write(f"# {title}\n# {len(densities)} densities, each with {len(temperatures)} temperatures\n"
                   "density[kg/m3] temperature[K] pressure[Pa] energy[J/kg]\n")
        for i, density in enumerate(densities):
            for j, temperature in enumerate(temperatures):
                file.write(f"{density:.16e} {temperature:.16e} {pressure[i, j]:.16e} {energy[i, j]:.16e}\n")
