# SPDX-License-Identifier: BSD-3-Clause
"""Tests of the Python post-processing on snapshots with analytical solutions.

The first line of each test states which bug it would catch. No run of the program is needed.
"""

import json
import os
import re

import h5py
import numpy as np
import pytest

import case
import scree_post
from post_command import call, process
from sample_snapshots import CENTRE, DENSITY, RADIUS, ball, make_series, matter, write
from scree.drawing import areal_density


@pytest.fixture
def work(options):
    """Folder of a test."""
    return str(options.work)


def closed(frame, outer, inner, density):
    """Areal density of a shell at the pixel centres, and the distance from its centre [m]."""
    rows, columns = frame.sigma.shape
    left, _, bottom, _ = frame.box
    x = left + (np.arange(columns) + 0.5) * frame.pixel - CENTRE
    y = bottom + (np.arange(rows) + 0.5) * frame.pixel
    distance = np.hypot(x[None, :], y[:, None])
    chord = np.sqrt(np.maximum(outer ** 2 - distance ** 2, 0.0)) \
        - np.sqrt(np.maximum(inner ** 2 - distance ** 2, 0.0))
    return 2.0 * density * chord, distance


def worst(frame, outer, density, inner=0.0, rim=0.1):
    """Largest and root mean square error away from the edges, relative to the peak."""
    exact, distance = closed(frame, outer, inner, density)
    inside = (distance < (1.0 - rim) * outer) & (
        np.abs(distance - inner) > rim * outer * (inner > 0.0)
    )
    error = (frame.sigma - exact)[inside] / exact.max()
    return np.abs(error).max(), np.sqrt((error ** 2).mean())


# --- tests ------------------------------------------------------------------------------------

def close(found, wanted, tolerance, what):
    """Fail with the numbers."""
    assert abs(found - wanted) <= tolerance * abs(wanted), f"{what}: {found!r}, wanted {wanted!r}"


def test_sphere_axisymmetric(work):
    """Wrong Abel transform, a caustic or bright line on the axis, mass per radian instead of the full circle."""
    snap = scree_post.snapshot(ball(f"{work}/axial_p_000001.hdf", "axisymmetric", 100))
    frame = areal_density.radiograph(snap, RADIUS / 60.0)
    largest, mean = worst(frame, RADIUS, DENSITY)
    assert largest < 0.01 and mean < 0.003, f"errors {largest:.4f}, {mean:.4f}"
    close(frame.mass, DENSITY * 4.0 / 3.0 * np.pi * RADIUS ** 3, 2.0e-3, "mass of the ball")
    assert frame.mass_error < 1.0e-6, f"mass error {frame.mass_error:.1e}"
    assert np.array_equal(frame.sigma, frame.sigma[::-1]), "the two halves differ"
    print(f"   sphere, axisymmetric: largest error {largest:.4f}, mean {mean:.4f} of the peak")


def test_sphere_quarter(work):
    """Mirror images missing or doubled, axes exchanged, kernel not integrated."""
    snap = scree_post.snapshot(ball(f"{work}/quarter_p_000001.hdf", "3d", 30))
    for sight in "xy":
        frame = areal_density.radiograph(snap, RADIUS / 40.0, sight)
        largest, mean = worst(frame, RADIUS, DENSITY)
        assert largest < 0.02 and mean < 0.008, f"line of sight {sight}: {largest:.4f}, {mean:.4f}"
        close(frame.mass, 4.0 * snap.fields["mass"].sum(), 1.0e-12, "mass of four quarters")
        assert frame.mass_error < 1.0e-6
    assert frame.vertical == "x"
    print(f"   sphere, 3-D quarter: largest error {largest:.4f}, mean {mean:.4f} of the peak")


def test_grown_ball(work):
    """Size of a particle from its initial volume instead of its current one: gaps."""
    for dimension, cells in (("axisymmetric", 60), ("3d", 30)):
        snap = scree_post.snapshot(ball(f"{work}/grown_p_000001.hdf", dimension, cells, grown=4.0))
        frame = areal_density.radiograph(snap, RADIUS / 40.0)
        largest, mean = worst(frame, 4.0 * RADIUS, DENSITY / 64.0)
        assert largest < 0.025 and mean < 0.01, f"{dimension}: {largest:.4f}, {mean:.4f}"
        assert frame.mass_error < 1.0e-6


def test_shell(work):
    """Projection that is correct for full balls only: limb of a shell wrong, inside not hollow."""
    inner = 0.7 * RADIUS
    snap = scree_post.snapshot(ball(f"{work}/shell_p_000001.hdf", "axisymmetric", 140, inner=inner))
    frame = areal_density.radiograph(snap, RADIUS / 60.0)
    largest, mean = worst(frame, RADIUS, DENSITY, inner, rim=0.05)
    assert largest < 0.02 and mean < 0.008, f"errors {largest:.4f}, {mean:.4f}"


def test_annulus():
    """A projection matrix that loses mass where radii and pixels do not coincide."""
    edges, radii = np.linspace(0.0, 1.3, 38), np.linspace(0.0, 1.2, 91)
    share = areal_density.annulus_projection(radii, edges)
    assert share.min() >= -1.0e-15 and np.abs(share.sum(axis=1) - 0.5).max() < 1.0e-12
    x, outer, inner = 0.31, radii[60], radii[59]         # a thin ring: the Abel kernel itself
    fine = areal_density.annulus_projection(radii[59:61], np.array([x, x + 1.0e-4]))[0, 0] / 1.0e-4
    close(fine, 1.0 / (np.pi * np.sqrt((0.5 * (outer + inner)) ** 2 - x**2)), 1.0e-3, "Abel kernel")


def test_random_sizes():
    """Mass lost where large and small particles are processed together, at the axis, or at a pixel edge."""
    random = np.random.default_rng(5)
    r, z = np.abs(random.normal(size=3000)), random.normal(size=3000)
    half, mass = 10.0 ** random.uniform(-3.0, 0.3, 3000), random.uniform(0.0, 1.0, 3000)
    r[:10], z[:10] = 0.0, 0.05 * np.arange(10)
    half = np.maximum(half, 0.05)
    for radial in (True, False):
        low = 0.0 if radial else -5.0
        image = areal_density.deposit(
            (z, r), mass, half, (-8.0, low), (0.05, 0.025), (600, 320), radial
        )
        close(image.sum(), mass.sum(), 1.0e-12, "mass of the image")
        assert image.min() >= -1.0e-15, "negative mass in a pixel"
        close((image.sum(axis=0) * (-8.0 + 0.05 * (np.arange(320) + 0.5))).sum() / mass.sum(),
              (mass * z).sum() / mass.sum(), 2.0e-2, "centre of mass")


def test_leading_edge(work):
    """Speed of the leading edge from the sheet at rest, from an isolated particle, or with the wrong sign."""
    snap = scree_post.snapshot(ball(f"{work}/edge_p_000001.hdf", "axisymmetric", 40, speed=-6000.0))
    rest = snap.points[:, 2] > CENTRE
    snap.fields["velocity"][rest] = 0.0
    stray = int(np.argmin(snap.points[:, 2]))
    snap.points[stray, 2], snap.fields["velocity"][stray, 2] = -1.0, -20000.0
    snap.fields["mass"][stray] *= 1.0e-6
    frame = areal_density.radiograph(snap, 1.0e-3, "y", -1.0)
    close(frame.speed, -6000.0, 1.0e-3, "speed of the leading edge")
    assert abs(frame.front - (CENTRE - RADIUS)) < 0.05 * RADIUS, f"front at {frame.front}"


def test_symmetry_plane(work):
    """Mirroring at 0 when the plane of symmetry is elsewhere; an unknown face ignored."""
    snap = scree_post.snapshot(ball(f"{work}/plane_p_000001.hdf", "3d", 12))
    still = areal_density.radiograph(snap, RADIUS / 20.0).sigma
    snap.points[:, 0] += 20.0 * RADIUS
    snap.provenance["grid_lo"] = np.array([20.0 * RADIUS, 0.0, 0.0])
    moved = areal_density.radiograph(snap, RADIUS / 20.0).sigma
    assert moved.shape == still.shape and np.abs(moved - still).max() < 1.0e-6 * still.max()
    snap.provenance["symmetry"] = "xlo left"
    try:
        areal_density.radiograph(snap, RADIUS / 20.0)
    except scree_post.ScreeError as error:
        assert "'left'" in str(error)
    else:
        raise AssertionError("an unknown face of symmetry was accepted")


def picture_size(path):
    """Width and height of a PNG file."""
    with open(path, "rb") as handle:
        head = handle.read(24)
    assert head[:8] == b"\x89PNG\r\n\x1a\n", f"{path} is not a PNG"
    return int.from_bytes(head[16:20], "big"), int.from_bytes(head[20:24], "big")


def test_radiograph_command(work):
    """A picture that needs a display or depends on the current folder, frames chosen wrongly."""
    series, entries = make_series(work)
    run = process("radiograph", os.path.dirname(series))
    assert run.returncode == 0, run.stderr
    rows = [line.split() for line in run.stdout.splitlines() if re.match(r"\s+\d", line)]
    assert [float(row[0]) for row in rows] == [1.0, 2.0, 3.0], run.stdout
    assert all(
        float(row[5]) < 1.0e-6 and abs(float(row[4]) / float(row[3]) - 1.0) < 1.0e-6 for row in rows
    )
    wide, _ = picture_size(series.replace("_p.hdf.series", "_radiograph.png"))
    assert wide >= 1000
    lone = os.path.join(os.path.dirname(series), entries[2]["name"])
    for words in (
        (series, "--time", "2"),
        (lone,),
        (series, "--last", "--unit", "g/cm2", "--mu", "0.1"),
        (series, "--frames", "2", "--view", "-10", "20", "-15", "15", "--pixel", "0.2"),
    ):
        run = call("radiograph", *words, "--out", f"{work}/one.png")
        assert run.returncode == 0, run.stderr
        assert picture_size(f"{work}/one.png")[1] > 300
        os.remove(f"{work}/one.png")
    run = call("radiograph", series, "--time", "0", "--out", f"{work}/empty.png")
    assert run.returncode == 0, run.stderr


def test_movie(work):
    """A film with a missing frame or with frames of different sizes, and the file for ParaView that names no series."""
    series, entries = make_series(work, name="film")
    together = series.removesuffix(".hdf.series") + ".vtkhdf"
    with open(together, "wb"):
        pass
    run = call(
        "radiograph",
        together,
        "--last",
        "--movie",
        f"{work}/film.gif",
        "--out",
        f"{work}/film.png",
    )
    assert run.returncode == 0, run.stderr
    from PIL import Image
    with Image.open(f"{work}/film.gif") as film:
        assert film.n_frames == len(entries), f"{film.n_frames} pages"


def test_errors(work):
    """A traceback instead of a message, a wrong exit code, a picture in spite of an error."""
    series, entries = make_series(work, name="bad")
    folder = os.path.dirname(series)
    first = os.path.join(folder, entries[1]["name"])
    with open(f"{work}/text.hdf", "w", encoding="ascii") as handle:
        handle.write("not hdf5")
    with open(first, "rb") as source, open(f"{work}/short.hdf", "wb") as handle:
        handle.write(source.read()[:3000])
    with h5py.File(f"{work}/other.hdf", "w") as handle:
        handle["numbers"] = np.arange(3)
    with open(f"{work}/broken.hdf.series", "w", encoding="ascii") as handle:
        handle.write('{"files": [{"name": "x"}')
    with open(f"{work}/gone.hdf.series", "w", encoding="ascii") as handle:
        json.dump({"files": [{"name": "gone.hdf", "time": 0.0}]}, handle)
    zero = np.zeros((4, 3))
    write(f"{work}/line.hdf", 0.0, zero, matter(np.ones(4), np.ones(4), zero), dimension="1d")
    write(f"{work}/thin.hdf", 0.0, zero, {"mass": (np.ones(4), "kg")}, dimension="3d")
    with open(f"{work}/words.csv", "w", encoding="ascii") as handle:
        handle.write("a,b\n1,2\n")
    with open(f"{work}/head.csv", "w", encoding="ascii") as handle:
        handle.write("time [s],kinetic [J]\n")
    out = ("--out", f"{work}/never.png")
    cases = [("radiograph", (f"{work}/absent.hdf", *out), 3, "no such file"),
             ("radiograph", (f"{work}/text.hdf", *out), 3, "not HDF5"),
             ("radiograph", (f"{work}/short.hdf", *out), 3, "truncated"),
             ("radiograph", (f"{work}/other.hdf", *out), 3, "/VTKHDF/Points"),
             ("radiograph", (f"{work}/broken.hdf.series", *out), 3, "not a snapshot series"),
             ("radiograph", (f"{work}/gone.hdf.series", *out), 3, "gone.hdf"),
             ("radiograph", (f"{work}/line.hdf", *out), 2, "one-dimensional"),
             ("radiograph", (f"{work}/thin.hdf", *out), 3, "velocity"),
             ("radiograph", (str(case.ROOT / "python/src"), *out), 3, "no particle series"),
             ("radiograph", (first, "--out", f"{work}/absent/a.png"), 3, "cannot write"),
             ("radiograph", (first, "--out", f"{work}/never.doc"), 2, ".png"),
             ("radiograph", (first, *out, "--movie", "a.avi"), 2, ".gif"),
             ("radiograph", (first, *out, "--pixel", "-1"), 2, "--pixel"),
             ("radiograph", (first, *out, "--pixel", "1e-5"), 2, "pixels"),
             ("radiograph", (first, *out, "--axis", "w"), 2, "--axis"),
             ("radiograph", (), 2, "SERIES_OR_SNAPSHOT"),
             ("plot", (f"{work}/absent.csv", *out), 3, "no such file"),
             ("plot", (f"{work}/words.csv", *out), 3, "time [s]"),
             ("plot", (f"{work}/head.csv", *out), 3, "no complete line"),
             ("plot", (first, *out), 3, "not a history"),
             ("check", (f"{work}/absent.hdf.series",), 3, "no such file"),
             ("check", (f"{work}/other.hdf",), 3, "/VTKHDF/Points"),
             ("check", ("--nothing", series), 2, "--nothing")]
    for command, words, code, part in cases:
        run = call(command, *words)
        assert run.returncode == code, f"{command} {words}: exit {run.returncode}, {run.stderr}"
        said = run.stderr.strip().splitlines()
        assert len(said) == 1, f"{command} {words}: not one line: {run.stderr}"
        assert part in said[0], f"{command} {words}: '{part}' not in: {run.stderr}"
        assert "Traceback" not in run.stderr, run.stderr
    assert not [
        name for name in os.listdir(work) if name.startswith("never")
    ], "a picture was written"
    for command in ("radiograph", "plot", "check"):
        run = call(command, "--help")
        assert run.returncode == 0 and "usage" in run.stdout and not run.stderr


def test_history(work):
    """Units lost, columns shifted, an incomplete line read, a missing column required."""
    path = f"{work}/ball_history.csv"
    with open(path, "w", encoding="ascii") as handle:
        handle.write(
            "time [s],step,momentum_z [kg m/s],kinetic [J],total [J],energy_error [1],front_z [m]\n"
        )
        for step in range(20):
            handle.write(
                f"{step * 1e-7:.17g},{step},-2.5,{100 - step},100,{step * 1e-6:g},{step * 1e-4:g}\n"
            )
        handle.write("2.0e-6,20,-2")
    table = scree_post.history(path)
    assert table.order == [
        "time",
        "step",
        "momentum_z",
        "kinetic",
        "total",
        "energy_error",
        "front_z",
    ]
    assert (
        len(table["time"]) == 20 and table["kinetic"][-1] == 81.0 and table["momentum_z"][0] == -2.5
    )
    assert table.units["momentum_z"] == "kg m/s" and table.units["step"] == "1"
    run = call("plot", path)
    assert run.returncode == 0, run.stderr
    assert "total energy: 1.90e-05" in run.stdout, run.stdout
    picture_size(path.replace(".csv", ".png"))


def test_reading(work):
    """Bodies or units read with their padding, the series out of order, a wrong time."""
    series, entries = make_series(work, name="read")
    found = scree_post.series(series)
    assert [time for time, _ in found] == [entry["time"] for entry in entries]
    snap = scree_post.snapshot(found[2][1])
    assert snap.time == 2.0e-6 and [body["name"] for body in snap.bodies] == ["ball", "sheet"]
    assert snap.units["velocity"] == "m/s" and snap.fields["stress"].shape == (len(snap.points), 6)
    assert snap.dimension == "axisymmetric" and snap.symmetry == ["xlo"]
    assert scree_post.series(found[2][1]) == [(2.0e-6, found[2][1])]


def test_check_files(work):
    """A check that always passes: each damage made here must be found."""
    series, entries = make_series(work, name="files")
    run = process("check", series)
    fine = 0
    if "VTK not asked" in run.stdout:
        fine = 77
        print("   the package vtk is missing: only what h5py sees is checked")
    assert run.returncode == fine, run.stdout + run.stderr
    victim = os.path.join(os.path.dirname(series), entries[2]["name"])

    def damage(change, word, in_vtk=False):
        if in_vtk and fine:
            return
        with open(victim, "rb") as handle:
            saved = handle.read()
        with h5py.File(victim, "r+") as handle:
            change(handle["VTKHDF"])
        run = process("check", series)
        assert run.returncode == 1 and word in run.stdout, f"{word}: {run.returncode} {run.stdout}"
        with open(victim, "wb") as handle:
            handle.write(saved)

    def wrong_type(group):
        del group.attrs["Type"]
        group.attrs["Type"] = "UnstructuredGrid"

    def drop_units(group):
        del group["PointData/mass"].attrs["units"]

    def wrong_time(group):
        group["FieldData/TimeValue"][0] = 7.0

    def no_cells(group):
        group["Types"][0] = 3

    damage(wrong_type, "fixed characters")
    damage(drop_units, "mass has units")
    damage(wrong_time, "7.0 s in the file")
    damage(no_cells, "one vertex")
