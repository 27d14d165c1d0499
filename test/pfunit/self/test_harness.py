# SPDX-License-Identifier: BSD-3-Clause
"""The harness itself: failing tests fail and report the line; unsupported directives are refused.

Would catch an assertion that always passes, a failure on a higher rank that is lost, an exit code that hides failures,
and a directive that is treated as a comment.
"""

import re
import subprocess
import sys
import tempfile
from pathlib import Path

import pytest

HERE = Path(__file__).resolve().parent

GOOD = """module test_x
   use funit
   implicit none
contains
   @test
   subroutine a()
      @assertTrue(.true.)
   end subroutine a
end module test_x
"""


def run(command):
    """Exit code and output."""
    answer = subprocess.run(command, capture_output=True, text=True, timeout=60)
    return answer.returncode, answer.stdout


def translate(text):
    """Exit code and messages of the translator."""
    with tempfile.TemporaryDirectory() as folder:
        source = Path(folder, "test_x.pf")
        source.write_text(text, encoding="utf-8")
        answer = subprocess.run(
            [sys.executable, HERE.parent / "translate.py", folder, "run_x", source],
            capture_output=True, text=True,
        )
        return answer.returncode, answer.stderr


class TestHarness:
    """Failing tests fail."""

    def test_every_failing_test_fails(self, pytestconfig):
        if not pytestconfig.getoption("--serial"):
            pytest.skip("CTest names the program")
        source = (HERE / "test_failing.pf").read_text(encoding="utf-8").splitlines()
        tests = [source[n + 1].split()[1].rstrip("()") for n, line in enumerate(source)
                 if line.strip() == "@test"]
        code, output = run([pytestconfig.getoption("--serial")])
        assert code == 1, output
        assert f"{len(tests)} tests, {len(tests)} failed" in output
        for name in tests:
            assert f"FAIL {name}\n" in output
            found = re.search(rf"^test_failing\.pf:(\d+): {name}: ", output, re.M)
            assert found, f"{name} does not say where it failed"
            assert "@assert" in source[int(found.group(1)) - 1]
        assert "words of the test" in output

    def test_failure_on_one_rank_is_seen(self, pytestconfig):
        if not pytestconfig.getoption("--parallel"):
            pytest.skip("there is no mpiexec")
        code, output = run(pytestconfig.getoption("--parallel"))
        assert code != 0, output
        assert "ok   last_of_two_fails [1 ranks]" in output
        assert "FAIL last_of_two_fails [2 ranks]" in output
        assert "ok   a_later_test_runs [2 ranks]" in output
        assert "3 tests, 1 failed" in output
        assert "(rank 1 of 2)" in output


class TestTranslator:
    """Unsupported directives are refused with file and line."""

    def test_good_file(self):
        assert translate(GOOD) == (0, "")

    def refuse(self, old, new, words):
        assert old in GOOD
        code, message = translate(GOOD.replace(old, new))
        assert code == 1, message
        assert re.search(words, message)

    def test_unknown_directive(self):
        self.refuse("@assertTrue(.true.)", "@assertIsNaN(x)", r"test_x\.pf:7: .*not supported")
        self.refuse("@test", "@mpitest", r"test_x\.pf:5: .*not supported")
        self.refuse("@test", "@tset", r"test_x\.pf:5: .*not supported")

    def test_directive_on_two_lines(self):
        self.refuse("(.true.)", "(.true., &\n   message='a')", "test_x.pf:7: .*one line")

    def test_wrong_arguments(self):
        self.refuse("@assertTrue(.true.)", "@assertEqual(1)", "2 arguments")
        self.refuse("(.true.)", "(.true., 'text')", "none of: message")
        self.refuse("(.true.)", "(.true., tolerance=1.0)", "none of: message")
        self.refuse("(.true.)", "(f(.true.)", "not closed")

    def test_test_options(self):
        self.refuse("@test", "@test(cases=[1])", "only @test and")
        self.refuse("@test", "@test(npes=[1])", "one argument if")
        self.refuse("@test", "@test(npes=[0])", "1 to 16")
        self.refuse("subroutine a()", "subroutine a(this)", "one argument if")
        self.refuse("subroutine a()", "integer function a()", "must begin a subroutine")

    def test_whole_file(self):
        self.refuse("module test_x", "module test_y", "must be named test_x")
        self.refuse("   @test\n", "", "no test in this file")
