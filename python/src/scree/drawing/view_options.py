# SPDX-License-Identifier: BSD-3-Clause
"""Options that picture and movie share, and the pages for them."""
from __future__ import annotations

import argparse
import math
from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from ..errors import EXIT_USAGE, ScreeError, unknown
from ..files import snapshot
from . import colour as colours
from . import look
from .quantity import quantity
from .space import SpacePage
from .view import Options, PlanePage, bounds, check_view, fields_for, matter

if TYPE_CHECKING:
    from ..files import Moment, Snapshot

CAMERAS = {"x": (0.0, 0.0), "y": (-90.0, 0.0), "z": (-90.0, 90.0), "corner": (-60.0, 20.0)}
SAMPLE = 6               # number of snapshots of a film that define the range of colours and the window


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Options for the content and the style of a picture."""
    add = parser.add_argument
    add("--colour", "--color", metavar="FIELD",
        help="a field (velocity: its size), a component such as velocity.z or stress.xx, x, y, z, body, "
        "or fragment_size (fragment_size where there are fragments, else velocity)")
    add("--range", type=quantity, nargs=2, metavar=("LOW", "HIGH"),
        help="ends of the colour bar, in SI or with a unit: --range 0 6km/s")
    add("--map", choices=colours.MAPS, help="colour map; default viridis, coolwarm for both signs")
    add("--bodies", metavar="A,B", help="only these bodies")
    add("--hide-failed", action="store_true", help="leave out failed particles")
    add("--no-mirror", action="store_true", help="do not complete the model at mirror planes")
    add("--no-walls", action="store_true", help="leave out rigid regions and closed boundaries")
    add("--view", type=quantity, nargs=4, metavar=("LEFT", "RIGHT", "BOTTOM", "TOP"),
        help="part to show, in m or with a unit: --view -10mm 10mm 0 30mm")
    add("--keep", metavar="SIDE", help="3-D: only one side of a plane, such as 'y>0' or 'z<5mm'")
    add("--camera", metavar="FROM", default="corner",
        help="3-D: x, y, z, corner, or azimuth,elevation in degrees (corner: -60,20)")
    add("--up", choices=("x", "y", "z"), default="z", help="3-D: the axis that points up (z)")
    add("--zoom", type=float, default=1.0, help="3-D: enlarge the middle (1)")
    add("--surface", action="store_true",
        help="2-D, 3-D: surface of solids and heaps; only particles outside it are drawn one by one")
    add("--title", help="default: the title of the run; '' for none")
    add("--dpi", type=int, default=200, help="pixels per inch (200); a page is 9 inches wide")


def camera(text: str) -> tuple[float, float]:
    """Azimuth and elevation [deg]."""
    if text in CAMERAS:
        return CAMERAS[text]
    try:
        azimuth, elevation = (float(word) for word in text.split(","))
    except ValueError:
        raise unknown("camera", text, [*CAMERAS, "AZIMUTH,ELEVATION"]) from None
    if not (math.isfinite(azimuth) and -90.0 <= elevation <= 90.0):
        raise ScreeError("--camera needs an elevation from -90 to 90 degrees", EXIT_USAGE)
    return azimuth, elevation


def side(text: str) -> tuple[int, float, float]:
    """Axis, sign and position of a plane such as y>0."""
    axis, sign, place = text[:1], text[1:2], text[2:]
    try:
        if axis in ("x", "y", "z") and sign in ("<", ">"):
            return "xyz".index(axis), 1.0 if sign == ">" else -1.0, quantity(place)
    except Exception as error:
        raise ScreeError(f"--keep {text}: {error}", EXIT_USAGE) from error
    raise ScreeError(f"--keep {text}: write a side of a plane, such as 'y>0' or 'z<5mm'", EXIT_USAGE)


def options_of(arguments: argparse.Namespace, snaps: Sequence[Snapshot]) -> Options:
    """Options for a film with these sample snapshots."""
    for name in ("zoom", "dpi"):
        if not (math.isfinite(getattr(arguments, name)) and getattr(arguments, name) > 0):
            raise ScreeError(f"--{name} must be above 0", EXIT_USAGE)
    if arguments.range and not arguments.range[0] < arguments.range[1]:
        raise ScreeError("--range needs LOW < HIGH", EXIT_USAGE)
    check_view(arguments.view)
    title = arguments.title
    if title is None:
        title = snaps[-1].title
    latest = max(abs(snap.time) for snap in snaps)
    return Options(
        colour=colours.colour_for(arguments.colour, snaps, arguments.range, arguments.map),
        mirror=not arguments.no_mirror,
        bodies=tuple(arguments.bodies.split(",")) if arguments.bodies else (),
        hide_failed=arguments.hide_failed,
        view=tuple(arguments.view) if arguments.view else (),
        title=title, dpi=arguments.dpi, camera=camera(arguments.camera), zoom=arguments.zoom,
        up="xyz".index(arguments.up),
        turn=getattr(arguments, "turn", 0.0),
        clock=look.scaled(latest, "s") if latest > 0.0 else (1.0, "s"),
        walls=not arguments.no_walls, surface=arguments.surface,
        keep=side(arguments.keep) if arguments.keep else ())


def read(file: str, arguments: argparse.Namespace) -> Snapshot:
    """A snapshot with the fields that are drawn."""
    return snapshot(file, fields_for(arguments.colour, arguments.hide_failed) | {"velocity"})


def sample(frames: Sequence[Moment]) -> list[str]:
    """Some snapshots of a series, including the first and the last."""
    rows = np.unique(np.linspace(0, len(frames) - 1, SAMPLE).round().astype(int))
    return [frames[row][1] for row in rows]


def check_field(name: str, file: str) -> None:
    """Refuse a field that the series lacks, with a list of all its fields."""
    snap = snapshot(file)
    colours.values_of(snap, name)


def settle_colour(arguments: argparse.Namespace, file: str) -> None:
    """Choose the field for the colours where the user has not chosen one."""
    if arguments.colour is None:
        arguments.colour = colours.default_name(snapshot(file, ("fragment",)))


def pages(arguments: argparse.Namespace, files: Sequence[str]) -> PlanePage | SpacePage:
    """The object that draws pages of this run; `files` define ranges and window."""
    settle_colour(arguments, files[-1])
    check_field(arguments.colour, files[-1])
    snaps = [read(file, arguments) for file in files]
    options = options_of(arguments, snaps)
    if snaps[-1].dimension == "3d":
        return SpacePage(snaps, options)
    for name in ("keep", "turn"):
        if getattr(arguments, name, None):
            raise ScreeError(f"--{name} is for runs in three dimensions", EXIT_USAGE)
    return PlanePage(snaps[-1], options, bounds([matter(snap, options) for snap in snaps]))
