# SPDX-License-Identifier: BSD-3-Clause
"""Errors of gauges, forces, loads and inflows that a single change of a deck of broken_values makes; rows as there."""

GAUGE = "&output name = 'g' kind = 'gauge' every = 1 "
LOAD = "&load name = 'l' "
FLOW = "&inflow body = 'one' "

INSTRUMENTS = [
    ("plain", "&time", f"{GAUGE} /\n&time", 3,
     "&output 'g': a gauge needs a point = x, y, z; or use gauge = 'mean' for means over bodies and region"),
    ("plain", "&time", f"{GAUGE} point = 2 0 0 /\n&time", 3,
     "&output 'g': the point lies outside of the grid, whose corners are"),
    ("plain", "&time", f"{GAUGE} gauge = 'surface' point = 0.5 0 0.5 /\n&time", 3,
     "&output 'g': a gauge of a surface needs the side from which the beam comes, such as side = '+x'"),
    ("plain", "&time", f"{GAUGE} gauge = 'surface' point = 0.5 0 0.5 side = '+y' /\n&time", 3,
     "&output 'g': side = '+y' is along a direction that the scene does not have; use another one"),
    ("plain", "&time", f"{GAUGE} point = 0.5 0 0.5 side = '+x' /\n&time", 3,
     "&output 'g': side given but gauge = 'point' does not use it"),
    ("plain", "&time", f"{GAUGE} point = 0.5 0 0.5 fields = 'identity' /\n&time", 3,
     "&output 'g': output field 'identity' is an identifier, which has no mean; remove it"),
    ("plain", "&time", "&output name = 'f' kind = 'forces' every = 1 /\n&time", 3,
     "&output 'f': there is no wall whose force could be shown; add a &boundary, give contacts, or remove this output"),
    ("plain", "&time", "&output name = 'f' kind = 'forces' every = 1 contacts = 'one', 'one' /\n&time", 3,
     "&output 'f': contacts needs &effects contact = .true.; without it all bodies share one velocity field"),
    ("plain", "&time", "&effects contact = T /\n&output name = 'f' kind = 'forces' every = 1 contacts = 'one' /\n&time",
     4, "&output 'f': contacts has one body; name two or more"),
    ("plain", "&time", "&effects contact = T /\n&output name = 'f' kind = 'forces' every = 1 contacts = 'one' 'on' /\n"
     "&time", 4, "&output 'f': no body 'on'; defined: one; did you mean 'one'?"),
    ("charge", "&body name = 'charge'  region = 'low'  material = 'high' /\n&body", "&effects contact = T /\n"
     "&output name = 'f' kind = 'forces' every = 1 contacts = 'charge' 'plate' /\n"
     "&body name = 'charge'  region = 'low'  material = 'high'  field = 1 /\n&body field = 1", 10,
     "&output 'f': 'charge' and 'plate' share a velocity field, so no contact force acts between them; give them "
     "different values of field in &body"),
    ("plain", "&time", "&output name = 'h' kind = 'history' every = 1 bodies = 'one' fields = 'viscous' /\n&time", 3,
     "&output 'h': output field 'viscous' is known for all material only, not for bodies or a region; there are: "
     "default time step dt mass momentum_x"),
    ("plain", "&time", "&output name = 'h' kind = 'history' every = 1 bodies = 'one' fields = 'noise' /\n&time", 3,
     "&output 'h': output field 'noise' is known for all material only"),
    ("sand", "&output", "&output name = 'f' kind = 'forces' every = 1 walls = 'zl' /\n&output", 10,
     "&output 'f': 'zl' is not a wall; there are: xlo zlo; did you mean 'zlo'?"),
    ("plain", "&time", f"{LOAD} /\n&time", 3,
     "&load 'l': give a pressure, or a traction and the normal of the surface"),
    ("plain", "&time", f"{LOAD} traction = 1 0 0 /\n&time", 3,
     "&load 'l': a traction needs the direction of the surface, such as normal = 0, 0, 1"),
    ("plain", "&time", f"{LOAD} pressure = 1 times = 0 1 factors = 1 /\n&time", 3,
     "&load 'l': times and factors must have the same length"),
    ("plain", "&time", f"{LOAD} pressure = 1 times = 1 0 factors = 1 0 /\n&time", 3,
     "&load 'l': times must ascend"),
    ("plain", "&time", f"{LOAD} pressure = 1 region = 'bal' /\n&time", 3,
     "&load 'l': no region 'bal'; defined: ball; did you mean 'ball'?"),
    ("plain", "&time", f"{LOAD} pressure = 1 bodies = 'on' /\n&time", 3,
     "&load 'l': no body 'on'; defined: one; did you mean 'one'?"),
    ("plain", "&time", "&inflow velocity = 1 0 0 /\n&time", 3, "&inflow: body must be given"),
    ("plain", "&time", f"{FLOW} velocity = 1 0 1 /\n&time", 3,
     "&inflow: the flow must be along x, y or z, such as velocity = 0, 0, -10; rotate the scene accordingly"),
    ("plain", "&time", f"{FLOW} velocity = 0 0 0 /\n&time", 3,
     "&inflow: the flow must have a speed and must not reverse at any time"),
    ("plain", "&time", f"{FLOW} velocity = 1 0 0 mass_rate = -1 /\n&time", 3, "mass_rate = -1  <- must be > 0"),
    ("plain", "&time", f"{FLOW} velocity = 1 0 0 /\n{FLOW} velocity = 1 0 0 /\n&time", 4,
     "&inflow: 'one' has another &inflow; give each its own body"),
    ("plain", "&time", f"{FLOW} velocity = 1 0 0 /\n&time", 3,
     "&inflow: the cross-section of 'one' changes along the flow"),
    ("plain", "&time", "&effects damping = -1 /\n&time", 3, "&effects: damping = -1  <- must be >= 0"),
]
