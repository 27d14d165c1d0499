# SPDX-License-Identifier: BSD-3-Clause
"""CASE_material.nml: a &material block with the fitted constants, and their origin as comments."""
from __future__ import annotations

import argparse
import os
import re
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from scree.errors import EXIT_USAGE, ScreeError, unknown

from . import memory, relaxation

if TYPE_CHECKING:
    from .cell_run import CellRun
    from .memory import Memory
    from .moduli import Moduli
    from .rheology import Fits, SteadyShear

Block = tuple[list[str], dict[str, Any]]               # comments and keys
LAWS = ("granular", "mu_i")


def reference(shears: Sequence[SteadyShear], memories: Sequence[Memory], wanted: str | None) -> SteadyShear:
    """The steady shear whose constants the block uses: the named one, or the slowest with a survival law."""
    if wanted:
        found = next((shear for shear in shears if shear.stage.name == wanted), None)
        if found is None:
            raise unknown("shear stage", wanted, [shear.stage.name for shear in shears])
        return found
    with_law = {one.stage for one in memories if one.measure == "survival"}
    chosen = [shear for shear in shears if shear.stage.name in with_law] or shears
    return min(chosen, key=lambda shear: shear.inertial)


def contact_strain(shear: SteadyShear, memories: Sequence[Memory], measure: str) -> Memory:
    """The measurement of a stage that gives gamma_c."""
    found = [one for one in memories if one.measure == measure and one.stage == shear.stage.name
             and one.pressure == shear.pressure]
    if not found:
        raise ScreeError(f"no {measure} was measured in stage '{shear.stage.name}'; choose another --tau or --stage"
                        + (", or write contacts with snapshots in &stage" if measure == "survival" else ""), EXIT_USAGE)
    if not found[0].strain > 2.0 * found[0].error:
        raise ScreeError(f"the {measure} of stage '{shear.stage.name}', {found[0].strain:.3g}, is not above twice its "
                        f"error {found[0].error:.2g}; choose another --tau or --stage", EXIT_USAGE)
    return found[0]


def nearest_probe(moduli: Sequence[Moduli], shear: SteadyShear, relaxed: bool) -> Moduli | None:
    """The elastic probe nearest in pressure to a steady shear, or None."""
    found = [one for one in moduli if one.relaxed == relaxed and one.elastic]
    same = [one for one in found if one.stage == shear.stage.number]
    return next(iter(same or sorted(found, key=lambda one: abs(one.pressure - shear.pressure))), None)


def name_of(case: str) -> str:
    """A name that is valid in a deck."""
    return re.sub(r"\W+", "_", case).strip("_").lower() or "grains"


def provenance(run: CellRun, shear: SteadyShear, fits: Fits) -> list[str]:
    """Comments: the runs and measurements of the block."""
    said = run.provenance
    keys = run.keys
    lines = [f"Constants of a cell of grains, case {run.case}, fitted by scree-post grains.",
             f"Program: {said.get('code', 'scree')} {said.get('version', '')} {said.get('git', '')}".rstrip(),
             f"Deck: {keys.get('number', 0.0):.0f} {keys['shape']}, diameter {keys['diameter']:g} m, density "
             f"{keys['density']:g} kg/m3, friction {keys.get('friction', float('nan')):g}",
             f"Stage {shear.stage.name}: I = {shear.inertial:.4g}, rate {shear.rate:.5g} 1/s, pressure "
             f"{shear.pressure:.5g} Pa, strain {shear.stage.strain[-1]:.3g}",
             f"mu = {shear.mu:.4f} +- {shear.mu_error:.4f}, volume fraction {shear.phi:.4f} +- {shear.phi_error:.4f}"]
    if "a" in fits:
        said = {name: f"{fits[name][0]:.4g} +- {fits[name][1]:.2g}" for name in ("mu_s", "a", "phi_c", "b")}
        lines.append(f"All stages: mu = mu_s + a I with mu_s = {said['mu_s']}, a = {said['a']}; volume fraction = "
                     f"phi_c - b I with phi_c = {said['phi_c']}, b = {said['b']}")
    return lines


def granular(run: CellRun, shear: SteadyShear, memories: Sequence[Memory], moduli: Sequence[Moduli],
             measure: str) -> Block:
    """Comments and keys of strength_model = 'granular'."""
    kept = contact_strain(shear, memories, measure)
    modulus = relaxation.shear_modulus(shear.stress, kept.strain)
    probe = nearest_probe(moduli, shear, True)
    lame = probe.lame if probe and probe.lame > 0.0 else modulus
    comments = [f"gr_gamma_c: {measure}, {kept.strain:.4g} +- {kept.error:.2g}; tau = {kept.tau:.4g} s at this rate"]
    for one in memories:
        if one.stage == shear.stage.name and one.measure != measure:
            comments.append(f"   beside it by {one.measure}: {one.strain:.4g} +- {one.error:.2g} {one.note}".rstrip())
    comments.append(f"shear: makes the steady shear stress {shear.stress:.5g} Pa, G = stress (1 + gamma^2)/gamma")
    comments += [f"   beside it by the {words} probe of stage {one.stage} at {one.pressure:.4g} Pa: "
                 f"G = {one.shear:.4g}, lambda = {one.lame:.4g} Pa" for words, one in
                 (("unrelaxed", nearest_probe(moduli, shear, False)), ("relaxed", probe)) if one]
    comments.append("bulk: lambda + 2 G/3 with lambda "
                    + (f"of the relaxed probe of stage {probe.stage}" if probe else "= G; the run has no probe"))
    comments.append("Valid at this pressure alone: G is a constant, while stresses of grains grow with the pressure.")
    keys = {"density": shear.phi * run.keys["density"], "bulk": lame + 2.0 * modulus / 3.0, "shear": modulus,
            "strength_model": "granular", "gr_mode": "deviator", "gr_gamma_c": kept.strain}
    return comments, keys


def friction(run: CellRun, shear: SteadyShear, fits: Fits, moduli: Sequence[Moduli]) -> Block:
    """Comments and keys of strength_model = 'mu_i'."""
    if "mu_s" not in fits:
        raise ScreeError("--law mu_i needs shear stages at two inertial numbers or more", EXIT_USAGE)
    probe = nearest_probe(moduli, shear, True)
    if probe is None:
        raise ScreeError("--law mu_i needs moduli of a relaxed state: set probe = .true. in a &stage that ends "
                        "at rest or in slow shear", EXIT_USAGE)
    if "curve_mu_s" in fits:
        values = [fits[name] for name in ("curve_mu_s", "curve_mu_2", "curve_I_0")]
        comments = ["mu_s, mu_2, mu_i0: fitted to all stages"]
    else:
        base, slope = fits["mu_s"], fits["a"]
        far = 10.0 * max(shear.inertial, 0.1)
        values = [base, (base[0] + slope[0] * far, 0.0), (far, 0.0)]
        comments = ["mu_s and (mu_2 - mu_s)/mu_i0 are the straight line mu_s + a I; mu_i0 itself is not measured"]
    comments += [f"   {name} = {value:.4g} +- {error:.2g}" for name, (value, error) in
                 zip(("mu_s", "mu_2", "mu_i0"), values)]
    comments.append(f"shear, bulk: relaxed probe of stage {probe.stage} at {probe.pressure:.4g} Pa")
    keys = {"density": shear.phi * run.keys["density"], "bulk": probe.lame + 2.0 * probe.shear / 3.0,
            "shear": probe.shear, "strength_model": "mu_i", "mu_s": values[0][0], "mu_2": values[1][0],
            "mu_i0": values[2][0], "grain_diameter": run.keys["diameter"], "grain_density": run.keys["density"]}
    return comments, keys


def block(run: CellRun, shears: Sequence[SteadyShear], memories: Sequence[Memory], moduli: Sequence[Moduli],
          fits: Fits, options: argparse.Namespace) -> tuple[str, dict[str, Any], SteadyShear]:
    """The text of the file, and its keys."""
    shear = reference(shears, memories, options.stage)
    if options.law == "granular":
        comments, keys = granular(run, shear, memories, moduli, options.tau)
    else:
        comments, keys = friction(run, shear, fits, moduli)
    lines = [f"! {line}" for line in [*provenance(run, shear, fits), *comments]]
    lines += ["&material", f"   name = '{name_of(run.case)}'"]
    lines += [f"   {key} = '{value}'" if isinstance(value, str) else f"   {key} = {value:.6g}"
              for key, value in keys.items()]
    return "\n".join([*lines, "/", ""]), keys, shear


def write_block(path: str, text: str) -> None:
    """Write the file under a temporary name, then rename it."""
    try:
        with open(path + ".part", "w", encoding="utf-8") as handle:
            handle.write(text)
        os.replace(path + ".part", path)
    except OSError as error:
        raise ScreeError(f"cannot write {path}: {error.strerror or error}") from error


MEASURES = (*memory.FOUR, "reversal")
