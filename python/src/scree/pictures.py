# SPDX-License-Identifier: BSD-3-Clause
"""Pictures in a plane or in 3-D, and radiographs, as drawn by the command scree-post.

    scree.picture(run, "pressure", time=2e-6).savefig("pressure.png", dpi=200)
    frame = scree.radiograph(run)
    frame.areal_density.shape, frame.extent
    frame.figure().savefig("radiograph.png", dpi=150)
"""
from __future__ import annotations

import os
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, Union

from . import files
from .drawing import page
from .drawing.look import plain_texts
from .drawing.radiograph_page import Picture
from .errors import FileProblem
from .results import Run
from .snapshot import Snapshot

if TYPE_CHECKING:
    import numpy as np
    from matplotlib.figure import Figure
    from numpy.typing import NDArray

    from .drawing.areal_density import Frame

Source = Union[Run, Snapshot, str, "os.PathLike[str]"]


def file_of(source: Source, time: float | None) -> str:
    """File of the snapshot of a run, series or folder that is nearest to a time [s]; the last one without a time."""
    if isinstance(source, Snapshot):
        return source.file
    if isinstance(source, Run):
        if len(source.snapshots) == 0:
            raise FileProblem(f"{source.folder} holds no series of particles, or several: open one of them")
        return (source.snapshots[-1] if time is None else source.snapshots.near(time)).file
    return page.nearest(files.series(str(source)), time)


def picture(source: Source, colour: str | None = None, *, time: float | None = None,
            limits: tuple[float, float] | None = None, view: tuple[float, float, float, float] | None = None,
            camera: str | tuple[float, float] = "corner", up: str = "z", **options: Any) -> Figure:
    """Particles coloured by a field: in 3-D as shaded spheres, in two dimensions at their size in the plane.

    `source` is a run, a snapshot, or the path of a series; `time` [s] selects the nearest snapshot, by default the
    last. `colour` is a field, a component such as velocity.z, speed, x, y, z, body or fragment_size; by default the
    size of fragments if there are any, otherwise the speed. `limits` are the ends of the colour bar and `view` left,
    right, bottom and top of the window, in SI. `camera` is x, y, z, corner, or azimuth and elevation [deg] in three
    dimensions, `up` the axis that points up. Further options are those of scree-post picture: bodies, hide_failed,
    keep, map, no_mirror, no_walls, title, zoom and dpi (of the image of spheres).
    """
    import matplotlib
    words = camera if isinstance(camera, str) else f"{camera[0]},{camera[1]}"
    chosen = page.options(colour=colour, range=limits, view=view, camera=words, up=up, **options)
    with matplotlib.rc_context():                        # settings of the caller are not changed
        figure, _ = page.picture(file_of(source, time), chosen)
    return plain_texts(figure)


@dataclass(frozen=True)
class Radiograph:
    """The areal density of a snapshot along a line of sight."""

    time: float                                          # [s]
    areal_density: NDArray[np.float64]                   # (vertical, horizontal) [kg/m2]
    extent: tuple[float, float, float, float]            # left, right, bottom, top of the image: z, then r, x or y [m]
    pixel: float                                         # side of a pixel [m]
    mass: float                                          # of the particles and their mirror images [kg]
    front: float                                         # position of the leading edge along z [m]
    speed: float                                         # of the leading edge [m/s]
    _frame: Frame = field(repr=False)
    _title: str = field(default="", repr=False)

    def figure(self, *, absorption: float | None = None, unit: str = "kg/m2") -> Figure:
        """The page of scree-post radiograph: film, areal density and particles; absorption in m2/kg."""
        import matplotlib
        towards = -1.0 if self.speed < 0.0 else 1.0
        options = {"mu": absorption, "unit": unit, "towards": towards, "view": None}
        with matplotlib.rc_context():                    # settings of the caller are not changed
            return plain_texts(Picture([self._frame], self._title, options).draw())


def radiograph(source: Source, *, time: float | None = None, pixel: float | None = None, sight: str = "y",
               smear: str = "spacing") -> Radiograph:
    """Synthetic flash X-ray image of a snapshot: the mass along the line of sight over its area.

    `sight` is x or y (three dimensions), `pixel` the side of a pixel [m], by default a 700th of the longer side.
    With `smear` "spacing" separated particles are spread over the gaps between them, with "volume" their width follows
    from their volume. Both conserve the mass of the particles to round-off.
    """
    file = file_of(source, time)
    frame = page.radiograph(file, pixel, sight, None, smear)
    with files.open_snapshot(file) as handle:
        title = files.header(handle, file).title
    return Radiograph(frame.time, frame.sigma, frame.box, frame.pixel, frame.mass, frame.front, frame.speed, frame,
                      title)
