#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Measure how a run scales with its ranks, and write the report.

    build/venv/bin/python scripts/scaling.py --work scaling                      # 1 to 512 ranks on this machine
    build/venv/bin/python scripts/scaling.py --work scaling --quick              # 1 to 32 ranks, a minute
    build/venv/bin/python scripts/scaling.py --work scaling --launcher 'srun -n {ranks} -c {threads}' \\
        --layouts 1x16,8x16,64x16,512x16 --edge 12 --ppc 2 --steps 100 --repeat 3

Weak scaling: a periodic elastic block with the same number of tiles for each rank. Strong scaling: a ball that flies
and spins, the same for all ranks; its digest must not depend on them. Work, messages, bytes, collective calls and
memory of the ranks are counted by the program, so they can be compared on fewer cores than ranks; times are compared
where every thread has a core, or a launcher starts the ranks. Output in the work folder: scaling.md, scaling.csv and
figures.
"""
import argparse
import json
import math
import os
import subprocess
import sys
from pathlib import Path

import scaling_report
from scaling_model import TILE_CELLS

ROOT = Path(__file__).resolve().parents[1]
LAYOUTS = "1x1,2x1,4x1,8x1,16x1,32x1,64x1,128x1,256x1,512x1"
QUICK = "1x1,2x1,8x1,32x1"
# By default Open MPI refuses to run as root and to start more ranks than cores, and binds all threads of a rank to one
# core. With hundreds of ranks per core, mpiexec of Open MPI 4 can miss that a rank has called MPI_Finalize and then
# reports an error; a rank that fails is still recognised by its exit code.
OPEN_MPI = {"OMPI_MCA_rmaps_base_oversubscribe": "1", "PRTE_MCA_rmaps_default_mapping_policy": ":oversubscribe",
            "OMPI_MCA_hwloc_base_binding_policy": "none",
            "OMPI_MCA_btl_vader_single_copy_mechanism": "none", "OMPI_MCA_mpi_yield_when_idle": "1",
            "OMPI_MCA_orte_allowed_exit_without_sync": "1",
            "OMP_WAIT_POLICY": "passive"}
HEAD = """
&run  dimension='3d'  method='{method}' /
&time  t_end=1.0e9  max_steps={steps} /
&method  {words} /
&material  name='rubber'  density=1000  young=1.0e6  poisson=0.3 /
&boundary  face='all'  type='periodic' /
&output  name='h'  kind='history'  every=1000000 /
&checkpoint  at_end=.false. /
&log  progress_seconds=1000 /
"""
BLOCK = HEAD + """
&grid  lo=0,0,0  hi={cells[0]},{cells[1]},{cells[2]}  dx=1 /
&region  name='box'  shape='box'  lo=0,0,0  hi={cells[0]},{cells[1]},{cells[2]} /
&body  name='block'  region='box'  material='rubber'  velocity=3,-2,1  ppc={ppc},{ppc},{ppc} /
"""
BALL = HEAD + """
&grid  lo=0,0,0  hi={box},{box},{box}  dx=1 /
&region  name='ball'  shape='sphere'  centre={centre},{centre},{centre}  radius={radius} /
&body  name='ball'  region='ball'  material='rubber'  velocity=3,-2,1  spin=0.5,0.2,0.1  ppc={ppc},{ppc},{ppc} /
"""


def factors(number):
    """Three factors of a number in descending order that differ as little as possible."""
    best = (number, 1, 1)
    for least in range(1, round(number ** (1.0 / 3.0)) + 1):
        for middle in range(least, math.isqrt(number // least) + 1):
            if number % (least * middle) == 0:
                best = min(best, (number // (least * middle), middle, least))
    return best


def words_of(options, method):
    """Keys of &method; without any, the update with the fewest exchanges, whose messages the model counts."""
    return options.method_words or ("stress_update='usl'" if method == "ddmp" else "")


def block_deck(options, method, cells):
    """Deck of the periodic block with numbers of cells along its edges."""
    return BLOCK.format(method=method, cells=cells, steps=options.steps, words=words_of(options, method),
                        ppc=options.ppc)


def weak_deck(options, method, workers):
    """A block that gives each worker a cube of `edge` tiles along its edges."""
    return block_deck(options, method, [TILE_CELLS * options.edge * n for n in factors(workers)])


def ball_deck(options, method):
    """A ball in the middle of a box."""
    box = TILE_CELLS * math.ceil((2 * options.radius + 8) / TILE_CELLS)
    return BALL.format(method=method, box=box, centre=box / 2, radius=options.radius, steps=options.steps,
                       words=words_of(options, method), ppc=options.ppc)


def launcher(options, ranks, threads):
    """The command that starts a number of ranks, as a list of words."""
    if options.launcher:
        words = options.launcher.format(ranks=ranks, threads=threads).split()
        return words if "{ranks}" in options.launcher else [*words, "-n", str(ranks)]
    if ranks == 1:
        return []
    # Ranks that wait poll, so with hundreds of them on few cores mpiexec would get little time to start them.
    low_priority = ["nice", "-n", "19"] if ranks * threads > (os.cpu_count() or 1) else []
    return ["mpiexec", "-n", str(ranks), *low_priority]


def environment(threads):
    """Environment of a run: that of the user, with the settings of Open MPI for more ranks than cores."""
    variables = {**OPEN_MPI, **os.environ, "OMP_NUM_THREADS": str(threads)}
    if os.geteuid() == 0:
        variables.update(OMPI_ALLOW_RUN_AS_ROOT="1", OMPI_ALLOW_RUN_AS_ROOT_CONFIRM="1")
    return variables


def run(options, deck, ranks, threads, name):
    """Make one run in a folder of this name. Returns its summary."""
    folder = options.work / name
    folder.mkdir(parents=True, exist_ok=True)
    path, result = folder / "case.nml", folder / "case.summary.json"
    if options.resume and result.exists() and path.read_text(encoding="utf-8") == deck:
        return json.loads(result.read_text(encoding="utf-8"))
    path.write_text(deck, encoding="utf-8")
    command = [*launcher(options, ranks, threads), str(options.scree), "-q", "--overwrite", "--case", "case",
               "--outdir", str(folder), str(path)]
    answer = subprocess.run(command, env=environment(threads), text=True, stdout=subprocess.PIPE,
                            stderr=subprocess.STDOUT)
    if answer.returncode != 0:
        sys.exit(f"scaling: {' '.join(command)} ended with exit code {answer.returncode}:\n{answer.stdout[-2000:]}")
    return json.loads(result.read_text(encoding="utf-8"))


def has_cores(options, ranks, threads):
    """True if times are meaningful: every thread has a core, or a launcher places the ranks."""
    return bool(options.launcher) or ranks * threads <= os.cpu_count()


def measure(options, method, kind, layouts):
    """Rows of the report for one kind of scaling; times are medians of alternating runs."""
    found, rates = {}, {layout: [] for layout in layouts}
    for repeat in range(options.repeat):
        for ranks, threads in layouts:
            if repeat > 0 and not has_cores(options, ranks, threads):
                continue
            print(f"scaling: {method} {kind}, {ranks} x {threads}, run {repeat + 1}", file=sys.stderr, flush=True)
            deck = weak_deck(options, method, ranks * threads) if kind == "weak" else ball_deck(options, method)
            found[ranks, threads] = run(options, deck, ranks, threads, f"{method}_{kind}_{ranks}x{threads}")
            if has_cores(options, ranks, threads):
                rates[ranks, threads].append(found[ranks, threads]["particle_updates_per_s"])
    return [scaling_report.row(method, kind, found[layout], rates[layout], options.edge ** 3 * layout[1])
            for layout in layouts]


def arguments():
    """The options of the command."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--scree", type=Path, default=ROOT / "build/bin/scree", help="the program")
    parser.add_argument("--work", type=Path, default=Path("scaling"), help="folder for runs and report")
    parser.add_argument("--layouts", help=f"ranks x threads, by default {LAYOUTS}")
    parser.add_argument("--quick", action="store_true", help=f"the layouts {QUICK}")
    parser.add_argument("--methods", default="ddmp", help="of ddmp and mpm, separated by commas")
    parser.add_argument("--kinds", default="weak,strong")
    parser.add_argument("--edge", type=int, default=2, help="tiles along the edge of the cube of a rank, weak scaling")
    parser.add_argument("--radius", type=float, default=27.0, help="radius of the ball in cells, strong scaling")
    parser.add_argument("--ppc", type=int, default=1, help="particles along each edge of a cell")
    parser.add_argument("--steps", type=int, default=10)
    parser.add_argument("--repeat", type=int, default=1, help="runs of the layouts whose threads all have cores")
    parser.add_argument("--resume", action="store_true", help="keep the runs in the work folder that have ended")
    parser.add_argument("--launcher", help="command that starts the ranks; {ranks} and {threads} are replaced")
    parser.add_argument("--method-words", default="", help="keys of &method, such as \"flip=1.0\"")
    options = parser.parse_args()
    options.scree, options.work = options.scree.resolve(), options.work.resolve()
    options.layouts = options.layouts or (QUICK if options.quick else LAYOUTS)
    return options


def main():
    """Measure, and write the report."""
    options = arguments()
    layouts = [tuple(map(int, word.split("x"))) for word in options.layouts.split(",")]
    options.work.mkdir(parents=True, exist_ok=True)
    rows = []
    for method in options.methods.split(","):
        for kind in options.kinds.split(","):
            rows += measure(options, method, kind, layouts)
            scaling_report.write(options.work, rows, f"particles per cell: {options.ppc ** 3}, steps: {options.steps}")
    print((options.work / "scaling.md").read_text(encoding="utf-8"), end="")
    if scaling_report.differing_digests(rows):
        sys.exit("scaling: the digest of the ball depends on the ranks")


if __name__ == "__main__":
    main()
