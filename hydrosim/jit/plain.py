"""Kernels compiled by plain `njit`, each with all kernels that it calls.

This takes minutes, but uses only documented parts of numba: `njit`, its cache, and `typeof_impl`
(https://numba.readthedocs.io/en/stable/extending/). It replaces `hydrosim.jit.linking` for a numba
that the latter does not support.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numba
from numba.core import config, types
from numba.extending import typeof_impl

from hydrosim.files.cache import cache_folder
from hydrosim.files.interrupts import raise_waiting
from hydrosim.jit.refs import struct_reference

settings: Any = config


class PlainKernel:
    """A kernel, for Python and for other kernels; numba infers its return type."""

    fastmath: frozenset[str] = frozenset()

    def __init__(
        self, function: Callable[..., Any], folder: Callable[[], str], returns: Sequence[type] = ()
    ) -> None:
        self.__module__ = function.__module__  # where pickle looks for it by name
        self.py_func = function
        self._folder = folder
        self._made: Any = None

    @property
    def dispatcher(self) -> Any:
        """numba's compiled function, made on first use."""
        if self._made is None:
            # numba looks for its cache at this moment, and would not notice edits of other files
            before = settings.CACHE_DIR
            settings.CACHE_DIR = str(cache_folder(f"plain-{self._folder()}"))
            try:
                how: dict[str, Any] = {"error_model": "numpy", "nogil": True, "cache": True}
                self._made = numba.njit(fastmath=set(self.fastmath), **how)(self.py_func)
            finally:
                settings.CACHE_DIR = before
        return self._made

    def __call__(self, *args: Any) -> Any:
        returned = self.dispatcher(*map(struct_reference, args))
        raise_waiting()
        return returned

    def __reduce__(self) -> str:
        return str(self.py_func.__qualname__)  # pickled by name, as functions are


class PlainSummingKernel(PlainKernel):
    """A kernel whose sums may be taken in any order."""

    fastmath = frozenset({"reassoc", "contract"})


kernel_classes = PlainKernel, PlainSummingKernel, PlainKernel


@typeof_impl.register(PlainKernel)
def _type_of_kernel(kernel: PlainKernel, context: Any) -> Any:
    return types.Dispatcher(kernel.dispatcher)
