# SPDX-License-Identifier: BSD-3-Clause
"""Snapshots and histories do not depend on ranks and threads, and other programs can read them.

Would catch: rows in the order of ranks, parts of files written by rank, sums of the history that
depend on ranks, files that VTK does not read. The comparison is byte for byte, except for the echo of the deck with the
folder of the run.
"""
# tiers: smoke
# timeout: 600
# cores: 2

import subprocess
import sys

import case
import report

DECK = """
&run  dimension='3d'  case='fall' /
&grid  lo=0,0,0  hi=8,8,8  dx=1 /
&time  t_end=0.06 /
&material  name='rubber'  density=1000  young=1.0e6  poisson=0.3 /
&region  name='box'   shape='box'  lo=1.3,1.2,4.1  hi=7,7.2,6.6 /
&region  name='ball'  shape='sphere'  centre=4,3,2.0  radius=1.4 /
&body  name='block'  region='box'   material='rubber'  velocity=2,-6,-14 /
&body  name='ball'   region='ball'  material='rubber'  velocity=3,3,5  spin=1,2,3 /
&boundary  face='zlo'  type='stick' /
&output  name='p'  kind='particles'  count=4 /
&output  name='block'  kind='particles'  count=2  bodies='block'  precision='double'  compress=0 /
&output  name='h'  kind='history'  every=1 /
"""


def test_files(options, sheet):
    """Three combinations of ranks and threads."""
    runs = []
    for ranks, threads in ((1, 1), (2, 1), (1, 2), (3, 1)):
        run = case.Case(options, f"files_{ranks}x{threads}", DECK, ranks, threads)
        run.name, run.deck = "fall", run.deck.rename(run.folder / "fall.nml")
        runs.append(run.run("-q"))
    base = runs[0].folder
    names = sorted(path.name for path in base.iterdir()
                   if path.suffix in (".hdf", ".csv", ".series", ".h5", ".vtkhdf"))
    sheet.require(sum(name.endswith(".hdf") for name in names) == 9, f"8 snapshots and the walls in {names}")
    sheet.require(any(name.endswith("_history.csv") for name in names), "there is a history")
    snapshots = [name for name in names if name.endswith(".hdf")]
    sheet.require(len({(base / name).read_bytes() for name in snapshots}) == 9, "snapshots differ")
    lines = (base / "fall_history.csv").read_text(encoding="utf-8").splitlines()
    sheet.require(len(lines) > 10, "the history has lines")
    for run in runs[1:]:
        for name in names:
            sheet.require((run.folder / name).is_file()
                          and (run.folder / name).read_bytes() == (base / name).read_bytes(),
                          f"{name} of {run.ranks} x {run.threads} is that of 1 x 1")
        there = sorted(path.name for path in run.folder.iterdir())
        sheet.require(there == sorted(path.name for path in base.iterdir()),
                      f"the same files on {run.ranks} x {run.threads}: {there}")
    print(f"         {len(names)} files compared: {', '.join(names)}")
    series = [base / name for name in names if name.endswith(".series")]
    sheet.require(len(series) == 2, "two series")
    for path in series:
        answer = subprocess.run([sys.executable, "-m", "scree_post", "check", path],
                                cwd=case.ROOT / "python/src", stdout=subprocess.PIPE,
                                stderr=subprocess.STDOUT, text=True)
        print(answer.stdout.strip()[-400:])
        if answer.returncode == report.NOT_RUN:
            sheet.skipped(f"the readers of VTK on {path.name}", "the package vtk is not installed")
        sheet.require(answer.returncode in (0, report.NOT_RUN), f"scree-post check on {path.name}: "
                      f"{answer.returncode} {answer.stdout[-2000:]}")
