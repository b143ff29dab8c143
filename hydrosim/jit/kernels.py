"""Compiled kernels and their cache folder. `hydrosim.jit.linking` compiles them,
`hydrosim.jit.disk` stores them. The environment variable ``HYDROSIM_JIT`` selects another way:
``plain``, or ``python`` without machine code.

The name of each file there holds a hash of all that its machine code is made of
(`hydrosim.jit.ingredients`). The name of the folder holds what all kernels share: versions, and the
sources that compile.
"""

from __future__ import annotations

import hashlib
import os
import warnings
from collections.abc import Callable
from functools import partial
from importlib import import_module
from importlib.machinery import EXTENSION_SUFFIXES
from typing import TYPE_CHECKING, Any

import llvmlite
import numba

from hydrosim.errors import InputError
from hydrosim.files.cache import PACKAGE, digest_of_sources

if TYPE_CHECKING:
    from types import ModuleType

SOURCES = {
    "jit",
    "modes.py",
    "multibody",
    "integrate",
    "tanks",
    "elements",
    "water",
}

WAYS = {
    "linked": "hydrosim.jit.linking",
    "plain": "hydrosim.jit.plain",
    "python": "hydrosim.jit.interpreted",
}
LATEST_NUMBA = (0, 68)
"""Latest version of numba with which `hydrosim.jit.linking` was tested."""


def _choose_way() -> ModuleType:
    """The module with the kinds of kernels. Falls back to ``plain`` with a warning if
    `hydrosim.jit.linking` does not support the installed numba. Raises InputError for an unknown
    ``HYDROSIM_JIT``."""
    asked = os.environ.get("HYDROSIM_JIT", "linked")
    if asked not in WAYS:
        raise InputError(f"HYDROSIM_JIT: found {asked}; expected {', '.join(WAYS)}.")
    try:
        if asked == "linked" and numba.version_info.short > LATEST_NUMBA:
            raise ImportError(f"tested up to numba {'.'.join(map(str, LATEST_NUMBA))}")
        return import_module(WAYS[asked])
    except (ImportError, AttributeError, TypeError) as error:
        if asked != "linked":
            raise
        warnings.warn(
            f"hydrosim.jit.linking does not support numba {numba.__version__} ({error}): kernels"
            " are compiled in the plain way, which takes minutes, once for each kind of scene."
            " Results are the same."
            f" Install numba {'.'.join(map(str, LATEST_NUMBA))} for the fast way.",
            stacklevel=2,
        )
        return import_module(WAYS["plain"])


_ways = _choose_way()
_InlinedKernel, _SummingKernel, _CompiledKernel = _ways.kernel_classes
WAY = next(way for way, name in WAYS.items() if name == _ways.__name__)
"""The way in use, a name in `WAYS`."""


def kernel_folder() -> str:
    """Name of the folder with the kernels compiled by this numba, LLVM and `hydrosim.jit`.
    Interpreters that load the same extension modules share it, wherever the sources lie. In the
    plain way numba trusts every file in it, so the name holds all sources."""
    sources = digest_of_sources(PACKAGE, "jit") if WAY == "linked" else sources_digest()
    made = f"{EXTENSION_SUFFIXES[0]}{numba.__version__}{llvmlite.__version__}{sources}"
    return f"kernels-{hashlib.sha256(made.encode()).hexdigest()[:16]}"


def sources_digest() -> str:
    """Digest of the sources of all kernels, independent of where they are installed. Checkpoints
    hold it."""
    return digest_of_sources(PACKAGE, *sorted(SOURCES))


def kernel(function: Callable[..., Any]) -> Any:
    """A function that numba compiles, with numpy's rules for division and no fast-math.

    Kernels run without numba's memory manager: they cannot allocate (the compiler refuses), and the
    many arrays of a model are passed without counting references. The machine code of a kernel
    becomes a part of every kernel that calls it, because a call would pass dozens of words.
    """
    return _make_kernel(_InlinedKernel, function)


def summing(function: Callable[..., Any]) -> Any:
    """A `kernel` whose sums may be taken in any order, so that they vectorise. Results change by
    rounding alone."""
    return _make_kernel(_SummingKernel, function)


def root(function: Callable[..., Any]) -> Any:
    """A `kernel` with machine code of its own, compiled at its first call. It suits a kernel that
    is large and called from several places, or that few scenes need. It returns nothing."""
    return _make_kernel(_CompiledKernel, function)


def root_giving(*types: type) -> Callable[[Callable[..., Any]], Any]:
    """A `root` that returns numbers of these types: float, bool or int."""
    return partial(_make_kernel, partial(_CompiledKernel, returns=types))


def _make_kernel(kind: Callable[..., Any], function: Callable[..., Any]) -> Any:
    home = function.__code__.co_filename
    _, inside, place = home.partition(f"{PACKAGE}{os.sep}")
    if inside and place.partition(os.sep)[0] not in SOURCES:
        raise ImportError(f"{home} defines a kernel; add it to SOURCES in hydrosim/jit/kernels.py")
    return kind(function, kernel_folder)


@kernel
def assign(target, source):
    """target[:] = source for flat arrays, without the temporary that numba would make."""
    for i in range(source.size):
        target[i] = source[i]


@kernel
def clear(target):
    """target[:] = 0 for a flat array."""
    for i in range(target.size):
        target[i] = 0.0


@kernel
def any_negative(values):
    """True if any of a flat array is negative."""
    for i in range(values.size):
        if values[i] < 0.0:
            return True
    return False


# Search for the piece of a piecewise function that holds a number.


@kernel
def piece_of(x, low, high, pieces):
    """Index, from ``low`` to ``high``, of the last of ``pieces`` that starts at or before ``x``. It
    is ``low`` if all pieces start later."""
    while low < high:
        middle = (low + high + 1) // 2
        if x < pieces[middle].start:
            high = middle - 1
        else:
            low = middle
    return low
