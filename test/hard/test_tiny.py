# SPDX-License-Identifier: BSD-3-Clause
"""Twenty small decks in which nothing happens, decks in which all particles have left or failed, and extreme numbers.

Would catch: a division by a count, mass, speed, or volume of zero, a state that rounding changes where nothing acts,
an absolute tolerance, very small numbers that stop a run.
"""
# timeout: 120

import numpy as np

import case

DECK = """
&run  dimension='{dimension}' /
&grid  lo=0,0,0  hi=8,{width},8  dx=1 /
&time  t_end=1  max_steps=30 /
&effects  {effects} /
&material  name='al'  density=2785  {material} /
{second}
&region  name='one'  shape='box'  {region} /
&body  name='one'  region='one'  material='al'  ppc={ppc}  {body} /
&output  name='p'  kind='particles'  count=1  precision='double'
  fields='identity','velocity','stress','volume','mass'{fields} /
&output  name='h'  kind='history'  every=1 /
"""
SOLID = "young=70e9  poisson=0.33"
METAL = """eos_model='mie_gruneisen'  mg_c0=5328  mg_s=1.338  mg_gamma=2  shear=27.6e9  specific_heat=875
  strength_model='johnson_cook'  jc_a=265e6  jc_b=426e6  jc_n=0.34  jc_c=0.015  jc_m=1  t_ref=293
  t_melt=775"""
BREAKS = METAL + "  damage_model='johnson_cook'  jcd=0.13,0.13,-1.5,0.011,0"
USUAL = {"dimension": "3d", "width": 8, "effects": "", "material": SOLID, "second": "",
         "region": "lo=2,2,2 hi=5,6,7", "ppc": "2,2,2", "body": "", "fields": ""}
LONE = {"region": "lo=3,3,3 hi=4,4,4", "ppc": "1,1,1"}
HEAT = {"effects": "thermal=.true.", "material": METAL, "fields": ",'energy','temperature'"}
FAILS = {"effects": "thermal=.true. damage=.true.", "fields": ",'energy','failed'"}
SCENES = {
    "rest": {}, "rest_lone": LONE,
    "rest_1d": {"dimension": "1d"}, "lone_1d": {"dimension": "1d", **LONE},
    "rest_plane": {"dimension": "plane_strain"}, "lone_plane": {"dimension": "plane_strain", **LONE},
    "rest_axis": {"dimension": "axisymmetric", "width": 0, "region": "lo=0,0,2 hi=5,0,7"},
    "lone_axis": {"dimension": "axisymmetric", "width": 0, "region": "lo=0,0,3 hi=1,0,4",
                  "ppc": "1,1,1"},
    "zero_gravity": {"effects": "gravity=.true. gravity_vector=0,0,0"},
    "no_viscosity": {"effects": "artificial_viscosity=.false."},
    "heat": HEAT, "heat_lone": {**HEAT, **LONE},
    "fails_never": {**FAILS, "material": BREAKS},
    "unused_material": {"second": "&material  name='none'  density=1  young=1  poisson=0 /"},
    "many_points": {"region": "lo=3,3,3 hi=4,4,4", "ppc": "9,9,9"},
    "one_cell_bodies": {"second": "&region name='two' shape='box' lo=6,6,6 hi=7,7,7 /\n"
                                  "&body name='two' region='two' material='al' ppc=1,1,1 /"},
    "at_the_wall": {"region": "lo=0,0,0 hi=8,8,8",
                    "second": "&boundary face='all' type='stick' /", "ppc": "1,1,1"},
    "periodic": {"region": "lo=0,0,0 hi=8,8,8",
                 "second": "&boundary face='all' type='periodic' /", "ppc": "1,1,1"},
    "mirror": {"second": "&boundary face='all' type='symmetry' /"},
    "cold_fluid": {"material": "bulk=2e9  elastic='none'"},
}


def test_at_rest(options, sheet):
    """In twenty decks no bit changes."""
    for name, words in SCENES.items():
        run = case.Case(options, name, DECK.format(**{**USUAL, **words})).run("-q")
        (_, first), (_, last) = run.snapshots()
        sheet.require(len(first.points) > 0 and run.summary["steps"] == 30, f"{name}: makes steps")
        # the pressure of a fluid at rest is -0: adding 0 makes it 0
        same = first.points.tobytes() == last.points.tobytes() and all(
            (values + 0).tobytes() == (last.fields[key] + 0).tobytes()
            for key, values in first.fields.items())
        sheet.require(same and last.time > 0.0, f"{name}: keeps its bits")
    sheet.require(len(SCENES) == 20, "twenty decks")
    sheet.note("at rest: decks that keep their bits", len(SCENES))


def test_gone_and_failed(options, sheet):
    """All particles leave, and the run ends and states the reason; all particles fail and continue without force."""
    run = case.Case(options, "gone", DECK.format(**{**USUAL, "body": "velocity=2e4,0,0"}))
    run.run("-q", "-s", "time.t_end=2e-3", "-s", "time.max_steps=100000", "-s", "time.dt_max=1e-5")
    sheet.require(run.summary["particles"] == 0 and run.summary["reason"] == "all material has left the grid",
                  "gone: the run ends and says why")
    sheet.require(25 <= run.summary["steps"] <= 45, "gone: the run ends once the last particle has left")
    sheet.below("gone: mass", run.summary["ledger"]["mass_error"], 1.0e-14)
    broken = METAL.split("strength_model")[0] + \
        "damage_model='principal_stress'  failure_stress=1.0  failed_as='nothing'"
    run = case.Case(options, "all_failed", DECK.format(**{
        **USUAL, **FAILS, "material": broken, "second": "&boundary face='all' type='periodic' /",
        "body": "velocity=100,-200,300  spin=10,20,30"}))
    run.run("-q", "-s", "time.max_steps=200")
    last = run.snapshots()[-1][1]
    share = last.fields["failed"].mean()
    sheet.above("all failed: share that has failed", share, 0.99)
    sheet.require(np.abs(last.fields["stress"][last.fields["failed"] > 0]).max() == 0.0,
                  "all failed: no stress is left")
    sheet.below("all failed: momentum", run.summary["ledger"]["momentum_error"], 1.0e-12)
    sheet.below("all failed: energy", run.summary["ledger"]["energy_error"], 1.0e-10)


def test_ends_of_numbers(options, sheet):
    """The same block in units that make all numbers tiny or huge."""
    digits = {}
    for name, length, mass in (("unit", 1.0, 1.0), ("tiny", 2.0**-100, 2.0**-100),
                               ("huge", 2.0**60, 2.0**100), ("least", 1.0, 2.0**-500)):
        speed, end = 2.0 * length, 3.0
        deck = f"""
&run  dimension='plane_strain' /
&grid  lo=0,0,0  hi={12 * length!r},{length!r},{12 * length!r}  cells=12,1,12 /
&time  t_end={end!r}  max_steps=200 /
&material  name='soft'  density={mass / length**3!r}  young={100.0 * mass / length!r}  poisson=0.25 /
&region  name='b'  shape='box'  lo={2 * length!r},0,{2 * length!r}  hi={8 * length!r},{length!r},{7 * length!r} /
&body  name='b'  region='b'  material='soft'  velocity={speed!r},0,{-0.5 * speed!r}  spin=0,0.5,0 /
&boundary  face='all'  type='slip' /
&output  name='p'  kind='particles'  count=1  precision='double'  fields='identity','velocity','stress' /
&checkpoint  at_end=.false. /
"""
        run = case.Case(options, f"numbers_{name}", deck).run("-q", expect=None)
        sheet.require(run.code == 0, f"numbers {name}: exit code {run.code}: {run.output[-300:]}")
        if run.code:
            continue
        last = run.snapshots()[-1][1]
        order = np.argsort(last.fields["identity"])
        digits[name] = (last.points[order] / length, last.fields["velocity"][order] / speed,
                        last.fields["stress"][order] / (mass / length), run.summary["steps"])
    sheet.require(digits["unit"][3] > 100, "numbers: makes steps")
    for name in ("tiny", "huge", "least"):
        for part, mine, other in zip(("places", "velocity", "stress"), digits[name], digits["unit"]):
            scale = np.abs(other).max()
            sheet.below(f"numbers {name}: {part}", np.abs(mine - other).max() / scale, 1.0e-12)
