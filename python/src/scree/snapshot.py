# SPDX-License-Identifier: BSD-3-Clause
"""Snapshots of particles: fields are read from the file at first use."""
from __future__ import annotations

import importlib.util
from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING, Any, overload

import numpy as np

from . import echo, files
from . import units as units_of
from .drawing.shape import widths
from .errors import FileProblem, nearest, reading

if TYPE_CHECKING:
    import pandas
    import pyvista
    import xarray
    from numpy.typing import NDArray

# Names of the components of a field by their number.
COMPONENTS: dict[int, tuple[str, ...]] = {
    3: ("x", "y", "z"),
    6: ("xx", "yy", "zz", "xy", "yz", "xz"),
    9: ("xx", "yx", "zx", "xy", "yy", "zy", "xz", "yz", "zz"),
}
AXES = {"x": 0, "y": 1, "z": 2}


def component_names(name: str, width: int) -> list[str]:
    """Names such as velocity_x and stress_xx of the components of a field."""
    return [f"{name}_{word}" for word in COMPONENTS.get(width, tuple(map(str, range(width))))]


def components(name: str, values: NDArray[Any]) -> dict[str, NDArray[Any]]:
    """Columns of a field by the names of its components; of a scalar, the field itself."""
    if values.ndim == 1:
        return {name: values}
    names = component_names(name, values.shape[1])
    return {component: values[:, place] for place, component in enumerate(names)}


def need_package(name: str) -> None:
    """Raise an error that says how to install a package that is missing."""
    if importlib.util.find_spec(name) is None:
        raise ImportError(f"the package {name} is not installed: pip install {name}", name=name)


class Snapshot:
    """Particles at one time, in SI.

        snap.time, snap.points              # [s]; (n, 3) [m]: x, y, z, in axisymmetry radius, 0, height
        snap["velocity"]                    # (n, 3) [m/s]; snap["velocity_z"] and snap["stress_xx"] are components
        snap["x"]                           # a coordinate
        snap.names, snap.units["pressure"]  # fields of the file and their units
        snap.bodies, snap.dimension, snap.provenance, snap.deck

    A field is read at first use and kept with the snapshot.
    """

    def __init__(self, file: str) -> None:
        self.file = str(file)
        self._read: dict[str, NDArray[Any]] = {}
        with files.open_snapshot(self.file) as handle:
            self._header = files.header(handle, self.file)
            data = handle.get("VTKHDF/PointData", {})
            self.units = {name: units_of.data_unit(data[name]) for name in data}
            self._widths = {name: int(data[name].shape[1]) for name in data if len(data[name].shape) > 1}
            self._count = int(handle["VTKHDF/Points"].shape[0])

    def __repr__(self) -> str:
        return f"<scree.Snapshot of {len(self)} particles at {self.time:g} s: {', '.join(self.names)}>"

    def __len__(self) -> int:
        return self._count

    @property
    def time(self) -> float:
        """Time [s]."""
        return self._header.time

    @property
    def names(self) -> list[str]:
        """Names of the fields in the file."""
        return list(self.units)

    @property
    def points(self) -> NDArray[np.float64]:
        """Positions of the particles (n, 3) [m]."""
        return self._values("Points").astype(np.float64, copy=False)

    @property
    def bodies(self) -> list[str]:
        """Names of the bodies, in the order of the deck."""
        return [str(entry.get("name", "")) for entry in self._header.bodies]

    @property
    def materials(self) -> list[str]:
        """Names of the materials, in the order of the deck."""
        return self._header.materials

    @property
    def dimension(self) -> str:
        """Problem class: 3d, plane_strain, axisymmetric or 1d."""
        return self._header.dimension

    @property
    def provenance(self) -> dict[str, Any]:
        """Version, commit, step, time steps and more."""
        return self._header.provenance

    @property
    def deck(self) -> Any:
        """The deck with all keys and their values, in SI, as a namelist of f90nml."""
        with reading(self.file):
            return echo.namelist(self._header.echo)

    def body(self, name: str) -> NDArray[np.bool_]:
        """Mask of the particles of a body."""
        if name not in self.bodies:
            raise KeyError(f"no body '{name}'{nearest(name, self.bodies)}")
        if len(self.bodies) == 1:
            return np.ones(len(self), dtype=bool)
        return np.asarray(self["body"] == self.bodies.index(name) + self._header.first_body)

    def __contains__(self, name: object) -> bool:
        return name in self.units or name in AXES or (isinstance(name, str) and self._whole(name) is not None)

    def __getitem__(self, name: str) -> NDArray[Any]:
        if name in self.units:
            return self._values(name)
        if name in AXES:
            return self.points[:, AXES[name]]
        whole = self._whole(name)
        if whole is None:
            raise KeyError(f"{self.file} has no field '{name}'{nearest(name, self.names)}; "
                           "choose what is written with &output fields")
        return components(whole, self._values(whole))[name]

    def unit(self, name: str) -> str:
        """Unit of a field, a component or a coordinate."""
        return "m" if name in AXES else self.units[name if name in self.units else self._whole(name) or name]

    def _whole(self, name: str) -> str | None:
        """The field to which a component such as stress_xx belongs."""
        base = name.rpartition("_")[0]
        return base if name in component_names(base, self._widths.get(base, 0)) else None

    def _values(self, name: str) -> NDArray[Any]:
        if name not in self._read:
            place = "VTKHDF/Points" if name == "Points" else f"VTKHDF/PointData/{name}"
            with files.open_snapshot(self.file) as handle:
                values = np.asarray(units_of.data_si(handle[place]))
                if name == "Points":
                    values = files.coordinates(values, self.file)
                if len(values) != len(self):
                    raise FileProblem(f"{self.file}: field {name} has {len(values)} rows for {len(self)} particles")
            self._read[name] = values
        return self._read[name]

    def size(self) -> NDArray[np.float64]:
        """Current width of each particle in the plane of the model [m], from its volume, or its mass and density."""
        if "volume" not in self.names and {"mass", "density"} <= {*self.names}:
            volume = self["mass"].astype(np.float64) / np.maximum(self["density"].astype(np.float64), 1.0e-300)
        else:
            volume = self["volume"].astype(np.float64)
        if self.dimension == "3d":
            return widths("3d", volume, self["x"], lambda axis: 1.0)
        grid = self.deck["grid"]
        return widths(self.dimension, volume, self["x"], lambda axis: float(grid["hi"][axis] - grid["lo"][axis]))

    def along(self, start: Sequence[float], end: Sequence[float], names: str | Sequence[str],
              width: float | None = None) -> pandas.DataFrame:
        """Fields of the particles near a line from `start` to `end` (x, y, z) [m].

        The result has a row per particle, sorted by the column `distance` from `start` [m], and a column for each of
        `names`, in SI. `width` [m] is the greatest distance of a particle from the line: by default the width of a
        particle. In one dimension all particles between the ends are near.
        """
        import pandas
        begin, finish = np.asarray(start, dtype=np.float64), np.asarray(end, dtype=np.float64)
        length = float(np.linalg.norm(finish - begin))
        if begin.shape != (3,) or finish.shape != (3,) or not length > 0.0:
            raise ValueError("start and end must be two different points x, y, z")
        axes = {"3d": [0, 1, 2], "1d": [0]}.get(self.dimension, [0, 2])
        offset = (self.points - begin)[:, axes]
        direction = ((finish - begin) / length)[axes]
        distance = offset @ direction
        away = np.linalg.norm(offset - distance[:, None] * direction, axis=1)
        near = (distance >= 0.0) & (distance <= length) & (away <= (self.size() if width is None else width))
        words = [names] if isinstance(names, str) else list(names)
        columns = {"distance": distance[near]}
        for name in words:
            columns |= components(name, self[name][near])
        table: pandas.DataFrame = pandas.DataFrame(columns).sort_values("distance", kind="stable", ignore_index=True)
        table.attrs["units"] = {"distance": "m", **{
            column: self.unit(name) for name in words for column in components(name, self[name][:1])}}
        table.attrs["time"] = self.time
        return table

    def to_pandas(self, names: Sequence[str] | None = None) -> pandas.DataFrame:
        """Coordinates and fields (all, or those named) as columns; units in `attrs["units"]`."""
        import pandas
        columns, units = components("", self.points), dict.fromkeys("xyz", "m")
        columns = {name.lstrip("_"): values for name, values in columns.items()}
        for name in self.names if names is None else names:
            parts = components(name, self[name])
            columns |= parts
            units |= dict.fromkeys(parts, self.unit(name))
        table = pandas.DataFrame(columns)
        table.attrs.update(units=units, time=self.time)
        return table

    def to_xarray(self, names: Sequence[str] | None = None) -> xarray.Dataset:
        """Fields over the dimension `particle`; vectors and tensors have a second dimension for their components."""
        need_package("xarray")
        import xarray
        data: dict[str, Any] = {"position": (("particle", "axis"), self.points, {"units": "m"})}
        coordinates: dict[str, Any] = {"axis": list(COMPONENTS[3]), "time": ((), self.time, {"units": "s"})}
        for name in self.names if names is None else names:
            values, attributes = self[name], {"units": self.unit(name)}
            if values.ndim == 1:
                data[name] = (("particle",), values, attributes)
                continue
            kind = {3: "axis", 6: "component", 9: "gradient"}.get(values.shape[1], f"{name}_part")
            data[name] = (("particle", kind), values, attributes)
            if values.shape[1] in COMPONENTS:
                coordinates[kind] = list(COMPONENTS[values.shape[1]])
        return xarray.Dataset(data, coordinates, {"file": self.file, "dimension": self.dimension})

    def to_pyvista(self, names: Sequence[str] | None = None) -> pyvista.PolyData:
        """Positions with fields, to be drawn or filtered by pyvista."""
        need_package("pyvista")
        import pyvista
        cloud = pyvista.PolyData(np.array(self.points))
        for name in self.names if names is None else names:
            cloud.point_data[name] = np.array(self[name])
        return cloud


class Snapshots(Sequence[Snapshot]):
    """Snapshots of a series by index, oldest first, or by time; files are opened at first use."""

    def __init__(self, frames: Sequence[tuple[float, str]]) -> None:
        self._frames = list(frames)

    def __repr__(self) -> str:
        if not self._frames:
            return "<scree.Snapshots: none>"
        return f"<scree.Snapshots: {len(self)} from {self._frames[0][0]:g} to {self._frames[-1][0]:g} s>"

    def __len__(self) -> int:
        return len(self._frames)

    @overload
    def __getitem__(self, place: int) -> Snapshot: ...
    @overload
    def __getitem__(self, place: slice) -> Snapshots: ...

    def __getitem__(self, place: int | slice) -> Snapshot | Snapshots:
        if isinstance(place, slice):
            return Snapshots(self._frames[place])
        return Snapshot(self._frames[place][1])

    def __iter__(self) -> Iterator[Snapshot]:
        return (Snapshot(file) for _, file in self._frames)

    @property
    def times(self) -> NDArray[np.float64]:
        """Times of all snapshots [s]."""
        return np.array([time for time, _ in self._frames])

    def near(self, time: float) -> Snapshot:
        """The snapshot whose time [s] is nearest."""
        if not self._frames:
            raise FileProblem("the run wrote no snapshots: add &output kind = 'particles' to the deck")
        return self[int(np.argmin(np.abs(self.times - time)))]
