# SPDX-License-Identifier: BSD-3-Clause
"""Particles that leave their bounds, or fail, are removed, and the balances still close.

Would catch: removed particles that are recorded twice, not at all, or in the row of the outflow; a count that depends
on ranks or threads or is lost in a restart; particles that are named or limit the step after their removal; a NaN that
does not stop the run; a run that continues with most of its mass removed.
"""
# timeout: 120

import numpy as np

import case

# Soft blocks meet far above their sound speed, off centre, with no resistance but their stress.
STREAMS = """
&run  dimension='plane_strain'  method='{method}' /
&grid  lo=0,0,0  hi=24,1,12  dx=1 /
&time  t_end=0.05  cfl=0.9  {time} /
&effects  artificial_viscosity=.false.  thermal={thermal} /
&material  name='soft'  density=1000  {matter} /
&region  name='left'   shape='box'  lo=3,0,3   hi=11,1,9 /
&region  name='right'  shape='box'  lo=13,0,4  hi=21,1,10 /
&body  name='left'   region='left'   material='soft'  velocity=300,0,20 /
&body  name='right'  region='right'  material='soft'  velocity=-300,0,0 /
&output  name='p'  kind='particles'  count=2  precision='double'
  fields='identity','velocity','stress','volume','mass' /
&output  name='h'  kind='history'  every=1 /
&checkpoint  {checkpoint} /
"""
ELASTIC = "young=1.0e6  poisson=0.3  strength_model='elastic'"
HOT = ("eos_model='mie_gruneisen'  mg_c0=35  mg_s=0.1  mg_gamma=2  shear=4.0e5  specific_heat=875"
       "  strength_model='elastic'")

# A brittle bar that is torn apart.
TORN = """
&run  dimension='plane_strain' /
&grid  lo=0,0,0  hi=40,1,8  dx=1 /
&time  t_end=0.02 /
&effects  damage=.true.  thermal=.true.  erosion={erosion} /
&material  name='glass'  density=2500  eos_model='mie_gruneisen'  mg_c0=1000  mg_s=1.3  mg_gamma=1
  shear=1.0e9  specific_heat=800  strength_model='elastic'  damage_model='principal_stress'
  failure_stress=2.0e7 /
&region  name='left'   shape='box'  lo=10,0,2  hi=20,1,6 /
&region  name='right'  shape='box'  lo=20,0,2  hi=30,1,6 /
&body  name='left'   region='left'   material='glass'  velocity=-20,0,3 /
&body  name='right'  region='right'  material='glass'  velocity=20,0,3 /
&output  name='p'  kind='particles'  count=2  precision='double'  fields='identity','mass','failed' /
&output  name='h'  kind='history'  every=1 /
&checkpoint  {checkpoint} /
"""


def books(sheet, name, run, energy):
    """The balances close, with separate entries for removed particles. The entries at the end."""
    ledger = run.summary["ledger"]
    for what, limit in (("mass", 1.0e-14), ("momentum", 1.0e-12), ("energy", energy)):
        sheet.below(f"{name}: error of {what}", ledger[f"{what}_error"], limit)
    return ledger["end"]


def test_streams(options, sheet):
    """Streams whose particles become inverted."""
    for name, matter, thermal, energy in (("elastic", ELASTIC, ".false.", 1.0),
                                          ("hot", HOT, ".true.", 1.0e-12)):
        for method in ("ddmp", "mpm"):
            label = f"{name}_{method}"
            deck = STREAMS.format(method=method, time="{time}", matter=matter, thermal=thermal,
                                  checkpoint="at_end=.false.")
            bad = case.Case(options, f"{label}_stop", deck.format(time="")).run("-q", expect=4)
            sheet.require("volume_ratio" in bad.output or "inside out" in bad.output,
                          f"{label}: it is for the volume: {bad.output}")
            run = case.Case(options, f"{label}_go", deck.format(
                time="on_bad='retire' retire_max=0.5")).run("-q")
            ledger = books(sheet, label, run, energy)
            number = len(run.snapshots()[0][1].fields["mass"])
            each = run.summary["ledger"]["start"]["mass"] / number
            gone = number - run.summary["particles"]
            sheet.above(f"{label}: particles taken out", ledger["removed_particles"], 1)
            sheet.require(ledger["removed_particles"] <= gone, f"{label}: {gone} are gone")
            sheet.near(f"{label}: their mass [kg]", ledger["removed_mass"],
                       ledger["removed_particles"] * each, 1.0e-12)
            sheet.near(f"{label}: what left the box [kg]", ledger["lost_mass"] + 1.0,
                       (gone - ledger["removed_particles"]) * each + 1.0, 1.0e-12)
            table = run.history
            sheet.require((np.diff(table["removed_mass"]) >= 0.0).all(), f"{label}: history")
            sheet.require(table["dt"][1:-1].min() > 1.0e-3 * table["dt"].max(), f"{label}: steps")


def test_layouts(options, sheet):
    """The same bits for any ranks and threads and after a restart; the end by retire_max."""
    deck = STREAMS.format(method="ddmp", matter=HOT, thermal=".true.", checkpoint="at_end=.true.",
                          time="on_bad='retire' retire_max={most}")
    runs = [case.Case(options, f"layout_{ranks}_{threads}", deck.format(most=0.5), ranks,
                      threads).run("-q") for ranks, threads in ((1, 1), (1, 2), (3, 1))]
    digests = [run.summary["digest"] for run in runs]
    sheet.require(len(set(digests)) == 1, f"layouts: one digest: {digests}")
    gone = runs[0].history["removed_particles"]
    at = int(np.argmax(gone > 0.5 * gone[-1]))
    again = case.Case(options, "layout_again", deck.format(most=0.5), 2)
    again.run("-q", "-s", f"time.max_steps={at}")
    sheet.require(0 < again.summary["ledger"]["end"]["removed_particles"] <= gone[-1],
                  "layouts: stopped in the midst of it")
    again.run("-q", "--restart")
    sheet.require(again.summary["digest"] == digests[0], "layouts: the same after a restart")
    texts = []
    for ranks in (1, 3):
        run = case.Case(options, f"most_{ranks}", deck.format(most=1.0e-3), ranks)
        run.run("-q", expect=4)
        texts.append([line for line in run.output.splitlines() if "retire_max" in line])
    sheet.require(len(texts[0]) == 1 and texts[0] == texts[1], f"retire_max: says so: {texts}")
    print("         " + texts[0][0])


def test_not_finite(options, sheet):
    """A NaN stops the run even if particles are retired."""
    deck = STREAMS.format(method="ddmp", matter=ELASTIC, thermal=".false.", checkpoint="",
                          time="dt_fixed=0.2 dt_collapse=0 on_bad='retire' retire_max=1")
    run = case.Case(options, "not_finite", deck).run("-q", "--force", "-s", "time.volume_ratio_min=0",
                                                     "-s", "time.t_end=100", expect=None)
    sheet.require(run.code == 4 and "not a finite number" in run.output or run.code == 0
                  and run.summary["particles"] == 0, f"not finite: stops: {run.output}")


def test_erosion(options, sheet):
    """Failed particles are removed, with any ranks and threads; without the effect they remain."""
    stay = case.Case(options, "stay", TORN.format(erosion=".false.", checkpoint="")).run("-q")
    failed = stay.summary["ledger"]["end"]["failed_mass"]
    sheet.above("erosion: failed mass that stays without it [kg]", failed, 1.0)
    runs = [case.Case(options, f"erode_{ranks}", TORN.format(erosion=".true.", checkpoint=""),
                      ranks).run("-q") for ranks in (1, 2)]
    ledger = books(sheet, "erosion", runs[0], 1.0e-12)
    sheet.above("erosion: mass taken out [kg]", ledger["removed_mass"], 1.0)
    sheet.require(ledger["failed_mass"] == 0.0, "erosion: none that failed is left")
    sheet.require(ledger["retired_mass"] == 0.0, "erosion: it does not count for retire_max")
    sheet.require(runs[0].summary["digest"] == runs[1].summary["digest"], "erosion: ranks")
    before, after = (snap for _, snap in runs[0].snapshots()[::len(runs[0].snapshots()) - 1])
    sheet.near("erosion: mass in the snapshots [kg]", before.fields["mass"].sum()
               - after.fields["mass"].sum(), ledger["removed_mass"], 1.0e-12)
