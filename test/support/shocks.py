# SPDX-License-Identifier: BSD-3-Clause
"""Closed solutions of shocks in solids and gases, independent of the program.

Mie-Grueneisen material with a linear Hugoniot Us = c0 + s up, as in doc/theory/equations_of_state.md, with the strength
of von Mises; and ideal gases. Roots by bisection, isentropes by a Runge-Kutta method.
"""

import dataclasses

import numpy as np


def solve(function, low, high):
    """Root between two positions with values of different sign."""
    sign = function(low) > 0.0
    assert sign != (function(high) > 0.0), "no change of sign"
    middle = low
    for _ in range(200):
        middle = 0.5 * (low + high)
        if (function(middle) > 0.0) == sign:
            low = middle
        else:
            high = middle
    return middle


@dataclasses.dataclass(frozen=True)
class Metal:
    """Constants in SI; without a shear modulus a fluid."""

    name: str
    density: float
    sound: float
    slope: float
    gamma: float
    shear: float = 0.0
    strength: float = 0.0

    def words(self):
        """Keys of &material in mm, us, mg."""
        text = (f"density={self.density / 1e3!r}  eos_model='mie_gruneisen'  mg_c0={self.sound / 1e3!r}  "
                f"mg_s={self.slope!r}  mg_gamma={self.gamma!r}")
        if self.strength:
            text += (f"  shear={self.shear / 1e9!r}  strength_model='von_mises'  yield={self.strength / 1e9!r}")
        return text

    def heating(self, density):
        """Grueneisen number times density; towards vapour the number tends to 1, or to twice that of the solid."""
        share, vapour = min(density / self.density, 1.0), min(1.0, 2.0 * self.gamma)
        return self.density * share * (vapour + (3.0 * self.gamma - 2.0 * vapour) * share
                                       - (2.0 * self.gamma - vapour) * share ** 2)

    def pressure(self, density, energy):
        """Equation of state; in expansion that of the energy c0^2 (1 - rho/rho0)^2/2 plus the heat above it."""
        bulk, strain = self.density * self.sound ** 2, 1.0 - self.density / density
        if strain > 0.0:
            cold = bulk * strain / (1.0 - self.slope * strain) ** 2 * (1.0 - 0.5 * self.gamma * strain)
            return cold + self.gamma * self.density * energy
        share = density / self.density
        heat = energy - 0.5 * self.sound ** 2 * (1.0 - share) ** 2
        return bulk * share ** 2 * (share - 1.0) + self.heating(density) * heat

    def shock(self, speed):
        """Shock speed, pressure, density and energy behind a shock in a fluid at rest."""
        front = self.sound + self.slope * speed
        return {"speed": front, "pressure": self.density * front * speed, "energy": 0.5 * speed ** 2,
                "density": self.density * front / (front - speed)}

    def released(self, speed, steps=4000):
        """Speed of a free surface behind a shock: u + integral of dp/(rho c) along the isentrope to p = 0."""
        start = self.shock(speed)

        def slopes(volume, state):
            """Derivatives of energy and velocity with respect to the specific volume; dp/dv along the isentrope by
            differences."""
            energy = state[0]
            pressure = self.pressure(1.0 / volume, energy)
            small = 1.0e-5 * volume
            tangent = (self.pressure(1.0 / (volume + small), energy - pressure * small)
                       - self.pressure(1.0 / (volume - small), energy + pressure * small)) / (2.0 * small)
            return np.array([-pressure, np.sqrt(max(-tangent, 0.0))])

        def integrate(end):
            volume, state = 1.0 / start["density"], np.array([start["energy"], speed])
            step = (end - volume) / steps
            for _ in range(steps):
                first = slopes(volume, state)
                second = slopes(volume + 0.5 * step, state + 0.5 * step * first)
                third = slopes(volume + 0.5 * step, state + 0.5 * step * second)
                fourth = slopes(volume + step, state + step * third)
                state = state + step / 6.0 * (first + 2.0 * second + 2.0 * third + fourth)
                volume += step
            return volume, state

        low, high = 1.0 / start["density"], 1.4 / self.density
        volume, state = integrate(1.0 / self.density)
        for _ in range(30):            # Newton: the pressure at the end falls with the volume
            pressure = self.pressure(1.0 / volume, state[0])
            pace = slopes(volume, state)[1]
            target = min(high, max(low, volume + pressure / pace ** 2))
            if abs(target / volume - 1.0) < 1.0e-12:
                break
            volume, state = integrate(target)
        return {"velocity": state[1], "energy": state[0], "density": 1.0 / volume}

    def precursor(self):
        """The elastic wave of a solid at its elastic limit, with logarithmic strain."""
        density = self.density * np.exp(self.strength / (2.0 * self.shear))
        jump = 1.0 / self.density - 1.0 / density
        stress = solve(lambda s: self.pressure(density, 0.5 * s * jump) + 2.0 / 3.0 * self.strength - s, 0.0, 1.0e11)
        return {"density": density, "stress": stress, "velocity": np.sqrt(stress * jump),
                "energy": 0.5 * stress * jump, "speed": np.sqrt(stress / jump) / self.density}

    def plastic(self, speed):
        """The second shock, into the state behind the elastic wave; its speed relative to material at rest."""
        ahead = self.precursor()

        def state(density):
            jump = 1.0 / ahead["density"] - 1.0 / density
            base = self.pressure(density, 0.0)
            heat = self.gamma * self.density   # pressure is linear in the energy
            energy = ((ahead["energy"] + 0.5 * (base + 2.0 / 3.0 * self.strength + ahead["stress"]) * jump)
                      / (1.0 - 0.5 * heat * jump))
            return self.pressure(density, energy) + 2.0 / 3.0 * self.strength, jump

        def excess(density):
            stress, jump = state(density)
            return ahead["velocity"] + np.sqrt(max(stress - ahead["stress"], 0.0) * jump) - speed

        density = solve(excess, ahead["density"] * (1.0 + 1.0e-9), 1.6 * self.density)
        stress, _ = state(density)
        flow = (stress - ahead["stress"]) / (speed - ahead["velocity"])
        return {"density": density, "stress": stress, "pressure": stress - 2.0 / 3.0 * self.strength,
                "speed": ahead["velocity"] + flow / ahead["density"]}


@dataclasses.dataclass(frozen=True)
class Gas:
    """Density, velocity and pressure of an ideal gas."""

    density: float
    velocity: float
    pressure: float


class Riemann:
    """Two ideal gases that touch at x = 0 from t = 0 on (E. F. Toro, *Riemann solvers*, ch. 4)."""

    def __init__(self, left, right, gamma):
        self.left, self.right, self.gamma = left, right, gamma
        self.sounds = [np.sqrt(gamma * side.pressure / side.density) for side in (left, right)]

        def excess(pressure):
            return (self.jump(0, pressure) + self.jump(1, pressure) + right.velocity - left.velocity)

        self.pressure = solve(excess, 1.0e-14 * max(left.pressure, right.pressure),
                              1.0e4 * max(left.pressure, right.pressure))
        self.velocity = 0.5 * (left.velocity + right.velocity
                               + self.jump(1, self.pressure) - self.jump(0, self.pressure))
        self.densities = [self.beside(side) for side in (0, 1)]

    def jump(self, side, pressure):
        """Change of velocity over a wave: shock or fan."""
        gas, sound, gamma = (self.left, self.right)[side], self.sounds[side], self.gamma
        if pressure > gas.pressure:
            return (pressure - gas.pressure) * np.sqrt(
                2.0 / gas.density / ((gamma + 1.0) * pressure + (gamma - 1.0) * gas.pressure))
        return 2.0 * sound / (gamma - 1.0) * ((pressure / gas.pressure) ** (0.5 * (gamma - 1.0) / gamma) - 1.0)

    def beside(self, side):
        """Density on either side of the contact discontinuity."""
        gas, ratio = (self.left, self.right)[side], self.pressure / (self.left, self.right)[side].pressure
        share = (self.gamma - 1.0) / (self.gamma + 1.0)
        if ratio > 1.0:
            return gas.density * (ratio + share) / (share * ratio + 1.0)
        return gas.density * ratio ** (1.0 / self.gamma)

    def fronts(self, side):
        """Speeds of the fronts of a wave, outer one first; both are the same for a shock."""
        gas, sound, gamma = (self.left, self.right)[side], self.sounds[side], self.gamma
        sign = (-1.0, 1.0)[side]
        if self.pressure > gas.pressure:
            speed = gas.velocity + sign * sound * np.sqrt(
                (gamma + 1.0) / (2.0 * gamma) * self.pressure / gas.pressure + (gamma - 1.0) / (2.0 * gamma))
            return speed, speed
        inner = np.sqrt(gamma * self.pressure / self.densities[side])
        return gas.velocity + sign * sound, self.velocity + sign * inner

    def density(self, speed):
        """Density at positions that move with given speeds x/t."""
        gamma, result = self.gamma, np.where(speed < self.velocity, *self.densities)
        for side, sign in ((0, -1.0), (1, 1.0)):
            gas, sound = (self.left, self.right)[side], self.sounds[side]
            outer, inner = self.fronts(side)
            fan = gas.density * np.abs(2.0 / (gamma + 1.0) - sign * (gamma - 1.0) / ((gamma + 1.0) * sound)
                                       * (gas.velocity - speed)) ** (2.0 / (gamma - 1.0))
            if outer != inner:
                result = np.where(sign * (speed - inner) > 0.0, fan, result)
            result = np.where(sign * (speed - outer) > 0.0, gas.density, result)
        return result
