# SPDX-License-Identifier: BSD-3-Clause
# tiers: smoke
"""An installation: programs, scenes, man pages and completion, in a folder with a blank and an umlaut in its name.

Would catch: a file that is not installed, a program that needs its build tree, a man page that man cannot read, a
completion that lacks an option of `scree --help` or completes nothing, and a man page or a completion that was not
regenerated after a change of the help; a file that the Debian package neither takes nor leaves out, which ends its
build.
"""

import os
import re
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path, PurePosixPath

import pytest

import case

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
    """Exit code, output and errors of a call from a given folder."""
    answer = subprocess.run([str(word) for word in words], cwd=folder, text=True, timeout=200, check=False,
                            capture_output=True, env={**os.environ, **case.OPEN_MPI, "OMP_NUM_THREADS": "1"})
    return answer.returncode, answer.stdout, answer.stderr


def completed(prefix, *words, folder="/", command="scree"):
    """Completions that bash offers for the last word of a line."""
    code, said, wrong = run("bash", "-c", ASK, "bash", prefix, command, prefix / "bin" / command, *words, folder=folder)
    if code or wrong:
        raise AssertionError(f"{words}: {code} {wrong}")
    return set(said.split("\n")) - {""}


def debian(name):
    """Patterns of one of the lists of the Debian package, without the places where their files go."""
    lines = (case.ROOT / "scripts/packages/debian" / name).read_text(encoding="utf-8").splitlines()
    return [line.split()[0] for line in lines]


def matches(path, patterns):
    """Those of the patterns that stand for a file or for a folder that it is in, as debhelper reads them."""
    return [pattern for pattern in patterns if any(place.match(pattern) for place in (path, *path.parents))]


@pytest.fixture(scope="module")
def prefix(file_options):
    """Folder in which the program is installed."""
    build, place = file_options.scree.parents[1], file_options.work / "opt scree ü"
    if not (build / "cmake_install.cmake").is_file():
        pytest.skip("there is no build tree around the program")
    code, said, wrong = run("cmake", "--install", build, "--prefix", place)
    if code:
        raise AssertionError(said + wrong)
    yield place
    shutil.rmtree(place)


class TestInstall:
    """One installation for all tests."""

    def test_program(self, options, prefix):
        """Would catch a program that works only in its build tree, and one that copies folders of an example as files:
        packages compile the Python files of an installation."""
        (prefix / "share/scree/input/two_discs/__pycache__").mkdir()
        folder = options.work / "eine Rechnung ü"
        shutil.rmtree(folder, ignore_errors=True)
        folder.mkdir(parents=True)
        scree = prefix / "bin/scree"
        code, _, wrong = run(scree, "--new", "two_discs", "discs", folder=folder)
        assert code == 0, wrong
        assert (folder / "discs/README.md").is_file()
        assert not (folder / "discs/__pycache__").exists()
        (prefix / "share/scree/input/two_discs/__pycache__").rmdir()
        code, said, wrong = run(scree, "two_discs.nml", "--set", "time.max_steps=2", folder=folder / "discs")
        assert code == 0, wrong
        assert "ended     max_steps reached" in said
        assert (folder / "discs/out/two_discs/two_discs_p.hdf.series").is_file()

    def test_speed(self, options, prefix):
        """Would catch a scree-bench that is not installed, or is installed without its package, its memory benchmark or
        scree."""
        folder = options.work / "speed ü"
        shutil.rmtree(folder, ignore_errors=True)
        folder.mkdir(parents=True)
        bench = prefix / "bin/scree-bench"
        alone = ("env", "-u", "SCREE", "-u", "PYTHONPATH", bench, "--only", "line", "--repeat", "1")
        code, said, wrong = run(*alone, folder=folder)
        assert code == 0, said + wrong
        assert re.search(r"line_ddmp +\d", said)
        assert len(list(folder.glob("scree_bench_*.json"))) == 1
        assert not list(prefix.rglob("__pycache__")), "written into the installation"
        shutil.move(prefix / "libexec/scree/memory_copy", folder)
        code, _, wrong = run(*alone, folder=folder)
        shutil.move(folder / "memory_copy", prefix / "libexec/scree/memory_copy")
        assert code == 3
        assert "no program memory_copy beside" in wrong

    def test_speed_page_and_completion(self, prefix):
        """Would catch an option of scree-bench that is missing in its man page or its completion."""
        code, said, _ = run(prefix / "bin/scree-bench", "--help")
        assert code == 0
        known = set(re.findall(r"^  (?:-\w, )?(--[a-z]+)", said, re.M))
        assert len(known) > 12
        page = prefix / "share/man/man1/scree-bench.1"
        text = page.read_text(encoding="utf-8").replace("\\-", "-")
        zsh = (prefix / "share/zsh/site-functions/_scree-bench").read_text(encoding="utf-8")
        for option in known:
            assert option in text
            assert f'"{option}[' in zsh
        assert known <= completed(prefix, "-", command="scree-bench")
        assert completed(prefix, "--size", "f", command="scree-bench") == {"full"}
        assert "debris_1x2" in completed(prefix, "--only", "de", command="scree-bench")
        if shutil.which("man") is not None:
            code, _, wrong = run("man", "--warnings", "-l", page)
            assert (code, wrong) == (0, "")

    def test_libraries(self, options, prefix):
        """Would catch a package that CMake does not find, and a library or a module that it lacks."""
        folder = options.work / "user of libraries ü"
        shutil.rmtree(folder, ignore_errors=True)
        folder.mkdir(parents=True)
        (folder / "CMakeLists.txt").write_text(USER_LISTS, encoding="utf-8")
        (folder / "user.f90").write_text(USER_PROGRAM, encoding="utf-8")
        cache = (options.scree.parents[1] / "CMakeCache.txt").read_text(encoding="utf-8")
        compiler = re.search(r"^CMAKE_Fortran_COMPILER:\w+=(.*)$", cache, re.M).group(1)
        call = ("cmake", "-S", folder, "-B", folder / "build", f"-DCMAKE_PREFIX_PATH={prefix}",
                f"-DCMAKE_Fortran_COMPILER={compiler}")
        code, said, wrong = run(*call)
        assert code == 0, said + wrong
        code, said, wrong = run("cmake", "--build", folder / "build")
        assert code == 0, said + wrong
        code, said, wrong = run(folder / "build/user")
        assert (code, said) == (0, "64\n"), wrong
        assert not [path for path in (prefix / "lib/cmake/scree").iterdir()
                    if str(case.ROOT) in path.read_text(encoding="utf-8")]
        # the package name with a capital letter is the same package
        (folder / "CMakeLists.txt").write_text(USER_LISTS.replace("(scree 0.1", "(Scree 0.1"), encoding="utf-8")
        code, said, wrong = run(*call[:3], "-B", folder / "build capital", *call[5:])
        assert code == 0, said + wrong
        without = USER_LISTS.replace("LANGUAGES Fortran", "LANGUAGES NONE")
        (folder / "CMakeLists.txt").write_text(without, encoding="utf-8")
        code, said, wrong = run(*call[:3], "-B", folder / "build none", *call[5:6])
        assert code != 0, said
        assert re.search("its modules were made by (gfortran|flang) [0-9]", " ".join(wrong.split()))

    def test_man_page(self, prefix):
        """Would catch a missing man page, one with errors reported by man, or one that lacks an option."""
        page = prefix / "share/man/man1/scree.1"
        text = page.read_text(encoding="utf-8").replace("\\-", "-")
        for option in self.options(prefix):
            assert option in text
        if shutil.which("man") is None:
            pytest.skip("there is no man")
        code, said, wrong = run("man", "--warnings", "-l", page)
        assert (code, wrong) == (0, "")
        assert "EXIT STATUS" in said

    def options(self, prefix):
        """All options of the help."""
        code, said, _ = run(prefix / "bin/scree", "--help")
        assert code == 0
        found = set(OPTION.findall(said[:said.index("exit codes")]))
        assert len(found) > 25
        assert {"--check", "-n", "--unset", "--ranks", "--version", "-V"} <= found
        return found

    def test_completion_knows_all_options(self, prefix):
        """Would catch an option that was added to the program but not to its completion."""
        known = self.options(prefix)
        assert completed(prefix, "-") == known
        zsh = (prefix / "share/zsh/site-functions/_scree").read_text(encoding="utf-8")
        assert set(re.findall(r'^  "(-[-\w]+)\[', zsh, re.M)) == known
        assert zsh.startswith("#compdef scree\n")

    def test_completion_of_values(self, options, prefix):
        """Would catch values that are not offered, or those of another option."""
        folder = options.work / "decks ü"
        shutil.rmtree(folder, ignore_errors=True)
        (folder / "out").mkdir(parents=True)
        for name in ("a b.nml", "c.nml", "c.h5", "c.txt"):
            (folder / name).touch()
        assert completed(prefix, "--che", folder=folder) == {"--check"}
        assert completed(prefix, "--list", "un") == {"units"}
        assert completed(prefix, "--job", "") == {"slurm", "pbs"}
        assert "debris_cloud" in completed(prefix, "--new", "de")
        assert completed(prefix, "--explain", "grid.d") == {"grid.dx"}
        assert completed(prefix, "--set", "time.t_") == {"time.t_end"}
        assert completed(prefix, "", folder=folder) == {"a b.nml", "c.nml", "out"}
        assert completed(prefix, "c.nml", "--restart", "c", folder=folder) == {"c.nml", "c.h5"}
        assert completed(prefix, "--outdir", "", folder=folder) == {"out"}
        assert completed(prefix, "--case", "") == set()

    def test_hdf5_of_the_mpi(self, request):
        """Would catch an HDF5 built for Open MPI that is used with MPICH: the wrong one of two wrappers in a folder, or
        no error message."""
        # the output of a wrapper cannot contain folders with blanks
        folder = Path(tempfile.mkdtemp(prefix="scree_hdf5_"))
        request.addfinalizer(lambda: shutil.rmtree(folder))
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
            "set(SCREE_MPI ON)\nset(scree_variant parallel)\n"
            f"set(CMAKE_FIND_LIBRARY_SUFFIXES .a)\ninclude(\"{case.ROOT}/cmake/ScreeHdf5.cmake\")\n", encoding="utf-8")
        shown = {}
        for mpi, library in (("openmpi", "/usr/lib/libmpi_usempif08.so"), ("mpich", "/usr/lib/libmpichfort.so")):
            code, said, wrong = run("cmake", "-S", folder, "-B", folder / f"build {mpi}", f"-DHDF5_ROOT={folder}",
                                    f"-DMPI_Fortran_LIBRARIES={library}")
            assert code == 0, said + wrong
            assert f"Found parallel HDF5: {folder}/{mpi}/" in said
            shown[mpi] = library
        code, said, wrong = run("cmake", "-S", folder, "-B", folder / "build wrong",
                                f"-DMPI_Fortran_LIBRARIES={shown['mpich']}",
                                f"-DSCREE_H5PFC={folder}/bin/h5pfc.openmpi")
        assert code != 0, said
        assert re.search("HDF5 and MPI do not fit: .* -DSCREE_H5PFC=", " ".join(wrong.split()))

    def test_build_without_tests(self, options):
        """Would catch --no-tests that still builds the tests, or an invalid option that is passed to CMake."""
        folder = options.work / "clone ü"
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
            assert code == 0, said + wrong
            line = [line for line in calls.read_text(encoding="utf-8").splitlines() if line.startswith("--build")]
            assert [text.endswith("--target scree") for text in line] == [target]
        code, _, wrong = run("env", path, f"CALLS={calls}", "bash", folder / "scripts/build.sh", "--notests")
        assert code == 2
        assert "--no-tests" in wrong

    def test_zsh(self, prefix):
        """Would catch a completion that zsh cannot parse."""
        if shutil.which("zsh") is None:
            pytest.skip("there is no zsh")
        code, _, wrong = run("zsh", "-n", prefix / "share/zsh/site-functions/_scree")
        assert (code, wrong) == (0, "")

    def test_files_are_those_of_the_help(self, options):
        """Would catch a help that was changed without its man page and completion."""
        code, said, wrong = run(sys.executable, case.ROOT / "scripts/document_commands.py", options.scree, "--check")
        assert code == 0, said + wrong

    def test_debian_package(self, prefix):
        """Would catch a new folder of scripts that the lists of the Debian package do not name, a pattern of which
        nothing is left, and a script that is packed without a module that it imports."""
        rules = (case.ROOT / "scripts/packages/debian/rules").read_text(encoding="utf-8")
        removed = re.findall(r"debian/tmp/usr/\$\(private\)/(\w+)", rules)
        assert removed == ["scree", "cmake"]
        library = next((path.parent for path in prefix.rglob("libscree.so") if "glibc-hwcaps" not in str(path)), None)
        if not library:
            pytest.skip("this build has no shared library")
        files = []
        for path in prefix.rglob("*"):
            if path.is_dir():
                continue
            if library in path.parents:
                inside = path.relative_to(library)
                if inside.parts[0] not in removed:
                    files.append(PurePosixPath("usr/lib/x86_64-linux-gnu/scree") / inside)
            else:
                files.append(PurePosixPath("usr") / path.relative_to(prefix))
        taken, left_out = debian("scree.install"), debian("not-installed")
        packed = [path for path in files if matches(path, taken)]
        # the documents have a folder with the name of the package
        unknown = [path for path in files if path not in packed and not matches(path, left_out)
                   and "share/doc" not in str(path)]
        assert unknown == []
        used = {pattern for path in files for pattern in matches(path, [*taken, *left_out])}
        assert {*taken, *left_out} - used <= {"usr/share/doc/scree/LICENSE"}
        scripts = {path.stem for path in packed if str(path.parent) == "usr/share/scree/scripts"}
        siblings = {path.stem for path in (case.ROOT / "scripts").glob("*.py")}
        for name in sorted(scripts):
            text = (case.ROOT / "scripts" / f"{name}.py").read_text(encoding="utf-8")
            needed = set(re.findall(r"^(?:import|from) (\w+)", text, re.M)) & siblings
            assert needed <= scripts, f"{name}.py imports {needed - scripts}"
