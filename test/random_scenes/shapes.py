# SPDX-License-Identifier: BSD-3-Clause
"""Random bodies of all shapes, with their regions written in cells about the origin of the body.

    shape = shapes.draw(chance, "plane_strain", half=(6.0, 1.0, 4.0), corner=True)
    shape.regions("a", place, dx)      # groups &region, the last one is the body
    shape.half                         # half the edges of its box [cells]
    shape.files                        # name: bytes of the files that regions read
"""

import dataclasses
import io

import h5py
import numpy as np

from chance import group

PLANE = {"box": 6, "sphere": 4, "cylinder": 1, "ellipsoid": 2, "cone": 1, "torus": 1, "prism": 3, "hollow": 2,
         "union": 1, "intersection": 1, "points": 1}
RINGS = {"box": 5, "sphere": 5, "cylinder": 3, "cone": 2, "ellipsoid": 2, "prism": 2, "hollow": 1, "union": 1,
         "intersection": 1}
SPACE = {"box": 4, "sphere": 4, "cylinder": 2, "ellipsoid": 2, "cone": 2, "torus": 1, "prism": 2, "hollow": 1,
         "union": 1, "intersection": 1, "stl": 2, "voxel": 2, "points": 1}
LINE = {"box": 8, "sphere": 1}
WORDS = {"1d": LINE, "plane_strain": PLANE, "axisymmetric": RINGS, "3d": SPACE}
FAR = 1.0e3     # cells, beyond any grid


@dataclasses.dataclass
class Shape:
    """A shape in cells; `parts` are groups of keys, the last of which is the body."""

    word: str
    half: tuple
    parts: list
    files: dict
    turn: float = 0.0          # about y [deg]
    packing: str = None

    def regions(self, name, place, dx):
        """Text of its regions with the origin at a place [cells]."""
        lines = []
        names = [f"{name}{index}" for index in range(len(self.parts) - 1)] + [name]
        for own, part in zip(names, self.parts):
            keys = {key: scaled(key, value, dx) for key, value in part.items()}
            if "of" in keys:
                keys["of"] = [names[index] for index in keys["of"]]
            else:
                if "file" in keys:
                    keys["file"] = f"{name}_{keys['file']}"
                if self.turn:
                    keys["rotate"] = [0.0, self.turn, 0.0]
                keys["translate"] = [coordinate * dx for coordinate in place]
            lines.append(group("region", name=own, **keys))
        return lines


def scaled(key, value, dx):
    """Lengths in cells converted to metres; other keys are unchanged."""
    if key in ("shape", "axis", "normal", "of", "file", "voxel_value"):
        return value
    if key == "point_volume":
        return value
    if key == "scale":
        return value * dx
    return [item * dx for item in value] if isinstance(value, (list, tuple)) else value * dx


def draw(chance, dimension, half, simple=False, turns=True):
    """A body with half edges of about `half` cells; only boxes and round bodies if `simple`."""
    words = WORDS[dimension]
    if simple:
        words = {word: words[word] for word in ("box", "sphere")}
    word = chance.choose(words)
    hx, hy, hz = half
    if dimension in ("plane_strain", "1d", "axisymmetric"):
        hy = FAR
    if dimension == "1d":
        hz = FAR
    if word in ("sphere", "torus", "hollow", "intersection", "union"):
        hx = hz = min(hx, hz) if dimension != "1d" else hx
        hy = hz if dimension == "3d" else hy
    files, packing = {}, None
    parts = MAKERS[word](chance, dimension, (hx, hy, hz), files)
    if word == "points":
        packing = "file"
    turn = 0.0
    if turns and dimension in ("plane_strain", "3d") and word not in ("points", "voxel") and chance.true(0.3):
        turn = float(chance.integer(-60, 60))
        hx = hz = (hx ** 2 + hz ** 2) ** 0.5
    if word == "union":
        hx, hz = 1.6 * hx, 1.6 * hz
        hy = 1.6 * hy if dimension == "3d" else hy
    return Shape(word, (hx, hy, hz), parts, files, turn, packing)


def box(_chance, _dimension, half, _files):
    """A box."""
    return [{"shape": "box", "lo": [-edge for edge in half], "hi": list(half)}]


def sphere(_chance, dimension, half, _files):
    """A ball, disc or segment."""
    return [{"shape": "sphere", "centre": [0, 0, 0], "radius": half[0] if dimension == "1d" else half[2]}]


def cylinder(_chance, dimension, half, _files):
    """A disc in the plane, a rod along the axis elsewhere."""
    if dimension == "plane_strain":
        return [{"shape": "cylinder", "axis": [0, 1, 0], "centre": [0, 0, 0], "radius": min(half[0], half[2]),
                 "height": 2 * FAR}]
    return [{"shape": "cylinder", "axis": [0, 0, 1], "centre": [0, 0, 0], "radius": half[0], "height": 2 * half[2]}]


def cone(chance, _dimension, half, _files):
    """A cone or its trunk along z, up or down."""
    upward = 1 if chance.true(0.5) else -1
    return [{"shape": "cone", "axis": [0, 0, upward], "centre": [0, 0, 0], "radius": half[0],
             "radius2": half[0] * chance.uniform(0.2, 0.8), "height": 2 * half[2]}]


def ellipsoid(_chance, dimension, half, _files):
    """An ellipsoid."""
    across = half[1] if dimension == "3d" else half[0]
    return [{"shape": "ellipsoid", "centre": [0, 0, 0], "semi_axes": [half[0], across, half[2]]}]


def torus(chance, dimension, half, _files):
    """A ring: in the plane an annulus, in space a torus."""
    section = half[2] * chance.uniform(0.3, 0.4)
    return [{"shape": "torus", "axis": [0, 1, 0] if dimension == "plane_strain" else [0, 0, 1], "centre": [0, 0, 0],
             "radius": half[2] - section, "radius2": section}]


def prism(chance, dimension, half, _files):
    """A polygon: a triangle, a wedge, or a staircase that is not convex."""
    hx, hy, hz = half
    low = 0.0 if dimension == "axisymmetric" else -hx
    corners = chance.choose([
        [low, -hz, hx, -hz, low, hz],
        [low, -hz, hx, -hz, 0.3 * hx, hz, low, hz],
        [low, -hz, hx, -hz, hx, 0.0, 0.4 * hx, 0.0, 0.4 * hx, hz, low, hz]])
    keys = {"shape": "prism", "polygon": corners}
    if dimension == "3d":
        keys.update(axis=[0, 1, 0], span=[-hy, hy])
    return [keys]


def hollow(chance, dimension, half, files):
    """A ball with a cavity."""
    outer = sphere(chance, dimension, half, files)[0]
    inner = {**outer, "radius": half[2] * chance.uniform(0.3, 0.6)}
    return [outer, inner, {"shape": "difference", "of": [0, 1]}]


def union(chance, dimension, half, files):
    """A ball and a box joined."""
    return [sphere(chance, dimension, half, files)[0], box(chance, dimension, [0.7 * half[0], 0.7 * half[1],
                                                                             1.6 * half[2]], files)[0],
            {"shape": "union", "of": [0, 1]}]


def intersection(chance, dimension, half, files):
    """A half of a ball."""
    normal = [0, 0, 1 if chance.true(0.5) else -1]
    return [sphere(chance, dimension, half, files)[0],
            {"shape": "halfspace", "centre": [0, 0, 0], "normal": normal}, {"shape": "intersection", "of": [0, 1]}]


def stl(_chance, _dimension, half, files):
    """A solid of facets: an octahedron with the bounding box of the body."""
    tips = [[0.0, 0.0, 0.0] for _ in range(6)]
    for axis in range(3):
        tips[2 * axis][axis], tips[2 * axis + 1][axis] = half[axis], -half[axis]
    lines = ["solid body"]
    for a, b, c in ((0, 2, 4), (2, 1, 4), (1, 3, 4), (3, 0, 4), (2, 0, 5), (1, 2, 5), (3, 1, 5), (0, 3, 5)):
        lines += ["facet normal 0 0 0", "outer loop"]
        lines += [f"vertex {tips[tip][0]:.6g} {tips[tip][1]:.6g} {tips[tip][2]:.6g}" for tip in (a, b, c)]
        lines += ["endloop", "endfacet"]
    files["body.stl"] = ("\n".join([*lines, "endsolid body"]) + "\n").encode()
    return [{"shape": "stl", "file": "body.stl", "scale": 1.0}]


def voxel(chance, _dimension, half, files):
    """Voxels of half a cell, with random holes."""
    number = [max(2, int(4 * edge)) for edge in half]
    values = np.array([chance.true(0.95) for _ in range(number[0] * number[1] * number[2])], dtype="u1")
    content = io.BytesIO()
    with h5py.File(content, "w") as file:
        voxels = file.create_dataset("voxels", data=values.reshape(number[::-1]))
        voxels.attrs["spacing"] = 0.5
        voxels.attrs["origin"] = [-0.25 * edge for edge in number]
    files["body.h5"] = content.getvalue()
    return [{"shape": "voxel", "file": "body.h5", "scale": 1.0}]


def points(chance, dimension, half, files):
    """A list of points, one in each half cell, with random displacements."""
    flat = dimension == "plane_strain"
    number = [1 if flat and axis == 1 else max(2, int(4 * half[axis])) for axis in range(3)]
    lines = ["x,y,z"]
    for k in range(number[2]):
        for j in range(number[1]):
            for i in range(number[0]):
                place = [0.5 * (index + 0.5 + chance.uniform(-0.2, 0.2) - 0.5 * most)
                         for index, most in zip((i, j, k), number)]
                lines.append(",".join(f"{value:.6g}" for value in place))
    files["body.csv"] = ("\n".join(lines) + "\n").encode()
    return [{"shape": "points", "file": "body.csv", "scale": 1.0, "point_volume": 0.25 if flat else 0.125}]


MAKERS = {"box": box, "sphere": sphere, "cylinder": cylinder, "cone": cone, "ellipsoid": ellipsoid, "torus": torus,
          "prism": prism, "hollow": hollow, "union": union, "intersection": intersection, "stl": stl, "voxel": voxel,
          "points": points}
