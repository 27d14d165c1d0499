# SPDX-License-Identifier: BSD-3-Clause
"""Writes a script that opens a run in ParaView 5.11 or newer, with particles coloured by a field.

If pvpython of ParaView is installed, a state file with the same content is written too.

    paraview --state=CASE_view.pvsm              # in a window: press play
    paraview --script=CASE_view.py               # the same
    pvbatch CASE_view.py picture.png             # without a window: the last time as a picture

Both halves of axisymmetric runs are shown, and models with mirror planes are completed. The window
contains all particles, or only the moving ones if all particles extend over more than twice their
range. Select other fields in the colour list of ParaView. You can edit the script.
"""
from __future__ import annotations

import argparse
import os
import shlex
import shutil
import subprocess

import numpy as np

from scree.drawing import colour as colours
from scree.drawing import look
from scree.drawing.box import mirror_plane
from scree.drawing.shape import mirror_faces, particle_size
from scree.drawing.space import basis, framed
from scree.drawing.view import Matter, Options, fields_for, matter
from scree.errors import EXIT_USAGE, ScreeError
from scree.files import Snapshot, beside, series, series_file, snapshot

SUMMARY = "a script and a state file that open a run in ParaView"
EXAMPLES = ("paraview out/two_discs --colour pressure", "paraview out/debris_cloud_3d --out cloud.py")
PRESETS = {"viridis": "Viridis (matplotlib)", "inferno": "Inferno (matplotlib)", "magma": "Magma (matplotlib)",
           "plasma": "Plasma (matplotlib)", "coolwarm": "Cool to Warm"}
SPREAD = 0.6             # radius of a dot over the width of a particle
PAGE = (1600, 1000)      # width and height of the window [pixels]
MARGIN = 1.15            # of the window over what it shows
LONGEST = 120.0          # longest time for pvpython [s]

SCRIPT = '''# SPDX-License-Identifier: BSD-3-Clause
"""Opens a run in ParaView 5.11 or newer; written by scree-post paraview.

    paraview --script=SCRIPT          # this file
    pvbatch SCRIPT picture.png        # or a state file, picture.pvsm
"""
import sys
from pathlib import Path

from paraview.simple import (
    AnnotateTimeFilter, ColorBy, GetActiveViewOrCreate, GetAnimationScene, GetColorTransferFunction, GetScalarBar,
    OpenDataFile, Reflect, Render, SaveScreenshot, SaveState, Show, _DisableFirstRenderCameraReset)

TITLE = {title!r}
SERIES = Path({series!r})
FIELD, COMPONENT = {field!r}, {component!r}              # of a vector "Magnitude"
FIELDS = {fields!r}
LABEL, UNIT = {label!r}, {unit!r}
LOW, HIGH, PRESET = {low!r}, {high!r}, {preset!r}        # in the unit of the file
RADIUS = {radius!r}                                      # of a dot, in the unit of the file
MIRRORS = {mirrors!r}                                    # axis and place of planes of symmetry
FLAT = {flat!r}                                          # a run in a plane: look along y
MIDDLE, HALF_HEIGHT = {middle!r}, {half_height!r}        # of the window
CLOCK, SECOND = {clock!r}, {second!r}                    # factor and unit of the time that is shown

_DisableFirstRenderCameraReset()                         # the camera stays as it is set below
particles = OpenDataFile(str(SERIES if SERIES.exists() else Path.cwd() / SERIES.name))
model = particles
for axis, place in MIRRORS:
    model = Reflect(Input=model, Plane=axis, Center=place, FlipAllInputArrays=1)
view = GetActiveViewOrCreate("RenderView")
view.ViewTime = particles.TimestepValues[-1]
view.ViewSize = {page!r}
view.UseColorPaletteForBackground = 0
view.Background = [1.0, 1.0, 1.0]
view.OrientationAxesLabelColor = [0.0, 0.0, 0.0]
dots = Show(model, view)
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
time = AnnotateTimeFilter(particles)
time.Format, time.Scale = f"t = {{{{time:.4g}}}} {{SECOND}}", CLOCK
clock = Show(time, view)
clock.Color = [0.0, 0.0, 0.0]
view.CameraParallelProjection = 1
view.CameraFocalPoint = MIDDLE
view.CameraPosition = [middle + 10.0 * HALF_HEIGHT * way for middle, way in zip(MIDDLE, {towards!r})]
view.CameraViewUp = [0.0, 0.0, 1.0]
view.CameraParallelScale = HALF_HEIGHT
scene = GetAnimationScene()
scene.UpdateAnimationUsingDataTimeSteps()
scene.AnimationTime = particles.TimestepValues[-1]
Render(view)
wanted = sys.argv[-1] if len(sys.argv) > 1 else ""
if wanted.endswith(".png"):
    SaveScreenshot(wanted, view)
    print(f"wrote {{wanted}}")
elif wanted.endswith(".pvsm"):
    SaveState(wanted)
    print(f"wrote {{wanted}}")
'''


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """The options."""
    parser.add_argument("source", metavar="SERIES", help="CASE_p.hdf.series or out/CASE")
    parser.add_argument("--colour", "--color", metavar="FIELD",
                        help="a field, speed, or a component such as velocity.z or stress.xx (speed)")
    parser.add_argument("--out", metavar="PY", help="script; default CASE_view.py in the folder of the series. The "
                        "state file is written to the same folder")


def range_of(snap: Snapshot, name: str) -> tuple[float, float, str]:
    """Ends of the colour bar, in the unit of the file, and the colour map; symmetric if the sign changes."""
    values = colours.values_of(snap, name)
    low, high = colours.sensible(values[np.isfinite(values)])
    if low < 0.0 < high and min(-low, high) > 0.1 * max(-low, high):
        return -max(-low, high), max(-low, high), PRESETS[look.SIGNED]
    return low, high, PRESETS[look.SEQUENTIAL]


def mirrors_of(snap: Snapshot) -> list[tuple[int, float]]:
    """Axes and positions [m] of the mirror planes of the model; in an axisymmetric run its axis
    is one."""
    planes = [(axis, mirror_plane(snap, axis, face) or 0.0) for axis, face in mirror_faces(snap)]
    return [(0, 0.0), *planes] if snap.dimension == "axisymmetric" else planes


def window_of(part: Matter, flat: bool) -> tuple[list[float], float, list[float]]:
    """Middle and half height of the window [m], and the direction to the camera."""
    right, up, towards = basis(*((-90.0, 0.0) if flat else (-60.0, 20.0)))
    points = framed([part])[0].points
    ends = [((points @ way).min(), (points @ way).max()) for way in (right, up, towards)]
    middle = sum(0.5 * (low + high) * way for (low, high), way in zip(ends, (right, up, towards)))
    wide, high = (0.5 * (last - first) for first, last in ends[:2])
    half = MARGIN * max(high, wide * PAGE[1] / PAGE[0], 1.0e-12)
    return np.asarray(middle).tolist(), float(half), towards.tolist()


def script_of(source: str, name: str | None) -> str:
    """The text of the script."""
    file = series(source)[-1][1]
    snap = snapshot(file, own_units=True)                # ParaView shows the numbers of the file
    if len(snap.points) == 0:
        raise ScreeError(f"{file} holds no particles", EXIT_USAGE)
    name = name or "velocity"
    name = colours.present(snap, name)
    low, high, preset = range_of(snap, name)
    field, part = colours.field_of(name)
    if field not in snap.fields:
        raise ScreeError(f"{name} is not a field of the files; ParaView needs one", EXIT_USAGE)
    vector = snap.fields[field].ndim == 2
    si = snapshot(file, fields_for(name) | {"velocity"})
    flat = si.dimension != "3d"
    middle, half_height, towards = window_of(matter(si, Options(colours.Colour(name, name))), flat)
    metres = float(np.abs(snap.points).max() / max(np.abs(si.points).max(), 1.0e-300))
    clock, second = look.scaled(abs(si.time), "s")
    unit = snap.units.get(field, "1")
    return SCRIPT.format(
        title=snap.title or os.path.basename(source),
        series=os.path.abspath(source), field=field, component=part.upper() if part else "Magnitude" if vector else "",
        fields=sorted(snap.fields), label=colours.label_of(snap, name), unit="" if unit == "1" else unit,
        low=float(low), high=float(high), preset=preset,
        radius=float(SPREAD * metres * np.median(particle_size(si))), flat=flat, page=list(PAGE),
        mirrors=[("XYZ"[axis], metres * place) for axis, place in mirrors_of(si)], towards=towards,
        middle=[metres * place for place in middle], half_height=metres * half_height,
        clock=clock * si.time / snap.time if snap.time else clock, second=second)


def pvpython() -> list[str]:
    """The Python of ParaView, on a virtual display if there is no other; empty if one of the two
    is missing.
    """
    program, screen = shutil.which("pvpython"), shutil.which("xvfb-run")
    if program is None or os.environ.get("DISPLAY"):
        return [program] if program else []
    # a virtual display that restarts after its last window has closed refuses the next window for
    # a moment
    return [screen, "-a", "-s", "-noreset -screen 0 1600x1000x24", program] if screen else []


def write_state(script: str) -> str:
    """Write the state file of a script; the result is its name, or the reason why there is
    none."""
    words, state = pvpython(), script.removesuffix(".py") + ".pvsm"
    if not words:
        return ""
    if os.path.exists(state):
        os.remove(state)
    try:
        answer = subprocess.run([*words, script, state], capture_output=True, text=True, errors="replace",
                                check=False, timeout=LONGEST)
        said = (answer.stderr or answer.stdout).strip().splitlines()
    except subprocess.TimeoutExpired:
        said = [f"it took longer than {LONGEST:g} s"]
    return state if os.path.exists(state) else f"note: pvpython wrote no state file: {(said or ['no reason'])[-1]}"


def run(arguments: argparse.Namespace) -> int:
    """Read the last snapshot, write the script and the state file."""
    source = series_file(arguments.source)
    out = arguments.out or beside(source, "_view.py")
    if not out.endswith(".py"):
        raise ScreeError(f"--out {out}: write a .py", EXIT_USAGE)
    text = script_of(source, arguments.colour)
    compile(text, out, "exec")
    try:
        with open(out, "w", encoding="utf-8") as file:
            file.write(text)
    except OSError as error:
        raise ScreeError(f"cannot write {out}: {error.strerror}") from error
    print(f"wrote {out}: paraview --script={shlex.quote(out)}")
    state = write_state(out)
    if state:
        print(f"wrote {state}: paraview --state={shlex.quote(state)}" if state.endswith(".pvsm") else state)
    return 0
