"""State of kernel calls that wait for other kernels to be compiled, or are interrupted
meanwhile."""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from time import perf_counter

from numba.core import event


class Torn(KeyboardInterrupt):
    """An interrupt or a signal while running kernels waited for another kernel or for a function of
    Python. These left their work half done; their output must not be used."""


class Waiting(threading.local):
    """State of doors in this thread: the ``error`` that kept one closed; ``seconds`` spent waiting
    for all others to open."""

    error: BaseException | None = None
    seconds: float = 0.0


waiting = Waiting()


def running_time() -> float:
    """Seconds on a clock that stops while kernels of this thread wait for others to be compiled or
    loaded."""
    return perf_counter() - waiting.seconds


class _First(event.Listener):
    """Calls ``act`` at the first event of a kind."""

    def __init__(self, act: Callable[[], None]) -> None:
        self._waiting = [act]

    def on_start(self, event: event.Event) -> None:
        while self._waiting:
            self._waiting.pop()()

    def on_end(self, event: event.Event) -> None:
        pass


@contextmanager
def at_first_compile(act: Callable[[], None]) -> Iterator[None]:
    """Call ``act`` before the first kernel is compiled in this context. Kernels that come from the
    disk do not count."""
    with event.install_listener("numba:compile", _First(act)):
        yield
