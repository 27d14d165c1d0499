# SPDX-License-Identifier: BSD-3-Clause
"""Checks that VTK, and so ParaView, reads the files of a run as they were written.

Every snapshot, and the .vtkhdf index if it exists, is opened with h5py and with the VTKHDF reader
of VTK: the number of points and cells, the bounds, the time, and the components and mean of every
field must agree. For grid files every number must agree. Numbers are compared in the units of the
files. Exit code 77 means that the package vtk is missing and that all checks with h5py alone
passed.
"""
from __future__ import annotations

import argparse
import os
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

from scree.errors import EXIT_DIFFERENT, modules
from scree.files import is_grid, open_file, series, series_file, snapshot

if TYPE_CHECKING:
    from scree.arrays import Array
    from scree.files import Moment, Snapshot

SUMMARY = "whether VTK, and so ParaView, reads the files as they were written"
EXAMPLES = ("check out/two_discs",)
EXIT_NO_VTK = 77         # exit code of a skipped test for CTest
MEAN = 1.0e-5            # single precision in the file, summed in double
EDGE = 1.0e-6            # single precision of positions in a reader

# number of points, bounds along x, y, z, and by field: components, means and magnitudes
Summary = tuple[int, "list[tuple[float, float]] | None", dict[str, tuple[int, Any, Any]]]


class Report:
    """Counts agreements and prints differences."""

    def __init__(self, loud: bool) -> None:
        self.loud, self.agree, self.differ = loud, 0, 0

    def check(self, good: Any, sentence: str) -> None:
        """Record one comparison."""
        self.agree, self.differ = self.agree + bool(good), self.differ + (not good)
        if not good:
            print(f"DIFFERENT {sentence}")
        elif self.loud:
            print(f"same      {sentence}")


def summary(points: Array, fields: Mapping[str, Array]) -> Summary:
    """The compared values: number of points, bounds, components and scaled mean of every
    field."""
    (np,) = modules("numpy")
    bounds = (
        [(float(points[:, k].min()), float(points[:, k].max())) for k in range(3)]
        if len(points)
        else None
    )
    means = {}
    for name, values in fields.items():
        values = (
            np.asarray(values, "f8").reshape(len(values), -1) if len(values) else np.zeros((0, 1))
        )
        size = np.abs(values).max(axis=0) if len(values) else np.zeros(1)
        means[name] = (values.shape[1], values.mean(axis=0) if len(values) else size, size)
    return len(points), bounds, means


def from_vtk(data: Any) -> tuple[Summary, int]:
    """The same summary of a VTK data set, and its number of cells."""
    (support, np) = modules("vtkmodules.util.numpy_support", "numpy")
    if data is None or data.GetNumberOfPoints() == 0:
        return (0, None, {}), 0
    points = support.vtk_to_numpy(data.GetPoints().GetData())
    found = data.GetPointData()
    fields = {found.GetArrayName(k): support.vtk_to_numpy(found.GetArray(k))
              for k in range(found.GetNumberOfArrays()) if found.GetArray(k) is not None}
    return summary(np.asarray(points, "f8"), fields), data.GetNumberOfCells()


def compare(report: Report, label: str, wanted: Summary, found: Summary, cells: int) -> None:
    """Compare two summaries."""
    (np,) = modules("numpy")
    report.check(found[0] == wanted[0], f"{label}: {found[0]} points, {wanted[0]} written")
    report.check(cells == wanted[0], f"{label}: {cells} cells, {wanted[0]} written")
    if wanted[1] is None or found[1] is None or found[0] != wanted[0]:
        return
    span = max(max(abs(edge) for edge in pair) for pair in wanted[1]) or 1.0
    off = max(abs(a - b) for one, two in zip(wanted[1], found[1]) for a, b in zip(one, two))
    report.check(off <= EDGE * span, f"{label}: bounds differ by {off:.1e}")
    for name, (parts, mean, size) in sorted(wanted[2].items()):
        if name not in found[2]:
            report.check(False, f"{label}: field {name} is not seen")
            continue
        seen_parts, seen_mean, _ = found[2][name]
        report.check(
            seen_parts == parts, f"{label}: {name} has {seen_parts} components, {parts} written"
        )
        if seen_parts == parts:
            good = np.abs(seen_mean - mean) <= MEAN * np.maximum(size, 1.0e-300)
            report.check(good.all() or ((size == 0.0).all() and (seen_mean == 0.0).all()),
                         f"{label}: mean of {name} {seen_mean.tolist()}, {mean.tolist()} written")


def check_structure(report: Report, file: str, snap: Snapshot) -> None:
    """Check the layout of a file apart from its numbers: attributes, topology, units, names."""
    (np,) = modules("numpy")
    name = os.path.basename(file)
    with open_file(file) as handle:
        group = handle["VTKHDF"]
        kind = group.attrs.get("Type", b"")
        kind = kind.encode() if isinstance(kind, str) else bytes(kind)
        report.check(kind == b"UnstructuredGrid", f"{name}: Type is {kind!r}")
        stored = group.attrs.get_id("Type").get_type() if "Type" in group.attrs else None
        report.check(
            stored is not None and not stored.is_variable_str() and stored.get_size() == 16,
            f"{name}: Type is a string of 16 fixed characters",
        )
        report.check(
            list(np.ravel(group.attrs.get("Version", []))) == [1, 0], f"{name}: Version is 1.0"
        )
        count = len(snap.points)
        for key in ("NumberOfPoints", "NumberOfCells", "NumberOfConnectivityIds"):
            value = group[key][...].tolist() if key in group else None
            report.check(value == [count], f"{name}: {key} is {value}")
        shapes = {"Connectivity": np.arange(count), "Offsets": np.arange(count + 1),
                  "Types": np.ones(count)}
        for key, values in shapes.items():
            report.check(key in group and np.array_equal(group[key][...], values),
                         f"{name}: {key} says one vertex per particle")
        for field in group.get("PointData", {}):
            report.check("units" in group["PointData"][field].attrs, f"{name}: {field} has units")
    report.check("mass" in snap.fields, f"{name}: there is a field mass")
    report.check(snap.provenance.get("case") is not None, f"{name}: /provenance names the case")


def from_hdf(vtk: Any, file: str, step: int | None = None) -> Any:
    """Read a VTKHDF file with VTK."""
    reader = vtk.vtkHDFReader()
    if not reader.CanReadFile(file):
        return None
    reader.SetFileName(file)
    reader.UpdateInformation()
    if step is not None:
        reader.SetStep(step)
    reader.Update()
    return merged(vtk, reader.GetOutputDataObject(0))


def merged(vtk: Any, data: Any) -> Any:
    """One unstructured grid from the result of a reader."""
    if data is None or data.IsA("vtkUnstructuredGrid"):
        return data
    join = vtk.vtkAppendFilter()
    if data.IsA("vtkCompositeDataSet"):
        walk = data.NewIterator()
        while not walk.IsDoneWithTraversal():
            join.AddInputData(walk.GetCurrentDataObject())
            walk.GoToNextItem()
    else:
        join.AddInputData(data)
    join.Update()
    return join.GetOutput()


def check_grid(report: Report, vtk: Any, file: str, time: float) -> None:
    """One file of fields on the grid: extents, edges, and the mean of each field."""
    (np, support) = modules("numpy", "vtkmodules.util.numpy_support")
    name = os.path.basename(file)
    with open_file(file) as handle:
        group = handle["VTKHDF"]
        extent = [int(number) for number in group.attrs["WholeExtent"]]
        origin, spacing = group.attrs["Origin"][...], group.attrs["Spacing"][...]
        fields = {key: data[...] for key, data in group["PointData"].items()}
        units = all("units" in data.attrs for data in group["PointData"].values())
        report.check(abs(group.attrs["Time"] - time) <= 1.0e-12 * abs(time), f"{name}: the time of the series")
    report.check(units, f"{name}: all fields have units")
    report.check(all(extent[2 * k + 1] > extent[2 * k] for k in range(3)),
                 f"{name}: has a thickness")
    for key, values in fields.items():
        report.check(values.shape[:3] == tuple(extent[2 * k + 1] + 1 for k in (2, 1, 0)),
                     f"{name}: {key} has the extents of the image")
    reader = vtk.vtkHDFReader()
    report.check(reader.CanReadFile(file), f"{name}: opens in VTK")
    reader.SetFileName(file)
    reader.Update()
    data = reader.GetOutputDataObject(0)
    if not data.IsA("vtkImageData"):
        report.check(False, f"{name}: VTK makes a {data.GetClassName()} of it")
        return
    report.check(list(data.GetExtent()) == extent, f"{name}: extents {data.GetExtent()}")
    report.check(np.allclose(data.GetOrigin(), origin) and np.allclose(data.GetSpacing(), spacing),
                 f"{name}: origin {data.GetOrigin()}, spacing {data.GetSpacing()}")
    found = data.GetPointData()
    seen = {found.GetArrayName(k): support.vtk_to_numpy(found.GetArray(k))
            for k in range(found.GetNumberOfArrays())}
    report.check(sorted(seen) == sorted(fields), f"{name}: fields {sorted(seen)}")
    for key, values in fields.items():
        flat = values.reshape(-1) if values.ndim == 3 else values.reshape(-1, values.shape[3])
        report.check(key in seen and np.array_equal(seen[key], flat),
                     f"{name}: each number of {key}")


def check_grids(report: Report, vtk: Any, steps: Sequence[Moment]) -> None:
    """All files of a series of grids. Without VTK there is no second reader to compare with."""
    for time, file in steps:
        if vtk:
            check_grid(report, vtk, file, time)
    print(f"{len(steps)} grids: {report.agree} comparisons agree, {report.differ} differ"
          + ("" if vtk else "; VTK not asked, the package vtk is missing"))


def load_vtk() -> Any:
    """The vtk package without its messages, or None."""
    try:
        import vtk
    except ImportError:
        return None
    vtk.vtkObject.GlobalWarningDisplayOff()
    return vtk


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """The options."""
    add = parser.add_argument
    add("series", metavar="SERIES",
        help="CASE_p.hdf.series or CASE_g.hdf.series, a snapshot, or out/CASE")
    add("-v", "--verbose", action="store_true", help="print comparisons that agree too")


def check_snapshots(report: Report, vtk: Any, steps: Sequence[Moment]) -> list[tuple[float, Summary]]:
    """Every snapshot against itself and the series; the result is the content of the files."""
    wanted = []
    for time, file in steps:
        snap = snapshot(file, own_units=True)
        name = os.path.basename(file)
        report.check(abs(snap.time - time) <= 1.0e-12 * max(abs(time), 1.0e-300),
                     f"{name}: time {snap.time!r} {snap.units['time']} in the file, {time!r} in the series")
        check_structure(report, file, snap)
        wanted.append((time, summary(snap.points, snap.fields)))
        if vtk:
            data = from_hdf(vtk, file)
            report.check(data is not None, f"{name}: opens in VTK")
            if data is not None:
                compare(report, name, wanted[-1][1], *from_vtk(data))
    return wanted


def check_index(report: Report, vtk: Any, index: str, wanted: Sequence[tuple[float, Summary]]) -> None:
    """The index file with links to the snapshots, if there is one; VTK 9.2 does not support files
    with several times."""
    name = os.path.basename(index)
    if not os.path.exists(index):
        return
    if not hasattr(vtk.vtkHDFReader, "SetStep"):
        print(f"{name}: left out, this VTK is older than 9.3 and reads one time a file")
        return
    for step, (time, parts) in enumerate(wanted):
        compare(report, f"{name} at {time:.4g}", parts, *from_vtk(from_hdf(vtk, index, step)))


def run(arguments: argparse.Namespace) -> int:
    """Check a series and its index."""
    source = series_file(arguments.series)
    report, vtk = Report(arguments.verbose), load_vtk()
    steps = series(source, own_units=True)
    if is_grid(steps[0][1]):
        check_grids(report, vtk, steps)
        return EXIT_DIFFERENT if report.differ else 0 if vtk else EXIT_NO_VTK
    wanted = check_snapshots(report, vtk, steps)
    stem = source.removesuffix(".hdf.series")
    if vtk and stem != source:
        check_index(report, vtk, stem + ".vtkhdf", wanted)
    print(f"{len(wanted)} snapshots: {report.agree} comparisons agree, {report.differ} differ"
          + ("" if vtk else "; VTK not asked, the package vtk is missing"))
    if report.differ:
        return EXIT_DIFFERENT
    return 0 if vtk else EXIT_NO_VTK
