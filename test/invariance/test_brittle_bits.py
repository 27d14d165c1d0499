# SPDX-License-Identifier: BSD-3-Clause
"""A brittle ball that bursts on a wall: the same bits for any ranks and threads.

Would catch: strength that is drawn by place or rank instead of by particle, failed particles that
follow their law only on some ranks, voids or flags that a migration mixes
up, flags that are anything but 0 and 1, mass or momentum lost on failing.
"""
# timeout: 400

import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "support"))
import case    # noqa: E402
import report  # noqa: E402

DECK = """
&run  dimension='3d'  seed={seed} /
&grid  lo=-8,-8,0  hi=8,8,8  dx=1  block=4 /
&units  system='mm-us-mg' /
&time  t_end=1000  max_steps={steps} /
&effects  damage=.true.  size_scatter=.true.  voids=.true. /
&material  name='glass'  preset='glass_borosilicate'  failed_as='{remains}'  {more} /
&region  name='ball'  shape='sphere'  centre=0.3,0.2,4  radius=3.6 /
&body  name='ball'  region='ball'  material='glass'  velocity=0,0,-0.15 /
&boundary  face='zlo'  type='symmetry' /
&output  name='p'  kind='particles'  count=1  precision='double'
  fields='failed','damage','scatter','solid_fraction' /
"""


def main():
    """Layouts and another seed."""
    options = case.arguments()
    sheet = report.Report()
    for remains, more in (("granular", ""), ("drucker_prager", "failed_friction_angle=30")):
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
        sheet.require(len(set(digest.values())) == 1, f"{remains}: same bits, {digest}")
        sheet.require(len(np.unique(last.fields["scatter"])) > 0.9 * len(failed), "each has a strength of its own")
        other = case.Case(options, f"{remains}_seed", DECK.format(**{**words, "seed": 8})).run("-q")
        sheet.require(other.summary["digest"] != digest[1, 1], "another seed is another ball")
    sheet.end()


if __name__ == "__main__":
    main()
