# SPDX-License-Identifier: BSD-3-Clause
"""Shows the results of a run in ParaView 5.11 or newer: particles coloured by speed, as balls in 3-D, as dots in 2-D.

    paraview --script=view.py                      # the newest run in out/
    pvbatch view.py FOLDER picture.png             # without a window: a picture of the last time

In the window, press play. Select other fields in the colour list. You can edit this script.
"""

import sys
from pathlib import Path

import numpy as np
from paraview import servermanager
from paraview.simple import (
    ColorBy, GetActiveViewOrCreate, GetAnimationScene, GetColorTransferFunction, GetScalarBar, OpenDataFile, Render,
    ResetCamera, SaveScreenshot, Show)
from vtkmodules.util.numpy_support import vtk_to_numpy


def newest():
    """The folder in out/ that was written last."""
    series = sorted(Path("out").glob("*/*_p.hdf.series"), key=lambda path: path.stat().st_mtime)
    if not series:
        sys.exit("there is nothing in out/ yet: run a deck first")
    return series[-1].parent


def places(series):
    """Particles as the run began: their positions."""
    series.UpdatePipeline(series.TimestepValues[0])
    return vtk_to_numpy(servermanager.Fetch(series).GetPoints().GetData())


def distance(points):
    """The distance of a particle from its nearest, in the middle of some of them."""
    some = points[:: max(len(points) // 30, 1)]
    squares = (np.sum((points - point) ** 2, axis=1) for point in some)
    return float(np.sqrt(np.median([square[square > 0.0].min() for square in squares])))


def show(folder):
    """Particles of a run; the view."""
    series = OpenDataFile(str(next(Path(folder).resolve().glob("*_p.hdf.series"))))
    points = places(series)
    flat = np.ptp(points[:, 1]) == 0.0
    last = series.TimestepValues[-1]
    series.UpdatePipeline(last)
    view = GetActiveViewOrCreate("RenderView")
    view.ViewTime = last
    view.ViewSize = (1200, 800)
    dots = Show(series, view)
    dots.SetRepresentationType("Point Gaussian")
    dots.ShaderPreset = "Plain circle" if flat else "Sphere"
    dots.GaussianRadius = 0.6 * distance(points)
    ColorBy(dots, ("POINTS", "velocity"))
    dots.RescaleTransferFunctionToDataRange(False)
    dots.SetScalarBarVisibility(view, True)
    bar = GetScalarBar(GetColorTransferFunction("velocity"), view)
    bar.Title, bar.ComponentTitle = "speed", ""
    # a plane is that of x and z: look along y, with z upwards
    view.CameraPosition, view.CameraFocalPoint, view.CameraViewUp = (0, -1, 0), (0, 0, 0), (0, 0, 1)
    ResetCamera(view)
    GetAnimationScene().UpdateAnimationUsingDataTimeSteps()
    Render(view)
    return view


shown = show(sys.argv[1] if len(sys.argv) > 1 else newest())
if len(sys.argv) > 2:
    SaveScreenshot(sys.argv[2], shown)
    print(f"wrote {sys.argv[2]}")
