# SPDX-License-Identifier: BSD-3-Clause
"""The strength of a place is that of the material, not of the cells and particles that compute it.

Would catch: strength drawn by the number of a particle, so that a finer lattice or another number of particles per
cell is another stone; flaws lost or counted twice between particles; a strength of specimens that does not follow
Weibull's V**(-1/m), or whose mean or spread depends on the cell size; strength that follows the body instead of the
place, or that changes if the body gets longer; halves of split particles, or particles of an inflow, that get a
strength of their own; a smallest size that particles do not share; a depth of the scene that does not count; results
that depend on ranks, threads or a restart.
"""
# tiers: full
# timeout: 200

import math

import numpy as np
import pytest

import case

DECK = """
&run  dimension='{dimension}'  seed={seed} /
&grid  lo={lo}  hi={hi}  dx={dx} /
&time  t_end={t_end}  max_steps={steps} /
&effects  damage=.true.  size_scatter=.true. /
{more}
&material  name='glass'  density=2500  young=70e9  poisson=0.2  {model} /
&region  name='a'  shape='box'  lo={low}  hi={high} /
&body  name='a'  region='a'  material='glass'  ppc={ppc}  packing='{packing}'  {velocity} /
&output  name='p'  kind='particles'  every=1000000  precision='double'  fields='scatter','mass','identity' /
"""
WEIBULL = "damage_model='principal_stress'  failure_stress=100e6  weibull_m=6  weibull_volume=1e-6"
FLAWS = "damage_model='grady_kipp'  weibull_m=6  weibull_k=1e25"
START = {"dimension": "3d", "seed": 1, "lo": "0,0,0", "hi": "0.12,0.12,0.12", "dx": 0.02, "t_end": 1, "steps": 0,
         "more": "", "model": WEIBULL, "low": "0,0,0", "high": "0.12,0.12,0.12", "ppc": "2,2,2", "packing": "lattice",
         "velocity": ""}
PLANE = {"dimension": "plane_strain", "ppc": "2,1,2"}
BAR = {"dimension": "1d", "ppc": "2,1,1"}


def field(options, name, how=(), ranks=1, threads=1, **keys):
    """Positions, strengths and identities of a run."""
    run = case.Case(options, name, DECK.format(**{**START, **keys}), ranks=ranks, threads=threads)
    last = run.run("-q", *how).snapshots()[-1][1]
    order = np.argsort(last.fields["identity"])
    return last.points[order], last.fields["scatter"][order], last.fields["identity"][order].astype("i8")


def weakest(points, strength, edge, active):
    """The least strength in each box of this edge, by the place of the box."""
    found = {}
    for place, value in zip(np.floor(points[:, active] / edge + 1e-9).astype(int), strength):
        found[tuple(place)] = min(found.get(tuple(place), math.inf), value)
    return found


@pytest.mark.parametrize("model", (WEIBULL, FLAWS, WEIBULL + "  weibull_size=5e-3"))
@pytest.mark.parametrize("scene, active", (({"high": "0.06,0.06,0.06"}, [0, 1, 2]), (PLANE, [0, 2]), (BAR, [0]),
                                           ({**PLANE, "dimension": "axisymmetric"}, [0, 2])))
def test_same_stone(options, sheet, scene, active, model):
    """The weakest of the particles in boxes of 20 mm, for lattices of 2, 3 and 5 particles along the edge."""
    fields = {}
    for name, dx, n in (("coarse", 0.02, 2), ("more", 0.02, 3), ("fine", 0.004, 1), ("finer", 0.004, 3)):
        ppc = ",".join(str(n if axis in active else 1) for axis in range(3))
        keys = {**scene, "dx": dx, "ppc": ppc, "model": model}
        points, strength, _ = field(options, name, **keys)
        fields[name] = weakest(points, strength, 0.02, active)
        if name == "coarse":
            jitter = field(options, "jitter", **{**keys, "packing": "jitter"})[1]
            sheet.require(np.array_equal(strength, jitter), "displaced particles have the strength of their sites")
    boxes = (3 if len(active) == 3 else 6) ** len(active)
    sheet.require(len(set(fields["coarse"].values())) == len(fields["coarse"]) == boxes, "all boxes, and they differ")
    for name in ("more", "fine", "finer"):
        sheet.require(fields[name] == fields["coarse"], f"{name}: the same weakest places")


def test_same_bits(options, sheet):
    """Ranks, threads and a restart."""
    keys = {"dx": 0.01, "steps": 4, "velocity": "velocity=3,0,0", "hi": "0.24,0.12,0.12"}
    one = field(options, "one", **keys)
    for name, ranks, threads in (("ranks", 2, 1), ("threads", 1, 2)):
        other = field(options, name, ranks=ranks, threads=threads, **keys)
        sheet.require(all(np.array_equal(a, b) for a, b in zip(one, other)), f"the same with more {name}")
    run = case.Case(options, "restart", DECK.format(**{**START, **keys}), ranks=2)
    run.run("-q", "-s", "time.max_steps=2")
    run.ranks = 1
    last = run.run("-q", "--restart").snapshots()[-1][1]
    order = np.argsort(last.fields["identity"])
    sheet.require(np.array_equal(last.fields["scatter"][order], one[1]), "the same after a restart")


def test_places(options, sheet):
    """A longer body, one elsewhere, one that moves, and another seed."""
    short = field(options, "short", high="0.06,0.12,0.12")
    whole = field(options, "whole")
    at = whole[0][:, 0] < 0.06
    sheet.require(np.array_equal(whole[1][at], short[1]), "a longer body has the same flaws where it was")
    moving = field(options, "moving", high="0.06,0.12,0.12", steps=3, velocity="velocity=100,0,0")
    sheet.require(np.array_equal(moving[1], short[1]), "a body that moves keeps its strength")
    sheet.require(moving[0][:, 0].max() > short[0][:, 0].max(), "it has moved")
    for name, keys in (("elsewhere", {"low": "0.06,0,0"}), ("seed", {"high": "0.06,0.12,0.12", "seed": 2})):
        other = field(options, name, **keys)[1]
        sheet.require(len(other) == len(short[1]) and not np.any(other == short[1]), f"{name}: another stone")


def test_size_effect(options, sheet):
    """Specimens of V and 8 V over 40 seeds, with two cell sizes, against Weibull's statistics."""
    modulus, volume = 6.0, 0.06 ** 3
    weak = {}
    for dx, seeds in ((0.03, 40), (0.02, 6)):
        rows = []
        for seed in range(seeds):
            points, strength, _ = field(options, f"{dx}_{seed}", dx=dx, seed=seed, ppc="1,1,1")
            rows.append((strength[(points < 0.06).all(axis=1)].min(), strength.min()))
        weak[dx] = np.array(rows)
    sheet.require(np.array_equal(weak[0.02], weak[0.03][:6]), "every specimen has the same strength with other cells")
    for column, size in ((0, volume), (1, 8.0 * volume)):
        right = (1.0e-6 / size) ** (1.0 / modulus)
        mean = right * math.gamma(1.0 + 1.0 / modulus)
        spread = right * math.sqrt(math.gamma(1.0 + 2.0 / modulus) - math.gamma(1.0 + 1.0 / modulus) ** 2)
        values = weak[0.03][:, column]
        sheet.below(f"{size:g} m3: error of the mean over its standard error",
                    abs(values.mean() - mean) / spread * math.sqrt(40), 2.5)
        sheet.below(f"{size:g} m3: relative error of the spread", abs(values.std(ddof=1) / spread - 1.0), 0.3)


def test_depth(options, sheet):
    """A slice 64 times as thick breaks at half the stress: its mean strength over 400 places is 64**(-1/6) of it."""
    mean = [field(options, f"{depth}", dx=0.006, ppc="1,1,1", dimension="plane_strain", hi=f"0.12,{depth},0.12",
                  high=f"0.12,{depth},0.12")[1].mean() for depth in (0.01, 0.64)]
    sheet.below("relative error of the ratio", abs(2.0 * mean[1] / mean[0] - 1.0), 0.03)


def test_halves(options, sheet):
    """A soft bar is stretched until its particles are halved: every half has the strength of the whole."""
    soft = WEIBULL.replace("100e6", "1e15")
    keys = {**BAR, "dx": 0.01, "hi": "0.5,1,1", "low": "0.1,0,0", "high": "0.2,1,1", "model": soft,
            "more": "&method  split=.true. /", "velocity": ""}
    points, strength, identity = field(options, "whole", **keys)
    deck = DECK.format(**{**START, **keys, "steps": 4000, "t_end": 4.0e-4,
                          "velocity": "velocity_formula='3e3*(x-0.15)','0','0'"})
    last = case.Case(options, "halves", deck.replace("70e9", "70e3")).run("-q").snapshots()[-1][1]
    sheet.require(len(last.fields["scatter"]) > 1.2 * len(strength), "particles were halved")
    known = dict(zip(identity, strength))
    right = [known[number & (2 ** 40 - 1)] for number in last.fields["identity"].astype("i8")]
    sheet.require(np.array_equal(right, last.fields["scatter"]), "halves have the strength of the whole")


def test_inflow(options, sheet):
    """Material that enters is a long bar that moves into the domain, of the flaws of that bar."""
    long = field(options, "long", **{**BAR, "lo": "-0.6,0,0", "hi": "0.6,1,1", "dx": 0.01, "low": "-0.6,0,0",
                                     "high": "0.1,1,1"})
    keys = {**BAR, "lo": "0,0,0", "hi": "0.6,1,1", "dx": 0.01, "high": "0.1,1,1",
            "more": "&inflow  body='a'  velocity=100,0,0 /", "steps": 100000, "t_end": 4.03e-3}
    points, strength, _ = field(options, "flow", **keys)
    start = points[:, 0] - 100.0 * 4.03e-3
    sheet.require(start.min() < -0.35, "material has entered")
    place = np.rint((start + 0.6) / 0.005 - 0.5).astype(int)
    by_place = dict(zip(np.rint((long[0][:, 0] + 0.6) / 0.005 - 0.5).astype(int), long[1]))
    sheet.below("strength against that of the bar", max(abs(by_place[n] / f - 1.0) for n, f in zip(place, strength)),
                1.0e-6)
