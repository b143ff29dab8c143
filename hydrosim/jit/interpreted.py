"""Kernels run by Python, for a debugger: nothing is compiled, and runs are slow. Numbers are
numpy's, so that a division by zero behaves as in machine code."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from hydrosim.jit.refs import StructReference

MAX_CONVERTED = 64  # number of converted tuples that are kept
_kept: dict[int, tuple[tuple, tuple]] = {}


class InterpretedKernel:
    """A function that reads the fields of records as attributes."""

    def __init__(
        self, function: Callable[..., Any], folder: Callable[[], str], returns: Sequence[type] = ()
    ) -> None:
        self.__module__ = function.__module__  # where pickle looks for it by name
        self.py_func = function

    def __call__(self, *args: Any) -> Any:
        with np.errstate(all="ignore"):
            return self.py_func(*map(_as_python_reads, args))

    def __reduce__(self) -> str:
        return str(self.py_func.__qualname__)  # pickled by name, as functions are


kernel_classes = InterpretedKernel, InterpretedKernel, InterpretedKernel


class _Record:
    """A record with its fields as attributes, whatever their names."""

    def __init__(self, values: np.void) -> None:
        object.__setattr__(self, "values", values)

    def __getattr__(self, name: str) -> Any:
        return _as_python_reads(self.values[name])

    def __setattr__(self, name: str, value: Any) -> None:
        self.values[name] = value


class _Records(np.ndarray):
    """An array of records with their fields as attributes."""

    def __getitem__(self, index: Any) -> Any:
        element = super().__getitem__(index)
        return _Record(element) if isinstance(element, np.void) else element

    def __iter__(self) -> Any:
        return (self[i] for i in range(len(self)))


def _as_python_reads(value: Any) -> Any:
    """The argument of a kernel in its form for Python; both share their memory."""
    if isinstance(value, StructReference):
        value = value.value
    if isinstance(value, np.ndarray) and value.dtype.names:
        return value.view(_Records)
    if isinstance(value, np.void):
        return _Record(value)
    if not (isinstance(value, tuple) and hasattr(value, "_fields")):
        return value
    record = _kept.get(id(value))
    if record is None or (record[0] is not value and record[1] is not value):
        converted = type(value)(*map(_as_python_reads, value))
        if len(_kept) >= MAX_CONVERTED:
            del _kept[next(iter(_kept))]
        record = (value, converted)
        _kept[id(value)] = record
        _kept[id(converted)] = record
    return record[1]
