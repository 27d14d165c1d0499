# SPDX-License-Identifier: BSD-3-Clause
# tiers: smoke
"""Damaged snapshots do not prevent a restart: they are reported and left out of the series, and a later restart
includes them again if they have been restored.

Would catch: a restart that a truncated, empty or overwritten snapshot stops or crashes, a snapshot that is left out
without a message, and a series that still lists it.
"""

import random

import case

SEED, FLIPS = 11, 6
DECK = """
&run dimension = '1d' /
&grid lo = 0 0 0  hi = 1 1 1  dx = 0.1 /
&time t_end = 1  max_steps = {steps}  dt_fixed = 1e-5 /
&material name = 'metal'  density = 2700  young = 70e9  poisson = 0.3 /
&region name = 'bar'  shape = 'box'  lo = 0.3 0 0  hi = 0.7 1 1 /
&body name = 'one'  region = 'bar'  material = 'metal'  velocity = 1 0 0 /
&output name = 'p'  kind = 'particles'  every = 5 /
&checkpoint dt = 1e-4  keep = 0 /
"""
VICTIM = "_p_000001.hdf"


def restart(options, sheet, label, damage):
    """One run, one damaged snapshot, and the restart."""
    run = case.Case(options, "series", DECK.format(steps=20)).run("-q")
    path = run.path(VICTIM)
    whole = path.read_bytes()
    damage(path, whole)
    run.deck.write_text(DECK.format(steps=40), encoding="utf-8")
    run.run("--restart", expect=None)
    text = run.output + run.path(".log").read_text(encoding="utf-8")
    series = run.path("_p.hdf.series").read_text(encoding="utf-8")
    return run.code, f"{path.name}" in text, path.name in series, series.count(".hdf\"")


def test_damaged_series(options, sheet):
    """Detected damage must be reported; damage in numbers that are not read may remain undetected."""
    for label, damage in (
            ("cut in half", lambda path, whole: path.write_bytes(whole[:len(whole) // 2])),
            ("empty", lambda path, whole: path.write_bytes(b"")),
            ("another kind of file", lambda path, whole: path.write_bytes(b"x" * len(whole)))):
        code, told, listed, count = restart(options, sheet, label, damage)
        sheet.require(code == 0 and told and not listed,
                      f"{label}: exit code {code}, the snapshot is named and left out")
        sheet.require(count == 8, f"{label}: the other snapshots stay, {count} of 9")
    code, told, listed, count = restart(options, sheet, "whole", lambda path, whole: None)
    sheet.require(code == 0 and not told and listed and count == 9, "without damage all are listed")
    chance = random.Random(SEED)
    codes, consistent = [], True
    for _ in range(FLIPS):
        def flip(path, whole):
            torn = bytearray(whole)
            for _ in range(20):
                torn[chance.randrange(len(torn))] ^= 1 << chance.randrange(8)
            path.write_bytes(bytes(torn))
        code, told, listed, _ = restart(options, sheet, "flipped", flip)
        codes.append(code)
        consistent = consistent and told != listed
    sheet.require(set(codes) == {0}, f"{FLIPS} snapshots with flipped bits: exit codes {sorted(set(codes))}")
    sheet.require(consistent, "each of them is in the series or told to be left out")
