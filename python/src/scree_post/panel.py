# SPDX-License-Identifier: BSD-3-Clause
"""Particles of a run in two dimensions in axes of a figure: the panels of the scenes and of the gallery.

    shown = panel.particles(axes, snap, 1e-6 * snap.fields["pressure"], low=0.0, high=400.0)
    figure.colorbar(shown, ax=axes, label="pressure [MPa]")
    panel.window(axes, (0, 165, 0, 165), "x [mm]", "z [mm]", title="60 µs")
"""
from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from scree.drawing import look
from scree.drawing.shape import particle_size, plane_edges

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.collections import PolyCollection
    from matplotlib.patches import Patch

    from scree.arrays import Array
    from scree.files import Snapshot

BELOW = 1.3              # width of the layer below over that of a particle
SEAM = 0.25              # line around each particle, which closes seams and shows the smallest ones [points]


def particles(axes: Axes, snap: Snapshot, values: Any, *, low: float | None = None, high: float | None = None,
              colours: str = look.SEQUENTIAL, rows: Array | None = None, sides: Sequence[float] = (1.0,),
              factor: float = 1.0e3, along: float = 0.0, log: bool = False) -> PolyCollection:
    """Draw particles as large as their volume; returns the drawn collection, for a colour bar.

    values  numbers (n) for the colour map, colours (n, 3) or (n, 4), or one colour for all
    rows    the particles that are drawn (all)
    sides   1 for the model, -1 for its mirror image at x = 0
    factor  from metres to the unit of the axes (mm)
    log     logarithmic colours; smaller numbers are drawn as `low`
    along   shift of the axis of the mirror image in the unit of the axes
    """
    from matplotlib.collections import PolyCollection
    rows = np.arange(len(snap.points)) if rows is None else np.flatnonzero(rows) if rows.dtype == bool else rows
    if "volume" not in snap.fields:
        mass, density = snap.need("mass", "density")
        snap.fields["volume"] = mass / density
    size = particle_size(snap)
    middle, edges = snap.points[rows][:, [0, 2]], 0.5 * plane_edges(snap, size)[rows]
    if not isinstance(values, str):
        values = np.concatenate([np.asarray(values)[rows] for _ in sides])
    for layer, spread in ((0.95, BELOW), (1.0, 1.0)):    # the layer below fills gaps between neighbours
        corners = np.stack([middle + spread * (a * edges[:, 0] + b * edges[:, 1])
                            for a, b in ((-1, -1), (1, -1), (1, 1), (-1, 1))], axis=1)
        corners = np.concatenate([factor * corners * (side, 1.0) + (along, 0.0) for side in sides])
        shown = PolyCollection(list(corners), linewidths=SEAM, antialiaseds=False, rasterized=True, zorder=layer)
        dress(shown, values, low, high, colours, log)
        axes.add_collection(shown)
    return shown


def dress(shown: PolyCollection, values: Any, low: float | None, high: float | None, colours: str, log: bool) -> None:
    """Colours of a layer: of a map, of each particle, or one for all."""
    from matplotlib.colors import LogNorm, Normalize
    if isinstance(values, str):
        shown.set(facecolor=values, edgecolor=values)
    elif values.ndim == 2:
        shown.set(facecolors=values, edgecolors=values)
    else:
        norm = LogNorm(low, high) if log else Normalize(low, high)
        shown.set(array=np.maximum(values, low or 0.0) if log else values, cmap=colours, norm=norm, edgecolor="face")


def window(axes: Axes, limits: Sequence[float], across: str = "", up: str = "", title: str = "") -> None:
    """Equal axes with these ends (left, right, bottom, top), labels and title."""
    axes.set(xlim=limits[:2], ylim=limits[2:], aspect="equal", xlabel=across, ylabel=up, title=title)


def patches(names: Mapping[str, str]) -> list[Patch]:
    """Coloured patches for a legend: names with their colours."""
    from matplotlib.patches import Patch
    return [Patch(color=tint, label=name) for name, tint in names.items()]
