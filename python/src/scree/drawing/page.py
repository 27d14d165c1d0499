# SPDX-License-Identifier: BSD-3-Clause
"""Figures and numbers of one snapshot: common parts of the commands picture and radiograph and of the package scree.

    figure = drawing.picture("out/case/case_p_000012.hdf", drawing.options(colour="pressure", camera="x"))
    frame = drawing.radiograph("out/case/case_p_000012.hdf")
"""
from __future__ import annotations

import argparse
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from .. import files
from ..errors import EXIT_USAGE, ScreeError
from ..files import snapshot
from . import view_options
from .areal_density import checked
from .areal_density import radiograph as project

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from ..files import Moment, Snapshot
    from .areal_density import Frame

RADIOGRAPH_FIELDS = ("mass", "volume", "velocity", "body", "failed", "damage")


def options(**values: Any) -> argparse.Namespace:
    """The options of scree-post picture by name, with the defaults of the command for those that are not named."""
    parser = argparse.ArgumentParser()
    view_options.add_arguments(parser)
    found = parser.parse_args([])
    for name, value in values.items():
        if not hasattr(found, name):
            raise ScreeError(f"a picture has no option '{name}'", EXIT_USAGE)
        setattr(found, name, value)
    return found


def nearest(frames: Sequence[Moment], time: float | None) -> str:
    """File of the snapshot nearest to a time [s], of the last one if there is no time."""
    return (frames[-1] if time is None else files.nearest(frames, [time])[0])[1]


def picture(file: str, arguments: argparse.Namespace) -> tuple[Figure, Snapshot]:
    """The figure of a snapshot, and the snapshot."""
    page = view_options.pages(arguments, [file])
    snap = view_options.read(file, arguments)
    if len(snap.points) == 0:
        raise ScreeError(f"{file} holds no particles", EXIT_USAGE)
    return page.draw(snap), snap


def flight(snap: Snapshot) -> float:
    """+1 if the material flies towards larger z, -1 if its momentum has the opposite direction."""
    mass, velocity = checked(snap)
    momentum = mass * velocity[:, 2]
    return -1.0 if momentum.sum() < -0.01 * np.abs(momentum).sum() else 1.0


def default_pixel(snap: Snapshot) -> float:
    """A pixel [m] of which about 700 cover the longer side of the cloud, rounded to two digits."""
    if len(snap.points) == 0:
        return 1.0e-3
    extent = float(np.ptp(snap.points, axis=0).max()) or 1.0e-3
    return float(f"{extent / 700.0:.1e}")


def radiograph(file: str, pixel: float | None = None, sight: str = "y", towards: float | None = None,
               smear: str = "spacing") -> Frame:
    """The areal density of a snapshot, see areal_density.Frame."""
    snap = snapshot(file, RADIOGRAPH_FIELDS)
    return project(snap, pixel or default_pixel(snap), sight, flight(snap) if towards is None else towards, smear)
