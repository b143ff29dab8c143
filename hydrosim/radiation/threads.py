"""One thread of BLAS: sums in another order round differently, and a fit makes more of that."""

from __future__ import annotations

from collections.abc import Callable
from functools import wraps
from typing import ParamSpec, TypeVar

P = ParamSpec("P")
R = TypeVar("R")


def one_thread(function: Callable[P, R]) -> Callable[P, R]:
    """The function with the same result, to the bit, whatever the number of threads of BLAS; its
    matrices are so small that more than one take longer too."""

    @wraps(function)
    def limited(*args: P.args, **kwargs: P.kwargs) -> R:
        from threadpoolctl import threadpool_limits  # slow to load, and not needed with a cache

        with threadpool_limits(limits=1, user_api="blas"):
            return function(*args, **kwargs)

    return limited
