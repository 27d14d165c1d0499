# SPDX-License-Identifier: BSD-3-Clause
"""scree --grains in steady shear: the energy balance, friction and volume fraction.

Would catch work of the cell that is not dissipated, hence a wrong stress, velocity gradient or loss; friction between
grains that is not that of the deck; and a servo whose pressure drifts.
"""
# tiers: full, long
# timeout: 200
# timeout long: 1800

import numpy as np

import case
import tier

FLOW = """&grains  shape = '{shape}'  number = {number}  diameter = 1e-3  spread = 0.2  density = 2500
  stiffness = {stiffness}  restitution = 0.5  friction = {friction} /
&cell  pressure = 1e3 /
&stage  name = 'press'  servo = 'isotropic'  duration = {press}  rows = 2  snapshots = 0 /
&stage  name = 'begin'  servo = 'y'  inertial_number = {inertial}  strain = {begin}  rows = 20  snapshots = 0 /
&stage  name = 'steady'  servo = 'y'  inertial_number = {inertial}  strain = {strain}  rows = 60  snapshots = 0 /
"""


def flow(options, name, **values):
    """History of the steady part, and the run."""
    values = {"shape": "discs", "number": 300, "stiffness": 1e6, "friction": 0.4, "press": 0.05, **values}
    one = case.Case(options, name, FLOW.format(**values)).run("--grains", "--quiet", timeout=1500)
    history = one.history
    return {key: history[key][history["stage"] == 3] for key in
            ("stress_xy", "stress_yy", "volume_fraction", "work", "dashpots", "slip", "step_error", "kinetic",
             "springs", "shear", "energy_error", "step", "strain", "inertial_number")}


def test_balance(options, sheet):
    """Work of the cell and dissipation over a strain of 10, I = 0.01 in the tier long."""
    part = flow(options, "balance", number=200, inertial=tier.choose(full=0.1, long=0.01), begin=1, strain=10)
    change = {key: values[-1] - values[0] for key, values in part.items()}
    sheet.require(change["strain"] > 9.5, f"the strain is {change['strain']}")
    lost = change["dashpots"] + change["slip"]
    sheet.require(change["dashpots"] > 0.05 * lost and change["slip"] > 0.05 * lost, "both kinds of loss")
    stored = change["kinetic"] + change["springs"] + change["shear"]
    sheet.near("dissipation and change of stored energy over work", (lost + stored) / change["work"], 1.0, 1e-3)
    # the work is that of the stresses in the history; the normal stress also does work
    sheet.below("numerical loss over work", change["step_error"] / change["work"], 1e-3)
    energy = np.mean(part["kinetic"] + part["springs"] + part["shear"])
    steps = np.diff(part["step"])
    sheet.below("error of the energy balance a step over the energy",
                np.abs(np.diff(part["energy_error"]) / steps).max() / energy, 1e-10)


def test_rheology(options, sheet):
    """Discs with friction 0.4: mu = 0.25 + 1.1 I and phi = 0.81 - 0.3 I within 10 % (F. da Cruz and others, Phys.
    Rev. E 72 (2005) 021309, quoted from memory)."""
    for inertial in tier.choose(full=(0.1,), long=(0.01, 0.03, 0.1, 0.19)):
        part = flow(options, f"rheology_{inertial}", inertial=inertial, begin=1,
                    strain=tier.choose(full=4, long=6 if inertial < 0.05 else 15))
        friction = -np.mean(part["stress_xy"]) / np.mean(part["stress_yy"])
        name = f"I = {inertial}" + tier.choose(full=", short", long="")
        sheet.near(f"{name}: friction", friction, 0.25 + 1.1 * inertial, 0.1)
        sheet.near(f"{name}: volume fraction", np.mean(part["volume_fraction"]), 0.81 - 0.3 * inertial, 0.1)
        sheet.near(f"{name}: pressure that is held", -np.mean(part["stress_yy"]), 1e3, 0.02)
