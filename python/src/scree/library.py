# SPDX-License-Identifier: BSD-3-Clause
"""The shared library libscree: its location, and its functions as declared in src/library/library_interface.f90."""
from __future__ import annotations

import ctypes
import functools
import os
import re
import subprocess
import threading
from pathlib import Path
from typing import Any

from .errors import FileProblem
from .program import find_program

NAME = "libscree.so"
# The loader of the GNU C library on x86-64, at the path that its binary interface prescribes.
LOADER = "/lib64/ld-linux-x86-64.so.2"
TEXT_MESSAGE, TEXT_FOLDER, TEXT_CASE, TEXT_REASON, TEXT_CONTROLS, TEXT_STORE, TEXT_FIELDS = range(7)
#: MPI and HDF5 are used from one thread at a time.
LOCK = threading.RLock()


class State(ctypes.Structure):
    """State of a simulation between calls."""

    _fields_ = (
        ("time", ctypes.c_double), ("dt", ctypes.c_double), ("dt_next", ctypes.c_double),
        ("time_end", ctypes.c_double), ("step", ctypes.c_int64), ("particles", ctypes.c_int64),
        ("generation", ctypes.c_int64), ("warnings", ctypes.c_int64), ("stores", ctypes.c_int),
        ("rank", ctypes.c_int), ("ranks", ctypes.c_int), ("running", ctypes.c_int), ("finished", ctypes.c_int),
        ("began_messages", ctypes.c_int))


class Memory(ctypes.Structure):
    """Memory of a field: component k of particle p is element p + k * stride."""

    _fields_ = (
        ("address", ctypes.c_void_p), ("particles", ctypes.c_int64), ("stride", ctypes.c_int64),
        ("components", ctypes.c_int), ("whole", ctypes.c_int), ("writable", ctypes.c_int))


_HANDLE, _TEXT = ctypes.c_void_p, ctypes.c_char_p
_VALUES = ctypes.POINTER(ctypes.c_double)
_ARGUMENTS: dict[str, tuple[Any, ...]] = {
    "scree_open": (_TEXT, ctypes.c_int, ctypes.c_int, ctypes.c_int, ctypes.POINTER(_HANDLE)),
    "scree_step": (_HANDLE, ctypes.c_int64, ctypes.c_double),
    "scree_state": (_HANDLE, ctypes.POINTER(State)),
    "scree_text": (_HANDLE, ctypes.c_int, ctypes.c_int),
    "scree_field": (_HANDLE, ctypes.c_int, _TEXT, ctypes.POINTER(Memory)),
    "scree_control": (_HANDLE, _TEXT, _VALUES),
    "scree_steer": (_HANDLE, _TEXT, _VALUES),
    "scree_output": (_HANDLE,), "scree_checkpoint": (_HANDLE,), "scree_finish": (_HANDLE,),
    "scree_close": (_HANDLE,), "scree_end_messages": (),
}


def find_library(path: str | os.PathLike[str] | None = None) -> str:
    """The library: by its path, by the environment (SCREE_LIBRARY), or in the tree of the program."""
    named = path or os.environ.get("SCREE_LIBRARY")
    if named:
        places = [Path(named)]
    else:
        tree = Path(find_program()).resolve().parents[1]
        places = [tree / "lib" / NAME, tree / "lib64" / NAME, *sorted(tree.glob(f"lib/*/{NAME}")),
                  *sorted(tree.glob(f"lib/*/scree/{NAME}"))]     # as in the Debian package
    for place in places:
        if place.is_file():
            return str((place if named else for_processor(place)).absolute())
    raise FileProblem(f"no library {places[0]}; scripts/build.sh builds it with the program, and the environment "
                      "variable SCREE_LIBRARY names another one")


def for_processor(library: Path) -> Path:
    """The library for this processor, from a build for several, -DSCREE_ARCH=dispatch.

    The loader selects the library of the program from the folders glibc-hwcaps/PROCESSOR, but it does not search
    them for a library that is opened by its path. `ld.so --help` lists the folders that it searches, in their order.
    """
    folders = library.parent / "glibc-hwcaps"
    if folders.is_dir():
        try:
            told = subprocess.run([LOADER, "--help"], stdout=subprocess.PIPE, text=True, check=False).stdout
        except OSError:                                  # another C library
            told = ""
        for folder in map(str, re.findall(r"^ +(\S+) \(supported, searched\)$", told, re.M)):
            if (folders / folder / library.name).is_file():
                return folders / folder / library.name
    return library


@functools.cache
def load(path: str) -> ctypes.CDLL:
    """The library of a file, with the types of its functions."""
    if not os.environ.get("OMP_WAIT_POLICY"):            # as in the program: waiting threads release their cores
        os.environ.setdefault("GOMP_SPINCOUNT", "10000")
    try:
        library = ctypes.CDLL(path)
        for name, arguments in _ARGUMENTS.items():
            function = getattr(library, name)
            function.argtypes = arguments
            function.restype = ctypes.c_char_p if name == "scree_text" else ctypes.c_int
    except (OSError, AttributeError) as error:
        raise FileProblem(f"cannot use the library {path}: {error}") from error
    return library
