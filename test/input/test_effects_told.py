# SPDX-License-Identifier: BSD-3-Clause
# tiers: smoke
"""`scree --check` and the log list the effects and models that are on, and whether the deck or a default sets them; the
timing table has their rows.

Would catch: an effect that is on and not listed, one that is listed and off, a default that is reported as a choice of
the deck, the models of another material, a log with less information than the check, a row of the timing table for an
effect that is off, one without time for an effect that is on, and a speed that is not updates over time.
"""

import case

DECK = """
&run  dimension='plane_strain' /
&grid  lo=0,0,0  hi=4,1,4  dx=1 /
&time  t_end=1  max_steps=1 /
&effects  {effects} /
&material  name='metal'  density=1000  bulk=1.0e6  shear=5.0e5  {metal} /
&material  name='water'  density=1000  bulk=1.0e6  {water} /
&region  name='a'  shape='box'  lo=0,0,0  hi=2,1,1 /
&region  name='b'  shape='box'  lo=0,0,2  hi=2,1,3 /
&body  name='a'  region='a'  material='metal' /
&body  name='b'  region='b'  material='water' /
&checkpoint  at_end=.false. /
"""
ALL = ("damage=.true. size_scatter=.true. voids=.true. thermal=.true. melting=.true. gravity=.true. erosion=.true. "
       "damping=1")
METAL = ("strength_model='von_mises' yield=1e3 damage_model='principal_stress' failure_stress=1e5 weibull_m=7 "
         "weibull_volume=1 specific_heat=500 t_melt=900 conductivity=10")
ROWS = ("strength", "eos", "voids", "damage", "thermal", "artificial_viscosity", "heat conduction", "contact")
PHASES = ("sort, move tiles", "points to nodes", "exchange", "waiting for ranks", "grid", "nodes to points")
ON = (ROWS[:2] + ROWS[5:6], ROWS[:2], ROWS[:7], ROWS[:2] + ROWS[5:6] + ROWS[7:])   # of the decks
CASES = (  # effects, metal, water, lines
    ("", "", "elastic='none'", ["effects    by default: strength, eos, artificial_viscosity, rate",
     "           metal: strength_model elastic (default), eos_model linear (default)",
     "           water: eos_model linear (default)"]),
    ("artificial_viscosity=.false. gravity=.true. eos=.true.", "strength_model='neo_hookean'", "elastic='none'",
     ["effects    by the deck: gravity, eos; by default: strength, rate",
      "           metal: strength_model neo_hookean, eos_model linear (default)"]),
    (ALL, METAL, "elastic='none' specific_heat=4000 eos_model='tait' tait_n=7 t_melt=373",
     ["effects    by the deck: gravity, damping, erosion, damage, size_scatter, voids, thermal, melting; by "
      "default: strength, eos, artificial_viscosity, rate", "           metal: strength_model von_mises, eos_model "
      "linear (default), damage_model principal_stress, conductivity on", "eos_model tait"]),
    ("contact=.true. damping=0 rate=.true.", "", "elastic='none'",
     ["effects    by the deck: contact, rate; by default: strength, eos, artificial_viscosity\n",
      "method     ddmp, transfer rflip (default), stress_update usavg (default), quadrature point (default), "
      "viscosity_limiter smooth (default)\n"]),
)


def test_effects_told(options, sheet):
    """Each deck with the check and with the log."""
    for number, (effects, metal, water, lines) in enumerate(CASES):
        run = case.Case(options, f"told_{number}", DECK.format(effects=effects, metal=metal, water=water))
        told = run.run("--check", "--no-estimate").output
        run.run("-q")
        logged = run.path(".log").read_text(encoding="utf-8")
        for line in lines:
            sheet.require(line in told, f"deck {number}: the check tells '{line}': {told}")
            sheet.require(line in logged, f"deck {number}: the log tells '{line}'")
        timers = run.summary["timers"]
        rows = tuple(row for row in ROWS if row in timers)
        sheet.require(rows == ON[number], f"deck {number}: rows of effects {rows}, on are {ON[number]}")
        for row in rows:
            sheet.require(timers[row]["avg"] > 0.0, f"deck {number}: {row} took some time")
        spent = sum(timers[row]["max"] for row in (*PHASES, *rows))
        sheet.near(f"deck {number}: rate times the time of the steps over the updates",
                   run.summary["particle_updates_per_s"] * spent / run.summary["particle_updates"], 1.0, 1.0e-6)
