# SPDX-License-Identifier: BSD-3-Clause
"""Decks for the pages of messages, where the first row of the tables of test/input is not the best example.

DECKS: name of the page: (deck, old text, wrong text, right text). The deck is one of broken_values.py by its name, or
a text of its own; a right text of None is the old one. Both are run: the wrong one must bring the message, the right
one neither error nor warning. FILES: name of the page: files beside both decks.
"""

BAR = """&run dimension = 'plane_strain' /
&grid lo = 0 0 0  hi = 1 0.1 1  dx = 0.1 /
&time t_end = 1e-5 /
"""
BODY = """&region name = 'ball'  shape = 'sphere'  centre = 0.5 0 0.5  radius = 0.2 /
&body name = 'one'  region = 'ball'  material = 'metal' /
"""
METAL = """&material name = 'metal'  density = 2700  young = 70e9  poisson = 0.3 /
"""
# Two blocks that touch, each with a velocity field of its own.
CONTACT = BAR + "&effects contact = .true. /\n" + METAL
TOUCHING = CONTACT + """&region name = 'low'   shape = 'box'  lo = 0 0 0    hi = 1 1 0.4 /
&region name = 'high'  shape = 'box'  lo = 0 0 0.4  hi = 1 1 0.8 /
&body name = 'low'   region = 'low'   material = 'metal'  field = 1 /
&body name = 'high'  region = 'high'  material = 'metal'  field = 2 /
&contact bodies = 'low' 'high'  friction = 0.3 /
"""
# Nine balls, each with a field of its own.
NINE = (BAR.replace("dx = 0.1", "dx = 0.05") + "&effects contact = .true. /\n" + METAL + "".join(
    f"&region name = '{k}'  shape = 'box'  lo = 0.{k} 0 0.{k}  hi = 0.{k + 1} 1 0.{k + 1} /\n"
    f"&body name = '{k}'  region = '{k}'  material = 'metal'  field = {k} /\n" for k in range(1, 9)) +
    "&region name = 'last'  shape = 'box'  lo = 0.9 0 0.9  hi = 1 1 1 /\n"
    "&body name = 'last'  region = 'last'  material = 'metal'  field = 9 /\n")
CRACK = BAR.replace("1e-5", "1e-6") + """&effects damage = .true. /
&material name = 'glass'  density = 2500  eos_model = 'linear'  young = 70e9  poisson = 0.2
  damage_model = 'principal_stress'  failure_stress = 2e6  fracture_energy = 8 /
""" + BODY.replace("metal", "glass")
GAS = BAR.replace("1e-5", "1e-6") + """&effects damage = .true.  thermal = .true. /
&material name = 'gas'  density = 100  eos_model = 'ideal_gas'  ig_gamma = 1.4  specific_heat = 700
  shear = 1e9  strength_model = 'elastic'
  damage_model = 'principal_stress'  failure_stress = 2e6  fracture_energy = 8 /
""" + BODY.replace("'metal' /", "'gas'  specific_energy = 1e6 /")
COPPER = BAR.replace("1e-5", "1e-6") + """&effects thermal = .true. /
&material name = 'cu'  density = 8930  eos_model = 'mie_gruneisen'  mg_c0 = 3940  mg_s = 1.489  mg_gamma = 2.02
  shear = 47.7e9  strength_model = 'steinberg_guinan'  scg_y0 = 0.12e9  scg_ymax = 0.64e9  scg_beta = 36
  scg_n = 0.45  scg_gp = 2.83e-11  scg_gt = 3.77e-4  scg_tm = 1790  scg_a = 1.5  scg_gamma = 2.02
  t_ref = 300  specific_heat = 383 /
""" + BODY.replace("metal", "cu")
PRISM = BAR + METAL + """&region name = 'tile'  shape = 'prism'  polygon = 0.1 0.1  0.9 0.1  0.9 0.9  0.1 0.9 /
&body name = 'one'  region = 'tile'  material = 'metal' /
"""
CUBE = BAR.replace("plane_strain", "3d").replace("1 0.1 1", "1 1 1")
SOLID = CUBE + METAL + """&region name = 'stone'  shape = 'stl'  file = 'open.stl' /
&body name = 'one'  region = 'stone'  material = 'metal' /
"""
SOIL = """&run dimension = 'plane_strain' /
&grid lo = 0 0 0  hi = 2 2 10  dx = 0.5 /
&time t_end = 0.01 /
&effects gravity = .true.  gravity_vector = 0 0 -10  eos = .false. /
&boundary face = 'all'  type = 'slip' /
&material name = 'soil'  density = 2000  young = 2e7  poisson = 0.3  strength_model = 'neo_hookean' /
&region name = 'low'  shape = 'box'  lo = 0 0 0  hi = 2 2 4 /
&body name = 'low'  region = 'low'  material = 'soil'  initial_stress = 'lithostatic' /
"""
GRAINS = """&run dimension = '3d' /
&grid lo = 0 0 0  hi = 1 1 1  dx = 0.125 /
&time t_end = 1e-5 /
&material name = 'metal'  density = 2700  young = 70e9  poisson = 0.3 /
&region name = 'grains'  shape = 'points'  file = 'grains.csv' /
&body name = 'one'  region = 'grains'  material = 'metal'  packing = 'file' /
"""
FINE_GRID = """&run dimension = '3d' /
&grid lo = 0 0 0  hi = 1 1 1  dx = 0.0009765625 /
&time t_end = 1e-9 /
&material name = 'metal'  density = 2700  young = 70e9  poisson = 0.3 /
&region name = 'ball'  shape = 'sphere'  centre = 0.5 0.5 0.5  radius = 0.005 /
&region name = 'near'  shape = 'box'  lo = 0.4 0.4 0.4  hi = 0.6 0.6 0.6 /
&body name = 'one'  region = 'ball'  material = 'metal' /
&output name = 'map'  kind = 'grid'  count = 1  region = 'near' /
"""
FLAT = "x,y,z,volume\n0.2,0,0.2,1e-3\n0.2,0,0.7,1e-3\n0.5,0,0.4,1e-3\n"
FLAT_GRAINS = GRAINS.replace("3d", "plane_strain").replace(
    "'grains.csv' /", "'grains.csv'  rotate = 0 30 0 /")
THREE = "x,y,z,volume\n0.2,0.2,0.2,1e-3\n0.5,0.5,0.5,1e-3\n0.7,0.7,0.7,1e-3\n"

MODE = "&exact solution = 'bar_mode'  bar_length = 1  mode_speed = 1"
SECOND = """&region name = 'cube'  shape = 'box'  lo = 0 0 0  hi = 0.2 1 0.2 /
&body name = 'two'  region = 'cube'  material = 'metal' /
"""
VORTEX = (BAR + METAL.replace("0.3 /", "0.3  strength_model = 'neo_hookean' /") + BODY
          + "&exact solution = 'vortex'  frequency = 1 /\n")


def facets(corners, triangles):
    """A text file of facets."""
    lines = ["solid stone"]
    for triangle in triangles:
        lines += ["facet normal 0 0 0", "outer loop"]
        lines += ["vertex {} {} {}".format(*corners[k]) for k in triangle]
        lines += ["endloop", "endfacet"]
    return "\n".join([*lines, "endsolid stone", ""])


CORNERS = [(0.2, 0.2, 0.2), (0.8, 0.2, 0.2), (0.2, 0.8, 0.2), (0.2, 0.2, 0.8)]
PYRAMID = [(0, 2, 1), (0, 1, 3), (0, 3, 2), (1, 2, 3)]
DECKS = {
    "is-not-closed": ("plain", "'plane_strain' /", "'plane_strain'", None),
    "text-outside-a-group": ("plain", "&time t_end", "time t_end", None),
    "character-is-not-allowed": ("plain", "&time", "\x1b[1m&time", None),
    "the-line-is-too-long": ("plain", "'plane_strain' /", "'plane_strain' /  ! " + 60 * "a long word ", None),
    "unknown-key": ("plain", "centre", "center", None),
    "this-is-an-older-scree": ("plain", "&run", "&run deck_version = 9 ", "&run deck_version = 1 "),
    "is-given-twice": ("plain", "density = 2700", "density = 2700  density = 7800", None),
    "appears-twice": ("plain", "&time t_end = 1e-5 /", "&time t_end = 1e-5 /\n&time cfl = 0.3 /",
                      "&time t_end = 1e-5  cfl = 0.3 /"),
    "the-name-is-taken": (
        "plain", "&body name = 'one'  region = 'ball'  material = 'metal' /",
        "&region name = 'ball'  shape = 'box'  lo = 0 0 0  hi = 0.2 1 0.2 /\n"
        "&body name = 'one'  region = 'ball'  material = 'metal' /",
        "&region name = 'cube'  shape = 'box'  lo = 0 0 0  hi = 0.2 1 0.2 /\n"
        "&body name = 'one'  region = 'ball'  material = 'metal' /"),
    "expects-a-number": ("plain", "dx = 0.1", "dx = 1e", None),
    "expects-some-numbers": ("plain", "'metal' /", "'metal'  velocity = 100 /", "'metal'  velocity = 100 0 0 /"),
    "expects-up-to-some-numbers": ("sand", "every = 20", "times = now", "times = 0.1 0.5 1"),
    "expects-an-integer": ("sand", "every = 20", "every = 2e1", None),
    "expects-a-text-that-is-not-empty": ("plain", "'metal' /", "'metal'  packing = '' /", None),
    "misses-a-value-before-a-comma": ("plain", "'metal' /", "'metal'  velocity = 1,,3 /",
                                      "'metal'  velocity = 1, 0, 3 /"),
    "the-subscript-must-be-from-1": ("plain", "'metal' /", "'metal'  velocity(0) = 1 /",
                                  "'metal'  velocity(1) = 1 /"),
    "must-be-in-range": ("plain", "density = 2700", "density = -2700", None),
    "must-not-be-beyond": ("plain", "t_end = 1e-5", "t_end = 1e-5  max_steps = 99999999999",
                           "t_end = 1e-5  max_steps = 2000000000"),
    "is-too-large-or-too-small": ("plain", "t_end = 1e-5", "t_end = 1e-320", None),
    "is-none-of": ("plain", "shape = 'sphere'", "shape = 'ball'", None),
    "no-such-name": ("plain", "region = 'ball'", "region = 'bal'", None),
    "must-be-given": ("plain", "radius = 0.2 /", "/", None),
    "must-be-set": ("plain", "young = 70e9  poisson = 0.3", "poisson = 0.3", None),
    "given-but-does-not-use-it": ("plain", "shape = 'sphere'  centre = 0.5 0 0.5  radius = 0.2",
                                  "shape = 'sphere'  centre = 0.5 0 0.5  radius = 0.2  height = 1", None),
    "given-but-effect-is-off": ("sand", "gravity = .true.", "gravity = .false.", None),
    "needs-effects": ("shock", "thermal = T  damage = T", "thermal = T", None),
    "are-both-given-keep-one": ("plain", "dx = 0.1", "dx = 0.1  cells = 10 1 10", None),
    "volume-from-grid-needs": (
        BAR.replace(" /", "  method = 'ddmp' /", 1) + METAL.replace(
            "0.3 /", "0.3\n  strength_model = 'mohr_coulomb'  friction_angle = 30  volume_from = 'grid' /") + BODY,
        "method = 'ddmp'", "method = 'mpm'", None),
    "volume-from-grid-is-for-grains": (
        BAR + METAL.replace("0.3 /", "0.3\n  strength_model = 'drucker_prager'  friction_angle = 30  "
                            "volume_from = 'grid' /") + BODY,
        "friction_angle = 30", "friction_angle = 30  cohesion = 1e3", None),
    "remove-heat-flux": ("plain", "&time t_end = 1e-5 /", "&method heat_flux = 2 /\n&time t_end = 1e-5 /", None),
    "give-one-of-dt-every-times-count": ("sand", "every = 20", "every = 20  dt = 0.1", "dt = 0.1"),
    "the-flow-must-be-along-x-y": (
        "plain", "&body", "&inflow body = 'one'  velocity = 1 0 1 /\n&body", None),
    "is-made-of-this-region-itself": (
        "plain", "&body", "&region name = 'both'  shape = 'union'  of = 'ball' 'both' /\n&body",
        "&region name = 'cube'  shape = 'box'  lo = 0 0 0  hi = 0.2 1 0.2 /\n"
        "&region name = 'both'  shape = 'union'  of = 'ball' 'cube' /\n&body"),
    "periodic-needs-both-faces": (
        "plain", "&time", "&boundary face = 'xlo'  type = 'periodic' /\n&time",
        "&boundary face = 'xlo'  type = 'periodic' /\n&boundary face = 'xhi'  type = 'periodic' /\n&time"),
    "face-or-region-must-be-given": ("plain", "&time", "&boundary type = 'stick' /\n&time",
                                     "&boundary face = 'zlo'  type = 'stick' /\n&time"),
    "a-region-cannot-be-type": (
        "plain", "&time", "&region name = 'wall'  shape = 'box'  lo = 0 0 0  hi = 1 1 0.1 /\n"
        "&boundary region = 'wall'  type = 'symmetry' /\n&time",
        "&region name = 'wall'  shape = 'box'  lo = 0 0 0  hi = 1 1 0.1 /\n"
        "&boundary region = 'wall'  type = 'slip' /\n&time"),
    "a-face-moves-only-with-type-velocity": (
        "plain", "&time", "&boundary face = 'zlo'  type = 'stick'  velocity = 1 0 0 /\n&time",
        "&boundary face = 'zlo'  type = 'velocity'  velocity = 1 0 0 /\n&time"),
    "temperature-is-that-of-a-whole-face": (
        "shock", "&output",
        "&boundary face = 'xhi'  region = 'ball'  type = 'stick'  temperature = 300 /\n&output",
        "&boundary face = 'xhi'  type = 'stick'  temperature = 300 /\n&output"),
    "t-off-must-be-after-t-on": (
        "plain", "&time", "&boundary face = 'zlo'  type = 'stick'  t_on = 5e-6  t_off = 2e-6 /\n&time",
        "&boundary face = 'zlo'  type = 'stick'  t_on = 2e-6  t_off = 5e-6 /\n&time"),
    "must-be-0-in-this-dimension": ("plain", "'metal' /", "'metal'  velocity = 0 100 0 /",
                                    "'metal'  velocity = 0 0 100 /"),
    "poisson-makes-the-wave-speed-infinite": ("plain", "poisson = 0.3", "poisson = 0.5", "poisson = 0.49"),
    "a-file-cannot-include-itself": ("plain", "&time", "&include file = 'scene.nml' /\n&time", None),
    "contact-of-a-body-with-itself": (TOUCHING, "'low' 'high'", "'low' 'low'", "'low' 'high'"),
    "share-a-velocity-field": (TOUCHING, "field = 2", "field = 1", None),
    "have-a-law-already-in-line": (
        TOUCHING, "friction = 0.3 /", "friction = 0.3 /\n&contact bodies = 'high' 'low'  law = 'stick' /", None),
    "knows-at-most-velocity-fields": (NINE, "field = 9", "field = 9", "field = 8"),
    "does-not-go-with-exact": (
        "plain", "&time", "&effects contact = .true. /\n"
        "&exact solution = 'bar_mode'  bar_length = 1  mode_speed = 1 /\n&time",
        "&exact solution = 'bar_mode'  bar_length = 1  mode_speed = 1 /\n&time"),
    "does-not-go-with-the-conductivity-of": (
        "plain", "poisson = 0.3 /", "poisson = 0.3  specific_heat = 900  conductivity = 200 /\n"
        "&effects contact = .true.  thermal = .true. /",
        "poisson = 0.3  specific_heat = 900  conductivity = 200 /\n&effects thermal = .true. /"),
    "is-not-whole": ("plain", "hi = 1 0.1 1  dx = 0.1", "hi = 1 0.1 1  dx = 0.15",
                     "hi = 1.05 0.1 1.05  dx = 0.15"),
    "is-more-than-a-million-cells": ("plain", "dx = 0.1", "dx = 1e-7", None),
    "lies-outside-of-the-grid": ("plain", "centre = 0.5 0 0.5", "centre = 5 0 0.5", None),
    "open-edges-it-leaks": (SOLID, "open.stl", "open.stl", "whole.stl"),
    "edges-of-the-polygon-cross": (PRISM, "0.9 0.9  0.1 0.9", "0.1 0.9  0.9 0.9", None),
    "its-region-is-a-list-of-points": (GRAINS, "  packing = 'file'", "", None),
    "is-a-list-of-points": (
        GRAINS, "&body", "&boundary region = 'grains'  type = 'stick' /\n&body",
        "&region name = 'wall'  shape = 'box'  lo = 0 0 0  hi = 1 1 0.125 /\n"
        "&boundary region = 'wall'  type = 'stick' /\n&body"),
    "turns-its-points-out": (FLAT_GRAINS, "rotate = 0 30 0", "rotate = 0 0 30", None),
    "which-cannot-be-turned": (FLAT_GRAINS.replace("plane_strain", "axisymmetric"), "  rotate = 0 30 0",
                               "  rotate = 0 30 0", ""),
    "basis-needs": (
        "plain", "'plane_strain' /", "'plane_strain' /\n&method basis = 'gimp' /",
        "'plane_strain'  method = 'mpm' /\n&method basis = 'gimp' /"),
    "of-exact-holds-for": (VORTEX, "  strength_model = 'neo_hookean'", "", None),
    "exact-gives-the": ("plain", "'metal' /", f"'metal'  velocity = 0 0 1 /\n{MODE} /", f"'metal' /\n{MODE} /"),
    "has-a-flight-speed-only-with-ends": (
        "plain", "'metal' /", f"'metal' /\n{MODE}  flight_speed = 2 /", f"'metal' /\n{MODE} /"),
    "is-of-the-material-of-a-body": (
        "plain", "'metal' /", f"'metal' /\n{SECOND}{MODE}  bodies = 'one' /",
        f"'metal' /\n{SECOND}{MODE}  bodies = 'one' 'two' /"),
    "does-not-know-the-hoop-stress": (
        "sand", "'axisymmetric' /", "'axisymmetric' /\n&method quadrature = 'lsd' /",
        "'axisymmetric' /\n&method quadrature = 'point' /"),
    "has-its-stress-from-its-deformation": (
        SOIL, "initial_stress = 'lithostatic'", "initial_stress = 'lithostatic'", "initial_stress = 'zero'"),
    "would-write-in-files": ("shock", "dt = 1 /", "dt = 1e-6 /", None),
    "would-write-cells-at-a-time": (FINE_GRID, "  region = 'near'", "", None),
    "would-write-rows": ("sand", "every = 20", "dt = 1e-12", "dt = 1e-3"),
    "the-plane-lies-outside-of-the-grid": (
        "shock", "kind = 'particles'", "kind = 'slice'  axis = 'z'  at = 11", "kind = 'slice'  axis = 'z'  at = 1"),
    "is-a-direction-that-the-scene-lacks": (
        "sand", "kind = 'history'", "kind = 'profile'  axis = 'y'", "kind = 'profile'  axis = 'z'"),
    "is-a-number-without-a-mean": (
        "shock", "kind = 'particles'", "kind = 'grid'  fields = 'body' 'velocity'",
        "kind = 'grid'  fields = 'velocity'"),
    "output-field-is-unknown": (
        "shock", "kind = 'particles'", "kind = 'particles'  fields = 'velocty'",
        "kind = 'particles'  fields = 'velocity'"),
    "dt-gives-checkpoints": ("plain", "&time", "&checkpoint dt = 1e-12 /\n&time", "&checkpoint dt = 1e-6 /\n&time"),
    "are-too-large-for-this-fracture-energy": (CRACK, "fracture_energy = 8", "fracture_energy = 0.8", None),
    "fracture-energy-and-failure-delay": (CRACK, "fracture_energy = 8", "fracture_energy = 8  failure_delay = 1e-3",
                                          None),
    "failure-delay-power-needs-failure-delay": (CRACK, "fracture_energy = 8", "failure_delay_power = 2",
                                                "failure_delay = 1e-6  failure_delay_power = 2"),
    "fracture-energy-needs-a-bulk-modulus": (GAS, "  fracture_energy = 8", "  fracture_energy = 8", ""),
    "is-lighter-than-polystyrene": ("plain", "density = 2700", "density = 2.7", None),
    "is-heavier-than-osmium": ("shock", "density = 2.79", "density = 2790", None),
    "makes-waves-of-another-speed": ("plain", "young = 70e9", "young = 70", None),
    "is-faster-than-any-wave": ("shock", "mg_c0 = 5.35", "mg_c0 = 5350", None),
    "is-that-of-a-table-per-mbar": (COPPER, "scg_gp = 2.83e-11", "scg_gp = 2.83", None),
    "did-you-mean-degrees-celsius": ("shock", "velocity = 0 0 6.7", "velocity = 0 0 6.7  temperature = 20",
                                     "velocity = 0 0 6.7  temperature = 293"),
    "expects-key-value": ("plain", "t_end = 1e-5", "t_end 1e-5", None),
}

STONES = {"whole.stl": facets(CORNERS, PYRAMID), "open.stl": facets(CORNERS, PYRAMID[:1] + PYRAMID[2:])}
FILES = {
    "open-edges-it-leaks": STONES,
    "its-region-is-a-list-of-points": {"grains.csv": THREE},
    "is-a-list-of-points": {"grains.csv": THREE},
    "turns-its-points-out": {"grains.csv": FLAT},
    "which-cannot-be-turned": {"grains.csv": FLAT},
}
