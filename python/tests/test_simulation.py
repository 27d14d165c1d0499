# SPDX-License-Identifier: BSD-3-Clause
"""A simulation in the process of Python: the same bits as the program, views of fields, changes, errors, ranks."""

from __future__ import annotations

import ctypes
import importlib.util
import os
import shutil
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from conftest import DECK, LINE

import scree
from scree import launch, library
from scree.field_view import FieldView

try:
    library.find_library()
except scree.FileProblem as error:
    pytest.skip(str(error), allow_module_level=True)

ALL_OBJECTS = 0x1F       # H5F_OBJ_ALL: files, data sets, groups, types and attributes
# A block that flies, is compressed by a load, or hits walls that move.
BLOCK = """
&run       case = 'block'  dimension = '1d' /
&grid      lo = 0, 0, 0  hi = 1, 0.01, 0.01  dx = 0.01 /
&time      t_end = 0.02 /
&material  name = 'rubber'  density = 1000  young = 1e6  poisson = 0.3 /
&region    name = 'block'  shape = 'box'  lo = 0.4, 0, 0  hi = 0.6, 0.01, 0.01 /
&body      name = 'block'  region = 'block'  material = 'rubber'  ppc = 2, 1, 1  velocity = 1, 0, 0 /
"""


def simulate(folder: Path, deck: str = BLOCK, **options: Any) -> scree.Simulation:
    """Start a simulation in a folder."""
    return scree.Simulation(deck, outdir=folder, **options)


def test_the_same_bits_as_the_program(run: scree.Run, tmp_path: Path) -> None:
    """Would catch a run loop that differs from that of the program, missing files, steps that depend on the way they
    are requested, and results that depend on the position of particles in memory, which reading fields changes."""
    once = simulate(tmp_path / "once", DECK)
    assert once.run() == run.summary["steps"] and once.finished and once.time == once.end_time
    single = simulate(tmp_path / "single", DECK)
    while single.step():
        assert single.dt > 0.0
    cut = simulate(tmp_path / "cut", DECK)
    while cut.run(until=cut.time + 0.07e-6):
        assert cut.fields["velocity"].shape == (cut.count, 3)
    for sim in (once, single, cut):
        mine = sim.finish()
        for key in ("digest", "steps", "reason", "exit_code", "particles"):
            assert mine.summary[key] == run.summary[key]
        assert {path.name for path in mine.folder.iterdir()} - {"deck.nml"} == \
            {path.name for path in run.folder.iterdir()} - {"deck.nml"}
        assert mine.history["kinetic"].iloc[-1] == run.history["kinetic"].iloc[-1]
        assert sim.finish() is mine                      # a second call changes nothing


def test_two_at_the_same_time(run: scree.Run, tmp_path: Path) -> None:
    """Would catch state in module variables, with which one simulation would change another."""
    fine = scree.run(DECK, {"grid.dx": 0.5}, outdir=tmp_path / "program", progress=False)
    with simulate(tmp_path / "one", DECK) as one, simulate(tmp_path / "two", DECK, set={"grid.dx": 0.5}) as two:
        while one.step() + two.step(3):
            assert one.fields["velocity"].shape != two.fields["velocity"].shape
    assert one.finish().summary["digest"] == run.summary["digest"]
    assert two.finish().summary["digest"] == fine.summary["digest"] != run.summary["digest"]


def test_one_run_of_a_case_in_a_folder(tmp_path: Path) -> None:
    """Would catch two simulations that write the same files, and a lock that remains after the first one was closed."""
    first = simulate(tmp_path)
    ways: list[dict[str, Any]] = [{"overwrite": True}, {"restart": True}]
    for options in ways:
        with pytest.raises(scree.FileProblem, match=f"is in use by process {os.getpid()} on host"):
            simulate(tmp_path, **options)
    first.step()
    first.close()
    again = simulate(tmp_path, overwrite=True)
    again.finish()
    assert not list(tmp_path.glob("*.lock"))


def test_texts_that_are_no_names(tmp_path: Path) -> None:
    """Would catch a text of the caller that ends a line of a log, a script or a table."""
    texts: list[dict[str, Any]] = [{"case": "a\nb"}, {"case": "a b"}, {"case": "../a"}, {"case": "a\0b"},
                                   {"set": {"run.title": "a\tb"}}, {"set": {"material.name": "a/b"}}]
    for options in texts:
        with pytest.raises(scree.DeckError):
            simulate(tmp_path / "x", **options)
        with pytest.raises((scree.DeckError, ValueError)):
            scree.run(DECK, options.get("set"), case=options.get("case"), outdir=tmp_path / "y", progress=False)
    assert {path.name for path in tmp_path.rglob("*")} == {"x", "y", "deck.nml"}


def test_many_in_a_row(tmp_path: Path) -> None:
    """Would catch files, communicators and HDF5 objects that a simulation does not release: afterwards there are as
    many open files and objects as before, and one more simulation can create its communicator."""
    with simulate(tmp_path / "first") as sim:
        sim.step()
    open_files = len(os.listdir("/proc/self/fd"))
    count = library.load(library.find_library()).H5Fget_obj_count
    count.argtypes, count.restype = (ctypes.c_int64, ctypes.c_uint), ctypes.c_ssize_t
    objects = count(ALL_OBJECTS, ALL_OBJECTS)
    for number in range(30):
        sim = simulate(tmp_path / str(number % 3), overwrite=True)
        sim.step()
        if number % 2:
            sim.close()                                  # ends without a summary
        else:
            sim.finish()
    assert len(os.listdir("/proc/self/fd")) == open_files
    assert count(ALL_OBJECTS, ALL_OBJECTS) == objects


def test_fields_are_memory(tmp_path: Path) -> None:
    """Would catch copies instead of views, columns in a wrong order, and read-only fields that can be changed."""
    with simulate(tmp_path) as sim:
        fields = sim.fields
        assert fields.material == "rubber" and fields.units["stress"] == "Pa" and len(fields) == len(list(fields))
        assert fields["stress"].shape == (sim.count, 6) and sim.count == 40
        np.testing.assert_array_equal(np.sort(fields["identity"]), np.unique(fields["identity"]))
        assert fields["mass"].sum() == pytest.approx(0.2 * 0.01 * 0.01 * 1000)
        x = fields["position"][:, 0]
        assert x.min() == pytest.approx(0.4025) and x.max() == pytest.approx(0.5975)
        fields["velocity"][:, 0] = 2.0                   # in another view of the same memory
        fields["velocity"] *= 1.5
        assert set(fields["velocity"][:, 0]) == {3.0}
        fields["velocity"] = np.full((sim.count, 3), (4.0, 0.0, 0.0))
        for name in set(fields) - fields.writable:
            with pytest.raises(ValueError, match="read-only"):
                fields[name][0] = 0
        assert {"position", "mass", "identity"} <= set(fields) - fields.writable
        with pytest.raises(KeyError, match="did you mean 'velocity'"):
            _ = fields["velocty"]
        sim.step()
        assert fields["position"][:, 0].mean() == pytest.approx(0.5 + 4.0 * sim.dt, rel=1e-12)


def test_stale_views(tmp_path: Path) -> None:
    """Would catch a view that is used after its memory was released or has another content."""
    sim = simulate(tmp_path)
    view = sim.fields["velocity"]
    column, chosen, copy = view[:, 0], view[view[:, 0] > 0.0], view.copy()
    result = view + 0.0
    assert isinstance(column, FieldView) and not isinstance(chosen, FieldView) and not isinstance(result, FieldView)
    assert np.concatenate([view, view]).shape == (80, 3) and "FieldView" in repr(view)
    sim.write_output()
    assert view[0, 0] == 1.0                             # output does not move particles in memory
    sim.step()
    uses: list[Any] = [
        lambda: view[0], lambda: column[0], lambda: view.sum(), lambda: column * 2.0, lambda: np.sin(view),
        lambda: np.add(1.0, view), lambda: view.__setitem__(0, 0.0), lambda: np.add(copy, 1.0, out=view),
        lambda: np.concatenate([copy, view]), lambda: np.where(True, 0.0, view), lambda: str(view), lambda: view.T,
        lambda: copy.__setitem__(slice(None), view), lambda: list(view)]
    for use in uses:
        with pytest.raises(scree.StaleView, match="get a new view"):
            use()
    assert chosen.sum() == result[:, 0].sum() == 40.0 == copy[:, 0].sum()
    last = sim.fields["velocity"]
    sim.finish()
    with pytest.raises(scree.StaleView):
        last.sum()
    with pytest.raises(scree.DeckError, match="closed"):
        _ = sim.fields["velocity"]


def test_law_of_a_script(tmp_path: Path) -> None:
    """Would catch changes that have no effect on the next step: velocities that decay, compared with the closed
    form."""
    with simulate(tmp_path) as sim:
        while sim.step():
            sim.fields["velocity"] *= np.exp(-100.0 * sim.dt)
        assert np.allclose(sim.fields["velocity"][:, 0], np.exp(-100.0 * 0.02), rtol=1e-9) and sim.steps > 50


def test_gravity_is_steered(tmp_path: Path) -> None:
    """Would catch a change without an effect, and one along a direction that the scene does not have."""
    with simulate(tmp_path, set={"effects.gravity": True, "effects.gravity_vector": (0, 0, 0)}) as sim:
        assert list(sim.controls) == ["gravity"] and list(sim.controls["gravity"]) == [0, 0, 0]
        sim.run(until=0.01)
        before = sim.time
        sim.controls["gravity"] = (-50.0, 0.0, 7.0)
        assert list(sim.controls["gravity"]) == [-50.0, 0.0, 0.0]
        sim.run()
        # velocities are half a step behind the time
        assert sim.fields["velocity"][:, 0].mean() == pytest.approx(1 - 50 * (sim.time - before), abs=50 * sim.next_dt)


def test_walls_are_steered(tmp_path: Path) -> None:
    """Would catch a rigid region whose position jumps together with its velocity: it must push the block from its
    present position."""
    piston = BLOCK + "&region name = 'piston'  shape = 'box'  lo = -1, -1, -1  hi = 0.36, 1, 1 /\n" \
        "&boundary region = 'piston'  type = 'velocity'  velocity = 1, 0, 0 /\n"
    with simulate(tmp_path, piston, set={"time.t_end": 0.04}) as sim:
        assert list(sim.controls) == ["piston"] and list(sim.controls["piston"]) == [1.0, 0.0, 0.0]
        sim.run(until=0.02)
        sim.controls["piston"] = 8.0, 0, 0
        assert sim.controls["piston"][0] == 1.0          # the change takes effect from this time on
        sim.step()
        assert sim.controls["piston"][0] == pytest.approx(8.0)
        left = sim.fields["position"][:, 0].min()
        assert left == pytest.approx(0.4025 + sim.time, abs=1e-4)  # no contact yet: the block moves as before
        sim.run()
        reached = 0.36 + 0.02 + 8.0 * 0.02               # it would be 0.68 if the whole displacement were at 8 m/s
        assert reached - 0.01 < sim.fields["position"][:, 0].min() < reached + 0.05


def test_loads_are_steered(tmp_path: Path) -> None:
    """Would catch a factor without an effect on the load: the pressure on the whole block must be constant, doubled, or
    zero."""
    pressed = BLOCK + "&load  pressure = 1e3 /\n"
    stress = {}
    for factor in (0.0, 1.0, 2.0):
        with simulate(tmp_path / str(factor), pressed, set={"time.t_end": 0.01, "effects.damping": 500}) as sim:
            assert sim.controls["load[1]"] == 1.0
            sim.step()
            sim.controls["load[1]"] = factor
            sim.run()
            assert sim.controls["load[1]"] == factor
            stress[factor] = sim.fields["stress"][:, 0].mean()
    assert stress[2.0] == pytest.approx(2.0 * stress[1.0], rel=0.05) and stress[1.0] < -500.0
    assert abs(stress[0.0]) < 0.1 * abs(stress[1.0])


def test_wrong_controls(tmp_path: Path) -> None:
    """Would catch an unknown control, or a value of a wrong shape or a value that is not finite, that is accepted."""
    with simulate(tmp_path, set={"effects.gravity": True}) as sim:
        with pytest.raises(KeyError, match="did you mean 'gravity'"):
            sim.controls["gravty"] = 0, 0, 0
        with pytest.raises(ValueError, match="3 components"):
            sim.controls["gravity"] = 1.0
        with pytest.raises(scree.DeckError, match="not finite"):
            sim.controls["gravity"] = 0, 0, float("nan")


def test_several_stores(tmp_path: Path) -> None:
    """Would catch materials that are confused, and fields of one material that are returned for all."""
    deck = DECK.replace("&region  name = 'left'", "&material  name = 'iron'  density = 7.8  bulk = 160  shear = 80 /\n"
                        "&region  name = 'left'").replace("'right'  material = 'copper'", "'right'  material = 'iron'")
    with simulate(tmp_path, deck) as sim:
        assert [store.material for store in sim.stores] == ["copper", "iron"]
        assert [store["velocity"][:, 0].mean() for store in sim.stores] == pytest.approx([1000.0, 0.0])
        assert sum(len(store["mass"]) for store in sim.stores) == sim.count
        with pytest.raises(KeyError, match="those of copper, iron"):
            _ = sim.fields


def test_errors_by_exit_code(deck: Path, run: scree.Run, tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    """Would catch an error that ends the process, prints text, or leaves a simulation half initialised."""
    for options in ({"set": {"grid.dy": 1}}, {"options": ["--check"]}, {"options": ["--colour"]}):
        with pytest.raises(scree.DeckError) as wrong:
            scree.Simulation(deck, outdir=tmp_path / "never", **options)
        assert wrong.value.code == 2 and wrong.value.messages
    with pytest.raises(scree.FileProblem, match="overwrite=True"):
        scree.Simulation(deck, outdir=run.folder)
    with pytest.raises(scree.FileProblem, match=r"missing\.nml"):
        scree.Simulation(tmp_path / "missing.nml")
    assert not (tmp_path / "never").exists()
    sim = simulate(tmp_path / "broken")
    sim.step()
    sim.fields["velocity"][3] = 1.0e300                  # finite, but it moves nodes out of bounds
    with pytest.raises(scree.PhysicsError):
        sim.run()
    assert sim.finished and sim.step() == 0
    with pytest.raises(scree.DeckError, match="has ended"):
        sim.finish()
    summary = scree.open(tmp_path / "broken").summary
    assert summary["exit_code"] == 4 and summary["steps"] >= 1
    assert capfd.readouterr() == ("", "")                # no warnings on the screen either


def test_screen(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    """Would catch output that was not requested, and missing output that was."""
    simulate(tmp_path / "quiet").finish()
    assert capfd.readouterr() == ("", "")
    simulate(tmp_path / "loud", quiet=False).finish()
    assert "ended     ended by the calling program" in capfd.readouterr().out


def test_end_before_the_end(tmp_path: Path) -> None:
    """Would catch a run without a summary, or one with a summary after an exception."""
    with simulate(tmp_path / "cut") as sim:
        sim.step(5)
    cut = sim.finish()
    assert (cut.summary["steps"], cut.summary["reason"]) == (5, "ended by the calling program")
    assert cut.snapshots.times[-1] == sim.time
    with pytest.raises(ZeroDivisionError), simulate(tmp_path / "failed") as sim:
        sim.step(1 // 0)
    assert not list((tmp_path / "failed").glob("*.summary.json"))


def test_output_and_checkpoints(bar: scree.Run, tmp_path: Path) -> None:
    """Would catch requested files that are missing, and a checkpoint from which a run ends differently."""
    sim = simulate(tmp_path, LINE)
    sim.step(10)
    sim.write_output()
    sim.write_checkpoint()
    assert list(tmp_path.glob("bar_chk_*.h5")) and sim.time in scree.open(tmp_path).snapshots.times
    sim.step(10)
    sim.close()
    again = simulate(tmp_path, LINE, restart=True)
    assert again.steps == 10
    again.run()
    assert again.finish().summary["digest"] == bar.summary["digest"]


def test_limits_of_the_deck(tmp_path: Path) -> None:
    """Would catch a run that is stopped with a checkpoint and counts as complete."""
    sim = simulate(tmp_path, set={"time.wall_limit": "00:00:01"})
    time.sleep(1.1)
    assert sim.run() < 5 and sim.finished
    with pytest.raises(scree.Interrupted, match="checkpoint"):
        sim.finish()
    assert list(tmp_path.glob("block_chk_*.h5"))


def test_library_is_found(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Would catch a library of another installation than that of the program, and an error without advice."""
    found = Path(library.find_library())
    assert found.parents[1] == Path(scree.find_program()).resolve().parents[1]
    monkeypatch.setenv("SCREE_LIBRARY", str(tmp_path / "none.so"))
    with pytest.raises(scree.FileProblem, match=r"no library .*none\.so"):
        library.find_library()
    other = tmp_path / "other.so"
    other.write_text("no library", encoding="utf-8")
    with pytest.raises(scree.FileProblem, match="cannot use"):
        library.load(str(other))


RANKS = """
import sys
from mpi4py import MPI
import scree
mine = MPI.COMM_SELF if sys.argv[1] == "self" else MPI.COMM_WORLD
outdir = f"{sys.argv[2]}{MPI.COMM_WORLD.rank if mine is MPI.COMM_SELF else ''}"
with scree.Simulation(open(sys.argv[3]).read(), outdir=outdir, comm=mine) as sim:
    while sim.step():
        assert len(sim.fields["velocity"]) == sim.count
        sim.fields["velocity"] *= 1.0
assert mine.allreduce(sim.count) == 72 and sim.ranks == mine.size
"""


@pytest.mark.skipif(not importlib.util.find_spec("mpi4py"), reason="mpi4py is not installed")
@pytest.mark.parametrize("group", ["world", "self"])
def test_ranks_of_mpi4py(group: str, run: scree.Run, deck: Path, tmp_path: Path) -> None:
    """Would catch a communicator that is not used or not copied, and bits that depend on the number of ranks."""
    mpiexec = shutil.which("mpiexec")
    assert mpiexec
    script = tmp_path / "script.py"
    script.write_text(RANKS, encoding="utf-8")
    source = str(Path(scree.__file__).parents[1])
    answer = subprocess.run([mpiexec, "-n", "2", sys.executable, script, group, tmp_path / "out", deck], text=True,
                            capture_output=True, timeout=120, check=False,
                            env={**os.environ, **launch.OPEN_MPI, "PYTHONPATH": source, "OMP_NUM_THREADS": "1"})
    assert answer.returncode == 0, answer.stderr
    folders = ["out"] if group == "world" else ["out0", "out1"]
    for folder in folders:
        summary = scree.open(tmp_path / folder).summary
        assert summary["digest"] == run.summary["digest"] and summary["ranks"] == 2 // len(folders)
