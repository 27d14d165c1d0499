# SPDX-License-Identifier: BSD-3-Clause
"""Problems with known solutions, the methods to compute them, and the list of runs.

    problem = accuracy_problems.PROBLEMS["waves"]
    deck = problem.deck(way, setting)             # the text of a deck
    error = problem.error(run, setting)           # relative error of a finished case.Case

All decks but that of the Taylor bar are those of the tests in test/support. Errors are relative to
the solution; the quantity of each problem was chosen before any time was measured. The script
accuracy_cost.py makes the runs, accuracy_evaluation.py evaluates and draws them, accuracy_page.py writes the numbers
of the page.
"""
import math
import sys
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT / "test" / "support"))

import numpy as np                                       # noqa: E402

import bodies                                            # noqa: E402
import flows                                             # noqa: E402
import manufactured                                      # noqa: E402
import taylor                                            # noqa: E402

METHODS = {                                  # name: value of `method` of &run, keys of &method
    "ddmp": ("ddmp", ""),
    "ddmp control": ("ddmp", "quadrature='control'"),
    "mpm": ("mpm", ""),
    "gimp": ("mpm", "basis='gimp'"),
    "cpgimp": ("mpm", "basis='cpgimp'"),
    "quadratic": ("mpm", "basis='quadratic'"),
    "cubic": ("mpm", "basis='cubic'"),
    "cpdi": ("mpm", "basis='cpdi'"),
}
# Variants of every method, in the last word of their names: transfer and stress update. The default of `ddmp` is usl
# with materials that are not elastic, that of `mpm` with any basis is musl.
UPDATES = {
    "musl": "transfer='flip' stress_update='musl'",
    "usl": "transfer='rflip' stress_update='usl'",
    "aflip": "transfer='aflip' stress_update='usl'",
    "apic": "transfer='apic' stress_update='usl'",
    "usl-q1": "transfer='rflip' stress_update='usl' bulk_q1=0.5",
    "apic-q1": "transfer='apic' stress_update='usl' bulk_q1=0.5",
}
USUAL = ("musl", "usl", "aflip", "apic")
WAYS = {f"{method} {update}": (first, f"{more} {words}".strip())
        for method, (first, more) in METHODS.items() for update, words in UPDATES.items()}


def method_of(way):
    """The method of a variant."""
    return way.rsplit(" ", 1)[0]


def update_of(way):
    """Transfer and stress update of a variant."""
    return way.rsplit(" ", 1)[1]


@dataclass(frozen=True)
class Setting:
    """Resolution and time step of a run."""

    cells: int                                           # number of cells along a length that the problem defines
    ppc: int                                             # particles along an edge of a cell
    cfl: float                                           # fraction of the stable step


@dataclass(frozen=True)
class Problem:
    """A problem: how its deck is written, what its error is, and what is run."""

    title: str                                           # title of the pictures, names the quantity of the error
    # number of dimensions of the grid: the cost is proportional to h^-(d+1)
    dimensions: int
    write: object                                        # (`method` of &run, keys of &method, setting) -> deck
    measure: object                                      # (run, setting) -> error
    cells: tuple                                         # at least four, none a power of two times another
    ppc: tuple                                           # the first value is the usual one, the others are variations
    cfl: tuple                                           # the same
    beside: int                                          # cells of the variations of ppc and cfl
    updates: tuple = USUAL                               # names in UPDATES: the variants of every method
    without: tuple = ()                                  # methods that the program refuses for this problem

    @property
    def methods(self):
        """The methods that can compute the problem."""
        return tuple(method for method in METHODS if method not in self.without)

    @property
    def ways(self):
        """The variants: the same of every method."""
        return tuple(f"{method} {update}" for update in self.updates for method in self.methods)

    def deck(self, way, setting):
        """The deck for a variant."""
        return self.write(*WAYS[way], setting)

    def error(self, run, setting):
        """Error of a run that has ended without failure."""
        return float(self.measure(run, setting))

    def plan(self):
        """Pairs of variant and setting: every variant on every grid with the usual ppc and cfl, then `usl` of every
        method with other values of one of the two on one grid."""
        usual = [(way, Setting(cells, self.ppc[0], self.cfl[0])) for cells in self.cells for way in self.ways]
        others = [Setting(self.beside, ppc, self.cfl[0]) for ppc in self.ppc[1:]]
        others += [Setting(self.beside, self.ppc[0], cfl) for cfl in self.cfl[1:]]
        return usual + [(f"{method} usl", setting) for setting in others for method in self.methods]


def greatest(run, _):
    """Greatest value in time of the displacement error, a root mean square over the particles, relative to the greatest
    displacement."""
    seen = run.summary["exact"]["greatest_displacement"]
    return run.history["displacement_error"].max() / seen


def waves(dimension, amplitude, end=0.5):
    """Function that writes decks of standing waves over half a period, in which the material swings out and back."""
    def write(method, words, setting):
        deck = manufactured.WAVES.format(
            dimension=dimension, method=method, words=words, spacing=f"{1.0 / setting.cells:.17g}",
            cfl=setting.cfl, poisson=0.0 if dimension == "1d" else 0.3, amplitude=amplitude,
            ppc=manufactured.PPC[dimension].format(setting.ppc), end=end * manufactured.PERIOD,
            every=4)
        return deck
    return write


def vortex(method, words, setting):
    """The ring of the vortex, until its middle circle has turned by one radian, the greatest rotation."""
    return manufactured.VORTEX.format(
        method=method, words=words, spacing=f"{1.0 / setting.cells:.17g}", cfl=setting.cfl,
        twist=1.0, end=0.5, least=f"{0.008 * setting.cfl / setting.cells:.17g}",
        ppc=manufactured.PPC["plane_strain"].format(setting.ppc), body="packing='cut'")


def timed(deck, setting):
    """The deck with a given fraction of the stable time step."""
    return deck.replace("t_end", f"cfl={setting.cfl}  t_end", 1)


def flight(method, words, setting):
    """The bar that vibrates while it flies; cells in its length of 25 m. It begins at a cell face near x = 2 m. The
    solution is that of small strain: with a strain of 5e-5 its own error is about 1e-5 of the amplitude."""
    spacing = 25.0 / setting.cells
    start = round(2.0 / spacing) * spacing
    deck = bodies.FLIGHT.format(method=method, words=words, spacing=spacing, ppc=setting.ppc, effects=bodies.DRY)
    for old, new in (("lo=2,0,0  hi=27,1,1", f"lo={start!r},0,0  hi={start + 25.0!r},1,1"),
                     ("origin=2,0,0", f"origin={start!r},0,0"), ("mode_speed=0.05", f"mode_speed={MODE_SPEED}")):
        assert old in deck
        deck = deck.replace(old, new)
    return timed(deck, setting) + quiet("count=1")


MODE_SPEED = 0.0005                          # amplitude of the velocity [m/s]; the wave speed is 10 m/s


def flight_error(run, _):
    """The larger of the errors of velocity and displacement, over their amplitudes."""
    seen = run.summary["exact"]
    velocity = seen["velocity_error"] / MODE_SPEED * 2 ** 0.5
    displacement = seen["displacement_error"] / (MODE_SPEED / (np.pi * 10.0 / 25.0)) * 2 ** 0.5
    return max(velocity, displacement)


def quiet(words, fields=""):
    """The deck with outputs at the end only, because their cost is not part of the comparison."""
    return (f"&output  name='h'  kind='history'  {words} /\n&checkpoint  at_end=.false. /\n"
            + (f"&output  name='p'  kind='particles'  count=1  precision='double'  "
               f"fields={fields} /\n" if fields else ""))


PISTON = """
&run  dimension='1d'  method='{method}' /
&units  system='mm-us-mg' /
&method  {words} /
&grid  lo=0,0,0  hi=12,1,1  dx={spacing!r} /
&time  t_end=1.2  cfl={cfl} /
&effects  strength=.false. /
&material  name='al'  density=2.785  eos_model='mie_gruneisen'  mg_c0=5.328  mg_s=1.338
  mg_gamma=2 /
&region  name='bar'  shape='box'  lo=0,0,0  hi=10,1,1 /
&body  name='bar'  region='bar'  material='al'  ppc={ppc},1,1  velocity=-0.4,0,0 /
&boundary  face='xlo'  type='slip' /
"""
SHOCK = 5328.0 + 1.338 * 400.0               # speed of the shock relative to the bar [m/s]: C0 + s u
# pressure behind the shock [Pa]: density, speed of the shock, speed of the bar
PRESSURE = 2785.0 * SHOCK * 400.0
BEHIND = SHOCK - 400.0                       # speed of the shock relative to the wall [m/s]


def piston(method, words, setting):
    """A bar of fluid metal hits a wall at 400 m/s; cells in 10 mm."""
    deck = PISTON.format(method=method, words=words, spacing=10.0 / setting.cells, ppc=setting.ppc,
                         cfl=setting.cfl)
    return deck + quiet("count=1", "'stress','volume'")


def piston_error(run, _):
    """Mean error of the pressure over the compressed length, relative to the pressure behind the shock."""
    time, snap = run.snapshots()[-1]
    front = BEHIND * time
    right = np.where(snap.points[:, 0] < front, PRESSURE, 0.0)
    wrong = np.abs(-snap.fields["stress"][:, 0] - right) * snap.fields["volume"]
    return wrong.sum() / 1.0e-6 / (PRESSURE * front)     # the cross-section is 1 mm2


SIZES = ("length", "foot", "waist")


def bar(method, words, setting):
    """The copper bar of input/taylor_copper; cells on its diameter of 7.62 mm, a multiple of three, so that a whole
    number of particles is on its length of 25.4 mm."""
    deck = (taylor.FOLDER / taylor.MEASURED.deck).read_text(encoding="utf-8")
    spacing = 7.62 / setting.cells
    across, along = (math.ceil(size / spacing - 1.0e-9) for size in (10.16, 26.67))
    for old, new in (("hi = 10.16, 0, 26.67", f"hi = {across * spacing!r}, 0, {along * spacing!r}"),
                     ("dx = 0.3175", f"dx = {spacing!r}"),
                     ("ppc = 2, 1, 2", f"ppc = {setting.ppc}, 1, {setting.ppc}"), ("every = 10", "count = 2"),
                     ("count = 4", "count = 1"), ("dimension =", f"method = '{method}'\n  dimension =")):
        assert old in deck
        deck = deck.replace(old, new)
    return timed(deck, setting) + f"&method  {words} /\n&checkpoint  at_end=.false. /\n"


def bar_sizes(run, _=None):
    """Sizes at the end: length, radius of the foot, and diameter at a fifth of the height [m]."""
    snaps = [snap for _, snap in run.snapshots()]
    found = taylor.measure(taylor.MEASURED, snaps[0], snaps[-1])
    return np.array([found[name] for name in SIZES])


# Length, foot and waist [m] with 24 cells on the radius, printed by accuracy_cost.py --reference:
# the mean of ddmp (16.2793, 6.7419, 10.1878 mm) and quadratic usl (16.2829, 6.7458, 10.1951 mm),
# which are 0.05 % apart.
REFERENCE = np.array([16.2811e-3, 6.7439e-3, 10.1914e-3])


def bar_error(run, _):
    """Mean of the errors of the three sizes."""
    return np.abs(bar_sizes(run) / REFERENCE - 1.0).mean()


def slope(method, words, setting):
    """Grains on a slope of 24 degrees with their steady profile, over one relaxation time."""
    height, angle = 0.01, np.radians(24.0)
    spacing, layers = height / setting.cells, setting.cells * setting.ppc
    wide = 5.0 * spacing                     # the least width for cubic splines on a periodic grid
    bulk = 1000.0 * flows.DENSITY * flows.GRAVITY * height
    words = words if "pic" in words else f"flip=0.9999 {words}"
    deck = flows.INCLINE.format(
        method=method, words=words, spacing=spacing, top=(setting.cells + 4) * spacing, end=0.8,
        along=float(flows.GRAVITY * np.sin(angle)), down=float(-flows.GRAVITY * np.cos(angle)),
        density=flows.DENSITY, bulk=bulk, shear=0.46 * bulk, mu_s=float(flows.MU_S),
        mu_2=float(flows.MU_2), i0=flows.I0, diameter=flows.DIAMETER,
        grain_density=flows.GRAIN_DENSITY)
    deck = deck.replace(f"hi={spacing!r},", f"hi={wide!r},")
    for n in range(layers):
        low, high = n * height / layers, (n + 1) * height / layers
        speed = float(flows.bagnold(0.5 * (low + high), 24.0, height))
        deck += (f"&region name='r{n}' shape='box' lo=0,0,{low!r} hi={wide!r},1,{high!r} /\n"
                 f"&body name='b{n}' region='r{n}' material='beads' ppc={setting.ppc},1,"
                 f"{setting.ppc} velocity={speed!r},0,0 /\n")
    return timed(deck, setting) + quiet("count=1", "'velocity'")


def slope_error(run, _):
    """Error of the speed, root mean square over all particles, relative to the speed of the surface."""
    _, last = run.snapshots()[-1]
    exact = flows.bagnold(last.points[:, 2], 24.0, 0.01)
    return bodies.rms(last.fields["velocity"][:, 0] - exact) / flows.bagnold(0.01, 24.0, 0.01)


PROBLEMS = {
    "waves": Problem(
        "standing waves in a square, amplitude 0.1: displacement", 2,
        waves("plane_strain", 0.1), greatest, (8, 12, 18, 28, 50), (2, 3), (0.4, 0.7), 18),
    "waves_cube": Problem(
        "standing waves in a cube, amplitude 0.05: displacement", 3,
        waves("3d", 0.05), greatest, (6, 9, 13, 19), (2, 3), (0.4, 0.7), 9),
    "waves_small": Problem(
        "standing waves in a square, amplitude 0.001: displacement", 2,
        waves("plane_strain", 0.001), greatest, (8, 14, 25, 46), (2, 3), (0.4, 0.7), 14),
    "flight": Problem(
        "bar that vibrates and flies through its grid: velocity, displacement", 1,
        flight, flight_error, (12, 18, 27, 40, 62, 100, 150), (2, 3), (0.4, 0.7), 40),
    "vortex": Problem(
        "ring turned by one radian: displacement", 2,
        vortex, greatest, (8, 10, 14, 18, 22), (4, 3), (0.4, 0.7), 14),
    "piston": Problem(
        "shock in a bar on a wall: pressure", 1,
        piston, piston_error, (25, 45, 75, 130, 240, 430, 845), (4, 2), (0.4, 0.7), 130,
        (*USUAL, "usl-q1", "apic-q1")),
    "taylor": Problem(
        "copper bar on a wall: length, foot and waist", 2,
        bar, bar_error, (6, 9, 15, 21), (2, 3), (0.4, 0.7), 6,
        without=("ddmp control",)),          # not measured there
    "slope": Problem(
        "grains on a slope: speed", 2,
        slope, slope_error, (3, 4, 5, 7), (2, 3), (0.4, 0.7), 4),
}
