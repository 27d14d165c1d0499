# SPDX-License-Identifier: BSD-3-Clause
# tiers: smoke
"""A complete deck of an impact with keys and words of decks for earlier versions: it is accepted unchanged, and a
coarser copy runs with closed balances.

Would catch a key, a word, a type of boundary or a field that such decks use and that is refused, an obsolete word that
stops a deck although it describes the only behaviour, and absorbing boundaries whose action is not recorded in the
balances.
"""

import os
import subprocess

import case

DECK = """! Sphere on a thin plate: debris cloud, quarter model by symmetry. Units: mm, us, mg.
&run
  title   = 'Al sphere D = 9.5 mm on Al plate 2.2 mm, 6.7 km/s, normal'
  case    = 'sphere_on_plate'
  dimension = '3d'
  method  = 'ddmp'
/
&units
  system  = 'mm-us-mg'              ! length mm, time us, mass mg  ->  velocity mm/us = km/s, stress GPa
/
&grid
  lo = 0, 0, -12                    ! x = 0 and y = 0 are symmetry planes
  hi = 30, 30, 60
  dx = 0.25
/
&time
  t_end = 12.0                      ! us
  cfl   = 0.35
  dt_min = 1.0e-6
  wall_limit = 'slurm'
/
&method
  transfer = 'flip'
  flip     = 0.995
  bulk_q1  = 0.06
  bulk_q2  = 1.5
/
&effects
  damage  = .true.
  thermal = .true.
  melting = .true.
/
&material
  name  = 'al_sphere'
  density = 2.79                    ! mg/mm3 = g/cm3
  young = 72.4   poisson = 0.33
  eos_model = 'mie_gruneisen'
  mg_c0 = 5.35   mg_s = 1.34   mg_gamma = 2.0
  strength_model = 'johnson_cook'
  jc_a = 0.265   jc_b = 0.426   jc_n = 0.34   jc_c = 0.015   jc_m = 1.0
  t_melt = 775.0   specific_heat = 8.75e-4  ! mm2/us2/K = 1e6 J/kg/K
  damage_model = 'johnson_cook'
  jcd = 0.13, 0.13, -1.5, 0.011, 0.0
  spall = 1.2
/
&material
  name  = 'al_plate'
  density = 2.703
  young = 69.0   poisson = 0.33
  eos_model = 'mie_gruneisen'
  mg_c0 = 5.24   mg_s = 1.40   mg_gamma = 1.97
  strength_model = 'johnson_cook'
  jc_a = 0.324   jc_b = 0.114   jc_n = 0.42   jc_c = 0.002   jc_m = 1.34
  t_melt = 925.0   specific_heat = 8.96e-4
  damage_model = 'johnson_cook'
  jcd = -0.77, 1.45, -0.47, 0.0, 1.6
  spall = 1.2
/
&region  name = 'ball'   shape = 'sphere'  centre = 0, 0, -4.80   radius = 4.75  /
&region  name = 'sheet'  shape = 'box'     lo = 0, 0, 0   hi = 30, 30, 2.2  /
&body
  name = 'sphere'   region = 'ball'   material = 'al_sphere'
  velocity = 0, 0, 6.7              ! km/s along +z
/
&body
  name = 'plate'    region = 'sheet'  material = 'al_plate'
/
&boundary  face = 'xlo'  type = 'symmetry'  /
&boundary  face = 'ylo'  type = 'symmetry'  /
&boundary  face = 'xhi'  type = 'absorbing' /
&boundary  face = 'yhi'  type = 'absorbing' /
&boundary  face = 'zlo'  type = 'outflow'   /
&boundary  face = 'zhi'  type = 'outflow'   /
&output
  name = 'cloud'  kind = 'particles'  dt = 0.5
  fields = 'velocity', 'pressure', 'mises', 'damage', 'temperature', 'body'
/
&output
  name = 'front'  kind = 'grid'  dt = 2.0
  fields = 'mass', 'velocity'
/
&output
  name = 'energy'  kind = 'history'  every = 20
  fields = 'kinetic', 'internal', 'momentum_z', 'mass_failed', 'front_z', 'tail_z'
/
&output
  name = 'pieces'  kind = 'fragments'  times = 6.0, 12.0
/
&checkpoint
  wall_minutes = 30
  keep = 2
/
"""


class TestWholeDeck:
    """The deck unchanged, and a coarse copy."""

    def run_it(self, options, name, *flags):
        """The deck in a separate folder, in a job that ends in an hour."""
        run = case.Case(options, name, DECK)
        words = [str(options.scree), *flags, str(run.deck)]
        answer = subprocess.run(words, capture_output=True, text=True, cwd=run.folder, timeout=250, env={
            **os.environ, **case.OPEN_MPI, "OMP_NUM_THREADS": "1"})
        assert answer.returncode == 0, answer.stdout + answer.stderr
        return run, answer.stdout + answer.stderr

    def test_check(self, options):
        """No error and no warning."""
        _, said = self.run_it(options, "check", "--check", "--no-estimate")
        assert " 0 errors, 0 warnings" in said

    def test_steps(self, options):
        """Steps of a coarse copy to the first state of the cloud, until the wave of the impact propagates."""
        run, _ = self.run_it(options, "steps", "-q", "--set", "grid.dx=1", "--set", "time.t_end=0.5", "--case", "steps",
                             "--outdir", ".")
        summary = run.summary
        assert summary["steps"] >= 3
        assert abs(summary["ledger"]["energy_error"]) < 1.0e-12
        assert abs(summary["ledger"]["momentum_error"]) < 1.0e-12
        assert abs(summary["ledger"]["mass_error"]) < 1.0e-12
