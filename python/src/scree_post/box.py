# SPDX-License-Identifier: BSD-3-Clause
"""The box of a run: its corners, cells and faces, from the echo of the deck in a snapshot."""
import re
from dataclasses import dataclass, field

import numpy as np

NUMBER = r"[-+]?\d[\d.]*(?:[eE][-+]?\d+)?"


@dataclass
class Box:
    """Corners and faces; None where the file does not tell."""

    low: object = None                                   # lower corner (3) [m]
    high: object = None                                  # upper corner (3) [m]
    cell: float = None                                   # size of a cell [m]
    periodic: set = field(default_factory=set)           # axes, such as {0}


def group_text(echo, name):
    """The inner texts of all groups of a name, comments left out."""
    bare = re.sub(r"!.*", "", echo)
    return re.findall(rf"^\s*&{name}\b(.*?)^\s*/", bare, re.M | re.S | re.I)


def numbers(group, key):
    """The numbers of a key, or None."""
    found = re.search(rf"\b{key}\s*=\s*({NUMBER}(?:[\s,]+{NUMBER})*)", group)
    if not found:
        return None
    return np.array([float(word) for word in re.split(r"[\s,]+", found.group(1))])


def box_of(snap):
    """The box of a snapshot. Attributes grid_lo and grid_hi of /provenance win over the echo."""
    box = Box()
    for group in group_text(snap.echo, "grid"):
        box.low, box.high = numbers(group, "lo"), numbers(group, "hi")
        size, cells = numbers(group, "dx"), numbers(group, "cells")
        if size is not None:
            box.cell = float(size[0])
        elif cells is not None and box.high is not None:
            box.cell = float((box.high[0] - box.low[0]) / cells[0])
    for group in group_text(snap.echo, "boundary"):
        face = re.search(r"\bface\s*=\s*'([xyz])(?:lo|hi)'", group)
        every = re.search(r"\bface\s*=\s*'all'", group)
        if re.search(r"\btype\s*=\s*'periodic'", group):
            box.periodic |= {0, 1, 2} if every else {"xyz".index(face.group(1))} if face else set()
    for name, key in (("low", "grid_lo"), ("high", "grid_hi")):
        if key in snap.provenance:
            setattr(box, name, np.ravel(snap.provenance[key]).astype(float))
    return box


def thickness(snap, axis=1):
    """Thickness of a run along a direction that its scene lacks [m]."""
    if axis == 1 and "thickness" in snap.provenance:
        return float(snap.provenance["thickness"])
    box = box_of(snap)
    if box.low is None or box.high is None or not box.high[axis] > box.low[axis]:
        return 1.0
    return float(box.high[axis] - box.low[axis])
