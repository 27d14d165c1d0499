# SPDX-License-Identifier: BSD-3-Clause
# tiers: smoke, full
# timeout: 300
"""A cell that deforms, with several numbers of ranks and threads, uninterrupted and stopped before and after its edges
are replaced; and a cell that does not deform, against a scene without a cell: the same digest.

Would catch a mean stress summed in the order of ranks, particles that keep their previous tiles after edges were
replaced or are lost on their way to distant ranks, edges, stage or servo missing in a checkpoint, and a cell at rest
that changes a bit.
"""

import numpy as np
import pytest

import case
import cells
import tier

LAYOUTS = tier.choose(full=((2, 1), (1, 2), (3, 1)), smoke=((2, 1), (1, 2)))
WAVES = "velocity_formula='0.3*sin(2*pi*z)','0','0.2*cos(2*pi*x)'"
RUBBER = "density=1000  young=1e5  poisson=0.3"
SERVO = """&stage  rate=0,0,0,{xy},10,{yz}  strain=1.2 /
&stage  servo='z'  rate=0,0,0,{xy},-10,0  strain=1.2  pressure=500 /
"""
PLANE = cells.scene(RUBBER, SERVO.format(xy=0, yz=0), 0.26, dx=0.0625, body=WAVES)
SPACE = cells.scene(RUBBER, SERVO.format(xy=6, yz=8), 0.26, dimension="3d", body=WAVES, tilt=0.3)
STILL = "&stage  duration=1 /"


def tables(one):
    """The bytes of the tables of a case."""
    return [one.path(ending).read_bytes() for ending in ("_cell.csv", "_history.csv")]


@pytest.mark.parametrize("name, deck", [
    ("plane", PLANE),
    pytest.param("space", SPACE, marks=pytest.mark.tiers("full")),
])
def test_layouts(options, sheet, name, deck):
    """All numbers of ranks and threads, and stops before and after the first replacement of edges, continued with other
    numbers."""
    def start(label, ranks=1, threads=1, more=(), keep=False):
        one = case.Case(options, label, deck, ranks, threads, keep=keep)
        one.name = "cell"
        return one.run("--quiet", *more, env={"OMP_WAIT_POLICY": "passive"})
    first = start(name)
    digest, steps, kept = first.summary["digest"], first.summary["steps"], tables(first)
    edge = np.diff(cells.table(first.path("_cell.csv"))["edge_xz"])
    sheet.require(np.any(edge < -0.5) and np.any(edge > 0.5), f"{name}: the cell has flipped, and back")
    for ranks, threads in LAYOUTS:
        other = start(f"{name}_{ranks}x{threads}", ranks, threads)
        text = f"{name}: {ranks} x {threads}"
        sheet.require(other.summary["digest"] == digest, f"{text}: {other.summary['digest']}, not {digest}")
        sheet.require(tables(other) == kept, f"{text}: the tables have the same bytes")
    label = f"{name}_stopped"
    start(label, 2, 1, ("--set", f"time.max_steps={steps // 5}"))
    start(label, 1, 2, ("--restart", "--set", f"time.max_steps={steps // 2}"), keep=True)
    last = start(label, 1, 1, ("--restart",), keep=True)
    sheet.require(last.summary["digest"] == digest, f"{name}: after restarts {last.summary['digest']}, not {digest}")
    rows = [text.splitlines()[-1] for text in tables(last)]
    sheet.require(rows == [text.splitlines()[-1] for text in kept], f"{name}: after restarts the same last rows")


@pytest.mark.parametrize("name, more", [
    ("elastic", {}),
    pytest.param("in_space", {"dimension": "3d"}, marks=pytest.mark.tiers("full")),
    pytest.param("line", {"dimension": "1d", "body": "velocity_formula='0.3*sin(2*pi*x)','0','0'"},
                 marks=pytest.mark.tiers("full")),
    pytest.param("splines", {"method": "mpm", "words": "basis='cubic'"}, marks=pytest.mark.tiers("full")),
    pytest.param("gas", {"material": "density=1  eos_model='ideal_gas'  ig_gamma=1.4", "effects": "strength=.false.",
                         "body": "specific_energy=2.5e3  " + WAVES}, marks=pytest.mark.tiers("full")),
])
def test_at_rest(options, sheet, name, more):
    """A cell that does not deform and a scene without a cell, by the same method."""
    words = "stress_update='usl'  transfer='flip'  flip=1  " + more.pop("words", "normalise='none'")
    digests = [cells.run(options, f"{name}_{label}", cells.scene(more.get("material", RUBBER), stages, 0.2, **{
        "body": WAVES, "words": words, **{key: more[key] for key in more if key != "material"}}))["case"].summary
        for label, stages in (("cell", STILL), ("none", None))]
    sheet.require(digests[0]["digest"] == digests[1]["digest"], f"{name}: at rest the same bits as without a cell")
    sheet.require(digests[0]["steps"] > 10, f"{name}: some steps were made")
