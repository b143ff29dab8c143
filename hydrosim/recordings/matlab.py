"""Recordings in MATLAB files up to version 7 (7.3 is HDF5)."""

from __future__ import annotations

import zlib
from collections.abc import Iterator
from typing import Any

import numpy as np

from hydrosim.documents.text import Source, name_and_unit
from hydrosim.recordings.recording import Recording, of_arrays

# exceptions of scipy about damaged files
_DAMAGE = (
    ArithmeticError,
    EOFError,
    LookupError,
    MemoryError,
    OSError,
    RuntimeError,
    TypeError,
    ValueError,
    zlib.error,
)


def read(source: Source) -> Recording:
    """Arrays over time in a MATLAB file; arrays in a struct are named "struct.field"."""
    from scipy.io import loadmat
    from scipy.io.matlab import MatReadError

    try:
        content = loadmat(source.file, squeeze_me=True, struct_as_record=False)
    except (MatReadError, *_DAMAGE) as error:
        source.wrong(f"cannot be read as MATLAB file ({error}); save it again")
    named = ((name, value) for name, value in content.items() if not name.startswith("__"))
    arrays = {name: array for each in named for name, array in _arrays(*each)}
    return of_arrays(source, "MATLAB", arrays, {name: name_and_unit(name)[1] for name in arrays})


def _arrays(name: str, value: Any) -> Iterator[tuple[str, np.ndarray]]:
    for field in getattr(value, "_fieldnames", ()):
        yield from _arrays(f"{name}.{field}", getattr(value, field))
    if isinstance(value, np.ndarray):
        yield name, value
