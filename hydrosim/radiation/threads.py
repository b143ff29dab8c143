"""One thread of BLAS. More threads change the order of sums and so their rounding, which a fit
amplifies."""

from __future__ import annotations

from collections.abc import Callable
from functools import wraps
from typing import ParamSpec, TypeVar

P = ParamSpec("P")
R = TypeVar("R")


def one_thread(function: Callable[P, R]) -> Callable[P, R]:
    """The function with a result that is identical to the bit for any number of BLAS threads. Its
    matrices are small, so more than one thread would also be slower."""

    @wraps(function)
    def limited(*args: P.args, **kwargs: P.kwargs) -> R:
        from threadpoolctl import threadpool_limits  # slow to load, and not needed with a cache

        with threadpool_limits(limits=1, user_api="blas"):
            return function(*args, **kwargs)

    return limited
