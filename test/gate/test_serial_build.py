# SPDX-License-Identifier: BSD-3-Clause
# tiers: smoke
"""The sources of a build without MPI have the same interfaces as those of a build with MPI.

Would catch: an MPI call in base_communicator or in the test harness that src/base/serial/mpi_f08.f90 lacks, or a change
of only one of the two variants of io_hdf5_ranks. A build with MPI compiles neither, so the error would not be found
before the next build without MPI. It would also catch presets that CMake rejects.
"""

import json
import re
import shutil
import subprocess

import pytest

import case

SRC = case.ROOT / "src"
INTERFACE = re.compile(
    r"^ *(?:(?:pure |impure )?(?:subroutine|function) .*|.*, *(?:intent|allocatable).*::.*|public ::.*)$", re.M)


def interface(path):
    """The lines of a module that its users see: public names, declarations of procedures and arguments, without
    comments."""
    text = re.sub(r" *!.*", "", path.read_text(encoding="utf-8"))
    return [line.strip() for line in INTERFACE.findall(text)]


def test_settings_of_files():
    """The two modules io_hdf5_ranks have the same interface."""
    found = {variant: interface(SRC / f"io/{variant}/io_hdf5_ranks.f90") for variant in ("parallel", "serial")}
    assert len(found["serial"]) >= 5, found["serial"]
    assert found["parallel"] == found["serial"]


def test_communicator_without_mpi(options):
    """base_communicator and the test harness compile with the module mpi_f08 for one rank."""
    compiler = case.gfortran_of(options)
    work = options.work / "modules"
    shutil.rmtree(work, ignore_errors=True)
    work.mkdir(parents=True)
    sources = [SRC / "base/serial/mpi_f08.f90", SRC / "base/base_communicator.f90",
               *(case.ROOT / f"test/pfunit/{name}.f90" for name in
                 ("funit_report", "funit_runner", "pfunit_method", "pfunit_runner"))]
    modules = options.scree.parents[1] / "modules"
    words = [compiler, "-std=f2008", "-fopenmp", "-fsyntax-only", f"-J{work}", f"-I{work}", f"-I{modules}/base"]
    for source in sources:
        answer = subprocess.run([*words, str(source)], capture_output=True, text=True, check=False)
        assert answer.returncode == 0, answer.stderr[-3000:]


def test_presets():
    """CMake reads the presets and lists each of them."""
    cmake = shutil.which("cmake")
    if not cmake:
        pytest.skip("there is no cmake")
    version = re.search(r"(\d+)\.(\d+)", subprocess.run([cmake, "--version"], capture_output=True, text=True,
                                                        check=True).stdout)
    presets = json.loads((case.ROOT / "CMakePresets.json").read_text(encoding="utf-8"))
    least = presets["cmakeMinimumRequired"]
    if tuple(map(int, version.groups())) < (least["major"], least["minor"]):
        pytest.skip("this CMake is too old for presets")
    answer = subprocess.run([cmake, "--list-presets"], cwd=case.ROOT, capture_output=True, text=True, check=False)
    assert answer.returncode == 0, answer.stderr
    wanted = [preset["name"] for preset in presets["configurePresets"] if not preset.get("hidden")]
    assert len(wanted) > 3
    assert re.findall(r'^  "(\w+)"', answer.stdout, re.M) == wanted
