# SPDX-License-Identifier: BSD-3-Clause
"""The cases that are measured. A new one is one more entry of CASES.

A case is a deck with its size and number of steps for `--size small` and `--size full`. Lengths are in cells: the cell
size is 1 in every template. Elastic blocks fly along a diagonal through 0.1 cells a step or so, so that particles cross
cells; metals strike a wall, so that they are compressed and yield.
"""
import fnmatch
from dataclasses import dataclass, field

from scree.errors import unknown

SIZES = ("small", "full")
# layouts (ranks, threads) that are measured in addition to 1 x 1
LAYOUTS = ((2, 1), (1, 2))
GAP = 8                                                  # cells around a block that flies

HEAD = """&run  dimension='{dimension}'  method='{method}' /
&units  system='{units}' /
&method  {words} /
&grid  lo=0,0,0  hi={upper}  dx=1 /
&time  t_end=1.0e9  max_steps={steps} /
&effects  {effects} /
&material  name='m'  {material} /
&region  name='r'  {shape} /
&body  name='b'  region='r'  material='m'  {body} /
{boundary}
&output  name='h'  kind='history'  every=1000000 /
&checkpoint  at_end=.false. /
&log  progress_seconds=100000 /
"""
QUIET = "artificial_viscosity=.false."
ELASTIC = "density=1000  bulk=1.0e6  shear=5.0e5"        # waves of 41 cells a second
METAL = ("density=2.785  shear=28.6  eos_model='mie_gruneisen'  mg_c0=5.328  mg_s=1.338  mg_gamma=2.0\n"
         "  strength_model='johnson_cook'  jc_a=0.265  jc_b=0.426  jc_n=0.34  jc_c=0.015  jc_m=1.0\n"
         "  t_ref=293  t_melt=775  specific_heat=8.75e-4")
SAND = "density=1500  bulk=3.0e5  shear=1.4e5  strength_model='drucker_prager'  friction_angle=40"
WALLS = "&boundary  face='all'  type='slip' /"
OPEN = "&boundary  face='all'  type='outflow' /"
ROUGH = WALLS + "\n&boundary  face='zlo'  type='stick' /"
AXIS = "&boundary  face='xlo'  type='symmetry' /"


def numbers(*values):
    """Numbers as text for a deck."""
    return ",".join(f"{value:g}" for value in values)


def box(low, high):
    """A region that is a box."""
    return f"shape='box'  lo={numbers(*low)}  hi={numbers(*high)}"


def flying_block(edge):
    """A cube that flies: corner of the grid, region, body."""
    whole = edge + 2 * GAP
    return {"upper": numbers(whole, whole, whole), "shape": box((GAP,) * 3, (GAP + edge,) * 3),
            "body": "ppc=2,2,2  velocity=8,-6,5"}


def flying_plate(edge):
    """A square of nine particles a cell that flies in the plane, or a ring around the axis."""
    whole = edge + 2 * GAP
    return {"upper": numbers(whole, 1, whole), "shape": box((GAP, 0, GAP), (GAP + edge, 1, GAP + edge)),
            "body": "ppc=3,1,3  velocity=0,0,8"}


def flying_line(edge):
    """A bar in one dimension that flies."""
    return {"upper": numbers(edge + 2 * GAP, 1, 1), "shape": box((GAP, 0, 0), (GAP + edge, 1, 1)),
            "body": "ppc=8,1,1  velocity=8,0,0"}


def block_on_wall(edge):
    """A cube that strikes the lower wall at 1 km/s, free to widen along x and y."""
    return {"upper": numbers(edge + 6, edge + 6, edge + 6), "shape": box((3, 3, 0), (3 + edge, 3 + edge, edge)),
            "body": "ppc=2,2,2  velocity=0,0,-1"}


def column(edge):
    """A quarter of a column of sand on a rough floor, twice as high as wide, at the beginning of its collapse."""
    half = edge // 2
    return {"upper": numbers(edge, edge, edge + 4), "shape": box((0, 0, 0), (half, half, edge)), "body": "ppc=2,2,2"}


def fragments(count):
    """Single particles that fly apart, about eight in a tile."""
    whole = 3 * count
    return {"upper": numbers(whole, whole, whole), "shape": "shape='points'  file='points.csv'  point_volume=0.125",
            "body": f"packing='file'  velocity_formula='2*(x/{whole}-0.5)','2*(y/{whole}-0.5)','2*(z/{whole}-0.5)'"}


def fragment_points(count):
    """The file of their positions: one particle in a cube of three cells, displaced from its centre by fractions of a
    sequence with a long period."""
    lines = ["x,y,z"]
    for number in range(count ** 3):
        corner = (number % count, number // count % count, number // count ** 2)
        lines.append(",".join(f"{3 * (low + 0.25 + 0.5 * (number * step % 1.0)):.6f}"
                              for low, step in zip(corner, (0.6180339887, 0.7548776662, 0.5698402910))))
    return {"points.csv": "\n".join(lines) + "\n"}


@dataclass(frozen=True)
class Case:
    """One deck. `small` and `full` are (edge of the body in cells, steps)."""

    name: str
    about: str                                           # description in a few words, for the tables
    geometry: object = None                              # edge -> upper, shape, body; None: a shipped example
    small: tuple = (20, 40)
    full: tuple = (64, 40)
    method: str = "ddmp"
    words: str = ""                                      # keys of &method
    dimension: str = "3d"
    units: str = "si"
    effects: str = QUIET
    material: str = ELASTIC
    boundary: str = OPEN
    body: str = ""                                       # more keys of &body
    example: str = ""                                    # of `scree --new`
    settings: tuple = ()                                 # GROUP.KEY=VALUE on top of an example
    files: object = None                                 # edge -> {name: text} of files that the deck refers to
    layouts: bool = False                                # also run on several ranks and threads

    def deck(self, size):
        """The deck as text; empty for an example."""
        if self.example:
            return ""
        edge, steps = getattr(self, size)
        parts = self.geometry(edge)
        parts["body"] += f"  {self.body}" if self.body else ""
        return HEAD.format(dimension=self.dimension, method=self.method, units=self.units, words=self.words,
                           steps=steps, effects=self.effects, material=self.material, boundary=self.boundary, **parts)

    def companions(self, size):
        """Names and texts of the files that the deck refers to."""
        return self.files(getattr(self, size)[0]) if self.files else {}

    def overrides(self, size):
        """Values for --set that change an example."""
        return (*self.settings, f"time.max_steps={getattr(self, size)[1]}") if self.example else ()


def plane(name, about, **more):
    """A case in the plane or around the axis."""
    return Case(name, about, flying_plate, small=(72, 40), full=(480, 40), **more)


def metal(name, about, **more):
    """A case of a metal in a shock, in mm, us and mg, so velocities are km/s and stresses GPa."""
    return Case(name, about, block_on_wall, units="mm-us-mg", material=METAL, effects="thermal=.true.",
                boundary=WALLS, **more)


IRREGULAR = "packing='jitter'"
CASES = (
    Case("block_ddmp", "elastic block in flight, 8 particles a cell, DDMP", flying_block, layouts=True),
    Case("block_mpm", "elastic block in flight, 8 particles a cell, MPM", flying_block, method="mpm", layouts=True),
    Case("irregular_ddmp", "elastic block, particles moved aside at random, DDMP", flying_block, body=IRREGULAR),
    Case("irregular_mpm", "elastic block, particles moved aside at random, MPM", flying_block, method="mpm",
         body=IRREGULAR),
    Case("block_gimp", "elastic block in flight, GIMP", flying_block, (16, 40), method="mpm", words="basis='gimp'"),
    Case("block_quadratic", "elastic block in flight, quadratic splines", flying_block, (16, 40), method="mpm",
         words="basis='quadratic'"),
    Case("block_cubic", "elastic block in flight, cubic splines", flying_block, (16, 40), method="mpm",
         words="basis='cubic'"),
    Case("block_cpdi", "elastic block in flight, CPDI", flying_block, (12, 40), (48, 40), method="mpm",
         words="basis='cpdi'"),
    metal("metal_ddmp", "metal block on a wall (Johnson-Cook, Mie-Grueneisen), DDMP"),
    metal("metal_ddmp_flip", "metal block on a wall, DDMP with FLIP", words="transfer='flip'"),
    metal("metal_mpm", "metal block on a wall, MPM", method="mpm"),
    Case("column", "column of sand that collapses (Drucker-Prager), DDMP", column, effects=(
        "gravity=.true.  gravity_vector=0,0,-9.81"), material=SAND, boundary=ROUGH, small=(26, 40), full=(96, 40)),
    plane("plane_strain_ddmp", "elastic square in flight, 9 particles a cell, DDMP", dimension="plane_strain"),
    plane("plane_strain_mpm", "elastic square in flight, MPM", dimension="plane_strain", method="mpm"),
    plane("axisymmetric_ddmp", "elastic ring in flight, 9 particles a cell, DDMP", dimension="axisymmetric",
          boundary=f"{OPEN}\n{AXIS}"),
    plane("axisymmetric_mpm", "elastic ring in flight, MPM", dimension="axisymmetric", method="mpm",
          boundary=f"{OPEN}\n{AXIS}"),
    Case("line_ddmp", "elastic bar in flight, one dimension, DDMP", flying_line, dimension="1d", small=(4000, 60),
         full=(200000, 60)),
    Case("debris", "shipped debris cloud, axisymmetric, its first steps, DDMP", example="debris_cloud",
         small=(0, 100), full=(0, 1200), settings=("checkpoint.at_end=.false.",), layouts=True),
    Case("sparse", "single particles in flight, a few in a tile, DDMP", fragments, small=(12, 40), full=(32, 40),
         files=fragment_points),
)


@dataclass(frozen=True)
class Run:
    """A case with a number of ranks and threads."""

    case: Case
    ranks: int = 1
    threads: int = 1
    key: str = field(init=False)                         # name in tables and files

    def __post_init__(self):
        layout = "" if self.cores == 1 else f"_{self.ranks}x{self.threads}"
        object.__setattr__(self, "key", self.case.name + layout)

    @property
    def cores(self):
        """Number of cores that a run uses."""
        return self.ranks * self.threads


def plan(only="", layouts=LAYOUTS):
    """All runs, or those that match one of the patterns. Patterns are separated by commas; each is a part of a name, or
    contains * and ?."""
    runs = [Run(case) for case in CASES]
    runs += [Run(case, ranks, threads) for case in CASES if case.layouts for ranks, threads in layouts
             if ranks * threads > 1]
    patterns = [word.strip() for word in only.split(",") if word.strip()]
    for pattern in patterns:
        if not any(matches(run.key, pattern) for run in runs):
            raise unknown("case", pattern, [run.key for run in runs], "--only")
    return [run for run in runs if not patterns or any(matches(run.key, word) for word in patterns)]


def matches(key, pattern):
    """True if the name of the run contains the pattern, or matches it with * and ?."""
    return fnmatch.fnmatchcase(key, pattern) if set(pattern) & set("*?[") else pattern in key
