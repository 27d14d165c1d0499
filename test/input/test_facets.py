# SPDX-License-Identifier: BSD-3-Clause
"""Regions from STL files: the particles in them, the warnings about leaks, and broken files.

Would catch a point that is taken for outside because its ray meets an edge or a corner, wrong volumes, a text and a
binary file that give different results, facets of a text that are counted wrongly, or too little memory for facets
after tabs, transformations in another order, and a broken file that is accepted.
"""

import struct

import numpy as np

import case

DECK = """&run dimension = '3d' /
&units system = '{system}' /
&grid lo = 0 0 0  hi = {size} {size} {size}  dx = {dx} /
&time t_end = 1  max_steps = 0 /
&material name = 'metal'  density = 1  bulk = 1  shear = 1 /
&region name = 'solid'  {shape} /
&body name = 'one'  region = 'solid'  material = 'metal' /
"""
CUBE = [(0, 2, 1), (1, 2, 3), (4, 5, 6), (5, 7, 6), (0, 1, 4), (1, 5, 4), (2, 6, 3), (3, 6, 7), (0, 4, 2),
        (2, 4, 6), (1, 3, 5), (3, 7, 5)]


def box(lower, upper):
    """Twelve facets of a box, counterclockwise as seen from outside."""
    corners = np.array([[(lower, upper)[k >> d & 1][d] for d in range(3)] for k in range(8)], dtype=float)
    return corners[np.array(CUBE)]


def ball(n, centre=(0.5, 0.5, 0.5), radius=0.3):
    """Facets of a sphere: n rows of 2 n quadrangles, each split into two triangles."""
    polar, around = np.linspace(0, np.pi, n + 1), np.linspace(0, 2 * np.pi, 2 * n + 1)[:-1]
    points = np.array([[(np.sin(a) * np.cos(b), np.sin(a) * np.sin(b), np.cos(a)) for b in around] for a in polar])
    points[0], points[-1] = (0, 0, 1), (0, 0, -1)
    points = np.asarray(centre) + radius * points
    facets = []
    for i in range(n):
        for j in range(2 * n):
            a, b = points[i][j], points[i][(j + 1) % (2 * n)]
            c, d = points[i + 1][j], points[i + 1][(j + 1) % (2 * n)]
            facets += [(a, c, d)] * (i < n - 1) + [(a, d, b)] * (i > 0)
            if i == n - 1:
                facets[-1:] = [(a, c, b)]
            if i == 0:
                facets[-1:] = [(a, c, d)]
    return np.array(facets)


def volume(facets):
    """Volume that the facets enclose."""
    return np.einsum("ij,ij->", facets[:, 0], np.cross(facets[:, 1], facets[:, 2])) / 6


def binary(facets):
    """A binary file."""
    body = b"".join(struct.pack("<12fH", 0, 0, 0, *facet.astype("f4").ravel(), 0) for facet in facets)
    return b"solid, but not a text".ljust(80) + struct.pack("<I", len(facets)) + body


def text(facets):
    """A text file, with the line ends of another system."""
    lines = ["solid thing"]
    for facet in facets:
        lines += ["  facet normal 0 0 0", "    outer loop"]
        lines += [f"\tvertex {x!r} {y!r} {z!r}" for x, y, z in facet.astype("f4").astype(float).tolist()]
        lines += ["    endloop", "  endfacet"]
    return "\r\n".join([*lines, "endsolid thing", ""]).encode()


class TestFacets:
    """Particles of the first state."""

    def run_of(self, options, name, content, more="", ranks=1, system="si", size=1, dx=0.0625, flags=("--quiet",),
               expect=0):
        """A run of zero steps."""
        shape = f"shape = 'stl'  file = '{name}.stl'  {more}"
        run = case.Case(options, name, DECK.format(system=system, size=size, dx=dx, shape=shape), ranks)
        (run.folder / f"{name}.stl").write_bytes(content)
        return run.run(*flags, expect=expect)

    def points(self, run):
        """Positions, sorted."""
        points = run.snapshots()[-1][1].points
        return points[np.lexsort(points.T)]

    def test_box_on_the_lattice(self, options, sheet):
        """A box has the particles of a box, although rays meet its edges, corners and diagonals."""
        for lower, upper in [((0.25, 0.25, 0.25), (0.75, 0.5, 0.625)),      # faces between particles
                             ((0.265625, 0.265625, 0.265625), (0.765625, 0.515625, 0.640625))]:  # faces on particles
            found = self.points(self.run_of(options, "box", binary(box(lower, upper))))
            shape = "shape = 'box'  lo = {} {} {}  hi = {} {} {}".format(*lower, *upper)
            plain = DECK.format(system="si", size=1, dx=0.0625, shape=shape)
            wanted = self.points(case.Case(options, "plain", plain).run("--quiet"))
            with sheet.part(lower):
                assert len(wanted) > 500
                assert np.array_equal(found, wanted), (len(found), len(wanted))

    def test_ball(self, options):
        """The particles of a sphere of facets have the volume of its facets; text, binary and ranks agree."""
        facets = ball(24)
        assert abs(volume(facets) / (4 / 3 * np.pi * 0.3**3) - 1.0) <= 0.5e-1
        one = self.run_of(options, "ball", binary(facets), dx=0.03125)
        found = self.points(one)
        assert abs(len(found) * 0.015625**3 / volume(facets) - 1.0) < 0.002
        off = np.linalg.norm(found - 0.5, axis=1)
        assert off.max() < 0.3
        assert np.array_equal(found, self.points(self.run_of(options, "text", text(facets), dx=0.03125)))
        tabs = text(facets).replace(b"facet normal", b"facet\tnormal")
        assert np.array_equal(found, self.points(self.run_of(options, "tabs", tabs, dx=0.03125)))
        for ranks in (2, 3):
            other = self.run_of(options, "ball_ranks", binary(facets), ranks=ranks, dx=0.03125)
            assert other.summary["digest"] == one.summary["digest"]

    def test_transformations(self, options):
        """The order is scale, rotate, translate; lengths of the file are in the unit of the deck."""
        wanted = self.points(self.run_of(options, "there", binary(box((0.25, 0.375, 0.25), (0.5, 0.75, 0.625)))))
        turned = binary(box((-3, 2, 2), (0, 4, 5)))          # turned by -90 degrees about z it is y, -x, z
        found = self.points(self.run_of(options, "moved", turned,
                                        "scale = 0.125  rotate = 0 0 -90  translate = 0 0.375 0"))
        assert np.array_equal(found, wanted), (found.min(axis=0), found.max(axis=0), len(wanted))
        cgs = self.run_of(options, "cgs", binary(100 * box((0.25, 0.375, 0.25), (0.5, 0.75, 0.625))), system="cgs",
                          size=100,
                          dx=6.25)
        assert np.allclose(self.points(cgs), wanted)

    def test_check_tells_of_the_surface(self, options, sheet):
        """Leaks, facets that are inverted, duplicate or flat, and the two volumes."""
        facets = ball(12)
        turned = facets.copy()
        turned[40] = turned[40][::-1]
        flat = facets[5].copy()
        flat[1] = flat[0]
        for name, content, message in [
                ("whole", facets, "particles  "),
                ("leak", np.delete(facets, 40, axis=0), "the surface has 3 open edges"),
                ("turned", turned, "3 edges have facets with opposite orientations"),
                ("twice", np.append(facets, facets[40:41], axis=0), "3 edges have more than two facets"),
                ("inwards", facets[:, ::-1], "all facets face inwards"),
                ("flat", np.append(facets, [flat], axis=0), "1 facets have no area")]:
            with sheet.part(name):
                said = self.run_of(options, name, binary(content), flags=("--check", "--no-estimate")).output
                assert message in said
                if name == "whole":
                    assert "&region" not in said

    def test_many_facets(self, options):
        """A hundred thousand facets: would catch a search through all of them for each point."""
        facets = ball(225)
        assert len(facets) > 1e5
        run = self.run_of(options, "many", binary(facets), dx=0.03125)
        plain = DECK.format(system="si", size=1, dx=0.03125,
                            shape="shape = 'sphere'  centre = 0.5 0.5 0.5  radius = 0.3")
        smooth = case.Case(options, "smooth", plain).run("--quiet").summary["particles"]
        assert abs(len(self.points(run)) / smooth - 1.0) < 0.002

    def test_broken_files(self, options, sheet):
        """Each is refused with the error and its position; nothing crashes."""
        good, plain = binary(ball(4)), text(ball(4))
        lines = plain.decode().split("\r\n")
        nan = bytearray(good)
        nan[84 + 50 * 2 + 12:84 + 50 * 2 + 16] = struct.pack("<f", float("nan"))
        more = bytearray(good)
        more[80:84] = struct.pack("<I", 2**32 - 1)
        for name, content, message in [
                ("short", good[:-1], "its header gives 48 facets, but it has 47"),
                ("count", bytes(more), "its header gives 4294967295 facets, but it has 48"),
                ("empty", b"", "it is too short for an STL file"),
                ("none", binary(np.zeros((0, 3, 3))), "it has no facets"),
                ("nan", bytes(nan), "facet 3 has a corner that is not finite"),
                ("noise", bytes(range(256)), "it is truncated, or not an STL file"),
                ("cut", "\r\n".join(lines[:20]).encode(), "it ends within a solid, in line 20; it is truncated"),
                ("word", plain.replace(b"outer loop", b"outer lop", 1).replace(b"\tvertex", b"\tvertices", 1),
                 "line 4: expected a facet with three vertices of three numbers, not 'vertices"),
                ("numbers", "\r\n".join(lines[:3] + ["vertex 1 2 x"] + lines[4:]).encode(), "line 4: expected"),
                ("stroke", "\r\n".join(lines[:3] + ["vertex 1 2 /"] + lines[4:]).encode(), "line 4: expected"),
                ("two", "\r\n".join(lines[:4] + ["vertex 1 nan 3"] + lines[5:]).encode(), "line 5: expected")]:
            with sheet.part(name):
                run = self.run_of(options, name, content, flags=("--check",), expect=2)
                assert "cannot read the facets of '" in run.output
                assert message in run.output
        run = case.Case(options, "missing", DECK.format(
            system="si", size=1, dx=0.0625, shape="shape = 'stl'  file = 'nowhere.stl'")).run("--check", expect=2)
        assert "nowhere.stl': No such file" in run.output


class TestPackings:
    """Conversion of lattice sites to particles."""

    def test_jitter(self, options):
        """Each particle is within the middle half of its site, none in the centre, the same for any ranks."""
        deck = DECK.format(system="si", size=1, dx=0.0625, shape="shape = 'box'  "
                           "lo = 0.25 0.25 0.25  hi = 0.75 0.75 0.75")
        deck = deck.replace("material = 'metal' /", "material = 'metal'  packing = 'jitter' /")
        one = case.Case(options, "jitter", deck).run("--quiet")
        off = (one.snapshots()[-1][1].points / 0.03125) % 1.0 - 0.5
        assert off.shape == (4096, 3)
        assert np.abs(off).max() < 0.25
        assert np.abs(off.mean(axis=0)).max() < 0.01
        assert np.allclose(off.std(axis=0), 0.25 / np.sqrt(3), rtol=0.05)
        assert np.abs(np.corrcoef(off.T) - np.eye(3)).max() < 0.05
        for ranks in (2, 3):
            other = case.Case(options, "jitter_ranks", deck, ranks).run("--quiet")
            assert other.summary["digest"] == one.summary["digest"]


def inside(name, x, y, z):
    """The formulas of the solids below, about their centres."""
    if name == "ellipsoid":
        return (x / 0.4)**2 + (y / 0.2)**2 + (z / 0.3)**2 < 1
    if name == "cone":
        along = (y + z) / np.sqrt(2)
        return (abs(along) < 0.3) & (np.sqrt(x**2 + (y - z)**2 / 2) < 0.35 * (0.5 - along / 0.6))
    if name == "trunk":
        return (abs(z) < 0.25) & (np.hypot(x, y) < 0.2 + 0.4 * z)
    if name == "torus":
        return (np.sqrt((x - y)**2 / 2 + z**2) - 0.3)**2 + (x + y)**2 / 2 < 0.01
    return x + 2 * y + 3 * z < 1e-9


class TestSolids:
    """Shapes with formulas: their particles against points of the formula, rotated ones against the volume."""

    def test_volumes(self, options, sheet):
        tilt = "  rotate = 20 0 30"
        for name, shape, wanted in [
                ("ellipsoid", "shape = 'ellipsoid'  centre = 0.5 0.5 0.5  semi_axes = 0.4 0.2 0.3",
                 4 / 3 * np.pi * 0.4 * 0.2 * 0.3),
                ("cone", "shape = 'cone'  centre = 0.5 0.5 0.5  radius = 0.35  radius2 = 0  height = 0.6  axis = 0 1 1",
                 np.pi / 3 * 0.35**2 * 0.6),
                ("trunk", "shape = 'cone'  centre = 0.5 0.5 0.5  radius = 0.1  radius2 = 0.3  height = 0.5",
                 np.pi / 3 * 0.5 * (0.01 + 0.03 + 0.09)),
                ("torus", "shape = 'torus'  centre = 0.5 0.5 0.5  radius = 0.3  radius2 = 0.1  axis = 1 1 0",
                 2 * np.pi**2 * 0.3 * 0.01),
                ("halfspace", "shape = 'halfspace'  centre = 0.5 0.5 0.5  normal = 1 2 3", 0.5)]:
            for turned in ("", "  translate = -0.5 -0.5 -0.5" + tilt) if name != "halfspace" else ("",):
                about = shape.replace("centre = 0.5 0.5 0.5", "centre = 0 0 0") if turned else shape
                more = tilt + "  translate = 0.5 0.5 0.5" if turned else ""
                deck = DECK.format(system="si", size=1, dx=0.03125, shape=about + more)
                run = case.Case(options, name, deck).run("--quiet")
                line = (np.arange(64) + 0.5) / 64 - 0.5
                known = inside(name, *np.meshgrid(line, line, line)).sum()
                with sheet.part(name, turned=bool(turned)):
                    assert run.summary["particles"] > 5000
                    if turned:
                        assert abs(run.summary["particles"] * 0.015625**3 / wanted - 1.0) < 0.01
                    else:      # except for points on the surface
                        assert abs(run.summary["particles"] / known - 1.0) < 0.004
