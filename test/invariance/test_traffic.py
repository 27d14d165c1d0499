# SPDX-License-Identifier: BSD-3-Clause
# cores: 2
"""Messages of ranks in a step agree with the model of doc/developer/scaling.md.

Would catch: patches sent twice, sent to ranks that do not need them, with nodes that these do not need, or with columns
that were not requested; a second exchange in a step; empty messages; at the start and at a restart, a list of all tiles
on some rank, and partitions of the curve that depend on how tiles are distributed.
"""

import re
from types import SimpleNamespace

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
