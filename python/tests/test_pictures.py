# SPDX-License-Identifier: BSD-3-Clause
"""Pictures and radiographs, and their parts: shaded balls, smeared particles, panels, scripts of ParaView."""

from __future__ import annotations

import ast
import importlib
import shutil
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import scree

render: Any = importlib.import_module("scree.drawing.render")
smear: Any = importlib.import_module("scree.drawing.smear")
space: Any = importlib.import_module("scree.drawing.space")
areal_density: Any = importlib.import_module("scree.drawing.areal_density")
colour: Any = importlib.import_module("scree.drawing.colour")
panel: Any = importlib.import_module("scree_post.panel")
command: Any = importlib.import_module("scree_post.command")
files: Any = importlib.import_module("scree.files")

CUBE = """
&run  case = 'cube'  dimension = '3d' /
&grid  lo = 0, 0, 0  hi = 4, 4, 4  dx = 1 /
&time  t_end = 1e-6 /
&material  name = 'm'  density = 1000  bulk = 1e9  shear = 1e8 /
&region  name = 'one'  shape = 'box'  lo = 0, 0, 0  hi = 1, 2, 3 /
&body  name = 'one'  region = 'one'  material = 'm'  ppc = 2, 2, 2  velocity = 0, 0, 1 /
&boundary  face = 'xlo'  type = 'symmetry' /
&output  name = 'all'  kind = 'particles'  count = 1  precision = 'double' /
"""


@pytest.fixture(scope="module")
def cube(tmp_path_factory: pytest.TempPathFactory) -> scree.Run:
    """A box of 1 m x 2 m x 3 m at a mirror plane."""
    return scree.run(CUBE, outdir=tmp_path_factory.mktemp("cube"), progress=False)


def balls(places: list[tuple[float, float, float]], radius: float = 0.5) -> Any:
    """Grey balls of one size."""
    right, up, near = np.array(places, dtype=float).T
    tint = np.full((len(places), 3), 0.7)
    return render.Balls(right, up, near, np.full(len(places), radius), tint)


def test_ball_in_front() -> None:
    """Would catch a ball that hides a nearer one, rows that count upwards, and a wrong size."""
    for order in (1, -1):
        places = [(0.0, 0.0, 5.0), (0.3, 0.0, 0.0)][::order]
        depth, owner = render.splat(np.array([50.0 + 40.0 * place[0] for place in places]),
                                    np.array([30.0 for _ in places]), np.array([40.0 * place[2] for place in places]),
                                    np.full(2, 20.0), (60, 100))
        near = 0 if order == 1 else 1
        assert owner[30, 50] == near and owner[30, 62] == near
        assert owner[30, 78] == 1 - near
        assert depth[30, 50] == pytest.approx(40.0 * 5.0 + 20.0, abs=0.1)
        covered = (owner == near).sum()
        assert covered == pytest.approx(np.pi * 20.0 ** 2, rel=0.01)
    image = render.Image(60, 60, (-3.0, 3.0, -3.0, 3.0), balls([(0.0, 2.0, 0.0)]))
    assert np.flatnonzero(image.drawn.any(axis=1)).max() < 20, "the ball above is not above"


def test_shadow() -> None:
    """Would catch a missing shadow: a ball between the light and another ball must make it darker."""
    towards = render.LIGHT * 3.0
    alone = render.Image(200, 200, (-1.0, 1.0, -1.0, 1.0), balls([(0.0, 0.0, 0.0)]))
    behind = render.Image(200, 200, (-1.0, 1.0, -1.0, 1.0), balls([(0.0, 0.0, 0.0), tuple(towards)]))
    # those pixels of the first ball where the second one does not hide it
    same = behind.drawn & (behind.depth == alone.depth)
    assert same.sum() > 3000
    assert behind.colour[same].mean() < 0.88 * alone.colour[same].mean()
    assert (behind.colour[same] <= alone.colour[same] + 1e-12).all()


def test_facet_and_line() -> None:
    """Would catch a wall that hides the objects in front of it, one that hides nothing behind it, and edges drawn
    through balls."""
    image = render.Image(100, 100, (-1.0, 1.0, -1.0, 1.0), balls([(0.0, 0.0, 0.0)], 0.4))
    before = image.colour.copy()
    square = np.array([[-0.9, -0.9, 0.0], [0.9, -0.9, 0.0], [0.9, 0.9, 0.0], [-0.9, 0.9, 0.0]])
    image.facet(square - (0.0, 0.0, 1.0), (1.0, 0.0, 0.0), 0.5)
    assert (image.colour[50, 50] == before[50, 50]).all() and image.colour[10, 10] == pytest.approx([1.0, 0.5, 0.5])
    changed = (np.abs(image.colour - before).max(axis=2) > 0.1).sum()
    assert changed == pytest.approx(90 ** 2 - np.pi * 20.0 ** 2, rel=0.02), "a part of the wall twice or not at all"
    image.line(np.array([-0.9, 0.0, -1.0]), np.array([0.9, 0.0, -1.0]), (0.0, 0.0, 0.0))
    assert (image.colour[50, 10] == 0.0).all() and (image.colour[50, 50] == before[50, 50]).all()


def test_axis_that_points_up() -> None:
    """Would catch mirror images: directions that are not right-handed, or another vertical axis than the chosen one."""
    for up in range(3):
        right, above, towards = space.basis(30.0, 0.0, up)
        assert np.cross(right, above) == pytest.approx(towards)
        assert above == pytest.approx(np.eye(3)[up])


def test_smear_keeps_mass() -> None:
    """Would catch weights that do not add up, mass far from its particle, and compact material that is smeared."""
    random = np.random.default_rng(3)
    for axes in (2, 3):
        block = np.stack(np.meshgrid(*[np.arange(14.0 if axes == 2 else 8.0)] * axes), axis=-1).reshape(-1, axes)
        cloud = 40.0 + 80.0 * random.random((400, axes))
        line = np.zeros((200, axes))
        line[:, 0], line[:, -1] = 6.0 * np.arange(200), -300.0
        places, size = np.concatenate([block, cloud, line]), np.ones(len(block) + 600)
        rows, offsets, share, half = smear.smeared(places, size)
        assert np.bincount(rows, share) == pytest.approx(np.ones(len(size)), rel=1e-12)
        for axis in range(axes):
            assert np.abs(np.bincount(rows, share * offsets[:, axis])).max() < 1.0e-9
        assert (half[rows < len(block)] == 1.0).all() and (np.bincount(rows)[:len(block)] == 1).all()
        inside = np.isin(rows, np.arange(len(block), len(block) + 400))
        assert half[inside].mean() > 2.0
        last = rows >= len(block) + 400
        assert np.abs(offsets[last]).max(axis=0)[0] > 5.0, "a row is not smeared along itself"
        assert np.abs(offsets[last][:, 1:]).max() < 1.0e-6 and (half[last] < 6.0).all(), "a row is smeared across"
        kept = smear.smeared(places, size, np.zeros(len(size), bool))
        assert (kept[3] == 1.0).all() and len(kept[0]) == len(size), "intact material is smeared"


def test_smear_is_even() -> None:
    """Would catch stripes: the areal density of a thin uniform cloud must not differ by more than a tenth between
    pixels."""
    step = np.arange(40.0) * 5.0
    places = np.stack(np.meshgrid(step, step), axis=-1).reshape(-1, 2)
    rows, offsets, share, half = smear.smeared(places, np.ones(len(places)))
    spread = places[rows] + offsets
    image = areal_density.deposit((spread[:, 0], spread[:, 1]), share, half, (-100.0, -100.0), (2.0, 2.0), (200, 200))
    assert image.sum() == pytest.approx(len(places), rel=1e-12)
    middle = image[75:125, 75:125] * 25.0 / 4.0          # 1 where the cloud is uniform
    assert np.abs(middle - 1.0).max() < 0.1


def test_radiograph(cube: scree.Run, run: scree.Run) -> None:
    """Would catch mass that is lost, a missing mirror image, an image in other units, and exchanged axes."""
    for smeared in ("spacing", "volume"):
        frame = scree.radiograph(cube, pixel=0.05, smear=smeared)
        assert frame.mass == pytest.approx(2.0 * 6000.0)
        assert frame.areal_density.sum() * frame.pixel ** 2 == pytest.approx(frame.mass, rel=1e-12)
        assert frame.areal_density.max() == pytest.approx(2000.0, rel=0.01), "1000 kg/m3 over 2 m along y"
        across = scree.radiograph(cube, pixel=0.05, sight="x", smear=smeared)
        assert across.areal_density.max() == pytest.approx(2000.0, rel=0.01), "the mirror image is seen through as well"
    assert frame.extent[1] - frame.extent[0] > 3.0 > frame.extent[3] - frame.extent[2] > 2.0
    assert frame.speed == pytest.approx(1.0) and frame.time == cube.snapshots[-1].time
    assert frame.figure().axes
    with pytest.raises(scree.ScreeError, match="did you mean 'spacing'"):
        scree.radiograph(cube, smear="spacin")
    assert scree.radiograph(run, time=0.0).time == 0.0


def test_picture_in_space(cube: scree.Run) -> None:
    """Would catch an empty picture, a window that truncates the body, and a camera that has no effect."""
    def seen(**options: Any) -> Any:
        figure = scree.picture(cube, "velocity.z", limits=(0.0, 2.0), dpi=40, title="", **options)
        image = np.asarray(figure.axes[0].images[0].get_array())
        return np.ptp(image.astype(int), axis=2) > 30

    share = seen(camera="x").mean()
    for camera, wide, high in (("x", 2.0, 3.0), ("y", 2.0, 3.0), ("z", 2.0, 2.0)):
        drawn = seen(camera=camera)
        rows, columns = (np.flatnonzero(drawn.any(axis=axis)) for axis in (1, 0))
        assert np.ptp(columns) / np.ptp(rows) == pytest.approx(wide / high, rel=0.06), camera
        assert rows.min() > 0 and rows.max() < len(drawn) - 1
    assert seen(camera=(0.0, 0.0), no_mirror=True, view=(-4.0, 4.0, -4.0, 4.0)).mean() < 0.5 * share
    with pytest.raises(scree.ScreeError, match="no option 'colours'"):
        scree.picture(cube, colours="body")


def test_picture_in_a_plane(run: scree.Run) -> None:
    """Would catch a wrong time, a colour bar in other units, and snapshots of another output."""
    figure = scree.picture(run, "velocity.x", time=0.0)
    assert "t = 0" in figure.axes[0].get_title()
    assert "[km/s]" in figure.axes[1].get_ylabel()
    assert scree.picture(run.snapshots[-1]).axes[1].get_ylabel().startswith("speed")


def test_fragment_size(cube: scree.Run) -> None:
    """Would catch the number of a fragment used as its size, and dust with the size of a fragment."""
    snap = files.snapshot(cube.snapshots[-1].file)
    number = np.zeros(len(snap.points))
    number[:40], number[40:41] = 1, 2
    snap.fields["fragment"] = number
    size = colour.values_of(snap, "fragment_size")
    assert size[0] == pytest.approx(np.cbrt(40 * 0.125 * 6.0 / np.pi), rel=1e-6)
    assert size[40] == pytest.approx(np.cbrt(0.125 * 6.0 / np.pi), rel=1e-6)
    assert np.isnan(size[41:]).all() and colour.default_name(snap) == "fragment_size"
    scale = colour.colour_for("fragment_size", [snap])
    assert scale.log and scale.unit == "m" and scale.low == pytest.approx(size[40])
    grey = colour.paint(scale, size)[-1]
    assert grey[0] == grey[1] == grey[2]
    number[:] = 1
    assert colour.default_name(snap) == "velocity"


def test_panel(run: scree.Run) -> None:
    """Would catch particles with a wrong size, and a mirror image on the same side."""
    import matplotlib.pyplot
    snap = files.snapshot(run.snapshots[0].file)
    _, axes = matplotlib.pyplot.subplots()
    shown = panel.particles(axes, snap, snap.fields["mass"], low=0.0, high=1.0, rows=snap.fields["body"] == 1,
                            sides=(1, -1))
    corners = np.array([path.vertices[:4] for path in shown.get_paths()])
    assert len(corners) == 2 * (snap.fields["body"] == 1).sum()
    assert np.ptp(corners, axis=1) == pytest.approx(np.full((len(corners), 2), 0.5), rel=1e-5), "half a cell of 1 mm"
    assert corners[:, :, 0].min() == pytest.approx(-5.0) and corners[:, :, 0].max() == pytest.approx(5.0)


def constants(tree: ast.Module) -> dict[str, Any]:
    """Names in capital letters that a script sets to literals."""
    found: dict[str, Any] = {}
    for node in tree.body:
        if isinstance(node, ast.Assign):
            for target in node.targets:
                names = target.elts if isinstance(target, ast.Tuple) else [target]
                values = node.value.elts if isinstance(node.value, ast.Tuple) else [node.value]
                for name, value in zip(names, values):
                    if isinstance(name, ast.Name) and name.id.isupper() and not isinstance(value, ast.Call):
                        found[name.id] = ast.literal_eval(value)
    return found


def test_script_of_paraview(cube: scree.Run, run: scree.Run, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Would catch a script with a syntax error, a field that the files lack, and dots with a wrong unit.

    test/input/test_paraview.py lets ParaView run it."""
    monkeypatch.setattr("scree_post.commands.paraview.pvpython", list)
    for made, words, size in ((cube, [str(cube.folder)], 0.5),
                              (run, [str(run.path("_p.hdf.series")), "--colour", "stress.xx"], 0.5)):
        out = tmp_path / "view.py"
        assert command.main(["paraview", *words, "--out", str(out)]) == 0
        tree = ast.parse(out.read_text(encoding="utf-8"))
        found = constants(tree)
        assert found["FIELD"] in made.snapshots[-1].names if made is cube else "stress"
        assert found["COMPONENT"] == ("Magnitude" if made is cube else "XX") and found["LOW"] < found["HIGH"]
        assert found["RADIUS"] == pytest.approx(0.6 * size, rel=0.02), "widths in the unit of the file"
        assert found["FLAT"] is (made is run)
        names = {node.id for node in ast.walk(tree) if isinstance(node, ast.Name)}
        imported = {alias.name for node in ast.walk(tree) if isinstance(node, ast.ImportFrom) for alias in node.names}
        stored = {node.id for node in ast.walk(tree) if isinstance(node, ast.Name) and isinstance(node.ctx, ast.Store)}
        assert names - stored <= imported | {"sys", "str", "len", "print", "zip"}, "a name that is nowhere defined"
    with pytest.raises(scree.ScreeError, match=r"write a \.py"):
        command.main(["paraview", str(cube.folder), "--out", str(tmp_path / "view.txt")])
    # text of the user that would end the docstring or a string of the script
    folder = tmp_path / 'a"""; bad = 1; """\'\\'
    shutil.copytree(cube.folder, folder)
    out = folder / 'b"""; bad = 1; """.py'
    assert command.main(["paraview", str(folder), "--out", str(out)]) == 0
    tree = ast.parse(out.read_text(encoding="utf-8"))
    assert not [node for node in ast.walk(tree) if isinstance(node, ast.Name) and node.id == "bad"]
    assert repr(str(folder))[1:-1] in out.read_text(encoding="utf-8")
