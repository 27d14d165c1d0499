# SPDX-License-Identifier: BSD-3-Clause
# tiers: smoke
"""The test runner, and the marks at the beginning of test files.

Would catch a long test that is in none of the groups, one that starts without a known duration, a failed test or one
that could not start that is counted as passed or skipped, a known miss or a skipped part that is not listed, a
misspelt mark, which CMake would ignore, and a script that installs packages without being asked.
"""

import os
import re
import subprocess
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
                               "minutes": 70.0, "jobs": 2, **{word: True for word in words}})


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

    def test_groups(self):
        """Every long test that fits is in exactly one group, and each group ends within the time."""
        tests = [test(f"t{number}", 40.0 * number, "long", cores=1 + number % 2) for number in range(1, 20)]
        tests += [test("unknown", run_tests.UNKNOWN, "long"), test("longer", 1800.0, "long")]
        groups, left = run_tests.long_groups(tests, 900.0, 2)
        assert [one.name for one in left] == ["unknown", "longer"]
        assert sorted(one.name for group in groups for one in group) == sorted(one.name for one in tests[:-2])
        assert len(groups) < 8      # 7600 s of work, 1620 s in a group
        assert all(run_tests.expected(group, 2) <= 900.0 for group in groups)

    def test_share(self, capsys):
        """All tests that fit have their day, none of unknown duration starts, and those left out are named."""
        tests = [test("full", 600, "full"), test("unknown", run_tests.UNKNOWN, "long"), test("longer", 9999, "long")]
        tests += [test(f"t{n}", 3000, "long", cores=2) for n in range(6)]
        found = [run_tests.share(tests, tests[:1], choice("full", share=day)) for day in range(3)]
        assert sorted(one.name for group in found for one in group) == [f"t{n}" for n in range(6)]
        said = capsys.readouterr().out
        assert said.count("unknown") == said.count("longer") == 3

    def test_in_time(self):
        """No test is started that is known not to end within the remaining time."""
        extra = [test("short", 300, "long"), test("long", 2000, "long"), test("longer", 9000, "long")]
        chosen, left = run_tests.in_time(extra, 3000.0, 2)
        assert [one.name for one in chosen] == ["long", "short"]
        assert [one.name for one in left] == ["longer"]

    def test_record(self, tmp_path, monkeypatch):
        """The cost of a test is its last line COST; tests that failed or were skipped keep theirs, those removed lose
        it."""
        file = tmp_path / "costs.csv"
        file.write_text("name,seconds\na,1.0\nb,2.0\ngone,3.0\n", encoding="utf-8")
        monkeypatch.setattr(run_tests, "COSTS", file)
        run_tests.record([("a", "failed", 9.0, "COST     7.00"), ("b", "passed", 9.0, "COST     1.00\nCOST     12.34"),
                          ("c", "skipped", 9.0, "COST     0.123"), ("d", "passed", 9.0, "no line"),
                          ("a", "skipped", 9.0, "COST     0.50")], [test(name, 0.0, "full") for name in "abcd"])
        assert file.read_text(encoding="utf-8") == "name,seconds\na,1.0\nb,12.3\nc,0.12\n"

    def test_choice(self):
        """Tiers and filters select the tests that they name."""
        tests = [test("a", 1, "unit", "smoke", "full"), test("b", 1, "full"), test("b.smoke", 1, "smoke"),
                 test("c", 2, "long"), test("d", 1, "bench")]
        for expected, words, filtered in (
                (["a", "b.smoke"], (), False), (["a", "b"], ("full",), False), (["a", "b"], (), True),
                (["c"], ("long",), False), (["a", "b.smoke"], ("smoke",), True)):
            assert [one.name for one in run_tests.choose(tests, choice(*words), filtered)] == expected
        assert [one.name for one in run_tests.choose(tests[4:], choice(), True)] == ["d"]

    def test_time(self):
        """The estimate is not below that of the longest test, nor below the work divided by the number of cores."""
        used = run_tests.USED
        assert abs(run_tests.expected([test("a", 10, cores=2), test("b", 4)], 2) * used - 7.0) < 1e-12
        assert abs(run_tests.expected([test("a", 10), test("b", 4)], 2) * used - 10.0) < 1e-12
        assert abs(run_tests.expected([test("a", 30, cores=2), test("b", 4)], 2) * used - 17.0) < 1e-12


class TestSetup:
    """What scripts/test.sh does where packages are missing."""

    def test_nothing_is_installed_unasked(self, tmp_path):
        """Would catch a run of the tests that calls sudo or apt-get without --setup."""
        for name, text in (("dpkg-query", "exit 1"), ("sudo", f"touch {tmp_path}/called; exit 1"),
                           ("apt-get", f"touch {tmp_path}/called; exit 1")):
            (tmp_path / name).write_text(f"#!/bin/sh\n{text}\n", encoding="utf-8")
            (tmp_path / name).chmod(0o755)
        path = {**os.environ, "PATH": f"{tmp_path}:{os.environ['PATH']}"}
        answer = subprocess.run([ROOT / "scripts/test.sh"], env=path, capture_output=True, text=True, check=False,
                                stdin=subprocess.DEVNULL)
        assert answer.returncode == 3 and "apt-get install" in answer.stderr, answer
        assert not (tmp_path / "called").exists()


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
