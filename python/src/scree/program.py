# SPDX-License-Identifier: BSD-3-Clause
"""The program scree: its location, its version, and the number of runs that use all cores."""
from __future__ import annotations

import os
import re
import shutil
import subprocess
from pathlib import Path

from .errors import FileProblem, unknown


def beside_package() -> list[Path]:
    """Positions of the program in the tree that contains this package: of a repository, or of an installation."""
    parents = Path(__file__).resolve().parents           # ROOT/python/src/scree, PLACE/share/scree/python/src/scree
    places = [parents[3] / "build" / "bin" / "scree"]
    return places + ([parents[5] / "bin" / "scree"] if len(parents) > 5 else [])


def find_program(path: str | os.PathLike[str] | None = None) -> str:
    """The program: by its path, by the environment (SCREE), in this tree, or in PATH."""
    candidates: list[str | os.PathLike[str] | None]
    candidates = [path] if path else [os.environ.get("SCREE"), *beside_package(), shutil.which("scree")]
    for candidate in candidates:
        if candidate and os.access(candidate, os.X_OK) and os.path.isfile(candidate):
            return os.path.abspath(candidate)
    raise FileProblem(f"no program {path}" if path else
                      "no program scree was found; name it with --scree build/bin/scree or in the "
                      "environment variable SCREE")


def example(name: str, program: str | os.PathLike[str] | None = None) -> Path:
    """Deck of an example that comes with the program, such as scree.example("debris_cloud").

    `scree --list examples` lists the names. The program is found as by find_program.
    """
    folder = Path(find_program(program)).resolve().parents[1] / "share" / "scree" / "input"
    decks = {deck.parent.name: deck for deck in sorted(folder.glob("*/scene.nml"))}
    if name not in decks:
        raise unknown("example", name, decks, str(folder))
    return decks[name]


def version_of(program: str) -> str:
    """Version text of the program."""
    try:
        answer = subprocess.run([program, "--version"], capture_output=True, text=True, check=True)
    except (OSError, subprocess.CalledProcessError) as error:
        raise FileProblem(f"{program} does not print its version; is it scree?") from error
    return answer.stdout.strip()


def key_unit(program: str, key: str) -> str:
    """Unit in SI of a key such as body[ball].velocity, empty without one."""
    words = [program, "--explain", re.sub(r"\[.*?\]", "", key)]
    said = subprocess.run(words, capture_output=True, text=True, check=False).stdout
    found = re.search(r"^ *unit: ([^,\n]+)", said, re.M)
    return found.group(1) if found else ""


def cores() -> int:
    """Cores that this process may use."""
    return len(os.sched_getaffinity(0))


def threads_of_a_run() -> int:
    """Threads of a run of a study: the number in OMP_NUM_THREADS, or one, since several runs at a time use the cores
    better."""
    try:
        return max(1, int(os.environ.get("OMP_NUM_THREADS", "1")))
    except ValueError:
        return 1


def jobs_for(threads: int) -> int:
    """Number of runs at a time that use all cores."""
    return max(1, cores() // threads)
