# SPDX-License-Identifier: BSD-3-Clause
"""Writes a script that opens a run in ParaView 5.11 or newer: particles of their size, by a field.

    paraview --script=CASE_view.py               # in a window: press play
    pvbatch CASE_view.py picture.png             # without a window: the last time as a picture

Other fields are in the list of colours of ParaView. The script is a start; change it as you like.
"""
from __future__ import annotations

import argparse
import os

import numpy as np

from scree.drawing import colour as colours
from scree.drawing import look
from scree.drawing.shape import particle_size
from scree.errors import EXIT_USAGE, ScreeError
from scree.files import series, series_file, snapshot

SUMMARY = "a script that opens a run in ParaView, with colours and camera"
EXAMPLES = ("paraview out/two_discs --colour pressure", "paraview out/debris_cloud_3d --out cloud.py")
PRESETS = {"viridis": "Viridis (matplotlib)", "inferno": "Inferno (matplotlib)", "magma": "Magma (matplotlib)",
           "plasma": "Plasma (matplotlib)", "coolwarm": "Cool to Warm"}
SPREAD = 0.6             # radius of a dot over the width of a particle

SCRIPT = '''# SPDX-License-Identifier: BSD-3-Clause
"""Opens a run in ParaView 5.11 or newer; written by scree-post paraview.

{title}

    paraview --script={name}
    pvbatch {name} picture.png
"""
import sys
from pathlib import Path

from paraview.simple import (
    AnnotateTimeFilter, ColorBy, GetActiveViewOrCreate, GetAnimationScene, GetColorTransferFunction, GetScalarBar,
    OpenDataFile, Render, ResetCamera, SaveScreenshot, Show)

SERIES = Path({series!r})
FIELD, COMPONENT = {field!r}, {component!r}              # of a vector "Magnitude"
FIELDS = {fields!r}
LABEL, UNIT = {label!r}, {unit!r}
LOW, HIGH, PRESET = {low!r}, {high!r}, {preset!r}        # in the unit of the file
RADIUS = {radius!r}                                      # of a dot, in the unit of the file
FLAT = {flat!r}                                          # a run in a plane: look along y

particles = OpenDataFile(str(SERIES if SERIES.exists() else Path.cwd() / SERIES.name))
view = GetActiveViewOrCreate("RenderView")
view.ViewTime = particles.TimestepValues[-1]
view.ViewSize = [1600, 1000]
view.UseColorPaletteForBackground = 0
view.Background = [1.0, 1.0, 1.0]
view.OrientationAxesLabelColor = [0.0, 0.0, 0.0]
dots = Show(particles, view)
dots.SetRepresentationType("Point Gaussian")
dots.ShaderPreset = "Plain circle" if FLAT else "Sphere"
dots.GaussianRadius = RADIUS
ColorBy(dots, ("POINTS", FIELD, COMPONENT) if COMPONENT else ("POINTS", FIELD))
colours = GetColorTransferFunction(FIELD)
colours.ApplyPreset(PRESET, True)
colours.RescaleTransferFunction(LOW, HIGH)
bar = GetScalarBar(colours, view)
bar.Title, bar.ComponentTitle = f"{{LABEL}} [{{UNIT}}]" if UNIT else LABEL, ""
bar.TitleColor = bar.LabelColor = [0.0, 0.0, 0.0]
dots.SetScalarBarVisibility(view, True)
clock = Show(AnnotateTimeFilter(particles), view)
clock.Color = [0.0, 0.0, 0.0]
view.CameraParallelProjection = 1
view.CameraFocalPoint = [0.0, 0.0, 0.0]
view.CameraPosition = [0.0, -1.0, 0.0] if FLAT else [0.47, -0.81, 0.34]
view.CameraViewUp = [0.0, 0.0, 1.0]
ResetCamera(view)
GetAnimationScene().UpdateAnimationUsingDataTimeSteps()
GetAnimationScene().GoToLast()
Render(view)
if len(sys.argv) > 1 and sys.argv[-1].endswith(".png"):
    SaveScreenshot(sys.argv[-1], view)
    print(f"wrote {{sys.argv[-1]}}")
'''


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """The options."""
    parser.add_argument("source", metavar="SERIES", help="CASE_p.hdf.series or out/CASE")
    parser.add_argument("--colour", "--color", metavar="FIELD",
                        help="a field, or a component such as velocity.z or stress.xx (velocity)")
    parser.add_argument("--out", metavar="PY", help="script; default CASE_view.py beside the series")


def script_of(source: str, name: str | None, out: str) -> str:
    """The text of the script."""
    file = series(source)[-1][1]
    snap = snapshot(file, own_units=True)                # ParaView shows the numbers of the file
    if len(snap.points) == 0:
        raise ScreeError(f"{file} holds no particles", EXIT_USAGE)
    name = name or "velocity"
    values = colours.values_of(snap, name)
    field, part = colours.field_of(name)
    if field not in snap.fields:
        raise ScreeError(f"{name} is no field of the files, which ParaView needs", EXIT_USAGE)
    low, high = colours.sensible(values[np.isfinite(values)])
    signed = low < 0.0 < high and min(-low, high) > 0.1 * max(-low, high)
    if signed:
        low, high = -max(-low, high), max(-low, high)
    vector = snap.fields[field].ndim == 2
    size = particle_size(snapshot(file, ("volume",)), snapshot(file, ()).points[:, 0])
    unit = snap.units.get(field, "1")
    metres = np.abs(snap.points).max() / max(np.abs(snapshot(file, ()).points).max(), 1.0e-300)
    return SCRIPT.format(
        title=(snap.title or os.path.basename(source)).replace('"""', "'"), name=os.path.basename(out),
        series=os.path.abspath(source), field=field, component=part.upper() if part else "Magnitude" if vector else "",
        fields=sorted(snap.fields), label=colours.label_of(snap, name), unit="" if unit == "1" else unit,
        low=float(low), high=float(high), preset=PRESETS[look.SIGNED if signed else look.SEQUENTIAL],
        radius=float(SPREAD * metres * np.median(size)), flat=snap.dimension != "3d")


def run(arguments: argparse.Namespace) -> int:
    """Read the last snapshot, write the script."""
    source = series_file(arguments.source)
    out = arguments.out or f"{os.path.splitext(os.path.splitext(source)[0])[0].removesuffix('_p')}_view.py"
    if not out.endswith(".py"):
        raise ScreeError(f"--out {out}: write a .py", EXIT_USAGE)
    text = script_of(source, arguments.colour, out)
    compile(text, out, "exec")
    try:
        with open(out, "w", encoding="utf-8") as file:
            file.write(text)
    except OSError as error:
        raise ScreeError(f"cannot write {out}: {error.strerror}") from error
    print(f"wrote {out}: paraview --script={out}")
    return 0
