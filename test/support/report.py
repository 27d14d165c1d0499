# SPDX-License-Identifier: BSD-3-Clause
"""Print what a test measured beside its limits, and end with exit code 1 if one was not met.

    import report
    sheet = report.Report()
    sheet.below("momentum error", error, 1.0e-13)
    sheet.require(steps > 100, "the run made more than 100 steps")
    sheet.known("energy lost [%]", lost, limit=10.0, target=2.0)   # a known miss
    sheet.skipped("full disk", "needs a file system of its own")
    sheet.end()

In a test of unittest `report.skip_part(self, why)` takes the place of `self.skipTest(why)`, and
`report.skip_all(why)` leaves a test that cannot run at all. Lines that begin with KNOWN or SKIPPED are collected by
scripts/run_tests.py, which prints them in one table at the end of every run.
"""

import math
import sys
import time

NOT_RUN = 77    # exit code of a test that was skipped whole


def skipped(what, why):
    """Print that a part of a test was skipped; scripts/run_tests.py lists it."""
    print(f"SKIPPED  {what}: {why}", flush=True)


def skip_part(test_case, why):
    """Leave one test of a unittest.TestCase that cannot run here."""
    skipped(test_case.id().split(".")[-1], why)
    test_case.skipTest(why)


def skip_all(why):
    """Leave a test that cannot run here."""
    skipped("all", why)
    sys.exit(NOT_RUN)


class Report:
    """A list of checks. Every check is printed, met or not, so that margins can be read."""

    def __init__(self):
        self.missed, self.checks, self.begin = [], 0, time.time()

    def below(self, name, value, limit):
        """The size of a number must not exceed its limit."""
        self._line(name, value, f"<= {limit:.3g}", abs(value) <= limit)

    def above(self, name, value, limit):
        """A number must reach its limit."""
        self._line(name, value, f">= {limit:.6g}", value >= limit)

    def near(self, name, value, expected, share):
        """A number must equal another one within a share of that."""
        error = value / expected - 1.0
        self._line(name, value, f"= {expected:.6g} within {share:.2g}, off by {error:+.2e}",
                   abs(error) <= share)

    def require(self, condition, text):
        """Something must hold, such as a guard against an empty pass."""
        self.checks += 1
        if not condition:
            self.missed.append(text)
            print(f"FAILED   {text}", flush=True)

    def known(self, name, value, limit, target):
        """A known miss: the size of a number must not exceed `limit`, and its target is not met yet.

        A value that meets the target fails too: replace the row by `below(name, value, target)`. The limit keeps a
        known miss from growing and has a reason like any other limit.
        """
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
        """A part of the test that cannot run here."""
        skipped(what, why)

    def note(self, name, value):
        """A number that is reported only."""
        print(f"         {name}: {value:.6g}" if isinstance(value, float)
              else f"         {name}: {value}", flush=True)

    def _line(self, name, value, limit, met):
        met = met and math.isfinite(value)
        self.checks += 1
        if not met:
            self.missed.append(name)
        print(f"{'met     ' if met else 'FAILED  '} {name}: {value:.6g} ({limit})", flush=True)

    def end(self):
        """Leave; a test without a single check has failed."""
        seconds = time.time() - self.begin
        print(f"{self.checks - len(self.missed)} of {self.checks} checks met, {seconds:.1f} s")
        sys.exit(1 if self.missed or not self.checks else 0)
