"""One thread of BLAS. More threads change the order of sums and so their rounding, which a fit
amplifies."""

from __future__ import annotations

import sys
from collections.abc import Callable
from functools import cache, wraps
from typing import TYPE_CHECKING, ParamSpec, TypeVar

if TYPE_CHECKING:
    from threadpoolctl import ThreadpoolController

P = ParamSpec("P")
R = TypeVar("R")


def one_thread(function: Callable[P, R]) -> Callable[P, R]:
    """The function with a result that is identical to the bit for any number of BLAS threads. Its
    matrices are small, so more than one thread would also be slower."""

    @wraps(function)
    def limited(*args: P.args, **kwargs: P.kwargs) -> R:
        with _blas_libraries("scipy.linalg" in sys.modules).limit(limits=1, user_api="blas"):
            return function(*args, **kwargs)

    return limited


@cache  # a search through all that the process has loaded takes 30 ms
def _blas_libraries(with_scipy: bool) -> ThreadpoolController:
    """The libraries of BLAS that are loaded: that of NumPy, and that of SciPy once it is there."""
    from threadpoolctl import ThreadpoolController  # slow to load, and not needed with a cache

    return ThreadpoolController()
