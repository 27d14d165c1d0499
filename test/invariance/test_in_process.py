# SPDX-License-Identifier: BSD-3-Clause
# timeout: 300
# cores: 2
"""A run in the process of Python has the bits of the program, step by step, on one rank and on two.

Would catch: a time loop of the library that differs from that of the program, state that one simulation leaves for the
next, results that depend on the positions of the particles in memory, which reading fields changes, and ranks that do
not share the run. Controls: runs make many steps, and a field that is written changes the digest.
"""

import importlib.util
import subprocess
import sys

import pytest

import case
import layouts

BLOCK = """
&run  dimension='3d' /
&grid  lo=0,0,0  hi=8,8,8  dx=1 /
&time  t_end=1  max_steps=60 /
&material  name='rubber'  density=1000  young=1.0e6  poisson=0.3 /
&region  name='box'  shape='box'  lo=4.3,4.2,4.1  hi=8,7.2,7.6 /
&region  name='ball'  shape='sphere'  centre=2,3,2.5  radius=1.4 /
&body  name='block'  region='box'   material='rubber'  velocity=-9,-6,4 /
&body  name='ball'   region='ball'  material='rubber'  velocity=12,3,-5  spin=1,2,3 /
&boundary  face='all'  type='periodic' /
&parallel  balance_every=13  imbalance=1.01 /
"""
# Runs every deck twice, the second time with access to fields; in the last run a velocity is changed.
SCRIPT = """
import sys
{communicator}
import scree
for deck in sys.argv[2:]:
    for way in ("run", "fields", "changed"):
        with scree.Simulation(deck, outdir=f"{{sys.argv[1]}}/{{way}}", case=way, overwrite=True, comm=comm) as sim:
            if way == "run":
                sim.run()
            while sim.step():
                for store in sim.stores:
                    store["velocity"] *= 1.0
                    if way == "changed" and sim.steps == 20:
                        store["velocity"][:] += 1e-9
        if sim.rank == 0:
            found = sim.finish().summary
            print("DIGEST", way, found["digest"], found["steps"], found["ranks"])
"""


def in_process(options, ranks, deck, folder, mpi4py):
    """Digests by kind of run, steps and ranks of a deck in the process of Python."""
    script = options.work / f"script_{mpi4py}.py"
    script.write_text(SCRIPT.format(communicator="from mpi4py import MPI; comm = MPI.COMM_WORLD" if mpi4py else
                                    "comm = None"), encoding="utf-8")
    words = [sys.executable, script, options.work / folder, deck]
    if ranks > 1:
        case.need_ranks(options.scree)
        words = ["mpiexec", "-n", ranks, *words]
    environment = {**case.Case(options, "unused", "", keep=True).environment, "SCREE": str(options.scree),
                   "PYTHONPATH": str(case.ROOT / "python/src"), "PYTHONDONTWRITEBYTECODE": "1"}
    answer = subprocess.run([str(word) for word in words], env=environment, text=True, timeout=200, check=False,
                            stdout=subprocess.PIPE, stderr=subprocess.STDOUT)
    if answer.returncode:
        raise AssertionError(answer.stdout[-4000:])
    rows = [line.split()[1:] for line in answer.stdout.splitlines() if line.startswith("DIGEST")]
    return {way: (digest, int(steps), int(seen)) for way, digest, steps, seen in rows}


@pytest.mark.parametrize("name", ["block", "cloud"])
def test_same_bits(options, sheet, name):
    """On one and two ranks."""
    if not (options.scree.parents[1] / "lib/libscree.so").is_file():
        pytest.skip("libscree.so is not built beside the program")
    with_mpi4py = importlib.util.find_spec("mpi4py") is not None
    if not with_mpi4py:
        sheet.skipped("communicators of mpi4py", "mpi4py is not installed; scripts/setup.sh installs it")
    deck = BLOCK if name == "block" else layouts.coarse_cloud(60)
    program = case.Case(options, name, deck).run("-q")
    for ranks, mpi4py in [(1, False), (2, with_mpi4py)]:
        found = in_process(options, ranks, program.deck, f"{name}_{ranks}_{mpi4py}", mpi4py)
        where = f"{name}, {ranks} ranks{', mpi4py' * mpi4py}"
        for way in ("run", "fields"):
            sheet.require(found[way] == (program.summary["digest"], program.summary["steps"], ranks),
                          f"{where}, {way}: {found[way]}, not that of the program, {program.summary['digest']}")
        sheet.require(found["changed"][0] != found["run"][0], f"{where}: a changed velocity changes the digest")
    sheet.require(program.summary["steps"] >= 40, f"{name}: makes many steps")
