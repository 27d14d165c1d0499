# SPDX-License-Identifier: BSD-3-Clause
"""Fields of a simulation as arrays of numpy, which cannot be used after the simulation has changed."""
from __future__ import annotations

from typing import Any, Protocol

import numpy as np

from .errors import StaleView


class Owner(Protocol):
    """The interface of a simulation that a view uses."""

    @property
    def generation(self) -> int:
        """Changes whenever views become invalid."""


_HARMLESS = frozenset(("base", "shape", "dtype", "ndim", "size", "itemsize", "nbytes", "strides", "flags"))


class FieldView(np.ndarray[Any, Any]):
    """A field of the particles of this rank, valid until the next step, which uses the values written into it.

    It is an array of numpy. Using it or parts of it after a further step of the simulation raises StaleView. Copies,
    results of calculations and parts selected by a mask or a list are ordinary arrays and remain valid.
    `numpy.asarray(view)` is an ordinary array in the same memory without this check: after a step its values are old,
    and changes of it have no effect.
    """

    _owner: Owner | None = None
    _generation: int = 0

    def __array_finalize__(self, template: Any) -> None:
        part = isinstance(template, FieldView) and self.base is not None
        self._owner = template._owner if part else None
        self._generation = template._generation if part else 0

    def _check(self) -> None:
        """Raise an error if the simulation has changed since the view was made."""
        if self._owner is not None and self._owner.generation != self._generation:
            raise StaleView("this view of a field was made before a step or the end of the simulation and is no longer "
                            "valid; get a new view with simulation.fields[...], or keep a copy()")

    def __getattribute__(self, name: str) -> Any:
        if not name.startswith("_") and name not in _HARMLESS:
            self._check()
        return super().__getattribute__(name)

    def __getitem__(self, index: Any) -> Any:
        self._check()
        part = super().__getitem__(_plain(index))
        return part if not isinstance(part, FieldView) or np.may_share_memory(part, self) else part.view(np.ndarray)

    def __setitem__(self, index: Any, value: Any) -> None:
        self._check()
        super().__setitem__(_plain(index), _plain(value))

    def __array_ufunc__(self, ufunc: np.ufunc, method: Any, *inputs: Any, **kwargs: Any) -> Any:
        out = kwargs.pop("out", ())
        if out:
            kwargs["out"] = tuple(_plain(array) for array in out)
        result = getattr(ufunc, method)(*(_plain(array) for array in inputs),
                                           **{name: _plain(value) for name, value in kwargs.items()})
        return result if not out else out[0] if len(out) == 1 else out

    def __array_function__(self, function: Any, types: Any, args: Any, kwargs: Any) -> Any:
        return function(*(_plain(value) for value in args), **{name: _plain(value) for name, value in kwargs.items()})

    def __repr__(self) -> str:
        return repr(_plain(self)).replace("array", "FieldView", 1)

    def __str__(self) -> str:
        return str(_plain(self))


def _plain(value: Any) -> Any:
    """An ordinary array in the memory of a view, also in lists and tuples; any other object unchanged."""
    if isinstance(value, FieldView):
        value._check()
        return value.view(np.ndarray)
    if isinstance(value, (list, tuple)) and any(isinstance(part, (FieldView, list, tuple)) for part in value):
        return type(value)(_plain(part) for part in value)
    return value


def view_of(memory: np.ndarray[Any, Any], owner: Owner) -> FieldView:
    """A view that checks the validity with its owner."""
    view = memory.view(FieldView)
    view._owner, view._generation = owner, owner.generation
    return view
