# SPDX-License-Identifier: BSD-3-Clause
# tiers: smoke
"""The test runner, and the marks at the beginning of test files.

Would catch a long test that is in none of the three parts, a failed test or one that could not start that is counted as
passed or skipped, a known miss or a skipped part that is not listed, and a misspelt mark, which CMake would ignore.
"""

import re
import tempfile
from pathlib import Path

import run_tests
from sources import ROOT, place

RESULTS = """<?xml version="1.0" encoding="UTF-8"?>
<testsuite name="Linux" tests="5">
 <testcase name="good" time="1.5" status="run"><system-out>met      a: 1
KNOWN    energy lost [%]: 7.5 (target &lt;= 2, limit 10)
SKIPPED  full disk: no file system for it
SKIPPEDNOT a line of ours
</system-out></testcase>
 <testcase name="bad" time="1" status="fail"><failure message="Failed"/><system-out>x</system-out></testcase>
 <testcase name="left out" time="0" status="notrun"><skipped message="SKIP_RETURN_CODE=77"/></testcase>
 <testcase name="not built" time="0" status="notrun"><skipped message="Unable to find executable"/></testcase>
 <testcase name="plain" time="0" status="run"/>
</testsuite>
"""
MARK = re.compile(r"^# ?([a-z]+(?: (?:smoke|full|long))?) ?: ")
KNOWN_MARKS = {"tiers", "cores", "timeout", "timeout smoke", "timeout full", "timeout long"}


def test(name, cost, *labels, cores=1):
    """A test as CTest lists it."""
    return run_tests.Test({"name": name, "properties": [
        {"name": "LABELS", "value": list(labels)}, {"name": "COST", "value": cost},
        {"name": "PROCESSORS", "value": cores}]})


def choice(*words, share=None):
    """The options of a user."""
    return type("Choice", (), {"smoke": False, "full": False, "long": False, "long_share": share,
                               "minutes": 70.0, "jobs": 2, "day": 0,
                               **{word: True for word in words}})


class TestRunner:
    """Which tests are run, and how their results are evaluated."""

    def test_results(self):
        """A test that cannot start has failed; a test with exit code 77 is skipped."""
        with tempfile.TemporaryDirectory() as folder:
            file = Path(folder) / "results.xml"
            file.write_text(RESULTS, encoding="utf-8")
            found = run_tests.outcomes(file)
        assert [result for _, result, _, _ in found] == ["passed", "failed", "skipped", "failed", "passed"]
        assert run_tests.marked(found, "KNOWN") == [("good", "energy lost [%]: 7.5 (target <= 2, limit 10)")]
        assert run_tests.marked(found, "SKIPPED") == [("good", "full disk: no file system for it")]

    def test_thirds(self):
        """Every long test is in exactly one of the three parts, and the parts take about the same time."""
        tests = [test(f"t{number}", 10.0 * number, "long", cores=1 + number % 2) for number in range(1, 20)]
        groups = [run_tests.long_share(tests, share) for share in range(run_tests.SHARES)]
        assert sorted(one.name for group in groups for one in group) == sorted(one.name for one in tests)
        work = [sum(one.cost * one.cores for one in group) for group in groups]
        assert max(work) < 1.2 * min(work)
        unknown = [test(f"u{number}", run_tests.UNKNOWN, "long") for number in range(9)]
        groups = [run_tests.long_share([*tests[:2], *unknown], share) for share in range(run_tests.SHARES)]
        assert [sum(one in unknown for one in group) for group in groups] == [3, 3, 3]

    def test_in_time(self):
        """No test is started that is known not to end within the limit."""
        tests = [test("full", 600, "full")]
        extra = [test("short", 300, "long"), test("long", 3000, "long"), test("longer", 3000, "long")]
        chosen, left = run_tests.in_time(tests, extra, 3000.0, 2)
        assert [one.name for one in chosen] == ["short", "long"]
        assert [one.name for one in left] == ["longer"]

    def test_never_recorded(self):
        """Long tests of unknown duration are run in the remaining time; the order changes daily, so that each of them
        is first on some day."""
        tests = [test("full", 600, "full")] + [test(f"t{n}", run_tests.UNKNOWN, "long") for n in range(6)]
        found = []
        for day in range(3 * run_tests.SHARES):
            flags = choice("full", share=day % run_tests.SHARES)
            flags.day = day
            chosen, tried = run_tests.choose(tests, flags, False)
            assert [one.name for one in chosen] == ["full"]
            found.append(tried[0].name)
        assert set(found) == {f"t{n}" for n in range(6)}

    def test_stopped(self):
        """A test that is stopped by a time limit is distinguished from one that fails."""
        line = "1/3 Test #14: hard/test_kill.long ......***Timeout   5.67 sec"
        assert run_tests.STOPPED.search(line).group(1) == "hard/test_kill.long"
        assert run_tests.STOPPED.search(line.replace("Timeout", "Failed")) is None

    def test_choice(self):
        """Tiers, filters and parts select the tests that they name."""
        tests = [test("a", 1, "unit", "smoke", "full"), test("b", 1, "full"), test("b.smoke", 1, "smoke"),
                 test("c", 2, "long"), test("d", 1, "bench")]
        for expected, words, share, filtered in (
                (["a", "b.smoke"], (), None, False), (["a", "b"], ("full",), None, False),
                (["a", "b"], (), None, True), (["c"], ("long",), None, False),
                (["a", "b.smoke"], ("smoke",), None, True)):
            names = [one.name for one in run_tests.choose(tests, choice(*words, share=share), filtered)[0]]
            assert names == expected
        assert [one.name for one in run_tests.choose(tests[4:], choice(), True)[0]] == ["d"]
        found = [one.name for share in range(3)
                 for one in run_tests.choose(tests, choice("full", share=share), False)[0]]
        assert (found.count("a"), found.count("c")) == (3, 1)

    def test_time(self):
        """The estimate is not below the longest test, nor below the total work divided by the number of cores."""
        assert run_tests.expected([test("a", 10, cores=2), test("b", 4)], 2) == 12.0
        assert run_tests.expected([test("a", 10), test("b", 4)], 2) == 10.0


class TestMarks:
    """Marks at the beginning of test files."""

    def test_marks(self):
        """Only marks that CMake reads are accepted, before the first line of code."""
        files = sorted((ROOT / "test").glob("*/test_*.py")) + sorted((ROOT / "test").glob("*/*/test_*.py"))
        assert len(files) > 80
        offences, found = [], 0
        for path in files:
            for number, line in enumerate(path.read_text(encoding="utf-8").splitlines(), 1):
                if line.startswith(("import ", "from ")):
                    break
                match = MARK.match(line)
                if match and number > 1:
                    found += 1
                    if match.group(1) not in KNOWN_MARKS:
                        offences.append(f"{place(path, number)}: unknown mark '{match.group(1)}'")
        assert found > 20
        assert offences == []

    def test_costs(self):
        """The list of costs is sorted and has one line per test."""
        lines = (ROOT / "test/costs.csv").read_text(encoding="utf-8").splitlines()
        names = [line.rsplit(",", 1)[0] for line in lines[1:]]
        assert lines[0] == "name,seconds"
        assert names == sorted(set(names))
        assert all(float(line.rsplit(",", 1)[1]) > 0.0 for line in lines[1:])
