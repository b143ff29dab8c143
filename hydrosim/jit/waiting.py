"""What calls of kernels do while others are compiled: they wait, and may be torn."""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from time import perf_counter

from numba.core import event


class Torn(KeyboardInterrupt):
    """An interrupt, or a signal, while a kernel was compiled that others waited for: they have left
    their work half done, and what they write to is not to be used."""


class Waiting(threading.local):
    """What this thread has met at doors: the ``error`` that kept one closed; ``seconds`` until all
    others were open."""

    error: BaseException | None = None
    seconds: float = 0.0


waiting = Waiting()


def running_time() -> float:
    """Seconds on a clock that stands still while kernels of this thread wait for others to be
    compiled or loaded."""
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
    """Call ``act`` before the first kernel is compiled meanwhile, if any is: those that come from
    the disk are not."""
    with event.install_listener("numba:compile", _First(act)):
        yield
