# SPDX-License-Identifier: BSD-3-Clause
"""Run the program that damages decks, on the decks of the project and on some further ones."""

import re
import shutil
import subprocess

import case
from broken_values import DECKS
from fuzzed_files import ENVIRONMENT

# Cells five times as large, so that the particles of a mutation are counted in milliseconds.
COARSE = (re.compile(r"dx = 0\.155 "), "dx = 0.775 ")

# Characters, quotes, repeat counts and subscripts that the other decks do not use.
MIXED = """! A deck with something of everything.
&run title = 'it''s a deck'  dimension = 'plane_strain' /
&units system = 'mm-us-mg' /
&grid lo = 0, 0, -12,  hi = 30, 1, 60  dx = 0.5 /
&time
  t_end = 12.0   ! us
  cfl = 0.35  dt_min = 1.0e-6
/
&method transfer = 'pic'  alpha = 'product' /
&effects thermal = .true.  gravity = T  gravity_vector(3) = -1 /
&material name = 'al'  density = 2.79  young = 72.4  poisson = 0.33
  strength_model = 'johnson_cook'  jc_a = 0.265  jc_b = 0.426  jc_n = 0.34  jc_c = 0.015
  jc_m = 1d0  t_melt = 775.0  specific_heat = 8.75e-4
/
&region name = 'ball'  shape = 'sphere'  centre = 15, 0, -4.80  radius = 4.75 /
&region name = 'sheet'  shape = 'box'  lo = 3*0  hi = 2*30, 2.2 /
&region name = 'rest'  shape = 'difference'  of = 'sheet', 'ball' /
&body name = 'sphere'  region = 'ball'  material = 'al'  velocity = 0, 0, 6.7 /
&body name = 'plate'  region = 'rest'  material = 'al'  ppc = 3 2 3 /
&boundary face = 'xlo'  type = 'symmetry' /
&output name = 'cloud'  kind = 'particles'  dt = 0.5  fields = 'velocity', 'pressure' /
&output name = 'energy'  kind = 'history'  times = 1 2 3. /
&checkpoint wall_minutes = 30 /
"""


def fuzz(options, first, count, timeout, program=None):
    """Make mutations of decks, starting at a given number, by the program beside scree or another one; exit code and
    output."""
    folder = options.work / "decks"
    folder.mkdir(parents=True, exist_ok=True)
    decks = {f"{name}.nml": text for name, text in DECKS.items()}
    decks["mixed.nml"] = MIXED
    for path in sorted((case.ROOT / "input").glob("*/*.nml")):
        decks[f"{path.parent.name}_{path.name}"] = path.read_text(encoding="utf-8")
    for raster in (case.ROOT / "input").glob("*/*.asc"):
        shutil.copy(raster, options.work)
    for name, text in decks.items():
        (folder / name).write_text(COARSE[0].sub(COARSE[1], text), encoding="utf-8")
    answer = subprocess.run(
        [str(word) for word in (program or options.scree.parent / "fuzz_decks", options.work, first, count,
                                *sorted(folder.glob("*.nml")))],
        stdout=subprocess.PIPE, stderr=subprocess.STDOUT, timeout=timeout, check=False,
        env=ENVIRONMENT)
    return answer.returncode, answer.stdout.decode(errors="replace")


def counts(output):
    """Numbers of mutations, refused decks and unknown words, from the last line of the output."""
    found = re.search(r"(\d+) mutations of \d+ decks: (\d+) refused, (\d+) unknown words", output)
    return tuple(int(number) for number in found.groups())
