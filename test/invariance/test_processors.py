# SPDX-License-Identifier: BSD-3-Clause
# tiers: long
# timeout: 3600
# cores: 2
"""One program for all x86-64 processors, -DSCREE_ARCH=dispatch: installed, moved, and run as on older processors.

Would catch: kernels that give other bits when compiled for another processor, as the sums over the particles of a tile
did with turn_from = 'tiles'; a library for a processor that is not installed, or that the loader or the package scree
does not select; instructions that the first library must not use, because older processors do not have them; a program
that needs its build tree.
"""

import os
import re
import shutil
import subprocess
import sys

import pytest

import case
import layouts

# Features that the loader of the C library is told to ignore, so that it treats the processor as an older one.
MASKS = {"x86-64-v4": "", "x86-64-v3": "-AVX512F", "x86-64": "-AVX2"}
# Registers and instructions that came after x86-64: AVX and later; SSE3 to SSE4.2, bit manipulation.
AVX512 = re.compile(r"%zmm|%k[1-7]\b|%[xy]mm(?:1[6-9]|2\d|3[01])\b")
AVX = re.compile(r"\tv(?!err|erw|mcall|mlaunch|mresume)\w+ |%ymm")
LATER = re.compile(
    r"\t(?:popcnt|lzcnt|tzcnt|crc32|movbe|andn|bextr|bzhi|bls[ir]|blsmsk|mulx|pdep|pext|rorx|sarx|shlx|shrx|"
    r"round[sp][sd]|blendv?p[sd]|pblend\w+|dpp[sd]|insertps|extractps|p(?:ins|ext)r[bdq]|pm(?:in|ax)s[bd]|"
    r"pm(?:in|ax)u[wd]|pmulld|pmuldq|pmov[sz]x\w+|ptest|pcmpeqq|pcmpgtq|packusdw|pcmp[ie]str[im]|mpsadbw|"
    r"pshufb|palignr|pabs[bwd]|psign[bwd]|ph(?:add|sub)\w+|pmaddubsw|pmulhrsw|h(?:add|sub)p[sd]|"
    r"addsubp[sd]|mov(?:ddup|s[hl]dup)|lddqu)[bwlq]? ")

BRITTLE = """
&run  dimension='3d' /
&grid  lo=-8,-8,0  hi=8,8,8  dx=1  block=4 /
&units  system='mm-us-mg' /
&time  t_end=1000  max_steps=60 /
&effects  damage=.true.  size_scatter=.true.  voids=.true.  thermal=.true. /
&material  name='glass'  preset='glass_borosilicate'  failed_as='granular'
  conductivity=2.0e-4  b_thermal=1.0e-4 /
&region  name='ball'  shape='sphere'  centre=0.3,0.2,4  radius=3.4 /
&body  name='ball'  region='ball'  material='glass'  velocity=0,0,-0.15 /
&boundary  face='zlo'  type='symmetry' /
&output  name='p'  kind='particles'  count=1  fields='failed' /
"""

BALLS = """
&run  dimension='3d'  method='{method}' /
&grid  lo=0,0,0  hi=8,8,8  dx=0.5 /
&time  t_end=1  max_steps=60 /
&material  name='rubber'  density=1000  young=1.0e6  poisson=0.3 /
&region  name='one'  shape='sphere'  centre=2.5,4.1,4.2  radius=1.4 /
&region  name='two'  shape='sphere'  centre=5.4,3.8,3.9  radius=1.4 /
&body  name='one'  region='one'  material='rubber'  velocity=12,3,-5  spin=1,2,3 /
&body  name='two'  region='two'  material='rubber'  velocity=-9,-6,4 /
"""

# Particles get the rotation of the tiles, and keep a part of their own velocity.
TURNING = """
&method  transfer='rflip'  turn_from='tiles'  stress_update='usavg'  flip=0.99 /
"""

METAL = """
&run  dimension='3d' /
&grid  lo=-5,-5,0  hi=5,5,12  dx=0.5 /
&units  system='mm-us-mg' /
&time  t_end=1000  max_steps=60 /
&effects  thermal=.true. /
&material  name='copper'  preset='cu_ofhc' /
&region  name='rod'  shape='sphere'  centre=0,0,4  radius=4 /
&body  name='rod'  region='rod'  material='copper'  velocity=0,0,-0.6 /
&boundary  face='zlo'  type='symmetry' /
"""


def scenes():
    """Names and decks: elastic, shock with energy and failure, friction, rotation of tiles, brittle failure, metal."""
    decks = {name: deck for name, deck, _ in layouts.decks()}
    for method in ("ddmp", "mpm"):
        decks[f"balls_{method}"] = BALLS.format(method=method)
    decks["turning"] = BALLS.format(method="mpm") + TURNING
    return {**decks, "brittle": BRITTLE, "metal": METAL}


def run(*words, timeout=3000, **environment):
    """Output of a command, which must succeed."""
    answer = subprocess.run([str(word) for word in words], text=True, stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
                            env={**os.environ, **case.OPEN_MPI, **environment}, timeout=timeout, check=False)
    if answer.returncode:
        raise AssertionError(f"{words}: {answer.returncode}\n{answer.stdout[-4000:]}")
    return answer.stdout


def masked(processor):
    """The environment in which a processor is treated as an older one."""
    mask = MASKS[processor]
    return {"GLIBC_TUNABLES": f"glibc.cpu.hwcaps={mask}"} if mask else {}


def cached(build, name):
    """A value in the CMake cache."""
    return re.search(rf"^{name}:\w+=(.*)$", (build / "CMakeCache.txt").read_text(encoding="utf-8"), re.M).group(1)


@pytest.fixture(scope="module")
def place(file_options):
    """An installation that was moved; made from the build of the tested program, if that is a build for dispatch."""
    if os.uname().machine != "x86_64":
        pytest.skip("this machine is no x86-64")
    given = file_options.scree.parents[1]
    build = given
    if cached(given, "SCREE_ARCH") != "dispatch":
        build = file_options.work / "build"
        same = [f"-D{name}={cached(given, name)}" for name in
                ("CMAKE_Fortran_COMPILER", "SCREE_H5PFC", "SCREE_MPI")]
        run("cmake", "-S", case.ROOT, "-B", build, "-G", cached(given, "CMAKE_GENERATOR"), *same,
            "-DSCREE_ARCH=dispatch", "-DBUILD_TESTING=OFF")
        run("cmake", "--build", build, "--parallel", "2")
    first, moved = file_options.work / "first", file_options.work / "moved ü"
    for folder in (first, moved):
        shutil.rmtree(folder, ignore_errors=True)
    run("cmake", "--install", build, "--prefix", first)
    first.rename(moved)
    return moved


@pytest.fixture(scope="module")
def usable(place):
    """The processors of MASKS that this one can emulate, determined by the program that starts."""
    folders = {path.parent.name for path in place.rglob("glibc-hwcaps/*/libscree.so")}
    assert folders == set(MASKS) - {"x86-64"}, folders
    found = []
    for processor in MASKS:
        told = run(place / "bin/scree", "--version", **masked(processor))
        if re.search(rf" -march={processor} ", told):
            found.append(processor)
    assert "x86-64" in found, "with AVX2 masked the first library is chosen"
    return found


def test_choice(place, usable, sheet):
    """The program and the package scree select the same library, by default the newest that the processor supports."""
    flags = run("cat", "/proc/cpuinfo")
    newest = "x86-64-v4" if " avx512vl" in flags else "x86-64-v3" if " avx2" in flags else "x86-64"
    for processor in usable:
        code = "from scree import library; print(library.find_library()); library.load(library.find_library())"
        found = run(sys.executable, "-c", code, SCREE=str(place / "bin/scree"), SCREE_LIBRARY="",
                    PYTHONPATH=str(case.ROOT / "python/src"), **masked(processor)).strip()
        wanted = "libscree.so" if processor == "x86-64" else f"glibc-hwcaps/{processor}/libscree.so"
        sheet.require(found.endswith(f"/{wanted}") and (processor != "x86-64" or "hwcaps" not in found),
                      f"{processor}: the package loads {found}")
    told = run(place / "bin/scree", "--version")
    sheet.require(f"-march={newest} " in told, f"without a mask kernels for {newest}: {told}")


def test_same_bits(options, place, usable, sheet):
    """Would catch sums that wider vectors add in another order, and products that are fused with sums."""
    options.scree = place / "bin/scree"
    for name, deck in scenes().items():
        digests = {}
        for processor in usable:
            box = case.Case(options, f"{name}_{processor}", deck, threads=2)
            box.run("-q", env=masked(processor))
            digests[processor] = box.summary["digest"]
            sheet.require(box.summary["steps"] >= 50, f"{name}: the run makes many steps")
            if name == "brittle":
                failed = box.snapshots()[-1][1].fields["failed"]
                sheet.require(0.0 < failed.mean() < 1.0, f"{name}: some particles failed")
        sheet.require(len(set(digests.values())) == 1, f"{name}: same bits, {digests}")
    for processor in MASKS:
        if processor not in usable:
            sheet.skipped(processor, "this processor does not have its instructions")


def test_instructions(place, sheet):
    """Would catch a layer, or the program itself, that is compiled for a newer processor than its library is for."""
    if shutil.which("objdump") is None:
        pytest.skip("objdump is not installed")
    libraries = {path.parent.name: path for path in place.rglob("libscree.so")}
    (first,) = [path for name, path in libraries.items() if not name.startswith("x86-64")]
    count = {}
    for name, file in (("program", place / "bin/scree"), ("x86-64", first), ("x86-64-v3", libraries["x86-64-v3"]),
                       ("x86-64-v4", libraries["x86-64-v4"])):
        text = run("objdump", "-d", "--no-show-raw-insn", file)
        count[name] = {"all": text.count("\n"), "AVX-512": len(AVX512.findall(text)), "AVX": len(AVX.findall(text)),
                       "later": len(LATER.findall(text))}
        del text
    sheet.note("instructions", count)
    for name in ("program", "x86-64"):
        for kind in ("AVX-512", "AVX", "later"):
            sheet.require(count[name][kind] == 0, f"{name}: {count[name][kind]} instructions of {kind}")
    sheet.require(count["x86-64-v3"]["AVX-512"] == 0, "no AVX-512 in the library for AVX2")
    sheet.above("AVX in the library for AVX2", count["x86-64-v3"]["AVX"], 10000)
    sheet.above("AVX-512 in the library for AVX-512", count["x86-64-v4"]["AVX-512"], 10000)
    sheet.above("instructions of the first library", count["x86-64"]["all"], 100000)
