# SPDX-License-Identifier: BSD-3-Clause
"""Misuse of the Python package: each row of the tables is a mistake of a caller and the exception that answers it.

The rows of a table run one after another in a process of their own, which has to survive them. Would catch a double
free, a read of memory that was released, a deadlock of two threads, a child process that finishes the MPI of its
parent, and mistakes that are accepted or answered by an error inside of the package.
"""
from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

HEAD = r'''
import contextlib, copy, ctypes, gc, multiprocessing, operator, os, pickle, sys, threading
import numpy as np
import scree
from scree import library as binding
BAR = """
&run case = 'bar'  dimension = '1d' /
&grid lo = 0, 0, 0  hi = 1, 0.01, 0.01  dx = 0.01 /
&time t_end = 1 /
&effects gravity = .true. /
&material name = 'rubber'  density = 1000  young = 1e6  poisson = 0.3 /
&region name = 'block'  shape = 'box'  lo = 0.4, 0, 0  hi = 0.6, 0.01, 0.01 /
&body name = 'block'  region = 'block'  material = 'rubber'  ppc = 2, 1, 1  velocity = 1, 0, 0 /
&output name = 'h'  kind = 'history'  every = 1 /
"""
number = 0
def start(**options):
    global number
    number += 1
    return scree.Simulation(BAR, outdir=f"{sys.argv[1]}/{number}", **options)
sim = start()
velocity = sim.fields["velocity"]
closed = start(); left = closed.fields["velocity"]; raw = np.asarray(left); window = memoryview(left); closed.close()
stepped = start(); old = np.asarray(stepped.fields["velocity"]); stepped.step(3)
library = sim._library
def code(name, *arguments):
    answer = getattr(library, name)(*arguments)
    if answer: raise RuntimeError(f"exit code {answer}")
def in_thread(work):
    failed = []
    def inner():
        try: work()
        except Exception as error: failed.append(error)
    threads = [threading.Thread(target=inner) for _ in range(4)]
    for thread in threads: thread.start()
    for thread in threads: thread.join()
    if failed: raise failed[0]
def in_child(work, leave=os._exit):
    """Runs the work in a forked child, and raises RuntimeError with the name of its exception."""
    reader, writer = os.pipe()
    child = os.fork()
    if child == 0:
        name = ""
        try: work()
        except BaseException as error: name = type(error).__name__
        os.write(writer, name.encode()); os.close(writer)
        leave(0)
    os.close(writer)
    name = os.read(reader, 100).decode()
    status = os.waitpid(child, 0)[1]
    if status: raise RuntimeError(f"the child ended with status {status}")
    if name: raise {"DeckError": scree.DeckError}[name]("in the child")
'''
TABLES: dict[str, tuple[tuple[str, str], ...]] = {
    "copies": (
        ("copy.copy(sim)", "TypeError"), ("copy.deepcopy(sim)", "TypeError"), ("pickle.dumps(sim)", "TypeError"),
        ("copy.deepcopy(sim.fields)", "TypeError"), ("pickle.dumps(sim.controls)", "TypeError"),
        ("copy.copy(sim.fields)['velocity'][0, 0]", ""), ("copy.deepcopy(velocity)[0, 0]", ""),
        ("pickle.loads(pickle.dumps(velocity))[0, 0]", ""), ("sim.__init__(BAR, outdir='x')", "DeckError"),
        ("scree.Simulation.__new__(scree.Simulation).step()", "AttributeError"),
        ("scree.Simulation.__new__(scree.Simulation).close()", ""),
        ("multiprocessing.get_context('spawn').Process(target=print, args=(sim,)).start()", "TypeError")),
    "after the end": (
        ("closed.close()", ""), ("closed.close(); closed.close()", ""), ("closed.step()", ""),
        ("closed.run()", ""), ("closed.fields['velocity']", "DeckError"), ("closed.write_output()", "DeckError"),
        ("closed.write_checkpoint()", "DeckError"), ("closed.controls['gravity']", "DeckError"),
        ("closed.controls['gravity'] = 0, 0, 0", "DeckError"), ("closed.finish()", "DeckError"),
        ("left[0, 0]", "StaleView"), ("left[:] = 0", "StaleView"), ("left.sum()", "StaleView"),
        ("np.add(1, left)", "StaleView"), ("raw.sum(), raw.fill(3.0)", ""), ("window.tobytes()", ""),
        ("memoryview(left).tobytes()", ""), ("np.asarray(left).sum()", ""), ("old.fill(7.0); stepped.step(3)", ""),
        ("old.sum()", ""), ("closed.__enter__().step()", ""), ("repr(closed), closed.time, closed.count", ""),
        ("closed.__del__()", ""), ("stepped.finish(); stepped.finish()", ""), ("stepped.step()", ""),
        ("stepped.write_output()", "DeckError")),
    "handles": (
        ("code('scree_step', None, 1, 1.0)", "RuntimeError"),
        ("code('scree_step', ctypes.c_void_p(1), 1, 1.0)", "RuntimeError"),
        ("code('scree_step', ctypes.c_void_p(123456789), 1, 1.0)", "RuntimeError"),
        ("code('scree_close', None)", "RuntimeError"),
        ("block = ctypes.create_string_buffer(4096); code('scree_close', ctypes.c_void_p(ctypes.addressof(block)))",
         "RuntimeError"),
        ("block = ctypes.create_string_buffer(ctypes.string_at(sim._handle.value, 64)); "
         "code('scree_close', ctypes.c_void_p(ctypes.addressof(block)))", "RuntimeError"),
        ("one = start(); handle = ctypes.c_void_p(one._handle.value); one.close(); code('scree_close', handle)",
         "RuntimeError"),
        ("one = start(); handle = ctypes.c_void_p(one._handle.value); one.close(); code('scree_step', handle, 1, 1.0)",
         "RuntimeError"),
        ("one = start(); library.scree_close(one._handle); one.step()", "InternalError"),
        ("assert library.scree_text(None, 0, 0) is None", ""),
        ("assert library.scree_text(sim._handle, 99, 99) == b''", ""),
        ("code('scree_field', sim._handle, 99, b'velocity', ctypes.byref(binding.Memory()))", "RuntimeError"),
        ("code('scree_field', sim._handle, 0, b'', ctypes.byref(binding.Memory()))", "RuntimeError")),
    "threads and processes": (
        ("in_thread(lambda: sim.step(5))", ""),
        ("in_thread(lambda: sim.fields['velocity'].sum())", "StaleView or none"),
        ("in_thread(lambda: [sim.step(), np.asarray(sim.fields['stress']).sum()])", ""),
        ("one = start(); in_thread(one.close)", ""), ("in_thread(lambda: start().run(until=0.001))", ""),
        ("one = start(); threads = [threading.Thread(target=work) for work in (lambda: one.step(50), one.close)]; "
         "[thread.start() for thread in threads]; [thread.join() for thread in threads]", ""),
        ("one = start(); one.loop = one; del one; gc.collect()", ""),
        ("in_child(lambda: sim.step())", "DeckError"), ("in_child(lambda: sim.fields['velocity'])", "DeckError"),
        ("in_child(sim.finish)", "DeckError"), ("in_child(sim.close)", ""), ("in_child(lambda: velocity.sum())", "any"),
        ("in_child(gc.collect)", ""), ("in_child(lambda: None, sys.exit)", "SystemExit or none"),
        ("sim.step()", "")),
    "values": (
        ("sim.fields['velocity'] = np.zeros((3, 3))", "ValueError"), ("sim.fields['velocity'] = 'fast'", "ValueError"),
        ("sim.fields['velocity'] = None", ""), ("sim.step()", "ValueError"),
        ("sim.fields['velocity'] = 0.0; sim.step()", ""),
        ("sim.fields['velocity'][3] = np.nan; sim.step()", "ValueError"),
        ("sim.fields['velocity'][3] = 1j", "TypeError"), ("sim.fields['velocity'] = [[1, 2], [3]]", "ValueError"),
        ("sim.fields['velocity'][999, 0] = 1", "IndexError"), ("sim.fields['velocity'][3] = 0; sim.step()", ""),
        ("sim.fields['position'] = 5.0", "ValueError"), ("sim.fields['position'].flags.writeable = True", "ValueError"),
        ("sim.fields['identity'][:] = -1", "ValueError"), ("sim.fields['none']", "KeyError"),
        ("sim.fields[0]", "KeyError"), ("sim.fields[[]]", "TypeError"),
        ("del sim.fields['velocity']", "AttributeError"),
        ("sim.controls['gravity'] = 1", "ValueError"), ("sim.controls['gravity'] = np.nan, 0, 0", "DeckError"),
        ("sim.controls['gravity'] = 'down'", "ValueError"), ("sim.controls['gravity'] = 0, 0, -9, 1", "ValueError"),
        ("sim.controls['moon']", "KeyError"), ("sim.step(1.5)", "TypeError"), ("sim.step('all')", "TypeError"),
        ("sim.step(-5)", ""), ("sim.run(until=np.nan)", "ValueError"), ("sim.run(until='end')", "TypeError"),
        ("sim.run(until=-1)", ""), ("sim.time = 3", "AttributeError"), ("sim.fields = {}", "AttributeError"),
        ("sim.fields['velocity'].resize((0, 3))", "ValueError"), ("sim.fields['velocity'].setflags(write=False)", ""),
        ("sim.fields['velocity'] = 1e300; sim.step()", "PhysicsError")),
    "arguments": (
        ("start(comm=5)", "AttributeError"), ("start(library='/bin/true')", "FileProblem"),
        ("start(library=sys.executable)", "FileProblem"), ("start(options=['--check'])", "DeckError"),
        ("start(options=['--echo'])", "DeckError"), ("start(options=['--help'])", "DeckError"),
        ("start(options=['a\\0b'])", "DeckError"), ("start(set={'grid.dx': 'x'})", "DeckError"),
        ("start(set={'grid.dx': np.nan})", "DeckError"), ("start(set={'grid.dx': 1e-300})", "DeckError"),
        ("scree.Simulation('none.nml')", "FileProblem"), ("scree.Simulation(BAR)", "ValueError"),
        ("scree.Simulation(sys.argv[1])", "FileProblem"), ("scree.Simulation(7)", "TypeError"),
        ("scree.Simulation(BAR, outdir='/proc/none')", "FileProblem"),
        ("scree.run(BAR, outdir=sys.argv[1] + '/a', ranks=0)", "ValueError"),
        ("scree.sweep(BAR, 'grid.dx', [0.02], lambda run: 1 / 0, outdir=sys.argv[1] + '/b', progress=False)",
         "ZeroDivisionError"),
        ("scree.sweep(BAR, 'grid.dx', [0.02], 'gauge.velocity', outdir=sys.argv[1] + '/c', progress=False)",
         "ScreeError"),
        ("scree.accuracy(BAR, lambda run: {}[1], set={'time.t_end': 1e-3}, outdir=sys.argv[1] + '/d', progress=False)",
         "KeyError"),
        ("scree.open(sys.argv[1] + '/none')", "FileProblem")),
}


def test_number_of_mistakes() -> None:
    """Would catch tables that have become empty."""
    assert sum(map(len, TABLES.values())) >= 61


@pytest.mark.parametrize("name", TABLES)
def test_no_mistake_ends_the_process(tmp_path: Path, name: str) -> None:
    """The exception of each mistake, in a process that survives all of them."""
    lines = [HEAD]
    for place, (mistake, _) in enumerate(TABLES[name]):
        lines.append(f"try: exec({mistake!r}); print({place}, '', flush=True)\n"
                     f"except Exception as error: print({place}, type(error).__name__, flush=True)")
    lines.append("print('end', flush=True)")
    answer = subprocess.run([sys.executable, "-c", "\n".join(lines), str(tmp_path)], text=True, timeout=60, check=False,
                            capture_output=True, cwd=tmp_path, env={**os.environ, "OMP_NUM_THREADS": "2"})
    said = dict(line.split(" ", 1) for line in answer.stdout.splitlines() if line[:1].isdigit())
    for place, (mistake, expected) in enumerate(TABLES[name]):
        assert str(place) in said, f"{mistake} ended the process: {answer.returncode}, {answer.stderr[-2000:]}"
        if expected != "any":
            allowed = expected.replace("none", "").split(" or ")
            assert said[str(place)] in allowed, f"{mistake} raised {said[str(place)]}"
    assert answer.returncode == 0 and answer.stdout.endswith("end\n"), answer.stderr[-2000:]
