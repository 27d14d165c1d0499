# SPDX-License-Identifier: BSD-3-Clause
"""Kinds of random scenes in which material fills or rests in a box: weight, gases, liquids."""

import math

import shapes
from chance import group, short
from layout import CLOSED, DEPTH, FACES, Plan, dimension_of


def column(plan, edges, floor=0.0):
    """A box from a corner of the grid: half edges and position, in cells."""
    half = [shapes.FAR] * 3
    place = [0.0, 0.0, 0.0]
    for axis in plan.axes:
        half[axis] = 0.5 * edges[axis]
        place[axis] = 0.5 * edges[axis] + (floor if axis == plan.axis else 0.0)
        if axis == 0 and plan.dimension == "axisymmetric":
            half[axis], place[axis] = edges[axis], 0.0
    parts = shapes.box(plan.chance, plan.dimension, half, {})
    return shapes.Shape("box", tuple(half), parts, {}), place


def weight(chance):
    """Grains or a solid under gravity: dropped, released as a column, or at rest with the stress of their weight."""
    dimension = dimension_of(chance)
    loose = chance.true(0.65)
    plan = Plan(chance, dimension, "loose" if loose else "solid")
    number = plan.matter("grains" if loose else chance.choose(["soft", "brittle", "metal"]))
    edges = [float(max(3, round(plan.across * chance.uniform(0.6, 1.4)))) for _ in range(3)]
    gap = chance.choose({0.0: 5, 1.0: 1, 2.5: 1})
    pull = plan.gravity(edges[plan.axis])
    shape, place = column(plan, edges, gap)
    body = plan.add("heap", number, shape, place, [0.0] * 3)
    filled = dimension == "1d" or chance.true(0.4)
    if filled and gap == 0.0 and not plan.matters[number].keys.get("gr_mode") == "total" and (
            plan.matters[number].keys.get("strength_model") != "neo_hookean") and (
            body.packing in (None, "cut", "jitter")) and chance.true(0.5):
        body.stress = {"initial_stress": "lithostatic", "k0": chance.uniform(0.4, 1.0)}
    for axis in plan.axes:
        free = chance.integer(2, 6) if axis == plan.axis else 0 if filled else chance.integer(2, plan.across)
        plan.cells[axis] = max(2, int(edges[axis] + (gap if axis == plan.axis else 0.0) + free + 0.99))
    height = (edges[plan.axis] + gap) * plan.dx
    plan.fall = math.sqrt(2.0 * pull * height)
    plan.time = chance.uniform(0.5, 3.0) * math.sqrt(2.0 * height / pull)
    for axis in plan.axes[:-1]:
        plan.face(FACES[2 * axis], chance.choose({"slip": 2, "symmetry": 2}))
        plan.face(FACES[2 * axis + 1], chance.choose({"slip": 2, "symmetry": 1} if filled else CLOSED))
    plan.face(FACES[2 * plan.axis], chance.choose(CLOSED))
    if chance.true(0.3):
        plan.face(FACES[2 * plan.axis + 1], "outflow")
    keys = plan.matters[number].keys
    if keys.get("strength_model") in ("drucker_prager", "mohr_coulomb", "mu_i") and "cohesion" not in keys and (
            not plan.effects.get("voids")) and chance.true(0.2):
        keys["volume_from"] = "grid"
    plan.shrink()
    return plan


def closed(plan, skip=()):
    """Closed or periodic boundaries on all sides of a full box."""
    for axis in plan.axes:
        if FACES[2 * axis] in skip or FACES[2 * axis + 1] in skip or not (
                plan.chance.true(0.15) and plan.cells[axis] >= 4 and not (
                    axis == 0 and plan.dimension == "axisymmetric")):
            for side in (0, 1):
                if FACES[2 * axis + side] not in skip:
                    plan.face(FACES[2 * axis + side], plan.chance.choose(CLOSED))
        else:
            plan.face(FACES[2 * axis], "periodic")
            plan.face(FACES[2 * axis + 1], "periodic")


def volume(plan, edges):
    """Volume of a box of a given number of cells [m3]."""
    if plan.dimension == "axisymmetric":
        return math.pi * edges[0] ** 2 * edges[2] * plan.dx ** 3
    result = 1.0
    for axis in range(3):
        result *= edges[axis] * plan.dx if axis in plan.axes else DEPTH
    return result


def box(chance):
    """A gas fills a closed box: at rest, sloshing, or compressed by a rigid piston."""
    dimension = dimension_of(chance)
    plan = Plan(chance, dimension, "gas")
    number = plan.matter("gas")
    matter = plan.matters[number]
    edges = [float(max(3, round(plan.across * chance.uniform(0.5, 1.5)))) for _ in range(3)]
    shape, place = column(plan, edges)
    for axis in plan.axes:
        plan.cells[axis] = int(edges[axis])
    body = plan.add("gas", number, shape, place, [0.0] * 3)
    length = edges[plan.axis] * plan.dx
    plan.full = volume(plan, edges)
    plan.time = chance.uniform(2.0, 12.0) * length / matter.wave_speed
    state = chance.choose({"rest": 4, "slosh": 3, "piston": 3})
    skip = ()
    if state == "slosh":
        speed = matter.wave_speed * chance.log(1.0e-3, 0.3)
        plan.impact = plan.frame = speed
        body.velocity = plan.vector(speed)
    elif state == "piston":
        # the piston moves by a fifth of the height at most, so pressures remain within a factor of two
        speed = matter.wave_speed * chance.log(3.0e-3, 0.2)
        plan.time = min(plan.time, 0.2 * length / speed)
        plan.impact = plan.frame = speed
        plan.area = plan.full / length
        plan.swept = speed
        plan.cells[plan.axis] += 3
        low, high = [-shapes.FAR * plan.dx] * 3, [shapes.FAR * plan.dx] * 3
        low[plan.axis] = length
        plan.walls += [group("region", name="piston", shape="box", lo=low, hi=high),
                       group("boundary", region="piston", type="slip", velocity=plan.vector(-speed))]
        skip = (FACES[2 * plan.axis + 1],)
    closed(plan, skip)
    plan.shrink()
    return plan


def expansion(chance):
    """A gas beside a thinner one, a hot centre in a cold gas, or a ball of gas in vacuum."""
    dimension = dimension_of(chance)
    plan = Plan(chance, dimension, "gas")
    number = plan.matter("gas")
    matter = plan.matters[number]
    edges = [float(max(4, round(plan.across * chance.uniform(0.8, 1.5)))) for _ in range(3)]
    if chance.true(0.35):
        shape = shapes.draw(chance, dimension, [0.5 * edge for edge in edges], True)
        plan.add("gas", number, shape, [0.0, 0.0, 0.0], [0.0] * 3)
        plan.enclose([(chance.integer(2, 8), chance.integer(2, 8)) for _ in range(3)])
        plan.faces({"outflow": 4, "slip": 1})
    else:
        shape, place = column(plan, edges)
        plan.add("gas", number, shape, place, [0.0] * 3)
        for axis in plan.axes:
            plan.cells[axis] = int(edges[axis])
        hot = [edge if axis != plan.axis else round(0.5 * edge) for axis, edge in enumerate(edges)]
        if dimension != "1d" and chance.true(0.5):
            hot = [max(2.0, round(0.3 * edge)) for edge in edges]
        inner, place = column(plan, hot)
        other = number
        if chance.true(0.5):
            other = plan.matter("gas")
            plan.matters[other].keys["density"] = short(matter.density * chance.log(1.0, 30.0))
            plan.matters[other].density = plan.matters[other].keys["density"]
        energy = short(matter.energy * chance.log(2.0, 100.0))
        plan.add("hot", other, inner, place, [0.0] * 3, energy=energy)
        own = plan.matters[other]
        plan.full = volume(plan, edges)
        own.wave_speed = math.sqrt(own.gamma * (own.gamma - 1.0) * energy)
        plan.extra = 2.0 / (own.gamma - 1.0) * own.wave_speed
        closed(plan)
    fast = max(own.wave_speed for own in plan.matters)
    plan.time = chance.uniform(0.5, 3.0) * edges[plan.axis] * plan.dx / fast
    plan.shrink()
    return plan


def liquid(chance):
    """A liquid in a box: released as a column, sloshing, at rest under its weight, or as a drop."""
    dimension = dimension_of(chance)
    plan = Plan(chance, dimension, "liquid")
    number = plan.matter("liquid")
    matter = plan.matters[number]
    edges = [float(max(3, round(plan.across * chance.uniform(0.6, 1.4)))) for _ in range(3)]
    pull = plan.gravity(edges[plan.axis])
    state = chance.choose({"column": 3, "pool": 3, "drop": 2}) if dimension != "1d" else "pool"
    height = edges[plan.axis]
    if state == "drop":
        shape = shapes.draw(chance, dimension, [0.5 * edge for edge in edges], True)
        place = [0.0, 0.0, 0.0]
        place[plan.axis] = shape.half[plan.axis] + chance.choose([0.0, 1.0])
        height = place[plan.axis] + shape.half[plan.axis]
        speed = plan.speed((number,))
        plan.impact = plan.frame = speed
        plan.add("drop", number, shape, place, plan.vector(-speed))
        plan.enclose([(chance.integer(2, 6), chance.integer(2, 6)) for _ in range(3)])
        plan.origin[plan.axis] = 0
        plan.cells[plan.axis] = math.ceil(height) + 4
    else:
        shape, place = column(plan, edges)
        body = plan.add("pool", number, shape, place, [0.0] * 3)
        for axis in plan.axes:
            free = chance.integer(2, 6) if axis == plan.axis or state == "column" else 0
            plan.cells[axis] = int(edges[axis]) + free
        if state == "pool" and body.packing in (None, "cut", "jitter") and chance.true(0.5):
            body.stress = {"initial_stress": "lithostatic", "k0": 1.0}
    plan.fall = math.sqrt(2.0 * pull * height * plan.dx)
    plan.time = min(chance.uniform(0.5, 3.0) * math.sqrt(2.0 * height * plan.dx / pull),
                    60.0 * height * plan.dx / matter.wave_speed)
    plan.faces(CLOSED, skip=(FACES[2 * plan.axis + 1],))
    plan.shrink()
    return plan
