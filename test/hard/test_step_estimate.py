# SPDX-License-Identifier: BSD-3-Clause
"""The number of steps that --check expects of impacts, before a particle moves.

Would catch: an estimate from the wave speed at rest alone, which is low by 1.6 to 2.2 here as steps shorten in shocks,
and one that sees impacts where bodies part.

The runs end while shocks are strong. Target: a fourth, so that a job can be asked for with the usual margin of a half.
Bodies that part get the estimate of the first step, to the last digit.
"""
# timeout: 120

import re
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "support"))
import case    # noqa: E402
import report  # noqa: E402

DECK = """
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
IMPACTS = {
    "copper on steel": {"dimension": "plane_strain", "low": -1.0e-2, "end": 4.0e-6, "ball": "cu_ofhc",
                        "wall": "steel_4340", "thick": 5.0e-3, "speed": 1500},
    "aluminium on a sheet": {"dimension": "plane_strain", "low": -1.0e-2, "end": 2.0e-6, "ball": "al_2024_t351",
                             "wall": "al_2024_t351", "thick": 2.0e-3, "speed": 6000},
    "lead on copper": {"dimension": "axisymmetric", "low": 0.0, "end": 4.0e-6, "ball": "lead", "wall": "cu_ofhc",
                       "thick": 5.0e-3, "speed": 3000},
}
TARGET = 0.25


def expected(run):
    """First step and number of steps that the check tells."""
    run.run("--check", "--no-estimate")
    found = re.search(r"first dt (\S+) s.*; about (\d+) steps", run.output)
    return float(found.group(1)), int(found.group(2))


def main():
    """Impacts, and the same bodies on their way apart."""
    options = case.arguments()
    sheet = report.Report()
    for name, words in IMPACTS.items():
        run = case.Case(options, name.replace(" ", "_"), DECK.format(**words))
        _, steps = expected(run)
        sheet.below(f"{name}: expected steps over those of the run, less 1",
                    steps / run.run("-q").summary["steps"] - 1.0, TARGET)
        words = {**words, "speed": -words["speed"]}
        first, steps = expected(case.Case(options, "apart", DECK.format(**words)))
        sheet.require(abs(steps - words["end"] / first) < 1.0, f"{name}: no impact of bodies that part")
    sheet.end()


if __name__ == "__main__":
    main()
