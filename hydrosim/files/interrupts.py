"""Signals that end a program: all raise KeyboardInterrupt, and all wait while a file is written.

Machine code knows no exceptions. Python serves a signal where a function begins that machine code
has called, before a ``try`` of that function could catch an exception. So the signal waits there
until the machine code has returned, see `called_by_machine_code`.
"""

from __future__ import annotations

import os
import signal
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from types import CodeType, FrameType
from typing import TypeVar

ENDING_SIGNALS = [
    getattr(signal, name) for name in ("SIGINT", "SIGTERM", "SIGHUP") if hasattr(signal, name)
]
HANG_UP = getattr(signal, "SIGHUP", None)

_received: list[int] = []
"""Signals of this process that raised KeyboardInterrupt."""

_waiting: list[int] = []
"""Signals that wait until machine code has returned."""

_callbacks: set[CodeType] = set()
"""Functions that machine code calls."""


class Catching(threading.local):
    """Whether a function that machine code has called ``catches`` exceptions now."""

    catches: bool = False


catching = Catching()

Function = TypeVar("Function", bound="Callable[..., object]")


def called_by_machine_code(function: Function) -> Function:
    """Mark a function that machine code calls. While it runs, interrupts are raised where
    ``catching.catches`` is true, and otherwise when the machine code has returned."""
    _callbacks.add(function.__code__)
    return function


def install_signal_handlers() -> None:
    """Let SIGTERM and SIGHUP raise KeyboardInterrupt as Ctrl-C does, unless they have other
    handlers, as under `nohup`. `raise_if_interrupted` knows all three."""
    terminals = [stream for stream in (0, 1, 2) if os.isatty(stream)]
    _received.clear()
    _waiting.clear()

    def interrupt(number: int, frame: FrameType | None) -> None:
        _received.append(number)
        if number == HANG_UP:
            _discard_output(terminals)
        if _must_wait(frame):
            _waiting.append(number)
        else:
            raise KeyboardInterrupt

    for number in ENDING_SIGNALS:
        if signal.getsignal(number) in (signal.SIG_DFL, signal.default_int_handler):
            signal.signal(number, interrupt)


def raise_if_interrupted() -> None:
    """Raise KeyboardInterrupt if a signal came earlier. Call it between parts of long work: the
    first exception may have ended one part only, or a library may have swallowed it."""
    if _received:
        raise KeyboardInterrupt


def raise_waiting() -> None:
    """Raise KeyboardInterrupt if a signal has waited for machine code that has returned now."""
    if _waiting and threading.current_thread() is threading.main_thread():
        _waiting.clear()
        raise KeyboardInterrupt


def _must_wait(frame: FrameType | None) -> bool:
    """True if an exception in this frame would pass into machine code."""
    if catching.catches:
        return False
    while frame is not None and frame.f_code not in _callbacks:
        frame = frame.f_back
    return frame is not None


def _discard_output(terminals: list[int]) -> None:
    """Discard output after a hang-up: writing to the lost terminal would end the program."""
    nowhere = os.open(os.devnull, os.O_RDWR)
    for stream in terminals:
        os.dup2(nowhere, stream)
    os.close(nowhere)


@contextmanager
def delay_interrupts() -> Iterator[None]:
    """Delay signals that would end the program until this context is left."""
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    came: list[int] = []
    before = {number: signal.getsignal(number) for number in ENDING_SIGNALS}
    for number in ENDING_SIGNALS:
        if before[number] != signal.SIG_IGN:
            signal.signal(number, lambda number, _: came.append(number))
    try:
        yield
    finally:
        for number, handler in before.items():
            signal.signal(number, signal.SIG_DFL if handler is None else handler)
        for number in came[:1]:
            signal.raise_signal(number)
