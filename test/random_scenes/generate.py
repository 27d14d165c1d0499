# SPDX-License-Identifier: BSD-3-Clause
"""A random valid deck from a seed.

    scene = generate.scene(17)
    scene.deck, scene.files            # text of the deck, and of the files that it reads
    scene.kind, scene.matters, ...     # what was put in, for judge.py

The deck is a pure function of the seed: chance.py has its own random numbers. Distributions:

kind        impact 30 %, a thin target 10 %, a wall or rigid region 14 %, weight 12 %, gas in a box 9 %, gas that
            expands or is shocked 6 %, liquid 7 %, flight with spin 6 %, three or four bodies 6 %
dimension   1d 20 %, plane strain 40 %, axisymmetric 15 %, 3d 25 %
size        0.1 mm to 1 m across; 3 to 30 cells, fewer in space; 2 to 4 particles a cell and direction; at most 4000
speed       logarithmic from 1 m/s to what the laws hold for: 15 km/s where an equation of state has energy, 0.2 to 0.5
            of the wave speed for elastic and granular laws and liquids
time        a few passes of a wave, crossings of the impact or falls; at most 1.5 million particle updates, 4000 steps
matter      materials.py: ten presets, and every law, equation of state and model of failure
bodies      shapes.py: every shape; packings, spin, temperature, energy, stress of weight
walls       all types of faces, rigid regions at rest and as pistons, contact, gravity
method      methods.py: 80 % of decks have the default; 20 % another transfer, basis, quadrature, update, cfl, splitting

Left out: `&exact` and `&point`, whose results are known and tested elsewhere; units, since other units give the same
bits (test/invariance); parts of boundaries, tables of motion, outputs and jobs.
"""

import dataclasses

import fills
import layout
import methods
from chance import Chance, group

MOST_UPDATES = 1.5e6          # particles times steps: about a second on one core
KINDS = {"impact": 30, "target": 10, "wall": 14, "weight": 12, "box": 9, "expansion": 6, "liquid": 7, "flight": 6,
         "several": 6}
MAKERS = {"impact": layout.impact, "target": layout.target, "wall": layout.wall, "weight": fills.weight,
          "box": fills.box, "expansion": fills.expansion, "liquid": fills.liquid, "flight": layout.flight,
          "several": layout.several}


@dataclasses.dataclass
class Scene:
    """A deck and its contents."""

    seed: int
    kind: str
    dimension: str
    deck: str
    files: dict
    dx: float                         # [m]
    bodies: list                      # of layout.Body, in the order of the deck
    matters: list                     # of materials.Matter, in the order of the deck
    effects: dict
    method: methods.Method
    impact: float                     # greatest relative speed of bodies, or of a body and a closed face [m/s]
    frame: float                      # greatest speed of a body or of a wall, with its spin [m/s]
    fall: float                       # greatest speed gained by gravity [m/s]
    push: float                       # speed that the initial energy and pressure can cause [m/s]
    oblique: bool                     # bodies do not meet flat boundaries along the normal
    full: float                       # volume of a closed box that is full at the start, 0 if there is none [m3]
    swept: float                      # volume of it that a piston sweeps until the end [m3]
    contact: bool
    steps: int                        # estimate
    t_end: float                      # [s]


def scene(seed):
    """The deck of a seed."""
    chance = Chance(seed)
    kind = chance.choose(KINDS)
    plan = MAKERS[kind](chance)
    method = methods.draw(chance, plan)
    return finish(seed, kind, chance, plan, method)


def finish(seed, kind, chance, plan, method):
    """Boundaries, time and outputs, and the text of the deck."""
    dx = plan.dx
    # a step is a fraction of a cell over the fastest wave speed, which a shock increases by up to three times
    fast = max(matter.wave_speed for matter in plan.matters) + max(1.5 * plan.impact, plan.frame, plan.fall)
    t_end = plan.time
    steps = fast * t_end / dx / method.cfl
    particles = plan.particles()
    most = min(MOST_UPDATES / max(particles, 50), 4000.0)
    if steps > most:
        t_end *= most / steps
        steps = most
    # runs that need six times as many steps have an error, or are listed for inspection
    steps = int(steps) + 30
    t_end = float(f"{t_end:.4g}")
    texts = [group("run", title=f"random deck {seed}: {kind}", dimension=plan.dimension, seed=seed + 1,
                   **method.run)]
    texts.append(plan.grid())
    texts.append(group("time", t_end=t_end, max_steps=6 * steps, **method.time))
    if method.keys:
        texts.append(group("method", **method.keys))
    if plan.effects:
        texts.append(group("effects", **plan.effects))
    texts += [group("material", name=f"m{index + 1}", **matter.keys) for index, matter in enumerate(plan.matters)]
    # a flying body may meet a closed boundary
    closed = any(f"type = '{word}'" in text for word in ("slip", "stick", "symmetry", "friction")
                 for text in plan.walls)
    files = {}
    for body in plan.bodies:
        texts += body.regions(dx)
        files.update({f"{body.name}_{name}": content for name, content in body.shape.files.items()})
    texts += [body.text() for body in plan.bodies]
    texts += plan.walls
    texts += [group("output", name="h", kind="history", every=max(1, steps // 40)),
              group("output", name="p", kind="particles", count=6, fields="state", precision="double"),
              group("checkpoint", wall_minutes=0.0)]
    return Scene(seed=seed, kind=kind, dimension=plan.dimension, deck="\n".join(texts) + "\n", files=files, dx=dx,
                 bodies=plan.bodies, matters=plan.matters, effects=plan.effects, method=method,
                 impact=max(plan.impact, plan.frame if closed else 0.0),
                 frame=plan.frame, fall=plan.fall, push=plan.push(), oblique=plan.oblique, full=plan.full,
                 swept=plan.swept * t_end * plan.area, contact=bool(plan.effects.get("contact")), steps=steps,
                 t_end=t_end)
