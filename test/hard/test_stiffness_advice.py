# SPDX-License-Identifier: BSD-3-Clause
"""Advice of --check about bulk moduli that are far too high for a slow flow, and its correctness.

Would catch: advice with a wrong load (height, gravity, density, speeds, cohesion), a wrong number of steps, or for
scenes whose stiffness determines the result: elastic bodies, gases, shaken scenes, runs of few steps, a material that
is soft already.

A tank of water, 0.5 m deep, with the bulk modulus of water: the advised modulus is density times gravity times depth
over 1 %, to the two digits that are printed, plus half the square of the speed of a wall. With this modulus and under
the sudden load of its weight, the water at the floor is compressed by 1 % at rest and by up to 2 % as it oscillates,
since a linear spring under a sudden load reaches twice its static displacement: the greatest density must be between
half of that at rest and that of the oscillation, with 10 % for the shape of particles. The number of steps must be that
of the run within 10 %: the signal is c plus the speed of the material, at most sqrt(2 g H eps) = 0.3 m/s compared with
22 m/s here.
"""
# timeout: 120

import re

import case

DECK = """
&run  dimension='plane_strain' /
&grid  lo=0,0,0  hi=0.2,1,0.6  dx=0.02 /
&time  t_end=0.5 /
&effects  {gravity} /
&material  name='water'  density=1000  {bulk}  {kind} /
&region  name='water'  shape='box'  lo=0,0,0  hi=0.2,1,0.5 /
&body  name='water'  region='water'  material='water' /
&boundary  face='xlo'  type='slip' /
&boundary  face='xhi'  {wall} /
&boundary  face='zlo'  type='slip' /
&output  name='h'  kind='history'  every=100 /
&checkpoint  at_end=.false. /
"""
USUAL = {"gravity": "gravity=.true.  gravity_vector=0,0,-9.81", "bulk": "bulk=2.2e9", "kind": "elastic='none'",
         "wall": "type='slip'"}
ADVICE = re.compile(r"^stiffness  the bulk modulus of 'water', (\S+) Pa, sets the number of steps; (\S+) Pa(.*?) would "
                    r"take about (\d+) steps", re.M)
WEIGHT = 1000.0 * 9.81 * 0.5


def advised(options, name, **words):
    """Advice of --check: modulus, number of steps, and the words between; None without advice."""
    run = case.Case(options, name, DECK.format(**{**USUAL, **words}))
    run.run("--check", "--no-estimate")
    found = ADVICE.search(run.output)
    return (float(found.group(2)), int(found.group(4)), found.group(3)) if found else None


def test_stiffness_advice(options, sheet):
    """Advice for water and sand, none for other materials, and a run that follows it."""
    loads = {
        "weight": ({}, WEIGHT),
        "wall": ({"wall": "type='velocity'  velocity=-3,0,0"}, WEIGHT + 500.0 * 3.0 ** 2),
        "cohesion": ({"kind": "shear=1e9  strength_model='mu_i'  mu_s=0.4  mu_2=0.7  mu_i0=0.3  grain_diameter=1e-3  "
                      "grain_density=2500  cohesion=5e3"}, WEIGHT + 5.0e3),
    }
    for name, (words, load) in loads.items():
        found = advised(options, name, **words)
        sheet.require(found is not None, f"{name}: there is advice")
        if found:
            sheet.near(f"{name}: modulus", found[0], load / 0.01, 0.05)
            sheet.require(("shear modulus" in found[2]) == ("shear" in words.get("kind", "")),
                          f"{name}: the shear modulus is named where there is one")
    for name, words in {
            "soft": {"bulk": "bulk=4e6"}, "elastic": {"kind": "shear=1e9"}, "weightless": {"gravity": ""},
            "energy": {"bulk": "", "kind": "elastic='none'  eos_model='mie_gruneisen'  mg_c0=1500  mg_s=1.5  "
                                        "mg_gamma=0.5"}}.items():
        sheet.require(advised(options, name, **words) is None, f"{name}: no advice")
    bulk, steps, _ = advised(options, "again")
    run = case.Case(options, "followed", DECK.format(**{**USUAL, "bulk": f"bulk={bulk}"}))
    summary = run.run("-q").summary
    sheet.near("steps with the advice", summary["steps"], steps, 0.1)
    greatest = summary["extremes"]["density_max"] / 1000.0 - 1.0
    sheet.above("greatest compression", greatest, 0.005)
    sheet.below("greatest compression", greatest, 0.022)
