# SPDX-License-Identifier: BSD-3-Clause
# tiers: smoke
"""Names, expressions and units of a deck, against the same numbers written by hand.

Would catch an expression or a unit that gives other bits than the written number, a unit that is converted twice, a
value of the command line that definitions do not use, and an echo that leads to another result.
"""

import math
from types import SimpleNamespace

import case


def place(options):
    return SimpleNamespace(scree=options.scree, work=options.work / "a folder für decks")
NAMED = """&define v = 6.71 km/s  angle = 30  n = 20 /
&define h = {10/n} thick = {5*h/1} /
&run dimension = 'plane_strain' /
&units system = 'mm-us-mg' /
&grid lo = 0 0 0  hi = {n*h} mm, 500 um, 1 cm  dx = {h} /
&time t_end = 300ns /
&material name = 'al'  density = 2.79 g/cm3  eos_model = 'mie_gruneisen'  mg_c0 = 5.35 km/s  mg_s = 1.34
  mg_gamma = 2  shear = 27.6 GPa  strength_model = 'von_mises'  yield = 2.65 kbar /
&region name = 'ball'  shape = 'sphere'  centre = 3 0 7  radius = {sqrt(4)} mm /
&region name = 'plate'  shape = 'box'  lo = 0 0 0  hi = 10 0.5 {thick} /
&body name = 'ball'  region = 'ball'  material = 'al'  velocity = {v*sind(angle)}, 0, {-v*cosd(angle)} /
&body name = 'plate'  region = 'plate'  material = 'al'  ppc = {n/10}, 1, {2**1} /
&output name = 'h'  kind = 'history'  every = {n/4} /
"""
PLAIN = """&run dimension = 'plane_strain' /
&grid lo = 0 0 0  hi = 1e-2 5e-4 1e-2  dx = 5e-4 /
&time t_end = 3e-7 /
&material name = 'al'  density = 2790  eos_model = 'mie_gruneisen'  mg_c0 = 5350  mg_s = 1.34
  mg_gamma = 2  shear = 27.6e9  strength_model = 'von_mises'  yield = 2.65e8 /
&region name = 'ball'  shape = 'sphere'  centre = 3e-3 0 7e-3  radius = 2e-3 /
&region name = 'plate'  shape = 'box'  lo = 0 0 0  hi = 1e-2 5e-4 2.5e-3 /
&body name = 'ball'  region = 'ball'  material = 'al'  velocity = 3355 0 {down} /
&body name = 'plate'  region = 'plate'  material = 'al'  ppc = 2 1 2 /
&output name = 'h'  kind = 'history'  every = 5 /
"""
COSINE = f"{-6.71 * math.cos(math.radians(30))!r}e3"     # the shortest decimal number with these bits, in km/s


class TestNumbers:
    """A small impact, at most 40 steps."""

    def digest(self, options, name, deck, *flags):
        """Digest of the state at the end of a run."""
        run = case.Case(place(options), name, deck).run("--quiet", *flags)
        assert run.summary["steps"] > 10
        return run.summary["digest"]

    def test_bits_of_the_written_numbers(self, options):
        """The same state to the last bit, also from the echo and in a folder with a blank in its name."""
        named = self.digest(options, "named", NAMED)
        assert named == self.digest(options, "plain", PLAIN.format(down=COSINE))
        echo = (place(options).work / "named/named.echo.nml").read_text(encoding="utf-8")
        assert "! &define v = 6.71 in the units of the deck" in echo
        assert named == self.digest(options, "echo", echo)

    def test_command_line(self, options):
        """A definition set on the command line changes all values that depend on it."""
        slow = self.digest(options, "slow", NAMED, "--set", "define.angle=0", "--set", "define.v=3 km/s")
        plain = self.digest(options, "slow_plain", PLAIN.format(down=COSINE), "--set",
                            "body[ball].velocity=0 0 -3 km/s")
        assert slow == plain
        assert slow != self.digest(options, "other", NAMED, "--set", "define.angle=0")
