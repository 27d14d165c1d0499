# SPDX-License-Identifier: BSD-3-Clause
"""scree --grains on lattices and packings at rest: failure, moduli and their bound.

Would catch a Coulomb limit of another force, a servo that controls another axis or stress, a tangential spring that is
lost, a probe that exchanges components, strains by another amount or relaxes a state in equilibrium, and fabric or
volume that is wrong by a factor.
"""
# tiers: smoke, full
# timeout: 120

import numpy as np
import pytest

import case
import tier

TRIANGULAR = """&grains  shape = 'discs'  diameter = 1e-3  density = 2500  stiffness = 1e6  tangential_ratio = 0.8
  restitution = 0.2  friction = {friction} /
&cell  packing = 'triangular'  cells = 6 4 1  overlap = 1e-4  pressure = 50 /
&stage  name = 'load'  servo = 'x'  rate = 0 -1 0 0 0 0  duration = 0.001  rows = 100  snapshots = 0 /
"""
CUBIC = """&grains  shape = 'spheres'  diameter = 1e-3  density = 2500  law = 'hertz'  young = 1e9  poisson = 0.2
  restitution = 0.2  friction = {friction} /
&cell  packing = 'fcc'  cells = 3 3 3  overlap = 1e-4  pressure = 50 /
&stage  name = 'load'  servo = 'xy'  rate = 0 0 -1 0 0 0  duration = 0.001  rows = 100  snapshots = 0 /
"""
LATTICE = """&grains  shape = 'discs'  diameter = 1  density = 1  stiffness = 1000  tangential_ratio = 0.3
  restitution = 0.5  friction = 10 /
&cell  packing = 'triangular'  cells = 6 4 1  overlap = 1e-6 /
&stage  name = 'rest'  duration = 1e-3  rows = 1  snapshots = 0  probe = .true. /
"""
RANDOM = """&grains  shape = '{shape}'  number = {number}  diameter = 1e-3  spread = 0  density = 2500
  stiffness = {stiffness}  tangential_ratio = 0.5  restitution = 0.2  friction = 0 /
&cell  pressure = {pressure} /
&stage  name = 'press'  servo = 'isotropic'  duration = {duration}  quiet = 1e-7  rows = 5  snapshots = 1
  probe = .true. /
"""


def run(options, name, deck):
    """A run without output."""
    return case.Case(options, name, deck).run("--grains", "--quiet")


def moduli(one):
    """Rows of the table of moduli by (relaxed, component): the changes of xx yy zz xy xz yz per strain."""
    rows = np.genfromtxt(one.path("_moduli.csv"), delimiter=",", skip_header=1)
    return {(int(row[3]), int(row[4])): row[5:11] for row in rows}


def test_failure(options, sheet):
    """Stress ratio at failure: P. W. Rowe, Proc. R. Soc. A 269 (1962) 500; C. Thornton, Geotechnique 29 (1979) 441."""
    for friction in tier.choose(full=(0.0, 0.1, 0.2), smoke=(0.2,)):
        history = run(options, "rowe", TRIANGULAR.format(friction=friction)).history
        ratio = history["stress_yy"] / history["stress_xx"]
        expected = np.tan(np.pi / 3) * np.tan(np.pi / 3 + np.arctan(friction))
        # elastic up to a strain of 3e-4; then the lattice dilates, which changes the ratio by 10 times the strain
        plateau = history["time"] > 4e-4
        sheet.require(plateau.sum() > 50, "the lattice is strained to failure")
        sheet.below(f"triangular lattice, friction {friction}: greatest error of the stress ratio at failure",
                    np.abs(ratio[plateau] / expected - 1.0).max(), 0.01)
        sheet.require(history["sliding"][-1] > 0.3, "contacts slide") if friction else None
    history = run(options, "fcc", CUBIC.format(friction=0.25)).history
    lateral = 0.5 * (history["stress_xx"] + history["stress_yy"])
    plateau = history["time"] > 4e-4
    sheet.below("FCC lattice, friction 0.25: greatest error of the stress ratio at failure",
                np.abs(history["stress_zz"] / lateral / (10.0 / 3.0) - 1.0)[plateau].max(), 0.01)


def test_lattice(options, sheet):
    """Moduli of the triangular lattice; the overlap of 1e-6 changes them by a fraction of that size."""
    one = run(options, "lattice", LATTICE)
    sheet.require(one.summary["reason"] == "last stage finished", f"the end of a run: {one.summary['reason']}")
    rows = moduli(one)
    factor = np.sqrt(3.0) / 4.0
    shear, lame = factor * 1300.0, factor * 700.0
    for relaxed in (0, 1):
        name = ("unrelaxed", "relaxed")[relaxed]
        sheet.near(f"{name} xx by xx", rows[relaxed, 1][0], lame + 2 * shear, 1e-5)
        sheet.near(f"{name} yy by xx", rows[relaxed, 1][1], lame, 1e-5)
        sheet.near(f"{name} yy by yy", rows[relaxed, 2][1], lame + 2 * shear, 1e-5)
        sheet.below(f"{name} xy by xx", rows[relaxed, 1][3] / shear, 1e-5)
    sheet.near("unrelaxed xy by xy", rows[0, 4][3], shear, 1e-5)
    sheet.below("unrelaxed xx by xy", rows[0, 4][0] / shear, 1e-5)


@pytest.mark.tiers("full")
def test_bound(options, sheet):
    """Random packings without friction: affine moduli are those of the fabric, and they bound the relaxed ones.

    For isotropic contacts of spheres G = n d^2 (2 k_n + 3 k_t)/30 and K = n d^2 k_n/9, with n contacts per volume; of
    discs G = n d^2 (k_n + k_t)/8 and K = n d^2 k_n/4 (K of discs: plane strain without z).
    """
    for shape, number, stiffness, pressure, duration in (("discs", 300, 1e6, 1e3, 0.05),
                                                         ("spheres", 216, 1e3, 1e3, 0.06)):
        one = run(options, shape, RANDOM.format(shape=shape, number=number, stiffness=stiffness, pressure=pressure,
                                                duration=duration))
        rows, history = moduli(one), one.history
        plane = shape == "discs"
        last = {key: history[key][-1] for key in ("coordination", "volume_fraction", "overlap_max")}
        solid = np.pi / 4 * 1e-6 if plane else np.pi / 6 * 1e-9
        contacts = 0.5 * number * last["coordination"] / (number * solid / last["volume_fraction"])
        tangential = 0.5 * stiffness
        if plane:
            bulk = contacts * 1e-6 * stiffness / 4
            shear = contacts * 1e-6 * (stiffness + tangential) / 8
            axes = (1, 2)
        else:
            bulk = contacts * 1e-6 * stiffness / 9
            shear = contacts * 1e-6 * (2 * stiffness + 3 * tangential) / 30
            axes = (1, 2, 3)
        d = len(axes)
        measured = sum(rows[0, axis][other - 1] for axis in axes for other in axes) / d**2
        sheet.require(last["coordination"] > 2 * d - 0.8, f"{shape}: a packing that carries, {last['coordination']}")
        # branch lengths, 1 less the overlap, and the stress itself, both of the order of the overlap
        small = 4 * last["overlap_max"]
        sheet.near(f"{shape}: affine bulk modulus over that of the fabric", measured, bulk, small)
        relaxed = sum(rows[1, axis][other - 1] for axis in axes for other in axes) / d**2
        sheet.require(relaxed > 0.0, f"{shape}: the packing carries when it is relaxed, {relaxed}")
        sheet.below(f"{shape}: relaxed bulk modulus over the affine one", relaxed / measured, 1.0)
        # the packing has few contacts, so its fabric is isotropic only to 1/sqrt(contacts)
        count = 0.5 * number * last["coordination"]
        shears = [rows[0, c][c - 1] for c in ((4,) if plane else (4, 5, 6))]
        sheet.near(f"{shape}: affine shear modulus over that of the fabric", np.mean(shears), shear,
                   small + 2 / np.sqrt(count))
        # relaxation of the grains to rest can only reduce the moduli
        sheet.below(f"{shape}: relaxed shear modulus over the affine one",
                    np.mean([rows[1, c][c - 1] for c in ((4,) if plane else (4, 5, 6))]) / np.mean(shears), 1.0)
