"""Signals that end a program: all raise KeyboardInterrupt, and all wait while a file is written."""

from __future__ import annotations

import os
import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from types import FrameType

ENDING = [
    getattr(signal, name) for name in ("SIGINT", "SIGTERM", "SIGHUP") if hasattr(signal, name)
]
HANG_UP = getattr(signal, "SIGHUP", None)

_received: list[int] = []
"""Signals of this process that raised KeyboardInterrupt."""


def taken_as_interrupts() -> None:
    """Let SIGTERM and SIGHUP raise KeyboardInterrupt as Ctrl-C does, unless they have other
    handlers, as under `nohup`. `raise_if_interrupted` knows all three."""
    terminals = [stream for stream in (0, 1, 2) if os.isatty(stream)]
    _received.clear()

    def interrupt(number: int, _: FrameType | None) -> None:
        _received.append(number)
        if number == HANG_UP:
            _leave(terminals)
        raise KeyboardInterrupt

    for number in ENDING:
        if signal.getsignal(number) in (signal.SIG_DFL, signal.default_int_handler):
            signal.signal(number, interrupt)


def raise_if_interrupted() -> None:
    """Raise KeyboardInterrupt if a signal came earlier. Call it between parts of long work: the
    first exception may have ended one part only, or a library may have swallowed it."""
    if _received:
        raise KeyboardInterrupt


def _leave(terminals: list[int]) -> None:
    """Discard output after a hang-up: writing to the lost terminal would end the program."""
    nowhere = os.open(os.devnull, os.O_RDWR)
    for stream in terminals:
        os.dup2(nowhere, stream)
    os.close(nowhere)


@contextmanager
def undisturbed() -> Iterator[None]:
    """Delay signals that would end the program until this context is left."""
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    came: list[int] = []
    before = {number: signal.getsignal(number) for number in ENDING}
    for number in ENDING:
        if before[number] != signal.SIG_IGN:
            signal.signal(number, lambda number, _: came.append(number))
    try:
        yield
    finally:
        for number, handler in before.items():
            signal.signal(number, signal.SIG_DFL if handler is None else handler)
        for number in came[:1]:
            signal.raise_signal(number)
