# SPDX-License-Identifier: BSD-3-Clause
# tiers: full, long
# timeout: 100
# timeout long: 3600
# cores: 2
"""Kernels of the particle loops and of the node phase in loops for a GPU, bench_offload.

Would catch: kernels that give other bits when they are called from such a loop, and, in the tier long, a kernel that
can no longer be compiled for GPUs, because it calls a procedure or reads a constant that is not marked for them. No GPU
is needed: the loops run on the host.
"""

import os
import re
import subprocess

import pytest

import case

KERNELS = ("space_motion", "add_edges", "gather_gradient", "gather_motion", "find_local", "assemble", "combine",
           "divide_motion", "centre_gradient", "predict_deviator")
DIGEST = re.compile(r"^digest (\w{16})  (\w{16})  (\w{16})$", re.M)


def run(*words, **environment):
    """Output of a command, which must succeed."""
    answer = subprocess.run([str(word) for word in words], text=True, stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
                            env={**os.environ, **environment}, check=False)
    if answer.returncode:
        raise AssertionError(f"{words}: {answer.returncode}\n{answer.stdout[-4000:]}")
    return answer.stdout


def cached(build, name):
    """A value in the CMake cache."""
    return re.search(rf"^{name}:\w+=(.*)$", (build / "CMakeCache.txt").read_text(encoding="utf-8"), re.M).group(1)


def digests(program, threads, **environment):
    """Digests at the start, after steps in threads, and after steps in the loops for a device."""
    return DIGEST.search(run(program, "3", "20", OMP_NUM_THREADS=str(threads), **environment)).groups()


def test_bits_here(options, sheet):
    """Without a second compiler, for any number of threads."""
    program = options.scree.parent / "bench_offload"
    if not program.is_file():
        pytest.skip("bench_offload is not built beside the program")
    found = {threads: digests(program, threads) for threads in (1, 2)}
    before, threads, device = found[1]
    sheet.require(before != threads, "the particles move")
    sheet.require(threads == device, f"same bits in loops for a device: {found[1]}")
    sheet.require(found[1] == found[2], f"same bits in two threads: {found}")


@pytest.mark.tiers("long")
def test_compiled_for_gpus(options, sheet):
    """With the second compiler: the program contains the kernels in the language of NVIDIA GPUs, and gives the same
    bits where there is no GPU."""
    given = options.scree.parents[1]
    compiler = cached(given, "CMAKE_Fortran_COMPILER")
    tool = run(compiler, "-print-file-name=accel/nvptx-none/mkoffload").strip()
    if not os.path.isabs(tool):
        pytest.skip("the compiler has no second one for nvptx: on Debian apt-get install gcc-12-offload-nvptx")
    build = options.work / "build"
    same = [f"-D{name}={cached(given, name)}" for name in ("CMAKE_Fortran_COMPILER", "SCREE_H5PFC", "SCREE_MPI")]
    run("cmake", "-S", case.ROOT, "-B", build, "-G", cached(given, "CMAKE_GENERATOR"), *same, "-DSCREE_OFFLOAD=ON")
    run("cmake", "--build", build, "--parallel", "2", "--target", "bench_offload")
    program = build / "bin/bench_offload"
    text = program.read_bytes()
    sheet.require(b".target sm_" in text, "the program holds code for GPUs")
    for kernel in KERNELS:
        sheet.require(re.search(rb"\.func[^\n]*_MOD_%s\b" % kernel.encode(), text),
                      f"{kernel} is compiled for GPUs")
    for way in ("DISABLED", "DEFAULT"):
        before, threads, device = digests(program, 2, OMP_TARGET_OFFLOAD=way)
        sheet.require(before != threads == device, f"{way}: same bits {before} {threads} {device}")
