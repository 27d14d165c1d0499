# SPDX-License-Identifier: BSD-3-Clause
"""Decks for the page of messages, where the first row of the tables of test/input is not the best example.

DECKS: code: (deck, old text, wrong text, right text). The deck is the name of one in broken_values.py, or a text of its
own; if the right text is None, the old text is the right one. Both decks are run: the wrong one must produce the
message, the right one neither an error nor a warning. FILES: code: files in the folder of both decks.
"""

BAR = """&run dimension = 'plane_strain' /
&grid lo = 0 0 0  hi = 1 0.1 1  dx = 0.1 /
&time t_end = 1e-4 /
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
# Nine balls, each with a velocity field of its own.
NINE = (BAR.replace("dx = 0.1", "dx = 0.05") + "&effects contact = .true. /\n" + METAL + "".join(
    f"&region name = '{k}'  shape = 'box'  lo = 0.{k} 0 0.{k}  hi = 0.{k + 1} 1 0.{k + 1} /\n"
    f"&body name = '{k}'  region = '{k}'  material = 'metal'  field = {k} /\n" for k in range(1, 9)) +
    "&region name = 'last'  shape = 'box'  lo = 0.9 0 0.9  hi = 1 1 1 /\n"
    "&body name = 'last'  region = 'last'  material = 'metal'  field = 9 /\n")
CRACK = BAR + """&effects damage = .true. /
&material name = 'glass'  density = 2500  eos_model = 'linear'  young = 70e9  poisson = 0.2
  damage_model = 'principal_stress'  failure_stress = 2e6  fracture_energy = 8 /
""" + BODY.replace("metal", "glass")
GAS = BAR + """&effects damage = .true.  thermal = .true. /
&material name = 'gas'  density = 100  eos_model = 'ideal_gas'  ig_gamma = 1.4  specific_heat = 700
  shear = 1e9  strength_model = 'elastic'
  damage_model = 'principal_stress'  failure_stress = 2e6  fracture_energy = 8 /
""" + BODY.replace("'metal' /", "'gas'  specific_energy = 1e6 /")
COPPER = BAR + """&effects thermal = .true. /
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
&time t_end = 1e-4 /
&material name = 'metal'  density = 2700  young = 70e9  poisson = 0.3 /
&region name = 'grains'  shape = 'points'  file = 'grains.csv' /
&body name = 'one'  region = 'grains'  material = 'metal'  packing = 'file' /
"""
FINE_GRID = """&run dimension = '3d' /
&grid lo = 0 0 0  hi = 1 1 1  dx = 0.0009765625 /
&time t_end = 1e-6 /
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

SLOPE = BAR + METAL.replace(
    " /", "\n  strength_model = 'mohr_coulomb'  friction_angle = 30  dilation_angle = 10 /") + BODY
MODE = "&exact solution = 'bar_mode'  bar_length = 1  mode_speed = 1"
SECOND = """&region name = 'cube'  shape = 'box'  lo = 0 0 0  hi = 0.2 1 0.2 /
&body name = 'two'  region = 'cube'  material = 'metal' /
"""
VORTEX = (BAR + METAL.replace("0.3 /", "0.3  strength_model = 'neo_hookean' /") + BODY
          + "&exact solution = 'vortex'  frequency = 1 /\n")


def facets(corners, triangles):
    """Text of a file with facets."""
    lines = ["solid stone"]
    for triangle in triangles:
        lines += ["facet normal 0 0 0", "outer loop"]
        lines += ["vertex {} {} {}".format(*corners[k]) for k in triangle]
        lines += ["endloop", "endfacet"]
    return "\n".join([*lines, "endsolid stone", ""])


CORNERS = [(0.2, 0.2, 0.2), (0.8, 0.2, 0.2), (0.2, 0.8, 0.2), (0.2, 0.2, 0.8)]
PYRAMID = [(0, 2, 1), (0, 1, 3), (0, 3, 2), (1, 2, 3)]
DECKS = {
    "D102": ("plain", "'plane_strain' /", "'plane_strain'", None),
    "D104": ("plain", "&time t_end", "time t_end", None),
    "D107": ("plain", "&time", "\x1b[1m&time", None),
    "D108": ("plain", "'plane_strain' /", "'plane_strain' /  ! " + 60 * "a long word ", None),
    "D113": ("plain", "centre", "center", None),
    "D219": ("plain", "&run", "&run deck_version = 9 ", "&run deck_version = 1 "),
    "D114": ("plain", "density = 2700", "density = 2700  density = 7800", None),
    "D115": ("plain", "&time t_end = 1e-4 /", "&time t_end = 1e-4 /\n&time cfl = 0.3 /",
                      "&time t_end = 1e-4  cfl = 0.3 /"),
    "D116": (
        "plain", "&body name = 'one'  region = 'ball'  material = 'metal' /",
        "&region name = 'ball'  shape = 'box'  lo = 0 0 0  hi = 0.2 1 0.2 /\n"
        "&body name = 'one'  region = 'ball'  material = 'metal' /",
        "&region name = 'cube'  shape = 'box'  lo = 0 0 0  hi = 0.2 1 0.2 /\n"
        "&body name = 'one'  region = 'ball'  material = 'metal' /"),
    "D201": ("plain", "dx = 0.1", "dx = 1e", None),
    "D209": ("plain", "'metal' /", "'metal'  velocity = 100 /", "'metal'  velocity = 100 0 0 /"),
    "D210": ("sand", "every = 20", "times = now", "times = 0.1 0.5 1"),
    "D206": ("sand", "every = 20", "every = 2e1", None),
    "D211": ("plain", "'metal' /", "'metal'  packing = '' /", None),
    "D212": ("plain", "'metal' /", "'metal'  velocity = 1,,3 /",
                                      "'metal'  velocity = 1, 0, 3 /"),
    "D213": ("plain", "'metal' /", "'metal'  velocity(0) = 1 /",
                                  "'metal'  velocity(1) = 1 /"),
    "D214": ("plain", "density = 2700", "density = -2700", None),
    "D217": ("plain", "t_end = 1e-4", "t_end = 1e-4  max_steps = 99999999999",
                           "t_end = 1e-4  max_steps = 2000000000"),
    "D218": ("plain", "t_end = 1e-4", "t_end = 1e-320", None),
    "D220": ("plain", "shape = 'sphere'", "shape = 'ball'", None),
    "D222": ("plain", "region = 'ball'", "region = 'bal'", None),
    "D301": ("plain", "radius = 0.2 /", "/", None),
    "D302": ("plain", "young = 70e9  poisson = 0.3", "poisson = 0.3", None),
    "D304": ("plain", "shape = 'sphere'  centre = 0.5 0 0.5  radius = 0.2",
                                  "shape = 'sphere'  centre = 0.5 0 0.5  radius = 0.2  height = 1", None),
    "D305": ("sand", "gravity = .true.", "gravity = .false.", None),
    "D306": ("shock", "thermal = T  damage = T", "thermal = T", None),
    "D307": ("plain", "dx = 0.1", "dx = 0.1  cells = 10 1 10", None),
    "D316": (
        BAR.replace(" /", "  method = 'ddmp' /", 1) + METAL.replace(
            "0.3 /", "0.3\n  strength_model = 'mohr_coulomb'  friction_angle = 30  volume_from = 'grid' /") + BODY,
        "method = 'ddmp'", "method = 'mpm'", None),
    "D317": (
        BAR + METAL.replace("0.3 /", "0.3\n  strength_model = 'drucker_prager'  friction_angle = 30  "
                            "volume_from = 'grid' /") + BODY,
        "friction_angle = 30", "friction_angle = 30  cohesion = 1e3", None),
    "D318": ("plain", "&time t_end = 1e-4 /", "&method heat_flux = 2 /\n&time t_end = 1e-4 /", None),
    "D319": ("sand", "every = 20", "every = 20  dt = 0.1", "dt = 0.1"),
    "D373": (
        "plain", "&time", "&region name = 'ram'  shape = 'halfspace'  centre = 0 0 0.1  normal = 0 0 1 /\n"
        "&boundary region = 'ram'  type = 'slip'  mass = 2 /\n&time",
        "&region name = 'ram'  shape = 'box'  lo = 0.2 0 0  hi = 0.8 1 0.1 /\n"
        "&boundary region = 'ram'  type = 'slip'  mass = 2 /\n&time"),
    "D444": (
        "plain", "&body", "&inflow body = 'one'  velocity = 1 0 1 /\n&body", None),
    "D321": (
        "plain", "&body", "&region name = 'both'  shape = 'union'  of = 'ball' 'both' /\n&body",
        "&region name = 'cube'  shape = 'box'  lo = 0 0 0  hi = 0.2 1 0.2 /\n"
        "&region name = 'both'  shape = 'union'  of = 'ball' 'cube' /\n&body"),
    "D322": (
        "plain", "&time", "&boundary face = 'xlo'  type = 'periodic' /\n&time",
        "&boundary face = 'xlo'  type = 'periodic' /\n&boundary face = 'xhi'  type = 'periodic' /\n&time"),
    "D326": ("plain", "&time", "&boundary type = 'stick' /\n&time",
                                     "&boundary face = 'zlo'  type = 'stick' /\n&time"),
    "D328": (
        "plain", "&time", "&region name = 'wall'  shape = 'box'  lo = 0 0 0  hi = 1 1 0.1 /\n"
        "&boundary region = 'wall'  type = 'symmetry' /\n&time",
        "&region name = 'wall'  shape = 'box'  lo = 0 0 0  hi = 1 1 0.1 /\n"
        "&boundary region = 'wall'  type = 'slip' /\n&time"),
    "D329": (
        "plain", "&time", "&boundary face = 'zlo'  type = 'stick'  velocity = 1 0 0 /\n&time",
        "&boundary face = 'zlo'  type = 'velocity'  velocity = 1 0 0 /\n&time"),
    "D330": (
        "shock", "&output",
        "&boundary face = 'xhi'  region = 'ball'  type = 'stick'  temperature = 300 /\n&output",
        "&boundary face = 'xhi'  type = 'stick'  temperature = 300 /\n&output"),
    "D331": (
        "plain", "&time", "&boundary face = 'zlo'  type = 'stick'  t_on = 5e-6  t_off = 2e-6 /\n&time",
        "&boundary face = 'zlo'  type = 'stick'  t_on = 2e-6  t_off = 5e-6 /\n&time"),
    "D332": ("plain", "'metal' /", "'metal'  velocity = 0 100 0 /",
                                    "'metal'  velocity = 0 0 100 /"),
    "D334": ("plain", "poisson = 0.3", "poisson = 0.5", "poisson = 0.49"),
    "D335": ("plain", "&time", "&include file = 'scene.nml' /\n&time", None),
    "D336": (TOUCHING, "'low' 'high'", "'low' 'low'", "'low' 'high'"),
    "D337": (TOUCHING, "field = 2", "field = 1", None),
    "D338": (
        TOUCHING, "friction = 0.3 /", "friction = 0.3 /\n&contact bodies = 'high' 'low'  law = 'stick' /", None),
    "D339": (NINE, "field = 9", "field = 9", "field = 8"),
    "D340": (
        "plain", "&time", "&effects contact = .true. /\n"
        "&exact solution = 'bar_mode'  bar_length = 1  mode_speed = 1 /\n&time",
        "&exact solution = 'bar_mode'  bar_length = 1  mode_speed = 1 /\n&time"),
    "D346": (
        "plain", "poisson = 0.3 /", "poisson = 0.3  specific_heat = 900  conductivity = 200 /\n"
        "&effects contact = .true.  thermal = .true. /",
        "poisson = 0.3  specific_heat = 900  conductivity = 200 /\n&effects thermal = .true. /"),
    "D404": ("plain", "hi = 1 0.1 1  dx = 0.1", "hi = 1 0.1 1  dx = 0.15",
                     "hi = 1.05 0.1 1.05  dx = 0.15"),
    "D405": ("plain", "dx = 0.1", "dx = 1e-7", None),
    "D409": ("plain", "centre = 0.5 0 0.5", "centre = 5 0 0.5", None),
    "D411": (SOLID, "open.stl", "open.stl", "whole.stl"),
    "D421": (PRISM, "0.9 0.9  0.1 0.9", "0.1 0.9  0.9 0.9", None),
    "D422": (GRAINS, "  packing = 'file'", "", None),
    "D414": (
        GRAINS, "&body", "&boundary region = 'grains'  type = 'stick' /\n&body",
        "&region name = 'wall'  shape = 'box'  lo = 0 0 0  hi = 1 1 0.125 /\n"
        "&boundary region = 'wall'  type = 'stick' /\n&body"),
    "D415": (FLAT_GRAINS, "rotate = 0 30 0", "rotate = 0 0 30", None),
    "D416": (FLAT_GRAINS.replace("plane_strain", "axisymmetric"), "  rotate = 0 30 0",
                               "  rotate = 0 30 0", ""),
    "D311": (
        "plain", "'plane_strain' /", "'plane_strain' /\n&method basis = 'gimp' /",
        "'plane_strain'  method = 'mpm' /\n&method basis = 'gimp' /"),
    "D341": (VORTEX, "  strength_model = 'neo_hookean'", "", None),
    "D342": ("plain", "'metal' /", f"'metal'  velocity = 0 0 1 /\n{MODE} /", f"'metal' /\n{MODE} /"),
    "D343": (
        "plain", "'metal' /", f"'metal' /\n{MODE}  flight_speed = 2 /", f"'metal' /\n{MODE} /"),
    "D344": (
        "plain", "'metal' /", f"'metal' /\n{SECOND}{MODE}  bodies = 'one' /",
        f"'metal' /\n{SECOND}{MODE}  bodies = 'one' 'two' /"),
    "D423": (
        SOIL, "initial_stress = 'lithostatic'", "initial_stress = 'lithostatic'", "initial_stress = 'zero'"),
    "D430": ("shock", "dt = 1 /", "dt = 1e-6 /", None),
    "D431": (FINE_GRID, "  region = 'near'", "", None),
    "D437": ("sand", "every = 20", "dt = 1e-12", "dt = 1e-3"),
    "D432": (
        "shock", "kind = 'particles'", "kind = 'slice'  axis = 'z'  at = 11", "kind = 'slice'  axis = 'z'  at = 1"),
    "D433": (
        "sand", "kind = 'history'", "kind = 'profile'  axis = 'y'", "kind = 'profile'  axis = 'z'"),
    "D436": (
        "shock", "kind = 'particles'", "kind = 'grid'  fields = 'body' 'velocity'",
        "kind = 'grid'  fields = 'velocity'"),
    "D221": (
        "shock", "kind = 'particles'", "kind = 'particles'  fields = 'velocty'",
        "kind = 'particles'  fields = 'velocity'"),
    "D438": ("plain", "&time", "&checkpoint dt = 1e-12 /\n&time", "&checkpoint dt = 1e-6 /\n&time"),
    "D440": (CRACK, "fracture_energy = 8", "fracture_energy = 0.8", None),
    "D441": (CRACK, "fracture_energy = 8", "fracture_energy = 8  failure_delay = 1e-3",
                                          None),
    "D442": (CRACK, "fracture_energy = 8", "failure_delay_power = 2",
                                                "failure_delay = 1e-6  failure_delay_power = 2"),
    "D443": (GAS, "  fracture_energy = 8", "  fracture_energy = 8", ""),
    "D501": ("plain", "density = 2700", "density = 2.7", None),
    "D502": ("shock", "density = 2.79", "density = 2790", None),
    "D503": ("plain", "young = 70e9", "young = 70", None),
    "D504": ("shock", "mg_c0 = 5.35", "mg_c0 = 5350", None),
    "D505": (COPPER, "scg_gp = 2.83e-11", "scg_gp = 2.83", None),
    "D507": ("shock", "velocity = 0 0 6.7", "velocity = 0 0 6.7  temperature = 20",
                                     "velocity = 0 0 6.7  temperature = 293"),
    "D508": (BAR + METAL.replace(" /", "  strength_model = 'von_mises'  yield = 265e6 /") + BODY,
             "yield = 265e6", "yield = 265", None),
    "D509": ("plain", "'metal' /", "'metal'  velocity = 900000 0 0 /", "'metal'  velocity = 900 0 0 /"),
    "D510": ("plain", "t_end = 1e-4", "t_end = 1e-9", None),
    "D511": ("plain", "t_end = 1e-4", "t_end = 1e300", None),
    "D512": ("plain", "&time", "&effects gravity = .true.  gravity_vector = 0 0 -9810 /\n&time",
             "&effects gravity = .true.  gravity_vector = 0 0 -9.81 /\n&time"),
    "D105": ("plain", "t_end = 1e-4", "t_end 1e-4", None),
    "D225": ("plain", "&run", "&run case = '" + 12 * "long_name_" + "' ", "&run case = 'name' "),
    "D349": ("plain", "young = 70e9  poisson = 0.3", "bulk = 58e9  elastic = 'none'  shear = 26e9",
             "bulk = 58e9  elastic = 'none'"),
    "D352": ("plain", "'metal' /", f"'metal' /\n{MODE} /\n&method split = .true. /", f"'metal' /\n{MODE} /"),
    "D353": ("plain", "'metal' /", "'metal'  initial_stress = 'lithostatic' /", None),
    "D355": ("plain", "&time", "&method transfer = 'aflip'  stress_update = 'usavg' /\n&time",
             "&method transfer = 'rflip'  stress_update = 'usavg' /\n&time"),
    "D356": ("plain", "'metal' /", "'metal'  packing = 'file' /", None),
    "D357": (PRISM, "0.1 0.9 /", "0.1 /", None),
    "D363": (SLOPE, "dilation_angle = 10", "dilation_angle = 40", None),
    "D364": (CRACK, "fracture_energy = 8", "softening = 'exponential'",
             "fracture_energy = 10  softening = 'exponential'"),
    "D366": ("sand", "kind = 'history'", "kind = 'history'  fields = 'velocity_error'", None),
    "D446": (SOLID, "open.stl", "turned.stl", "whole.stl"),
}

STONES = {"whole.stl": facets(CORNERS, PYRAMID), "open.stl": facets(CORNERS, PYRAMID[:1] + PYRAMID[2:]),
          "turned.stl": facets(CORNERS, [PYRAMID[0][::-1], *PYRAMID[1:]])}
FILES = {
    "D411": STONES,
    "D446": STONES,
    "D422": {"grains.csv": THREE},
    "D414": {"grains.csv": THREE},
    "D415": {"grains.csv": FLAT},
    "D416": {"grains.csv": FLAT},
}
