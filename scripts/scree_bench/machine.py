# SPDX-License-Identifier: BSD-3-Clause
"""The machine and the programs of a measurement: the processor, the program scree, and the program that copies
memory."""
import os
import platform
import re
import shutil
import subprocess
from dataclasses import dataclass
from pathlib import Path

from scree.errors import ScreeError
from scree.program import cores, find_program

COPY_NAME = "memory_copy"
COPY_FOLDER = "../libexec/scree"         # relative to the folder of scree
COPY_MEGABYTES, COPY_REPEATS = 128, 3
VERSION = re.compile(r"^scree (\S+) \(git ([^)]*)\)\s+(\S+ \S+) (\S+) (.*?)\s{2,}(.*)$", re.M)
# By default Open MPI refuses to run as root and to start more ranks than cores, and binds the threads of a rank to one
# core.
DEFAULTS = {"OMPI_ALLOW_RUN_AS_ROOT": "1", "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM": "1",
            "OMPI_MCA_rmaps_base_oversubscribe": "1", "OMPI_MCA_hwloc_base_binding_policy": "none",
            "OMPI_MCA_btl_vader_single_copy_mechanism": "none",
            "PRTE_MCA_rmaps_default_mapping_policy": ":oversubscribe",
            "PRTE_MCA_hwloc_default_binding_policy": "none", "OMP_WAIT_POLICY": "passive"}


def environment(threads):
    """Environment variables of a run with a number of threads."""
    return {**DEFAULTS, **os.environ, "OMP_NUM_THREADS": str(threads)}


@dataclass
class Program:
    """A program scree, and the content of its --version."""

    path: str
    version: str = ""
    commit: str = ""
    compiler: str = ""
    build: str = ""
    flags: str = ""
    mpi: str = ""

    def record(self):
        """Description for the file of results, without paths."""
        return {key: value for key, value in vars(self).items() if key != "path"}


def read_version(path, text):
    """A Program from the text of `scree --version`."""
    found = VERSION.search(text)
    if not found:
        raise ScreeError(f"{path} is not scree: --version says '{text.strip().splitlines()[:1]}'")
    return Program(path, *(part.strip() for part in found.groups()))


def program(path, beside=None):
    """The program scree. The first of these that exists: the named one, that of the environment variable SCREE, the one
    in the folder of this command, of this repository, or in the search path."""
    if not path and not os.environ.get("SCREE") and beside and os.access(Path(beside) / "scree", os.X_OK):
        path = str(Path(beside) / "scree")
    path = find_program(path)
    try:
        answer = subprocess.run([path, "--version"], capture_output=True, text=True, check=True, timeout=60)
    except (OSError, subprocess.SubprocessError) as error:
        raise ScreeError(f"{path} does not print its version; is it scree, and does it start?") from error
    return read_version(path, answer.stdout)


def copy_program(scree, folder=None):
    """The program that copies memory, in the given folder or installed with scree."""
    for place in filter(None, (folder, Path(scree).parent / COPY_FOLDER)):
        path = Path(place).absolute() / COPY_NAME
        if os.access(path, os.X_OK):
            return os.path.normpath(path)
    raise ScreeError(f"no program {COPY_NAME} beside {scree}; build or install Scree again, or take a program of "
                    "this version with --scree")


def measure_copy(path, threads, megabytes=COPY_MEGABYTES, repeats=COPY_REPEATS):
    """Speed of copy and triad of all threads together [GB/s], the best of some repeats."""
    try:
        answer = subprocess.run([path, str(megabytes), str(repeats)], env=environment(threads), text=True, check=True,
                                capture_output=True)
    except (OSError, subprocess.SubprocessError) as error:
        raise ScreeError(f"{path} could not copy {3 * megabytes} MB in memory: {error}") from error
    found = {word: re.search(rf"^{word} GB/s ([\d.]+)", answer.stdout, re.M) for word in ("copy", "triad")}
    if not all(found.values()):
        raise ScreeError(f"{path} printed no speed: {answer.stdout.strip()[:100]}")
    return {word: float(match.group(1)) for word, match in found.items()}


def processor_name(text):
    """Name of the processor in the text of /proc/cpuinfo."""
    for key in ("model name", "Hardware", "cpu model", "cpu"):
        found = re.search(rf"^{key}\s*:\s*(.+)$", text, re.M)
        if found:
            return " ".join(found.group(1).split())
    return platform.processor() or platform.machine()


def vectors(text):
    """The widest vector instructions of the processor, by the flags in /proc/cpuinfo."""
    found = re.search(r"^(?:flags|Features)\s*:\s*(.+)$", text, re.M)
    flags = set(found.group(1).split()) if found else set()
    for flag, name in (("avx512f", "AVX-512"), ("avx2", "AVX2"), ("avx", "AVX"), ("sve", "SVE"), ("asimd", "NEON"),
                       ("sse2", "SSE2")):
        if flag in flags:
            return name
    return ""


def describe():
    """Description of the machine for the file of results."""
    try:
        text = Path("/proc/cpuinfo").read_text(encoding="utf-8", errors="replace")
    except OSError:
        text = ""
    try:
        memory = os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES") / 2 ** 30
    except (OSError, ValueError):
        memory = 0.0
    return {"processor": processor_name(text), "vectors": vectors(text), "cores": cores(),
            "memory_gib": round(memory, 1), "system": f"{platform.system()} {platform.machine()}"}


def has(word):
    """True if a command is in the search path."""
    return shutil.which(word) is not None
