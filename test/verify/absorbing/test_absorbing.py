# SPDX-License-Identifier: BSD-3-Clause
"""Waves that meet a boundary of type = 'absorbing': at normal incidence, shear waves, at oblique incidence, in
axisymmetry, and the balances.

Would catch: a boundary that acts like an open or a closed one, speeds of the wrong material or of P and S waves
exchanged, a wrong fraction of the boundary area of a node, a force from the velocity before the step, normal and
tangential directions mixed up, impulse or work that is not recorded, nodes that two ranks slow differently, flying
material that is stopped where no material reached the boundary at the start, reflected waves in bodies from lists of
points, or in the second of two layers.

A velocity of the boundary xlo, sin**2 over 20 cells, propagates through a bar of 100 cells; what a bar of 200 cells
does not have is compared with the incident amplitude. A free boundary gives +0.88, a mirror plane -0.87, since the
method itself spreads so short a pulse on its path of 200 cells; the absorbing boundary 0.0013 with usl, target 0.005.
The strain of usavg has in the last cell the velocities of particles on one side alone: 0.0064, a known miss held at
twice the target. For shear 0.0077, limit 0.01; a pulse of 40 cells 0.0017; mpm with linear functions 0.0073, quadratic
ones 0.012, limit 0.02.

Oblique incidence: packets of P waves of 17 cells that meet two boundaries at 45 degrees and angles around it.
Reflection by dashpots is a linear problem of three waves, solved here and averaged over the directions of the packet:
0.0050 of the energy; final energy over that with free boundaries 0.0091, limit 0.01 above the value for the dashpots.
"""
# timeout: 120

import math

import numpy as np

import case
import measured

DENSITY, BULK, SHEAR = 2000.0, 1.0e9, 0.6e9
P_SPEED, S_SPEED = math.sqrt((BULK + 4.0 / 3.0 * SHEAR) / DENSITY), math.sqrt(SHEAR / DENSITY)
EDGE = 0.01

MATTER = f"&material  name='m'  density={DENSITY}  bulk={BULK}  shear={SHEAR} /"
BAR = """
&run  dimension='{dimension}'  method='{method}' /
&grid  lo=0,0,0  hi={size[0]!r},1,{size[1]!r}  dx=0.01 /
&method  {words} /
&time  t_end={end!r} /
{matter}
&region  name='bar'  shape='box'  lo=0,0,0  hi={size[0]!r},1,{size[1]!r} /
&body  name='bar'  region='bar'  material='m'  ppc={ppc} /
&boundary  face='{front}'  type='velocity'  table='pulse.csv' /
&boundary  face='{back}'  type='{kind}' /
{sides}
&output  name='p'  kind='particles'  times={half!r},{end!r}  precision='double'  fields='identity','velocity' /
&output  name='h'  kind='history'  every=5 /
&checkpoint  at_end=.false. /
"""

ASKEW = """
&run  dimension='plane_strain' /
&grid  lo=0,0,0  hi=1,1,{high!r}  dx=0.01 /
&time  t_end={end!r} /
{matter}
&region  name='dots'  shape='points'  file='dots.csv' /
&body  name='bar'  region='dots'  material='m'  packing='file' /
&boundary  face='xlo'  type='{kind}' /
&boundary  face='xhi'  type='{kind}' /
&boundary  face='zlo'  type='periodic' /
&boundary  face='zhi'  type='periodic' /
&output  name='p'  kind='particles'  times=0,{end!r}  precision='double'  fields='velocity' /
&checkpoint  at_end=.false. /
"""

FLIGHT = """
&run  dimension='1d' /
&grid  lo=0,0,0  hi=1,1,1  dx=0.01 /
&time  t_end=1.5e-2 /
{matter}
&region  name='block'  shape='box'  lo=0.6,0,0  hi=0.8,1,1 /
&body  name='block'  region='block'  material='m'  velocity=40,0,0 /
&boundary  face='xhi'  type='absorbing' /
&output  name='h'  kind='history'  every=20 /
&checkpoint  at_end=.false. /
"""

LAYERS = """
&run  dimension='plane_strain' /
&grid  lo=0,0,0  hi=0.6,1,0.12  dx=0.01 /
&time  t_end=2.4e-3 /
&material  name='fast'  density=1000  young=1e9  poisson=0 /
&material  name='slow'  density=4000  young=1e9  poisson=0 /
&region  name='lower'  shape='box'  lo=0,0,0  hi=0.6,1,0.05 /
&region  name='upper'  shape='box'  lo=0,0,0.07  hi=0.6,1,0.12 /
&region  name='lower_end'  shape='box'  lo=0,0,0  hi=0.2,1,0.05 /
&region  name='upper_end'  shape='box'  lo=0,0,0.07  hi=0.2,1,0.12 /
&body  name='a'  region='lower'  material='fast' /
&body  name='b'  region='upper'  material='slow' /
&body  name='c'  region='lower_end'  material='fast'  velocity=0.1,0,0 /
&body  name='d'  region='upper_end'  material='slow'  velocity=0.1,0,0 /
&boundary  face='xhi'  type='{kind}' /
&output  name='h'  kind='history'  every=20 /
&checkpoint  at_end=.false. /
"""

BLOW = """
&run  dimension='{dimension}' /
&grid  lo=0,0,0  hi=0.2,{wide},0.2  dx=0.01 /
&time  t_end={end!r} /
&effects  strength={strength} /
&material  name='m'  density=2785  eos_model='mie_gruneisen'  mg_c0=5328  mg_s=1.338  mg_gamma=2 {shear} /
&region  name='all'  shape='box'  lo=0,0,0  hi=0.2,0.2,0.2 /
&region  name='core'  shape='{core}'  centre=0,0,0.1  radius=0.04  {core_words} /
&body  name='all'  region='all'  material='m' /
&body  name='core'  region='core'  material='m'  {blow} /
{faces}
&output  name='h'  kind='history'  every=5 /
&checkpoint  at_end=.false. /
"""


def pulse(folder, component, width):
    """The table of the boundary velocity that makes a smooth pulse."""
    lines = ["t,vx,vy,vz"]
    for time in np.linspace(0.0, width, 201).tolist():
        row = [0.0, 0.0, 0.0]
        row[component] = float(0.01 * np.sin(np.pi * time / width) ** 2)
        lines.append(",".join(repr(number) for number in [time, *row]))
    (folder / "pulse.csv").write_text("\n".join(lines) + "\n", encoding="utf-8")


def returned(options, name, kind, component=0, along=0, cells=20, dimension="1d", method="ddmp", words=""):
    """Reflected amplitude over the incident one, with its sign: what the bar has more than the same part of one of
    twice the length, in which the pulse goes on."""
    speed = P_SPEED if component == along else S_SPEED
    length, width = 100 * EDGE, cells * EDGE / speed
    sides = ""
    if dimension == "plane_strain":
        sides = "&boundary face='zlo' type='periodic' /\n&boundary face='zhi' type='periodic' /"
    if dimension == "axisymmetric":
        sides = "&boundary face='xhi' type='slip' /"
    states = []
    for what, far in (("", length), ("_long", 2 * length)):
        deck = BAR.format(dimension=dimension, method=method, words=words, matter=MATTER, sides=sides, kind=kind,
                          size=[far, 5 * EDGE] if along == 0 else [5 * EDGE, far],
                          ppc="4,1,1" if dimension == "1d" else "2,1,2", front="xz"[along > 0] + "lo",
                          back="xz"[along > 0] + "hi", half=0.5 * length / speed + 0.5 * width,
                          end=1.5 * length / speed + 0.5 * width)
        box = case.Case(options, name + what, deck)
        pulse(box.folder, component, width)
        for _, snap in box.run("-q").snapshots():
            near = np.argsort(snap.fields["identity"])
            near = near[snap.points[near, along] < length]
            states.append(snap.fields["velocity"][near, component])
    more = states[1] - states[3]
    came, back = np.abs(states[0]).max(), more[np.abs(more).argmax()]
    measured.show(name, {"came": came, "comes back": back / came})
    if not 0.005 < came < 0.011:
        raise AssertionError(f"{name}: no pulse came")
    return back / came


def test_along_the_normal(options, sheet):
    """P waves in bars with all shape functions that are compatible with the boundary, and S waves."""
    sheet.above("free face gives the pulse back", returned(options, "free", "outflow"), 0.8)
    sheet.above("mirror gives it back turned", -returned(options, "mirror", "symmetry"), 0.8)
    sheet.known("P wave", returned(options, "normal", "absorbing"), limit=0.01, target=0.005)
    sheet.below("P wave, 40 cells", returned(options, "long", "absorbing", cells=40), 0.003)
    sheet.below("P wave, mpm", returned(options, "mpm", "absorbing", method="mpm"), 0.02)
    sheet.below("P wave, quadratic splines", returned(
        options, "quadratic", "absorbing", method="mpm", words="basis='quadratic'"), 0.02)
    sheet.known("P wave along an axis", returned(
        options, "axial", "absorbing", component=2, along=2, dimension="axisymmetric"), limit=0.01, target=0.005)
    sheet.below("P wave, usl", returned(options, "normal_usl", "absorbing", words="stress_update='usl'"), 0.005)
    sheet.above("S wave, free face", returned(
        options, "free_shear", "outflow", component=2, dimension="plane_strain"), 0.8)
    sheet.below("S wave", returned(
        options, "shear", "absorbing", component=2, dimension="plane_strain"), 0.01)


def thrown_back(angle):
    """Fraction of the energy of a plane P wave that dashpots reflect as P and S waves."""
    lame = BULK - 2.0 / 3.0 * SHEAR

    def fault(way, motion, speed):
        """Difference between the stress of a wave on the boundary and that of the dashpots, with the normal along x."""
        stress = -(lame * (way @ motion) * np.eye(2) + SHEAR * (np.outer(way, motion) + np.outer(motion, way))) / speed
        return stress[0] + DENSITY * np.array([P_SPEED * motion[0], S_SPEED * motion[1]])

    turned = np.arcsin(S_SPEED / P_SPEED * np.sin(angle))
    back = np.array([-np.cos(angle), np.sin(angle)])
    matrix = np.column_stack([
        fault(back, back, P_SPEED),
        fault(np.array([-np.cos(turned), np.sin(turned)]), np.array([np.sin(turned), np.cos(turned)]), S_SPEED)])
    came = np.array([np.cos(angle), np.sin(angle)])
    p_wave, s_wave = np.linalg.solve(matrix, -fault(came, came, P_SPEED))
    return p_wave ** 2 + s_wave ** 2 * S_SPEED * np.cos(turned) / (P_SPEED * np.cos(angle))


def waves(snap):
    """Measure of the kinetic energy of the mean velocities of cells: relative motion of the particles of a cell, which
    the nodes do not resolve, is not part of a wave."""
    cell = np.floor(snap.points / EDGE).astype(int)
    place = cell[:, 0] * 1000 + cell[:, 2]
    count = np.maximum(np.bincount(place), 1)
    return sum(((np.bincount(place, snap.fields["velocity"][:, k]) / count) ** 2).sum() for k in (0, 2))


def test_askew(options, sheet):
    """Plane packets of P waves in a box that is periodic in the directions of its boundaries. They begin with a
    velocity alone, so half of them propagates to each boundary."""
    half, cells = 50 * EDGE, 24
    slope, depth = 2.0 * math.pi / (cells * EDGE), 16 * EDGE
    x, z = [places.ravel() for places in np.meshgrid(
        (np.arange(200) + 0.5) * 0.5 * EDGE - half, (np.arange(2 * cells) + 0.5) * 0.5 * EDGE)]
    phase, hull = slope * (x + z), 0.01 * np.exp(-0.5 * (x / depth) ** 2)
    # the gradient of a potential, so that there are no S waves
    across, along = hull * (np.cos(phase) - x / (slope * depth ** 2) * np.sin(phase)), hull * np.cos(phase)
    lines = ["x,y,z,volume,vx,vy,vz"] + [
        f"{a!r},0.5,{b!r},{0.25 * EDGE ** 2!r},{u!r},0.0,{w!r}"
        for a, b, u, w in zip((x + half).tolist(), z.tolist(), across.tolist(), along.tolist())]
    energy = {}
    for kind in ("outflow", "absorbing"):
        box = case.Case(options, f"askew_{kind}", ASKEW.format(
            end=95 * EDGE * math.sqrt(2.0) / P_SPEED, kind=kind, matter=MATTER, high=cells * EDGE))
        (box.folder / "dots.csv").write_text("\n".join(lines) + "\n", encoding="utf-8")
        states = [waves(snap) for _, snap in box.run("-q").snapshots()]
        energy[kind] = states[-1] / states[0]
        measured.show(f"askew, {kind}", {"left": energy[kind]})
    normal = slope * np.linspace(0.2, 3.0, 1401)
    weight = (normal ** 2 + slope ** 2) * np.exp(-(depth * (normal - slope)) ** 2)
    wanted = sum(weight * [thrown_back(math.atan2(slope, part)) for part in normal]) / sum(weight)
    print(f"         askew: dashpots throw back {thrown_back(0.25 * math.pi):.4f} of the energy at 45 degrees, "
          f"{wanted:.4f} of that of the packet", flush=True)
    sheet.above("askew: free faces give back", energy["outflow"], 0.25)
    sheet.below("askew: share that comes back less that of dashpots",
                energy["absorbing"] / energy["outflow"] - wanted, 0.01)


def test_books(options, sheet):
    """A ball that expands in 3-D, with the same bits on several ranks; in axisymmetry a rod that expands, with
    strength."""
    sides = "".join(f"&boundary face='{face}' type='{{}}' /\n" for face in ("xhi", "zlo", "zhi"))
    ball = BLOW.format(dimension="3d", wide=0.2, end=8.0e-5, strength=".false.", shear="", core="sphere", core_words="",
                       blow="velocity=30,20,5", faces="&boundary face='all' type='absorbing' /\n"
                       "&boundary face='xlo' type='symmetry' /\n&boundary face='ylo' type='slip' /")
    # a weak viscosity, so that most of the energy arrives at the faces
    ball += "&method bulk_q1=0.06 /\n"
    runs = [case.Case(options, f"ball_{ranks}", ball, ranks=ranks).run("-q") for ranks in (1, 3)]
    sheet.require(runs[0].summary["digest"] == runs[1].summary["digest"], "3 ranks have the bits of 1")
    rod = {kind: case.Case(options, f"rod_{kind}", BLOW.format(
        dimension="axisymmetric", wide=0, end=9.0e-5, strength=".true.", core="cylinder", core_words="height=1",
        blow="specific_energy=2e4", shear="shear=27e9", faces=sides.format(kind, "slip", "slip"))).run("-q")
        for kind in ("outflow", "absorbing")}
    for name, run in [("ball", runs[0]), ("rod", rod["absorbing"])]:
        ledger = run.summary["ledger"]
        if name == "ball":
            sheet.below(f"{name}: momentum error", ledger["momentum_error"], 1.0e-13)
        sheet.below(f"{name}: energy error", ledger["energy_error"], 1.0e-13)
    left = [run.history["kinetic"][-1] / run.history["kinetic"].max() for run in (rod["absorbing"], rod["outflow"])]
    measured.show("rod", {"left": left[0], "left with a free face": left[1]})
    sheet.below("rod: kinetic energy against that with a free face", left[0] / left[1], 0.2)
    work = runs[0].history["external_work"][-1]
    sheet.below("ball: work of the faces over the energy of motion", work / runs[0].history["kinetic"][0], 1.0)
    sheet.above("ball: the faces take energy", -work / runs[0].history["kinetic"][0], 0.1)


def test_where_matter_goes_on(options, sheet):
    """A block flies out where no material reaches the boundary at the start; two bars without a Poisson effect, the
    second with half the wave speed, are at rest when their waves have left. With the wave speeds of the first bar at
    both boundaries, a ninth of the energy of the second would be reflected."""
    run = case.Case(options, "flight", FLIGHT.format(matter=MATTER)).run("-q")
    sheet.near("flight: mass that leaves [kg]", run.history["lost_mass"][-1], run.history["mass"][0], 1.0e-12)
    sheet.near("flight: its momentum [kg m/s]", run.history["lost_momentum_x"][-1], run.history["momentum_x"][0],
               1.0e-9)
    left = {}
    for kind in ("outflow", "absorbing"):
        kinetic = case.Case(options, f"layers_{kind}", LAYERS.format(kind=kind)).run("-q").history["kinetic"]
        left[kind] = kinetic[-1] / kinetic[0]
    sheet.above("layers: kinetic energy left with a free face", left["outflow"], 0.2)
    sheet.below("layers: the same with an absorbing one", left["absorbing"], 0.02)
