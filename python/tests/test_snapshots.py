# SPDX-License-Identifier: BSD-3-Clause
"""Snapshots: fields, lines, and conversions to the data types of other packages."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import scree
from scree import files, units


def test_series(run: scree.Run) -> None:
    """Would catch snapshots in a wrong order, times in other units, and a selected snapshot that is not the nearest."""
    snapshots = run.snapshots
    assert snapshots.times[0] == 0.0 and snapshots.times[-1] == pytest.approx(1e-6)
    assert [snap.time for snap in snapshots] == pytest.approx(list(snapshots.times))
    assert snapshots.near(0.49e-6).time == snapshots[2].time == snapshots[1:3][1].time
    assert snapshots.near(1.0).time == snapshots[-1].time
    assert set(run.series) == {"p", "fast_p"}


def test_fields(run: scree.Run) -> None:
    """Would catch fields in the units of the file, components in a wrong order, and bodies that are confused."""
    first, last = run.snapshots[0], run.snapshots[-1]
    assert (last["mass"] @ last["velocity"])[0] == pytest.approx(run.history["momentum_x"].iloc[-1], rel=1e-3)
    assert np.array_equal(last["stress_xz"], last["stress"][:, 5])
    pressure = -(last["stress_xx"] + last["stress_yy"] + last["stress_zz"]) / 3.0
    assert np.abs(last["pressure"]).max() > 1e6
    assert pressure == pytest.approx(last["pressure"], abs=1e-6 * np.abs(last["pressure"]).max())
    left = first.body("left")
    assert left.sum() == len(first) // 2 and np.all(first["velocity_x"][left] == pytest.approx(1000.0))
    assert np.all(first["x"][left] < 5.0e-3) and np.all(first["velocity"][~left] == 0.0)
    assert first.unit("stress_xx") == first.units["pressure"] == "Pa" and first.unit("z") == "m"
    assert (first.dimension, first.bodies, first.materials) == ("plane_strain", ["left", "right"], ["copper"])
    assert first.deck["grid"]["dx"] == pytest.approx(1e-3)
    assert first.size() == pytest.approx(np.full(len(first), 0.5e-3))


def test_lazy(run: scree.Run, monkeypatch: pytest.MonkeyPatch) -> None:
    """Would catch a snapshot that reads the whole file to return one field, or reads a field twice."""
    read: list[str] = []
    whole = units.data_si

    def noted(data: object) -> object:
        read.append(str(getattr(data, "name", "")))
        return whole(data)

    snap = run.snapshots[-1]
    monkeypatch.setattr(units, "data_si", noted)
    assert len(snap) > 0 and "velocity_x" in snap and "torsion" not in snap and snap.time > 0.0 and not read
    _ = snap["velocity_x"], snap["velocity"], snap["velocity_z"]
    assert read == ["/VTKHDF/PointData/velocity"]


def test_same_as_whole_reader(run: scree.Run) -> None:
    """Would catch a lazy reader that differs from the one that the command scree-post uses."""
    snap, whole = run.snapshots[2], files.snapshot(run.snapshots[2].file)
    assert snap.names == list(whole.fields) and snap.units == {name: whole.units[name] for name in snap.names}
    assert np.array_equal(snap.points, whole.points)
    for name in snap.names:
        assert np.array_equal(snap[name], whole.fields[name])


def test_unknown_field(run: scree.Run) -> None:
    """Would catch an error message without the list of existing fields."""
    with pytest.raises(KeyError, match="did you mean 'velocity'"):
        _ = run.snapshots[0]["velocty"]
    with pytest.raises(KeyError, match="no body 'lift'; did you mean 'left'"):
        run.snapshots[0].body("lift")


def test_damaged_file(run: scree.Run, tmp_path: Path) -> None:
    """Would catch a traceback of h5py for a truncated file."""
    path = tmp_path / "cut.hdf"
    path.write_bytes(Path(run.snapshots[0].file).read_bytes()[:3000])
    with pytest.raises(scree.FileProblem, match=r"cut\.hdf"):
        scree.Snapshot(str(path))


def test_pandas(run: scree.Run) -> None:
    """Would catch a column with the values or the unit of another one."""
    snap = run.snapshots[-1]
    table = snap.to_pandas()
    assert len(table) == len(snap) and np.array_equal(table["stress_xz"], snap["stress"][:, 5])
    assert np.array_equal(table[["x", "y", "z"]].to_numpy(), snap.points)
    assert table.attrs["units"]["stress_xz"] == "Pa" and table.attrs["units"]["x"] == "m"
    assert set(table.columns) == set(table.attrs["units"])
    assert list(snap.to_pandas(["mass"]).columns) == ["x", "y", "z", "mass"]


def test_xarray(run: scree.Run) -> None:
    """Would catch components under the wrong names."""
    pytest.importorskip("xarray")
    snap = run.snapshots[-1]
    data = snap.to_xarray()
    assert np.array_equal(data["stress"].sel(component="xz"), snap["stress_xz"])
    assert np.array_equal(data["velocity"].sel(axis="z"), snap["velocity_z"])
    assert np.array_equal(data["position"].sel(axis="x"), snap["x"])
    assert data["stress"].attrs["units"] == "Pa" and float(data["time"]) == snap.time


def test_pyvista(run: scree.Run) -> None:
    """Would catch points without their fields."""
    pytest.importorskip("pyvista")
    snap = run.snapshots[-1]
    cloud = snap.to_pyvista(["mass", "velocity"])
    assert np.array_equal(cloud.points, snap.points) and set(cloud.point_data) == {"mass", "velocity"}
    assert np.array_equal(cloud.point_data["velocity"], snap["velocity"])


def test_missing_package(run: scree.Run, monkeypatch: pytest.MonkeyPatch) -> None:
    """Would catch a traceback without advice which package to install."""
    monkeypatch.setattr("importlib.util.find_spec", lambda name: None)
    with pytest.raises(ImportError, match="pip install xarray"):
        run.snapshots[0].to_xarray()
    with pytest.raises(ImportError, match="pip install pyvista"):
        run.snapshots[0].to_pyvista()


def test_along(run: scree.Run) -> None:
    """Would catch particles beside the line, beyond its ends, or in a wrong order: compared with an explicit search."""
    snap = run.snapshots[-1]
    start, end = (3e-3, 1e-3, 3.8e-3), (8e-3, 1e-3, 1.2e-3)
    table = snap.along(start, end, ["pressure", "velocity"], width=0.4e-3)
    direction = np.subtract(end, start) / np.linalg.norm(np.subtract(end, start))
    found = []
    for row, point in enumerate(snap.points):
        offset = (point - start) * (1.0, 0.0, 1.0)
        distance = offset @ direction
        if 0.0 <= distance <= np.linalg.norm(np.subtract(end, start)):
            beside = np.linalg.norm(offset - distance * direction)
            if beside <= 0.4e-3:
                found.append((distance, row))
    assert len(found) > 5 and len(table) == len(found)
    found.sort()
    assert table["distance"].to_numpy() == pytest.approx([distance for distance, _ in found])
    assert np.array_equal(table["pressure"], snap["pressure"][[row for _, row in found]])
    assert table.attrs["units"] == {"distance": "m", "pressure": "Pa", "velocity_x": "m/s", "velocity_y": "m/s",
                                    "velocity_z": "m/s"}
    with pytest.raises(ValueError, match="two different points"):
        snap.along(start, start, "pressure")


def test_along_in_one_dimension(bar: scree.Run) -> None:
    """Would catch a line in one dimension that requires correct values of y and z."""
    snap = bar.snapshots[-1]
    table = snap.along((0, 0, 0), (0.02, 0, 0), "velocity_x")
    assert len(table) == len(snap) == 36 and np.all(np.diff(table["distance"]) > 0.0)
    assert snap.size()[-1] == pytest.approx(0.5e-3, rel=1e-6)
