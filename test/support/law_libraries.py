# SPDX-License-Identifier: BSD-3-Clause
"""Build strength laws in shared libraries from a test.

    import law_libraries
    law_libraries.build_c(source, target, "-DFAULT=2")
    law_libraries.build_fortran(options, [source, ...], target)
"""

import shutil
import subprocess

import pytest

import case

LAWS = case.ROOT / "input/laws"
FLAGS = ("-O2", "-ffp-contract=off", "-fPIC", "-shared")


def build(command, folder):
    """Run a compiler, which must succeed without a warning."""
    answer = subprocess.run([str(word) for word in command], cwd=folder, capture_output=True, text=True, check=False)
    assert answer.returncode == 0 and not answer.stderr, f"{command}\n{answer.stdout}\n{answer.stderr}"


def build_c(source, target, *flags):
    """Compile a library in C; the test is skipped where there is no compiler of C."""
    compiler = shutil.which("gcc") or shutil.which("cc")
    if not compiler:
        pytest.skip("there is no compiler of C")
    build([compiler, "-Wall", "-Wextra", *FLAGS, *flags, f"-I{LAWS}", source, "-o", target, "-lm"], target.parent)


def build_fortran(options, sources, target, *flags):
    """Compile a library in Fortran with the compiler of the program; the first source is scree_law.f90."""
    build([case.gfortran_of(options), "-Wall", *FLAGS, *flags, LAWS / "scree_law.f90", *sources, "-o", target],
          target.parent)
