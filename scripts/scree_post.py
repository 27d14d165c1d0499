# SPDX-License-Identifier: BSD-3-Clause
"""Reading what Scree writes: snapshot series, snapshots and time histories.

    import scree_post
    for time, file in scree_post.series("out/case/case_p.hdf.series"):
        snap = scree_post.snapshot(file)
        print(time, snap.points.shape, snap.fields["mass"].sum(), snap.units["mass"])
    table = scree_post.history("out/case/case_history.csv")
    table["kinetic"], table.units["kinetic"]

All values are in SI units, as in the files. Only h5py and numpy are needed.
"""
import csv
import json
import os
import sys
from dataclasses import dataclass, field

DIMENSIONS = ("3d", "plane_strain", "axisymmetric", "1d")
EXIT_USAGE = 2
EXIT_FILE = 3


class PostError(Exception):
    """A one-line message for the user and the exit code that goes with it."""

    def __init__(self, message, code=EXIT_FILE):
        super().__init__(message)
        self.code = code


def modules(*names):
    """Import what a script needs, with one clear line if it is not installed."""
    import importlib
    try:
        return [importlib.import_module(name) for name in names]
    except ImportError as error:
        raise PostError(
            f"Python package '{error.name}' is missing; scripts/setup.sh installs it in "
            "build/venv, then use build/venv/bin/python"
        ) from error


def pyplot():
    """Matplotlib without a display, in the look shared by all pictures."""
    (matplotlib,) = modules("matplotlib")
    matplotlib.use("Agg")
    (plot,) = modules("matplotlib.pyplot")
    plot.rcParams.update({
        "font.family": "DejaVu Sans", "font.size": 11, "axes.titlesize": 11, "axes.labelsize": 11,
        "axes.linewidth": 0.8, "xtick.labelsize": 10, "ytick.labelsize": 10, "legend.fontsize": 10,
        "xtick.direction": "out", "ytick.direction": "out", "legend.frameon": False,
        "savefig.facecolor": "white", "mathtext.default": "regular", "svg.fonttype": "none"})
    return plot


def run(main, name):
    """Run a script's main; errors are one line on standard error and an exit code."""
    try:
        code = main()
        sys.stdout.flush()
    except PostError as error:
        print(f"{name}: {error}", file=sys.stderr)
        code = error.code
    except BrokenPipeError:                              # the reader of our output went away
        sys.stdout = open(os.devnull, "w", encoding="ascii")
        code = 0
    except KeyboardInterrupt:
        print(f"{name}: interrupted", file=sys.stderr)
        code = 130
    except MemoryError as error:
        print(f"{name}: not enough memory: {error}", file=sys.stderr)
        code = EXIT_FILE
    sys.exit(code or 0)


def readable(path):
    """The path itself if it is a file that can be read."""
    if not os.path.exists(path):
        raise PostError(f"no such file: {path}")
    if os.path.isdir(path):
        raise PostError(f"{path} is a folder, a file is wanted")
    if not os.access(path, os.R_OK):
        raise PostError(f"no permission to read {path}")
    return path


def series_file(path):
    """The series that a user means: the file itself, or the only series of a folder."""
    if os.path.isdir(path):
        found = sorted(name for name in os.listdir(path) if name.endswith("_p.hdf.series"))
        if len(found) == 1:
            return os.path.join(path, found[0])
        raise PostError(
            f"{path}: {len(found) or 'no'} particle series (*_p.hdf.series) in this folder, "
            "name the file"
        )
    return path


def series(path):
    """List of (time [s], file) of a .series file, a snapshot, or a folder with one series."""
    path = readable(series_file(path))
    if not path.endswith(".series"):
        return [(snapshot_time(path), path)]
    try:
        with open(path, encoding="utf-8") as handle:
            entries = json.load(handle)["files"]
        folder = os.path.dirname(os.path.abspath(path))
        frames = [(float(entry["time"]), os.path.join(folder, entry["name"])) for entry in entries]
    except (ValueError, KeyError, TypeError) as error:
        raise PostError(
            f"{path} is not a snapshot series: {type(error).__name__}: {error}"
        ) from error
    except OSError as error:
        raise PostError(f"cannot read {path}: {error.strerror}") from error
    if not frames:
        raise PostError(f"{path} lists no snapshots")
    return sorted(frames)


def text(value):
    """A string from what HDF5 hands back: bytes, padded or not, or arrays of one."""
    if hasattr(value, "tolist"):
        value = value.tolist()
    while isinstance(value, (list, tuple)) and len(value) == 1:
        value = value[0]
    if isinstance(value, bytes):
        value = value.decode("utf-8", "replace")
    return value.strip("\0 ") if isinstance(value, str) else value


@dataclass
class Snapshot:
    """One snapshot of particles."""

    file: str
    time: float                                          # [s]
    points: object                                       # (n, 3) [m]
    fields: dict = field(default_factory=dict)           # name: (n,), (n, 3) or (n, 6)
    units: dict = field(default_factory=dict)            # name: unit
    bodies: list = field(default_factory=list)           # {"name", "material", "colour"} per body
    first_body: int = 1                                  # value of the field body of bodies[0]
    provenance: dict = field(default_factory=dict)

    @property
    def dimension(self):
        """Problem class, one of DIMENSIONS."""
        return self.provenance["dimension"]

    @property
    def symmetry(self):
        """Faces that are planes of symmetry, such as ["xlo", "ylo"]."""
        value = self.provenance.get("symmetry", "")
        return value.split() if isinstance(value, str) else [str(text(face)) for face in value]

    def need(self, *names):
        """The named fields, or a message naming those that the file does not hold."""
        missing = [name for name in names if name not in self.fields]
        if missing:
            raise PostError(
                f"{self.file}: no field {', '.join(missing)}; write it with &output fields "
                f"(there are: {', '.join(sorted(self.fields)) or 'none'})"
            )
        return [self.fields[name] for name in names]


def _open(path):
    (h5py,) = modules("h5py")
    try:
        handle = h5py.File(readable(path), "r")
    except OSError as error:
        reason = (
            "still being written" if "unable to lock" in str(error) else "not HDF5, or cut short"
        )
        raise PostError(f"cannot open {path}: {reason}") from error
    if "VTKHDF/Points" not in handle:
        handle.close()
        raise PostError(f"{path} is not a particle snapshot: it has no /VTKHDF/Points")
    return handle


def _time(handle, path):
    try:
        return float(handle["VTKHDF/FieldData/TimeValue"][0])
    except (KeyError, IndexError) as error:
        raise PostError(f"{path} has no /VTKHDF/FieldData/TimeValue") from error


def snapshot_time(path):
    """Time of a snapshot [s]."""
    with _open(path) as handle:
        return _time(handle, path)


def _bodies(handle):
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


def snapshot(file, names=None):
    """Read a snapshot: points, fields (all, or those named), units, bodies, provenance."""
    with _open(file) as handle:
        try:
            data = handle.get("VTKHDF/PointData", {})
            points = handle["VTKHDF/Points"][...].astype("f8")
            snap = Snapshot(file=file, time=_time(handle, file), points=points)
            for name in data:
                if names is None or name in names:
                    snap.fields[name] = data[name][...]
                    snap.units[name] = str(text(data[name].attrs.get("units", "1")))
            snap.bodies, snap.first_body = _bodies(handle)
            if "provenance" in handle:
                snap.provenance = {k: text(v) for k, v in handle["provenance"].attrs.items()}
        except OSError as error:
            raise PostError(f"cannot read {file}: damaged or cut short") from error
    wrong = [name for name, values in snap.fields.items() if len(values) != len(points)]
    if wrong:
        raise PostError(f"{file}: field {wrong[0]} has {len(snap.fields[wrong[0]])} rows "
                        f"for {len(points)} particles")
    snap.provenance.setdefault("dimension", "3d")
    if snap.dimension not in DIMENSIONS:
        raise PostError(f"{file}: unknown dimension '{snap.dimension}' in /provenance")
    return snap


class History(dict):
    """Columns of a history by name; `units` holds the units, `order` the names."""

    def __init__(self):
        super().__init__()
        self.units = {}
        self.order = []


def history(file):
    """Read CASE_history.csv; a last line that is still being written is left out."""
    (numpy,) = modules("numpy")
    try:
        with open(readable(file), newline="", encoding="utf-8") as handle:
            rows = [row for row in csv.reader(handle) if row and not row[0].startswith("#")]
    except (UnicodeDecodeError, csv.Error) as error:
        raise PostError(
            f"{file} is not a history: not a text file of comma separated values"
        ) from error
    if not rows or not any(cell.strip().startswith("time") for cell in rows[0]):
        raise PostError(f"{file} is not a history: its first line names no column 'time [s]'")
    head, body = rows[0], rows[1:]
    if body and len(body[-1]) != len(head):
        body.pop()
    try:
        values = numpy.array([[float(cell) for cell in row] for row in body])
    except ValueError as error:
        raise PostError(f"{file}: {error}") from error
    if values.ndim != 2 or values.shape[1] != len(head):
        raise PostError(f"{file} holds no complete line below its header")
    table = History()
    for column, title in enumerate(head):
        name, _, unit = title.strip().partition("[")
        table.order.append(name.strip())
        table[name.strip()] = values[:, column]
        table.units[name.strip()] = unit.rstrip("] ") or "1"
    return table


def scaled(largest, unit):
    """Factor and label that make numbers of this size readable, such as (1e6, "µs")."""
    steps = {
        "s": ((1.0, 1.0, "s"), (1.0e-3, 1.0e3, "ms"), (1.0e-6, 1.0e6, "µs"), (0.0, 1.0e9, "ns")),
        "m": ((0.5, 1.0, "m"), (5.0e-4, 1.0e3, "mm"), (0.0, 1.0e6, "µm")),
        "J": ((1.0e6, 1.0e-6, "MJ"), (1.0e3, 1.0e-3, "kJ"), (1.0, 1.0, "J"), (0.0, 1.0e3, "mJ")),
        "kg": ((1.0, 1.0, "kg"), (1.0e-3, 1.0e3, "g"), (0.0, 1.0e6, "mg")),
        "m/s": ((1.0e3, 1.0e-3, "km/s"), (0.0, 1.0, "m/s")),
    }
    if unit == "s" and largest >= 1.0e-6:                # impacts are told in microseconds
        return (1.0e6, "µs") if largest < 1.0e-3 else scaled_step(steps[unit], largest)
    return scaled_step(steps.get(unit, ((0.0, 1.0, unit),)), largest)


def scaled_step(steps, largest):
    """First step whose lower bound the number reaches."""
    for bound, factor, label in steps:
        if largest >= bound:
            return factor, label
    return steps[-1][1:]


def save(figure, path, dpi):
    """Write a picture under a temporary name, then rename it, so that no half picture is left."""
    stem, ending = os.path.splitext(path)
    if ending.lower() not in (".png", ".pdf", ".svg", ".jpg", ".tif"):
        raise PostError(f"--out {path}: write a .png, .pdf, .svg, .jpg or .tif", EXIT_USAGE)
    part = f"{stem}.part{ending}"
    try:
        figure.savefig(part, dpi=dpi)
        os.replace(part, path)
    except OSError as error:
        if os.path.exists(part):
            os.remove(part)
        raise PostError(f"cannot write {path}: {error.strerror or error}") from error


COMMANDS = {"accuracy": ("scree_accuracy", "how accurate a number of a deck is, and what more costs")}


def main():
    """Hand the words over to the module of a command."""
    import importlib
    words = sys.argv[1:]
    if words and words[0] in COMMANDS:
        return importlib.import_module(COMMANDS[words[0]][0]).main(words[1:])
    lines = "\n".join(f"  {name:<10} {text}" for name, (_, text) in COMMANDS.items())
    use = (f"usage: scree_post.py COMMAND [options]\n\n{lines}\n\nscree_post.py COMMAND --help lists "
           "the options of a command.")
    if words and words[0] in ("-h", "--help"):
        print(use)
        return 0
    raise PostError(f"unknown command '{words[0]}'\n{use}" if words else use, EXIT_USAGE)


if __name__ == "__main__":
    sys.dont_write_bytecode = True
    import scree_post                                    # the module that the commands know
    scree_post.run(scree_post.main, "scree_post")
