# SPDX-License-Identifier: BSD-3-Clause
"""A brittle ball bursts on a hot plate: the same bits for any ranks and threads, and after a restart.

Would catch: strength that depends on the present position or the rank instead of the place at the start, failed
particles that follow their law only on some ranks, voids, temperatures or flags that a migration or a checkpoint
exchanges, heat whose flow depends on ranks, flags other than 0 and 1, mass or momentum lost on failing; cracks whose
stress without cracks, recovered from the effective stress, depends on ranks and threads; a delay whose load from the
previous step is lost when a particle migrates or a run is stopped.
"""
# timeout: 400
# cores: 2

import numpy as np

import case

DECK = """
&run  dimension='3d'  seed={seed} /
&grid  lo=-8,-8,0  hi=8,8,8  dx=1  block=4 /
&units  system='mm-us-mg' /
&time  t_end=1000  max_steps={steps} /
&effects  damage=.true.  size_scatter=.true.  voids=.true.  thermal=.true. /
&material  name='glass'  preset='glass_borosilicate'  failed_as='{remains}'  {more}
  conductivity=2.0e-4  b_thermal=1.0e-4 /
&material  name='plate'  preset='glass_borosilicate'  failed_as='{remains}'  {more}
  conductivity=4.0e-4  young=100 /
&region  name='ball'  shape='sphere'  centre=0.3,0.2,4  radius=3.4 /
&body  name='ball'  region='ball'  material='glass'  velocity=0,0,-0.15 /
&region  name='plate'  shape='box'  lo=-5,-5,0  hi=5,5,0.5 /
&body  name='plate'  region='plate'  material='plate'  temperature=900 /
&boundary  face='zlo'  type='symmetry' /
&output  name='p'  kind='particles'  count=1  precision='double'
  fields='failed','damage','scatter','solid_fraction','temperature' /
"""


def test_brittle_bits(options, sheet):
    """Several numbers of ranks and threads, and another seed."""
    for remains, more in (("granular", ""), ("drucker_prager", "failed_friction_angle=30"),
                          ("rubble", "fracture_energy=2.0e-3  softening='exponential'"),
                          ("rubble", "failure_delay=0.5  failure_delay_power=2")):
        digest = {}
        words = {"seed": 7, "steps": 60, "remains": remains, "more": more}
        for ranks, threads in ((1, 1), (2, 1), (1, 2)):
            run = case.Case(options, f"{remains}_{ranks}_{threads}", DECK.format(**words), ranks=ranks,
                            threads=threads).run("-q")
            digest[ranks, threads] = run.summary["digest"]
            ledger = run.summary["ledger"]
            last = run.snapshots()[-1][1]
            failed = last.fields["failed"]
            sheet.require(set(np.unique(failed)) == {0.0, 1.0}, "some failed, some did not, none in between")
            sheet.below("mass", abs(ledger["mass_error"]), 1.0e-14)
            sheet.below("momentum", abs(ledger["momentum_error"]), 1.0e-11)
        print(f"{remains}: {failed.mean():.3f} of the particles failed, least solid fraction "
              f"{last.fields['solid_fraction'].min():.3f}, {digest[1, 1]}")
        intact = last.fields["temperature"][failed == 0.0]
        sheet.require(np.mean(~np.isin(intact, (293.0, 900.0))) > 0.3, "heat flows in what did not break")
        stopped = case.Case(options, f"{remains}_restart", DECK.format(**words), ranks=2)
        stopped.run("-q", "-s", "time.max_steps=31")
        sheet.require(stopped.summary["digest"] != digest[1, 1], "the middle is not the end")
        stopped.ranks = 1
        digest["restart"] = stopped.run("-q", "--restart").summary["digest"]
        sheet.require(len(set(digest.values())) == 1, f"{remains}: same bits, {digest}")
        sheet.require(len(np.unique(last.fields["scatter"])) > 0.9 * len(failed), "each has a strength of its own")
        other = case.Case(options, f"{remains}_seed", DECK.format(**{**words, "seed": 8})).run("-q")
        sheet.require(other.summary["digest"] != digest[1, 1], "another seed is another ball")
