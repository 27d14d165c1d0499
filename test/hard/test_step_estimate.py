# SPDX-License-Identifier: BSD-3-Clause
"""The number of steps that --check expects, compared with the number in runs: impacts at 0.5 to 15 km/s.

Would catch: an estimate from the wave speed at rest alone, which is low by a factor of up to 4 here because steps
become shorter in shocks; one that keeps the steps of a shock to the end, which is high by a factor of up to 1.9 because
shocks decay; one that assumes impacts where bodies separate or pass each other, omits the second plate, the mirror
plane or a boundary, or takes an oblique impact for a normal one; a copy with larger cells whose steps are counted
wrongly; a log or summary with another number.

Three runs end while shocks are strong; the others are those of test_impacts.py and bodies with flat ends, normal and
oblique. Target: 30 %, so that a job can be requested with the usual margin of a half. Known miss: a fast oblique box
throws jets onto the second plate before it arrives itself; held at a half, beyond which the estimate would not be
better than the first step. Bodies that separate or pass each other get the estimate of the first step, to the last
digit.
"""
# tiers: full, long
# timeout: 600

import re

from test_impacts import IMPACTS, deck

import case
import tier

EARLY = """
&run  dimension='{dimension}' /
&grid  lo={low},0,-6e-3  hi=10e-3,1,14e-3  dx=0.25e-3 /
&time  t_end={end} /
&material  name='ball'  preset='{ball}' /
&material  name='wall'  preset='{wall}' /
&region  name='ball'  shape='sphere'  centre=0,0,-2.5e-3  radius=2.5e-3 /
&region  name='wall'  shape='box'  lo={low},0,0  hi=10e-3,1,{thick} /
&body  name='ball'  region='ball'  material='ball'  ppc=2,2,2  velocity=0,0,{speed} /
&body  name='wall'  region='wall'  material='wall'  ppc=2,2,2 /
&output  name='h'  kind='history'  every=100 /
&checkpoint  at_end=.false. /
"""
STRONG = {
    "copper on steel": {"dimension": "plane_strain", "low": -1.0e-2, "end": 4.0e-6, "ball": "cu_ofhc",
                        "wall": "steel_4340", "thick": 5.0e-3, "speed": 1500},
    "aluminium on a sheet": {"dimension": "plane_strain", "low": -1.0e-2, "end": 2.0e-6, "ball": "al_2024_t351",
                             "wall": "al_2024_t351", "thick": 2.0e-3, "speed": 6000},
    "lead on copper": {"dimension": "axisymmetric", "low": 0.0, "end": 4.0e-6, "ball": "lead", "wall": "cu_ofhc",
                       "thick": 5.0e-3, "speed": 3000},
}
FLAT = """
&run  dimension='{dimension}' /
&units  system='mm-us-mg' /
&grid  lo={low},0,-12  hi=16,1,{top}  dx=0.5 /
&time  t_end={end} /
&effects  thermal=.true.  damage=.true. /
&material  name='a'  preset='{one}' /
&region  name='striker'  shape='box'  lo={left},0,{rear}  hi={right},1,-0.5 /
&body  name='striker'  region='striker'  material='a'  velocity={along},0,{down} /
{target}
&output  name='h'  kind='history'  every=100 /
&checkpoint  at_end=.false. /
"""
PLATE = """&material  name='b'  preset='{two}' /
&region  name='plate'  shape='box'  lo={low},0,0  hi=16,1,{thick} /
&body  name='plate'  region='plate'  material='b' /
&region  name='second'  shape='box'  lo={low},0,{place}  hi=16,1,{end} /
&body  name='second'  region='second'  material='b' /
"""
FACE = "&boundary  face='zhi'  type='slip' /"
# dimension, end in us, striker, half width, rear, velocity in km/s, plates (material, thickness, gap) or a boundary
FLATS = {
    "lead rod, oblique": ("plane_strain", 1.522, "lead", 1.5, -10.5, 4.893, 4.893, ("al_6061_t6", 1, 6)),
    "aluminium rod on glass": ("axisymmetric", 1.78, "al_2024_t351", 1.5, -10.5, 0, 7.99, ("glass_soda_lime", 4, 12)),
    "steel rod on copper": ("plane_strain", 16.02, "steel_4340", 1.5, -10.5, 0, 0.66, ("cu_ofhc", 2, 6)),
    "lead box on aluminium": ("plane_strain", 4.52, "lead", 2, -2.5, 0, 1.73, ("al_2024_t351", 1, 6)),
    "steel rod on a face": ("plane_strain", 0.48, "steel_4340", 1.5, -10.5, 5.42, 5.42, None),
    "steel box, oblique": ("plane_strain", 1.205, "steel_4340", 2, -2.5, 6.13, 10.617471, ("steel_4340", 1, 12)),
}
SLOW = ("al_al_5_oblique", "al_al_7_two_space", "copper_copper_8_oblique")    # in space, 10 s each
TARGET = 0.3


def flat(name):
    """The deck of a body with flat ends."""
    dimension, end, one, half, rear, along, down, plates = FLATS[name]
    low = 0 if dimension == "axisymmetric" else -16
    target, top = FACE, 0
    if plates:
        two, thick, gap = plates
        target = PLATE.format(two=two, low=low, thick=thick, place=thick + gap, end=2 * thick + gap)
        top = max(14, 2 * thick + gap + 4)
    return FLAT.format(dimension=dimension, low=low, top=top, end=end, one=one, left=max(low, -half), right=half,
                       rear=rear, along=along, down=down, target=target)


def expected(run, *words):
    """First step and number of steps that the check prints, and the number in the line `estimate`."""
    run.run("--check", *(words or ["--no-estimate"]))
    found = re.search(r"first dt (\S+) s.*; about (\d+) steps", run.output)
    line = re.search(r"estimate +about (\d+) steps; processor time .*, wall time .* on 1 rank x 1 threads", run.output)
    return float(found.group(1)), int(found.group(2)), int(line.group(1)) if line else 0


def compare(sheet, run, name):
    """An estimate and its run."""
    _, steps, _ = expected(run)
    summary = run.run("-q").summary
    error = steps / summary["steps"] - 1.0
    sheet.below(f"{name}: expected steps over those of the run, less 1", error, TARGET)
    log = (run.folder / f"{run.name}.log").read_text(encoding="utf-8")
    sheet.require(summary["steps_expected"] == steps and f"; about {steps} steps\n" in log
                  and f"steps     {summary['steps']} (estimate at the start {steps}), limited by" in log,
                  f"{name}: check, log and summary have the same number")


def test_step_estimate(options, sheet):
    """Impacts, and the same bodies moving apart."""
    for name, words in STRONG.items():
        compare(sheet, case.Case(options, name.replace(" ", "_"), EARLY.format(**words)), name)
        words = {**words, "speed": -words["speed"]}
        first, steps, _ = expected(case.Case(options, "apart", EARLY.format(**words)))
        sheet.require(abs(steps - words["end"] / first) < 1.0 + 5.0e-4 * steps,
                      f"{name}: no impact of bodies that part")
    for name in FLATS:
        compare(sheet, case.Case(options, re.sub("[ ,]+", "_", name), flat(name)), name)
    for name in IMPACTS:
        if tier.NAME == "long" or name not in SLOW:
            compare(sheet, case.Case(options, name, deck(name)), name)
    # along the plate, not onto it
    words = flat("lead box on aluminium").replace("velocity=0,0,1.73", "velocity=1.73,0,0")
    first, steps, _ = expected(case.Case(options, "by", words))
    sheet.require("velocity=1.73,0,0" in words and abs(steps - 4.52e-6 / first) < 1.0 + 5.0e-4 * steps,
                  "no impact of bodies that pass each other")
    # if two seconds are enough for the whole run, the line counts its steps
    done = case.Case(options, "al_al_7_plane", deck("al_al_7_plane"), keep=True).summary["steps"]
    _, _, steps = expected(case.Case(options, "copy", deck("al_al_7_plane")), "--set", "log.timing=.false.")
    sheet.below("al_al_7_plane: steps of the line `estimate` over those of the run, less 1", steps / done - 1.0, TARGET)
