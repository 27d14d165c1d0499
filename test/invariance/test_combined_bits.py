# SPDX-License-Identifier: BSD-3-Clause
"""Methods and effects in combinations that no other test has: the same bits on one rank and thread and on two of each.

Would catch: node fields that are those of the step before or of another velocity field, such as those of particles at
a crack that are strained before the second side of their nodes has moved; memory that is used before it is set, in one
order of the stress update or with one kind of shape functions alone; sums of an effect in the order of ranks.

Each scene is combined with every dimension, gradient, transfer and order of the stress update that it allows, and each
of these with each other, but not three at a time. All decks run in one process, so that later ones get the memory
of earlier ones, and new memory is filled with other bytes in the second run. Tiles have nearly their least size, and
particles cross them. Controls: all decks make their steps on two ranks, the ranks exchange tiles, and the digests of
different decks differ.
"""
# tiers: full, long
# timeout: 600
# cores: 2

import itertools
import subprocess
import sys

import pytest

import case
import tier

STEPS = 12
CHOICES = {
    "dimension": ("plane_strain", "axisymmetric", "3d", "1d"),
    "gradient": ("point", "sub_points", "control", "linear", "gimp", "cpgimp", "cpdi", "quadratic", "cubic"),
    "transfer": ("rflip", "flip", "pic", "apic", "aflip"),
    "update": ("usf", "usl", "musl", "usavg"),
}
DUAL = ("point", "sub_points", "control")       # quadratures of the dual gradient; others are shape functions

RUBBER = "density=1000  young=1e6  poisson=0.3"
WEAK = f"{RUBBER}  damage_model='principal_stress'  failure_stress=2e3"
METAL = "eos_model='mie_gruneisen'  density=1000  mg_c0=30  mg_s=1.4  mg_gamma=1.8  shear=4e5"
GAS = "eos_model='ideal_gas'  ig_gamma=1.4  elastic='none'"
PAIR = "&contact  bodies='low','high'  law='bonded'  bond_strength=3e3  friction=0.3 /"
CRACK = "&contact  bodies='low','low'  friction=0.3 /"
RIGID = """&region  name='rigid'  shape='sphere'  centre={middle}  radius=0.13 /
&boundary  region='rigid'  type='friction'  friction=0.4  density=2000 /
&output  name='r'  kind='rigid'  every=4 /"""
LOAD = "&load  pressure=2e3  bodies='high' /"
# effects, materials of the lower and of the upper body, words of both bodies, words of &method, further groups
SCENES = {
    "cracks": ("contact=.true.  damage=.true.", WEAK, RUBBER, "", "", f"&contact  friction=0.3 /\n{CRACK}"),
    "grains_of_cracks": ("contact=.true.  damage=.true.  gravity=.true.",
                         f"{WEAK}  failed_as='drucker_prager'  failed_friction_angle=30", WEAK, "",
                         "split=.true.  split_at=0.51", CRACK),
    "contact": ("contact=.true.", RUBBER, f"{RUBBER}  strength_model='neo_hookean'", "", "", f"{PAIR}\n{RIGID}"),
    "erosion": ("damage=.true.  erosion=.true.  size_scatter=.true.", f"{WEAK}  weibull_m=6  weibull_volume=1e-3",
                RUBBER, "",
                "split=.true.  split_at=0.51", LOAD),
    "rigid": ("damping=3", RUBBER, RUBBER, "", "", f"{RIGID}\n{LOAD}"),
    "inflow": ("damage=.true.", RUBBER, f"{WEAK}  failure_delay=1e-3", "", "",
               "&inflow  body='low'  velocity={speed} /"),
    "heat": ("thermal=.true.", f"{METAL}  specific_heat=100  conductivity=1e4",
             f"{RUBBER}  specific_heat=100  conductivity=2e4", "temperature=400", "heat_flux=2",
             "&boundary  face='{axis}hi'  type='stick'  temperature=600 /"),
    "metal": ("thermal=.true.  melting=.true.  damage=.true.",
              f"{METAL}  specific_heat=100  t_melt=400  strength_model='johnson_cook'  jc_a=1e4  jc_b=1e4  jc_n=0.3  "
              "jc_c=0.01  jc_m=1  damage_model='johnson_cook'  jcd=0.05,0,0,0,0",
              f"{METAL}  specific_heat=100  t_melt=400  spall=1e4", "", "antilock='bbar'", ""),
    "gas": ("contact=.true.", f"{GAS}  density=1", f"{GAS}  density=2", "specific_energy=2e3",
            "heat_flux=2  split=.true.  split_at=0.51", ""),
    "explosive": ("artificial_viscosity=.true.", "preset='tnt'", "preset='al_6061_t6'", "", "",
                  "&detonation  point={start} /"),
    "loose": ("gravity=.true.  voids=.true.", f"{RUBBER}  strength_model='drucker_prager'  friction_angle=30",
              f"{RUBBER}  strength_model='mu_i'  mu_s=0.4  mu_2=0.7  mu_i0=0.3  grain_diameter=1e-3  "
              "grain_density=1600", "", "", "&boundary  face='{axis}lo'  type='absorbing' /"),
    "cell": ("artificial_viscosity=.true.", RUBBER, RUBBER, "", "",
             "&boundary  face='all'  type='periodic' /\n&cell /\n&stage  rate={rate}  strain=5 /"),
}
DECK = """
&run  dimension='{dimension}'  method='{method}' /
&grid  lo=0,0,0  hi={hi}  dx={dx!r}  block={block} /
&time  t_end=1  max_steps={steps} /
&method  {words} /
&effects  {effects} /
&material  name='low'  {low} /
&material  name='high'  {high} /
&region  name='low'  shape='box'  lo={low_lo}  hi={low_hi} /
&region  name='high'  shape='box'  lo={high_lo}  hi={high_hi} /
&body  name='low'  region='low'  material='low'  ppc={ppc}  {low_words} /
&body  name='high'  region='high'  material='high'  ppc={ppc}  velocity={back}  {body} /
{groups}
&parallel  balance_every=3  imbalance=1.01 /
&checkpoint  wall_minutes=0 /
"""
SCRIPT = """
import sys
import scree
with open(sys.argv[1], "a", encoding="utf-8") as rows:
    for path in sys.argv[2:]:
        print("deck", path, flush=True)
        with scree.Simulation(path, outdir=f"{path}.out", case="case", overwrite=True) as sim:
            sim.run()
            if sim.rank == 0:
                seen = sim.finish().summary
                print(seen["digest"], seen["steps"], seen["ranks"], seen["threads"],
                      seen.get("traffic", {}).get("tiles_sent", 0), file=rows, flush=True)
"""


def fits(scene, dimension, gradient, transfer, update):
    """Does the program accept the combination? Its messages give the reasons."""
    if update == "usavg" and transfer in ("apic", "aflip"):
        return False
    if CRACK in SCENES[scene][-1]:
        return gradient in ("point", "linear") and transfer in ("flip", "rflip", "aflip") and update in ("usl", "usf")
    if scene == "cell":
        return dimension != "axisymmetric" and transfer in ("flip", "pic") and update == "usl" and gradient in (
            "point", "linear", "gimp", "quadratic", "cubic")
    return True


def parts(row):
    """Pairs of a deck that are to be tested; with cracks, which few methods allow, also those of each crack scene."""
    pairs = set(itertools.combinations(enumerate(row), 2))
    if CRACK in SCENES[row[0]][-1]:
        pairs |= {(row[0], *pair) for pair in pairs}
    return pairs


def combinations():
    """Decks by scene, dimension, gradient, transfer and update. Each deck is the one that has the most pairs which no
    deck before has."""
    options = [(row, parts(row)) for row in itertools.product(SCENES, *CHOICES.values()) if fits(*row)]
    missing = set().union(*(pairs for _, pairs in options))
    chosen = []
    while missing:
        row, pairs = max(options, key=lambda option: len(missing & option[1]))
        missing -= pairs
        chosen.append(row)
    return chosen


def deck(scene, dimension, gradient, transfer, update):
    """The text of a deck."""
    effects, low, high, body, words, groups = SCENES[scene]
    axes = {"1d": "x", "3d": "xyz"}.get(dimension, "xz")
    axis = axes[-1]

    def vector(along, across=0.0, rest=0.0):
        return ",".join(str(along if name == axis else across if name in axes else rest) for name in "xyz")

    speed = vector(5)
    keys = f"transfer='{transfer}'  stress_update='{update}'  {words}"
    keys += f"  quadrature='{gradient}'" if gradient in DUAL else f"  basis='{gradient}'"
    if scene == "inflow":
        start = ""
    else:
        start = f"velocity={speed}"
    return DECK.format(
        dimension=dimension, method="ddmp" if gradient in DUAL else "mpm", hi=vector(1, 1, 1), dx=1 / 12, steps=STEPS,
        block=6 if gradient == "sub_points" else 5 if gradient not in (*DUAL, "linear") else 4, words=keys,
        effects=effects, low=low, high=high, low_lo=vector(0, 1 / 6), low_hi=vector(0.5, 5 / 6, 1),
        high_lo=vector(0.5, 0, 0), high_hi=vector(11 / 12, 3 / 4, 1), ppc=vector(2, 2, 1), low_words=f"{start}  {body}",
        back=vector(-5), body=body, groups=groups.format(
            axis=axis, speed=speed, middle=vector(0.5, 0.9, 0.5), start=vector(1 / 12, 1 / 2, 1 / 2),
            rate="-5,0,0,0,0,0" if dimension == "1d" else "0,0,-3,0,20,0"))


def digests(options, decks, ranks, threads, fill):
    """Digest, steps, ranks, threads and moved tiles of all decks, in one process for each rank; new memory is filled
    with a byte."""
    script, found = options.work / "script.py", options.work / f"found_{ranks}.txt"
    script.write_text(SCRIPT, encoding="utf-8")
    found.write_text("", encoding="utf-8")
    words = [sys.executable, script, found, *decks]
    if ranks > 1:
        words = ["mpiexec", "-n", ranks, *words]
    environment = {**case.Case(options, "unused", "", threads=threads, keep=True).environment, **case.PATIENT,
                   "SCREE": str(options.scree), "PYTHONPATH": str(case.ROOT / "python/src"),
                   "PYTHONDONTWRITEBYTECODE": "1", "MALLOC_PERTURB_": str(fill)}
    answer = subprocess.run([str(word) for word in words], env=environment, text=True, timeout=500, check=False,
                            stdout=subprocess.PIPE, stderr=subprocess.STDOUT)
    if answer.returncode:
        raise AssertionError(answer.stdout[-4000:])
    rows = [line.split() for line in found.read_text(encoding="utf-8").splitlines()]
    return [(digest, *map(int, rest)) for digest, *rest in rows]


def test_combinations(options, sheet):
    """All decks; in the tier full a third of them."""
    if not (options.scree.parents[1] / "lib/libscree.so").is_file():
        pytest.skip("libscree.so is not built beside the program")
    case.need_ranks(options.scree)
    rows = combinations()[::tier.choose(full=3, long=1)]
    names = ["-".join(row) for row in rows]
    decks = [options.work / f"{name}.nml" for name in names]
    for path, row in zip(decks, rows):
        path.write_text(deck(*row), encoding="utf-8")
    alone, shared = digests(options, decks, 1, 1, 0), digests(options, decks, 2, 2, 8)
    sheet.require(len(alone) == len(shared) == len(names), "all decks have run")
    for name, one, two in zip(names, alone, shared):
        sheet.require(two[0] == one[0], f"{name}: {two[0]}, not {one[0]}")
        sheet.require(two[1:4] == (STEPS, 2, 2), f"{name}: {two[1:4]} steps, ranks, threads")
    sheet.require(len({row[0] for row in alone}) == len(names), "all decks have other digests")
    moved = sum(row[4] for row in shared)
    print(f"         {len(names)} decks, {moved} tiles moved between ranks")
    sheet.require(moved > len(names) // 10, "tiles moved between ranks")
