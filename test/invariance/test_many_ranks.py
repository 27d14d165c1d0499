# SPDX-License-Identifier: BSD-3-Clause
"""Many more ranks than cores, and more ranks than tiles: the same bits, and messages to neighbours only.

Would catch: a rank without particles that waits for a message or divides by its count, a list of receivers with ranks
that are not neighbours, one collective call per neighbour or per tile, arrays with one entry per rank, which grow with
the number of ranks, a restart in which every rank lists all tiles, and a report of scripts/scaling.py with empty
columns or figures. full: 24 and 36 ranks; long: 512 ranks.
"""
# tiers: full, long
# timeout: 600
# timeout long: 3600
# cores: 2

import csv
import re
import subprocess
import sys
from types import SimpleNamespace

import pytest
from PIL import Image

import case
import scaling
from scaling_model import EXCHANGES, TILE_CELLS, WORD, boxes_of, words_of

STEPS = 3
CALLS = 2                               # reductions of the time step and of node displacements
NEIGHBOURS = 26
BAR = """
&run  dimension='1d' /
&grid  lo=0,0,0  hi=640,1,1  dx=1  block=64 /
&time  t_end=1.0e3  max_steps=40 /
&material  name='rubber'  density=1000  young=1.0e6  poisson=0.3 /
&region  name='bar'  shape='box'  lo=40,0,0  hi=360,1,1 /
&body  name='bar'  region='bar'  material='rubber'  velocity=20,0,0 /
&parallel  balance='auto'  balance_every=7  imbalance=1.01 /
"""


def scene(options, **changed):
    """The options of scripts/scaling.py for small scenes."""
    small = {"steps": STEPS, "edge": 1, "radius": 12.0, "ppc": 1, "method_words": "", "launcher": "", "resume": False}
    return SimpleNamespace(scree=options.scree, work=options.work, **{**small, **changed})


@pytest.mark.tiers("full")
def test_more_ranks_than_tiles(options, sheet):
    """A bar of 6 tiles in flight, on 24 ranks: most of them never have a particle."""
    one = case.Case(options, "bar_1", BAR).run("-q").summary
    many = case.Case(options, "bar_24", BAR, ranks=24).run("-q").summary
    sheet.require(many["digest"] == one["digest"], f"24 ranks: digest {many['digest']}, not {one['digest']}")
    counts = many["rank_counts"]
    sheet.require(many["ranks"] == 24 and counts["tiles"]["min"] == 0, "some ranks have no tiles")
    sheet.require(counts["particle_updates"]["min"] == 0, "these ranks work on no particles")
    total = round(counts["particle_updates"]["avg"] * 24)
    sheet.require(total == many["particle_updates"], f"{total} updates on the ranks, {many['particle_updates']} in all")
    sheet.require(counts["messages"]["min"] == 0, "a rank without tiles sends nothing")


@pytest.mark.tiers("full")
def test_neighbours(options, sheet):
    """A periodic block of 4 x 3 x 3 tiles on as many ranks: each sends to its 26 neighbours, not to all 35."""
    case.need_ranks(options.scree)
    small = scene(options)
    cells = [4 * TILE_CELLS, 3 * TILE_CELLS, 3 * TILE_CELLS]
    deck = scaling.block_deck(small, "ddmp", cells).replace("velocity=3,-2,1", "velocity=0,0,0")
    one = scaling.run(small, deck, 1, 1, "block_1")
    many = scaling.run(small, deck, 36, 1, "block_36")
    sheet.require(many["digest"] == one["digest"], f"36 ranks: digest {many['digest']}, not {one['digest']}")
    counts = many["rank_counts"]
    # one call more: the first exchange of patches finds the senders
    (columns, layers), = EXCHANGES["ddmp"]
    words = sum(number * words_of("ddmp", 0, columns, nodes, TILE_CELLS ** 3)
                for number, nodes in zip((6, 12, 8), boxes_of(layers)))
    for name, expected in (("messages", STEPS * NEIGHBOURS), ("bytes", STEPS * WORD * words),
                           ("collective_calls", STEPS * CALLS + 1), ("tiles", STEPS),
                           ("ghost_tiles", STEPS * NEIGHBOURS), ("memory_by_ranks_bytes", WORD * 37)):
        found = counts[name]
        sheet.require(found["min"] == found["max"] == expected,
                      f"{name} of a rank: {found['min']} to {found['max']}, not {expected}")
    sheet.require(one["rank_counts"]["messages"]["max"] == one["rank_counts"]["collective_calls"]["max"] == 0,
                  "one rank sends nothing")


@pytest.mark.tiers("full")
def test_restart_lists(options, sheet):
    """More ranks read a checkpoint of 27 tiles: each rank lists only the tiles of the rows that it reads."""
    case.need_ranks(options.scree)
    program = options.scree.parent / "bench_restart"
    if not program.exists():
        pytest.skip("bench_restart was not built")
    for action, ranks in (("write", 2), ("read", 9)):
        words = [*scaling.launcher(scene(options), ranks, 1), str(program), action, str(options.work), "3"]
        said = subprocess.run(words, env=scaling.environment(1), text=True, check=True, stdout=subprocess.PIPE).stdout
    particles, listed, received, longest = map(int, re.findall(r"[a-z] (\d+)", said.splitlines()[-1]))
    sheet.require(particles == 27 * TILE_CELLS ** 3 * 8, f"{particles} particles are counted")
    sheet.require(27 <= listed == received <= 27 + 2 * 9, f"{listed} tiles are listed and {received} are received")
    sheet.require(longest <= 27 // 9 + 2, f"a rank lists {longest} tiles of the 3 that it reads")


@pytest.mark.tiers("full")
def test_report(options, sheet):
    """The command in the documentation of scaling runs, on few ranks: all columns have numbers, and the figures are
    large enough."""
    case.need_ranks(options.scree)
    command = [sys.executable, case.ROOT / "scripts/scaling.py", "--scree", options.scree, "--work", options.work,
               "--layouts", "1x1,2x1,4x1", "--edge", "1", "--radius", "9", "--steps", STEPS]
    subprocess.run([str(word) for word in command], check=True, stdout=subprocess.DEVNULL)
    with open(options.work / "scaling.csv", encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    sheet.require([(row["kind"], row["ranks"]) for row in rows]
                  == [(kind, ranks) for kind in ("weak", "strong") for ranks in ("1", "2", "4")], "one row per layout")
    sheet.require(len({row["digest"] for row in rows if row["kind"] == "strong"}) == 1, "the ball has one digest")
    for row in rows[1:3]:
        sheet.require(float(row["messages"]) > 0 and float(row["memory"]) > 0,
                      f"{row['ranks']} ranks: counts are there")
        # for a block with as many tiles as ranks the segments of the curve are cubes
        sheet.near(f"{row['ranks']} ranks: MB of the model", float(row["megabytes"]),
                   float(row["megabytes_model"]), 0.05)
    for name in ("scaling_ddmp_weak.png", "scaling_ddmp_strong.png"):
        sheet.require(Image.open(options.work / name).width >= 1600, f"{name} is 1600 pixels wide")
    report = (options.work / "scaling.md").read_text(encoding="utf-8")
    sheet.require("All layouts end with the same digest" in report, "the report compares digests")


@pytest.mark.tiers("long")
def test_hundreds(options, sheet):
    """A ball that flies and spins on 512 ranks, with about as many tiles."""
    case.need_ranks(options.scree)
    small = scene(options, radius=27.0, steps=10)
    one = scaling.run(small, scaling.ball_deck(small, "ddmp"), 1, 1, "ball_1")
    many = scaling.run(small, scaling.ball_deck(small, "ddmp"), 512, 1, "ball_512")
    sheet.require(many["digest"] == one["digest"], f"512 ranks: digest {many['digest']}, not {one['digest']}")
    counts = many["rank_counts"]
    # tiles appear and vanish; at worst the senders of each step are new
    sheet.require(10 * CALLS < counts["collective_calls"]["min"] == counts["collective_calls"]["max"]
                  <= 10 * (CALLS + 1), "collective calls do not grow with the ranks")
    sheet.below("messages of the busiest rank in a step", counts["messages"]["max"] / 10, 2.0 * 2 * NEIGHBOURS)
    sheet.require(counts["memory_by_ranks_bytes"]["max"] == WORD * 513, "one array has an entry per rank")
