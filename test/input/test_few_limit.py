# SPDX-License-Identifier: BSD-3-Clause
# tiers: smoke
# cores: 2
"""The table at the end of a run names a few particles that limit the time step.

Would catch: a scene limited by one fast body without this line, a factor that does not follow from the speeds, counts
or a name that depend on ranks, and the line in a run in which all particles are alike.
"""

import case

DECK = """
&run  dimension='plane_strain'  method='ddmp' /
&grid  lo=0,0,0  hi=40,1,40  dx=1 /
&time  t_end=1.0e9  max_steps=4 /
&material  name='m'  density=1000  bulk=1.0e6  shear=5.0e5 /
&region  name='r'  shape='box'  lo=10,0,10  hi=30,1,30 /
&body  name='rest'  region='r'  material='m'  ppc=3,1,3 /
&region  name='s'  shape='box'  lo=33,0,33  hi=35,1,35 /
&body  name='fast'  region='s'  material='m'  ppc=3,1,3  velocity={speed},0,0 /
&boundary  face='all'  type='outflow' /
&checkpoint  at_end=.false. /
"""
WAVE = (1.0e6 / 1000 + 4 * 5.0e5 / 3 / 1000) ** 0.5                       # 40.8 m/s


class TestFew:
    """36 of 3636 particles are fast, which is less than one in a hundred."""

    def ended(self, options, name, speed, ranks=1):
        run = case.Case(options, name, DECK.format(speed=speed), ranks=ranks)
        run.run()
        return run.summary["steps_limited_by_few"], run.path(".log").read_text(encoding="utf-8")

    def test_fast_body(self, options):
        """2.2 times the wave speed, so the sum of speed and wave speed is 3.2 times that of the other particles: the
        factor is at least 3 and below 5."""
        speed = 2.2 * WAVE
        limit, log = self.ended(options, "fast", speed)
        assert limit == {"particles": 36, "factor": 3.0}
        line = next(line for line in log.splitlines() if line.startswith("signals"))
        assert "36 of 3636 particles" in line
        assert "of body 'fast', material 'm'" in line
        again, other = self.ended(options, "ranks", speed, ranks=2)
        assert again == limit
        assert line in other

    def test_all_alike(self, options):
        """At 0.2 times the wave speed the flying body reduces the step by a sixth, which is not reported."""
        limit, log = self.ended(options, "slow", 0.2 * WAVE)
        assert limit["particles"] == 0
        assert "signals  " not in log
