# SPDX-License-Identifier: BSD-3-Clause
"""Readers of the files of Scree: snapshot series, snapshots and time histories.

All values are in SI, for files in any units (see units.py). Only h5py and numpy are needed, and they are imported when
a file is read.
"""
from __future__ import annotations

import contextlib
import csv
import os
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

from . import units as units_of
from .errors import DAMAGE, EXIT_FILE, FileProblem, decoded, modules, readable, reading, unknown

if TYPE_CHECKING:
    from .arrays import Array

Moment = tuple[float, str]                               # time [s] and file of a snapshot



IMPLAUSIBLE = 1.0e100    # no run has times and positions of this size
UNTITLED = "untitled"    # title of a deck that gives none
DIMENSIONS = ("3d", "plane_strain", "axisymmetric", "1d", "2d")


def series_file(path: str) -> str:
    """The series at a path: the file itself, the series beside its CASE_p.vtkhdf, or the only one in a folder."""
    parts = path.removesuffix(".vtkhdf") + ".hdf.series"
    if path.endswith(".vtkhdf") and os.path.isfile(parts):
        return parts
    if os.path.isdir(path):
        found = sorted(name for name in os.listdir(path) if name.endswith("_p.hdf.series"))
        if len(found) == 1:
            return os.path.join(path, found[0])
        raise FileProblem(
            f"{path}: {len(found) or 'no'} particle series (*_p.hdf.series) in this folder, "
            f"name the file{': ' if found else ''}{', '.join(found)}"
        )
    return path


def history_file(path: str) -> str:
    """The history at a path: the file itself, or the only history in a folder."""
    if os.path.isdir(path):
        found = sorted(name for name in os.listdir(path) if name.endswith("_history.csv"))
        if len(found) == 1:
            return os.path.join(path, found[0])
        raise FileProblem(f"{path}: {len(found) or 'no'} histories (*_history.csv) in this folder, "
                        f"name the file{': ' if found else ''}{', '.join(found)}")
    return path


def beside(source: str, ending: str) -> str:
    """A file of the same case as a series or a snapshot: CASE and an ending such as _view.py."""
    stem = os.path.basename(source).removesuffix(".series").removesuffix(".hdf").removesuffix("_p")
    return os.path.join(os.path.dirname(source) or ".", stem + ending)


def nearest(frames: Sequence[Moment], times: Iterable[float]) -> list[Moment]:
    """The snapshots of a series that are nearest to times [s], each once, in their order."""
    rows = {min(range(len(frames)), key=lambda row: abs(frames[row][0] - time)) for time in times}
    return [frames[row] for row in sorted(rows)]


def series(path: str, own_units: bool = False) -> list[Moment]:
    """List of (time [s], file) of a .series file, a snapshot, or a folder with one series.

    With `own_units` the times are in the unit of the files.
    """
    path = readable(series_file(path))
    if not path.endswith(".series"):
        return [(snapshot_time(path, own_units), path)]
    try:
        with open(path, encoding="utf-8") as handle:
            entries = units_of.times_in(handle.read())
    except (ArithmeticError, LookupError, RecursionError, TypeError, ValueError) as error:
        raise FileProblem(
            f"{path} is not a snapshot series: {type(error).__name__}: {error}"
        ) from error
    except OSError as error:
        raise FileProblem(f"cannot read {path}: {error.strerror}") from error
    if not all(isinstance(name, str) and abs(time) < IMPLAUSIBLE for time, name in entries):
        raise FileProblem(f"{path} is not a snapshot series: it lists no names of files with times")
    folder = os.path.dirname(os.path.abspath(path))
    frames = sorted((time, os.path.join(folder, name)) for time, name in entries)
    if not frames:
        raise FileProblem(f"{path} lists no snapshots")
    if own_units:
        return frames
    exponent = units_of.series_exponent([file for _, file in frames], open_file)
    return [(units_of.shifted(time, exponent), file) for time, file in frames]


def text(value: Any) -> Any:
    """A string from a value of HDF5: bytes, padded or not, or arrays with one element."""
    if hasattr(value, "tolist"):
        value = value.tolist()
    while isinstance(value, (list, tuple)) and len(value) == 1:
        value = value[0]
    if isinstance(value, bytes):
        value = decoded(value)
    return value.strip("\0 ") if isinstance(value, str) else value


@dataclass
class Snapshot:
    """One snapshot of particles."""

    file: str
    time: float                                          # [s]
    points: Array                                        # (n, 3) [m]
    fields: dict[str, Array] = field(default_factory=dict)           # name: (n,), (n, 3) or (n, 6)
    units: dict[str, str] = field(default_factory=dict)            # name: unit
    bodies: list[dict[str, Any]] = field(default_factory=list)           # {"name", "material", "colour"} per body
    first_body: int = 1                                  # value of the field body of bodies[0]
    materials: list[str] = field(default_factory=list)        # names, in the order of the deck
    provenance: dict[str, Any] = field(default_factory=dict)
    echo: str = ""                                       # the deck with all keys and their values, in SI

    @property
    def dimension(self) -> str:
        """Problem class, one of DIMENSIONS."""
        return str(self.provenance["dimension"])

    @property
    def symmetry(self) -> list[str]:
        """Faces that are planes of symmetry, such as ["xlo", "ylo"]."""
        value = self.provenance.get("symmetry", "")
        return value.split() if isinstance(value, str) else [str(text(face)) for face in value]

    @property
    def title(self) -> str:
        """Title of the run; the name of the case where the deck has no title."""
        title = str(self.provenance.get("title") or "")
        return str(self.provenance.get("case") or "") if title in ("", UNTITLED) else title

    def body_rows(self) -> Array:
        """Row of `bodies` of every particle; 0 where there is one body only."""
        (np,) = modules("numpy")
        rows: Array = self.fields.get("body", np.full(len(self.points), self.first_body))
        # files of other programs may count from 0 in spite of this attribute
        first = self.first_body if len(rows) == 0 or rows.min() >= self.first_body else 0
        numbers: Array = np.asarray(rows).astype(int) - first
        return numbers

    def body_name(self, row: int) -> str:
        """Name of a body of the table."""
        name = self.bodies[row].get("name", "") if 0 <= row < len(self.bodies) else ""
        return name or f"body {row + 1}"

    def need(self, *names: str) -> list[Array]:
        """The named fields; an error that names those missing in the file."""
        missing = [name for name in names if name not in self.fields]
        if missing and "radius" in self.fields:
            raise FileProblem(f"{self.file} is a cell of grains, not of particles; scree-post grains draws it")
        if missing:
            raise unknown("field", ", ".join(missing), sorted(self.fields),
                          f"{self.file}: write it with &output fields", EXIT_FILE)
        return [self.fields[name] for name in names]


@contextlib.contextmanager
def open_file(path: str) -> Iterator[Any]:
    """A file of particles or of the grid, opened for reading; damage found while it is open is a FileProblem."""
    (h5py,) = modules("h5py")
    readable(path)
    try:
        handle = h5py.File(path, "r")
    except DAMAGE as error:
        reason = (
            "still being written" if "unable to lock" in str(error) else "not HDF5, or truncated"
        )
        raise FileProblem(f"cannot open {path}: {reason}") from error
    with reading(path), handle:
        yield handle


@contextlib.contextmanager
def open_snapshot(path: str) -> Iterator[Any]:
    """A file of particles, opened for reading."""
    with open_file(path) as handle:
        if "VTKHDF/Points" not in handle:
            raise FileProblem(f"{path} is not a particle snapshot: it has no /VTKHDF/Points")
        yield handle


def _time(handle: Any, path: str, own_units: bool = False) -> float:
    time = units_of.raw_time(handle) if own_units else units_of.time_si(handle)
    if time is None:
        raise FileProblem(f"{path} has no /VTKHDF/FieldData/TimeValue")
    if not abs(time) < IMPLAUSIBLE:
        raise FileProblem(f"cannot read {path}: damaged: its time is {time:g}")
    return time


def snapshot_time(path: str, own_units: bool = False) -> float:
    """Time of a file of particles or of the grid [s], or in the unit of the file."""
    with open_file(path) as handle:
        if "VTKHDF" not in handle:
            raise FileProblem(f"{path} is not a particle snapshot: it has no /VTKHDF/Points")
        return _time(handle, path, own_units)


def _bodies(handle: Any) -> tuple[list[dict[str, Any]], int]:
    """Table of bodies: a group with the datasets name, material, colour."""
    if "bodies" not in handle or not hasattr(handle["bodies"], "keys"):
        return [], 1
    group = handle["bodies"]
    columns = {key: [text(entry) for entry in group[key][...].ravel().tolist()]
               for key in ("name", "material", "colour") if key in group}
    count = len(columns.get("name", []))
    table = [{key: column[row] for key, column in columns.items() if row < len(column)}
             for row in range(count)]
    return table, int(group.attrs.get("first_index", 1))


def header(handle: Any, file: str, own_units: bool = False) -> Snapshot:
    """The data of an open file of a snapshot except positions and fields."""
    snap = Snapshot(file=file, time=_time(handle, file, own_units), points=modules("numpy")[0].zeros((0, 3)))
    snap.units["time"] = units_of.raw_time_unit(handle) if own_units else "s"
    snap.bodies, snap.first_body = _bodies(handle)
    if "bodies/material_name" in handle:
        snap.materials = [str(text(name)) for name in handle["bodies/material_name"][...]]
    if "provenance" in handle:
        record = handle["provenance"]
        snap.provenance = {k: text(v) for k, v in record.attrs.items()}
        if "deck_echo" in record:
            snap.echo = decoded(bytes(record["deck_echo"][...]))
    snap.provenance.setdefault("dimension", "3d")
    if snap.dimension not in DIMENSIONS:
        raise FileProblem(f"{file}: unknown dimension '{snap.dimension}' in /provenance")
    return snap


def coordinates(points: Array, file: str) -> Array:
    """Positions of particles (n, 3), refused if they cannot be those of a run."""
    (np,) = modules("numpy")
    points = points.astype("f8")
    if points.ndim != 2 or points.shape[1] != 3 or not (np.abs(points) < IMPLAUSIBLE).all():
        raise FileProblem(f"cannot read {file}: damaged: its particles have no positions")
    return points


def snapshot(file: str, names: Any = None, own_units: bool = False) -> Snapshot:
    """Read a snapshot: points, fields (all, or those named), units, bodies, provenance.

    With `own_units` all numbers are in the units of the file, for comparisons with other readers.
    """
    def numbers(data: Any) -> Array:
        values: Array = data[...] if own_units else units_of.data_si(data)
        return values

    with open_snapshot(file) as handle:
        snap = header(handle, file, own_units)
        snap.points = coordinates(numbers(handle["VTKHDF/Points"]), file)
        data = handle.get("VTKHDF/PointData", {})
        for name in data:
            if names is None or name in names:
                snap.fields[name] = numbers(data[name])
                snap.units[name] = units_of.data_unit(data[name])
        wrong = [name for name, values in snap.fields.items() if len(values) != len(snap.points)]
        if wrong:
            raise FileProblem(f"{file}: field {wrong[0]} has {len(snap.fields[wrong[0]])} rows "
                              f"for {len(snap.points)} particles")
    return snap


def is_grid(file: str) -> bool:
    """True for a file of fields on the grid."""
    with open_file(file) as handle:
        kind = handle["VTKHDF"].attrs.get("Type", b"") if "VTKHDF" in handle else b""
        return bool((kind if isinstance(kind, bytes) else kind.encode()).rstrip(b"\0 ") == b"ImageData")


class History(dict[str, "Array"]):
    """Columns of a table by name, in SI; `units` holds the units, `order` the names."""

    def __init__(self) -> None:
        super().__init__()
        self.units: dict[str, str] = {}
        self.order: list[str] = []


def history(file: str, may_be_empty: bool = False) -> History:
    """Read CASE_history.csv or another table of a run, in SI.

    An incomplete last line, which is still being written, is ignored. A table without rows, or without its first line,
    is that of a run that has just begun, or was killed then.
    """
    (numpy,) = modules("numpy")
    try:
        with open(readable(file), newline="", encoding="utf-8") as handle:
            rows = [row for row in csv.reader(handle) if row and not row[0].startswith("#")]
    except (ValueError, csv.Error) as error:
        raise FileProblem(
            f"{file} is not a history: not a text file of comma separated values"
        ) from error
    if not rows or not any(cell.strip().startswith("time") for cell in rows[0]):
        if may_be_empty and len(rows) < 2:
            return History()
        raise FileProblem(f"{file} is not a history: its first line names no column 'time [s]'")
    head, body = rows[0], rows[1:]
    if body and len(body[-1]) != len(head):
        body.pop()
    try:
        values = numpy.array([[float(cell) for cell in row] for row in body])
    except ValueError as error:
        raise FileProblem(f"{file}: {error}") from error
    if values.ndim != 2 or values.shape[1] != len(head):
        if len(values) > 0 or not may_be_empty:
            raise FileProblem(f"{file} holds no complete line below its header")
        values = values.reshape(0, len(head))
    table = History()
    for column, title in enumerate(head):
        name, _, unit = title.strip().partition("[")
        name = name.strip()
        unit, exponent = units_of.si_unit(unit.rstrip("] ") or "1", name)
        table.order.append(name)
        table[name] = units_of.shifted(values[:, column], exponent)
        table.units[name] = unit
    return table
