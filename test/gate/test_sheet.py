# SPDX-License-Identifier: BSD-3-Clause
# tiers: smoke
"""The Python test harness itself: failing checks fail the test, and the exit code reports this to CTest.

Would catch a failed check that is printed but does not fail the test, checks after a failed one that are not made, a
NaN that passes, a test that passes because it checks nothing, a crash or a fixture that fails without failing the test,
a known miss that meets its target and is not reported, a file without a test or with skipped ones only that counts as
passed, a failure that a skip hides, and a tier that is ignored.
"""

import os
import subprocess
import sys

import pytest

TEST = __file__.rsplit(os.sep, 2)[0]
NOT_RUN, NO_TESTS = 77, 5

FAILING = {
    "limit": ("def test_a(sheet):\n    sheet.below('x', 2.0, 1.0)\n    sheet.near('later', 1.0, 1.0, 0.1)\n",
              ("FAILED   x: 2 (<= 1)", "met      later", "1 of 2 checks met, not:", "   x")),
    "nan": ("def test_a(sheet):\n    sheet.below('x', float('nan'), 1.0)\n", ("FAILED   x: nan",)),
    "nan_above": ("def test_a(sheet):\n    sheet.above('x', float('nan'), 1.0)\n", ("FAILED   x: nan",)),
    "nan_near": ("def test_a(sheet):\n    sheet.near('x', float('nan'), 1.0, 0.1)\n", ("FAILED   x: nan",)),
    "infinite": ("def test_a(sheet):\n    sheet.above('x', float('inf'), 1.0)\n", ("FAILED   x: inf",)),
    "condition": ("def test_a(sheet):\n    sheet.require(False, 'x holds')\n", ("FAILED   x holds",)),
    "no_check": ("def test_a(sheet):\n    pass\n", ("no check was made",)),
    "crash": ("def test_a(sheet):\n    sheet.require(True, 'x')\n    raise RuntimeError('oh')\n",
              ("RuntimeError: oh",)),
    "assertion": ("def test_a():\n    assert 1 == 2\n", ("assert 1 == 2",)),
    "fixture": ("import pytest\n\n\n@pytest.fixture\ndef run():\n    raise RuntimeError('oh')\n\n\n"
                "def test_a(run, sheet):\n    sheet.require(True, 'x')\n", ("RuntimeError: oh",)),
    "end_of_fixture": ("import pytest\n\n\n@pytest.fixture\ndef run():\n    yield\n    raise RuntimeError('oh')\n\n\n"
                       "def test_a(run, sheet):\n    sheet.require(True, 'x')\n", ("RuntimeError: oh",)),
    "part": ("def test_a(sheet):\n    for n in range(3):\n        with sheet.part('row', n=n):\n"
             "            assert n != 1\n",
             ("FAILED   row, n 1", "2 of 3 checks met")),
    "known_met": ("def test_a(sheet):\n    sheet.known('x', 1.0, limit=3.0, target=2.0)\n",
                  ("no longer a known miss",)),
    "known_worse": ("def test_a(sheet):\n    sheet.known('x', 4.0, limit=3.0, target=2.0)\n", ("FAILED   x: 4",)),
    "hidden": ("import pytest\n\n\ndef test_a(sheet):\n    sheet.require(False, 'x holds')\n"
               "    pytest.skip('no time')\n",
               ("FAILED   x holds", "0 of 1 checks met")),
    "import": ("import nobody\n\n\ndef test_a():\n    pass\n", ("No module named 'nobody'",)),
    "class": ("class TestA:\n    def test_a(self, sheet):\n        sheet.below('x', 2.0, 1.0)\n", ("FAILED   x: 2",)),
    "no_program": ("def test_a(options):\n    pass\n", ("there is no program",), "--scree", "nowhere/scree"),
    "wrong_tier": ("import pytest\n\n\n@pytest.mark.tiers('ful')\ndef test_a():\n    pass\n", ("none of the tiers",)),
}
PASSING = {
    "met": ("def test_a(sheet):\n    sheet.below('x', 0.5, 1.0)\n",
            ("met      x: 0.5", "passed   test_a", "1 of 1 checks")),
    "known": ("def test_a(sheet):\n    sheet.known('x', 2.5, limit=3.0, target=2.0)\n",
              ("\nKNOWN    x: 2.5 (target <= 2",)),
    "some_skipped": ("import pytest\n\n\ndef test_a():\n    pytest.skip('no disk')\n\n\ndef test_b():\n    pass\n",
                     ("\nSKIPPED  test_a: no disk",)),
    "tier": ("import pytest\n\n\n@pytest.mark.tiers('long')\ndef test_a():\n    assert False\n\n\n"
             "def test_b():\n    pass\n",
             ("1 passed, 1 deselected",), "--tier", "smoke"),
    "folders": ("import pytest\n\n\n@pytest.mark.parametrize('n', ['a b', 'a_b'])\ndef test_a(options, n):\n"
                "    assert not list(options.work.iterdir())\n    (options.work / 'x').touch()\n", ("2 passed",)),
}


def call(options, text, *words):
    """Exit code and output of a file of tests."""
    # pytest chooses the configuration from the path of the file
    file = options.work / "test_sample.py"
    file.write_text(text, encoding="utf-8")
    answer = subprocess.run([sys.executable, "-m", "pytest", "-c", os.path.join(TEST, "pytest.ini"), "--rootdir", TEST,
                             "-p", "conftest", file, "--scree", options.scree, "--work", options.work / "inner",
                             *words], text=True, check=False, stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
                            env={**os.environ, "PYTHONPATH": f"{TEST}:{os.path.join(TEST, 'support')}"})
    return answer.returncode, "\n" + answer.stdout


@pytest.mark.parametrize("name", FAILING)
def test_must_fail(options, sheet, name):
    text, said, *words = FAILING[name]
    code, output = call(options, text, *words)
    sheet.require(code not in (0, NOT_RUN), f"exit code {code}: {output}")
    for part in said:
        sheet.require(part in output, f"'{part}' is said: {output}")


@pytest.mark.parametrize("name", PASSING)
def test_must_pass(options, sheet, name):
    text, said, *words = PASSING[name]
    code, output = call(options, text, *words)
    sheet.require(code == 0, f"exit code {code}: {output}")
    for part in said:
        sheet.require(part in output, f"'{part}' is said: {output}")


def test_exit_codes(options):
    """All skipped, no test, and none in this tier."""
    whole = "import pytest\n\npytestmark = pytest.mark.skipif(True, reason='no lmp')\n\n\ndef test_a():\n    pass\n"
    code, output = call(options, whole)
    assert code == NOT_RUN
    assert "\nSKIPPED  test_a: no lmp" in output
    assert call(options, "def helper():\n    pass\n")[0] == NO_TESTS
    assert call(options, PASSING["tier"][0], "--tier", "full", "-k", "test_a")[0] == NO_TESTS
