# SPDX-License-Identifier: BSD-3-Clause
"""Small decks as a new user writes them, from a seed, and a judge of their runs by invariants.

The decks leave almost all keys of &method at their defaults: two bodies, or one and a wall, of a preset or of a few
handbook numbers. Nothing is shared with test/random_scenes, which uses the whole schema: errors of one generator or of
its limits are not those of the other one. Six kinds of matter take turns, so equal counts of each:

elastic   rubber, plastic, jelly: material without internal energy that stores all work
metals    presets of metals, 1 m/s to 12 km/s
brittle   glass, granite, concrete with damage
grains    sand and beads under gravity, or struck
liquids   water, oil: at rest, sloshing, drops, dam breaks, struck by a bullet
gases     closed boxes at rest, sloshing, under a piston; shock tubes; guns; explosives

Limits, from theory or from targets, none from measurements:

end        exit code 0: every deck is legal, and such matter exists.
mass       1e-12; momentum 1e-10 of the greatest of sum m|v|, impulse, and 1e-3 M c: rounding.
energy     2 % of the greatest kinetic and internal energy that entered, as a running mean over a twentieth of the run.
           Recorded dissipation counts as kept. Velocities are half a step behind stresses, which matter with internal
           energy has in its books; for other matter kinetic energy and work are the means of two steps, otherwise the
           sum oscillates by half a step over the time of a vibration. The smaller of both errors counts.
volume     closed box of gas: 2 % (exact: the box); liquid and unfailed solid between the shock of the impact and
           1 + v/c, each with 10 %; all matter: the cells that hold particles and those around them.
heat       no particle above 1.2 v^2/2 by the impact (the exact energy of a shock at a wall); in a plane or in space
           the plastic work of a strain of 3 at the greatest flow stress adds to v^2/2, and up to 2 % of the mass may
           have three times as much, as the pressure at the edge of contact reaches three times that of a plane shock
           (F. J. Heymann, J. Appl. Phys. 40 (1969) 5113). Gases: the energy behind the exact shocks of that speed, with
           the compression of the box.
speed      twice the exact bound: v for like matter, 2 v for a light body struck by a heavy one; the exact solution of
           the shock tube; where curved or oblique faces meet at v > c/10, jets of up to 2 % of the mass may have
           2 (v + c) (G. Birkhoff and others, J. Appl. Phys. 19 (1948) 563). In a plane or in space two particles, or
           0.5 % of them, may have four times the bound, as a wave doubles its speed once more at an edge.
"""

import dataclasses
import json
import math
import os
import random
import re
import resource
import shutil
import signal
import subprocess

import numpy as np

KINDS = ("elastic", "metals", "brittle", "grains", "liquids", "gases")
ENERGY, GAS_VOLUME, HEAT, JET, FEW = 0.02, 0.02, 1.2, 0.02, 0.005
GRAVITY = 9.81
# One rank needs no network.
ALONE = {"OMP_NUM_THREADS": "1", "OMPI_MCA_btl": "self", "OMPI_MCA_pml": "ob1", "OMPI_MCA_ess_singleton_isolated": "1",
         "OMPI_ALLOW_RUN_AS_ROOT": "1", "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM": "1"}
# density, bulk sound speed, greatest flow stress
METALS = {"al_2024_t351": (2785, 5328, 0.6e9), "al_6061_t6": (2703, 5350, 0.45e9), "cu_ofhc": (8930, 3940, 0.45e9),
          "steel_4340": (7850, 4570, 1.3e9), "steel_1006": (7890, 4570, 0.8e9), "ti_6al_4v": (4430, 5130, 1.4e9),
          "lead": (11350, 2050, 0.3e9), "tungsten_alloy": (17300, 4030, 1.8e9)}
BRITTLE = {"glass_soda_lime": (2530, 4236), "glass_borosilicate": (2230, 4000), "granite": (2680, 4320),
           "concrete_c40": (2400, 2900)}
SPEEDS = (1, 3, 10, 30, 100, 200, 400, 700, 1000, 1500, 2000, 3000, 4000, 5000, 6700, 8000, 10000, 12000)


@dataclasses.dataclass
class Matter:
    """A &material, and what the limits need of it."""

    words: str                   # keys of &material without the name
    density: float
    sound: float                 # bulk sound speed [m/s]
    carries: bool = False        # has an internal energy
    wave: float = 0.0            # greatest wave speed [m/s], if it is not `sound`
    family: str = "solid"
    breaks: bool = False
    flow: float = 0.0            # flow stress [Pa]

    @property
    def fastest(self):
        """Greatest wave speed [m/s]."""
        return self.wave or self.sound


@dataclasses.dataclass
class Scene:
    """A deck and the numbers that its limits use."""

    seed: int
    kind: str
    name: str = ""
    deck: str = ""
    dimension: str = "1d"
    dx: float = 1.0
    matters: list = dataclasses.field(default_factory=list)     # of each body
    impact: float = 0.0          # speed at which bodies, or a body and a wall, meet
    speed: float = 0.0           # exact bound of the speed of any particle
    heat: float = 0.0            # bound of the energy per mass gained, 0: of the impact
    curved: bool = False
    box: float = 0.0             # volume of a closed box full of gas
    swept: float = 0.0           # volume that a piston sweeps until t_end
    end: float = 0.0


class Writer:
    """Collects groups of a deck in one of two systems of units."""

    def __init__(self, rng, scene, thermal=False):
        self.rng, self.scene = rng, scene
        self.small = rng.random() < 0.35      # mm-us-mg
        self.length, self.time = (1.0e3, 1.0e6) if self.small else (1.0, 1.0)
        self.effects, self.method, self.groups, self.names = [], [], [], []
        self.thermal = thermal
        self.ppc = rng.choice((2, 2, 2, 3))
        self.packing = "jitter" if rng.random() < 0.25 else ""

    def place(self, *values):
        """Lengths."""
        return ", ".join(f"{value * self.length:.10g}" for value in values)

    def speed(self, *values):
        """Speeds."""
        return ", ".join(f"{value * self.length / self.time:.6g}" for value in values)

    def material(self, name, matter):
        """A &material."""
        self.groups.append(f"&material\n  name = '{name}'\n  {matter.words}\n/")

    def region(self, name, shape):
        """A &region."""
        self.groups.append(f"&region  name = '{name}'  {shape}  /")

    def box(self, name, low, high):
        """A &region that is a box."""
        self.region(name, f"shape = 'box'  lo = {self.place(*low)}  hi = {self.place(*high)}")

    def ball(self, name, centre, radius):
        """A &region that is a sphere."""
        self.region(name, f"shape = 'sphere'  centre = {self.place(*centre)}  radius = {self.place(radius)}")

    def body(self, name, region, material, matter, velocity=None, more=""):
        """A &body."""
        self.scene.matters.append(matter)
        words = [f"name = '{name}'  region = '{region}'  material = '{material}'"]
        if self.ppc != 2:
            words.append(f"ppc = {self.ppc}, {self.ppc}, {self.ppc}")
        if self.packing and "packing" not in more:
            words.append(f"packing = '{self.packing}'")
        if velocity and any(velocity):
            words.append(f"velocity = {self.speed(*velocity)}")
        self.groups.append("&body\n  " + "\n  ".join(words + ([more] if more else [])) + "\n/")

    def wall(self, face, kind, more=""):
        """A &boundary at a face."""
        self.groups.append(f"&boundary  face = '{face}'  type = '{kind}'  {more}/")

    def gravity(self, axis):
        """Gravity along the last active axis."""
        vector = [0.0, 0.0, 0.0]
        vector[axis] = -GRAVITY * self.length / self.time ** 2
        self.effects += ["gravity = .true.", "gravity_vector = " + ", ".join(f"{value:.6g}" for value in vector)]

    def text(self, low, high, end):
        """The deck."""
        scene = self.scene
        scene.end = end
        if self.thermal:
            self.effects.append("thermal = .true.")
        lines = [f"! {scene.name}", f"&run  title = '{scene.name}'  case = 'deck'  dimension = '{scene.dimension}' /"]
        if self.small:
            lines.append("&units  system = 'mm-us-mg' /")
        lines += [f"&grid\n  lo = {self.place(*low)}\n  hi = {self.place(*high)}\n  dx = {self.place(scene.dx)}\n/",
                  f"&time  t_end = {end * self.time:.6g} /"]
        if self.effects:
            lines.append("&effects\n  " + "\n  ".join(self.effects) + "\n/")
        if self.method:
            lines.append("&method  " + "  ".join(self.method) + " /")
        lines += self.groups
        lines += ["&output  name = 'p'  kind = 'particles'  count = 8  fields = 'state' /",
                  "&output  name = 'energy'  kind = 'history'  every = 1 /", "&checkpoint  at_end = .false. /"]
        return "\n".join(lines) + "\n"


# ---------------------------------------------------------------------------------------------------------- matter

def elastic_matter(rng, thermal, soft=False):
    """Rubber by neo_hookean, or a linear elastic plastic."""
    density = rng.choice((950, 1000, 1100, 1200))
    poisson = rng.choice((0.3, 0.35, 0.4, 0.45))
    rubber = soft or rng.random() < 0.6
    young = rng.choice((2e4, 1e5, 3e5)) if soft else rng.choice((1e6, 3e6, 1e7)) if rubber else rng.choice((2e8, 3e9))
    law = "strength_model = 'neo_hookean'" if rubber and rng.random() < 0.6 else ""
    bulk, shear = young / 3.0 / (1.0 - 2.0 * poisson), young / 2.0 / (1.0 + poisson)
    words = (f"density = {density} kg/m3\n  young = {young / 1e6:g} MPa   poisson = {poisson}"
             + (f"\n  {law}" if law else "") + ("\n  specific_heat = 1500 J/(kg K)" if thermal else ""))
    return Matter(words, density, math.sqrt(bulk / density),
                  wave=math.sqrt((bulk + 4.0 / 3.0 * shear) / density)), "rubber" if rubber else "plastic"


def metal(rng, name=None, damage=False):
    """A preset of a metal."""
    name = name or rng.choice(sorted(METALS))
    density, sound, flow = METALS[name]
    return Matter(f"preset = '{name}'", density, sound, carries=True, wave=1.25 * sound, breaks=damage, flow=flow), name


def brittle_matter(rng):
    """A preset of a brittle material."""
    name = rng.choice(sorted(BRITTLE))
    density, sound = BRITTLE[name]
    return Matter(f"preset = '{name}'", density, sound, carries=name == "glass_soda_lime", wave=1.35 * sound,
                  breaks=True, flow=1.0e9), name


def grains(rng, thermal, slow):
    """Sand as a preset, or soft enough for slow flows."""
    if not slow and rng.random() < 0.6:
        return Matter("preset = 'sand_dry'", 1674, 264, wave=362, family="grains"), "sand_dry"
    if rng.random() < 0.4:
        return Matter("preset = 'glass_beads'", 1470, 75, wave=96, family="grains"), "glass_beads"
    density, angle = rng.choice((1500, 1600, 1700)), rng.choice((28, 32, 36))
    law = rng.choice(("drucker_prager", "mohr_coulomb"))
    words = (f"density = {density} kg/m3\n  young = 3 MPa   poisson = 0.3\n  strength_model = '{law}'\n  "
             f"friction_angle = {angle}" + ("\n  specific_heat = 830 J/(kg K)" if thermal else ""))
    return Matter(words, density, math.sqrt(2.5e6 / density), wave=math.sqrt(4.04e6 / density),
                  family="grains"), f"sand {angle} degrees"


def liquid(rng, thermal, speed):
    """Water with its own stiffness, or softened so that it is ten times faster than the flow."""
    real = speed > 30.0
    heat = "\n  specific_heat = 4180 J/(kg K)" if thermal else ""
    if real and rng.random() < 0.5:
        return Matter("density = 1000 kg/m3  elastic = 'none'\n  eos_model = 'mie_gruneisen'\n  mg_c0 = 1480 m/s  "
                      "mg_s = 1.92  mg_gamma = 0.28" + heat, 1000, 1480, carries=True, family="liquid"), "water (shock)"
    sound = 1483.0 if real else max(10.0 * speed, 5.0)
    bulk = 1000.0 * sound ** 2
    if rng.random() < 0.3:
        return Matter(f"density = 1000 kg/m3  bulk = {bulk:.4g} Pa\n  strength_model = 'newtonian'  "
                      f"viscosity = {rng.choice((0.001, 0.1, 1.0))} Pa s" + heat, 1000, sound,
                      family="liquid"), "oil"
    return Matter(f"density = 1000 kg/m3  bulk = {bulk:.4g} Pa\n  elastic = 'none'  eos_model = 'tait'  tait_n = 7"
                  + heat, 1000, sound, family="liquid"), "water"


# ----------------------------------------------------------------------------------------------------------- scenes

def dimension_of(rng, words=("1d", "plane_strain", "plane_strain", "axisymmetric", "3d")):
    """One of the problem classes."""
    return rng.choice(words)


def cells_across(rng, dimension):
    """Cells across a body."""
    return {"1d": rng.choice((12, 20, 30)), "plane_strain": rng.choice((8, 10, 14)),
            "axisymmetric": rng.choice((8, 12)), "3d": rng.choice((5, 6))}[dimension]


def spread(scene, size, axis):
    """Low and high corner of a domain that holds (-half, half) across and (low, high) along the axis, from cells."""
    half, low, high = size
    h = scene.dx
    if scene.dimension == "1d":
        return (low * h, 0.0, 0.0), (high * h, h, h)
    across = (0.0 if scene.dimension == "axisymmetric" else -half * h, half * h)
    if scene.dimension == "3d":
        return (across[0], across[0], low * h), (across[1], across[1], high * h)
    return (across[0], 0.0, low * h), (across[1], h, high * h)


def body_region(writer, scene, name, shape, low, length, half, shift=0.0):
    """A region from `low` of `length` cells along the axis and `half` cells to each side."""
    h = scene.dx
    if scene.dimension == "1d":
        writer.box(name, (low * h, 0.0, 0.0), ((low + length) * h, h, h))
    elif shape == "ball":
        radius = 0.5 * length
        writer.ball(name, (shift * h, 0.5 * h if scene.dimension == "plane_strain" else 0.0, (low + radius) * h),
                    radius * h)
    elif shape == "cylinder" and scene.dimension == "3d":
        writer.region(name, f"shape = 'cylinder'  centre = {writer.place(shift * h, 0.0, (low + 0.5 * length) * h)}  "
                      f"axis = 0, 0, 1  radius = {writer.place(half * h)}  height = {writer.place(length * h)}")
    else:
        left = 0.0 if scene.dimension == "axisymmetric" else (shift - half) * h
        deep = (-half * h, half * h) if scene.dimension == "3d" else (0.0, h)
        writer.box(name, (left, deep[0], low * h), ((shift + half) * h, deep[1], (low + length) * h))


def along(scene, speed):
    """A velocity along the axis of the scene."""
    return (speed, 0.0, 0.0) if scene.dimension == "1d" else (0.0, 0.0, speed)


def collide(rng, writer, scene, first, second, speed, transits, names):
    """A body strikes another one or a wall. Returns the deck."""
    flat = scene.dimension == "1d"
    n = cells_across(rng, scene.dimension)
    shape = "box" if flat else rng.choice(("box", "ball", "ball", "cylinder"))
    half = max(2, n // 2)
    axial = n
    if not flat and shape != "ball":
        axial = rng.choice((n, n, max(4, n // 2)))
    else:
        axial = 2 * half if shape == "ball" else n
    fast = max(first.fastest, second.fastest if second else 0.0)
    slow = min(first.sound, second.sound if second else first.sound)
    gap = 0 if speed < 0.05 * fast else rng.choice((0, 1, 2))
    longest = axial
    writer.material(names[0], first)
    if second is None:
        kind = rng.choice(("slip", "stick", "symmetry", "friction"))
        face = "xlo" if flat else "zlo"
        writer.wall(face, kind, "friction = 0.3 " if kind == "friction" else "")
        body_region(writer, scene, "body", shape, gap, axial, half)
        writer.body("body", "body", names[0], first, along(scene, -speed))
        size = (half + (6 if not flat else 0), 0, gap + axial + rng.choice((6, 10)))
        like = True
    else:
        twin = rng.random() < 0.4
        if names[1] != names[0]:
            writer.material(names[1], second)
        thick = axial if twin else rng.choice((max(3, n // 2), n))
        longest = max(axial, thick)
        wide = half if twin else half + rng.choice((2, 4))
        shift = rng.choice((0, 0, half // 2)) if not flat and scene.dimension != "axisymmetric" else 0
        bottom = 6
        body_region(writer, scene, "target", shape if twin else "box", bottom, thick, wide)
        body_region(writer, scene, "projectile", shape, bottom + thick + gap, axial, half, shift)
        share = 0.5 if twin else rng.choice((0.0, 0.0, 1.0))
        writer.body("target", "target", names[1], second, along(scene, share * speed))
        writer.body("projectile", "projectile", names[0], first, along(scene, -(1.0 - share) * speed))
        size = (wide + 6, 0, bottom + thick + gap + axial + 8)
        like = first.words == second.words
        if not flat and rng.random() < 0.35 or flat and rng.random() < 0.2:
            writer.effects.append("contact = .true.")
            if rng.random() < 0.5:
                writer.groups.append("&contact  friction = 0.2 /")
    scene.impact, scene.speed = speed, speed if like else 2.0 * speed
    # a target that moves, and the projectile that stays, add the speed of the frame
    scene.curved = not flat
    h = scene.dx
    end = gap * h / speed * (1.0 if gap else 0.0) + transits * longest * h / (slow + speed)
    return writer.text(*spread(scene, size, 2), end)


def press(rng, writer, scene, matter, name, speed, share):
    """A moving rigid region presses a body on a wall by a share of its height."""
    n = cells_across(rng, scene.dimension)
    half, h = max(2, n // 2), scene.dx
    writer.material(name, matter)
    face = "xlo" if scene.dimension == "1d" else "zlo"
    writer.wall(face, rng.choice(("slip", "stick")))
    body_region(writer, scene, "body", "box", 0, n, half)
    writer.body("body", "body", name, matter)
    far = 100 * h
    if scene.dimension == "1d":
        writer.box("hammer", (n * h, -far, -far), ((n + 4) * h, far, far))
    else:
        writer.box("hammer", (-far, -far, n * h), (far, far, (n + 4) * h))
    push = writer.speed(*along(scene, -speed))
    writer.groups.append(f"&boundary  region = 'hammer'  type = 'slip'  velocity = {push}  /")
    scene.impact, scene.speed, scene.curved = speed, 2.0 * speed, scene.dimension != "1d"
    # strain to `share` in uniaxial strain, twice for reflections, and the speed of the hammer
    scene.heat = speed ** 2 + 2.0 * (matter.fastest * share) ** 2
    return writer.text(*spread(scene, (half + 6, 0, n + 4), 2), share * n * h / speed)


def elastic(rng, scene):
    """Rubber and plastic: collisions, drops, presses."""
    thermal = rng.random() < 0.1
    scene.dimension = dimension_of(rng)
    scene.dx = rng.choice((0.5e-3, 1e-3, 2e-3, 5e-3))
    writer = Writer(rng, scene, thermal)
    if rng.random() < 0.5:
        writer.effects.append("artificial_viscosity = .false.")
    what = rng.choice(("collide", "collide", "collide", "collide", "press", "drop"))
    matter, name = elastic_matter(rng, thermal, what == "drop")
    speed = max(1.0, min(0.3, 10.0 ** rng.uniform(-2.3, -0.5)) * matter.sound)
    if what == "drop":
        writer.small = False
        writer.length = writer.time = 1.0
        scene.dx = rng.choice((0.005, 0.01))
        n = cells_across(rng, scene.dimension)
        half, gap = n // 2, rng.choice((0, 2, 5))
        writer.gravity(0 if scene.dimension == "1d" else 2)
        writer.material(name, matter)
        writer.wall("xlo" if scene.dimension == "1d" else "zlo", rng.choice(("slip", "stick")))
        body_region(writer, scene, "body", rng.choice(("box", "ball")), gap, 2 * half, half)
        writer.body("body", "body", name, matter)
        height = 2 * half * scene.dx
        fall = math.sqrt(2.0 * GRAVITY * gap * scene.dx)
        scene.impact = fall + 2.0 * GRAVITY * height / matter.sound      # a sudden weight doubles its strain
        scene.speed = scene.impact
        scene.name = f"{name} falls"
        return writer.text(*spread(scene, (half + 5, 0, 2 * half + gap + 6), 2),
                           2.0 * fall / GRAVITY + 8.0 * height / matter.sound)
    if what == "press":
        scene.name = f"{name} pressed"
        return press(rng, writer, scene, matter, name, max(speed, 0.02 * matter.sound), rng.choice((0.1, 0.2)))
    second, other = None, ""
    if rng.random() < 0.65:
        second, other = (matter, name) if rng.random() < 0.7 else elastic_matter(rng, thermal)
        if other == name and second is not matter:
            other = name + "_2"
        speed = min(speed, 0.3 * second.sound)
    scene.name = f"{name} on {other or 'a wall'}"
    return collide(rng, writer, scene, matter, second, speed, rng.choice((10, 16, 24)), (name, other))


def metals(rng, scene):
    """Metal on metal or on a wall."""
    thermal = rng.random() < 0.3
    damage = rng.random() < 0.4
    scene.dimension = dimension_of(rng)
    scene.dx = rng.choice((0.25e-3, 0.5e-3, 1e-3, 2e-3))
    writer = Writer(rng, scene, thermal)
    if damage:
        writer.effects.append("damage = .true.")
    speed = float(rng.choice(SPEEDS))
    first, name = metal(rng, damage=damage)
    second, other = None, ""
    if rng.random() < 0.75:
        second, other = (first, name) if rng.random() < 0.4 else metal(rng, damage=damage)
    scene.name = f"{name} on {other or 'a wall'} at {speed:g} m/s"
    return collide(rng, writer, scene, first, second, speed, rng.choice((4, 8, 12)), (name, other))


def brittle(rng, scene):
    """Glass, granite, concrete with damage."""
    thermal = rng.random() < 0.2
    scene.dimension = dimension_of(rng)
    scene.dx = rng.choice((0.25e-3, 0.5e-3, 1e-3))
    writer = Writer(rng, scene, thermal)
    writer.effects.append("damage = .true.")
    matter, name = brittle_matter(rng)
    speed = float(rng.choice((10, 30, 60, 100, 200, 300, 400))) if not matter.carries else \
        float(rng.choice((10, 30, 100, 300, 600, 1000, 2000, 3000)))
    chance = rng.random()
    pair = [(matter, name), (None, "")]
    if chance < 0.4:
        pair = [metal(rng, rng.choice(("steel_4340", "al_6061_t6", "tungsten_alloy")), True), (matter, name)]
    elif chance < 0.7:
        pair = [(matter, name), (matter, name)]
    scene.name = f"{pair[0][1]} on {pair[1][1] or 'a wall'} at {speed:g} m/s"
    return collide(rng, writer, scene, pair[0][0], pair[1][0], speed, rng.choice((4, 8, 12)), (pair[0][1], pair[1][1]))


def granular(rng, scene):
    """Sand and beads: heaps, layers, balls that fall in, impacts."""
    thermal = False
    what = rng.choice(("heap", "layer", "ball", "impact", "impact"))
    scene.dimension = dimension_of(rng, ("plane_strain", "plane_strain", "axisymmetric", "3d") if what != "impact"
                                   else ("1d", "plane_strain", "axisymmetric", "3d"))
    if what == "impact":
        scene.dx = rng.choice((1e-3, 2e-3, 5e-3))
        writer = Writer(rng, scene, thermal)
        matter, name = grains(rng, thermal, False)
        chance, second, other = rng.random(), None, ""
        first, label = matter, name
        speed = float(rng.choice((3, 10, 20, 50, 100, 200)))
        speed = min(speed, 0.6 * matter.sound)
        if chance < 0.5:
            (first, label), second, other = metal(rng, rng.choice(("steel_4340", "al_6061_t6"))), matter, name
        elif chance < 0.75:
            second, other = matter, name
        label, other = label.replace(" ", "_"), other.replace(" ", "_")
        scene.name = f"{label} on {other or 'a wall'} at {speed:g} m/s"
        if label in METALS:
            return collide(rng, writer, scene, first, second, speed, 1.5, (label, other))
        return collide(rng, writer, scene, first, second, speed, rng.choice((2, 4)), (label, other))
    scene.dx = h = rng.choice((0.005, 0.01))
    writer = Writer(rng, scene, thermal)
    writer.small, writer.length, writer.time = False, 1.0, 1.0
    matter, name = grains(rng, thermal, True)
    name = name.replace(" ", "_")
    writer.gravity(2)
    writer.material(name, matter)
    writer.wall("zlo", rng.choice(("stick", "friction")), "")
    if "'friction'" in writer.groups[-1]:
        writer.groups[-1] = "&boundary  face = 'zlo'  type = 'friction'  friction = 0.5  /"
    n = {"plane_strain": rng.choice((8, 12)), "axisymmetric": 8, "3d": 4}[scene.dimension]
    height = rng.choice((n // 2, n))
    if what == "heap":
        body_region(writer, scene, "heap", "box", 0, height, n // 2)
        writer.body("heap", "heap", name, matter)
        size = (n + 2 * height, 0, height + 3)
        drop = height * h
    else:
        for face in ("xlo", "xhi") + (("ylo", "yhi") if scene.dimension == "3d" else ()):
            if face != "xlo" or scene.dimension != "axisymmetric":
                writer.wall(face, "slip")
        body_region(writer, scene, "bed", "box", 0, height, n)
        more = "initial_stress = 'lithostatic'" if rng.random() < 0.4 else ""
        if more:
            writer.packing = ""
        writer.body("bed", "bed", name, matter, None, more)
        size, drop = (n, 0, height + 3), 0.0
        if what == "ball":
            radius, fall = max(2, n // 4), rng.choice((1.0, 2.0, 5.0))
            soft = Matter("density = 2500 kg/m3\n  young = 10 MPa   poisson = 0.3", 2500, 58, wave=73)
            writer.material("ball", soft)
            body_region(writer, scene, "ball", "ball", height, 2 * radius, radius)
            writer.body("ball", "ball", "ball", soft, (0.0, 0.0, -fall))
            size, drop = (n, 0, height + 2 * radius + 4), fall ** 2 / 2.0 / GRAVITY
            scene.curved = True
    scene.impact = math.sqrt(2.0 * GRAVITY * (drop + height * h))
    scene.speed, scene.name = scene.impact * (2.0 if what == "ball" else 1.0), f"{name}: {what}"
    end = rng.choice((1.0, 2.0)) * math.sqrt(2.0 * height * h / GRAVITY) if what != "ball" else \
        4.0 * n * h / matter.sound + 0.5 * height * h / scene.impact
    return writer.text(*spread(scene, size, 2), end)


def liquids(rng, scene):
    """Water and oil."""
    thermal = False
    what = rng.choice(("still", "slosh", "dam", "drop", "drop", "bullet", "slabs"))
    choices = {"slabs": ("1d",), "still": ("1d", "plane_strain", "axisymmetric", "3d"), "slosh": ("plane_strain",),
               "dam": ("plane_strain", "3d"), "drop": ("plane_strain", "axisymmetric", "3d"),
               "bullet": ("plane_strain", "axisymmetric", "3d")}[what]
    scene.dimension = dimension_of(rng, choices)
    scene.name = f"liquid: {what}"
    if what in ("drop", "bullet", "slabs"):
        scene.dx = rng.choice((0.5e-3, 1e-3))
        writer = Writer(rng, scene, thermal)
        speed = float(rng.choice((2, 5, 20, 50, 100, 200))) if what != "bullet" else float(rng.choice(
            (100, 300, 800, 1500, 3000)))
        matter, name = liquid(rng, thermal, speed)
        name = re.sub(r"\W+", "_", name).strip("_")
        first, second, label, other = matter, None, name, ""
        if what == "bullet":
            (first, label), second, other = metal(rng, rng.choice(("steel_4340", "lead", "al_6061_t6"))), matter, name
        elif rng.random() < 0.5:
            second, other = matter, name
        scene.name += f", {label} on {other or 'a wall'} at {speed:g} m/s"
        return collide(rng, writer, scene, first, second, speed, rng.choice((4, 8)), (label, other))
    scene.dx = h = rng.choice((0.005, 0.01, 0.02))
    writer = Writer(rng, scene, thermal)
    writer.small, writer.length, writer.time = False, 1.0, 1.0
    n = {"1d": 20, "plane_strain": rng.choice((10, 16)), "axisymmetric": 8, "3d": 5}[scene.dimension]
    height = n if what != "slosh" else n // 2
    scene.impact = math.sqrt(2.0 * GRAVITY * height * h)
    matter, name = liquid(rng, thermal, scene.impact)
    writer.gravity(0 if scene.dimension == "1d" else 2)
    writer.material(name, matter)
    flat = scene.dimension == "1d"
    for face in ("xlo",) if flat else ("xlo", "xhi", "zlo") + (("ylo", "yhi") if scene.dimension == "3d" else ()):
        if face != "xlo" or scene.dimension != "axisymmetric":
            writer.wall(face, "slip")
    half = {"still": n // 2, "slosh": n, "dam": n // 2}[what]
    if what == "dam":
        deep = (-2 * n * h, 2 * n * h) if scene.dimension == "3d" else (0.0, h)
        if scene.dimension == "3d":
            writer.box("water", (-2 * n * h, deep[0], 0.0), (-n * h, deep[1], height * h))
            size = (2 * n, 0, height + 4)
        else:
            writer.box("water", (-2 * n * h, 0.0, 0.0), (-n * h, h, height * h))
            size = (2 * n, 0, height + 4)
    else:
        body_region(writer, scene, "water", "box", 0, height, half)
        size = (half, 0, height + 4)
    more = ""
    if what == "slosh":
        speed = 0.1 * scene.impact
        length = half * h
        more = f"velocity_formula = '{speed:.4g}*sin({math.pi / 2 / length:.8g}*(x + {length:.6g}))', '0', '0'"
    elif what == "still" and not writer.packing and rng.random() < 0.5:
        more = "initial_stress = 'lithostatic'  k0 = 1"
    writer.body("water", "water", name, matter, None, more)
    # still water under a sudden weight: twice the static strain; else free fall
    scene.speed = scene.impact if what == "dam" else 2.0 * GRAVITY * height * h / matter.sound + (
        0.3 * scene.impact if what == "slosh" else 0.0)
    return writer.text(*spread(scene, size, 2), rng.choice((1.0, 2.0)) * math.sqrt(2.0 * height * h / GRAVITY))


def star(left, right, gamma):
    """Speed between two gases (density, pressure) at rest, left at higher pressure, by the exact Riemann solution."""
    low, high = right[1], left[1]
    for _ in range(200):
        p = 0.5 * (low + high)
        behind = 2.0 / (gamma - 1.0) * math.sqrt(gamma * left[1] / left[0]) * (
            1.0 - (p / left[1]) ** ((gamma - 1.0) / 2.0 / gamma))
        ahead = (p - right[1]) * math.sqrt(2.0 / right[0] / ((gamma + 1.0) * p + (gamma - 1.0) * right[1]))
        low, high = (p, high) if behind > ahead else (low, p)
    return ahead


def gases(rng, scene):
    """Gas in closed boxes, guns and explosives."""
    what = rng.choice(("rest", "slosh", "piston", "tube", "tube", "wind", "gun", "charge"))
    scene.dimension = dimension_of(rng, ("1d", "plane_strain", "plane_strain", "3d") if what != "charge" else
                                   ("1d", "plane_strain", "axisymmetric"))
    flat = scene.dimension == "1d"
    scene.dx = h = rng.choice((1e-3, 2e-3, 0.01))
    writer = Writer(rng, scene)
    if what == "rest":
        writer.packing = "jitter"
    if what == "charge":
        explosive = rng.choice(("tnt", "comp_b", "pbx_9404"))
        charge = Matter(f"preset = '{explosive}'", 1700, 2500, carries=True, wave=8500, family="gas")
        plate, name = metal(rng, rng.choice(("steel_4340", "cu_ofhc", "al_6061_t6")))
        n = 20 if flat else 10
        writer.material("charge", charge)
        writer.material(name, plate)
        body_region(writer, scene, "charge", "box", 10, n, n // 2)
        body_region(writer, scene, "plate", "box", 10 + n, max(3, n // 4), n // 2)
        writer.body("charge", "charge", "charge", charge)
        writer.body("plate", "plate", name, plate)
        point = (10 * h, 0.0, 0.0) if flat else (0.0, 0.0, 10 * h)
        normal = "1, 0, 0" if flat else "0, 0, 1"
        writer.groups.append(f"&detonation  shape = 'plane'  point = {writer.place(*point)}  normal = {normal} /")
        scene.name, scene.impact, scene.speed = f"{explosive} drives {name}", 4000.0, 1.0e4
        # the chemical energy is internal from the start; a detonation adds u^2/2 with u = D/4
        scene.heat, scene.curved = 1.0e7, not flat
        return writer.text(*spread(scene, (n // 2 + 10, 0, 10 + n + n // 4 + 20), 2), 2.0 * n * h / 8000.0)
    gamma = rng.choice((1.4, 1.4, 1.667))
    density, pressure = rng.choice((1.2, 1.2, 0.18)), 1.013e5
    sound = math.sqrt(gamma * pressure / density)
    energy = pressure / (gamma - 1.0) / density
    gas = Matter(f"density = {density} kg/m3\n  elastic = 'none'  eos_model = 'ideal_gas'  ig_gamma = {gamma}", density,
                 sound, carries=True, family="gas")
    writer.material("gas", gas)
    n = {"1d": rng.choice((20, 40)), "plane_strain": rng.choice((10, 16)), "3d": 6}[scene.dimension]
    wide = n if scene.dimension == "3d" else max(4, n // 2)
    high = (n * h, wide * h if scene.dimension == "3d" else h, h if flat else wide * h)
    low = (0.0, 0.0, 0.0)
    volume = n * h * high[1] * high[2]
    warm = f"specific_energy = {energy:.6g} J/kg"
    scene.name = f"gas: {what}"
    if what != "gun":
        writer.wall("all", "slip")
        scene.box = volume
    if what in ("rest", "slosh", "piston", "wind"):
        writer.box("box", low, high)
    if what == "rest":
        writer.body("gas", "box", "gas", gas, None, warm)
        scene.speed, scene.heat, scene.impact = 0.005 * sound, energy * 0.02, 0.01 * sound
        end = 20.0 * n * h / sound
    elif what == "slosh":
        speed = rng.choice((0.02, 0.05, 0.1, 0.2)) * sound
        factor = math.pi / (n * h * writer.length)
        writer.body("gas", "box", "gas", gas, None, warm + f"\n  velocity_formula = '{writer.speed(speed)}*sin("
                    f"{factor:.8g}*x)', '0', '0'")
        scene.impact = scene.speed = 1.2 * speed
        scene.heat = (gamma - 1.0) * energy * 2.0 * speed / sound
        end = 16.0 * n * h / sound
    elif what == "piston":
        speed = rng.choice((0.02, 0.05, 0.1, 0.3, 0.8)) * sound
        cut = rng.choice((0.3, 0.5, 0.6))
        writer.body("gas", "box", "gas", gas, None, warm)
        far = 100 * h
        writer.box("piston", (n * h, -far, -far), (2 * n * h, far, far))
        writer.groups.append(f"&boundary  region = 'piston'  type = 'slip'  velocity = {writer.speed(-speed, 0, 0)} /")
        scene.impact, scene.speed, scene.swept = speed, speed, cut * volume
        shocks = gamma * energy + 0.5 * speed ** 2
        scene.heat = shocks * (1.0 - cut) ** (1.0 - gamma) * (1.0 + speed / sound) - energy
        return writer.text(low, ((n + 3) * h, high[1], high[2]), cut * n * h / speed)
    elif what == "wind":
        speed = rng.choice((0.1, 0.3, 0.7, 1.2)) * sound
        writer.body("gas", "box", "gas", gas, (speed, 0.0, 0.0), warm)
        scene.impact = scene.speed = speed
        scene.heat = (gamma - 1.0) * energy + 0.5 * speed ** 2
        often = rng.choice((2.0, 6.0))
        if often > 2.0:      # the shock returns from the other wall
            scene.heat = gamma * (scene.heat + energy) + 0.5 * speed ** 2 - energy
        end = often * n * h / (sound + speed)
    elif what == "tube":
        ratio, heavy = rng.choice((2.0, 5.0, 10.0, 40.0)), rng.choice((1.0, 4.0, 8.0))
        middle = n // 2 * h
        thick = Matter(gas.words.replace(f"density = {density}", f"density = {heavy * density:g}"), heavy * density,
                       math.sqrt(ratio / heavy) * sound, carries=True, family="gas")
        writer.material("driver", thick)
        writer.box("left", low, (middle, high[1], high[2]))
        writer.box("right", (middle, 0.0, 0.0), high)
        writer.body("left", "left", "driver", thick, None, f"specific_energy = {energy * ratio / heavy:.6g} J/kg")
        writer.body("right", "right", "gas", gas, None, warm)
        speed = star((heavy * density, ratio * pressure), (density, pressure), gamma)
        scene.impact = scene.speed = speed
        hottest = max(energy, energy * ratio / heavy)
        # the incident and the reflected shock
        scene.heat = gamma * (gamma * hottest + 0.5 * speed ** 2) + 0.5 * speed ** 2 - hottest
        end = 3.0 * n * h / max(sound, thick.sound)
    else:
        ratio = rng.choice((100.0, 500.0))
        writer.groups.pop()
        hot = Matter(gas.words.replace(f"density = {density}", f"density = {ratio * density:g}"), ratio * density,
                     sound, carries=True, family="gas")
        writer.material("gas", hot)
        plate, name = metal(rng, rng.choice(("steel_4340", "al_6061_t6")))
        writer.material(name, plate)
        for face in ("xlo",) if flat else ("xlo", "zlo", "zhi") + (("ylo", "yhi") if scene.dimension == "3d" else ()):
            writer.wall(face, "slip")
        writer.box("chamber", low, high)
        writer.box("plate", (n * h, 0.0, 0.0), ((n + 4) * h, high[1], high[2]))
        writer.body("gas", "chamber", "gas", hot, None, warm)
        writer.body("plate", "plate", name, plate)
        scene.impact, scene.speed = 0.5 * sound, 2.0 * sound / (gamma - 1.0)
        scene.heat = energy
        return writer.text(low, ((n + 14) * h, high[1], high[2]), 1.0 * n * h / sound)
    return writer.text(low, high, end)


def scene(seed):
    """The scene of a seed."""
    rng = random.Random(f"foreign deck {seed}")
    made = Scene(seed, KINDS[seed % len(KINDS)])
    make = {"elastic": elastic, "metals": metals, "brittle": brittle, "grains": granular, "liquids": liquids,
            "gases": gases}[made.kind]
    made.deck = make(rng, made)
    return made


# ------------------------------------------------------------------------------------------------------------ judge

@dataclasses.dataclass
class Verdict:
    """Result of one deck."""

    seed: int
    kind: str
    name: str
    dimension: str
    passed: bool = True
    cause: str = ""              # the first of the findings
    findings: list = dataclasses.field(default_factory=list)
    energy: float = 0.0          # greatest running mean of what was lost (-) or made (+), of the energy that entered
    damped: float = 0.0          # recorded loss by the PIC fraction, of the same
    noise: str = ""              # verdict of the run on its noise
    trust: str = ""              # verdict of the run
    steps: int = 0
    seconds: float = 0.0         # processor time of the steps

    def find(self, cause, detail):
        """Record a failure."""
        self.passed, self.cause = False, self.cause or cause
        self.findings.append((cause, detail))


def judge(scree, scene, folder, options=(), limit=60):
    """Run the deck of a scene in a folder and check it. The limit is processor time [s], so that other programs do not
    make a run slow."""
    verdict = Verdict(scene.seed, scene.kind, scene.name, scene.dimension)
    shutil.rmtree(folder, ignore_errors=True)
    os.makedirs(folder)
    deck = os.path.join(folder, "deck.nml")
    with open(deck, "w", encoding="utf-8") as file:
        file.write(scene.deck)
    words = [str(scree), "-q", "--overwrite", "--outdir", os.path.join(folder, "out"), *options, deck]
    try:
        answer = subprocess.run(words, env={**os.environ, **ALONE}, text=True, check=False, stdout=subprocess.PIPE,
                                stderr=subprocess.STDOUT, cwd=folder, timeout=20 * limit,
                                preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_CPU, (limit, limit + 5)))
    except subprocess.TimeoutExpired:
        answer = None
    if answer is None or answer.returncode in (-signal.SIGXCPU, -signal.SIGKILL):
        verdict.seconds = limit
        verdict.find("slow", f"more than {limit} s")
        return verdict
    if answer.returncode == 2:
        lines = [line for line in answer.stdout.splitlines() if "error" in line]
        verdict.find("refused", " ".join(lines[:1])[-300:])
        return verdict
    try:
        with open(os.path.join(folder, "out", "deck.summary.json"), encoding="utf-8") as file:
            summary = json.load(file)
    except (OSError, ValueError):
        verdict.find("crash", f"exit code {answer.returncode}: {answer.stdout[-300:]}")
        return verdict
    verdict.steps, verdict.seconds = summary["steps"], summary["processor_s"]
    verdict.trust = summary["trust"]["verdict"]
    verdict.noise = summary["trust"]["noise"]["verdict"]
    if answer.returncode:
        text = " ".join(answer.stdout.split())
        verdict.find("ends early", f"exit code {answer.returncode} at {summary['time'] / scene.end:.2f} of t_end: "
                     f"{text[-400:]}")
    books(verdict, scene, table(os.path.join(folder, "out", "deck_history.csv")))
    first = None
    for when, fields in snapshots(os.path.join(folder, "out")):
        first = first or start(scene, fields)
        state(verdict, scene, fields, first, f"at {when / scene.end:.2f} of t_end")
    return verdict


def table(path):
    """Columns of a history by name, without units."""
    with open(path, encoding="utf-8") as file:
        lines = [line for line in file if line.strip() and not line.startswith("#")]
    names = [name.split("[")[0].strip().strip('"') for name in lines[0].split(",")]
    values = np.array([[float(word) for word in line.split(",")] for line in lines[1:]])
    return dict(zip(names, values.T))


def snapshots(folder):
    """Pairs of time and fields, oldest first."""
    import scree_post
    path = os.path.join(folder, "deck_p.hdf.series")
    if not os.path.exists(path):
        return
    for when, file in scree_post.series(path):
        snap = scree_post.snapshot(file)
        yield when, {"place": np.asarray(snap.points), **{name: np.asarray(snap.fields[name]) for name in snap.fields}}


def books(verdict, scene, history):
    """Mass, momentum and energy over the whole run."""
    if not all(np.isfinite(values).all() for values in history.values()):
        verdict.find("not finite", "history")
        return
    mass = float(history["mass"][0])
    worst = float(np.abs(history["mass"] + history["lost_mass"] + history["removed_mass"] - mass).max()) / mass
    if worst > 1.0e-12:
        verdict.find("mass", f"{worst:.1e}")
    scale = max(math.sqrt(2.0 * mass * history["kinetic"].max()),
                1.0e-3 * mass * max(matter.sound for matter in scene.matters))
    miss = 0.0
    for axis in {"1d": "x", "axisymmetric": "z"}.get(scene.dimension, "xyz"):
        whole = (history[f"momentum_{axis}"] + history[f"lost_momentum_{axis}"] + history[f"removed_momentum_{axis}"]
                 - history[f"impulse_{axis}"])
        scale = max(scale, np.abs(history[f"impulse_{axis}"]).max())
        miss = max(miss, float(np.abs(whole - whole[0]).max()))
    if miss > 1.0e-10 * scale:
        verdict.find("momentum", f"{miss / scale:.1e}")
    had = history["kinetic"] + history["internal"]
    entered = had[0] + np.maximum.accumulate(np.maximum(history["external_work"], 0.0))
    scale = max(float(entered.max()), float(had.max()) if not had[0] else 0.0)
    if scale <= 0.0:
        return
    motion = history["kinetic"] - history["external_work"]
    rest = history["internal"] + history["lost_energy"] + history["removed_energy"] + history["dissipated"] - had[0]
    width = max(1, len(rest) // 20)
    means = [np.convolve(whole / scale, np.full(width, 1.0 / width), "valid")
             for whole in (motion + rest, 0.5 * (motion[:-1] + motion[1:]) + rest[:-1])]
    verdict.energy = min((float(mean[np.abs(mean).argmax()]) for mean in means), key=abs)
    verdict.damped = float(history["damped"][-1]) / scale
    if abs(verdict.energy) > ENERGY:
        verdict.find("energy lost" if verdict.energy < 0.0 else "energy made", f"{100.0 * verdict.energy:.1f} %")


def start(scene, fields):
    """Volume and energy of each body at the start."""
    rows = bodies(scene, fields)
    return {row: float(fields["energy"][rows == row].max()) if "energy" in fields else 0.0
            for row in range(len(scene.matters))}


def bodies(scene, fields):
    """Number of the body of each particle, from 0."""
    if "body" not in fields or len(scene.matters) == 1:
        return np.zeros(len(fields["mass"]), int)
    return fields["body"].astype(int) - 1


def state(verdict, scene, fields, first, when):
    """Speed, energy per mass and volumes of a snapshot."""
    if not len(fields["mass"]):
        return
    if not all(np.isfinite(values).all() for values in fields.values()):
        verdict.find("not finite", when)
        return
    rows, mass = bodies(scene, fields), fields["mass"]
    speed = np.sqrt((fields["velocity"] ** 2).sum(axis=-1))
    sound = max(matter.sound for matter in scene.matters)
    limit = 2.0 * scene.speed
    over = speed > limit
    # jets of curved or oblique faces
    jets = scene.curved and scene.impact > 0.1 * min(matter.sound for matter in scene.matters)
    named = jets and speed.max() <= 2.0 * (scene.impact + sound) and mass[over].sum() <= JET * mass.sum()
    # waves double their speed once more at each edge of a free surface
    edges = scene.dimension != "1d" and over.sum() <= max(2, FEW * len(mass)) and speed.max() <= 2.0 * limit
    if over.any() and not (named or edges):
        verdict.find("fast particles", f"{when}: {speed.max():.4g} m/s of {scene.speed:.4g}, {int(over.sum())} of "
                     f"{len(mass)}, {scene.matters[rows[speed.argmax()]].family}")
    for row, matter in enumerate(scene.matters):
        own = rows == row
        if own.any():
            body(verdict, scene, matter, {name: values[own] for name, values in fields.items()}, first[row], when)
    space = cells(scene, fields["place"])
    whole = float(fields["volume"].sum())
    if scene.box:
        space = scene.box - scene.swept * min(1.0, float(when.split()[1]))
        # a step of the piston, and what lies in cut cells
        if abs(whole / space - 1.0) > GAS_VOLUME:
            verdict.find("volume of box", f"{when}: {whole / space:.4f}")
    elif whole > space:
        verdict.find("volume beyond space", f"{when}: {whole / space:.3g} of the cells around")


def body(verdict, scene, matter, fields, energy, when):
    """Energy per mass and volume of one body."""
    mass = fields["mass"]
    if matter.carries and "energy" in fields:
        most = scene.heat or 0.5 * scene.impact ** 2
        if scene.dimension != "1d":
            most += 3.0 * matter.flow / matter.density
        gained = fields["energy"] - energy
        most = HEAT * max(most, 1.0e-6 * matter.sound ** 2)
        over = gained > most
        share = float(mass[over].sum() / mass.sum())
        named = scene.curved and share <= JET and gained.max() <= 3.0 * most / HEAT
        if over.any() and not named:
            verdict.find("hot layer" if share > JET else "hot particles", f"{when}: {gained.max():.3g} J/kg of "
                         f"{most / HEAT:.3g}, {int(over.sum())} of {len(mass)}, {matter.family}")
    rate = scene.impact / matter.sound
    whole = np.ones(len(mass), bool)
    if matter.breaks:
        whole = fields["failed"] < 0.5 if "failed" in fields else np.zeros(len(mass), bool)
    if matter.family in ("gas", "grains") or rate > 0.6 or not whole.any() or scene.speed > 0.6 * matter.sound:
        return
    ratio = float(fields["volume"][whole].sum()) * matter.density / float(mass[whole].sum())
    least, most = 0.9 * (1.0 - rate / (1.0 + 1.2 * rate)), 1.1 + rate
    if not least <= ratio <= most:
        verdict.find("volume of " + matter.family, f"{when}: V/V0 = {ratio:.3g}, limits {least:.2f} and {most:.2f}")


def cells(scene, places):
    """Volume of the cells with particles and of those around them."""
    axes = {"1d": (0,), "3d": (0, 1, 2)}.get(scene.dimension, (0, 2))
    own = np.unique(np.floor(places[:, axes] / scene.dx).astype(int), axis=0)
    steps = np.stack(np.meshgrid(*[(-1, 0, 1)] * len(axes), indexing="ij"), axis=-1).reshape(-1, len(axes))
    found = np.unique((own[:, None, :] + steps[None, :, :]).reshape(-1, len(axes)), axis=0)
    if scene.dimension == "axisymmetric":
        inner = np.maximum(found[:, 0], 0)
        return float((np.pi * (2 * inner + 1) * (found[:, 0] >= 0)).sum()) * scene.dx ** 3
    return len(found) * scene.dx ** 3
