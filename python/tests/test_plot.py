# SPDX-License-Identifier: BSD-3-Clause
"""Figures: their content and units."""

from __future__ import annotations

from pathlib import Path

import matplotlib.colors
import matplotlib.pyplot
import numpy as np
import pytest
from matplotlib.collections import PolyCollection
from matplotlib.figure import Figure

import scree
from scree import plot
from scree.drawing.look import readable_unit


@pytest.mark.parametrize(("size", "unit", "factor", "shown"), [
    (2.5e9, "Pa", 1e-9, "GPa"), (4e-6, "s", 1e6, "µs"), (0.02, "m", 1e3, "mm"), (90.0, "m", 1.0, "m"),
    (5e-4, "1", 1e6, "10⁻⁶"), (3e7, "1/s", 1e-6, "10⁶ 1/s"), (0.0, "J", 1.0, "J"), (7e3, "m/s", 1e-3, "km/s"),
    (1000.0, "J", 1e-3, "kJ"), (float("nan"), "Pa", 1.0, "Pa")])
def test_readable_unit(size: float, unit: str, factor: float, shown: str) -> None:
    """Would catch a prefix that does not belong to the factor: an axis that is wrong by a factor of a thousand."""
    found = readable_unit(size, unit)
    assert found[0] == pytest.approx(factor) and found[1] == shown


def test_history(run: scree.Run) -> None:
    """Would catch a curve of another column, or numbers that do not match the unit of the axis."""
    figure = plot.history(run, ["kinetic", "momentum_x"])
    upper, lower = figure.axes
    factor, unit = readable_unit(run.history["kinetic"].abs().max(), "J")
    assert upper.get_ylabel() == f"kinetic [{unit}]" and lower.get_ylabel().startswith("momentum x [")
    assert upper.lines[0].get_ydata() == pytest.approx(factor * run.history["kinetic"].to_numpy())
    assert lower.get_xlabel() == "time [µs]"
    assert upper.lines[0].get_xdata() == pytest.approx(1e6 * run.history["time"].to_numpy())
    with pytest.raises(KeyError, match="did you mean 'kinetic'"):
        plot.history(run, "kinetc")


def test_several_histories(run: scree.Run) -> None:
    """Would catch curves of several runs without different labels."""
    (axes,) = plot.history([run, run], "velocity_x", table="gauge").axes
    styles = [line.get_linestyle() for line in axes.lines]
    assert len(styles) == 2 and styles[0] != styles[1]


def squares_of(figure: Figure) -> PolyCollection:
    """The particles of a picture."""
    (found,) = (part for part in figure.axes[0].collections if isinstance(part, PolyCollection))
    return found


def corners_of(squares: PolyCollection) -> np.ndarray:
    """Corners (n, 4, 2) of the particles of a picture."""
    return np.array([np.asarray(path.vertices)[:4] for path in squares.get_paths()])


def test_field(run: scree.Run, tmp_path: Path) -> None:
    """Would catch squares of a wrong size or position, a colour bar in other units, and colours that cover only half of
    the range."""
    snap = run.snapshots[-1]
    figure = plot.field(snap, "pressure")
    squares = squares_of(figure)
    factor, unit = readable_unit(np.abs(snap["pressure"]).max(), "Pa")
    assert np.asarray(squares.get_array()) == pytest.approx(factor * snap["pressure"])
    assert figure.axes[0].child_axes[0].get_ylabel() == f"pressure [{unit}]"
    corners = corners_of(squares)
    assert corners.mean(axis=1) == pytest.approx(1e3 * snap.points[:, [0, 2]])
    edges = np.ptp(corners, axis=1)
    assert 1e-6 * edges.prod(axis=1) * 2e-3 == pytest.approx(snap["volume"])
    low, high = squares.get_clim()
    # ends of another sign are at most a twentieth
    assert (low, high) == (-high, high) or max(low, -high) >= -0.05 * max(high, -low)
    figure.savefig(tmp_path / "field.png")
    assert (tmp_path / "field.png").stat().st_size > 5000


def test_limits(run: scree.Run) -> None:
    """Would catch limits in the unit of the axis instead of SI, and a colour bar without the pointed ends that mark
    values beyond the limits."""
    snap = run.snapshots[-1]
    most = float(np.abs(snap["pressure"]).max())
    figure = plot.field(snap, "pressure", limits=(0.0, 0.5 * most))
    factor = readable_unit(0.5 * most, "Pa")[0]
    assert squares_of(figure).get_clim() == pytest.approx((0.0, factor * 0.5 * most))
    assert squares_of(figure).get_cmap().name == plot.SEQUENTIAL
    assert plot.limits_of(np.array([-1.0, 3.0, np.nan]), None) == (-3.0, 3.0)
    assert plot.limits_of(np.array([2.0, 2.0]), None) == (2.0, 4.0)


def test_colours_differ_in_lightness() -> None:
    """Would catch a colour map whose ends look the same to colour-blind readers or in print."""
    def lightness(name: str) -> np.ndarray:
        colours = matplotlib.colormaps[name](np.linspace(0.0, 1.0, 64))[:, :3]
        return np.asarray(colours @ (0.2126, 0.7152, 0.0722))

    assert np.all(np.diff(lightness(plot.SEQUENTIAL)) > 0.0)
    middle = lightness(plot.DIVERGING)
    assert middle[32] > 0.8 and middle[0] < 0.4 and middle[-1] < 0.4
    ends = matplotlib.colormaps[plot.DIVERGING]([0.0, 1.0])
    assert abs(ends[0][2] - ends[1][2]) > 0.2            # blue and not blue: different for any kind of colour vision


def test_vectors_and_tensors(run: scree.Run) -> None:
    """Would catch a vector of which only the first component is shown, and a tensor that is shown without an error."""
    snap = run.snapshots[0]
    squares = squares_of(plot.field(snap, "velocity"))
    assert np.max(np.asarray(squares.get_array())) == pytest.approx(1.0), "in km/s"
    with pytest.raises(ValueError, match="stress_xx"):
        plot.field(snap, "stress")


def test_one_dimension(bar: scree.Run) -> None:
    """Would catch a picture of squares in one dimension, where a line is required."""
    figure = plot.field(bar.snapshots[-1], "pressure")
    (axes,) = figure.axes
    assert axes.get_xlabel() == "x [mm]" and axes.get_ylabel() == "pressure [GPa]"


def test_axisymmetric(tmp_path: Path) -> None:
    """Would catch rings drawn without axisymmetry, and a missing half of the plane."""
    text = """
&run  case = 'ring'  dimension = 'axisymmetric' /
&grid  lo = 0, 0, 0  hi = 4, 0, 4  dx = 1 /
&time  t_end = 1e-6 /
&material  name = 'm'  density = 1000  bulk = 1e9  shear = 1e8 /
&region  name = 'disc'  shape = 'box'  lo = 0, 0, 1  hi = 2, 0, 3 /
&body  name = 'disc'  region = 'disc'  material = 'm'  ppc = 2, 1, 2 /
&output  name = 'all'  kind = 'particles'  count = 1 /
"""
    snap = scree.run(text, outdir=tmp_path, progress=False).snapshots[0]
    assert snap.size() == pytest.approx(np.full(16, 0.5), rel=1e-5)
    for mirror, count in ((True, 32), (False, 16)):
        figure = plot.field(snap, "mass", mirror=mirror)
        centres = corners_of(squares_of(figure)).mean(axis=1)
        assert len(centres) == count and centres[:, 0].min() == pytest.approx(-1.75 if mirror else 0.25)
    assert figure.axes[0].get_xlabel() == "radius [m]"


def test_three_dimensions(run: scree.Run, monkeypatch: pytest.MonkeyPatch) -> None:
    """Would catch a picture in which squares hide each other."""
    monkeypatch.setattr(scree.Snapshot, "dimension", "3d")
    with pytest.raises(ValueError, match="to_pyvista"):
        plot.field(run.snapshots[0], "pressure")


def test_line(run: scree.Run) -> None:
    """Would catch a curve in other units than those of its axis, and fields of different units on one axis."""
    snap, ends = run.snapshots[-1], ((2e-3, 1e-3, 2.3e-3), (10e-3, 1e-3, 2.3e-3))
    table = snap.along(*ends, ["stress_xx", "stress_zz"])
    figure, given = matplotlib.pyplot.subplots()
    assert plot.line(snap, ["stress_xx", "stress_zz"], *ends, axes=given) is figure
    factor, unit = readable_unit(table[["stress_xx", "stress_zz"]].abs().max().max(), "Pa")
    assert given.lines[1].get_ydata() == pytest.approx(factor * table["stress_zz"].to_numpy())
    assert given.lines[0].get_xdata() == pytest.approx(1e3 * table["distance"].to_numpy())
    assert given.get_ylabel() == f"[{unit}]" and given.get_xlabel() == "distance [mm]"
    with pytest.raises(ValueError, match="several units"):
        plot.line(snap, ["stress_xx", "velocity"], *ends)
    with pytest.raises(ValueError, match="no particle"):
        plot.line(snap, "stress_xx", (2e-3, 1e-3, 5.9e-3), (3e-3, 1e-3, 5.9e-3))
