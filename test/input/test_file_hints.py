# SPDX-License-Identifier: BSD-3-Clause
# tiers: smoke
# cores: 2
"""Hints to the MPI library for files that several ranks write.

Would catch hints that are printed but do not reach the files, hints on a local disk, a file system that is not
recognised, hints of the deck that do not replace those for the file system, and results that depend on hints.
"""

import re
import subprocess

import pytest

import case

DECK = """&run dimension = 'plane_strain' /
&grid lo = 0 0 0  hi = 1 0.1 1  dx = 0.05 /
&time t_end = 1e9  max_steps = 5  dt_fixed = 1e-6 /
&material name = 'metal'  density = 2700  young = 70e9  poisson = 0.3 /
&region name = 'ball'  shape = 'sphere'  centre = 0.5 0 0.5  radius = 0.3 /
&body name = 'one'  region = 'ball'  material = 'metal'  velocity = 1 0 0 /
"""
# Answers the first query for the file system of a folder named on_lustre with the number of Lustre. Later queries, by
# the MPI library, get the true answer, because that library may have no driver for Lustre.
PRETEND = """function statfs(path, status) bind(c, name="statfs") result(failed)
   use, intrinsic :: iso_c_binding
   implicit none
   character(kind=c_char), intent(in) :: path(*)
   integer(c_int64_t), intent(inout) :: status(15)
   integer(c_int) :: failed
   integer, save :: asked = 0
   integer :: n
   interface
      function other(path, status) bind(c, name="statfs64") result(failed)
         import
         implicit none
         character(kind=c_char), intent(in) :: path(*)
         integer(c_int64_t), intent(inout) :: status(*)
         integer(c_int) :: failed
      end function other
   end interface

   failed = other(path, status)
   n = 1
   do while (path(n) /= c_null_char)
      n = n + 1
   end do
   if (n < 10) return
   if (any(path(n - 9:n - 1) /= ["o", "n", "_", "l", "u", "s", "t", "r", "e"])) return
   asked = asked + 1
   if (asked == 1) status(1) = int(z"0BD00BD0", c_int64_t)
end function statfs
"""


def run(options, name, *words, ranks=2, **more):
    """A run on some ranks; its output, with the hints that ROMIO uses for each file."""
    made = case.Case(options, name, DECK, ranks=ranks)
    made.run(*words, env={"ROMIO_PRINT_HINTS": "1", **more})
    return made


def used(options, made):
    """Hints that ROMIO used for all files of a run."""
    if "Open MPI v5." in case.version(options.scree):
        pytest.skip("Open MPI 5.0 keeps the hints of a file from ROMIO, and reads no ROMIO_HINTS")
    found = {}
    for name, value in re.findall(r"^key = (\S+)\s+value = (\S+)", made.output, re.M):
        found.setdefault(name, set()).add(value)
    if not found:
        pytest.skip("this MPI library does not print the hints of files (ROMIO_PRINT_HINTS)")
    return found


def test_hints_of_the_deck(options):
    """Hints of the deck are in the log and in use; without them there is no line and the library uses its defaults."""
    plain = run(options, "plain")
    assert "io hints" not in plain.output
    made = run(options, "own", "--set", "parallel.io_hints='romio_cb_write=enable; cb_buffer_size = 2097152;'")
    assert "io hints  romio_cb_write=enable, cb_buffer_size=2097152\n" in made.output
    assert plain.summary["digest"] == made.summary["digest"]
    assert used(options, made)["romio_cb_write"] == {"enable"}
    assert used(options, made)["cb_buffer_size"] == {"2097152"}
    assert used(options, plain)["romio_cb_write"] == {"automatic"}


def test_one_rank(options):
    """One rank writes without MPI, so no hints are reported."""
    made = run(options, "one", "--set", "parallel.io_hints='cb_nodes=1'", ranks=1)
    assert "io hints" not in made.output


def test_lustre(options, tmp_path):
    """Hints for Lustre are in use, those of the deck replace them, and 'none' removes all."""
    compiler = case.gfortran_of(options)
    library = tmp_path / "pretend.so"                # the loader separates names at blanks
    source = options.work / "pretend.f90"
    source.write_text(PRETEND, encoding="utf-8")
    subprocess.run([compiler, "-shared", "-fPIC", "-o", library, source], cwd=options.work, check=True)
    more = {"LD_PRELOAD": str(library)}
    made = run(options, "on_lustre", **more)
    assert ("io hints  romio_cb_write=enable, romio_ds_write=disable, romio_lustre_ds_in_coll=disable (lustre)\n"
            in made.output), made.output
    made = run(options, "on_lustre", "--set", "parallel.io_hints='romio_cb_write=automatic'", **more)
    assert "io hints  romio_cb_write=automatic, romio_ds_write=disable," in made.output
    none = run(options, "on_lustre", "--set", "parallel.io_hints='none'", **more)
    assert "io hints" not in none.output
    assert used(options, made)["romio_ds_write"] == {"disable"}
    assert used(options, made)["romio_cb_write"] == {"automatic"}
    assert used(options, none)["romio_ds_write"] == {"automatic"}
