# SPDX-License-Identifier: BSD-3-Clause
# tiers: smoke, full
# timeout: 300
"""A scene in a periodic cell that deforms, against closed solutions.

Would catch: a stress that is not pulled back to the mesh or a force that is not pushed forward, a velocity gradient
without that of the cell or in the wrong configuration, particles with positions on the previous mesh after edges were
replaced, or written with mesh coordinates, the term -L u with the wrong sign or order, work of the cell that the
balance lacks, a servo that holds another stress than the mean of the particles.

* Relaxing contacts in simple shear (J. Rheol. 41 (1997) 1275): each step of the law is exact in simple shear, the flow
  is uniform, and so the mean stress of the cell is exact. It is correct to round-off at all times while edges of the
  cell are replaced six times; limit 1e-10 of G.
* A wave in a viscous fluid, u_y = A cos(k.r) with k = F^-T k0: A = A0 exp(-nu k0^2 (t + g^2 t^3/3)) for any amplitude.
  Errors are of second order in the cells, with a replacement of edges in the middle; `mpm` misses that on grids that
  are not powers of two times each other, a known miss. Velocities are half a step behind.
* Compression and shear: the density is that of the cell, and the pressure that of the law, with an error of third order
  in the step.
* Start, reversal and stop of the same law, stage by stage, and `--point`: round-off.
* A servo: in steady shear of relaxing contacts its error goes to 0.
* Friction of mu(I): that of its formula, starting from a flow with waves, for any motion of the cell.
* Balance: exact to round-off with internal energy; in elastic material its error is of second order in the step.
"""

import numpy as np
import pytest

import case
import cells
import convergence
import measured

WAVE_CELLS = (10, 14, 19, 26)
STEPS = (1.0, 1.3, 1.6, 1.9)            # the fraction of the stable step is 0.5 over this


@pytest.mark.parametrize("dimension", [
    "plane_strain",
    pytest.param("3d", marks=pytest.mark.tiers("full", "long")),
])
def test_shear(options, sheet, dimension):
    """The granular law from rest to steady shear."""
    rate, time, modulus = 2.0, 0.7, 3.0
    found = cells.run(options, f"granular_{dimension}", cells.granular(time, rate, dimension=dimension))
    t, w = found["time"], rate * time
    size = modulus * w / (1.0 + w**2)
    across = size * (1.0 - np.exp(-t / time) * (np.cos(rate * t) - w * np.sin(rate * t)))
    along = size * (w - np.exp(-t / time) * (w * np.cos(rate * t) + np.sin(rate * t)))
    stress, edge = ("stress_xy", "edge_xy") if dimension == "3d" else ("stress_xz", "edge_xz")
    flips = np.count_nonzero(np.abs(np.diff(found[edge])) > 0.5)
    sheet.require(flips >= 5, f"granular, {dimension}: the cell has flipped ({flips})")
    sheet.near(f"granular, {dimension}: strain at the end", found["strain"][-1], 6.0, 1.0e-12)
    sheet.below(f"granular, {dimension}: shear stress over G", np.abs(found[stress] - across).max() / modulus, 1.0e-10)
    sheet.below(f"granular, {dimension}: normal stress over G", np.abs(found["stress_xx"] - along).max() / modulus,
                1.0e-10)


@pytest.mark.tiers("full", "long")
def test_path(options, sheet):
    """Start, reversal and stop: the stress z = (s_xx - s_zz)/2 + i s_xz satisfies z' = -(1/tau + i g) z + i G g."""
    time, modulus = 0.7, 3.0
    rates, ends = (2.0, -3.0, 0.0), (1.2, 2.1, 2.5)
    stages = "\n".join(f"&stage  rate=0,0,0,0,{rate},0  duration={end - begin!r} /"
                       for rate, begin, end in zip(rates, (0.0, *ends), ends))
    found = cells.run(options, "path", cells.scene(
        "density=0.1  bulk=5  shear=3  strength_model='granular'  gr_tau=0.7", stages, ends[-1], dx=0.25))
    begin, at_begin, exact = 0.0, 0.0j, np.zeros(len(found["time"]), complex)
    for rate, end in zip(rates, ends):
        pull = 1.0 / time + 1j * rate
        steady = 1j * modulus * rate / pull
        here = (found["time"] >= begin) & (found["time"] <= end * (1.0 + 1.0e-12))
        exact[here] = steady + (at_begin - steady) * np.exp(-pull * (found["time"][here] - begin))
        at_begin = steady + (at_begin - steady) * np.exp(-pull * (end - begin))
        begin = end
    sheet.require(np.ptp(found["stage"]) >= 2, "path: all stages were there")
    stress = 0.5 * (found["stress_xx"] - found["stress_zz"]) + 1j * found["stress_xz"]
    sheet.below("path: stress over G", np.abs(stress - exact).max() / modulus, 1.0e-10)


@pytest.mark.tiers("full", "long")
def test_point(options, sheet):
    """The law in the cell and with --point, to the same strain."""
    deck = cells.granular(0.7, dimension="3d")
    found = cells.run(options, "cell", deck)
    deck += "&point  path='shear'  rate=2  strain=6  steps=100 /\n"
    one = case.Case(options, "point", deck)
    one.run("--point")
    alone = cells.table(one.path("_point.csv"))
    for name in ("xy", "xx"):
        sheet.near(f"--point: stress {name} [Pa]", found["stress_" + name][-1], alone[name][-1], 1.0e-10)


@pytest.mark.tiers("full", "long")
@pytest.mark.parametrize("method, transfer", [("ddmp", "flip"), ("mpm", "flip")])
def test_wave(options, sheet, method, transfer):
    """The order of a wave that is sheared."""
    errors = []
    for number in WAVE_CELLS:
        found = cells.run(options, f"wave_{method}_{transfer}_{number}", cells.kelvin(number, method, transfer))
        t = found["time"] - 0.5 * found["dt"]
        t[0] = 0.0
        exact = 0.1 * np.exp(-0.02 * (2.0 * np.pi)**2 * (t + t**3 / 3.0))
        sheet.require(np.any(np.diff(found["edge_xz"]) < -0.5),
                      f"wave, {method}, {transfer}, {number} cells: the cell has flipped")
        errors.append(np.abs(np.sqrt(4.0 * found["kinetic"] / found["mass"]) - exact).max() / 0.1)
    measured.show(f"wave {method} {transfer}", dict(zip(WAVE_CELLS, errors)))
    # 1 % with 32 cells, at second order
    name, far = f"wave, {method}, {transfer}", 0.01 * (32.0 / WAVE_CELLS[-1]) ** 2
    order = convergence.order(WAVE_CELLS, errors)
    measured.record(f"{name}: order", order)
    if method == "mpm":
        # the error falls by less on the finer grids; held at first order
        sheet.known(f"{name}: error with {WAVE_CELLS[-1]} cells", errors[-1], limit=2.0 * far, target=far)
        sheet.known(f"{name}: 1.9 less the order", max(0.0, 1.9 - order), limit=0.9, target=0.0)
    else:
        sheet.below(f"{name}: error with {WAVE_CELLS[-1]} cells", errors[-1], far)
        sheet.above(f"{name}: order", order, 1.9)


@pytest.mark.tiers("full", "long")
def test_compress(options, sheet):
    """Density, pressure and positions in space of a cell that is compressed and sheared."""
    found = cells.run(options, "compressed", cells.scene(
        "density=1000  bulk=1e6  shear=1e4", "&stage  rate=-0.1,0,-0.2,0,0.3,0  duration=1 /", 1.0, every=10)
        + "&output  name='p'  kind='particles'  count=2  precision='double'  fields='identity' /\n")
    first, last = (snap.points[np.argsort(snap.fields["identity"])] for snap in
                   (shot for _, shot in (found["case"].snapshots()[0], found["case"].snapshots()[-1])))
    edges = np.array([[found["edge_xx"][-1], 0.0, found["edge_xz"][-1]], [0.0, 1.0, 0.0],
                      [0.0, 0.0, found["edge_zz"][-1]]])
    sheet.above("compressed: particles [1000]", len(first) / 1000.0, 0.2)
    sheet.below("compressed: positions in space [m]", np.abs(last - first @ edges.T).max(), 1.0e-12)
    sheet.near("compressed: density [kg/m3]", found["density"][-1], 1000.0 * np.exp(0.3), 1.0e-8)
    sheet.near("compressed: pressure [Pa]", found["pressure"][-1],
               1.0e6 * (found["density"][-1] / 1000.0 - 1.0), 1.0e-7)


@pytest.mark.tiers("full", "long")
def test_hold(options, sheet):
    """A servo that holds a normal stress in steady shear; the contacts lose their load within a given strain."""
    found = cells.run(options, "held", cells.scene(
        "density=1  bulk=500  shear=100  strength_model='granular'  gr_gamma_c=0.3",
        "&stage  servo='xz'  duration=2  pressure=20 /\n&stage  servo='z'  rate=0,0,0,0,0.5,0  strain=4  pressure=20 /",
        10.0, every=10))
    sheet.near("held: pressure [Pa]", -found["stress_zz"][-1], 20.0, 1.0e-6)
    sheet.require(found["stage"][-1] > 1, "held: the second stage was reached")
    # (Y.15) in steady shear: G W/(1 + W^2) with W = gr_gamma_c
    sheet.near("held: shear stress [Pa]", found["stress_xz"][-1], 100.0 * 0.3 / 1.09, 1.0e-4)


@pytest.mark.tiers("full", "long")
def test_friction(options, sheet):
    """The law mu(I) at a controlled pressure from a flow with waves: its friction at the mean pressure of all three
    axes."""
    waves = "velocity_formula='0.05*sin(2*pi*z)+0.03*cos(4*pi*x)','0','0.04*cos(2*pi*x)'"
    found = cells.run(options, "friction", cells.scene(
        "density=1500  bulk=1e6  shear=5e5  strength_model='mu_i'  mu_s=0.38  mu_2=0.64  mu_i0=0.28  "
        "grain_diameter=0.02  grain_density=2500",
        "&stage  servo='isotropic'  duration=0.5  pressure=1e3 /\n"
        "&stage  servo='z'  rate=0,0,0,0,4,0  strain=8  pressure=1e3 /", 2.5, body=waves, every=50))
    pressure = -(found["stress_xx"] + found["stress_yy"] + found["stress_zz"])[-1] / 3.0
    number = 4.0 * 0.02 * np.sqrt(2500.0 / pressure)
    # the remaining waves have 0.1 % of the initial kinetic energy
    sheet.near("mu(I): friction", found["stress_xz"][-1] / pressure, 0.38 + 0.26 / (1.0 + 0.28 / number), 1.0e-3)
    sheet.near("mu(I): held pressure [Pa]", -found["stress_zz"][-1], 1000.0, 5.0e-3)


@pytest.mark.tiers("full", "long")
def test_balance(options, sheet):
    """The energy of the cell and of a flow in it."""
    stage = "&stage  rate=-0.1,0,-0.2,0,0.3,0  duration=1 /"
    found = cells.run(options, "gas", cells.scene(
        "density=1  eos_model='ideal_gas'  ig_gamma=1.4", stage, 1.0, effects="strength=.false.", every=10,
        body="specific_energy=2.5e3  velocity_formula='sin(2*pi*z)','0','sin(2*pi*x)'"))
    sheet.above("gas: work of the cell [J]", found["external_work"][-1], 300.0)
    sheet.below("gas: balance of energy", np.abs(found["energy_error"]).max(), 1.0e-13)
    # a disc with free surfaces that the cell compresses
    deck = cells.scene(
        "density=1000  eos_model='mie_gruneisen'  mg_c0=10  mg_s=1.5  mg_gamma=1  shear=4e4",
        "&stage  rate=-0.1,0,-0.1,0,0,0  duration=1 /\n&stage  rate=0,0,0,0,0.5,0  strain=1 /", 3.0, dx=0.05, every=50,
        body="velocity_formula='-0.3*sin(2*pi*x)','0','-0.3*sin(2*pi*z)'")
    found = cells.run(options, "disc", deck.replace(
        "shape='box'  lo=0,0,0  hi=1,1.0,1", "shape='sphere'  centre=0.5,0,0.5  radius=0.47"))
    sheet.above("disc: it is pressed along x [Pa]", -found["stress_xx"][-1], 1.0e3)
    sheet.below("disc: balance of energy", np.abs(found["energy_error"]).max(), 1.0e-12)
    errors = [np.abs(cells.run(options, f"elastic_{number}", cells.scene(
        "density=1000  bulk=1e6  shear=1e4  strength_model='neo_hookean'", stage, 1.0, cfl=0.5 / number,
        every=10))["energy_error"][-1]) for number in STEPS]
    sheet.below("elastic: balance of energy", errors[0], 1.0e-7)
    sheet.above("elastic: order of the balance", convergence.order(STEPS, errors), 1.9)
