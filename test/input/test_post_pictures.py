# SPDX-License-Identifier: BSD-3-Clause
# tiers: smoke, full
# timeout: 600
"""Tests of the pictures and numbers that scree-post makes from small runs: picture, movie, radiograph, fragments.

Pictures are checked by their numbers. The first line of each test states which bug it would catch.
"""

import math
import sys

import numpy as np
import pytest

import report
import scree_post
import tier
from post_command import call, run_cases, series
from sample_snapshots import matter, write
from scree.drawing import surface, view_options
from scree.drawing.colour import colour_for, paint, values_of
from scree.drawing.walls import Wall, add_paths
from scree_post import film, fragment_table, pieces
from scree_post.command import parser_of
from scree_post.commands import movie as movie_command


@pytest.fixture(scope="module")
def options(file_options):
    """Small runs in a folder that all tests use."""
    run_cases(file_options, *tier.choose(("two_discs", "debris_cloud", "debris_cloud_3d"), smoke=("two_discs",)))
    return file_options


def good(answer):
    """Output of a call that must succeed without a warning."""
    assert answer.returncode == 0 and not answer.stderr, f"{answer.returncode} {answer.stderr}"
    return answer.stdout


def pixels(path):
    """Colours of a picture (height, width, 3)."""
    from PIL import Image
    with Image.open(path) as image:
        return np.asarray(image.convert("RGB")).astype(int)


def share_of(image, colour):
    """Fraction of the pixels that have nearly this colour (0 to 255)."""
    return float((np.abs(image - np.array(colour)).max(axis=2) < 12).mean())


def body_page(options, name, *words):
    """A picture by body, and the colours of the first two bodies in it."""
    out = options.work / f"{name}_body.png"
    good(call("picture", options.work / "out" / name, "--colour", "body", "--out", out, *words))
    image = pixels(out)
    return image, share_of(image, (0, 114, 178)), share_of(image, (213, 94, 0))


def test_plane_picture(options):
    """Axes with different scales, a body not drawn, z upside down, another time, gaps in the material."""
    image, left, right = body_page(options, "two_discs", "--time", "0")
    assert left > 0.04 and abs(left / right - 1.0) < 0.1, f"{left} {right} of two equal discs"
    blue = np.argwhere(np.abs(image - np.array((0, 114, 178))).max(axis=2) < 12)
    disc = blue[blue[:, 1] < 0.5 * image.shape[1]]       # without the patch of the legend
    tall, wide = np.ptp(disc, axis=0)
    assert abs(tall / wide - 1.0) < 0.03, f"a disc is {wide} x {tall} pixels"
    assert disc[:, 0].mean() > 0.5 * image.shape[0], "the lower disc is not below"
    area = len(disc) / (math.pi * wide * tall / 4.0)
    assert area > 0.9, f"{area:.2f} of the disc are filled"
    later, _, _ = body_page(options, "two_discs", "--time", "2")
    assert later.shape[2] == 3 and (later.shape != image.shape or (later != image).any())


def ball_of(axes, width=1.0, radius=16.0):
    """Jittered particles of a disc or a ball about (1, 2, 3), those on the surface left whole."""
    sides = [np.arange(-radius - 1.5, radius + 2.0)] * axes
    places = np.stack([side.ravel() for side in np.meshgrid(*sides)], axis=1)
    places = places[np.linalg.norm(places, axis=1) < radius]
    return width * (places + np.random.default_rng(3).uniform(-0.25, 0.25, places.shape)) + np.arange(1.0, axes + 1.0)


def test_rigid_bodies_turn():
    """Would catch a rotation about the origin, one in the wrong sense, and a place of the row before or after."""
    half = math.sqrt(0.5)
    table = {"time": np.array([0.0, 1.0, 3.0]), "ram_x": np.array([1.0, 1.0, 2.0]), "ram_y": np.zeros(3),
             "ram_z": np.array([0.0, 0.0, 4.0]), "ram_turn_1": np.array([1.0, half, -half]), "ram_turn_x": np.zeros(3),
             "ram_turn_y": np.array([0.0, half, -half]), "ram_turn_z": np.zeros(3)}
    body, other = Wall("ram", "slip", 0, -1.0e30, 1.0e30), Wall("zlo", "slip", 5, -1.0e30, 1.0e30)
    add_paths([body, other], table)
    assert other.path is None
    corner = np.array([[[3.0, 0.0, 0.0], [1.0, 0.0, 1.0]]])
    assert np.allclose(body.placed(corner, 0.0), corner, atol=1.0e-15)
    # a quarter of a turn about y takes x to -z and z to x
    assert np.allclose(body.placed(corner, 1.0), [[[1.0, 0.0, -2.0], [2.0, 0.0, 0.0]]], atol=1.0e-15)
    assert np.allclose(body.placed(corner, 2.0), [[[1.5, 0.0, 0.0], [2.5, 0.0, 2.0]]], atol=1.0e-15)
    assert np.allclose(body.placed(corner, 9.0), [[[2.0, 0.0, 2.0], [3.0, 0.0, 4.0]]], atol=1.0e-15)


def test_surface():
    """A surface beside its particles by a part of a cell, too large or with holes; loose particles that are not drawn,
    flags that are averaged.

    A contour of half filled space lies s^2/(2R) per curved direction inside a disc or ball of radius R, s = 0.8 widths.
    """
    points = ball_of(2)
    stray = np.array([[25.0, 2.0]])
    every = np.concatenate([points, stray])
    filling = surface.Filling(every, np.tile(np.eye(2), (len(every), 1, 1)), np.ones(len(every)))
    path = surface.outline(filling)
    edges = path.to_polygons()
    assert len(edges) == 1, f"{len(edges)} outlines of one disc"
    x, y = np.array(edges[0])[:-1].T
    turned = 0.5 * (x * np.roll(y, -1) - np.roll(x, -1) * y)
    radius = math.sqrt(abs(turned.sum()) / math.pi)
    wanted = math.sqrt(len(points) / math.pi)
    assert abs(radius - wanted + surface.SMOOTH ** 2 / (2.0 * wanted)) < 0.05, f"radius {radius}, wanted {wanted}"
    centre = [((side + np.roll(side, -1)) * turned).sum() / (3.0 * turned.sum()) for side in (x, y)]
    assert np.abs(np.array(centre) - (1.0, 2.0)).max() < 0.1, f"the outline of the disc is about {centre}"
    loose = filling.loose(every, np.ones(len(every)))
    assert loose[-1] and not loose[:-1].any(), f"{loose.sum()} loose particles, wanted 1"
    flags = (points[:, :1] > 1.0).astype(float)
    assert set(np.unique(surface.mixed(points, flags, points + 0.3))) == {0.0, 1.0}

    points = np.concatenate([ball_of(3), [[1.0, 2.0, 30.0]]])
    loose, near, look = surface.cast(points, np.ones(len(points)), points, (-20.0, 22.0, -19.0, 23.0), (84, 84))
    assert loose[-1] and not loose[:-1].any(), f"{loose.sum()} loose particles, wanted 1"
    wanted = (0.75 * (len(points) - 1) / math.pi) ** (1.0 / 3.0)
    row, column = np.nonzero(near > -np.inf)
    right, up = -20.0 + 0.5 * (column + 0.5) - 1.0, 23.0 - 0.5 * (row + 0.5) - 2.0
    place = np.stack([right, up, near[row, column] - 3.0], axis=1)
    far = np.linalg.norm(place, axis=1)
    assert abs(far.mean() - wanted + surface.SMOOTH ** 2 / wanted) < 0.05, f"radius {far.mean()}, wanted {wanted}"
    assert np.abs(place.mean(axis=0)[:2]).max() < 0.1 and np.quantile(place[:, 2], 0.02) > 0.0, \
        "the surface is beside the ball"
    along = (look[:, :3] * place).sum(axis=1) / far
    assert np.median(along) > 0.98, f"cosine of normal and radius {np.median(along)}"
    assert np.abs(look[:, 3:] - place - (1.0, 2.0, 3.0)).max() < 2.0, "colours of particles elsewhere"


@pytest.mark.tiers("full", "long")
def test_surface_picture(options):
    """A surface that leaves out a body, or has another size or colour than the particles."""
    _, left, right = body_page(options, "two_discs", "--time", "0")
    _, left_surface, right_surface = body_page(options, "two_discs", "--time", "0", "--surface")
    assert abs(left_surface / left - 1.0) < 0.08 and abs(right_surface / right - 1.0) < 0.08


@pytest.mark.tiers("full", "long")
def test_axisymmetric_picture(options):
    """One half only, or halves that are not mirror images; --view or --bodies ignored."""
    image, sphere, sheet = body_page(options, "debris_cloud", "--time", "0", "--title", "")
    assert sphere > 0.005 and sheet > 0.005
    orange = np.abs(image - np.array((213, 94, 0))).max(axis=2) < 12
    matter_only = int(0.88 * image.shape[1])             # the legend is to the right of it
    columns = np.flatnonzero(orange[:, :matter_only].any(axis=0))
    middle = 0.5 * (columns.min() + columns.max())
    blue = np.argwhere(np.abs(image[:, :matter_only] - np.array((0, 114, 178))).max(axis=2) < 12)
    assert abs(np.median(blue[:, 1]) - middle) < 0.02 * image.shape[1], "not about the axis"
    _, sphere, sheet = body_page(options, "debris_cloud", "--time", "0", "--bodies", "sphere")
    assert sphere > 0.005 and sheet < 0.002, f"{sheet} of a body that was not asked for"
    snap = scree_post.snapshot(scree_post.series(series(options.work, "debris_cloud"))[-1][1])
    assert snap.points[:, 0].min() >= 0.0


@pytest.mark.tiers("full", "long")
def test_space_picture(options):
    """Nothing drawn without a display, mirror images or a cut ignored, a camera that cannot be moved."""
    whole, sphere, sheet = body_page(options, "debris_cloud_3d", "--camera", "z")
    assert whole.std() > 20.0, "an empty page"
    base = options.work / "out" / "debris_cloud_3d"
    found = {}
    for name, words in {"whole": (), "quarter": ("--no-mirror",), "half": ("--keep", "x>0"),
                        "turned": ("--camera", "30,60"), "large": ("--zoom", "2")}.items():
        out = options.work / f"space_{name}.png"
        good(call("picture", base, "--view", "-20mm", "20mm", "-20mm", "20mm", "--camera", "z",
                  "--colour", "failed", "--title", "", "--dpi", "80", "--out", out, *words))
        image = pixels(out)
        # shaded spheres: all that is not grey, left of the legend
        part = image[int(0.1 * len(image)):, :int(0.72 * image.shape[1])]
        found[name] = float((np.ptp(part, axis=2) > 40).mean())
    assert found["whole"] > 0.2, found
    assert abs(found["quarter"] / found["whole"] - 0.25) < 0.05, found
    assert abs(found["half"] / found["whole"] - 0.5) < 0.08, found
    assert abs(found["turned"] - found["whole"]) > 0.01, found


@pytest.mark.tiers("full", "long")
def test_fragment_picture(options):
    """A colour bar from 0 to the last number, two heavy fragments of one colour, small fragments as bright as large
    ones."""
    out = options.work / "fragments.png"
    base = options.work / "out" / "debris_cloud_3d"
    good(call("picture", base, "--colour", "fragment", "--camera", "z", "--title", "", "--dpi", "100", "--out",
              out))
    snap = scree_post.snapshot(scree_post.series(series(options.work, "debris_cloud_3d"))[-1][1])
    assert set(snap.fields["fragment"]) == {1}, "at this time the sphere still sits in the sheet"
    image = pixels(out)
    heavy = np.argwhere(np.abs(image - np.array((0, 114, 178))).max(axis=2) < 40)
    assert len(heavy) > 0.01 * image[..., 0].size, "the heaviest fragment is not blue"
    snap.fields["fragment"] = np.arange(len(snap.points)) % 9
    colour = colour_for("fragment", [snap])
    assert colour.names == ("1, the heaviest", "2", "3", "4", "5", "6", "others", "none"), colour.names
    tints = [tuple(tint) for tint in paint(colour, np.arange(14.0))]
    assert len(set(tints[:13])) == 13 and tints[13] == tints[7], tints
    assert max(tints[0][:3]) - min(tints[0][:3]) < 0.01, "none is not grey"
    snap.fields["fragment"] = 1 + np.arange(len(snap.points)) % 2
    assert colour_for("fragment", [snap]).names == ("1, the heaviest", "2")


def frames_of(path):
    """The frames of a film."""
    import subprocess
    if path.suffix == ".gif":
        from PIL import Image, ImageSequence
        with Image.open(path) as image:
            return [np.asarray(page.convert("RGB")).astype(int)
                    for page in ImageSequence.Iterator(image)]
    folder = path.with_suffix("")
    folder.mkdir(exist_ok=True)
    for old in folder.glob("*.png"):
        old.unlink()
    subprocess.run([film.encoder(), "-y", "-loglevel", "error", "-i", path, folder / "%03d.png"],
                   check=True)
    return [pixels(page) for page in sorted(folder.glob("*.png"))]


@pytest.mark.tiers("full", "long")
def test_movie(options):
    """A frame missing, all frames the same, colours that change from frame to frame, half a film."""
    base = options.work / "out"
    times = [time for time, _ in scree_post.series(series(options.work, "two_discs"))]
    for name in ("discs.gif", "discs.mp4"):
        out = options.work / name
        if out.suffix == ".mp4":
            try:
                film.encoder()
            except scree_post.ScreeError as error:
                assert "imageio-ffmpeg" in str(error) and error.code == 2
                answer = call("movie", base / "two_discs", "--out", out)
                assert answer.returncode == 2 and "write a .gif" in answer.stderr, answer.stderr
                report.skipped("films in .mp4", "neither imageio-ffmpeg nor ffmpeg is installed")
                continue
        text = good(call("movie", base / "two_discs", "--colour", "pressure", "--dpi", "50",
                         "--out", out))
        assert f"{len(times)} pages" in text, text
        pages = frames_of(out)
        assert len(pages) == len(times), f"{len(pages)} pages of {len(times)} in {name}"
        assert len({page.shape for page in pages}) == 1
        changed = [float((np.abs(one - two).max(axis=2) > 30).mean())
                   for one, two in zip(pages, pages[1:])]
        assert min(changed) > 0.001, f"pages that do not differ: {changed}"
        bar = [page[page.shape[0] // 4:3 * page.shape[0] // 4, int(0.90 * page.shape[1]):]
               for page in pages]
        most = 4.0 if out.suffix == ".mp4" else 0.0      # a .gif has one palette for all frames
        assert max(np.abs(one - bar[0]).mean() for one in bar) <= most, "the colour bar changes"
    assert not list(options.work.glob("*.part*"))
    good(call("movie", base / "two_discs", "--every", "5", "--from", "0.5", "--out",
              options.work / "page.png", "--dpi", "50"))
    late = [time for time in times if time >= 0.5][::5]
    assert len(list(options.work.glob("page_*.png"))) == len(late)


@pytest.mark.tiers("full", "long")
def test_turning_film(options):
    """A camera that does not turn, or a window that changes, in three dimensions."""
    out = options.work / "turning.gif"
    good(call("movie", options.work / "out" / "debris_cloud_3d", "--turn", "90", "--every", "2",
              "--dpi", "50", "--colour", "body", "--out", out))
    pages = frames_of(out)
    assert len(pages) == 3 and len({page.shape for page in pages}) == 1
    assert (np.abs(pages[0] - pages[1]).max(axis=2) > 30).mean() > 0.02


@pytest.mark.tiers("full", "long")
def test_colours(options):
    """The wrong component, a colour range stretched by outliers, signs that are not shown."""
    file = scree_post.series(series(options.work, "debris_cloud"))[-1][1]
    snap = scree_post.snapshot(file)
    velocity = snap.fields["velocity"].astype("f8")
    assert np.array_equal(values_of(snap, "velocity.z"), velocity[:, 2])
    assert np.allclose(values_of(snap, "velocity"), np.linalg.norm(velocity, axis=1), rtol=1e-12)
    assert np.array_equal(values_of(snap, "x"), snap.points[:, 0])
    speed = colour_for("velocity", [snap])
    assert speed.unit == "km/s" and speed.low == 0.0 and speed.label == "speed"
    largest = np.linalg.norm(velocity, axis=1).max()
    assert abs(1.0e3 * speed.high / largest - 1.0) < 0.3, f"{speed.high} for {largest}"
    snap.fields["pressure"] = np.linspace(-1.0e9, 1.0e9, len(snap.points))
    both = colour_for("pressure", [snap])
    assert both.map == "coolwarm" and both.low == -both.high and both.unit == "GPa"
    snap.fields["pressure"][:] = 1.0
    snap.fields["pressure"][0] = 1.0e30
    snap.fields["pressure"][1:600] = np.linspace(0.0, 2.0, 599)
    stray = colour_for("pressure", [snap])
    assert stray.high < 10.0 and stray.beyond == (False, True), stray
    ends = paint(both, np.array([-2.0e9, 2.0e9, np.nan]))
    assert (ends[0] != ends[1]).any() and (ends[2, :3] == 0.6).all()


@pytest.mark.tiers("full", "long")
def test_radiograph(options):
    """Mass lost between particles and picture for files of the program."""
    for name, copies in (("debris_cloud", 1.0), ("debris_cloud_3d", 4.0), ("two_discs", 1.0)):
        text = good(call("radiograph", options.work / "out" / name, "--frames", "2", "--dpi", "50",
                         "--pixel", "10" if name == "two_discs" else "0.5",
                         "--out", options.work / f"{name}_ray.png"))
        rows = [line.split() for line in text.splitlines()[1:3]]
        file = scree_post.series(series(options.work, name))[-1][1]
        mass = copies * scree_post.snapshot(file).fields["mass"].sum(dtype="f8")
        assert abs(float(rows[-1][3]) / mass - 1.0) < 1.0e-7, f"{name}: {rows[-1]} {mass}"
        assert all(abs(float(row[4]) / float(row[3]) - 1.0) < 1.0e-6 for row in rows), rows


def lattice(corner, cells, step=1.0e-3):
    """Particles of a block of cells."""
    axes = [step * (np.arange(count) + 0.5) for count in cells]
    return np.array(corner) + np.stack([g.ravel() for g in np.meshgrid(*axes)], axis=1)


def snapshot_of(options, points, dimension="3d", symmetry="", failed=None, echo="", step=1.0e-3):
    """A snapshot of particles of one width."""
    volume = np.full(len(points), step ** 3)
    if dimension == "axisymmetric":
        volume = 2.0 * math.pi * points[:, 0] * step ** 2
    velocity = np.tile((1.0, 2.0, 3.0), (len(points), 1))
    fields = matter(1000.0 * volume, volume, velocity)
    fields["failed"] = (np.zeros(len(points)) if failed is None else failed, "1")
    snap = scree_post.snapshot(write(f"{options.work}/blocks.hdf", 1.0e-6, points, fields,
                                     dimension=dimension, symmetry=symmetry))
    snap.echo = echo
    return snap


@pytest.mark.tiers("full", "long")
def test_fragments_of_blocks(options):
    """Blocks joined that are separate or separated that touch; masses, positions, sizes of the wrong block."""
    points = np.concatenate([lattice((0, 0, 0), (4, 4, 4)), lattice((0, 0, 5.6e-3), (3, 3, 3)),
                             lattice((20e-3, 0, 0), (2, 1, 1))])
    random = np.random.default_rng(3).permutation(len(points))
    snap = snapshot_of(options, points[random])
    for how in ({"factor": 1.5}, {"cell": 1.3e-3}):
        found = fragment_table.fragments_of(snap, **how)
        assert [row[2] for row in found.rows] == [64, 27, 2], f"{how}: {found.rows}"
    heavy = fragment_table.fragments_of(snap, factor=1.5).rows[0]
    assert abs(heavy[3] - 64.0e-6) < 1.0e-15 and abs(heavy[4] - 64.0e-9) < 1.0e-18
    assert np.allclose(heavy[6:9], 2.0e-3, rtol=1e-9) and np.allclose(heavy[9:12], (1, 2, 3))
    assert abs(heavy[5] - (6.0 * 64.0e-9 / math.pi) ** (1 / 3)) < 1.0e-12
    one = fragment_table.fragments_of(snap, factor=2.7)  # the gap is 1.6 + 1 widths
    assert [row[2] for row in one.rows] == [91, 2], one.rows
    failed = (points[random][:, 2] > 2.0e-3) & (points[random][:, 2] < 3.0e-3)
    found = fragment_table.fragments_of(snapshot_of(options, points[random],
                                                    failed=failed.astype(float)))
    assert [row[2] for row in found.rows] == [32, 27, 16, 2], found.rows
    assert abs(found.masses.sum() + found.failed - found.total) < 1.0e-15
    assert abs(found.failed - 16.0e-6) < 1.0e-15


@pytest.mark.tiers("full", "long")
def test_fragments_by_brute_force():
    """Pairs lost in the search by cells, where widths and densities differ."""
    random = np.random.default_rng(11)
    for axes, count in ((2, 400), (3, 500), (1, 60)):
        points = random.uniform(-1.0, 1.0, (count, axes)) ** 3
        width = random.uniform(0.5, 1.5, count) * 0.6 / count ** (1.0 / axes)
        labels = pieces.find_pieces(points, width, 1.2)
        reach = 0.6 * (width[:, None] + width[None, :])
        near = ((points[:, None, :] - points[None, :, :]) ** 2).sum(axis=2) <= reach ** 2
        mine = np.arange(count)
        for _ in range(count):                           # labels spread until nothing changes
            lower = np.where(near, mine[None, :], count).min(axis=1)
            if np.array_equal(lower, mine):
                break
            mine = lower
        assert 3 < len(set(mine)) < count, "nothing to find"
        pairs = set(zip(labels.tolist(), mine.tolist()))
        assert len(pairs) == len(set(labels.tolist())) == len(set(mine.tolist())), f"{axes} axes"


@pytest.mark.tiers("full", "long")
def test_fragments_at_faces(options):
    """A fragment across a mirror plane counted twice or halved, a fragment cut at a periodic boundary."""
    points = np.concatenate([lattice((0, 0, 0), (2, 2, 2)), lattice((6e-3, 0, 0), (1, 1, 1))])
    found = fragment_table.fragments_of(snapshot_of(options, points, symmetry="xlo ylo"))
    # the isolated fragment touches the plane y = 0, not x = 0
    assert [row[2] for row in found.rows] == [32, 2, 2], found.rows
    assert abs(found.total - 4.0 * 9.0e-6) < 1.0e-15
    assert np.allclose(found.rows[0][9:12], (0, 0, 3), atol=1e-12), "velocity of the whole"
    assert "mirror planes xlo ylo" in found.note
    half = fragment_table.fragments_of(snapshot_of(options, points, symmetry="xlo ylo"),
                                       mirror=False)
    assert [row[2] for row in half.rows] == [8, 1] and "not completed" in half.note
    echo = ("&grid\n   lo = 0.0, 0.0, 0.0\n   hi = 0.01, 0.01, 0.01\n   dx = 0.002\n/\n"
            "&boundary\n   face = 'zlo'\n   type = 'periodic'\n/\n")
    points = np.concatenate([lattice((0, 0, 0), (1, 1, 1)), lattice((0, 0, 8e-3), (1, 1, 2)),
                             lattice((5e-3, 0, 4e-3), (1, 1, 1))])
    found = fragment_table.fragments_of(snapshot_of(options, points, echo=echo))
    assert [row[2] for row in found.rows] == [3, 1], found.rows
    assert abs(found.rows[0][8] - 9.5e-3) < 1.0e-12, f"centre at {found.rows[0][8]}"
    assert "periodic along z" in found.note
    found = fragment_table.fragments_of(snapshot_of(options, points))
    assert [row[2] for row in found.rows] == [2, 1, 1], "ends tied without a periodic face"


@pytest.mark.tiers("full", "long")
def test_fragments_are_rings(options):
    """A ring of an axisymmetric run reported as a compact body: mass, radius, size of the cross-section."""
    flat = lattice((4e-3, 0, 0), (3, 1, 3))
    flat[:, 1] = 0.0
    found = fragment_table.fragments_of(snapshot_of(options, flat, "axisymmetric"))
    (row,) = found.rows
    assert "ring" in found.note
    assert abs(row[3] / (1000.0 * 2.0 * math.pi * 5.5e-3 * 9.0e-6) - 1.0) < 1.0e-12, row[3]
    assert abs(row[5] / (2.0 * math.sqrt(9.0e-6 / math.pi)) - 1.0) < 1.0e-9, row[5]


@pytest.mark.tiers("full", "long")
def test_fragments_command(options):
    """A table without the mass of some particles, or one that cannot be read again."""
    table = options.work / "pieces.csv"
    for name, copies in (("debris_cloud_3d", 4.0), ("debris_cloud", 1.0)):
        text = good(call("fragments", options.work / "out" / name, "--all", "--table", table,
                         "--out", options.work / "pieces.png"))
        found = scree_post.history(str(table))
        assert found.order == [title.split(" [")[0] for title in fragment_table.COLUMNS]
        assert found.units["mass"] == "kg" and found.units["velocity_z"] == "m/s"
        frames = scree_post.series(series(options.work, name))
        for time, file in frames:
            snap = scree_post.snapshot(file)
            whole = copies * snap.fields["mass"][snap.fields["failed"] < 0.5].sum(dtype="f8")
            rows = np.abs(found["time"] - time) < 1.0e-12
            assert abs(found["mass"][rows].sum() / whole - 1.0) < 1.0e-6, f"{name} at {time}"
            assert (np.diff(found["mass"][rows]) <= 1.0e-9 * found["mass"].max()).all()
        assert snap.fields["failed"].sum() > 100, "nothing has failed in the run"
        assert text.count("fragments, ") == len(frames)
        assert pixels(options.work / "pieces.png").std() > 10.0


def refused(answer, code, *parts):
    """A call that must end with one line on standard error that contains some words."""
    said = answer.stderr.strip().splitlines()
    assert answer.returncode == code and len(said) == 1, f"exit {answer.returncode}: {said}"
    assert all(part in said[0] for part in parts), f"{parts} not in: {said[0]}"


@pytest.mark.tiers("full", "long")
def test_mistakes(options):
    """A traceback instead of a message, no suggestion, a wrong exit code, half a picture."""
    discs, cloud = (options.work / "out" / name for name in ("two_discs", "debris_cloud_3d"))
    never = ("--out", options.work / "never.png")
    cases = [
        (("picture", discs, "--colour", "presure", *never), 2, "did you mean 'pressure'"),
        (("picture", discs, "--colour", "velocity.w", *never), 2, "no component 'w'", "x, y, z"),
        (("picture", discs, "--colour", "pressure.x", *never), 2, "no components"),
        (("picture", discs, "--bodies", "lefd", *never), 2, "did you mean 'left'"),
        (("picture", discs, "--hide-failed", *never), 3, "'failed'", "&output fields"),
        (("picture", discs, "--time", "5lightyears", *never), 2, "5us"),
        (("picture", discs, "--range", "2", "1", *never), 2, "LOW < HIGH"),
        (("picture", discs, "--view", "1", "0", "0", "1", *never), 2, "LEFT < RIGHT"),
        (("picture", discs, "--keep", "y>0", *never), 2, "three dimensions"),
        (("picture", discs, "--map", "jet", *never), 2, "viridis"),
        (("picture", discs, "--out", options.work / "a.doc"), 2, ".png"),
        (("picture", discs, "--out", options.work / "none" / "a.png"), 3, "no folder"),
        (("picture", cloud, "--camera", "up", *never), 2, "AZIMUTH"),
        (("picture", cloud, "--keep", "y=0", *never), 2, "'y>0'"),
        (("picture", cloud, "--keep", "y>left", *never), 2, "'left'"),
        (("picture", cloud, "--zoom", "0", *never), 2, "--zoom"),
        (("movie", discs, "--out", "film.avi"), 2, ".mp4"),
        (("movie", discs, "--turn", "9", "--out", options.work / "never.gif"), 2, "--turn"),
        (("movie", discs, "--from", "99", "--out", options.work / "never.gif"), 2, "no snapshot"),
        (("movie", discs, "--quality", "99", "--out", options.work / "never.gif"), 2, "--quality"),
        (("movie", discs, "--rate", "0", "--out", options.work / "never.gif"), 2, "--rate"),
        (("movie", options.work / "out" / "none"), 3, "no such file"),
        (("fragments", discs, "--reach", "0", *never), 2, "--reach"),
        (("fragments", discs, "--cell", "0", *never), 2, "--cell"),
        (("fragments", discs, "--least", "0", *never), 2, "--least"),
        (("fragments", discs, "--table", options.work / "no" / "t.csv", *never), 3, "cannot write")]
    for words, code, *parts in cases:
        refused(call(*words), code, *parts)
    assert not list(options.work.glob("never*")) and not list(options.work.glob("*.part*"))


@pytest.mark.tiers("full", "long")
def test_missing_packages(options):
    """A 3-D picture that needs vtk or a display, a traceback where ffmpeg is not installed."""
    import importlib

    from scree import errors
    saved, which = importlib.import_module, film.shutil.which

    def without(name, *rest):
        if name.split(".")[0] in ("vtk", "pyvista"):
            raise ImportError("no", name=name)
        return saved(name, *rest)

    errors.importlib.import_module, film.shutil.which = without, lambda name: None
    hidden = {name: sys.modules.get(name) for name in ("imageio_ffmpeg", "vtk", "pyvista")}
    sys.modules.update(dict.fromkeys(hidden))
    try:
        good(call("picture", options.work / "out" / "debris_cloud_3d", "--dpi", "50", "--out",
                  options.work / "alone.png"))
        refused(call("movie", options.work / "out" / "two_discs", "--out",
                     options.work / "a.mp4"), 2, "imageio-ffmpeg", "write a .gif")
    finally:
        errors.importlib.import_module, film.shutil.which = saved, which
        for name, module in hidden.items():
            if module is None:
                del sys.modules[name]
            else:
                sys.modules[name] = module


@pytest.mark.tiers("full", "long")
def test_sample(options):
    """A film whose window is that of its first frame."""
    frames = scree_post.series(series(options.work, "debris_cloud"))
    files = view_options.sample(frames)
    assert files[0] == frames[0][1] and files[-1] == frames[-1][1] and len(files) == 6
    arguments = parser_of("movie", movie_command).parse_args(
        [series(options.work, "debris_cloud")])
    page = view_options.pages(arguments, files)
    snap = scree_post.snapshot(frames[-1][1])
    assert page.box[3] > snap.points[:, 2].max() and page.box[1] > snap.points[:, 0].max()
    assert page.box[0] == -page.box[1]
