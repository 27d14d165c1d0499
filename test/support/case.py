# SPDX-License-Identifier: BSD-3-Clause
"""Run a deck from a test and read its results.

    import case
    def test_two_ranks(options):               # options: a fixture of test/conftest.py
        box = case.Case(options, "two_ranks", DECK, ranks=2, threads=1)
        box.run()                              # box.code, box.output
        box.summary["digest"]                  # of CASE.summary.json
        box.history["time"]                    # numpy arrays by name, of CASE_history.csv
"""

import argparse
import functools
import json
import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

import tier

ROOT = Path(__file__).resolve().parents[2]
# Open MPI refuses to run as root and with more ranks than cores unless this is allowed, and would bind all threads of a
# rank to one core. Ranks of one machine need only shared memory: the search for networks takes a second at the start of
# each run, and without a network Open MPI 5 prints errors. A run without mpiexec needs no daemon.
OPEN_MPI = {
    "OMPI_ALLOW_RUN_AS_ROOT": "1",
    "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM": "1",
    "OMPI_MCA_rmaps_base_oversubscribe": "1",
    "OMPI_MCA_hwloc_base_binding_policy": "none",
    "OMPI_MCA_btl": "self,vader",
    "OMPI_MCA_pml": "ob1",
    "OMPI_MCA_ess_singleton_isolated": "1",
    "OMPI_MCA_btl_vader_single_copy_mechanism": "none",
    "PRTE_MCA_rmaps_default_mapping_policy": ":oversubscribe",
    "PRTE_MCA_hwloc_default_binding_policy": "none",
}

# Several tests run at once: ranks and threads that wait release their cores.
PATIENT = {"OMP_WAIT_POLICY": "passive", "OMPI_MCA_mpi_yield_when_idle": "1"}


def arguments(description=None):
    """The options --scree PROGRAM and --work FOLDER of a script that is not a test."""
    parser = argparse.ArgumentParser(description=description)
    parser.add_argument("--scree", default=ROOT / "build/bin/scree")
    parser.add_argument("--work", required=True)
    known, rest = parser.parse_known_args()
    sys.argv[1:] = rest  # for the options of the script itself
    known.scree = Path(known.scree).resolve()
    known.work = Path(known.work).resolve()
    if not known.scree.is_file():
        parser.error(f"there is no program {known.scree}")
    known.work.mkdir(parents=True, exist_ok=True)
    return known


@functools.lru_cache(maxsize=None)
def version(scree):
    """Version, compiler and MPI of the program, as it prints them."""
    return subprocess.run([str(scree), "--version"], stdout=subprocess.PIPE, text=True, check=True).stdout


def has_ranks(scree):
    """False if the program was built without MPI."""
    return "without MPI" not in version(scree)


def gfortran_of(options):
    """The gfortran of the build that contains the program; the test is skipped if another compiler was used."""
    if "gfortran" not in version(options.scree):
        pytest.skip("this program was not built with gfortran")
    cache = (options.scree.parents[1] / "CMakeCache.txt").read_text(encoding="utf-8")
    return re.search(r"^CMAKE_Fortran_COMPILER:\w+=(.*)$", cache, re.M).group(1)


def need_ranks(scree):
    """Skip a test of several ranks if the program was built without MPI."""
    if not has_ranks(scree):
        pytest.skip("this program was built without MPI")


class Case:
    """One deck in a separate folder, which is emptied first unless `keep` is true."""

    def __init__(self, options, name, deck, ranks=1, threads=1, keep=False):
        self.scree, self.name = options.scree, re.sub(r"[^\w.+-]", "_", name)   # the case has no other characters
        self.ranks, self.threads = ranks, threads
        self.folder = options.work / name
        self.code, self.output, self.guarded = None, "", False
        if not keep:
            shutil.rmtree(self.folder, ignore_errors=True)
        self.folder.mkdir(parents=True, exist_ok=True)
        self.deck = self.folder / f"{name}.nml"
        self.deck.write_text(deck, encoding="utf-8")

    def command(self, *options):
        """The words that run the program with further options. Results of an earlier call are
        replaced unless the call restarts from them or `guarded` is true."""
        words = [self.scree, "--case", self.name, "--outdir", self.folder, *options, self.deck]
        if not self.guarded and not {"--restart", "-r", "--check", "--job"} & set(map(str, options)):
            words.insert(1, "--overwrite")
        if self.ranks > 1:
            need_ranks(self.scree)
            words = ["mpiexec", "-n", self.ranks, *words]
        return [str(word) for word in words]

    @property
    def environment(self):
        """The environment of the program."""
        return {**os.environ, **OPEN_MPI, "OMP_NUM_THREADS": str(self.threads)}

    def start(self, *options, **how):
        """Start the program without waiting; `how` is passed to Popen."""
        return subprocess.Popen(self.command(*options), env=self.environment, cwd=self.folder,
                                stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, **how)

    def run(self, *options, expect=0, timeout=None, **how):
        """Run the program with further options; `expect` is the exit code, None accepts any; the default of `timeout`
        [s] depends on the tier; `how` is passed to subprocess.run, with its `env` added to that of the case."""
        timeout = timeout or (1500 if tier.NAME == "long" else 250)
        environment = {**self.environment, **how.pop("env", {})}
        answer = subprocess.run(self.command(*options), env=environment, timeout=timeout,
                                stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True,
                                cwd=self.folder, **how)
        self.code, self.output = answer.returncode, answer.stdout
        if expect is not None and self.code != expect:
            raise AssertionError(
                f"{self.name}: exit code {self.code}, expected {expect}\n{self.output[-4000:]}")
        return self

    def path(self, ending):
        """A file of the case, such as path("_history.csv") or path(".summary.json")."""
        return self.folder / f"{self.name}{ending}"

    @property
    def summary(self):
        """The content of CASE.summary.json."""
        return json.loads(self.path(".summary.json").read_text(encoding="utf-8"))

    @property
    def history(self):
        """The columns of CASE_history.csv as arrays, with `units` by name."""
        return post().history(str(self.path("_history.csv")))

    def snapshots(self, stream="p"):
        """Pairs (time, Snapshot) of a series, oldest first."""
        tools = post()
        series = tools.series(str(self.path(f"_{stream}.hdf.series")))
        return [(time, tools.snapshot(file)) for time, file in series]


def post():
    """The package scree_post of python/src/, which reads all file formats; importing its modules takes a while."""
    import scree_post
    return scree_post
