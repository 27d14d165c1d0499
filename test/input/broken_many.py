# SPDX-License-Identifier: BSD-3-Clause
"""Decks with errors of all stages at once: in the syntax, in values, in keys that contradict each other, in materials
against the cell size, and in positions. Each deck comes with all lines that must be reported. No other line may be
reported, because an error that only follows from another one misleads the reader.
"""

ONE = """&run dimension = 'plane_strain' /
&grid lo = 0 0 0  hi = 1 0.1 1  dx = 0.1 /
&time t_end = 1e-4  t_ende = 3 /
&effects damage = .true. /
&material name = 'metal' density = 2700 kg
  young = 70e9  poisson = 0.3 /
&material name = 'glass' density = 2500  young = 70e9  poisson = 0.2  damage_model = 'principal_stress'
  failure_stress = 5e8  fracture_energy = 1 /
&material name = 'stone' density = 2500  young = 70e9 /
&material name = 'clay'  density = 2000  bulk = 1e9  shear = 1e8  damage_model = 'principal_stress'
  failure_stress = 1e6  fracture_energy = 1e3  failure_delay = 1e-3 /
&material name = 'slate' density = 2700  bulk = 1e9  shear = 1e8  damage_model = 'principal_stress'
  failure_stress = 1e6  failure_delay_power = 2 /
&region name = 'ball'  shape = 'sphere'  centre = 0.5 0 0.5  radius = 0.2 /
&region name = 'far'   shape = 'sphere'  centre = 5 0 5  radius = 0.2 /
&body name = 'one'    region = 'ball'  material = 'metal' /
&body name = 'two'    region = 'far'   material = 'glass' /
&output name = 'h'  kind = 'history' /
"""

TWO = """&run dimension = 'plane_strain' /
&grid lo = 0 0 0  hi = 1 0.1 1  dx = 0.1  dxx = 0.1 /
&time t_end = -1 /
&material name = 'metal' density = 2700 young = 70e9 /
&material name = 'ice' density = 900 young = 9e9 poisson = 0.3 spall = -1 /
&region name = 'ball'  shape = 'sphere'  centre = 0.5 0 0.5  radius = 0.2 /
&region name = 'self'  shape = 'union'  of = 'self','ball' /
&body name = 'one'    region = 'ball'  material = 'mettal' /
&body name = 'two'    region = 'bal'  material = 'ice' velocity = 0 1 0 /
&boundary face = 'xlo' type = 'periodic' /
"""

DECKS = [
    (ONE, [
        "3: error: &time: unknown key 't_ende'; did you mean 't_end'?",
        "5: error: &material: density = 2700 kg  <- expects kg/m3 or a unit of the same kind such as g/cm3, not 'kg'",
        "8: error: &material 'glass': cells of 0.1 m are too large for this fracture_energy: a cell "
         "that cracks would snap back; dx must be at most 3.29983e-7 m",
        "9: error: &material 'stone': poisson must be set (above -1, below 0.5), as young is "
     "given",
        "10: error: &material 'clay': fracture_energy and failure_delay are both given; keep one: "
         "the strength decreases with the crack opening or with time",
        "12: error: &material 'slate': failure_delay_power needs failure_delay [s], the time to "
     "failure at twice the strength; without it failure is immediate",
        "17: error: &body 'two': lies outside of the grid; move its region or widen &grid",
        "18: error: &output 'h': give one of dt, every, times, count",
    ]),
    (TWO, [
        "2: error: &grid: unknown key 'dxx'; did you mean 'dx'?",
        "3: error: &time: t_end = -1  <- must be > 0 s",
        "4: error: &material 'metal': poisson must be set (above -1, below 0.5), as young is "
     "given",
        "5: error: &material: spall = -1  <- must be > 0 Pa",
        "7: error: &region 'self': 'self' contains this region",
        "8: error: &body 'one': no material 'mettal'; defined: metal, ice; did you mean 'metal'?",
        "9: error: &body 'two': no region 'bal'; defined: ball, self; did you mean 'ball'?",
        "9: error: &body 'two': velocity must be 0 in y, as dimension = 'plane_strain'",
        "10: error: &boundary: periodic needs both faces; make xhi periodic too",
    ]),
]
