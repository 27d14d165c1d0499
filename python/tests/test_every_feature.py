# SPDX-License-Identifier: BSD-3-Clause
"""A deck that uses every feature of the language, read by all commands of scree-post and all functions of scree.

Would catch a reader of decks besides the program, a title or a name that a command takes as a formula, a format or a
path, and a command that fails on a table, a kind of output or a unit that the small decks of the other tests lack.
"""
from __future__ import annotations

import contextlib
import io
from collections.abc import Callable
from pathlib import Path
from typing import Any

import matplotlib.pyplot
import numpy as np
import pytest

import scree
from scree.errors import ScreeError
from scree.quantities import check
from scree_post.command import main
from scree_post.commands import COMMANDS

# Expressions, names, units, presets, lists with repeated values, an included file, tabs, carriage returns, both kinds
# of quotes, quotes in quotes, comments with quotes, groups on one line and over lines, capital letters, a comment in
# Latin-1, and a title with dollar signs, backslashes, braces and percent signs.
DECK = r"""! a comment with 'quotes", braces {1/0} and &groups /
&RUN~Title = 'Stoß $v_0$ of "two" bodies: it''s \alpha \N{x} {0} %s 50 %'
   dimension='plane_strain'/ &units system = 'mm-us-mg' output_units='deck' /
&define v = 0.5 km/s  angle = 30  n = 16 /
&define
   h = {1/2}    ! mm
/
&grid lo = 3*0   hi = 16~2, {n/2}
   dx = {h}  /
&time t_end = {2*h} us   cfl = 4d-1 /
&effects  contact = T, damage = .TRUE.  thermal = .true. /
&include file = "more things.nml" /
&material name = 'soft'  density = 1.2 g/cm3  young = {0.5 + 0.5} GPa  poisson = .3  specific_heat = 0.9 kJ/(kg K) /
&region name = 'ball' shape = 'sphere' centre = 4, 1, 4 radius = {3*h} mm /
&region name = 'brick' shape = 'box' lo = 9 0 1 hi = 10 mm, 2 mm, 0.2 cm /
&body name = 'ball+1.a' region = 'ball' material = 'metal' ppc = 2,1,2 velocity = {v*cosd(angle)}, 0, {v*sind(angle)} /
&body name = 'brick' region = 'brick' material = 'soft' ppc = 2 1 2 repeat = 1, 1, 3 repeat_step = 2*0, 2
   velocity_formula = '-0.1*(z - {n/4})', '0', '0' /
&contact friction = 0.2 /
&boundary face = 'xhi' type = 'slip' /
&output name = 'all'  kind = 'particles'  count = 2  fields = 'default', 'stress', 'fragment'  precision = 'double' /
&output name = 'e'  kind = 'history'  every = 2 /
&output name = 'spot'  kind = 'gauge'  every = 2  gauge = 'particle'  point = 4, 1, 4  fields = 'velocity', 'pressure' /
&output name = 'mean'  kind = 'gauge'  every = 2  gauge = 'mean'  fields = 'velocity' /
&output name = 'load'  kind = 'forces'  every = 2 /
&output name = 'pieces'  kind = 'fragments'  count = 2 /
&output name = 'line'  kind = 'profile'  count = 3  axis = 'x'  bins = 4 /
&output name = 'cells'  kind = 'grid'  count = 2 /
&output name = 'cut'  kind = 'slice'  count = 2  axis = 'z'  at = 4 /
""".replace("~", "\t").replace("\n&grid", "\r\n&grid")
MORE = "&material name = 'metal'  preset = 'al_6061_t6'  spall = 1 GPa /"


@pytest.fixture(scope="module")
def deck(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The deck in a folder whose name needs quotes."""
    folder = tmp_path_factory.mktemp("it's {every} $feature$")
    (folder / "more things.nml").write_text(MORE, encoding="utf-8")
    path = folder / "every.nml"
    path.write_bytes(DECK.encode("utf-8") + "! Größe in Latin-1\n".encode("latin-1"))
    return path


@pytest.fixture(scope="module")
def results(deck: Path) -> scree.Run:
    """Its run."""
    return scree.run(deck, outdir=deck.parent / "out", progress=False)


def post(*words: object) -> str:
    """What a command of scree-post prints; it has to succeed."""
    said = io.StringIO()
    with contextlib.redirect_stdout(said):
        assert not main([str(word) for word in words]), words
    return said.getvalue()


def test_all_commands(deck: Path, results: scree.Run, monkeypatch: pytest.MonkeyPatch) -> None:
    """Each command on the deck or on its results."""
    monkeypatch.chdir(deck.parent)
    monkeypatch.setenv("MPLBACKEND", "Agg")
    out, mark = results.folder, out_file(deck)
    series = out / "every_p.hdf.series"
    grid = "grid.dx={4*h/2},{2*h/2}"
    calls: dict[str, tuple[object, ...]] = {
        "preview": (out, "--by", "body", "--out", mark("preview.png")),
        "info": (series, "--time", "1us"), "plot": (out, "--y", "kinetic,internal", "--out", mark("plot.pdf")),
        "picture": (series, "--colour", "speed", "--out", mark("picture.png")),
        "movie": (series, "--colour", "body", "--out", mark("movie.gif")),
        "radiograph": (series, "--pixel", "0.1mm", "--out", mark("radiograph.png")), "fragments": (series,),
        "means": (out / "every_gauge.csv",), "paraview": (series, "--colour", "speed", "--out", mark("view.py")),
        "compare": (series, series), "check": (series,),
        "sweep": (deck, "--set", grid, "--take", "gauge.velocity_x:max,fragments[1].mass,profile.density:mean,steps",
                  "--set", "define.angle=30", "--outdir", deck.parent / "sweep"),
        "accuracy": (deck, "--quantity", "forces.xhi_impulse_x", "mean_gauge.velocity_x:mean", "fragments.fragment:max",
                     "--factors", "4,2,1", "--work", deck.parent / "accuracy", "--plot", mark("accuracy.png"))}
    others = {"eos", "grains", "terrain", "validate"}    # of materials, grains, rasters, own decks
    assert {*calls} | others == {*COMMANDS}
    said = {name: post(name, *words) for name, words in calls.items()}
    post("plot", out / "every_profile.csv", "--x", "position", "--y", "density", "--out", mark("line.png"))
    assert "4 rows" in post("means", out / "every_profile.csv", "--row", 2, "--columns", "mass")
    with pytest.raises(ScreeError, match=r"choose one by its fragment, --row 1"):
        post("means", out / "every_fragments.csv")
    for name in ("preview.png", "plot.pdf", "picture.png", "movie.gif", "radiograph.png", "accuracy.png"):
        assert mark(name).stat().st_size > 3000, name
    assert "Stoß $v_0$" in said["info"] and r"\N{x} {0} %s 50 %" in said["info"]
    space: dict[str, Any] = {}
    text = mark("view.py").read_text(encoding="utf-8")
    exec("\n".join(line for line in text.splitlines() if line.startswith(("TITLE =", "FIELD,"))), space)
    assert space["TITLE"].startswith("Stoß $v_0$") and (space["FIELD"], space["COMPONENT"]) == ("velocity", "Magnitude")
    rows = (deck.parent / "sweep" / "sweep.csv").read_text(encoding="utf-8").splitlines()
    assert rows[0].startswith("grid.dx,define.angle,exit_code,gauge.velocity_x:max [m/s],fragments[1].mass [kg]")
    assert len(rows) == 3 and "mean_gauge.velocity_x:mean [m/s]" in said["accuracy"]


def out_file(deck: Path) -> Callable[[str], Path]:
    """Names of files beside the deck."""
    return lambda name: deck.parent / name


def test_all_functions(deck: Path, results: scree.Run) -> None:
    """The functions of the package, with values that follow from the deck."""
    assert results.case == "every" and results.deck["run"]["title"].startswith("Stoß $v_0$")
    assert results.deck["grid"]["dx"] == 5.0e-4 and len(results.deck["body"]) == 4
    snap = scree.open(results.folder).snapshots[0]
    assert snap.bodies == ["ball+1.a", "brick_1", "brick_2", "brick_3"]
    ball = snap["velocity"][snap.body("ball+1.a")]
    np.testing.assert_allclose(ball, np.broadcast_to([500 * np.cos(np.pi / 6), 0.0, 250.0], ball.shape), rtol=1e-12)
    assert {*results.tables} >= {"history", "gauge", "mean_gauge", "forces", "fragments", "profile"}
    figures = [scree.plot.history(results, ["kinetic", "total"]), scree.plot.field(snap, "speed"),
               scree.plot.line(snap, "pressure", (0, 0, 0.004), (0.016, 0, 0.004), width=0.001),
               scree.picture(results, "body"), scree.radiograph(results).figure()]
    for figure in figures:
        figure.savefig(deck.parent / "figure.png")
    matplotlib.pyplot.close("all")
    with scree.Simulation(deck, outdir=deck.parent / "steps") as sim:
        assert sim.step(2) == 2
    found = scree.accuracy(deck, ["gauge.velocity_x", "front_x"], factors=(4, 2, 1), body="ball+1.a",
                           outdir=deck.parent / "found", progress=False)
    assert found.grid.spacing == 5.0e-4 and found.units["gauge.velocity_x"] == "m/s"
    assert found.causes and "'metal' fails by damage_model = 'johnson_cook' and spall without" in found.causes[0]
    table = scree.sweep(deck, "define.v", ["0.5 km/s", 1.0], "gauge.velocity_x",
                        outdir=deck.parent / "swept", set={"time.t_end": "0.1 us"}, progress=False)
    assert table["gauge.velocity_x"].iloc[1] == pytest.approx(2.0 * table["gauge.velocity_x"].iloc[0], rel=0.05)


@pytest.mark.parametrize(("name", "message"), [
    ("gauge.velocity", "did you mean 'gauge.velocity_"), ("fragments.mass", r"as in fragments\[1\].mass"),
    ("gauge[1].velocity_x", "one row for each time"), ("kinetic:often", "after the colon write"),
    ("kinetic:at=1s", "from 0 to t_end"), ("profile[1]", "there is no quantity"),
    ("front_x:max", "there is no quantity"), ("xhi_impulse_x", r"did you mean 'forces\.xhi_impulse_x'\?")])
def test_unknown_quantities(results: scree.Run, name: str, message: str) -> None:
    """Would catch a mistake in a name that gives a number, or a message that does not say what to write."""
    with pytest.raises(ScreeError, match=message):
        check(results, name)


def test_names_before_runs(deck: Path) -> None:
    """Would catch a study that makes runs before it refuses a name."""
    for study in (lambda: scree.accuracy(deck, "gauge.speed", factors=(4, 2, 1), outdir=deck.parent / "none",
                                         progress=False),
                  lambda: scree.sweep(deck, "grid.dx", [0.5, 1.0], "gauge.speed", outdir=deck.parent / "none",
                                      progress=False)):
        with pytest.raises(ScreeError, match=r"there is no quantity 'gauge\.speed'"):
            study()
    assert not list(deck.parent.glob("none/*"))
