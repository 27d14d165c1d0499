# SPDX-License-Identifier: BSD-3-Clause
# tiers: smoke, full
"""`scree --preview`, the file of walls of each run, and both in pictures.

Would catch: a rigid region that is drawn too large, too small or elsewhere, cut at the box where it enters later, or
left at its initial position; a boundary or a part of one with the wrong type, extent or time; a file that VTK does not
read, or that depends on the number of ranks or on units; a preview that makes steps, changes results, fails in a folder
with an unusual name, draws nothing, or does not say so where it cannot draw.

Limits. Corners of facets are on the surface to the rounding of 40 bisections. A chord of length L = sqrt(2) h of a
circle of radius r cuts off L^2/(12 r^2) of the area in the mean over its positions, L^2/(6 r^2) at worst; triangles of
a sphere with edges up to sqrt(3) h lose up to (sqrt(3) h)^2/(4 r^2) of its area.
"""

import math
import os
import shutil
import subprocess

import numpy as np
import pytest

import case
import post_command

PLANE = """
&run dimension='plane_strain' title='A block over a hill' /
&units system='mm-us-mg' output_units='{units}' /
&grid lo=0 0 0 hi=40 1 20 dx=0.5 /
&time t_end=2 /
&material name='al' density=2.7 young=70 poisson=0.3 /
&material name='cu' density=8.9 young=120 poisson=0.34 /
&region name='block' shape='box' lo=12 0 8 hi=20 1 14 /
&region name='other' shape='box' lo=22 0 8 hi=28 1 14 /
&region name='ball' shape='sphere' centre=16 0.5 3 radius=2 /
&region name='hill' shape='sphere' centre=16 0.5 0 radius=6 /
&region name='piston' shape='box' lo=-5 0 -1 hi=3 1 21 /
&region name='slot' shape='box' lo=39 0 5 hi=41 1 10 /
&body name='block' region='block' material='al' velocity=0 0 -0.5 /
&body name='other' region='other' material='cu' /
&boundary face='zlo' type='slip' /
&boundary face='xhi' type='stick' /
&boundary face='xhi' region='slot' type='friction' friction=0.1 t_on=1 /
&boundary region='hill' type='friction' friction=0.3 t_off=1.5 /
&boundary region='piston' type='slip' velocity=2 0 0 /
&output name='p' kind='particles' count=2 /
"""
LINE = """
&run dimension='1d' /
&grid lo=0 0 0 hi=1 2 3 dx=0.01 /
&time t_end=1e-6 /
&material name='al' density=2700 young=70e9 poisson=0.3 /
&region name='a' shape='box' lo=0.2 0 0 hi=0.5 2 3 /
&region name='p' shape='box' lo=0.05 0 0 hi=0.2 2 3 /
&body name='bar' region='a' material='al' /
&boundary region='p' type='slip' velocity=100 0 0 /
&boundary face='xhi' type='absorbing' /
"""
SPACE = """
&run dimension='3d' /
&grid lo=0 0 0 hi=10 10 10 dx=0.5 /
&time t_end=1e-6 /
&material name='al' density=2700 young=70e9 poisson=0.3 /
&region name='ball' shape='sphere' centre=5 5 8 radius=1.8 /
&region name='floor' shape='box' lo=-1 -1 -1 hi=11 11 1 /
&region name='peg' shape='sphere' centre=5 5 4 radius=2 /
&body name='ball' region='ball' material='al' /
&boundary region='floor' type='stick' /
&boundary region='peg' type='friction' friction=0.2 /
&boundary face='xlo' type='symmetry' /
"""
AXIS = """
&run dimension='axisymmetric' /
&grid lo=0 0 0 hi=10 1 10 dx=0.5 /
&time t_end=1e-6 /
&material name='al' density=2700 young=70e9 poisson=0.3 /
&region name='ball' shape='sphere' centre=0 0 7 radius=2 /
&region name='plate' shape='box' lo=-1 -1 1 hi=8 2 2 /
&body name='ball' region='ball' material='al' /
&boundary region='plate' type='stick' /
"""
FINE = 1.0e-9            # relative to the size of a set: 40 bisections of a step


def all_walls(path):
    """Walls of a file."""
    from scree.drawing import walls
    return walls.read_walls(str(path))


def walls_in(path):
    """Walls of a file by label; for a wall that appears or disappears, the time at which it is present at the end."""
    return {wall.label: wall for wall in all_walls(path)[::-1]}


def area_of(segments):
    """Area inside closed outlines in the plane x, z."""
    from scree.drawing import walls
    total = 0.0
    for loop in walls.outlines(segments[:, :, [0, 2]]):
        x, z = loop[:, 0], loop[:, 1]
        total += 0.5 * abs(np.sum(x[:-1] * z[1:] - x[1:] * z[:-1]))
    return total


def surface_of(triangles):
    """Area of triangles."""
    sides = triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0]
    return 0.5 * float(np.linalg.norm(np.cross(*sides), axis=1).sum())


def plane(options, sheet):
    """Surfaces, parts, times and paths in a plane, in two systems of units and on two ranks."""
    runs = [case.Case(options, name, PLANE.format(units=units), ranks=ranks) for name, units, ranks in (
        ("one", "si", 1), ("deck", "deck", 1), ("two", "si", 2))]
    runs[2].name = "one"                                 # in another folder
    for run in runs:
        run.run("-q")
    found = walls_in(runs[0].path("_walls.hdf"))
    sheet.require(set(found) == {"xlo: outflow", "xhi: stick", "xhi slot: friction", "zlo: slip", "zhi: outflow",
                                 "hill: friction", "piston: slip"}, f"walls: {sorted(found)}")
    hill = np.stack(found["hill: friction"].cells)
    away = np.hypot(hill[..., 0] - 0.016, hill[..., 2]) / 0.006 - 1.0
    inner = hill[..., 2] > 1.0e-12
    sheet.below("corners of the hill off its surface, over its radius", np.abs(away[inner]).max(), FINE)
    step = 0.25e-3
    sheet.near("area of the half disc [m2]", area_of(hill), 0.5 * math.pi * 0.006 ** 2,
               2.0 * step ** 2 / (6.0 * 0.006 ** 2) + 2.0 * step ** 2 / (0.5 * math.pi * 0.006 ** 2))
    piston = np.stack(found["piston: slip"].cells)
    sheet.below("left end of the piston that moves in from outside [m]", piston[..., 0].min() + 4.0e-3, FINE)
    sheet.below("right end of the piston [m]", piston[..., 0].max() - 3.0e-3, FINE)
    shift = found["piston: slip"].shift(1.0e-6)
    sheet.below("way of the piston after 1 us off 2 mm [m]", float(np.abs(shift - [0.002, 0.0, 0.0]).max()), 1.0e-12)
    sheet.below("way of the hill [m]", float(np.abs(found["hill: friction"].shift(1.0e-6)).max()), 0.0)
    slot = np.stack(found["xhi slot: friction"].cells)
    sheet.below("slot off 5 to 10 mm [m]", max(abs(slot[..., 2].min() - 0.005), abs(slot[..., 2].max() - 0.01)), 1e-12)
    drawn = {}
    for time in (0.5e-6, 1.5e-6):
        right = [wall for wall in all_walls(runs[0].path("_walls.hdf")) if wall.face == 2 and wall.acts(time)]
        drawn[time] = {wall.kind: round(1.0e3 * sum(abs(cell[1, 2] - cell[0, 2]) for cell in wall.cells), 9)
                       for wall in right}
        if time < 1.0e-6:
            drawn[time] = {"stick": round(1.0e3 * sum(abs(cell[1, 2] - cell[0, 2]) for wall in right
                                                      for cell in wall.cells), 9)}
    sheet.require(drawn == {0.5e-6: {"stick": 20.0}, 1.5e-6: {"stick": 15.0, "friction": 5.0}},
                  f"length of the right face by type before and after its part comes [mm]: {drawn}")
    acts = [[found[name].acts(time) for time in (0.5e-6, 1.2e-6, 1.8e-6)] for name in (
        "xhi slot: friction", "hill: friction", "zlo: slip")]
    sheet.require(acts == [[False, True, True], [True, True, False], [True] * 3], f"when walls are there: {acts}")
    other = walls_in(runs[1].path("_walls.hdf"))
    same = all(np.allclose(np.concatenate(found[name].cells), np.concatenate(other[name].cells), rtol=1e-15, atol=0.0)
               and found[name].acts(1.2e-6) == other[name].acts(1.2e-6) for name in found)
    sheet.require(same and np.allclose(other["piston: slip"].shift(1.0e-6), shift, rtol=1e-14),
                  "the same walls in the units of the deck")
    bytes_of = [run.path("_walls.hdf").read_bytes() for run in (runs[0], runs[2])]
    sheet.require(bytes_of[0] == bytes_of[1], "the same bytes on two ranks")
    in_vtk(sheet, runs[0].path("_walls.hdf"))
    pictures(sheet, runs[0])
    return runs[0]


def in_vtk(sheet, path):
    """VTK reads the file."""
    try:
        import vtk
    except ImportError:
        sheet.skipped("walls in VTK", "the package vtk is missing")
        return
    reader = vtk.vtkHDFReader()
    reader.SetFileName(str(path))
    reader.Update()
    data = reader.GetOutputDataObject(0)
    count = sum(len(wall.cells) for wall in all_walls(path))
    sheet.require(data.GetNumberOfCells() == count and data.GetCell(0).GetClassName() == "vtkLine",
                  f"VTK sees {data.GetNumberOfCells()} cells of {count}")
    sheet.require(data.GetCellData().HasArray("wall") == 1, "VTK sees the number of the wall of each cell")


def pixels(path):
    """Colours of a picture."""
    import matplotlib.image
    return (255.0 * matplotlib.image.imread(str(path))[..., :3]).round().astype(int)


def share(image, colour):
    """Fraction of the pixels that have about a given colour."""
    return float((np.abs(image - np.array(colour)).max(axis=2) < 12).mean())


def pictures(sheet, run):
    """Walls are in pictures, at their positions at that time, and can be left out."""
    view = ("--view", "0", "40mm", "0", "20mm", "--dpi", "60")
    found = {}
    for name, words in {"start": ("--time", "0"), "end": ()}.items():
        images = []
        for which in ((), ("--no-walls",)):
            out = run.folder / "walls.png"
            answer = post_command.call("picture", run.folder, "--colour", "body", "--out", out, *view, *words, *which)
            sheet.require(answer.returncode == 0, f"picture at the {name}: {answer.stderr}")
            images.append(pixels(out))
        found[name] = float((np.abs(images[0] - images[1]).max(axis=2) > 12).mean())
    # 60 mm2 of the piston and 57 mm2 of the hill are 15 % of the window, which is at least half of the page
    sheet.above("share of rigid regions in the first picture", found["start"], 0.07)
    # at that time the piston covers 140 mm2, and the hill has disappeared
    sheet.near("growth of rigid regions to the end", found["end"] / found["start"], 140.0 / 116.5, 0.1)


def test_line_and_space(options, sheet):
    """Points along a line, triangles in space."""
    run = case.Case(options, "line", LINE).run("-q", "--set", "time.max_steps=1")
    found = walls_in(run.path("_walls.hdf"))
    ends = sorted(float(cell[0, 0]) for cell in found["p: slip"].cells)
    sheet.require(len(ends) == 2 and abs(ends[0] - 0.05) < FINE and abs(ends[1] - 0.2) < FINE, f"piston: {ends}")
    run = case.Case(options, "space", SPACE).run("-q", "--set", "time.max_steps=1")
    found = walls_in(run.path("_walls.hdf"))
    peg = np.stack(found["peg: friction"].cells)
    away = np.linalg.norm(peg - [5.0, 5.0, 4.0], axis=2) / 2.0 - 1.0
    sheet.below("corners of the peg off its surface, over its radius", np.abs(away).max(), FINE)
    sheet.near("area of the peg [m2]", surface_of(peg), 4.0 * math.pi * 4.0, 3.0 * 0.25 ** 2 / 4.0 / 4.0)
    floor = np.stack(found["floor: stick"].cells)
    # the part in the box, 10 x 10 x 1; edges are cut off by less than a step of a quarter
    lost = 120.0 * 0.25 * (2.0 - math.sqrt(2.0))
    sheet.near("area of the floor in the box [m2]", surface_of(floor), 240.0, lost / 240.0)
    sheet.require(found["xlo: symmetry"].cells[0].shape == (4, 3), "a face in space is a quadrangle")


def previews(options, sheet, run):
    """Previews in all dimensions: one picture each, no step, results unchanged, unusual folder names."""
    folder = options.work / "Über sicht"
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    drawer = folder / "bin"
    drawer.mkdir()
    (drawer / "scree-post").write_text(f"#!/bin/sh\nPYTHONPATH='{post_command.PACKAGES}' exec '{os.sys.executable}' "
                                       "-m scree_post \"$@\"\n", encoding="utf-8")
    (drawer / "scree-post").chmod(0o755)
    shutil.copy(options.scree, drawer / "scree")         # without build/venv beside it
    path = {**os.environ, **case.OPEN_MPI, "PATH": f"{drawer}:{os.environ['PATH']}"}
    blue, red = (0, 114, 178), (213, 94, 0)
    for name, text, bodies in (("plane", PLANE.format(units="deck"), 2), ("line", LINE, 1), ("space", SPACE, 1),
                               ("axis", AXIS, 1)):
        (folder / f"{name}.nml").write_text(text, encoding="utf-8")
        answer = subprocess.run([drawer / "scree", "--preview", f"{name}.nml"], cwd=folder, env=path, text=True,
                                capture_output=True, check=False)
        sheet.require(answer.returncode == 0 and "wrote" in answer.stdout, f"{name}: {answer.stdout}{answer.stderr}")
        made = {file.name for file in (folder / "out" / f"{name}_preview").iterdir()}
        sheet.require({f"{name}_preview.png", f"{name}_walls.hdf", f"{name}_p_000000.hdf"} <= made
                      and f"{name}_p_000001.hdf" not in made and not (folder / "out" / name).exists(),
                      f"{name}: files {sorted(made)}")
        image = pixels(folder / "out" / f"{name}_preview" / f"{name}_preview.png")
        shares = [share(image, tint) for tint in (blue, red)[:bodies]]
        sheet.above(f"{name}: least share of a body in the picture", min(shares), 0.002)
    same = (folder / "out/plane_preview/plane_walls.hdf").read_bytes()
    again = subprocess.run([drawer / "scree", "--preview", "plane.nml"], cwd=folder, env=path, check=False,
                           capture_output=True)
    sheet.require(again.returncode == 0 and same == (folder / "out/plane_preview/plane_walls.hdf").read_bytes(),
                  "a second preview replaces the first")
    bare = {**path, "PATH": "/usr/bin:/bin"}
    answer = subprocess.run([drawer / "scree", "--preview", "line.nml"], cwd=folder, env=bare, text=True,
                            capture_output=True, check=False)
    sheet.require(answer.returncode == 0 and "scree-post preview" in answer.stdout and "setup.sh" in answer.stdout,
                  f"without scree-post: {answer.stdout}{answer.stderr}")
    for words, said in ((("--check",), "excludes"), (("--restart",), "excludes"),
                        (("--set", "grid.dxx=1"), "dxx")):
        answer = subprocess.run([drawer / "scree", "--preview", *words, "line.nml"], cwd=folder, env=path, text=True,
                                capture_output=True, check=False)
        sheet.require(answer.returncode == 2 and said in answer.stderr + answer.stdout, f"{words}: {answer.stderr}")
    before = {file.name: file.stat().st_mtime_ns for file in run.folder.iterdir()}
    run.run("--preview", "-q")
    sheet.require(before == {file.name: file.stat().st_mtime_ns for file in run.folder.iterdir()},
                  "results of a run are as they were")
    answer = post_command.call("preview", run.folder, "--out", folder / "again.png", "--by", "material")
    sheet.require(answer.returncode == 0, f"of the results of a run: {answer.stderr}")


@pytest.mark.tiers("full")
def test_preview(options, sheet):
    """All tests of previews."""
    run = plane(options, sheet)
    previews(options, sheet, run)
