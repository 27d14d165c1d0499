# SPDX-License-Identifier: BSD-3-Clause
"""Writes a table of an analytical equation of state in the format of eos_model = 'table'.

Use it as an example of the format and for tests against exact values. A line contains a density, a
temperature, a pressure and an energy per mass in SI units; the lines of a density follow each
other, with the same temperatures for all densities. Densities and temperatures are spaced with
constant ratios and include the reference density and temperature. The solid has a free energy with
constant specific heat, from which pressure and energy follow consistently.
"""
from __future__ import annotations

import argparse
from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from scree.errors import EXIT_USAGE, ScreeError

from ..state_table import Solid, axis, ideal_gas, mie_gruneisen, write

if TYPE_CHECKING:
    from scree.arrays import Array

SUMMARY = "a table of an equation of state, for eos_model = 'table'"
EXAMPLES = ("eos ideal_gas --gamma 1.4 --heat 717.5 --density 0.01 20 --out air.txt",
            "eos mie_gruneisen --rest 2785 --sound 5328 --slope 1.338 --gamma 2 --heat 900")
LEAST = 2


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """The options."""
    add = parser.add_argument
    add("law", choices=("ideal_gas", "mie_gruneisen"), help="the equation of state")
    add("--density", type=float, nargs=2, metavar=("A", "B"),
        help="least and greatest density [kg/m3] (gas 0.001 100, solid 0.85 and 1.6 times --rest)")
    add("--temperature", type=float, nargs=2, default=(50.0, 20000.0), metavar=("A", "B"),
        help="least and greatest temperature [K] (50 20000)")
    add("--nodes", type=int, nargs=2, default=(60, 60), metavar=("N", "M"),
        help="number of densities and of temperatures (60 60)")
    add("--gamma", type=float, required=True, help="ratio of specific heats; mg_gamma of the solid")
    add("--heat", type=float, required=True, help="specific heat at constant volume [J/(kg K)]")
    add("--rest", type=float, help="reference density of the solid [kg/m3]")
    add("--sound", type=float, help="mg_c0 of the solid [m/s]")
    add("--slope", type=float, help="mg_s of the solid")
    add("--zero", type=float, default=293.0, help="reference temperature, where e = 0 [K] (293)")
    add("--out", metavar="FILE", help="file of the table (LAW.txt)")


def nodes(name: str, bounds: Sequence[float], count: int, rest: float | None = None) -> Array:
    """Numbers with equal ratios, and a given one that must be among them if it is within the
    range."""
    if count < LEAST or not 0.0 < bounds[0] < bounds[1]:
        raise ScreeError(f"--{name} needs two numbers above 0 that ascend, and --nodes at least {LEAST}", EXIT_USAGE)
    numbers = axis(bounds[0], bounds[1], count)
    if rest is not None and bounds[0] < rest < bounds[1]:
        place = 1 + np.argmin(np.abs(np.log(numbers[1:-1] / rest))) if count > LEAST else None
        numbers = np.append(numbers, rest) if place is None else np.where(np.arange(count) == place, rest, numbers)
    return np.unique(numbers)


def run(arguments: argparse.Namespace) -> None:
    """Write the table."""
    solid = arguments.law == "mie_gruneisen"
    if solid and None in (arguments.rest, arguments.sound, arguments.slope):
        raise ScreeError("mie_gruneisen needs --rest, --sound and --slope", EXIT_USAGE)
    bounds = arguments.density or ((0.85 * arguments.rest, 1.6 * arguments.rest) if solid else (1.0e-3, 100.0))
    out = arguments.out or f"{arguments.law}.txt"
    densities = nodes("density", bounds, arguments.nodes[0], arguments.rest)
    temperatures = nodes("temperature", arguments.temperature, arguments.nodes[1], arguments.zero)
    if solid:
        constants = Solid(arguments.rest, arguments.sound, arguments.slope, arguments.gamma, arguments.heat,
                          arguments.zero)
        if arguments.slope * (1.0 - arguments.rest / densities[-1]) >= 0.9:
            raise ScreeError("--density ends too near the greatest compression, where slope (1 - rest/density) = 1",
                            EXIT_USAGE)
        pressure, energy = mie_gruneisen(densities, temperatures, constants)
        title = f"Mie-Grueneisen: {constants}"
    else:
        pressure, energy = ideal_gas(densities, temperatures, arguments.gamma, arguments.heat)
        title = f"ideal gas: gamma {arguments.gamma:g}, specific heat {arguments.heat:g} J/(kg K)"
    write(out, densities, temperatures, pressure, energy, title)
    print(f"{out}: {len(densities)} densities, {len(temperatures)} temperatures")
