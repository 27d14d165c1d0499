# SPDX-License-Identifier: BSD-3-Clause
"""ParaView opens the files of a run; skipped where pvbatch or a virtual display is missing.

Would catch a layout that the VTK wheels read and the readers of ParaView do not, a series that ParaView shows with
other times, particles or fields that are lost, and a view script or a state file that no longer works.
"""

import json
import os
import re
import shutil
import subprocess
from pathlib import Path

import h5py
import numpy as np
import PIL.Image
import pytest

import post_command

# Runs in the Python of ParaView: prints the content of the given files at each time.
READS = """
import json, sys
from paraview.simple import Delete, OpenDataFile
from paraview import servermanager
from vtkmodules.util.numpy_support import vtk_to_numpy
seen = {}
for name in sys.argv[1:]:
    reader = OpenDataFile(name)
    seen[name] = []
    for time in reader.TimestepValues:
        reader.UpdatePipeline(time)
        data = servermanager.Fetch(reader)
        arrays = data.GetPointData()
        seen[name].append({
            "time": time, "points": data.GetNumberOfPoints(), "cells": data.GetNumberOfCells(),
            "bounds": data.GetBounds(),
            "means": {arrays.GetArrayName(n): vtk_to_numpy(arrays.GetArray(n)).mean(axis=0, dtype=float).tolist()
                      for n in range(arrays.GetNumberOfArrays())}})
    Delete(reader)
print("SEEN " + json.dumps(seen))
"""


# Opens a state file: prints the time and the half height of its view, and saves a picture.
OPENS = """
import json, sys
from paraview.simple import GetViews, LoadState, Render, SaveScreenshot, _DisableFirstRenderCameraReset
_DisableFirstRenderCameraReset()
LoadState(sys.argv[1])
(view,) = GetViews()
Render(view)
SaveScreenshot(sys.argv[2], view)
print("SEEN " + json.dumps([view.ViewTime, view.CameraParallelScale]))
"""


def command():
    """ParaView without a window, on a virtual display; None if one of the two is missing."""
    pvbatch, screen = shutil.which("pvbatch"), shutil.which("xvfb-run")
    if not pvbatch:
        return None
    if os.environ.get("DISPLAY"):
        return [pvbatch]
    # a virtual display that restarts after its last window has closed refuses the next window for a moment
    return [screen, "-a", "-s", "-noreset -screen 0 1400x1000x24", pvbatch] if screen else None


def expected(path):
    """Content of a snapshot: time, number and bounds of particles, means of fields."""
    with h5py.File(path) as file:
        data = file["VTKHDF"]
        points = data["Points"][:]
        return {"time": float(data["FieldData/TimeValue"][0]), "points": len(points), "cells": len(points),
                "sizes": {name: np.abs(field[:]).max() for name, field in data["PointData"].items()},
                "bounds": np.column_stack([points.min(axis=0), points.max(axis=0)]).ravel(),
                "means": {name: np.mean(field[:], axis=0, dtype=float)
                          for name, field in data["PointData"].items()}}


def compare(sheet, name, found, wanted):
    """All times of one file."""
    sheet.require(len(found) == len(wanted) > 2, f"{name}: {len(found)} times, {len(wanted)} snapshots")
    for one, other in zip(found, wanted):
        at = f"{name} at {other['time']:.3g}"
        sheet.require(one["points"] == other["points"] and one["cells"] == other["cells"],
                      f"{at}: {one['points']} points and {one['cells']} cells of {other['points']}")
        sheet.require(np.allclose(one["time"], other["time"], rtol=1e-9), f"{at}: time {one['time']}")
        sheet.require(np.allclose(one["bounds"], other["bounds"], rtol=1e-6), f"{at}: bounds {one['bounds']}")
        sheet.require(set(one["means"]) == set(other["means"]), f"{at}: fields {sorted(one['means'])}")
        for field, mean in other["means"].items():
            sheet.require(np.allclose(one["means"][field], mean, rtol=1e-9, atol=1e-12 * other["sizes"][field]),
                          f"{at}: mean {field} {one['means'][field]}, not {mean}")


def test_paraview(options, sheet):
    """A short run, opened by ParaView."""
    start = command()
    if not start:
        pytest.skip("pvbatch, or xvfb-run for it, is not installed")
    shutil.rmtree(options.work / "mine", ignore_errors=True)
    folder = options.work / "mine"
    subprocess.run([options.scree, "--new", "two_discs", folder], check=True, capture_output=True)
    subprocess.run([options.scree, "--quiet", "two_discs.nml", "--set", "grid.dx=0.05", "--set", "time.t_end=0.5",
                    "--set", "output[discs].fields='velocity','stress','affine','body','mass'", "--set",
                    "method.transfer=apic"],
                   cwd=folder, check=True)
    results = folder / "out/two_discs"
    wanted = [expected(path) for path in sorted(results.glob("two_discs_p_[0-9]*.hdf"))]
    (folder / "reads.py").write_text(READS, encoding="utf-8")
    names = [str(results / "two_discs_p.hdf.series")]
    answer = subprocess.run([*start, folder / "reads.py", *names], capture_output=True, text=True, check=False)
    said = [line for line in answer.stdout.splitlines() if line.startswith("SEEN ")]
    sheet.require(bool(said), f"ParaView ended with {answer.returncode}: {answer.stdout}{answer.stderr}")
    for name, found in json.loads(said[0][5:]).items() if said else ():
        compare(sheet, Path(name).name, found, wanted)
    answer = subprocess.run([*start, "view.py", "out/two_discs", "view.png"], cwd=folder, capture_output=True,
                            text=True, check=False)
    picture = folder / "view.png"
    sheet.require(picture.is_file() and picture.stat().st_size > 5000, f"view.py: {answer.stdout}{answer.stderr}")


def halves(picture):
    """Numbers of coloured pixels left and right of the middle of a picture; grey pixels are letters and the
    background."""
    pixels = np.asarray(PIL.Image.open(picture).convert("RGB")).astype(int)[:, 100:1450]
    coloured = np.ptp(pixels, axis=2) > 30
    middle = 700                                         # of 1600 pixels, of which 100 are cut off
    return int(coloured[:, :middle].sum()), int(coloured[:, middle:].sum())


def test_script_and_state(options, sheet):
    """The script that scree-post paraview writes for an axisymmetric run shows both halves at the last time, and so
    does the state file.

    Would catch a script or state that ParaView refuses, a window that does not show the particles, one half only, and
    another time."""
    start = command()
    if not start or not shutil.which("pvpython"):
        pytest.skip("pvbatch and pvpython, or xvfb-run for them, are not installed")
    work = post_command.run_cases(options, "debris_cloud")
    folder = work / "out/debris_cloud"
    answer = post_command.call("paraview", folder, "--colour", "damage")
    script, state = folder / "debris_cloud_view.py", folder / "debris_cloud_view.pvsm"
    sheet.require(answer.returncode == 0 and state.is_file(), f"scree-post: {answer.stdout}{answer.stderr}")
    (work / "opens.py").write_text(OPENS, encoding="utf-8")
    answers = [subprocess.run([*start, *words], capture_output=True, text=True, check=False) for words in (
        (script, work / "script.png"), (work / "opens.py", state, work / "state.png"))]
    said = [line for line in answers[1].stdout.splitlines() if line.startswith("SEEN ")]
    sheet.require(bool(said), f"the state: {answers[1].stdout}{answers[1].stderr}")
    last = expected(sorted(folder.glob("debris_cloud_p_[0-9]*.hdf"))[-1])
    time, half_height = json.loads(said[0][5:])
    sheet.require(np.isclose(time, last["time"], rtol=1e-9), f"time {time} of the state")
    text = script.read_text(encoding="utf-8")
    wanted = float(re.search(r"^MIDDLE, HALF_HEIGHT = \[.*\], (\S+)", text, re.M).group(1))
    height = 0.5 * (last["bounds"][5] - last["bounds"][4])
    sheet.require(0.2 * height < half_height < 2.0 * height, f"half height {half_height} of the window, {height}")
    sheet.require(np.isclose(half_height, wanted, rtol=1e-9), f"half height {half_height} of the state, not {wanted}")
    for name in ("script", "state"):
        picture = work / f"{name}.png"
        sheet.require(picture.is_file(), f"{name}: no picture: {answers[0].stdout}{answers[0].stderr}")
        left, right = halves(picture)
        sheet.require(min(left, right) > 500 and 0.8 < left / right < 1.25, f"{name}: pixels {left} and {right}")
