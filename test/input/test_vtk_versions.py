# SPDX-License-Identifier: BSD-3-Clause
# tiers: long
# timeout: 1200
"""Outputs open in the oldest supported version of VTK, 9.2, which is the reader in ParaView 5.11, and in the newest.

Would catch a layout that only newer readers support, and a check that fails by an error of its own in an old version.
Each version is installed into a separate environment, which needs the network; skipped where that fails.
"""

import subprocess
import sys

import pytest

import case

VERSIONS = ("vtk==9.2.6", "vtk")
# Particles, a grid and a slice, with symmetric tensors and integers.
DECK = """&run dimension = 'plane_strain' /
&grid lo = 0 0 0  hi = 1 0.1 1  dx = 0.05 /
&time t_end = 1e-3  cfl = 0.3 /
&material name = 'rubber'  density = 1000  young = 1e6  poisson = 0.3 /
&region name = 'ball'  shape = 'sphere'  centre = 0.5 0.05 0.5  radius = 0.2 /
&body name = 'one'  region = 'ball'  material = 'rubber'  velocity = 1 0 2  spin = 0 3 0 /
&output name = 'points'  kind = 'particles'  count = 3
  fields = 'velocity', 'stress', 'material', 'pressure', 'mass' /
&output name = 'nodes'  kind = 'grid'  count = 3  fields = 'mass', 'velocity' /
"""


def environment(folder, package):
    """The Python of an environment with one package; None if the package cannot be installed."""
    python = folder / "bin/python"
    if not python.exists():
        subprocess.run([sys.executable, "-m", "venv", folder], check=True)
    done = subprocess.run([python, "-m", "pip", "install", "--quiet", package, "h5py", "matplotlib"],
                          capture_output=True, text=True, check=False)
    return python if done.returncode == 0 else None


def test_vtk_versions(options, sheet):
    """One run, read by each version."""
    box = case.Case(options, "outputs", DECK)
    box.run()
    sheet.require(box.code == 0, f"exit code {box.code}: {box.output[-300:]}")
    tried = 0
    for package in VERSIONS:
        python = environment(options.work / package.replace("==", "_"), package)
        if not python:
            sheet.skipped(package, "it cannot be installed here")
            continue
        tried += 1
        lists = sorted(box.folder.rglob("*.hdf.series"))
        sheet.require(len(lists) == 2, f"particles and nodes: {lists}")
        for series in lists:
            answer = subprocess.run([python, "-m", "scree_post", "check", series], capture_output=True, text=True,
                                    check=False, cwd=case.ROOT / "python/src")
            print(f"{package}: {series.name}: {answer.stdout.strip()}")
            sheet.require(answer.returncode == 0, f"{package}: {series.name}: {answer.stdout}{answer.stderr}")
    if not tried:
        pytest.skip("no version of VTK can be installed here")
