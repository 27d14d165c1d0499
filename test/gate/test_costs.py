# SPDX-License-Identifier: BSD-3-Clause
# tiers: smoke
"""The tests of a tier end within the time that the documents state, according to their recorded processor time.

Would catch tests that together take longer than the time that README.md and testing.md name, and a test whose duration
nobody knows.
"""

import pytest

import run_tests
from sources import ROOT

UNIT = 1.0     # of a unit test that was never recorded [s]: no more than it may take


@pytest.fixture(scope="module")
def tests(file_options):
    """All tests of the build of this program, with the costs of the list."""
    folder = file_options.scree.parent.parent
    if not (folder / "CTestTestfile.cmake").is_file():
        pytest.skip("the program is not in a build folder with tests")
    costs = dict(line.rsplit(",", 1) for line in run_tests.COSTS.read_text(encoding="utf-8").splitlines()[1:])
    found = run_tests.listed(folder, [])
    for test in found:
        test.cost = float(costs.get(test.name, UNIT if "unit" in test.labels else run_tests.UNKNOWN))
    return found


@pytest.mark.parametrize("tier", run_tests.LIMITS)
def test_tier_is_in_its_limit(tests, sheet, tier):
    """The recorded processor time of all tests of a tier."""
    chosen = [test for test in tests if tier in test.labels]
    for test in sorted(chosen, key=lambda test: -test.cost)[:10]:
        print(f"{test.cost:8.1f} s  {test.name}")
    sheet.require(len(chosen) > 100, f"{tier}: the build has tests")
    for test in chosen:
        if test.cost == run_tests.UNKNOWN:
            sheet.require(False, f"{test.name} was never recorded: scripts/test.sh --record -R {test.name}")
    sheet.below(f"{tier}: expected time on {run_tests.CORES} cores [s]",
                run_tests.expected(chosen, run_tests.CORES), run_tests.LIMITS[tier])


def test_long_tests_of_one_day(tests, sheet):
    """With a group of long tests the tests end within the default of --minutes."""
    full = [test for test in tests if "full" in test.labels]
    rest = [test for test in tests if "long" in test.labels and "full" not in test.labels]
    seconds = 60.0 * run_tests.MINUTES - run_tests.expected(full, run_tests.CORES)
    groups, left = run_tests.long_groups(rest, seconds, run_tests.CORES)
    sheet.require(groups, "the full tier leaves time for long tests")
    for group in groups:
        sheet.below("full tier and a group of long tests [minutes]",
                    run_tests.expected([*full, *group], run_tests.CORES) / 60.0, run_tests.MINUTES)
    both = [test.name for group in [left, *groups] for test in group]
    sheet.require(sorted(both) == sorted(test.name for test in rest), "every long test is in one group, or in none")


@pytest.mark.parametrize("page, text", (
    ("README.md", "scripts/test.sh      # at most 4 minutes more"),
    ("doc/developer/testing.md", "every part of the program, at most 4 minutes on 2 cores"),
    ("doc/developer/testing.md", "all that is verified by default, at most {full:.0f} minutes"),
    ("doc/developer/testing.md", "at most {minutes:.0f} minutes for all tests"),
    ("scripts/test.sh", "time limit for all tests with --long-share (default {minutes:.0f})")))
def test_pages(page, text):
    """The documents name the limits that are checked here."""
    text = text.format(full=run_tests.LIMITS["full"] / 60.0, minutes=run_tests.MINUTES)
    assert text in (ROOT / page).read_text(encoding="utf-8")
