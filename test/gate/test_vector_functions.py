# SPDX-License-Identifier: BSD-3-Clause
# tiers: smoke
"""Laws and particle kernels use exp, log and powers of base_elementary, not those of the mathematics library.

Would catch: a loop that the compiler turns into calls of the vector library of mathematics. The last bits of these
functions differ from those of the scalar function in the remainder of the loop, so a result would depend on the
position of a particle in its range, and thus on ranks, threads and restarts. It would also catch products that are
fused with sums in spite of -ffp-contract=off, as gfortran 12.2 does with complex numbers, and matmul of the compiler's
library, which uses fused operations on processors that have them: such bits depend on the processor. The names of the
vector functions are those of the vector ABI, such as _ZGVdN4v_exp. It would also catch a law that calls the scalar
function: its loop is not vectorised, and its bits depend on the version of the library.
"""

import re
import shutil
import subprocess
from pathlib import Path

import pytest

import case

LAYERS = ("base", "deck", "mesh", "material", "particle", "transfer", "sample", "io", "ddmp", "exact", "step", "scene",
          "output", "run", "program")
PARTICLES = ("material", "transfer", "ddmp", "step")
FUNCTIONS = {"exp", "exp2", "expm1", "log", "log10", "log1p", "log2", "pow", "cbrt", "sin", "cos", "sincos", "tan",
             "sinh", "cosh", "tanh", "asin", "acos", "atan", "atan2", "cexp", "clog", "cpow"}
COLD = {"material_relaxation": "turns of more than 0.4 in one step",
        "law_drucker_prager": "angles of the deck",
        "law_mohr_coulomb": "angles of the deck"}

# x86-64 and ARM: instructions that round once for product and sum; plain sums.
FUSED = re.compile(r"\tv?f(?:n?m(?:add|sub)|m(?:addsub|subadd)|ml[as])\w* ")
SUM = re.compile(r"\tv?f?add[sp]?d?\s.*(?:%[xyz]mm|\bd\d)")

SAMPLE = """subroutine sample(number, values)
   integer, intent(in) :: number
   real(kind(1.0d0)), intent(inout) :: values(number)
   integer :: i
   {mark}
   do i = 1, number
      values(i) = exp(values(i))
   end do
end subroutine sample
"""


def cached(options, name):
    """A value of the cache of CMake."""
    cache = (options.scree.parents[1] / "CMakeCache.txt").read_text(encoding="utf-8")
    return re.search(rf"^{name}:\w+=(.*)$", cache, re.M).group(1)


def undefined(options, file):
    """Pairs of an object and a symbol that it imports."""
    answer = subprocess.run([cached(options, "CMAKE_NM"), "--undefined-only", "--print-file-name", file],
                            capture_output=True, text=True, check=True)
    pairs = []
    for line in answer.stdout.splitlines():
        name, symbol = line.rsplit(None, 1)
        pairs.append((Path(re.split(r":\s", name)[0].replace(":", "/")).name, symbol))
    return pairs


class TestVectorFunctions:
    """Examines the symbols of the compiled libraries."""

    def sample(self, options, mark):
        """Symbols that a loop over exp imports."""
        work = options.work
        work.mkdir(parents=True, exist_ok=True)
        source = work / "sample.f90"
        source.write_text(SAMPLE.format(mark=mark), encoding="utf-8")
        subprocess.run([case.gfortran_of(options), "-c", "-O3", "-march=native", "-o", work / "sample.o", source],
                       check=True)
        return {symbol for _, symbol in undefined(options, work / "sample.o")}

    def test_the_mark_helps(self, options):
        """The gate itself: the mark before a loop prevents the vector variants."""
        with_mark = self.sample(options, "!GCC$ novector")
        assert "exp" in with_mark
        assert not [symbol for symbol in with_mark if symbol.startswith("_ZGV")]

    def test_symbols(self, options):
        """No object of the program imports a vector variant."""
        found, scalar = [], 0
        for layer in LAYERS:
            library = options.scree.parents[1] / "lib" / f"libscree_{layer}.a"
            assert library.is_file(), f"{library} is missing; build the program first"
            for name, symbol in undefined(options, library):
                scalar += symbol in ("exp", "log", "pow")
                if symbol.startswith("_ZGV"):
                    found.append(f"{name}: {symbol}; put !GCC$ novector before the loop, or compile the file with "
                                 "-fno-tree-slp-vectorize where there is no loop")
        assert scalar > 5, "units, random numbers and exact solutions call exp, log and pow somewhere"
        assert found == [], "\n" + "\n".join(found)

    def test_fused_products(self, options):
        """No instruction of the program multiplies and adds with a single rounding."""
        if shutil.which("objdump") is None:
            pytest.skip("objdump is not installed")
        tree = options.scree.parents[1]
        files = [options.scree, *sorted(tree.glob("lib/glibc-hwcaps/*/libscree.so"))]
        for file in files:
            answer = subprocess.run(["objdump", "-d", "--no-show-raw-insn", file], capture_output=True, text=True,
                                    check=True)
            place, found, sums = "", [], 0
            for line in answer.stdout.splitlines():
                if line.endswith(">:"):
                    place = line.split("<")[1][:-2]
                elif FUSED.search(line):
                    found.append(f"{place}: {line.split(None, 1)[1]}; compile its file with -fno-tree-slp-vectorize")
                sums += bool(SUM.search(line))
            assert file == options.scree and len(files) > 1 or sums > 1000, f"{file}: {sums} sums"
            assert found == [], f"{file}\n" + "\n".join(found)

    def test_matrix_products(self, options):
        """No object imports the matrix product of the compiler's library."""
        found = [f"{name}: {symbol}; multiply variables of constant shape" for layer in LAYERS
                 for name, symbol in undefined(options, options.scree.parents[1] / "lib" / f"libscree_{layer}.a")
                 if symbol.startswith("_gfortran_matmul")]
        assert found == [], "\n" + "\n".join(found)

    def test_own_functions(self, options):
        """No object of a law or of a particle kernel imports functions of the mathematics library, except those
        listed."""
        found, listed = [], set()
        for layer in PARTICLES:
            for name, symbol in undefined(options, options.scree.parents[1] / "lib" / f"libscree_{layer}.a"):
                module = name.split(".")[0]
                if symbol not in FUNCTIONS:
                    continue
                if module in COLD:
                    listed.add(module)
                else:
                    found.append(f"{name}: {symbol}; use base_elementary")
        assert found == [], "\n" + "\n".join(found)
        assert listed == set(COLD), "exceptions that are none any more"
