# SPDX-License-Identifier: BSD-3-Clause
"""Exact states of detonations with products of Jones, Wilkins and Lee, from the constants alone."""

from dataclasses import dataclass

import numpy as np


@dataclass
class Products:
    """Constants A, B [Pa], R1, R2, omega, E0 [Pa] and density of the explosive [kg/m3]."""
    stiff: float
    soft: float
    r1: float
    r2: float
    omega: float
    chemical: float
    density: float

    def pressure(self, volume, energy):
        """Pressure of a relative volume and an energy per reference volume."""
        return (self.stiff * (1.0 - self.omega / (self.r1 * volume)) * np.exp(-self.r1 * volume)
                + self.soft * (1.0 - self.omega / (self.r2 * volume)) * np.exp(-self.r2 * volume)
                + self.omega * energy / volume)

    def hugoniot(self, volume):
        """Pressure of the products behind a shock into the explosive."""
        cold = self.pressure(volume, self.chemical)
        return cold / (1.0 - 0.5 * self.omega * (1.0 - volume) / volume)

    def detonation(self):
        """Speed, pressure and relative volume at which the Rayleigh line touches the Hugoniot, where D is least."""
        low, high = 0.5, 0.95
        share = 0.5 * (np.sqrt(5.0) - 1.0)
        while high - low > 1.0e-9:
            one, other = high - share * (high - low), low + share * (high - low)
            if self.hugoniot(one) / (1.0 - one) < self.hugoniot(other) / (1.0 - other):
                high = other
            else:
                low = one
        volume = 0.5 * (low + high)
        pressure = self.hugoniot(volume)
        return np.sqrt(pressure / self.density / (1.0 - volume)), pressure, volume

    def isentrope(self, volume, start, pressure):
        """Pressure and energy on the isentrope through a state, from the closed form of JWL."""
        energy = self.chemical + 0.5 * pressure * (1.0 - start)
        term = (self.stiff / self.r1 * np.exp(-self.r1 * start) + self.soft / self.r2 * np.exp(-self.r2 * start))
        constant = (energy - term) * start ** self.omega
        energy = (self.stiff / self.r1 * np.exp(-self.r1 * volume) + self.soft / self.r2 * np.exp(-self.r2 * volume)
                  + constant * volume ** -self.omega)
        return self.pressure(volume, energy), energy

    def taylor_wave(self, count=20001, largest=3.0):
        """Self-similar flow behind a plane detonation from a wall: x/t, pressure and velocity from the wall to the
        front. Along it x/t = u + c and du = -sqrt(-dp dv) down to rest (G. I. Taylor, Proc. R. Soc. A 200, 1950)."""
        speed, pressure, start = self.detonation()
        volume = np.linspace(start, largest, count)
        along, _ = self.isentrope(volume, start, pressure)
        step = np.sqrt(np.maximum(-np.diff(along), 0.0) * np.diff(volume) / self.density)
        velocity = speed * (1.0 - start) - np.concatenate(([0.0], np.cumsum(step)))
        sound = volume * np.sqrt(-np.gradient(along, volume, edge_order=2) / self.density)
        keep = velocity > 0.0
        place, along, velocity = (velocity + sound)[keep], along[keep], velocity[keep]
        return (np.append(place, 0.0)[::-1], np.append(along, along[-1])[::-1], np.append(velocity, 0.0)[::-1])


TNT = Products(371.2e9, 3.231e9, 4.15, 0.95, 0.3, 7.0e9, 1630.0)
COMPOSITION_B = Products(524.23e9, 7.678e9, 4.2, 1.1, 0.34, 8.5e9, 1717.0)
