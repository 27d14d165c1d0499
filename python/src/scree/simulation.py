# SPDX-License-Identifier: BSD-3-Clause
"""A simulation in the process of Python: step by step, with direct access to fields and changes between steps."""
from __future__ import annotations

import atexit
import ctypes
import math
import operator
import os
from collections.abc import Iterable, Iterator, Mapping, Sequence
from types import TracebackType
from typing import Any

import numpy as np

from . import library as binding
from .errors import DeckError, decoded, error_of_run, nearest
from .field_view import FieldView, view_of
from .launch import deck_file, options_of
from .results import Run

_ALL = 2**62                                             # more steps than a run has


class Fields(Mapping[str, FieldView]):
    """Fields of the particles of one material on this rank, by name.

    `fields["velocity"]` is an array (n, 3), valid until the next step, which uses the values written into it.
    `fields["velocity"] = values` changes the field. Identities, positions and masses are read-only. All values are in
    SI.
    """

    def __init__(self, simulation: Simulation, index: int) -> None:
        self._simulation, self._index = simulation, index
        self.material = simulation._text(binding.TEXT_STORE, index)
        lines = [line.split() for line in simulation._text(binding.TEXT_FIELDS, index).splitlines()]
        self.units = {line[0]: line[1] for line in lines}
        self.writable = frozenset(line[0] for line in lines if line[4] == "1")

    def __repr__(self) -> str:
        return f"<scree fields of {self.material}: {', '.join(self)}>"

    def __getitem__(self, name: str) -> FieldView:
        if name not in self.units:
            raise KeyError(f"no field '{name}' of {self.material}{nearest(name, self.units)}")
        return self._simulation._field(self._index, name)

    def __setitem__(self, name: str, values: Any) -> None:
        view = self[name]
        if not (isinstance(values, FieldView) and values.shape == view.shape and np.may_share_memory(values, view)):
            view[...] = values

    def __contains__(self, name: object) -> bool:
        return name in self.units

    def __iter__(self) -> Iterator[str]:
        return iter(self.units)

    def __len__(self) -> int:
        return len(self.units)


class Controls(Mapping[str, Any]):
    """Quantities that may be changed between steps, by name: velocities (3) of boundaries that move and of rigid
    regions [m/s], factors of loads, constant gravity (3) [m/s2].

    `controls["piston"] = 0, 0, -2` takes effect linearly over the next step. All ranks must set the same value.
    """

    def __init__(self, simulation: Simulation) -> None:
        self._simulation = simulation
        lines = [line.rsplit(" ", 1) for line in simulation._text(binding.TEXT_CONTROLS).splitlines()]
        self._components = {name: int(number) for name, number in lines}

    def __repr__(self) -> str:
        return f"<scree controls: {', '.join(self) or 'none'}>"

    def _count(self, name: str) -> int:
        if name not in self._components:
            raise KeyError(f"no control '{name}'{nearest(name, self._components)}")
        return self._components[name]

    def __getitem__(self, name: str) -> Any:
        count = self._count(name)
        values = (ctypes.c_double * 3)()
        self._simulation._call("scree_control", name.encode(), values)
        return values[0] if count == 1 else np.array(values)

    def __setitem__(self, name: str, value: Any) -> None:
        count = self._count(name)
        numbers = np.atleast_1d(np.asarray(value, dtype=float))
        if numbers.shape != (count,):
            raise ValueError(f"the control '{name}' has {count} components, not {value!r}")
        self._simulation._call("scree_steer", name.encode(), (ctypes.c_double * 3)(*numbers))

    def __iter__(self) -> Iterator[str]:
        return iter(self._components)

    def __len__(self) -> int:
        return len(self._components)


class Simulation:
    """A run in this process, step by step.

        with scree.Simulation("scene.nml", outdir="out/scene") as sim:
            while sim.step(10):
                sim.fields["velocity"] *= 0.999
        run = sim.finish()

    deck       a file, or the text of a deck, which is written to OUTDIR/deck.nml
    set        values of keys, such as {"grid.dx": 0.5}
    outdir     folder of the results, out/CASE by default
    case       prefix of the files, by default as the deck says
    comm       communicator of mpi4py whose ranks share the run; by default all ranks that mpirun has started
    restart    continue from the newest checkpoint
    overwrite  remove the results of an earlier run of this case
    quiet      print nothing; the log is written in any case
    options    further options of the program
    library    the file of libscree, by default that beside the program

    All functions that change the run are called by all ranks. Errors are those of scree.run. A simulation cannot be
    copied, pickled, or used in a child process that was forked.
    """

    _handle: ctypes.c_void_p | None = None               # None also if the constructor has failed

    def __init__(self, deck: str | os.PathLike[str], set: Mapping[str, Any] | None = None, *,
                 outdir: str | os.PathLike[str] | None = None, case: str | None = None, comm: Any = None,
                 restart: bool = False, overwrite: bool = False, quiet: bool = True, options: Iterable[str] = (),
                 library: str | os.PathLike[str] | None = None) -> None:
        if self._handle is not None:
            raise DeckError("this simulation is open; create another one")
        self._process = os.getpid()
        self._arrays: dict[tuple[int, str], np.ndarray[Any, Any]] = {}     # requested since the last step
        self._shown = 0                                  # their generation
        self._state = binding.State()
        self._run: Run | None = None
        self._library = binding.load(binding.find_library(library))
        words = [*options_of(set or {}, case, outdir), *options]
        words += ["--quiet"] * quiet + ["--restart"] * restart + ["--overwrite"] * overwrite
        words += ["--", os.fspath(_place_deck(deck, outdir, overwrite, comm))]
        if any("\0" in str(word) for word in words):
            raise DeckError("an option holds a null character")
        if comm is not None and comm.Is_inter():
            raise DeckError("comm is an intercommunicator; a run needs the ranks of one group")
        self._open(words, comm)
        self.stores: Sequence[Fields] = tuple(Fields(self, index) for index in range(self._state.stores))
        self.controls = Controls(self)

    def _open(self, words: list[str], comm: Any) -> None:
        """Start the run; after an error all resources are released."""
        handle = ctypes.c_void_p()
        letters = b"".join(os.fsencode(word) + b"\0" for word in words)
        with binding.LOCK:
            code = self._library.scree_open(letters, len(words), int(comm is not None),
                                            0 if comm is None else comm.py2f(), ctypes.byref(handle))
        self._handle = handle
        self._update()
        if self._state.began_messages:
            _end_messages_at_exit(self._library)
        self.folder, self.case = self._text(binding.TEXT_FOLDER), self._text(binding.TEXT_CASE)
        if code:
            error = self._error(code)
            self.close()
            raise error

    def _call(self, name: str, *arguments: Any) -> None:
        """Call a function of the library; an exit code other than 0 raises an error."""
        with binding.LOCK:
            code = getattr(self._library, name)(self._open_handle(), *arguments)
            self._update()
            if code:
                raise self._error(code)

    def _open_handle(self) -> ctypes.c_void_p:
        """The handle of a simulation that is open in this process."""
        if self._handle is None:
            raise DeckError("the simulation is closed; create a new one")
        if self._process != os.getpid():
            raise DeckError("this process was forked from that of the simulation, whose threads and files it lacks; "
                            "call the simulation in its own process, or start the child with the method 'spawn'")
        return self._handle

    def _error(self, code: int) -> Exception:
        """The error of an exit code, with the message of the library."""
        return error_of_run(code, self._text(binding.TEXT_MESSAGE).splitlines(), self.folder)

    def _update(self) -> None:
        with binding.LOCK:
            self._library.scree_state(self._handle, ctypes.byref(self._state))

    def _text(self, what: int, index: int = 0) -> str:
        with binding.LOCK:
            text: bytes | None = self._library.scree_text(self._open_handle(), what, index)
        return decoded(text or b"")

    def _memory(self, index: int, name: str) -> tuple[np.ndarray[Any, Any], bool]:
        """The memory of a field in the simulation, and whether it may be changed. It is valid until the next call."""
        memory = binding.Memory()
        self._call("scree_field", index, name.encode(), ctypes.byref(memory))
        shape = (memory.particles,) if memory.components == 1 else (memory.particles, memory.components)
        kind = np.int64 if memory.whole else np.float64
        if not memory.particles:
            return np.zeros(shape, kind), bool(memory.writable)
        words = (memory.components - 1) * memory.stride + memory.particles
        buffer = (ctypes.c_char * (8 * words)).from_address(memory.address)
        return np.ndarray(shape, kind, buffer, strides=(8, 8 * memory.stride)[:len(shape)]), bool(memory.writable)

    def _field(self, index: int, name: str) -> FieldView:
        """The array of a field, whose memory belongs to Python, so that no use of it can harm the process."""
        with binding.LOCK:
            self._open_handle()
            if (index, name) not in self._arrays:
                memory, writable = self._memory(index, name)
                own = memory.copy(order="F")
                own.flags.writeable = writable
                self._arrays[index, name] = own
            return view_of(self._arrays[index, name], self)

    def _return_fields(self) -> None:
        """Give the arrays that were requested since the last step to the simulation."""
        for (index, name), values in self._arrays.items():
            if not values.flags.writeable:
                continue
            memory, _ = self._memory(index, name)
            wrong = ~np.isfinite(values) & (values != memory)
            if wrong.any():
                row = int(np.argwhere(wrong)[0][0])
                raise ValueError(f"the field '{name}' of {self.stores[index].material} was set to {values[row]} in row "
                                 f"{row}; {int(wrong.sum())} of its numbers are not finite and must be set again")
            memory[...] = values

    def _change(self, name: str, *arguments: Any) -> None:
        """Call a function that uses or changes the state, with the fields as they were changed in Python."""
        with binding.LOCK:
            self._open_handle()
            self._return_fields()
            try:
                self._call(name, *arguments)
            finally:
                if self.generation != self._shown:
                    self._arrays, self._shown = {}, self.generation

    @property
    def fields(self) -> Fields:
        """Fields of the particles, of a run with one store; runs with several have `stores`, one for each material or,
        with contact, for each body."""
        if len(self.stores) != 1:
            raise KeyError("this simulation has several particle stores; use simulation.stores[k], which are those of "
                           + ", ".join(store.material for store in self.stores))
        return self.stores[0]

    @property
    def time(self) -> float:
        """Simulated time [s]."""
        return float(self._state.time)

    @property
    def end_time(self) -> float:
        """Time at which the run ends [s]."""
        return float(self._state.time_end)

    @property
    def dt(self) -> float:
        """The last time step [s]."""
        return float(self._state.dt)

    @property
    def next_dt(self) -> float:
        """The next stable time step [s]."""
        return float(self._state.dt_next)

    @property
    def steps(self) -> int:
        """Steps done."""
        return int(self._state.step)

    @property
    def count(self) -> int:
        """Particles of this rank."""
        return int(self._state.particles)

    @property
    def rank(self) -> int:
        """This rank, from 0."""
        return int(self._state.rank)

    @property
    def ranks(self) -> int:
        """Number of ranks."""
        return int(self._state.ranks)

    @property
    def warnings(self) -> int:
        """Warnings in the log so far."""
        return int(self._state.warnings)

    @property
    def generation(self) -> int:
        """Changes whenever views of fields become invalid."""
        return int(self._state.generation)

    @property
    def finished(self) -> bool:
        """True if no step is left: the end of the run, a limit or an error has been reached."""
        return bool(self._state.finished) or not self._state.running

    def step(self, count: int = 1) -> int:
        """Do some steps, fewer at the end of the run; returns how many were done."""
        return self._advance(count, math.inf)

    def run(self, until: float | None = None) -> int:
        """Do steps until the time is at least `until` [s], by default to the end; returns how many were done.

        A step is not shortened to end at this time, so results do not depend on how steps are called.
        """
        return self._advance(_ALL, math.inf if until is None else until)

    def _advance(self, count: int, until: float) -> int:
        """Do steps one by one, so that an interrupt by the keyboard can be handled between two of them."""
        before, last = self.steps, self.steps + operator.index(count)
        if math.isnan(until):
            raise ValueError("until is NaN; write a time in s")
        while not self._state.finished and self.steps < last and self.time < until:
            self._change("scree_step", 1, until)
        return self.steps - before

    def write_output(self) -> None:
        """Write the present state to all output streams; outputs due later do not change."""
        self._change("scree_output")

    def write_checkpoint(self) -> None:
        """Write a checkpoint of the present state."""
        self._change("scree_checkpoint")

    def finish(self) -> Run:
        """End the run here: last output and summary. Returns its results."""
        if self._run is None:
            try:
                self._change("scree_finish")
            finally:
                if self._handle is not None and not self._state.running:
                    self.close()
            self._run = Run(self.folder, self.case)
        return self._run

    def close(self) -> None:
        """Release memory and files. An unfinished run gets no summary."""
        with binding.LOCK:
            if self._handle is None:
                return
            handle, self._handle, self._arrays = self._handle, None, {}
            self._state.running, self._state.finished = 0, 1
            self._state.generation += 1
            if self._process == os.getpid():             # else the simulation is that of the parent process
                self._library.scree_close(handle)

    def __del__(self) -> None:
        if self._handle is not None and self.ranks == 1:
            self.close()

    def __reduce_ex__(self, protocol: Any) -> Any:
        raise TypeError("a simulation cannot be copied or pickled: write_checkpoint() saves its state, and "
                        "scree.Simulation(..., restart=True) continues from it")

    def __enter__(self) -> Simulation:
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None,
                 trace: TracebackType | None) -> None:
        if kind is None and self._handle is not None:
            self.finish()
        elif self.ranks == 1:                            # with several ranks, the other ranks may not call this
            self.close()

    def __repr__(self) -> str:
        return f"<scree.Simulation {self.case}: step {self.steps}, t = {self.time:.6g} s of {self.end_time:.6g} s>"


_MESSAGES: list[Any] = []                                # the library that started MPI


def _end_messages_at_exit(library: Any) -> None:
    """Finish MPI at the end of the process, once."""
    if not _MESSAGES:
        _MESSAGES.append(library)
        process = os.getpid()
        atexit.register(lambda: library.scree_end_messages() if process == os.getpid() else None)


def _place_deck(deck: str | os.PathLike[str], outdir: str | os.PathLike[str] | None, overwrite: bool,
                comm: Any) -> str | os.PathLike[str]:
    """The file of the deck. A deck that is given as text is written by rank 0, which also reads it."""
    if comm is None:
        rank = int(os.environ.get("OMPI_COMM_WORLD_RANK") or os.environ.get("PMI_RANK") or 0)
    else:
        rank = comm.Get_rank()
    problem: Exception | None = None
    path: str | os.PathLike[str] = "deck.nml"
    if rank == 0:
        try:
            path = deck_file(deck, outdir, overwrite)
        except Exception as error:
            problem = error
    if comm is not None:
        problem = comm.bcast(problem, root=0)
    if problem is not None:
        raise problem
    return path
