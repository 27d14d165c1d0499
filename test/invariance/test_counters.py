# SPDX-License-Identifier: BSD-3-Clause
# tiers: smoke
"""Counters at the limits of their types: a run that has made 2^31, 10^10 or 2^53 steps continues like one that has made
ten.

Would catch: a step counter that overflows at 2^31, or loses steps in a single-precision number or a narrow column; a
schedule, a load balance or a file name that depends on the size of a counter.

No run makes so many steps: the counter in a checkpoint is set to the large number, its hashes and its seal are computed
again as in src/base/base_hash.f90 and src/io/io_seal.f90 (which also tests these against another implementation), and
the run continues. Its particles must be those of the run with the unchanged counter, to the last bit.

Numbers far below the smallest normal number must change nothing and must not slow down a step: see the last part.
"""

import shutil
import struct

import h5py
import numpy as np

import case

DECK = """
&run  dimension='1d' /
&grid  lo=0,0,0  hi=1,1,1  dx=0.1 /
&time  t_end=3e-4  dt_fixed=1e-5 /
&material  name='metal'  density=2700  young=70e9  poisson=0.3 /
&region  name='bar'   shape='box'  lo=0.1,0,0  hi=0.5,1,1 /
&region  name='dust'  shape='box'  lo=0.8,0,0  hi=0.9,1,1 /
&body  name='one'   region='bar'   material='metal'  velocity=1,0,0 /
&body  name='dust'  region='dust'  material='metal'  velocity={dust},0,0 /
&output  name='h'  kind='history'    every=10 /
&output  name='p'  kind='particles'  every=10  precision='double'  fields='identity','velocity','stress','volume' /
&parallel  balance_every=5 /
&checkpoint  dt=1e-4  keep=0 /
"""
ONE = (1 << 64) - 1
GOLDEN, FIRST, SECOND = 0x9E3779B97F4A7C15, 0xBF58476D1CE4E5B9, 0x94D049BB133111EB
SEAL = 48


def mix(bits):
    """The finaliser of splitmix64 (G. L. Steele and others, OOPSLA 2014)."""
    bits = (bits + GOLDEN) & ONE
    bits = ((bits ^ (bits >> 30)) * FIRST) & ONE
    bits = ((bits ^ (bits >> 27)) * SECOND) & ONE
    return bits ^ (bits >> 31)


def word(number):
    """Bits of a number as an integer."""
    return struct.unpack("<Q", struct.pack("<d", number))[0]


def reseal(path, seal, step):
    """Set the step counter in a checkpoint, and seal the file again."""
    path.write_bytes(path.read_bytes()[:-SEAL])
    with h5py.File(path, "r+") as file:
        root = file.attrs
        root.modify("step", np.array(step, dtype=np.int64))
        time, dt = (float(np.ravel(root[key])[0]) for key in ("time", "dt_next"))
        check = mix(mix(mix(step) ^ word(time)) ^ word(dt))
        name = next(key for key in root if key.startswith("check"))
        root.modify(name, np.array(check, dtype=np.uint64).astype(np.int64))
    body = path.read_bytes()
    padded = body + bytes(-len(body) % 8)
    words = struct.unpack(f"<{len(padded) // 8}Q", padded)
    total = sum(mix(mix(place + 1) ^ value) for place, value in enumerate(words))
    digest = mix((total + mix(len(body))) & ONE)
    path.write_bytes(body + seal[:SEAL - 17] + f"{digest:016x}\n".encode("ascii"))


def test_counters(options, sheet):
    """Counters, then very small numbers."""
    right = case.Case(options, "right", DECK.format(dust=0)).run("-q")
    last = right.snapshots()[-1][1]
    for step in (10, 2**31 - 5, 2**31, 10**10, 2**53 - 25):
        run = case.Case(options, "great", DECK.format(dust=0))
        source = sorted(right.folder.glob("right_chk_*.h5"))[0]
        target = run.path("_chk_0001.h5")
        shutil.copy(source, target)
        reseal(target, source.read_bytes()[-SEAL:], step)
        run.run("--restart", expect=None)
        sheet.require(run.code == 0, f"{step} steps: exit code {run.code} {run.output[-300:] if run.code else ''}")
        if run.code:
            continue
        sheet.require(run.summary["steps"] == step + 20, f"{step} steps: {run.summary['steps']} at the end")
        found = run.snapshots()[-1][1]
        same = all(np.array_equal(found.fields[name], last.fields[name]) for name in last.fields)
        sheet.require(same, f"{step} steps: all bits of the particles are those of the run not touched")
        sheet.require(int(run.history["step"][-1]) == step + 20, f"{step} steps: the history has them all")


def test_tiny(options, sheet):
    """Velocities at the smallest normal number, and stresses that fall below it."""
    words = []
    for dust in (0, 1e-300, 1e-306):
        run = case.Case(options, f"dust_{dust}", DECK.format(dust=dust)).run("-q")
        found = run.snapshots()[-1][1]
        bar = found.points[:, 0] < 0.7
        words.append((run.summary["steps"], found.fields["velocity"][bar].tobytes(),
                      found.fields["stress"][bar].tobytes()))
        sheet.below(f"dust of {dust} m/s: its speed afterwards",
                    float(np.abs(found.fields["velocity"][~bar]).max()), 1.0e-300)
    sheet.require(words[0] == words[1] == words[2],
                  "dust at 1e-300 and 1e-306 m/s changes no bit and no step of another body")
