# SPDX-License-Identifier: BSD-3-Clause
"""Options of test_harness.py, which CTest sets."""


def pytest_addoption(parser):
    """The programs of the failing tests."""
    group = parser.getgroup("harness of unit tests")
    group.addoption("--serial", metavar="PROGRAM", help="test_failing, as it was built")
    group.addoption("--parallel", metavar="WORD", action="append", default=[],
                    help="a word of the command that runs test_failing_ranks on two ranks; once for each word")
