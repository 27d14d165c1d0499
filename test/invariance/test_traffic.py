# SPDX-License-Identifier: BSD-3-Clause
# cores: 2
"""Messages of ranks in a step agree with the model of doc/developer/scaling.md.

Would catch: patches sent twice, sent to ranks that do not need them, with nodes that these do not need, or with columns
that were not requested; a second exchange in a step; empty messages; at the start and at a restart, a list of all tiles
on some rank, and partitions of the curve that depend on how tiles are distributed. Also waits for all ranks in steps in
which each rank knows from whom it receives, and messages to ranks that do not expect them.
"""
# timeout: 300

import re
from types import SimpleNamespace

import pytest

import case
import scaling
from scaling_model import EXCHANGES, traffic, words_of

STEPS = 4
WORD = 8
BAR = """
&run  dimension='1d'  method='{method}' /
&method  {words} /
&grid  lo=0,0,0  hi=512,1,1  dx=1  block=64 /
&time  t_end=1.0e3  max_steps={steps} /
&material  name='rubber'  density=1000  young=1.0e6  poisson=0.3 /
&region  name='bar'  shape='box'  lo=0,0,0  hi=512,1,1 /
&body  name='bar'  region='bar'  material='rubber' /
&parallel  balance='never' /
"""
BAR_PATCHES = {"mpm": ((3, 1), (3, 1)), "ddmp": ((5, 4),)}     # numbers per node and nodes of the bar
RANKS = 8
SPHERES = """
&run  dimension='3d' /
&grid  lo=0,0,0  hi=96,96,96  dx=1 /
&time  t_end=1.0e3  max_steps=2 /
&material  name='rubber'  density=1000  young=1.0e6  poisson=0.3 /
&region  name='ball'  shape='sphere'  centre=8,10,8  radius=4.4 /
&body  name='ball'  region='ball'  material='rubber'  ppc=1,1,1  repeat=5,5,1  repeat_step=9,9,9 /
&region  name='plate'  shape='box'  lo=1,1,2  hi=95,95,4 /
&body  name='plate'  region='plate'  material='rubber'  ppc=1,1,1 /
&output  name='h'  kind='history'  every=1000000 /
"""
# Two balls meet over a periodic face: tiles appear and vanish. Gas is halved where it is stretched.
FLIGHT = """
&run  dimension='plane_strain' /
&grid  lo=0,0,0  hi=64,1,64  dx=1  block=4 /
&boundary  face='all'  type='periodic' /
&time  t_end=1.0e3  max_steps=120 /
&material  name='rubber'  density=1000  young=1.0e6  poisson=0.3 /
&region  name='one'  shape='sphere'  centre=50,0,50  radius=7 /
&body  name='one'  region='one'  material='rubber'  ppc=2,1,2  velocity=40,0,30 /
&region  name='two'  shape='sphere'  centre=20,0,24  radius=5 /
&body  name='two'  region='two'  material='rubber'  ppc=2,1,2  velocity=-40,0,10 /
&parallel  balance='never' /
"""
GAS = """
&run  dimension='plane_strain' /
&grid  lo=0,0,0  hi=1.6,1,1.6  dx=0.04  block=4 /
&boundary  face='all'  type='periodic' /
&time  t_end=1  max_steps=100 /
&effects  strength=.false. /
&material  name='air'  density=1.2  eos_model='ideal_gas'  ig_gamma=1.4 /
&region  name='air'  shape='sphere'  centre=0.7,0,0.5  radius=0.3 /
&body  name='air'  region='air'  material='air'  ppc=2,1,2  velocity=200,0,100  specific_energy=2.0e5 /
&parallel  balance='never' /
"""
INFLOW = """
&run  dimension='plane_strain' /
&grid  lo=0,0,0  hi=64,1,64  dx=1  block=4 /
&time  t_end=1.0e3  max_steps=120 /
&material  name='rubber'  density=1000  young=1.0e6  poisson=0.3 /
&region  name='jet'  shape='box'  lo=0,0,28  hi=8,1,36 /
&body  name='jet'  region='jet'  material='rubber'  ppc=2,1,2 /
&inflow  body='jet'  velocity=20,0,0 /
&parallel  balance='never' /
"""


@pytest.mark.parametrize("name, calls", (("flight", 2), ("gas", 3), ("inflow", 2)))
def test_collective_calls(options, sheet, name, calls):
    """A step needs two reductions, with particles that are halved one more; further ones only where particles enter,
    and where a rank gets new neighbours, which is rare. On five ranks the bits are those of one."""
    deck = {"flight": FLIGHT, "gas": GAS, "inflow": INFLOW}[name]
    one = case.Case(options, "one", deck).run("-q").summary
    many = case.Case(options, "many", deck, ranks=5).run("-q").summary
    sheet.require(many["digest"] == one["digest"], f"five ranks: digest {many['digest']}, not {one['digest']}")
    counts, steps = many["rank_counts"], many["steps"]
    found = counts["collective_calls"]
    sheet.require(found["min"] == found["max"] > calls * steps, f"{name}: {found} collective calls in {steps} steps")
    if name == "gas":
        sheet.require(many["particles_halved"] > 0, "particles are halved")
    entries = 0
    if name == "inflow":
        sheet.require(many["particles"] > 1.5 * 256, "the jet has grown")
        # steps in which one of the two layers of particles in each cell enters
        entries = 2 * 20 * many["time"] + 1
    most = calls * steps + entries + steps / 4
    sheet.require(found["max"] <= most, f"{name}: {found['max']} collective calls, not at most {most:.0f}")
    sheet.require(counts["messages"]["max"] > steps, "there are neighbours")


def test_bars(options, sheet):
    """Eight tiles in a row on two ranks: one tile of each rank touches the other rank."""
    for method, exchanges in EXCHANGES.items():
        run = case.Case(options, f"bar_{method}", BAR.format(method=method, steps=STEPS, words=scaling.words_of(
            SimpleNamespace(method_words=""), method)), ranks=2)
        found = run.run("-q").summary["traffic"]
        # in one dimension vectors and tensors of packed patches have one number, other vectors three
        words = sum(words_of(method, exchange, columns, nodes, 64)
                    for exchange, (columns, nodes) in enumerate(BAR_PATCHES[method]))
        sheet.require(found["patch_messages"] == 2 * STEPS * len(exchanges),
                      f"{method}: {found['patch_messages']} messages of patches")
        sheet.require(found["patch_bytes"] == 2 * STEPS * WORD * words,
                      f"{method}: {found['patch_bytes']} bytes of patches")


def test_blocks(options, sheet):
    """A periodic block of 4 x 4 x 4 tiles on 1 to 8 ranks."""
    scene = SimpleNamespace(scree=options.scree, work=options.work, steps=STEPS, ppc=2, method_words="", launcher="",
                            resume=False)
    for method in EXCHANGES:
        for ranks in (1, 2, 4, 8):
            deck = scaling.block_deck(scene, method, [24, 24, 24]).replace("velocity=3,-2,1", "velocity=0.3,-0.2,0.1")
            summary = scaling.run(scene, deck, ranks, 1, f"block_{method}_{ranks}")
            found = summary.get("traffic", {"patch_messages": 0, "patch_bytes": 0})
            messages, size = traffic(method, 64 / ranks, ranks)
            name = f"{method} on {ranks} ranks"
            sheet.require(found["patch_messages"] == messages * STEPS * ranks,
                          f"{name}: {found['patch_messages'] / STEPS / ranks} messages, "
                          f"not {messages}")
            if ranks > 1:
                sheet.near(f"{name}, bytes a step and rank",
                           found["patch_bytes"] / STEPS / ranks, size, 1.0e-3)


def test_starts(options, sheet):
    """Balls in rows, whose boxes share tiles, over a plate, in the lower third of the box: the lists of tiles
    of a rank at the start and at a restart are fractions of the whole, and results are those of one rank."""
    one = case.Case(options, "start_1", SPHERES).run("-q")
    tiles = int(re.search(r"([0-9]+) of [0-9]+ hold particles", one.path(".log").read_text("utf-8")).group(1))
    sheet.require(tiles > 300, f"{tiles} tiles hold particles")
    many = case.Case(options, f"start_{RANKS}", SPHERES, ranks=RANKS).run("-q")
    for name in ("start", "restart"):
        listed = many.summary["traffic"]["tiles_listed_at_start"]
        sheet.require(tiles / RANKS <= listed <= 1.5 * tiles / RANKS,
                      f"{name}: a rank of {RANKS} has a list of {listed} of {tiles} tiles")
        sheet.require(many.summary["digest"] == one.summary["digest"],
                      f"{name} on {RANKS} ranks: digest {many.summary['digest']}, "
                      f"not {one.summary['digest']}")
        many.run("-q", "--restart", "--set", "time.max_steps=3")
        one.run("-q", "--restart", "--set", "time.max_steps=3")
