# SPDX-License-Identifier: BSD-3-Clause
"""A run that follows an exact solution has the same bits for any ranks and threads and after a restart.

Would catch: particles that the initial displacement moves to tiles of other ranks and that arrive late, twice or not at
all; a body force that depends on the order of threads; a reference position that is lost in sorting, migration or a
checkpoint; sums of errors that depend on ranks; greatest errors and a time of the stress that a restart resets.
"""
# timeout: 200
# cores: 2

import case

DECK = """
&run  dimension='plane_strain'  method='{method}' /
&grid  lo=0,0,0  hi=1,1,1  dx=0.03125  block=4 /
&time  t_end=1  max_steps=60 /
&method  stress_update='{update}' /
&material  name='rubber'  density=20  young=2.0e5  poisson=0.3  strength_model='neo_hookean' /
&material  name='other'  density=30  young=1.0e5  poisson=0.2 /
&region  name='cube'  shape='box'  lo=0,0,0  hi=1,1,1 /
&region  name='ball'  shape='cylinder'  axis=0,1,0  centre=0.5,0.5,0.5  radius=0.1  height=2 /
&body  name='cube'  region='cube'  material='rubber'  ppc=2,1,2 /
&body  name='ball'  region='ball'  material='other'  ppc=2,1,2 /
&boundary  face='all'  type='symmetry' /
&exact  solution='axis_aligned'  amplitude=0.06  bodies='cube' /
&output  name='h'  kind='history'  every=7 /
&parallel  balance_every=13  imbalance=1.01 /
"""

LAYOUTS = ((1, 1), (2, 1), (1, 2), (3, 1))      # ranks, threads


def test_exact_bits(options, sheet):
    """Three orders of the stress update; the first run is stopped and continued."""
    for method, update in (("ddmp", "usl"), ("ddmp", "usf"), ("mpm", "musl")):
        deck = DECK.format(method=method, update=update)
        runs = []
        for ranks, threads in LAYOUTS:
            run = case.Case(options, f"{update}_{ranks}x{threads}", deck, ranks, threads).run("-q")
            runs.append(run)
            sheet.require(run.summary["digest"] == runs[0].summary["digest"],
                          f"{update}: digest of {ranks} x {threads} is that of 1 x 1")
            sheet.require(run.path("_history.csv").read_bytes()
                          == runs[0].path("_history.csv").read_bytes(),
                          f"{update}: history of {ranks} x {threads} is that of 1 x 1")
            sheet.require(run.summary["exact"] == runs[0].summary["exact"],
                          f"{update}: errors of {ranks} x {threads} are those of 1 x 1")
        first = runs[0].summary
        sheet.require(first["steps"] == 60, f"{update}: makes its steps")
        error = runs[0].history["displacement_error"]
        sheet.require(error[0] < 1.0e-15 < error[-1], f"{update}: leaves the solution in the end")
        print(f"         {update}: {first['digest']}, {first['particles']} particles, "
              f"error {error[-1]:.2e} m")
        stopped = case.Case(options, f"{update}_restart", deck, 2, 1)
        stopped.run("-q", "-s", "time.max_steps=31")
        stopped.ranks, stopped.threads = 1, 2
        stopped.run("-q", "--restart")
        sheet.require(stopped.summary["digest"] == first["digest"], f"{update}: restart, digest")
        sheet.require(stopped.summary["exact"] == first["exact"], f"{update}: restart, errors")
    free = case.Case(options, "free", DECK.format(method="ddmp", update="usl")
                     .replace("amplitude=0.06", "amplitude=0.060000000001")).run("-q")
    sheet.require(free.summary["digest"] != case.Case(options, "usl_1x1", "", keep=True)
                  .summary["digest"], "another amplitude gives another digest")
