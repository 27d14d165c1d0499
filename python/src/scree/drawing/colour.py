# SPDX-License-Identifier: BSD-3-Clause
"""Colouring of particles: by a field, a component of one, or the body; ranges and colour maps.

All maps can be read with any colour vision: viridis for magnitudes, coolwarm for numbers of both signs, and the colours
of Okabe and Ito for bodies and other integers. The heaviest fragments have these colours, small fragments have pale
tints that repeat, and particles of no fragment are grey.
"""
from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from ..errors import EXIT_USAGE, ScreeError, unknown
from ..snapshot import COMPONENTS
from . import look
from .shape import particle_size

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from ..arrays import Array
    from ..files import Snapshot

WHOLE = ("body", "material", "failed", "fragment")
FAILED = ("intact", "failed")
NO_FRAGMENT = "#c8c8c8"                                  # small fragments and particles that are not counted
NAMED = 6                                                # fragments with a separate colour
FEW = 2                                                  # number of fragments that are distinguished by default
PALE = 0.55                                              # fraction of white in the tints of the other fragments
MAPS = ("viridis", "cividis", "inferno", "magma", "plasma", "coolwarm", "PuOr", "gray")


Tint = Any                # a colour that matplotlib accepts


@dataclass
class Colour:
    """The colouring of one film: `factor` and `unit` are those of the label."""

    name: str                                            # as on the command line
    label: str
    unit: str = ""
    factor: float = 1.0
    low: float = 0.0                                     # in the unit of the label
    high: float = 1.0
    map: str = "viridis"
    names: tuple[str, ...] = ()                                    # of integers, such as bodies
    tints: tuple[Tint, ...] = ()                                    # of fragments, see fragment_tints
    # whether there are numbers below and above the range
    beyond: tuple[bool, bool] = (False, False)
    log: bool = False                                    # logarithmic scale


def field_of(name: str) -> tuple[str, str]:
    """Field and component of a name such as stress.xx."""
    field, _, part = name.partition(".")
    return field, part


def present(snap: Snapshot, name: str) -> str:
    """The name as it is in the file: speed is the magnitude of the velocity, unless it is a field of the file."""
    return "velocity" if name == "speed" and "speed" not in snap.fields else name


def choices(snap: Snapshot) -> list[str]:
    """All names by which particles of a snapshot can be coloured."""
    found = []
    for name, values in sorted(snap.fields.items()):
        found.append(name)
        if values.ndim == 2:
            found += [f"{name}.{part}" for part in COMPONENTS.get(values.shape[1], ())]
    found += ["speed"] * ("velocity" in snap.fields and "speed" not in snap.fields)
    return found + ["x", "y", "z"] + ["fragment_size"] * ("fragment" in snap.fields)


def values_of(snap: Snapshot, name: str) -> Array:
    """One number a particle [SI]: a field, a component, the length of a vector, a position."""
    if name in ("x", "y", "z"):
        return np.asarray(snap.points[:, "xyz".index(name)])
    if name == "fragment_size":
        return fragment_size(snap)
    field, part = field_of(present(snap, name))
    if field not in snap.fields:
        raise unknown("field", name, choices(snap), snap.file)
    values = snap.fields[field]
    if field == "body":
        return snap.body_rows()
    if field == "material" and snap.materials:           # indices in the file start from 1
        return values.astype(int) - 1
    if values.ndim == 1:
        if part:
            raise ScreeError(f"{field} has no components; write {field}", EXIT_USAGE)
        return values.astype("f8")
    parts = COMPONENTS.get(values.shape[1], ())
    if part:
        if part not in parts:
            raise unknown("component", part, parts, field)
        return values[:, parts.index(part)].astype("f8")
    if values.shape[1] != 3:
        raise ScreeError(f"{field} has components: write one of "
                        + ", ".join(f"{field}.{part}" for part in parts), EXIT_USAGE)
    return np.asarray(np.linalg.norm(values.astype("f8"), axis=1))


def fragment_size(snap: Snapshot) -> Array:
    """Diameter [m] of the sphere with the volume of the fragment of each particle, in a plane of the circle with its
    area; NaN for particles of no fragment."""
    number, _ = snap.need("fragment", "volume")
    number = number.astype(int)
    size = particle_size(snap)
    if snap.dimension == "3d":
        width = np.cbrt(np.bincount(number, size ** 3) * 6.0 / np.pi)
    else:
        width = np.sqrt(np.bincount(number, size ** 2) * 4.0 / np.pi)
    return np.where(number > 0, width[number], np.nan)


def default_name(snap: Snapshot) -> str:
    """Default for the colouring of particles: the size of fragments if there are any, otherwise the speed."""
    number = snap.fields.get("fragment")
    several = number is not None and len(np.unique(number[number > 0])) >= FEW
    return "fragment_size" if several else "velocity"


def label_of(snap: Snapshot, name: str) -> str:
    """Words for a name, such as 'speed' or 'stress xx'."""
    field, part = field_of(name)
    if field == "velocity" and not part:
        return "speed"
    return f"{look.words(field)} {part}".strip()


def colour_for(name: str, snaps: Sequence[Snapshot], wanted: Sequence[float] | None = None,
               chosen_map: str | None = None) -> Colour:
    """The colouring of a film: ranges over the given snapshots, or the requested ranges [SI]."""
    snap = next((one for one in snaps if len(one.points)), snaps[0])
    field, _ = field_of(present(snap, name))
    if field in WHOLE:
        values_of(snap, name)                            # raises an error if there is none
        count = max((int(values_of(one, name).max()) for one in snaps if len(one.points)),
                    default=0) + 1
        if field == "fragment":
            numbers = np.unique(np.concatenate([values_of(one, name) for one in snaps]))
            return Colour(name, label_of(snap, name), names=fragment_names(numbers), tints=fragment_tints())
        names = FAILED if field == "failed" else tuple(
            snap.body_name(row) if field == "body" else snap.materials[row]
            if field == "material" and row < len(snap.materials) else f"material {row}"
            for row in range(count))
        return Colour(name, label_of(snap, name), names=names)
    unit = "m" if name in ("x", "y", "z", "fragment_size") else snap.units.get(field, "1")
    found = np.concatenate([values_of(one, name) for one in snaps])
    found = found[np.isfinite(found)]
    log = name == "fragment_size" and not (wanted and wanted[0] <= 0.0)
    if wanted:
        low, high = wanted
    elif log:
        low, high = (float(found.min()), float(found.max())) if len(found) else (1.0, 10.0)
        high = max(high, 1.01 * low)
    else:
        low, high = sensible(found)
        if low < 0.0 < high and min(-low, high) > 0.1 * max(-low, high):
            high = max(-low, high)
            low = -high
    signed = low < 0.0 < high and abs(low + high) < 1.0e-9 * high
    factor, unit = look.readable_unit(max(abs(low), abs(high)), unit)
    slack = 1.0e-6 * (high - low)
    beyond = (bool((found < low - slack).any()), bool((found > high + slack).any()))
    return Colour(name, label_of(snap, name), unit, factor, factor * low, factor * high,
                  chosen_map or (look.SIGNED if signed else look.SEQUENTIAL), beyond=beyond, log=log)


def fragment_tints() -> tuple[Tint, ...]:
    """Colours of fragments: that of no fragment, those of the heaviest ones, and those that all others share in
    turn."""
    rgb = look.pyplot().matplotlib.colors.to_rgb
    full = [rgb(tint) for tint in look.COLOURS[:NAMED]]
    pale = [tuple(PALE + (1.0 - PALE) * part for part in tint) for tint in full]
    return (rgb(NO_FRAGMENT), *full, *pale)


def fragment_names(numbers: Array) -> tuple[str, ...]:
    """Lines of a legend for these numbers of fragments: the heaviest, one line for all others, and particles of no
    fragment."""
    most = int(max(numbers, default=0))
    names = [str(number) for number in range(1, min(most, NAMED) + 1)]
    if names:
        names[0] += ", the heaviest"
    return tuple(names) + ("others",) * (most > NAMED) + ("none",) * (0 in numbers)


def fragment_patches(colour: Colour) -> list[Any]:
    """A coloured patch for each line of the legend of fragments; several patches for the line of the others."""
    from matplotlib.patches import Patch
    patch = [Patch(color=tint) for tint in colour.tints]
    return [patch[0] if name == "none" else tuple(patch[NAMED + 1:NAMED + 5]) if name == "others"
            else patch[row + 1] for row, name in enumerate(colour.names)]


def sensible(values: Array) -> tuple[float, float]:
    """A range that is not widened by a few outliers."""
    if len(values) == 0:
        return 0.0, 1.0
    low, high = (float(np.quantile(values, share)) for share in (0.002, 0.998))
    least, most = float(values.min()), float(values.max())
    if most - least <= 1.5 * (high - low) or high <= low:
        low, high = least, most
    if low >= 0.0 and low < 0.3 * high:
        low = 0.0
    if high <= low:
        pad = 0.5 * abs(low) or 1.0
        low, high = (0.0, 2.0 * low) if low > 0.0 else (low - pad, low + pad)
    return low, high


def paint(colour: Colour, values: Array) -> Array:
    """Colours (n, 4) of numbers [SI]; NaN is grey."""
    plot = look.pyplot()
    if colour.tints:
        tints = np.array([plot.matplotlib.colors.to_rgba(tint) for tint in colour.tints])
        number = values.astype(int)
        return np.asarray(tints[np.where(number > NAMED, NAMED + 1 + (number - 1) % NAMED, number)])
    if colour.names:
        tints = np.array([plot.matplotlib.colors.to_rgba(tint) for tint in tints_of(colour)])
        return np.asarray(tints[np.clip(values.astype(int), 0, len(colour.names) - 1) % len(tints)])
    values, low, high = colour.factor * values, colour.low, colour.high
    if colour.log:
        with np.errstate(divide="ignore", invalid="ignore"):
            values, low, high = np.log(values), np.log(low), np.log(high)
    share = (values - low) / (high - low)
    rgba: Array = plot.get_cmap(colour.map)(np.clip(np.nan_to_num(share), 0.0, 1.0))
    rgba[~np.isfinite(values)] = (0.6, 0.6, 0.6, 1.0)
    return rgba


def tints_of(colour: Colour) -> tuple[str, ...]:
    """Colours of integers."""
    return ("#0072b2", "#e69f00") if colour.names == FAILED else look.COLOURS


def legend(figure: Figure, axes: Axes | None, colour: Colour, slot: Axes | None = None) -> None:
    """Colour bar (into the axes `slot`), or names with their colours, right of the axes."""
    plot = look.pyplot()
    if colour.names and axes is not None:
        from matplotlib.legend_handler import HandlerTuple
        from matplotlib.patches import Patch
        patches = fragment_patches(colour) if colour.tints else [
            Patch(color=tints_of(colour)[row % len(tints_of(colour))]) for row in range(len(colour.names))]
        axes.legend(patches, colour.names, loc="upper left", bbox_to_anchor=(1.01, 1.0),
                    borderaxespad=0.0, handlelength=1.0, handleheight=1.0,
                    title="fragment" if colour.tints else None, alignment="left",
                    handler_map={tuple: HandlerTuple(ndivide=None, pad=0.0)})
        return
    scale = plot.matplotlib.cm.ScalarMappable(
        (plot.matplotlib.colors.LogNorm if colour.log else plot.matplotlib.colors.Normalize)(
            colour.low, colour.high), colour.map)
    where = {"cax": slot} if slot is not None else {
        "ax": axes, "fraction": 0.05, "pad": 0.02, "aspect": 30}
    bar = figure.colorbar(scale, **where,
                          extend={(False, False): "neither", (True, False): "min",
                                  (False, True): "max", (True, True): "both"}[colour.beyond])
    bar.set_label(look.with_unit(colour.label, colour.unit))
