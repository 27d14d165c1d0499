# SPDX-License-Identifier: BSD-3-Clause
"""What particles are coloured by: a field, a component of one, the body; ranges and colour maps.

All maps can be read with any colour vision: viridis for sizes, coolwarm for numbers of both signs,
and the colours of Okabe and Ito for bodies and other whole numbers.
"""
from dataclasses import dataclass

import numpy as np

from . import look
from .errors import EXIT_USAGE, PostError, unknown

COMPONENTS = {3: ("x", "y", "z"), 6: ("xx", "yy", "zz", "xy", "yz", "xz"),
              9: ("xx", "yx", "zx", "xy", "yy", "zy", "xz", "yz", "zz")}
WHOLE = ("body", "material", "failed")
FAILED = ("intact", "failed")
MAPS = ("viridis", "cividis", "inferno", "magma", "plasma", "coolwarm", "PuOr", "gray")


@dataclass
class Colour:
    """What one film is coloured by: `factor` and `unit` are those of the label."""

    name: str                                            # as on the command line
    label: str
    unit: str = ""
    factor: float = 1.0
    low: float = 0.0                                     # in the unit of the label
    high: float = 1.0
    map: str = "viridis"
    names: tuple = ()                                    # of whole numbers, such as bodies
    beyond: tuple = (False, False)                       # whether numbers lie below, above


def field_of(name):
    """Field and component of a name such as stress.xx."""
    field, _, part = name.partition(".")
    return field, part


def choices(snap):
    """All names that particles of a snapshot can be coloured by."""
    found = []
    for name, values in sorted(snap.fields.items()):
        found.append(name)
        if values.ndim == 2:
            found += [f"{name}.{part}" for part in COMPONENTS.get(values.shape[1], ())]
    return found + ["x", "y", "z"]


def values_of(snap, name):
    """One number a particle [SI]: a field, a component, the length of a vector, a position."""
    if name in ("x", "y", "z"):
        return snap.points[:, "xyz".index(name)]
    field, part = field_of(name)
    if field not in snap.fields:
        raise unknown("field", name, choices(snap), snap.file)
    values = snap.fields[field]
    if field == "body":
        return snap.body_rows()
    if values.ndim == 1:
        if part:
            raise PostError(f"{field} has no components; write {field}", EXIT_USAGE)
        return values.astype("f8")
    parts = COMPONENTS.get(values.shape[1], ())
    if part:
        if part not in parts:
            raise unknown("component", part, parts, field)
        return values[:, parts.index(part)].astype("f8")
    if values.shape[1] != 3:
        raise PostError(f"{field} has components: write one of "
                        + ", ".join(f"{field}.{part}" for part in parts), EXIT_USAGE)
    return np.sqrt((values.astype("f8") ** 2).sum(axis=1))


def label_of(snap, name):
    """Words for a name, such as 'speed' or 'stress xx'."""
    field, part = field_of(name)
    if field == "velocity" and not part:
        return "speed"
    return f"{look.words(field)} {part}".strip()


def colour_for(name, snaps, wanted=None, chosen_map=None):
    """The colour of a film: ranges over the given snapshots, or those asked for [SI]."""
    snap = next((one for one in snaps if len(one.points)), snaps[0])
    field, _ = field_of(name)
    if field in WHOLE:
        values_of(snap, name)                            # complains if there is none
        count = max((int(values_of(one, name).max()) for one in snaps if len(one.points)),
                    default=0) + 1
        names = FAILED if field == "failed" else tuple(
            snap.body_name(row) if field == "body" else f"material {row}" for row in range(count))
        return Colour(name, label_of(snap, name), names=names)
    unit = "m" if name in ("x", "y", "z") else snap.units.get(field, "1")
    found = np.concatenate([values_of(one, name) for one in snaps])
    found = found[np.isfinite(found)]
    if wanted:
        low, high = wanted
    else:
        low, high = sensible(found)
        if low < 0.0 < high and min(-low, high) > 0.1 * max(-low, high):
            high = max(-low, high)
            low = -high
    signed = low < 0.0 < high and abs(low + high) < 1.0e-9 * high
    factor, unit = look.label_unit(max(abs(low), abs(high)), unit)
    slack = 1.0e-6 * (high - low)
    beyond = (bool((found < low - slack).any()), bool((found > high + slack).any()))
    return Colour(name, label_of(snap, name), unit, factor, factor * low, factor * high,
                  chosen_map or ("coolwarm" if signed else "viridis"), beyond=beyond)


def sensible(values):
    """A range that a few stray particles do not stretch."""
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


def paint(colour, values):
    """Colours (n, 4) of numbers [SI]; not-a-number is grey."""
    plot = look.pyplot()
    if colour.names:
        tints = np.array([plot.matplotlib.colors.to_rgba(tint) for tint in tints_of(colour)])
        return tints[np.clip(values.astype(int), 0, len(colour.names) - 1) % len(tints)]
    span = colour.high - colour.low
    share = (colour.factor * values - colour.low) / span
    rgba = plot.get_cmap(colour.map)(np.clip(np.nan_to_num(share), 0.0, 1.0))
    rgba[~np.isfinite(values)] = (0.6, 0.6, 0.6, 1.0)
    return rgba


def tints_of(colour):
    """Colours of whole numbers."""
    return ("#0072b2", "#e69f00") if colour.names == FAILED else look.COLOURS


def legend(figure, axes, colour, slot=None):
    """Colour bar (into the axes `slot`), or names with their colours, right of the axes."""
    plot = look.pyplot()
    if colour.names:
        from matplotlib.patches import Patch
        patches = [Patch(color=tints_of(colour)[row % len(tints_of(colour))], label=name)
                   for row, name in enumerate(colour.names)]
        axes.legend(handles=patches, loc="upper left", bbox_to_anchor=(1.01, 1.0),
                    borderaxespad=0.0, handlelength=1.0, handleheight=1.0)
        return
    scale = plot.matplotlib.cm.ScalarMappable(
        plot.matplotlib.colors.Normalize(colour.low, colour.high), colour.map)
    where = {"cax": slot} if slot is not None else {
        "ax": axes, "fraction": 0.05, "pad": 0.02, "aspect": 30}
    bar = figure.colorbar(scale, **where,
                          extend={(False, False): "neither", (True, False): "min",
                                  (False, True): "max", (True, True): "both"}[colour.beyond])
    bar.set_label(look.with_unit(colour.label, colour.unit))
