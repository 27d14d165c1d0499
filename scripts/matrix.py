#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Build and test Scree with several compilers, MPI and HDF5 libraries, on Debian systems in folders (chroots).

    scripts/matrix.py --list                                   # the cells
    scripts/matrix.py FOLDER                                   # all cells: hours
    scripts/matrix.py FOLDER trixie-gfortran14-openmpi         # some of them, by name or pattern
    scripts/matrix.py FOLDER '*mpich*' --steps build,digests   # parts of the work
    scripts/matrix.py FOLDER --table                           # the results so far as Markdown

Each system is a folder FOLDER/SUITE that mmdebstrap fills (Debian package mmdebstrap), with a clone of the committed
state of this repository in it; the system of the machine itself is not changed. Needs root, for chroot. The results are
FOLDER/results/CELL.json, what the commands print is FOLDER/logs/CELL.STEP.log. The table of the results, with their
reading, is doc/developer/platforms.md.

Steps: prepare (system, packages, Python environment, HDF5 for flang), build, digests (of three scenes, on one rank and
on two), smoke (tests of the tier smoke), package (installation, and a program that finds it with CMake).
"""

import argparse
import fnmatch
import json
import os
import re
import shlex
import subprocess
import sys
import time
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
STEPS = ("prepare", "build", "digests", "smoke", "package")
LABELS = ("unit", "verify", "invariance", "input", "hard", "random", "gate")
# What every system gets beside compilers and libraries.
PACKAGES = ("ca-certificates", "cmake", "git", "make", "ninja-build", "python3-venv", "zlib1g-dev", "libhdf5-dev",
            "procps", "libegl1", "libgl1", "libxrender1")
MPI_PACKAGES = {"openmpi": ("openmpi-bin", "libopenmpi-dev", "libhdf5-openmpi-dev"),
                "mpich": ("mpich", "libmpich-dev", "libhdf5-mpich-dev"), "none": ("libhdf5-dev",)}
NETWORK = ("http_proxy", "https_proxy", "no_proxy", "PIP_CERT", "PIP_INDEX_URL", "SSL_CERT_FILE")
MIRROR = "http://deb.debian.org/debian"
# A mirror of the testing distribution may be older than its release file allows.
APT_OPTIONS = ('Acquire::Languages "none"', 'Acquire::Check-Valid-Until "false"')
# Scenes whose digests are compared, with the settings that make them short: elastic bodies in contact, plasticity with
# heat, and equation of state with failure.
SCENES = {"two_discs": ("time.max_steps=300",), "taylor_copper": ("time.max_steps=100",),
          "debris_cloud": ("time.max_steps=40",)}
# HDF5 with the Fortran modules of flang, from the source package of Debian 13.
HDF5_FLANG = r"""
set -e
test -f /opt/hdf5-{flang}/done && exit 0
echo 'deb-src {mirror} trixie main' > /etc/apt/sources.list.d/source.list
apt-get update -qq && apt-get install -y -qq --no-install-recommends dpkg-dev gcc g++
mkdir -p /opt/source && cd /opt/source && rm -rf hdf5-*/ && apt-get source -qq hdf5
cmake -S hdf5-*/ -B build-{flang} -G Ninja -DCMAKE_INSTALL_PREFIX=/opt/hdf5-{flang} -DCMAKE_BUILD_TYPE=Release \
   -DCMAKE_Fortran_COMPILER={flang} -DHDF5_BUILD_FORTRAN=ON -DHDF5_BUILD_CPP_LIB=OFF -DHDF5_BUILD_HL_LIB=OFF \
   -DHDF5_BUILD_TOOLS=OFF -DHDF5_BUILD_EXAMPLES=OFF -DBUILD_TESTING=OFF -DBUILD_STATIC_LIBS=OFF \
   -DHDF5_ENABLE_SZIP_SUPPORT=OFF -DHDF5_ENABLE_Z_LIB_SUPPORT=ON
cmake --build build-{flang} --parallel {jobs}
cmake --install build-{flang}
touch /opt/hdf5-{flang}/done
"""
USER_LISTS = """cmake_minimum_required(VERSION 3.18)
project(user LANGUAGES Fortran)
find_package({name} 0.1 REQUIRED)
add_executable(user user.f90)
target_link_libraries(user PRIVATE scree::io)
"""
USER_PROGRAM = """program user
   use base_communicator, only: communicator_t
   use io_hdf5, only: start_library
   implicit none
   type(communicator_t) :: ranks
   integer :: status

   call ranks%start()
   call start_library(status)
   print "(a,2(1x,i0))", "status and ranks", status, ranks%size
   call ranks%finish()
end program user
"""


@dataclass(frozen=True)
class Cell:
    """One combination of system, compiler and libraries."""

    suite: str                  # of Debian
    compiler: str               # Debian package
    mpi: str                    # openmpi, mpich or none

    @property
    def name(self):
        """Name on the command line and in files."""
        return f"{self.suite}-{self.compiler.replace('-', '')}-{'serial' if self.mpi == 'none' else self.mpi}"

    @property
    def is_flang(self):
        """Is the compiler LLVM flang, whose modules no package holds?"""
        return self.compiler.startswith("flang")

    @property
    def command(self):
        """The compiler as it is called: until version 19 flang had another name."""
        return "flang-new-19" if self.compiler == "flang-19" else self.compiler

    @property
    def packages(self):
        """Debian packages of the compiler and the libraries."""
        more = (f"libomp-{self.compiler.split('-')[1]}-dev",) if self.is_flang else ()
        return (self.compiler, *more, *MPI_PACKAGES[self.mpi])

    @property
    def options(self):
        """Options of the configuration."""
        words = [f"-DCMAKE_Fortran_COMPILER={self.command}"]
        if self.mpi == "none":
            words.append("-DSCREE_MPI=OFF")
        else:
            words.append(f"-DMPI_Fortran_COMPILER=mpifort.{self.mpi}")
        if self.is_flang:
            words.append(f"-DHDF5_ROOT=/opt/hdf5-{self.command}")
        return words


CELLS = [
    Cell("bookworm", "gfortran-12", "openmpi"),
    Cell("bookworm", "gfortran-12", "mpich"),
    Cell("bookworm", "gfortran-12", "none"),
    Cell("bookworm", "flang-19", "none"),
    Cell("trixie", "gfortran-12", "openmpi"),
    Cell("trixie", "gfortran-13", "openmpi"),
    Cell("trixie", "gfortran-14", "openmpi"),
    Cell("trixie", "gfortran-14", "mpich"),
    Cell("trixie", "gfortran-14", "none"),
    Cell("trixie", "flang-19", "none"),
    Cell("forky", "gfortran-15", "openmpi"),
    Cell("forky", "gfortran-16", "openmpi"),
    Cell("forky", "gfortran-16", "mpich"),
    Cell("forky", "gfortran-16", "none"),
    Cell("forky", "flang-22", "none"),
]


class Failure(Exception):
    """A step that did not succeed; the results so far stay."""


class Place:
    """The folder of all systems, results and logs."""

    def __init__(self, folder, choice):
        self.folder, self.jobs, self.test_jobs = folder, choice.jobs, choice.test_jobs
        self.labels = [word for word in choice.labels.split(",") if word != "none"]
        # how packages are reached
        self.network = [f"{name}={value}" for name, value in os.environ.items() if name in NETWORK]
        for name in ("results", "logs"):
            (folder / name).mkdir(parents=True, exist_ok=True)

    def result(self, cell):
        """What is known of a cell."""
        file = self.folder / "results" / f"{cell.name}.json"
        return json.loads(file.read_text(encoding="utf-8")) if file.is_file() else {}

    def note(self, cell, **values):
        """Add to what is known of a cell."""
        file = self.folder / "results" / f"{cell.name}.json"
        file.write_text(json.dumps({**self.result(cell), **values}, indent=1, sort_keys=True) + "\n", encoding="utf-8")

    def inside(self, cell, step, script, may_fail=False):
        """Run a script of bash in the system of a cell; its output goes to the log and is returned."""
        system = self.folder / cell.suite
        mounts = (f"mount -t proc proc {shlex.quote(str(system))}/proc && cd {shlex.quote(str(system))} && "
                  "mount --rbind /sys sys && mount --rbind /dev dev && mount -t tmpfs tmpfs dev/shm && "
                  "mount --bind /etc/ssl etc/ssl && cp /etc/resolv.conf etc/resolv.conf && "
                  'exec chroot . env -i HOME=/root LANG=C.UTF-8 DEBIAN_FRONTEND=noninteractive '
                  f'PATH=/usr/sbin:/usr/bin:/sbin:/bin {shlex.join(self.network)} bash -c "$1"')
        answer = subprocess.run(["unshare", "--mount", "--propagation", "private", "bash", "-c", mounts, "_", script],
                                stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, errors="replace",
                                check=False)
        log = self.folder / "logs" / f"{cell.name}.{step}.log"
        log.write_text(answer.stdout, encoding="utf-8")
        if answer.returncode and not may_fail:
            tail = "\n".join(answer.stdout.splitlines()[-15:])
            raise Failure(f"{step} failed, exit code {answer.returncode}; the end of {log}:\n{tail}")
        return answer.stdout


def prepare(place, cell):
    """System, packages, clone of the repository, Python environment, and HDF5 for flang."""
    system = place.folder / cell.suite
    if not (system / "etc/debian_version").is_file():
        # the options are kept in the system, for the packages that follow
        subprocess.run(["mmdebstrap", "--mode=root", "--variant=minbase", "--include=ca-certificates",
                        *(f"--aptopt={option}" for option in APT_OPTIONS), cell.suite, str(system), MIRROR], check=True)
    wanted = shlex.join([*PACKAGES, *cell.packages])
    place.inside(cell, "packages", "set -e\nmissing=\n"
                 f"for one in {wanted}; do dpkg -s $one > /dev/null 2>&1 || missing=\"$missing $one\"; done\n"
                 'test -z "$missing" && exit 0\napt-get update -qq\n'
                 "apt-get install -y -qq --no-install-recommends $missing")
    if set(place.labels) - {"unit"}:
        prepare_python(place, cell)
    if cell.is_flang:
        place.inside(cell, "hdf5", HDF5_FLANG.format(flang=cell.command, mirror=MIRROR, jobs=place.jobs))
    packages = place.inside(cell, "versions", "dpkg-query -W -f='${Package} ${Version}\\n' " +
                            shlex.join(cell.packages))
    place.note(cell, packages=dict(line.split() for line in packages.splitlines() if len(line.split()) == 2))


def prepare_python(place, cell):
    """The Python environment of the tests, with the packages of the repository as scripts/setup.sh installs them."""
    renew_clone(place, cell)
    place.inside(cell, "python", "set -e\ncd /opt/scree/python\n"
                 "cmp -s pyproject.toml /opt/venv/requirements.stamp && exit 0\n"
                 "python3 -m venv /opt/venv\n/opt/venv/bin/pip install --quiet '.[develop]'\n"
                 "/opt/venv/bin/pip install --quiet --no-deps --no-build-isolation --editable .\n"
                 "cp pyproject.toml /opt/venv/requirements.stamp")


def renew_clone(place, cell, built=False):
    """The committed state of this repository in the system, or that of which the cell was built; its commit."""
    clone = place.folder / cell.suite / "opt/scree"
    if not clone.is_dir():
        subprocess.run(["git", "clone", "--quiet", "--no-hardlinks", str(ROOT), str(clone)], check=True)
    commit = place.result(cell).get("commit") if built else None
    if commit is None:
        commit = subprocess.run(["git", "-C", str(ROOT), "rev-parse", "HEAD"], stdout=subprocess.PIPE, text=True,
                                check=True).stdout.strip()
    for words in (("fetch", "--quiet", str(ROOT), commit), ("checkout", "--quiet", "--force", "--detach", commit)):
        subprocess.run(["git", "-C", str(clone), *words], check=True)
    link = clone / "build/venv"
    if not link.is_symlink():
        link.parent.mkdir(exist_ok=True)
        link.symlink_to("/opt/venv")
    return commit


def build(place, cell):
    """Program and, where they are to be run, unit tests; warnings stop the build."""
    commit = renew_clone(place, cell)
    begin = time.time()
    place.note(cell, commit=commit, built=False)
    place.inside(cell, "configure", f"cd /opt/scree && cmake -S . -B build/{cell.name} -G Ninja " +
                 shlex.join(cell.options))
    said = place.inside(cell, "build", f"cmake --build /opt/scree/build/{cell.name} --parallel {place.jobs}" +
                        ("" if "unit" in place.labels else " --target scree fuzz_decks") + " -- -k 0")
    warnings = len(re.findall("warning:", said, re.I))
    version = place.inside(cell, "version", f"/opt/scree/build/{cell.name}/bin/scree --version")
    place.note(cell, built=True, warnings=warnings, version=version.splitlines(),
               build_seconds=round(time.time() - begin))


def digests(place, cell):
    """Digests of the scenes, on one rank and, with MPI, on two."""
    renew_clone(place, cell, built=True)
    environment = "OMP_NUM_THREADS=2 OMPI_ALLOW_RUN_AS_ROOT=1 OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1 " \
        "OMPI_MCA_rmaps_base_oversubscribe=1 PRTE_MCA_rmaps_default_mapping_policy=:oversubscribe "
    found = {}
    for scene, settings in SCENES.items():
        for ranks in (1,) if cell.mpi == "none" else (1, 2):
            starter = [] if ranks == 1 else [f"mpiexec.{cell.mpi}", "-n", str(ranks)]
            words = [*starter, f"build/{cell.name}/bin/scree", "-q", "--overwrite", "--case", scene, "--outdir",
                     f"/tmp/{cell.name}", f"input/{scene}/scene.nml"]
            for setting in settings:
                words += ["--set", setting]
            place.inside(cell, f"{scene}.{ranks}", f"cd /opt/scree && {environment}{shlex.join(words)}")
            summary = place.folder / cell.suite / f"tmp/{cell.name}/{scene}.summary.json"
            found[f"{scene} {ranks}"] = json.loads(summary.read_text(encoding="utf-8"))["digest"]
    place.note(cell, digests=found)


def smoke(place, cell):
    """Tests of the tier smoke, one label after the other."""
    renew_clone(place, cell, built=True)
    for label in place.labels:
        words = f"--smoke --folder build/{cell.name} --jobs {place.test_jobs} -L '^{label}$'"
        said = place.inside(cell, f"smoke.{label}", "cd /opt/scree && python3 scripts/run_tests.py " +
                            words, may_fail=True)
        ended = re.search(r"^(\d+) passed, (\d+) failed, (\d+) skipped$", said, re.M)
        if not ended:
            raise Failure("the tests did not end:\n" + "\n".join(said.splitlines()[-15:]))
        failed = re.search(r"^Failed\n((?:  .*\n)*)", said, re.M)
        tests = place.result(cell).get("tests", {})
        tests[label] = {"passed": int(ended.group(1)), "skipped": int(ended.group(3)),
                        "failed": failed.group(1).split() if failed else []}
        place.note(cell, tests=tests)


def package(place, cell):
    """An installation, found by CMake under both spellings of its name."""
    user = place.folder / cell.suite / f"tmp/{cell.name}/user"
    place.note(cell, package=False)
    for name in ("scree", "Scree"):
        (user / name).mkdir(parents=True, exist_ok=True)
        (user / name / "CMakeLists.txt").write_text(USER_LISTS.format(name=name), encoding="utf-8")
        (user / name / "user.f90").write_text(USER_PROGRAM, encoding="utf-8")
        said = place.inside(cell, "package", f"set -e\ncd /tmp/{cell.name}/user\nrm -rf prefix build\n"
                            f"cmake --install /opt/scree/build/{cell.name} --prefix $PWD/prefix > /dev/null\n"
                            f"cmake -S {name} -B build -DCMAKE_PREFIX_PATH=$PWD/prefix "
                            f"-DCMAKE_Fortran_COMPILER={cell.command}\ncmake --build build\nOMPI_ALLOW_RUN_AS_ROOT=1 "
                            "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1 build/user")
        if "status and ranks 0 1" not in said:
            raise Failure(f"the program of the package said {said[-200:]}")
    place.note(cell, package=True)


def library_of(result, name):
    """Version of the first package with this text in its name, without the parts of Debian."""
    for package_name, version in sorted(result.get("packages", {}).items()):
        if name in package_name:
            return re.split(r"[-+]", re.sub(r"^\d+:", "", version))[0]
    return "?"


def row(cell, result):
    """Cells of a line of the table."""
    compiler = re.search(r"(gfortran|flang) (\S+)", " ".join(result.get("version", [])))
    libraries = {"openmpi": "Open MPI " + library_of(result, "openmpi-bin"),
                 "mpich": "MPICH " + library_of(result, "libmpich"), "none": "none"}[cell.mpi]
    tests = "not run"
    if "tests" in result:
        groups = result["tests"].values()
        skipped, failed = sum(group["skipped"] for group in groups), sum((group["failed"] for group in groups), [])
        tests = f"{sum(group['passed'] for group in groups)} pass"
        tests += f", {skipped} skipped" if skipped else ""
        tests += f", {len(failed)} fail" if failed else ""
        missing = [label for label in LABELS if label not in result["tests"]]
        tests += f" (not run: {', '.join(missing)})" if missing else ""
    built = {True: "yes", False: "no"}.get(result.get("built"), "not run")
    packaged = {True: "yes", False: "no"}.get(result.get("package"), "not run")
    return [cell.suite, " ".join(compiler.groups()) if compiler else cell.compiler, libraries,
            library_of(result, "libhdf5"), built, tests, packaged, bits(result)]


def bits(result):
    """The first digits of the digests of one rank; with a mark if two ranks differ."""
    found = result.get("digests", {})
    words = [found.get(f"{scene} 1", "?")[:8] for scene in SCENES]
    differ = [scene for scene in SCENES if found.get(f"{scene} 2", found.get(f"{scene} 1")) != found.get(f"{scene} 1")]
    return " ".join(words) + (f" (two ranks differ: {', '.join(differ)})" if differ else "") if found else "not run"


def table(place, cells):
    """All results as Markdown."""
    head = ["Debian", "compiler", "MPI", "HDF5", "builds", "tests of the tier smoke", "find_package",
            "digests of " + ", ".join(SCENES)]
    rows = [head, ["---"] * len(head), *(row(cell, place.result(cell)) for cell in cells)]
    return "\n".join("| " + " | ".join(line) + " |" for line in rows)


def main():
    """Read the options and go through the cells."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", nargs="?", type=Path, help="where the systems are")
    parser.add_argument("cells", nargs="*", help="names or patterns; default: all")
    parser.add_argument("--steps", default=",".join(STEPS), help="some of %(default)s")
    parser.add_argument("--labels", default=",".join(LABELS), help="labels of the tests of smoke, or none: "
                        "without unit no unit tests are built, with unit alone or none no Python environment is made; "
                        "default %(default)s")
    parser.add_argument("--jobs", type=int, default=2, help="compilations at a time")
    parser.add_argument("--test-jobs", type=int, default=1, help="tests at a time")
    parser.add_argument("--list", action="store_true", help="print the names of the cells")
    parser.add_argument("--table", action="store_true", help="print the results as Markdown")
    choice = parser.parse_args()
    if choice.list:
        print("\n".join(cell.name for cell in CELLS))
        return
    steps = choice.steps.split(",")
    if choice.folder is None or set(steps) - set(STEPS):
        parser.error(f"a FOLDER is needed, and steps are {', '.join(STEPS)}")
    chosen = [cell for cell in CELLS
              if not choice.cells or any(fnmatch.fnmatch(cell.name, text) for text in choice.cells)]
    if not chosen:
        parser.error(f"no cell is named so; there are {', '.join(cell.name for cell in CELLS)}")
    place = Place(choice.folder.resolve(), choice)
    if choice.table:
        print(table(place, chosen))
        return
    failures = 0
    for cell in chosen:
        for step in steps:
            try:
                globals()[step](place, cell)
                print(f"{cell.name}: {step} done", flush=True)
            except (Failure, subprocess.CalledProcessError, OSError) as problem:
                print(f"{cell.name}: {step}: {problem}", flush=True)
                failures += 1
                break
    sys.exit(1 if failures else 0)


if __name__ == "__main__":
    main()
