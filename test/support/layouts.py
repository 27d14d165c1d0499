# SPDX-License-Identifier: BSD-3-Clause
"""One deck on many combinations of ranks and threads, with and without load balancing, uninterrupted and restarted.

Every run must end in the state of one rank with one thread, to the last bit.
"""

import itertools
import re

import case

CLOUD_STEPS, COLUMN_STEPS, BAR_STEPS, BLOCK_STEPS = 60, 60, 90, 50

COLUMN = f"""
&run  dimension='plane_strain' /
&grid  lo=0,0,0  hi=0.8,1,0.4  dx=0.01 /
&time  t_end=1  max_steps={COLUMN_STEPS} /
&effects  gravity=.true. /
&material  name='grains'  density=1500  young=1.0e6  poisson=0.3  strength_model='drucker_prager'
  friction_angle=30  cohesion=0 /
&region  name='column'  shape='box'  lo=0,0,0  hi=0.2,1,0.3 /
&body  name='column'  region='column'  material='grains'  ppc=3,1,3  velocity=2,0,0 /
&boundary  face='xlo'  type='symmetry' /
&boundary  face='zlo'  type='stick' /
"""

BAR = f"""
&run  dimension='1d' /
&grid  lo=0,0,0  hi=600,1,1  dx=0.25 /
&time  t_end=1  max_steps={BAR_STEPS} /
&material  name='rubber'  density=1000  young=1.0e6  poisson=0.3 /
&region  name='left'   shape='box'  lo=3,0,0   hi=250,1,1 /
&region  name='right'  shape='box'  lo=250,0,0  hi=500,1,1 /
&body  name='left'   region='left'   material='rubber'  ppc=2,1,1  velocity=9,0,0 /
&body  name='right'  region='right'  material='rubber'  ppc=3,1,1  velocity=-3,0,0 /
"""

BLOCKS = f"""
&run  dimension='plane_strain' /
&grid  lo=0,0,0  hi=0.8,1,0.4  dx=0.01 /
&time  t_end=1  max_steps={BLOCK_STEPS} /
&effects  contact=.true. /
&material  name='m'  density=1000  young=1.0e6  poisson=0.3 /
&region  name='a'  shape='box'     lo=0.1,0,0.1  hi=0.4,1,0.3 /
&region  name='b'  shape='box'     lo=0.4,0,0.1  hi=0.6,1,0.25 /
&region  name='c'  shape='sphere'  centre=0.42,0,0.34  radius=0.05 /
&body  name='a'  region='a'  material='m'  ppc=2,1,2  velocity=2,0,0.5 /
&body  name='b'  region='b'  material='m'  ppc=3,1,2  velocity=-3,0,0 /
&body  name='c'  region='c'  material='m'  ppc=2,1,2  velocity=0,0,-4 /
&contact  friction=0.3 /
&contact  bodies='a','b'  law='bonded'  bond_strength=3.0e4  friction=0.1 /
"""

BALANCE = {
    "on": "&parallel  balance='auto'  balance_every=7  imbalance=1.01 /\n",
    "off": "&parallel  balance='never' /\n",
}


def coarse_cloud(steps):
    """The debris cloud with cells of twice the size, few particles and few steps."""
    text = (case.ROOT / "input/debris_cloud/scene.nml").read_text(encoding="utf-8")
    for old, new in ((r"dx *= *0\.155", "dx = 0.31"), (r"ppc *= *3, *1, *3", "ppc = 2,1,2"),
                     (r"t_end *= *20\.0", f"t_end = 20.0  max_steps = {steps}"),
                     (r"dt *= *1\.0 *\n", "count = 1\n")):
        text, count = re.subn(old, new, text)
        assert count, old
    return text


def decks():
    """Name, deck and number of steps."""
    return (("cloud", coarse_cloud(CLOUD_STEPS), CLOUD_STEPS), ("column", COLUMN, COLUMN_STEPS),
            ("bar", BAR, BAR_STEPS), ("blocks", BLOCKS, BLOCK_STEPS))


class Matrix:
    """One deck in one folder; counts the runs."""

    def __init__(self, options, sheet, name, deck, steps):
        self.options, self.sheet, self.name, self.deck, self.steps = (
            options, sheet, name, deck, steps)
        self.runs = 0
        first = self.new("first", 1, 1, "off").run("-q").summary
        self.digest = first["digest"]
        sheet.require(first["steps"] == steps, f"{name}: makes {steps} steps")
        self.moved = 0

    def new(self, word, ranks, threads, balance):
        """A run in a separate folder; the case has the same name in all of them."""
        run = case.Case(self.options, f"{self.name}_{word}", self.deck + BALANCE[balance],
                        ranks, threads)
        run.name, run.deck = self.name, run.deck.rename(run.folder / f"{self.name}.nml")
        self.runs += 1
        return run

    def whole(self, ranks, threads, balance):
        """An uninterrupted run."""
        run = self.new("whole", ranks, threads, balance).run("-q")
        self.compare(run, f"{ranks} x {threads}, balance {balance}")
        self.moved += run.summary.get("traffic", {}).get("tiles_sent", 0)

    def stopped(self, step, before, after, balance):
        """A run that is stopped at a step with some ranks and threads, and continued with others."""
        run = self.new("stopped", *before, balance).run("-q", "-s", f"time.max_steps={step}")
        self.sheet.require(run.summary["digest"] != self.digest, f"{self.name}: {step} is not the end")
        kept = {path: path.read_bytes() for path in run.folder.glob("*_chk_*.h5")}
        for ranks, threads in after:
            for path in run.folder.glob("*_chk_*.h5"):
                path.unlink()
            for path, content in kept.items():
                path.write_bytes(content)
            run.ranks, run.threads = ranks, threads
            run.run("-q", "--restart")
            self.runs += 1
            self.compare(run, f"step {step} of {before[0]} x {before[1]}, then {ranks} x {threads},"
                         f" balance {balance}")

    def compare(self, run, text):
        """Check that the last state is that of one rank and thread."""
        found = run.summary["digest"]
        self.sheet.require(found == self.digest,
                           f"{self.name}: {text}: {found}, not {self.digest}")
        self.sheet.require(run.summary["steps"] == self.steps, f"{self.name}: {text}: all steps")


def run_few(options, sheet):
    """The smallest deck with four combinations of ranks and threads, with load balancing, and one restart with another
    combination."""
    name, deck, steps = next(row for row in decks() if row[0] == "bar")
    matrix = Matrix(options, sheet, name, deck, steps)
    for ranks, threads in ((2, 1), (1, 2), (3, 1)):
        matrix.whole(ranks, threads, "on")
    matrix.stopped(steps // 3, (2, 1), ((1, 2),), "on")
    sheet.require(matrix.moved > 0, f"{name}: tiles moved between ranks")
    print(f"         {name}: {matrix.digest} in {matrix.runs} runs, {matrix.moved} tiles moved", flush=True)


def run_all(options, sheet, ranks, threads, restarts):
    """All decks for all combinations of ranks, threads and load balancing; `restarts` selects which of the stops at the
    first, a middle and the last but one step are made."""
    grid = list(itertools.product(ranks, threads))
    for name, deck, steps in decks():
        matrix = Matrix(options, sheet, name, deck, steps)
        for (rank, thread), balance in itertools.product(grid, BALANCE):
            matrix.whole(rank, thread, balance)
        stops = (1, steps // 3, steps - 1)
        for index in restarts:
            for number, balance in enumerate(BALANCE):
                matrix.stopped(stops[index], grid[(3 * index + number) % len(grid)], grid, balance)
        sheet.require(matrix.moved > 0, f"{name}: tiles moved between ranks")
        print(f"         {name}: {matrix.digest} in {matrix.runs} runs, {matrix.moved} tiles moved",
              flush=True)
