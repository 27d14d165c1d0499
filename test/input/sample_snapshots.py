# SPDX-License-Identifier: BSD-3-Clause
"""Snapshots of problems with analytical solutions, in the file layout of the program."""
import json
import os

import h5py
import numpy as np

RADIUS = 5.0e-3          # [m]
DENSITY = 2700.0         # [kg/m3]
CENTRE = 3.0e-3          # of the sphere on the axis [m]


def put(group, name, values, unit=None):
    """A dataset as the program writes it."""
    packed = {"chunks": (min(len(values), 65536),) + values.shape[1:], "compression": "gzip",
              "compression_opts": 1, "shuffle": True} if len(values) else {}
    data = group.create_dataset(name, data=values, **packed)
    if unit:
        data.attrs["units"] = np.bytes_(unit)


def write(path, time, points, fields, **provenance):
    """Write a snapshot in the file layout of the program; fields is {name: (values, unit)}."""
    count = len(points)
    with h5py.File(path, "w", libver=("earliest", "v110")) as handle:
        group = handle.create_group("VTKHDF")
        group.attrs["Version"] = np.array([1, 0], "i4")
        group.attrs.create(
            "Type", np.bytes_("UnstructuredGrid"), dtype=h5py.string_dtype("ascii", 16)
        )
        for key in ("NumberOfPoints", "NumberOfCells", "NumberOfConnectivityIds"):
            group[key] = np.array([count], "i8")
        put(group, "Points", points, "m")
        put(group, "Connectivity", np.arange(count, dtype="i8"))
        put(group, "Offsets", np.arange(count + 1, dtype="i8"))
        put(group, "Types", np.full(count, 1, "u1"))
        data = group.create_group("PointData")
        for name, (values, unit) in fields.items():
            put(data, name, values, unit)
        group.create_group("FieldData")["TimeValue"] = np.array([time])
        bodies = handle.create_group("bodies")
        bodies["name"] = np.array([b"ball  ", b"sheet "])
        bodies["material"] = np.array([b"al", b"al"])
        record = handle.create_group("provenance")
        for key, value in {"case": "ball", "title": "A ball", **provenance}.items():
            record.attrs[key] = np.bytes_(value) if isinstance(value, str) else value
    return path


def matter(mass, volume, velocity):
    """The fields that every snapshot of this module has."""
    count = len(mass)
    return {
        "mass": (mass, "kg"),
        "volume": (volume, "m3"),
        "velocity": (velocity.astype("f4"), "m/s"),
        "body": (np.ones(count, "i4"), "1"),
        "failed": (np.arange(count) % 2 * np.ones(count, "f4"), "1"),
        "stress": (np.outer(mass, np.arange(6.0)).astype("f4"), "Pa"),
        "identity": (np.arange(count), "1"),
    }


def ball(path, dimension, cells, grown=1.0, inner=0.0, speed=1000.0, time=1.0e-6):
    """A ball (or shell) of particles on a lattice, expanded by a factor since the start."""
    step = RADIUS / cells
    line = (np.arange(cells) + 0.5) * step
    axial = (np.arange(-cells, cells) + 0.5) * step
    if dimension == "axisymmetric":
        r, z = (grid.ravel() for grid in np.meshgrid(line, axial))
        points, volume = np.stack([r, 0.0 * r, z], axis=1), 2.0 * np.pi * r * step ** 2
    else:
        points = np.stack([grid.ravel() for grid in np.meshgrid(line, line, axial)], axis=1)
        volume = np.full(len(points), step ** 3)
    radius = np.sqrt((points ** 2).sum(axis=1))
    keep = (radius < RADIUS) & (radius >= inner)
    points, volume = points[keep] * grown, volume[keep]
    points[:, 2] += CENTRE
    velocity = np.zeros_like(points)
    velocity[:, 2] = speed
    return write(path, time, points, matter(DENSITY * volume, volume * grown ** 3, velocity),
                 dimension=dimension, symmetry="xlo" if dimension == "axisymmetric" else "xlo ylo")


def make_series(work, dimension="axisymmetric", cells=16, name="ball"):
    """A series of four snapshots, the first without particles."""
    folder = f"{work}/{name}"
    os.makedirs(folder, exist_ok=True)
    entries = []
    for step in range(4):
        time, file = step * 1.0e-6, f"{name}_p_{step:06d}.hdf"
        if step == 0:
            none = np.zeros((0, 3))
            write(f"{folder}/{file}", time, none, matter(np.zeros(0), np.zeros(0), none),
                  dimension=dimension, symmetry="")
        else:
            ball(f"{folder}/{file}", dimension, cells + step, grown=step, time=time)
        entries.append({"name": file, "time": time})
    with open(f"{folder}/{name}_p.hdf.series", "w", encoding="ascii") as handle:
        json.dump({"file-series-version": "1.0", "files": entries}, handle)
    return f"{folder}/{name}_p.hdf.series", entries
