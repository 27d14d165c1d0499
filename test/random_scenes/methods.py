# SPDX-License-Identifier: BSD-3-Clause
"""The numerical method of a random deck: the default in 80 % of them, otherwise a random valid one."""

import dataclasses

TRANSFERS = {"flip": 3, "pic": 1, "apic": 2, "aflip": 2, "rflip": 3}
# Transfers that remove velocities of particles that nodes do not resolve: without an internal energy to receive it,
# kinetic energy is lost by design.
FILTERS = ("pic", "apic")


@dataclasses.dataclass
class Method:
    """Keys of &run, &time and &method."""

    default: bool
    run: dict
    time: dict
    keys: dict
    cfl: float = 0.4
    filters: bool = False         # loses kinetic energy by design
    unstable: bool = False        # documented as unstable in doc/theory/methods_compared.md
    loses_momentum: bool = False  # documented as not conserving momentum in doc/reference/output.md
    split: bool = False

    @property
    def name(self):
        """For the table."""
        if self.default:
            return "default"
        words = [self.run.get("method", "ddmp")]
        words += [str(self.keys[key]) for key in ("basis", "transfer", "quadrature", "stress_update", "antilock")
                  if key in self.keys]
        return "-".join(words)


def draw(chance, plan):
    """A method that is valid for a scene."""
    method = Method(True, {}, {}, {})
    if not chance.true(0.2):
        return method
    method.default = False
    # volumes from the fill of nodes need the dual gradient
    dual = chance.true(0.6) or any("volume_from" in matter.keys for matter in plan.matters)
    keys = method.keys
    if chance.true(0.6):
        keys["transfer"] = chance.choose(TRANSFERS)
    if dual:
        draw_dual(chance, plan, keys)
    else:
        draw_single(chance, plan, method)
    if chance.true(0.4) and not keys.get("paper"):
        keys["stress_update"] = chance.choose(["usl", "usf", "musl", "usavg"])
    word = keys.get("transfer", "rflip" if dual else "flip")
    if keys.get("stress_update") == "usavg" and word in ("apic", "aflip"):
        keys["stress_update"] = "musl"         # the program refuses usavg with whole linear fields
    if word in ("flip", "rflip", "aflip") and chance.true(0.4) and not keys.get("paper"):
        keys["flip"] = chance.choose([1.0, 0.995, 0.99, 0.95])
    if chance.true(0.15):
        keys["antilock"] = "bbar"
    if chance.true(0.15) and plan.dimension != "axisymmetric" and not keys.get("paper"):
        keys["split"] = True
        method.split = True
    if plan.effects.get("artificial_viscosity", True):
        if chance.true(0.15):
            keys.update(bulk_q1=chance.uniform(0.0, 0.2), bulk_q2=chance.uniform(1.0, 4.0))
        if chance.true(0.1) and any(matter.carries for matter in plan.matters):
            keys["heat_flux"] = chance.uniform(0.5, 2.0)
    if chance.true(0.3):
        method.cfl = chance.choose([0.1, 0.2, 0.3, 0.5, 0.7])
        method.time["cfl"] = method.cfl
    if chance.true(0.1):
        method.time["strain_max"] = chance.choose([0.1, 0.2, 0.5])
    method.filters = word in FILTERS or keys.get("flip", 1.0) < 0.999
    update = keys.get("stress_update", "usl" if dual else "musl")
    method.loses_momentum = keys.get("paper", False) or keys.get("free_surface", "fill") == "none"
    # unstable: linear functions of the plain method, usf with linear velocity fields, a large cfl, and a dual gradient
    # without a local part
    method.unstable = (not dual and keys.get("basis", "linear") == "linear") or (
        update == "usf" and word in ("aflip", "apic")) or method.cfl > 0.5 or keys.get("alpha_0", 1.0) == 0.0
    return method


def draw_dual(chance, plan, keys):
    """Keys of the dual gradient."""
    if chance.true(0.05) and keys.get("transfer", "flip") == "flip":
        keys["paper"] = True
        keys.pop("transfer", None)
        return
    if chance.true(0.3):
        keys["quadrature"] = chance.choose(["point", "sub_points", "control"])
    if chance.true(0.2) and keys.get("quadrature") != "sub_points":
        keys["alpha"] = chance.choose(["split", "product", "bubble_squared"])
    if chance.true(0.2):
        keys["alpha_0"] = chance.choose([0.25, 0.5, 0.75])
    if chance.true(0.2):
        keys["free_surface"] = chance.choose(["fill", "cells", "none"])
    if chance.true(0.1):
        keys["blend"] = chance.choose(["smooth", "linear"])


def draw_single(chance, plan, method):
    """The plain gradient with another basis; the program warns of linear functions with linear velocity fields."""
    method.run["method"] = "mpm"
    slopes = method.keys.get("transfer") in ("apic", "aflip")
    words = {"linear": 0 if slopes else 1, "gimp": 3, "cpgimp": 2, "cpdi": 2, "quadratic": 3, "cubic": 2}
    if min(plan.cells) < 4:
        words = {"linear": 1}
        if slopes:
            method.keys["transfer"] = "flip"
    method.keys["basis"] = chance.choose(words)
