"""Kernels as numba compiles them by itself: `njit`, each with all that it calls.

It takes minutes, but it asks nothing of numba but what is documented: `njit`, its cache, and
`typeof_impl` (https://numba.readthedocs.io/en/stable/extending/). So it stands in where numba is
another than `hydrosim.jit.linking` knows.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numba
from numba.core import config, types
from numba.extending import typeof_impl

from hydrosim.cache import cache_folder
from hydrosim.jit.refs import hold

settings: Any = config


class Part:
    """A kernel, for Python and for other kernels; what it returns numba finds out."""

    fastmath: frozenset[str] = frozenset()

    def __init__(
        self, function: Callable[..., Any], folder: Callable[[], str], returns: Sequence[type] = ()
    ) -> None:
        self.py_func = function
        self._folder = folder
        self._made: Any = None

    @property
    def compiled(self) -> Any:
        """The function as numba has it, made when it is first asked for."""
        if self._made is None:
            # numba looks for its cache at this moment, and would not see edits of other files
            before = settings.CACHE_DIR
            settings.CACHE_DIR = str(cache_folder(f"plain-{self._folder()}"))
            try:
                how: dict[str, Any] = {"error_model": "numpy", "nogil": True, "cache": True}
                self._made = numba.njit(fastmath=set(self.fastmath), **how)(self.py_func)
            finally:
                settings.CACHE_DIR = before
        return self._made

    def __call__(self, *args: Any) -> Any:
        return self.compiled(*map(hold, args))

    def __reduce__(self) -> str:
        return str(self.py_func.__qualname__)  # pickled by name, as functions are


Whole = Part


class Summing(Part):
    """A kernel whose sums may be taken in any order."""

    fastmath = frozenset({"reassoc", "contract"})


@typeof_impl.register(Part)
def _type_of_kernel(kernel: Part, context: Any) -> Any:
    return types.Dispatcher(kernel.compiled)
