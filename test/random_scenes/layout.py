# SPDX-License-Identifier: BSD-3-Clause
"""Kinds of random scenes: bodies, walls and time, with all lengths in cells until the deck is written."""

import dataclasses
import math

import materials
import shapes
from chance import group, short

AXES = {"1d": (0,), "plane_strain": (0, 2), "axisymmetric": (0, 2), "3d": (0, 1, 2)}
DEPTH = 1.0                    # of a plane or line [m]
FACES = ("xlo", "xhi", "ylo", "yhi", "zlo", "zhi")
MOST = {"1d": 400, "plane_strain": 3600, "axisymmetric": 3600, "3d": 2600}
ACROSS = {"1d": (3, 30), "plane_strain": (3, 22), "axisymmetric": (3, 22), "3d": (3, 7)}
CLOSED = {"slip": 3, "stick": 2, "symmetry": 2, "friction": 1}


@dataclasses.dataclass
class Body:
    """A body of a deck."""

    name: str
    matter: int
    shape: shapes.Shape
    place: list                # of its origin [cells]
    ppc: list
    velocity: list             # [m/s]
    spin: list = None
    packing: str = None
    stress: dict = dataclasses.field(default_factory=dict)
    temperature: float = None
    energy: float = None

    def regions(self, dx):
        """Text of the groups &region of the body."""
        return self.shape.regions(self.name, self.place, dx)

    def text(self):
        """Text of its &body."""
        moving = self.velocity if any(self.velocity) else None
        return group("body", name=self.name, region=self.name, material=f"m{self.matter + 1}",
                     ppc=self.ppc if self.packing != "file" else None, packing=self.packing, velocity=moving,
                     spin=self.spin, temperature=self.temperature, specific_energy=self.energy, **self.stress)


class Plan:
    """A scene to which parts are added."""

    def __init__(self, chance, dimension, effect_kind):
        self.chance, self.dimension = chance, dimension
        self.axes = AXES[dimension]
        self.axis = self.axes[-1]                       # direction in which bodies fall and meet
        low, high = ACROSS[dimension]
        self.across = min(high, int(chance.log(low, high + 1)))
        self.effects = materials.draw_effects(chance, effect_kind)
        self.dx = float(f"{chance.log(1.0e-4, 1.0) / self.across:.3g}")
        self.ppc = chance.choose({2: 6, 3: 2, 4: 1}) if dimension != "3d" else 2
        self.bodies, self.matters, self.walls = [], [], []
        self.cells = [1, 1, 1]
        self.origin = [0, 0, 0]
        self.impact = self.frame = self.fall = 0.0
        self.extra = 0.0                                # speed that the initial energy can cause [m/s]
        self.oblique, self.full, self.swept, self.area, self.time = False, 0.0, 0.0, 0.0, 0.0

    def matter(self, family):
        """Add a material; returns its number."""
        self.matters.append(materials.draw(self.chance, family, self.effects, self.dx))
        return len(self.matters) - 1

    def lattice(self, number=None):
        """Particles per cell along each direction."""
        number = number or self.ppc
        return [number if axis in self.axes else 1 for axis in range(3)]

    def half(self, along=None):
        """Half edges of a body of about `across` cells."""
        edges = [0.5 * self.across * (1.0 if self.chance.true(0.5) else self.chance.uniform(0.5, 1.5))
                 for _ in range(3)]
        edges = [max(1.5, round(2.0 * edge) / 2.0) for edge in edges]
        if along:
            edges[self.axis] = along
        return edges

    def add(self, name, matter, shape, place, velocity, **more):
        """Add a body."""
        packing = shape.packing
        if packing is None and self.chance.true(0.25):
            packing = self.chance.choose(["cut", "jitter", "poisson_disk"])
        body = Body(name, matter, shape, place, self.lattice(), velocity, packing=packing, **more)
        if self.effects.get("thermal") and self.chance.true(0.3):
            body.temperature = self.chance.uniform(250.0, 450.0)
        own = self.matters[matter]
        if own.family == "gas" and body.energy is None:
            body.energy = own.energy
        self.bodies.append(body)
        return body

    def enclose(self, margin):
        """A grid around all bodies, with `margin` cells on each side: (lower, upper) for each direction."""
        for axis in self.axes:
            low = min(body.place[axis] - body.shape.half[axis] for body in self.bodies)
            high = max(body.place[axis] + body.shape.half[axis] for body in self.bodies)
            if axis == 0 and self.dimension == "axisymmetric":
                self.origin[axis] = 0
            else:
                self.origin[axis] = math.floor(low - margin[axis][0])
            self.cells[axis] = max(2, math.ceil(high + margin[axis][1]) - self.origin[axis])

    def grid(self):
        """Text of &grid."""
        low, high = [], []
        for axis in range(3):
            if axis in self.axes:
                low.append(self.origin[axis] * self.dx)
                high.append((self.origin[axis] + self.cells[axis]) * self.dx)
            else:
                low.append(0.0)
                high.append(0.0 if self.dimension == "axisymmetric" else DEPTH)
        return group("grid", lo=low, hi=high, dx=self.dx)

    def particles(self):
        """Approximate number of particles."""
        total = 0.0
        for body in self.bodies:
            volume = 1.0
            for axis in self.axes:
                edge = 2.0 * min(body.shape.half[axis], self.cells[axis])
                if axis == 0 and self.dimension == "axisymmetric":
                    edge *= 0.5
                volume *= edge * body.ppc[axis]
            total += volume
        return total

    def shrink(self):
        """Reduce the particles per cell where there would be too many."""
        while self.particles() > MOST[self.dimension]:
            most = max(max(body.ppc) for body in self.bodies)
            if most <= 2:
                break
            for body in self.bodies:
                body.ppc = [min(number, most - 1) for number in body.ppc]

    def face(self, name, word, **more):
        """A boundary of a type; open boundaries need no group."""
        if self.dimension == "axisymmetric" and name == "xlo":
            return
        if word == "friction":
            more["friction"] = self.chance.uniform(0.0, 0.8)
        if word != "outflow" or self.chance.true(0.2):
            self.walls.append(group("boundary", face=name, type=word, **more))

    def faces(self, words, skip=()):
        """All boundaries except given ones."""
        for axis in self.axes:
            for side in (0, 1):
                name = FACES[2 * axis + side]
                if name not in skip:
                    self.face(name, self.chance.choose(words))

    def vector(self, along, aside=0.0):
        """A velocity with components along the axis of the scene and across."""
        value = [0.0, 0.0, 0.0]
        value[self.axis] = short(along)
        if aside and self.dimension in ("plane_strain", "3d"):
            value[0] = short(aside)
        return value

    def speed(self, numbers):
        """An impact speed within the range of all given materials."""
        most = min(self.matters[number].speed_limit for number in numbers)
        return self.chance.log(min(1.0, 0.1 * most), most)

    def passes(self, low, high):
        """Duration of some passes of the slower of wave and impact through the bodies [s]."""
        length = max(2.0 * max(body.shape.half[axis] for axis in self.axes) for body in self.bodies) * self.dx
        slow = min(matter.wave_speed for matter in self.matters)
        return self.chance.uniform(low, high) * length / max(slow, self.impact)

    def gravity(self, size):
        """Gravity for which the weight of some cells is far below the stiffness; returns the acceleration."""
        slow = min(matter.bulk_speed for matter in self.matters)
        pull = self.chance.log(1.0e-4, 1.0e-2) * slow ** 2 / (size * self.dx)
        value = self.vector(-pull)
        self.effects.update(gravity=True, gravity_vector=value)
        return pull

    def push(self):
        """Speed that the initial energy can cause: heat that becomes motion, or a gas that expands into vacuum."""
        speed = self.extra
        for body in self.bodies:
            matter = self.matters[body.matter]
            if matter.family == "gas" and not self.full:
                gamma = matter.gamma
                speed = max(speed, 2.0 / (gamma - 1.0) * math.sqrt(gamma * (gamma - 1.0) * body.energy))
            elif body.energy and matter.family != "gas":
                speed = max(speed, 2.0 * math.sqrt(2.0 * body.energy))
        return speed


def dimension_of(chance, words=None):
    """A random dimension."""
    weights = {"1d": 20, "plane_strain": 40, "axisymmetric": 15, "3d": 25}
    return chance.choose({word: weights[word] for word in (words or weights)})


def solid(chance, effects):
    """A random family of solids."""
    words = {"metal": 5, "brittle": 2, "soft": 4, "porous": 1}
    if effects.get("thermal") or effects.get("voids") or not effects.get("eos", True):
        words["porous"] = 0
    if not effects.get("strength", True):
        words["brittle"] = 1
    return chance.choose(words)


def couple(plan, first, second):
    """Two materials; the same one in four of ten scenes. Steps are those of the stiffer one, so the time scales of both
    are within a factor of thirty."""
    a = plan.matter(first)
    if plan.chance.true(0.4):
        return a, a
    for _ in range(6):
        b = plan.matter(second)
        ratio = plan.matters[a].wave_speed / plan.matters[b].wave_speed
        if 1.0 / 30.0 < ratio < 30.0:
            return a, b
        plan.matters.pop()
    return a, a


def gap_of(plan):
    """Gap between bodies: none, a fraction of a cell, or some cells [cells]."""
    return plan.chance.choose({0.0: 4, 0.3: 2, 1.0: 3, 2.5: 1})


def stick_or_slip(plan):
    """Contact between bodies in a fifth of the scenes."""
    if len(plan.bodies) < 2 or not plan.chance.true(0.2):
        return
    plan.effects["contact"] = True
    law = plan.chance.choose(["friction", "stick", "frictionless", "bonded"])
    strength = None
    if law == "bonded" and plan.chance.true(0.5):
        matter = plan.matters[0]
        strength = short(1.0e-2 * matter.density * matter.bulk_speed ** 2)
    plan.walls.append(group("contact", law=law, bond_strength=strength, friction=plan.chance.uniform(0.0, 0.6)
                            if law in ("friction", "bonded") else None))


def meet(plan, speed, gap, aside=0.0):
    """The upper of two bodies flies against the lower one; both have a common velocity, which must have no effect."""
    chance = plan.chance
    drift = chance.choose({0.0: 3, -0.5: 1, 0.3: 1}) * speed
    lower, upper = plan.bodies
    lower.velocity = plan.vector(drift)
    upper.velocity = plan.vector(drift - speed, aside)
    plan.impact = math.hypot(speed, aside)
    plan.frame = max(math.hypot(drift - speed, aside), abs(drift))
    # the time to cross the gap is added, and the gap is small if that would be most of the run
    plan.time = plan.passes(2.0, 6.0)
    if gap * plan.dx / speed > 0.5 * plan.time:
        gap = short(0.5 * plan.time * speed / plan.dx)
    upper.place[plan.axis] += gap
    plan.time += gap * plan.dx / speed


def impact(chance, target=False):
    """Two bodies meet, normally or obliquely; the target may be a plate with a thickness of some cells."""
    dimension = dimension_of(chance)
    plan = Plan(chance, dimension, "shock" if chance.true(0.6) else "solid")
    first = solid(chance, plan.effects)
    second = solid(chance, plan.effects) if chance.true(0.85) or target else chance.choose(["liquid", "grains"])
    if not plan.effects.get("strength", True) and second == "grains" or not plan.effects.get("eos", True):
        second = first
    a, b = couple(plan, first, second)
    simple = chance.true(0.5)
    upper = shapes.draw(chance, dimension, plan.half(), simple)
    if target:
        wide = plan.half(along=max(1.5, 0.5 * float(chance.integer(3, max(3, plan.across)))))
        for axis in plan.axes[:-1]:
            wide[axis] = max(1.5, round(1.5 * upper.half[axis] * 2.0) / 2.0)
        lower = shapes.draw(chance, "1d" if dimension == "1d" else dimension, wide, True, turns=False)
        lower = dataclasses.replace(lower, word="box", half=tuple(wide), parts=shapes.box(
            chance, dimension, [edge if axis in plan.axes else shapes.FAR for axis, edge in enumerate(wide)], {}))
    else:
        lower = shapes.draw(chance, dimension, plan.half(), simple)
    speed = plan.speed((a, b))
    place = [0.0, 0.0, 0.0]
    plan.add("low", b, lower, list(place), [0.0] * 3)
    place[plan.axis] = lower.half[plan.axis] + upper.half[plan.axis]
    if dimension in ("plane_strain", "3d") and chance.true(0.4):
        place[0] = chance.uniform(-0.5, 0.5) * (lower.half[0] + upper.half[0])
    if chance.true(0.4):
        place[plan.axis] += chance.uniform(0.0, 1.0)
    aside = speed * chance.uniform(0.2, 1.5) if dimension in ("plane_strain", "3d") and chance.true(0.35) else 0.0
    plan.add("up", a, upper, place, [0.0] * 3)
    meet(plan, speed, gap_of(plan), aside)
    plan.oblique = bool(aside) or lower.word != "box" or upper.word != "box" or bool(upper.turn or lower.turn)
    plan.enclose([(chance.integer(2, 6), chance.integer(2, 6)) for _ in range(3)])
    plan.faces({"outflow": 6, "slip": 1, "stick": 1, "symmetry": 1})
    stick_or_slip(plan)
    conduct(plan)
    plan.shrink()
    return plan


def target(chance):
    """A body flies against a plate."""
    return impact(chance, target=True)


def conduct(plan):
    """Conduction of heat in a third of the scenes with temperatures, so slow that it does not limit the step."""
    if plan.effects.get("contact") or not plan.effects.get("thermal") or not plan.chance.true(0.35):
        return
    for matter in plan.matters:
        diffusivity = plan.dx * matter.wave_speed * plan.chance.log(1.0e-3, 0.2)
        matter.keys["conductivity"] = short(diffusivity * matter.density * matter.heat)


def wall(chance):
    """A body flies against a boundary or against a rigid region."""
    dimension = dimension_of(chance)
    plan = Plan(chance, dimension, "shock" if chance.true(0.5) else "solid")
    number = plan.matter(solid(chance, plan.effects))
    shape = shapes.draw(chance, dimension, plan.half(), chance.true(0.5))
    speed = plan.speed((number,))
    aside = speed * chance.uniform(-1.0, 1.0) if dimension in ("plane_strain", "3d") and chance.true(0.3) else 0.0
    plan.impact = plan.frame = math.hypot(speed, aside)
    body = plan.add("body", number, shape, [0.0, 0.0, 0.0], plan.vector(-speed, aside))
    plan.time = plan.passes(2.0, 6.0)
    gap = min(gap_of(plan), short(0.5 * plan.time * speed / plan.dx))
    plan.time += gap * plan.dx / speed
    place = math.ceil(shape.half[plan.axis])
    body.place[plan.axis] = place + shape.half[plan.axis] + gap
    rigid = chance.true(0.4)
    margin = [[chance.integer(2, 6), chance.integer(2, 6)] for _ in range(3)]
    plan.enclose(margin)
    plan.origin[plan.axis] = place - (3 if rigid else 0)
    top = math.ceil(body.place[plan.axis] + shape.half[plan.axis])
    plan.cells[plan.axis] = top + margin[plan.axis][1] - plan.origin[plan.axis]
    plan.oblique = bool(aside) or shape.word != "box" or bool(shape.turn)
    name = FACES[2 * plan.axis]
    if rigid:
        rigid_floor(plan, place)
    elif plan.axis == 0 or chance.true(0.85):
        plan.face(name, chance.choose(CLOSED))
    else:
        along = short(speed * chance.uniform(-0.5, 0.5)) if dimension != "axisymmetric" else 0.0
        plan.face(name, "velocity", velocity=[along, 0.0, 0.0])
    plan.faces({"outflow": 7, "slip": 1, "symmetry": 1}, skip=(name,))
    conduct(plan)
    plan.shrink()
    return plan


def rigid_floor(plan, place):
    """A rigid region whose surface is at a position along the axis of the scene [cells]."""
    chance = plan.chance
    centre = [0.0, 0.0, 0.0]
    normal = [0.0, 0.0, 0.0]
    centre[plan.axis], normal[plan.axis] = place * plan.dx, 1.0
    plan.walls.append(group("region", name="floor", shape="halfspace", centre=centre, normal=normal))
    kind = chance.choose(["stick", "slip", "friction", "velocity"])
    plan.walls.append(group("boundary", region="floor", type=kind,
                            friction=chance.uniform(0.0, 0.8) if kind == "friction" else None))


def flight(chance):
    """A body flies and rotates; it may leave the box, or enter it again through a periodic boundary."""
    dimension = dimension_of(chance)
    plan = Plan(chance, dimension, "solid")
    number = plan.matter(solid(chance, plan.effects))
    matter = plan.matters[number]
    shape = shapes.draw(chance, dimension, plan.half(), chance.true(0.4))
    speed = chance.log(1.0, 15000.0)
    velocity = plan.vector(speed if chance.true(0.5) else -speed, speed * chance.uniform(-1.0, 1.0))
    spin, rim = None, 0.0
    if dimension in ("plane_strain", "3d") and chance.true(0.6):
        # the rim rotates so slowly that the centrifugal strain is below a thousandth
        rim = 0.03 * matter.speed_limit if matter.speed_limit < matter.wave_speed else 0.01 * matter.wave_speed
        radius = max(shape.half[axis] for axis in plan.axes) * plan.dx
        spin = [0.0, short(chance.uniform(0.1, 1.0) * rim / radius), 0.0]
    plan.add("body", number, shape, [0.0, 0.0, 0.0], velocity, spin=spin)
    plan.frame = math.sqrt(sum(part ** 2 for part in velocity)) + 2.0 * rim
    plan.impact = 2.0 * rim
    length = 2.0 * max(shape.half[axis] for axis in plan.axes) * plan.dx
    plan.time = chance.uniform(2.0, 8.0) * max(length / speed, length / matter.wave_speed)
    if speed < matter.wave_speed:
        plan.time = min(plan.time, 6.0 * length / matter.wave_speed)
    if chance.true(0.15):
        plan.gravity(length / plan.dx)
        plan.fall = plan.effects["gravity_vector"][plan.axis] * -plan.time
    plan.enclose([(chance.integer(2, 6), chance.integer(2, 6)) for _ in range(3)])
    if chance.true(0.25) and dimension != "axisymmetric":
        axis = chance.choose(plan.axes)
        plan.face(FACES[2 * axis], "periodic")
        plan.face(FACES[2 * axis + 1], "periodic")
    conduct(plan)
    plan.shrink()
    return plan


def several(chance):
    """Three or four bodies in a row meet one after another, in a box that may be closed."""
    dimension = dimension_of(chance)
    plan = Plan(chance, dimension, "shock" if chance.true(0.4) else "solid")
    plan.across = max(3, plan.across // 2)
    first = solid(chance, plan.effects)
    a, b = couple(plan, first, solid(chance, plan.effects))
    speed = plan.speed((a, b))
    height, lows = 0.0, []
    for index in range(chance.integer(3, 4)):
        shape = shapes.draw(chance, dimension, plan.half(), chance.true(0.6))
        place = [0.0, 0.0, 0.0]
        if dimension in ("plane_strain", "3d"):
            place[0] = chance.uniform(-1.0, 1.0) * shape.half[0]
        height += shape.half[plan.axis]
        place[plan.axis] = height
        height += shape.half[plan.axis] + gap_of(plan)
        velocity = plan.vector(speed * chance.uniform(-1.0, 1.0))
        lows.append(velocity[plan.axis])
        plan.add(f"b{index + 1}", chance.choose([a, b]), shape, place, velocity)
    plan.impact = max(max(lows) - min(lows), max(abs(low) for low in lows))
    plan.frame = max(abs(low) for low in lows)
    plan.oblique = dimension != "1d"
    plan.time = plan.passes(2.0, 6.0)
    plan.enclose([(chance.integer(1, 4), chance.integer(1, 4)) for _ in range(3)])
    plan.faces({"outflow": 4, "slip": 1, "stick": 1, "symmetry": 1, "friction": 1})
    used = {body.matter for body in plan.bodies}
    if used != set(range(len(plan.matters))):
        plan.matters = [plan.matters[number] for number in sorted(used)]
        for body in plan.bodies:
            body.matter = sorted(used).index(body.matter)
    stick_or_slip(plan)
    conduct(plan)
    plan.shrink()
    return plan
