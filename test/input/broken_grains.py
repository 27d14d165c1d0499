# SPDX-License-Identifier: BSD-3-Clause
"""Decks of cells of grains without an error, and errors that a single change makes.

A row: deck, old text, new text, line of the message (0: none), the message after "error: ".
"""

DECKS = {
    "discs": """&grains number = 100  diameter = 1e-3  density = 2500
  stiffness = 1e6 /
&cell volume_fraction = 0.4 /
&stage name = 'press'  servo = 'isotropic'  pressure = 1e3  duration = 1e-3 /
&stage name = 'shear'  rate = 0 0 0 1 0 0  strain = 1e-3 /
""",
    "lattice": """&grains shape = 'spheres'  diameter = 1e-3  density = 2500
  law = 'hertz'  young = 1e9 /
&cell packing = 'fcc'  cells = 3 3 3  overlap = 1e-3  pressure = 1e3 /
&stage inertial_number = 0.01  strain = 1e-4 /
""",
}

FAULTS = [
    ("lattice", "'fcc'", "'triangular'", 3,
     "&cell: a triangular lattice is of discs; use packing = 'fcc' for spheres"),
    ("discs", "volume_fraction = 0.4", "packing = 'fcc'  cells = 3 3 3", 3,
     "&cell: an fcc lattice is of spheres; use packing = 'triangular' for discs"),
    ("discs", "  stiffness = 1e6", "  law = 'hertz'  young = 1e9", 2,
     "&grains: the law of Hertz is for spheres; for discs use law = 'linear'"),
    ("discs", "0.4", "0.8", 3,
     "&cell: grains placed at random without overlap reach 0.490874; begin there and compress in a first &stage"
     " with servo = 'isotropic'"),
    ("discs", "number = 100", "number = 15", 1,
     "&grains: a periodic cell needs four grains or more along each edge"),
    ("discs", DECKS["discs"][DECKS["discs"].index("&stage"):], "", 1,
     "&grains: there is no &stage: give at least one, such as servo = 'isotropic'   duration = 1.0"),
    ("discs", "  duration = 1e-3", "", 4, "the stage has no end: give strain or duration"),
    ("discs", "rate = 0 0 0 1 0 0  strain", "strain", 5,
     "strain needs a rate or an inertial_number; without them give duration"),
    ("lattice", "inertial_number = 0.01", "inertial_number = 0.01  rate = 0 0 0 1 0 0", 4,
     "rate and inertial_number are both given; keep one"),
    ("lattice", "  pressure = 1e3", "", 4, "servo and inertial_number need a pressure, here or in &cell"),
    ("discs", "  pressure = 1e3", "", 4, "servo and inertial_number need a pressure, here or in &cell"),
    ("discs", "'isotropic'", "'xyz'", 4, "discs have no direction z: use 'isotropic', 'x', 'y' or 'xy'"),
    ("discs", "'isotropic'", "'yx'", 4, "servo = 'yx' is none of: none isotropic x y z xy xz yz xyz"),
    ("discs", "stiffness = 1e6", "restitution = 0.5", 1, "stiffness must be given"),
    ("lattice", "young = 1e9", "poisson = 0.2", 1, "young must be given"),
    ("lattice", "cells = 3 3 3  ", "", 3, "cells must be given"),
    ("discs", "number = 100  ", "", 1, "number must be given"),
    ("discs", "density = 2500", "density = -2500", 1, "density = -2500  <- must be > 0"),
    ("discs", "stiffness = 1e6", "stiffness = 1e6  restitution = 0", 2, "restitution = 0  <- must be > 0 and <= 1"),
    ("discs", "stiffness = 1e6", "stiffness = 1e6  young = 1e9", 2, "young given but"),
    ("lattice", "cells = 3 3 3", "cells = -4 4 4", 3, "cells = -4 4 4  <- must be > 0"),
    ("lattice", "cells = 3 3 3", "cells = 1000 1000 1000", 3,
     "&cell: the lattice has 4.0e9 grains; the greatest number is 1.0e8: write fewer cells"),
    ("discs", "duration = 1e-3", "duration = 1e300", 4, "the stage would take"),
    ("discs", "rate = 0 0 0 1 0 0", "rate = 0 0 0 1e30 0 0", 5, "the cell would be strained by"),
    ("discs", "density = 2500", "density = 1e-300", 1,
     "diameter, density and stiffness give a time step that is not a positive number"),
]
