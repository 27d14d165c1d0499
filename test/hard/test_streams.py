# SPDX-License-Identifier: BSD-3-Clause
"""Streams that cross, a state of almost no volume, and states that require a short step.

Would catch: particles that become inverted without an error, NaN, a step that grows too fast, is not finite, or follows
the wrong limit, a run that stops without naming the particle that caused it.
"""
# timeout: 600

import numpy as np

import case

STREAMS = """
&run  dimension='plane_strain' /
&grid  lo=0,0,0  hi=24,1,12  dx=1 /
&time  t_end={end}  cfl=0.9 /
&effects  artificial_viscosity={viscous} /
&material  name='soft'  density=1000  young=1.0e6  poisson=0.3  {law} /
&region  name='left'   shape='box'  lo=3,0,3   hi=11,1,9 /
&region  name='right'  shape='box'  lo=13,0,3  hi=21,1,9 /
&body  name='left'   region='left'   material='soft'  velocity={speed},0,0 /
&body  name='right'  region='right'  material='soft'  velocity=-{speed},0,0 /
&output  name='p'  kind='particles'  every=1  precision='double'
  fields='identity','velocity','stress','volume','mass' /
&output  name='h'  kind='history'  every=1 /
&checkpoint  at_end=.false. /
"""

HOT = """
&run  dimension='plane_strain' /
&grid  lo=0,0,0  hi=24,1,24  dx=1 /
&time  t_end=1  max_steps=150 /
&effects  thermal=.true.  damage=.true. /
&material  name='al'  density=2785  eos_model='mie_gruneisen'  mg_c0=5328  mg_s=1.338  mg_gamma=2
  shear=27.6e9  specific_heat=875  damage_model='principal_stress'  failure_stress=1.0e9
  failed_as='{failed}' /
&region  name='block'  shape='box'  lo=6,0,6  hi=18,1,18 /
&region  name='spot'   shape='box'  lo=12,0,12  hi=12.5,1,12.5 /
&body  name='block'  region='block'  material='al'  velocity={speed},0,0 /
&body  name='spot'   region='spot'   material='al'  velocity={speed},0,0  specific_energy={energy} /
&boundary  face='all'  type='periodic' /
&output  name='h'  kind='history'  every=1 /
&checkpoint  at_end=.false. /
"""


def test_streams(options, sheet):
    """Two soft blocks meet far above their sound speed of 37 m/s."""
    for law in ("elastic", "neo_hookean"):
        for viscous in (".true.", ".false."):
            for speed in (30, 300):
                name = f"{law}_{viscous[1]}_{speed}"
                run = case.Case(options, name, STREAMS.format(
                    law=f"strength_model='{law}'", speed=speed, viscous=viscous,
                    end=8.0 / speed)).run("-q", expect=None)
                least, most = np.inf, 0.0
                for _, snap in run.snapshots():
                    ratio = snap.fields["volume"] * 1000.0 / snap.fields["mass"]
                    least, most = min(least, ratio.min()), max(most, ratio.max())
                table = run.history
                sheet.require(run.code in (0, 4), f"streams {name}: exit code {run.code}")
                if run.code:
                    named = "particle" in run.output and "body" in run.output
                    sheet.require(named, f"streams {name}: says who: {run.output}")
                    print(f"         streams {name}: {run.output.splitlines()[0]}")
                else:
                    sheet.require(np.isfinite(table["kinetic"]).all(), f"streams {name}: numbers")
                    sheet.above(f"streams {name}: least ratio of volumes", least, 1.0e-3)
                    sheet.below(f"streams {name}: momentum", run.summary["ledger"]["momentum_error"],
                                1.0e-12)
                sheet.require(table["dt"][1:].min() > 0.0, f"streams {name}: steps")
                sheet.note(f"streams {name}: ratios of volumes", f"{least:.3g} to {most:.3g}")
                if viscous == ".true.":
                    sheet.require(run.code == 0, f"streams {name}: with viscosity it goes on")


def test_hot_spot(options, sheet):
    """A hot spot, material that fails permanently, and a block much faster than sound."""
    for name, energy, speed, failed in (("hot", 1.0e10, 0, "rubble"), ("failed", 1.0e6, 0, "nothing"),
                                        ("fast", 0.0, 5.0e5, "rubble")):
        run = case.Case(options, f"spot_{name}", HOT.format(
            energy=energy, speed=speed, failed=failed)).run("-q")
        table, ledger = run.history, run.summary["ledger"]
        steps = table["dt"][1:]
        sheet.require(len(steps) == 150 and np.isfinite(steps).all(), f"spot {name}: finite steps")
        sheet.below(f"spot {name}: greatest growth of a step", (steps[1:] / steps[:-1]).max(),
                    1.1 + 1.0e-12)
        sheet.above(f"spot {name}: least over greatest step", steps.min() / steps.max(), 1.0e-3)
        sheet.below(f"spot {name}: momentum", ledger["momentum_error"], 1.0e-12)
        sheet.below(f"spot {name}: energy", ledger["energy_error"], 1.0e-10)
        if name == "fast":
            bound = 0.4 / (5.0e5 + 5328.0)
            sheet.below(f"spot {name}: steps over that of motion", steps.max() / bound, 1.02)


def test_near_nothing(options, sheet):
    """Material at a thousandth of its volume: it must be refused at once, because of its ratio of volumes."""
    run = case.Case(options, "ratio", STREAMS.format(
        law="strength_model='neo_hookean'", speed=30, viscous=".true.", end=0.2))
    run.run("-q", "-s", "time.volume_ratio_min=0.9", expect=4)
    sheet.require("is below volume_ratio_min" in run.output, f"ratio: says so: {run.output}")
    least = min((snap.fields["volume"] * 1000.0 / snap.fields["mass"]).min()
                for _, snap in run.snapshots()[:-1])
    sheet.above("ratio: least before the step that is refused", least, 0.9)
