# SPDX-License-Identifier: BSD-3-Clause
# tiers: smoke
"""An installation: programs, scenes, man pages and completion, in a folder with a blank and an umlaut in its name.

Would catch: a file that is not installed, a program that needs the tree it was built in, a man page that man cannot
read, a completion that lacks an option of `scree --help` or completes nothing, and a man page or a completion that was
not renewed with the help.
"""

import os
import re
import shutil
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

import case
import report

OPTIONS = case.arguments(__doc__)
BUILD = OPTIONS.scree.parents[1]
PLACE = OPTIONS.work / "opt scree ü"
OPTION = re.compile(r"(?<![\w-])(--[a-z][a-z-]*|-[a-zA-Z](?=, --))")
ASK = """set -u
source "$1/share/bash-completion/completions/$2"
program="$2"
shift 2
COMP_WORDS=("$@")
COMP_CWORD=$(($# - 1))
"$(complete -p "${program}" | sed 's/.*-F \\([^ ]*\\) .*/\\1/')"
printf '%s\\n' "${COMPREPLY[@]}"
"""


USER_LISTS = """cmake_minimum_required(VERSION 3.18)
project(user LANGUAGES Fortran)
find_package(scree 0.1 REQUIRED)
add_executable(user user.f90)
target_link_libraries(user PRIVATE scree::mesh)
"""
USER_PROGRAM = """program user
   use base_kinds, only: wp
   use mesh_grid, only: grid_t
   implicit none
   type(grid_t) :: grid

   grid%upper = [1.0_wp, 0.5_wp, 0.25_wp]
   grid%spacing = 0.125_wp
   call grid%start(0)
   print "(i0)", grid%cell_count()
end program user
"""


def run(*words, folder="/"):
    """Exit code, output and errors of a call from a folder."""
    answer = subprocess.run([str(word) for word in words], cwd=folder, text=True, timeout=200, check=False,
                            capture_output=True, env={**os.environ, **case.OPEN_MPI, "OMP_NUM_THREADS": "1"})
    return answer.returncode, answer.stdout, answer.stderr


def completed(*words, folder="/", command="scree"):
    """What bash offers for the last word of a line."""
    code, said, wrong = run("bash", "-c", ASK, "bash", PLACE, command, PLACE / "bin" / command, *words, folder=folder)
    if code or wrong:
        raise AssertionError(f"{words}: {code} {wrong}")
    return set(said.split("\n")) - {""}


class Install(unittest.TestCase):
    """One installation for all tests."""

    @classmethod
    def setUpClass(cls):
        if not (BUILD / "cmake_install.cmake").is_file():
            raise unittest.SkipTest("there is no build tree around the program")
        shutil.rmtree(PLACE, ignore_errors=True)
        code, said, wrong = run("cmake", "--install", BUILD, "--prefix", PLACE)
        if code:
            raise AssertionError(said + wrong)

    @classmethod
    def tearDownClass(cls):
        shutil.rmtree(PLACE, ignore_errors=True)

    def test_program(self):
        """Would catch a program that works only where it was built."""
        folder = OPTIONS.work / "eine Rechnung ü"
        shutil.rmtree(folder, ignore_errors=True)
        folder.mkdir(parents=True)
        scree = PLACE / "bin/scree"
        code, _, wrong = run(scree, "--new", "two_discs", "discs", folder=folder)
        self.assertEqual(code, 0, wrong)
        code, said, wrong = run(scree, "two_discs.nml", "--set", "time.max_steps=2", folder=folder / "discs")
        self.assertEqual(code, 0, wrong)
        self.assertIn("ended     max_steps reached", said)
        self.assertTrue((folder / "discs/out/two_discs/two_discs_p.hdf.series").is_file())

    def test_speed(self):
        """Would catch a scree-bench that is not installed, or without its package, its copy of memory or scree."""
        folder = OPTIONS.work / "speed ü"
        shutil.rmtree(folder, ignore_errors=True)
        folder.mkdir(parents=True)
        bench = PLACE / "bin/scree-bench"
        alone = ("env", "-u", "SCREE", "-u", "PYTHONPATH", bench, "--only", "line", "--repeat", "1")
        code, said, wrong = run(*alone, folder=folder)
        self.assertEqual(code, 0, said + wrong)
        self.assertRegex(said, r"line_ddmp +\d")
        self.assertEqual(len(list(folder.glob("scree_bench_*.json"))), 1)
        self.assertFalse(list(PLACE.rglob("__pycache__")), "written into the installation")
        shutil.move(PLACE / "libexec/scree/memory_copy", folder)
        code, _, wrong = run(*alone, folder=folder)
        shutil.move(folder / "memory_copy", PLACE / "libexec/scree/memory_copy")
        self.assertEqual(code, 3)
        self.assertIn("no program memory_copy beside", wrong)

    def test_speed_page_and_completion(self):
        """Would catch an option of scree-bench that its man page or its completion lacks."""
        code, said, _ = run(PLACE / "bin/scree-bench", "--help")
        self.assertEqual(code, 0)
        known = set(re.findall(r"^  (?:-\w, )?(--[a-z]+)", said, re.M))
        self.assertGreater(len(known), 12)
        page = PLACE / "share/man/man1/scree-bench.1"
        text = page.read_text(encoding="utf-8").replace("\\-", "-")
        zsh = (PLACE / "share/zsh/site-functions/_scree-bench").read_text(encoding="utf-8")
        for option in known:
            self.assertIn(option, text)
            self.assertIn(f'"{option}[', zsh)
        self.assertLessEqual(known, completed("-", command="scree-bench"))
        self.assertEqual(completed("--size", "f", command="scree-bench"), {"full"})
        self.assertIn("debris_1x2", completed("--only", "de", command="scree-bench"))
        if shutil.which("man") is not None:
            code, _, wrong = run("man", "--warnings", "-l", page)
            self.assertEqual((code, wrong), (0, ""))

    def test_libraries(self):
        """Would catch a package that CMake does not find, and a library or a module that it lacks."""
        folder = OPTIONS.work / "user of libraries ü"
        shutil.rmtree(folder, ignore_errors=True)
        folder.mkdir(parents=True)
        (folder / "CMakeLists.txt").write_text(USER_LISTS, encoding="utf-8")
        (folder / "user.f90").write_text(USER_PROGRAM, encoding="utf-8")
        cache = (BUILD / "CMakeCache.txt").read_text(encoding="utf-8")
        compiler = re.search(r"^CMAKE_Fortran_COMPILER:\w+=(.*)$", cache, re.M).group(1)
        call = ("cmake", "-S", folder, "-B", folder / "build", f"-DCMAKE_PREFIX_PATH={PLACE}",
                f"-DCMAKE_Fortran_COMPILER={compiler}")
        code, said, wrong = run(*call)
        self.assertEqual(code, 0, said + wrong)
        code, said, wrong = run("cmake", "--build", folder / "build")
        self.assertEqual(code, 0, said + wrong)
        code, said, wrong = run(folder / "build/user")
        self.assertEqual((code, said), (0, "64\n"), wrong)
        self.assertFalse([path for path in (PLACE / "lib/cmake/scree").iterdir()
                          if str(case.ROOT) in path.read_text(encoding="utf-8")])
        without = USER_LISTS.replace("LANGUAGES Fortran", "LANGUAGES NONE")
        (folder / "CMakeLists.txt").write_text(without, encoding="utf-8")
        code, said, wrong = run(*call[:3], "-B", folder / "build none", *call[5:6])
        self.assertNotEqual(code, 0, said)
        self.assertIn("its modules were made by gfortran", " ".join(wrong.split()))

    def test_man_page(self):
        """Would catch a page that is missing, that man complains of, or that lacks an option."""
        page = PLACE / "share/man/man1/scree.1"
        text = page.read_text(encoding="utf-8").replace("\\-", "-")
        for option in self.options():
            self.assertIn(option, text)
        if shutil.which("man") is None:
            report.skip_part(self, "there is no man")
        code, said, wrong = run("man", "--warnings", "-l", page)
        self.assertEqual((code, wrong), (0, ""))
        self.assertIn("EXIT STATUS", said)

    def options(self):
        """All options of the help."""
        code, said, _ = run(PLACE / "bin/scree", "--help")
        self.assertEqual(code, 0)
        found = set(OPTION.findall(said[:said.index("exit codes")]))
        self.assertGreater(len(found), 25)
        self.assertLessEqual({"--check", "-n", "--unset", "--ranks", "--version", "-V"}, found)
        return found

    def test_completion_knows_all_options(self):
        """Would catch an option that was added to the program and not to its completion."""
        known = self.options()
        self.assertEqual(completed("-"), known)
        zsh = (PLACE / "share/zsh/site-functions/_scree").read_text(encoding="utf-8")
        self.assertEqual(set(re.findall(r'^  "(-[-\w]+)\[', zsh, re.M)), known)
        self.assertTrue(zsh.startswith("#compdef scree\n"))

    def test_completion_of_values(self):
        """Would catch values that are not offered, or those of another option."""
        folder = OPTIONS.work / "decks ü"
        shutil.rmtree(folder, ignore_errors=True)
        (folder / "out").mkdir(parents=True)
        for name in ("a b.nml", "c.nml", "c.h5", "c.txt"):
            (folder / name).touch()
        self.assertEqual(completed("--che", folder=folder), {"--check"})
        self.assertEqual(completed("--list", "un"), {"units"})
        self.assertEqual(completed("--job", ""), {"slurm", "pbs"})
        self.assertIn("debris_cloud", completed("--new", "de"))
        self.assertEqual(completed("--explain", "grid.d"), {"grid.dx"})
        self.assertEqual(completed("--set", "time.t_"), {"time.t_end"})
        self.assertEqual(completed("", folder=folder), {"a b.nml", "c.nml", "out"})
        self.assertEqual(completed("c.nml", "--restart", "c", folder=folder), {"c.nml", "c.h5"})
        self.assertEqual(completed("--outdir", "", folder=folder), {"out"})
        self.assertEqual(completed("--case", ""), set())

    def test_hdf5_of_the_mpi(self):
        """Would catch an HDF5 of Open MPI beside MPICH: of two wrappers in a folder the wrong one, or no complaint."""
        # what a wrapper shows cannot hold folders with blanks
        folder = Path(tempfile.mkdtemp(prefix="scree_hdf5_"))
        self.addCleanup(shutil.rmtree, folder)
        (folder / "bin").mkdir()
        for mpi in ("openmpi", "mpich"):
            place = folder / mpi
            place.mkdir()
            for name in ("hdf5.mod", "libhdf5_fortran.a", "libhdf5.a", "libz.a"):
                (place / name).touch()
            (place / "H5pubconf.h").write_text("#define H5_HAVE_PARALLEL 1\n", encoding="utf-8")
            wrapper = folder / "bin" / f"h5pfc.{mpi}"
            wrapper.write_text(f"#!/bin/sh\necho gfortran '-I{place}' '-L{place}'\n", encoding="utf-8")
            wrapper.chmod(0o755)
        (folder / "CMakeLists.txt").write_text(
            "cmake_minimum_required(VERSION 3.18)\nproject(one LANGUAGES NONE)\nset(CMAKE_FIND_LIBRARY_PREFIXES lib)\n"
            f"set(CMAKE_FIND_LIBRARY_SUFFIXES .a)\ninclude(\"{case.ROOT}/cmake/ScreeHdf5.cmake\")\n", encoding="utf-8")
        shown = {}
        for mpi, library in (("openmpi", "/usr/lib/libmpi_usempif08.so"), ("mpich", "/usr/lib/libmpichfort.so")):
            code, said, wrong = run("cmake", "-S", folder, "-B", folder / f"build {mpi}", f"-DHDF5_ROOT={folder}",
                                    f"-DMPI_Fortran_LIBRARIES={library}")
            self.assertEqual(code, 0, said + wrong)
            self.assertIn(f"Found parallel HDF5: {folder}/{mpi}/", said)
            shown[mpi] = library
        code, said, wrong = run("cmake", "-S", folder, "-B", folder / "build wrong",
                                f"-DMPI_Fortran_LIBRARIES={shown['mpich']}",
                                f"-DSCREE_H5PFC={folder}/bin/h5pfc.openmpi")
        self.assertNotEqual(code, 0, said)
        self.assertRegex(" ".join(wrong.split()), "HDF5 and MPI do not fit: .* -DSCREE_H5PFC=")

    def test_build_without_tests(self):
        """Would catch --no-tests that builds the tests all the same, or a wrong word that goes to CMake."""
        folder = OPTIONS.work / "clone ü"
        shutil.rmtree(folder, ignore_errors=True)
        (folder / "bin").mkdir(parents=True)
        shutil.copytree(case.ROOT / "scripts", folder / "scripts", ignore=shutil.ignore_patterns("__pycache__"))
        (folder / "bin/cmake").write_text('#!/bin/sh\nprintf "%s\\n" "$*" >> "$CALLS"\n', encoding="utf-8")
        (folder / "bin/cmake").chmod(0o755)
        calls = folder / "calls"
        path = f"PATH={folder}/bin:{os.environ['PATH']}"
        for words, target in ((("--no-tests",), True), (("--no-tests", "Debug"), True), ((), False)):
            calls.unlink(missing_ok=True)
            code, said, wrong = run("env", path, f"CALLS={calls}", "bash", folder / "scripts/build.sh", *words)
            self.assertEqual(code, 0, said + wrong)
            line = [line for line in calls.read_text(encoding="utf-8").splitlines() if line.startswith("--build")]
            self.assertEqual([text.endswith("--target scree") for text in line], [target])
        code, _, wrong = run("env", path, f"CALLS={calls}", "bash", folder / "scripts/build.sh", "--notests")
        self.assertEqual(code, 2)
        self.assertIn("--no-tests", wrong)

    def test_zsh(self):
        """Would catch a completion that zsh cannot parse."""
        if shutil.which("zsh") is None:
            report.skip_part(self, "there is no zsh")
        code, _, wrong = run("zsh", "-n", PLACE / "share/zsh/site-functions/_scree")
        self.assertEqual((code, wrong), (0, ""))

    def test_files_are_those_of_the_help(self):
        """Would catch a help that was changed without its man page and completion."""
        code, said, wrong = run(sys.executable, case.ROOT / "scripts/document_commands.py", OPTIONS.scree, "--check")
        self.assertEqual(code, 0, said + wrong)


if __name__ == "__main__":
    unittest.main()
