# SPDX-License-Identifier: BSD-3-Clause
"""Print the measured values of a test with their limits; a test fails at its end if one of them was not met.

    def test_momentum(options, sheet):
        sheet.below("momentum error", error, 1.0e-13)
        sheet.require(steps > 100, "the run made more than 100 steps")
        sheet.known("energy lost [%]", lost, limit=10.0, target=2.0)   # a known miss
        sheet.skipped("full disk", "needs a file system of its own")
        with sheet.part("a name"):                                     # an assertion in it is one check
            assert first == second

The fixture `sheet` of test/conftest.py creates and evaluates it. Lines that begin with KNOWN or SKIPPED are collected
by scripts/run_tests.py, which prints them in one table at the end of every run. A test that cannot run on this machine
calls pytest.skip(why), whose line is printed as well.
"""

import contextlib
import math

import measured

NOT_RUN = 77    # exit code of a test that was skipped as a whole


def skipped(what, why):
    """Print that a part of a test was skipped; scripts/run_tests.py lists it."""
    print(f"SKIPPED  {what}: {why}", flush=True)


class Report:
    """A list of checks. Every check is printed, met or not, so that margins are visible."""

    def __init__(self):
        self.missed, self.checks = [], 0

    def below(self, name, value, limit):
        """The size of a number must not exceed its limit."""
        measured.record(name, value, limit)
        self._line(name, value, f"<= {limit:.3g}", abs(value) <= limit)

    def above(self, name, value, limit):
        """A number must reach its limit."""
        measured.record(name, value, limit)
        self._line(name, value, f">= {limit:.6g}", value >= limit)

    def near(self, name, value, expected, share):
        """A number must equal another one within a relative tolerance."""
        error = value / expected - 1.0
        measured.record(name, value)
        measured.record(f"{name}.error", error, share)
        self._line(name, value, f"= {expected:.6g} within {share:.2g}, off by {error:+.2e}",
                   abs(error) <= share)

    def require(self, condition, text):
        """A condition must hold, such as a control against a test that shows nothing."""
        self.checks += 1
        if not condition:
            self.missed.append(text)
            print(f"FAILED   {text}", flush=True)

    def known(self, name, value, limit, target):
        """A known miss: the size of a number must not exceed `limit`, and its target is not met yet.

        A value that meets the target fails too: replace the row by `below(name, value, target)`. The limit keeps a
        known miss from growing and needs a reason like any other limit.
        """
        measured.record(name, value, limit, target)
        self.checks += 1
        missed = math.isfinite(value) and target < abs(value) <= limit
        if not missed:
            self.missed.append(name)
            met = math.isfinite(value) and abs(value) <= target
            print(f"FAILED   {name}: {value:.6g} "
                  + (f"meets its target {target:.3g}: it is no longer a known miss" if met else f"(<= {limit:.3g})"),
                  flush=True)
            return
        print(f"KNOWN    {name}: {value:.6g} (target <= {target:.3g}, limit {limit:.3g})", flush=True)

    def skipped(self, what, why):
        """Record a part of the test that cannot run on this machine."""
        skipped(what, why)

    def note(self, name, value):
        """A number that is reported only."""
        measured.record(name, value)
        print(f"         {name}: {value:.6g}" if isinstance(value, float)
              else f"         {name}: {value}", flush=True)

    def _line(self, name, value, limit, met):
        met = met and math.isfinite(value)
        self.checks += 1
        if not met:
            self.missed.append(name)
        print(f"{'met     ' if met else 'FAILED  '} {name}: {value:.6g} ({limit})", flush=True)

    @contextlib.contextmanager
    def part(self, *names, **more):
        """A part of a test whose assertions are one check; the rest of the test runs even if it fails."""
        self.checks += 1
        try:
            yield
        except AssertionError as error:
            name = ", ".join([*map(str, names), *(f"{key} {value}" for key, value in more.items())])
            self.missed.append(name)
            print(f"FAILED   {name}: {error}", flush=True)

    def good(self):
        """True if all checks were met, and there was at least one."""
        return bool(self.checks) and not self.missed

    def verdict(self):
        """Number of checks that were met, and the names of the others."""
        if not self.checks:
            return "no check was made"
        missed = "".join(f"\n   {name}" for name in self.missed)
        return f"{self.checks - len(self.missed)} of {self.checks} checks met{missed and ', not:'}{missed}"
