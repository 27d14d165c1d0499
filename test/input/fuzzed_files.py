# SPDX-License-Identifier: BSD-3-Clause
"""A small deck with an undamaged input file of each kind, and the program that damages them."""

import os
import re
import shutil
import subprocess

import h5py
import numpy as np

import case
from scree_post import state_table

# One cube per file.
DECK = """
&run dimension = '3d' /
&grid lo = 0 0 0  hi = 5 1 1  dx = 0.25 /
&time t_end = 1e-6  max_steps = 2 /
&effects strength = .true.  gravity = .true.  gravity_vector = 0 0 -1  gravity_table = 'gravity.csv' /
&material name = 'metal'  density = 1000  bulk = 1e9  shear = 5e8 /
&material name = 'gas'  density = 1.0  strength_model = 'newtonian'  viscosity = 0
  eos_model = 'table'  eos_table = 'states.txt'  table_temperature = 300 /
&region name = 'text'  shape = 'stl'  file = 'text.stl'  translate = 0 0 0 /
&region name = 'binary'  shape = 'stl'  file = 'binary.stl'  translate = 1 0 0 /
&region name = 'points'  shape = 'points'  file = 'points.csv'  translate = 3 0 0 /
&region name = 'gas'  shape = 'box'  lo = 4 0 0  hi = 5 1 1 /
&region name = 'land'  shape = 'terrain'  file = 'land.asc' /
&boundary region = 'land'  type = 'slip' /
&body name = 'text'    region = 'text'    material = 'metal' /
&body name = 'binary'  region = 'binary'  material = 'metal' /
&body name = 'points'  region = 'points'  material = 'metal'  packing = 'file' /
&body name = 'gas'     region = 'gas'     material = 'gas' /
&boundary face = 'xhi'  type = 'velocity'  table = 'motion.csv' /
&output name = 'h'  kind = 'history'  every = 1 /
"""
# HDF5 files: the HDF5 library itself may crash on damage, so each file is read by a separate process.
HDF5_DECK = """
&run dimension = '3d' /
&grid lo = 0 0 0  hi = 2 1 1  dx = 0.25 /
&time t_end = 1  max_steps = 0 /
&material name = 'metal'  density = 1000  bulk = 1e9  shear = 5e8 /
&region name = 'image'  shape = 'voxel'  file = 'image.h5' /
&region name = 'points'  shape = 'points'  file = 'points.hdf'  translate = 1 0 0 /
&body name = 'points'  region = 'points'  material = 'metal'  packing = 'file' /
"""
HDF5_SOURCE = """
&run dimension = '3d' /
&grid lo = 0 0 0  hi = 1 1 1  dx = 0.25 /
&time t_end = 1  max_steps = 0 /
&material name = 'metal'  density = 1000  bulk = 1e9  shear = 5e8 /
&region name = 'ball'  shape = 'sphere'  centre = 0.5 0.5 0.5  radius = 0.3 /
&body name = 'one'  region = 'ball'  material = 'metal' /
&output name = 'p'  kind = 'particles'  count = 1 /
"""
# Sanitizers stop at the first error and show where; a request for too much memory fails as it does without them.
ENVIRONMENT = {**os.environ, **case.OPEN_MPI, "OMP_NUM_THREADS": "1", "UBSAN_OPTIONS": "halt_on_error=1",
               "GFORTRAN_ERROR_BACKTRACE": "0",
               "ASAN_OPTIONS": "detect_leaks=0:allocator_may_return_null=1"}
CORNERS = np.array([[k & 1, k >> 1 & 1, k >> 2 & 1] for k in range(8)], dtype="f4") * 0.5 + 0.25
CUBE = CORNERS[np.array([(0, 2, 1), (1, 2, 3), (4, 5, 6), (5, 7, 6), (0, 1, 4), (1, 5, 4), (2, 6, 3), (3, 6, 7),
                         (0, 4, 2), (2, 4, 6), (1, 3, 5), (3, 7, 5)])]


def text_facets():
    """A cube as STL, text."""
    rows = ["solid cube"]
    for facet in CUBE:
        rows += ["facet normal 0 0 0", "outer loop", *(f"vertex {x:g} {y:g} {z:g}" for x, y, z in facet),
                 "endloop", "endfacet"]
    return "\n".join([*rows, "endsolid cube", ""]).encode()


def binary_facets():
    """The same cube as STL, binary."""
    record = np.zeros(len(CUBE), dtype=[("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("rest", "<u2")])
    record["corners"] = CUBE
    return b"cube".ljust(80) + np.uint32(len(CUBE)).tobytes() + record.tobytes()


def write_all(folder):
    """Write the deck and its files; their paths, the deck first."""
    folder.mkdir(parents=True, exist_ok=True)
    axis = (np.arange(4) + 0.5) / 4
    points = "\n".join(["x, y, z, volume", *(f"{x}, {y}, {z}, 0.015625" for x in axis for y in axis for z in axis), ""])
    files = {
        "deck.nml": DECK.encode(),
        "text.stl": text_facets(),
        "binary.stl": binary_facets(),
        "points.csv": points.encode(),
        "gravity.csv": b"t, gx, gy, gz\n0, 1, 2, 3\n0.5, 0, 0, 1e-3\n1, 4, 5, 6\n",
        "land.asc": b"ncols 5\nnrows 1\nxllcenter 0.5\nyllcorner 0\ncellsize 1\n0.1 0.2 0.1 0 0.1\n",
        "motion.csv": b"t, vx, vy, vz\n0 1 2 3\n0.5 0 0 1e-3\n1 4 5 6\n",
    }
    axes = state_table.axis(0.1, 10.0, 5), state_table.axis(100.0, 3000.0, 5)
    state_table.write(folder / "states.txt", *axes, *state_table.ideal_gas(*axes, 1.4, 717.5), "gas")
    for name, content in files.items():
        (folder / name).write_bytes(content)
    return [folder / "deck.nml", *(folder / name for name in sorted([*files, "states.txt"]) if name != "deck.nml")]


def fuzz(program, work, paths, first, count, timeout):
    """Make mutations, starting at a given number; exit code, output, and number of files that are refused by name."""
    work.mkdir(parents=True, exist_ok=True)
    answer = subprocess.run([str(word) for word in (program, work, first, count, *paths)],
                            stdout=subprocess.PIPE, stderr=subprocess.STDOUT, timeout=timeout, check=False,
                            env=ENVIRONMENT)
    output = answer.stdout.decode(errors="replace")
    return answer.returncode, output, {name: int(n) for name, n in re.findall(r"^(\S+): (\d+) refused$", output, re.M)}


def write_hdf5(options, folder):
    """Write a deck with voxels and particles in HDF5 files: paths of the deck and of the two files."""
    run = case.Case(options, "source", HDF5_SOURCE).run("-q")
    folder.mkdir(parents=True, exist_ok=True)
    deck, voxels, points = folder / "deck.nml", folder / "image.h5", folder / "points.hdf"
    deck.write_text(HDF5_DECK, encoding="utf-8")
    shutil.copyfile(run.path("_p_000000.hdf"), points)
    with h5py.File(voxels, "w") as file:
        file.create_dataset("voxels", data=np.ones((4, 4, 4), dtype="u1"), compression="gzip").attrs["spacing"] = 0.25
    return deck, voxels, points


def damaged(chance, whole):
    """The bytes of a file after damage: flipped bits, numbers of extreme values, or a missing end."""
    data = bytearray(whole)
    if chance.random() < 0.15:
        return bytes(data[:chance.randrange(len(data))])
    for _ in range(chance.choice([1, 1, 2, 5, 20])):
        place = chance.randrange(len(data))
        if chance.random() < 0.5:
            data[place] ^= 1 << chance.randrange(8)
        else:
            width = chance.choice([1, 2, 4, 8])
            data[place:place + width] = bytes([chance.choice([0, 127, 255])]) * width
    return bytes(data)
