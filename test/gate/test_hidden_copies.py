# SPDX-License-Identifier: BSD-3-Clause
# timeout: 900
# cores: 2
"""The compiler does not copy slices of arrays in calls.

Would catch a slice passed to a contiguous argument: the copy made a kernel 7 to 9 times slower.
The compiler warns of every temporary array; small ones that a line writes explicitly, such as [a, b, c], are allowed.
"""

import os
import re
import subprocess
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import case
from sources import project_files

FOLDERS = ("mesh", "material", "particle", "transfer", "ddmp", "exact", "step", "scene", "output", "run",
           "program")
MESSAGE = re.compile(
    r"^(?P<file>/.*?\.f90):(?P<line>\d+):(?P<column>\d+):\n\n.*\n.*\n"
    r"Warning: Creating array temporary at \(1\)", re.M)
SLICE = re.compile(r"[\s(,=]*[\w%]+(?:\([^()]*\)%\w+)*\((?=[^()]*:)")
# The front end makes the copies; the later passes of an optimised compilation would take a third of the time.
FRONT_END = ("-O0", "-ffrontend-optimize")

def slices(text):
    """Positions of copied slices in the messages of the compiler."""
    found = []
    for message in MESSAGE.finditer(text):
        source = Path(message["file"])
        line = source.read_text(encoding="utf-8").split("\n")[int(message["line"]) - 1]
        # a list that is shortened once, `key = key(:n)`, is copied intentionally
        if re.match(r"\s*(\w+) = \1\(:[\w*]+\)$", line):
            continue
        if SLICE.match(line[int(message["column"]) - 1:]):
            found.append(f"{source.name}:{message['line']}: {line.strip()}")
    return found


class TestHiddenCopies:
    """Compiles the folders with loops over particles again, only for the warnings."""

    def messages(self, options, path):
        modules = [f"-I{folder}" for folder in sorted((options.scree.parents[1] / "modules").iterdir())]
        work = options.work / path.stem
        work.mkdir(parents=True, exist_ok=True)
        answer = subprocess.run(
            [case.gfortran_of(options), "-S", "-std=f2008", *FRONT_END, "-fopenmp", "-Warray-temporaries",
             "-fdiagnostics-color=never", *modules, f"-J{work}", "-o", os.devnull, path],
            capture_output=True, text=True, env={**os.environ, "LC_ALL": "C"})
        assert answer.returncode == 0, answer.stderr[-2000:]
        return answer.stderr

    def test_a_copied_slice_is_seen(self, options):
        """The gate itself: a slice of rows to a contiguous argument must be found."""
        work = options.work
        work.mkdir(parents=True, exist_ok=True)
        sample = work / "sample.f90"
        sample.write_text(
            "module sample\nimplicit none\ncontains\nsubroutine outer(x)\n"
            "real, contiguous, intent(inout) :: x(:, :)\ncall inner(x(2:3, :))\n"
            "end subroutine outer\nsubroutine inner(x)\n"
            "real, contiguous, intent(inout) :: x(:, :)\nx = 2*x\n"
            "end subroutine inner\nend module sample\n", encoding="utf-8")
        assert slices(self.messages(options, sample)) == ["sample.f90:6: call inner(x(2:3, :))"]

    def test_sources(self, options):
        paths = [path for folder in FOLDERS for path in project_files(".f90", under=f"src/{folder}")]
        with ThreadPoolExecutor(2) as pool:
            found = [place for text in pool.map(lambda path: self.messages(options, path),
                                                paths) for place in slices(text)]
        assert found == [], "\n" + "\n".join(found)
