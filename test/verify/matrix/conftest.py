# SPDX-License-Identifier: BSD-3-Clause
"""Options of test_matrix.py."""


def pytest_addoption(parser):
    """A file for the table of the documents, and a selection of methods."""
    group = parser.getgroup("matrix of methods")
    group.addoption("--write", metavar="FILE", help="file for the table of doc/theory/matrix_of_methods.md")
    group.addoption("--only", metavar="WORD", help="only the methods with this word in their names")
