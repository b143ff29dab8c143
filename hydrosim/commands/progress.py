"""How far a command is: a bar on a terminal, elsewhere a line now and then."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from threading import Event, Thread
from time import perf_counter
from typing import NamedTuple, Protocol

from hydrosim.commands.terminal import print_status, progress_console

FIRST_LINE_S = 2.0
"""Time [s] after which the first line is said. What takes less says none."""
MAX_PAUSE_S = 60.0
"""Time [s] from one line to the next, at most."""


class ProgressReport(Protocol):
    """Takes how far the work is: so much ``done`` of a ``total``, and a remark."""

    def __call__(self, done: float = 0.0, total: float = 0.0, remark: str = "") -> None: ...


class ProgressState(NamedTuple):
    """How far the work is. A ``total`` of zero is not known."""

    done: float = 0.0
    total: float = 0.0
    remark: str = ""

    def text(self, unit: str) -> str:
        """ "35 of 100 s, 250 steps/s"."""
        counted = f"{self.done:,.0f} of {self.total:,.0f} {unit}".strip() if self.total else ""
        return ", ".join(part for part in (counted, self.remark) if part)

    @property
    def share(self) -> str:
        """ "35 %"."""
        return f"{min(self.done / self.total, 1.0):.0%}".replace("%", " %") if self.total else ""


@contextmanager
def progress(what: str, unit: str = "") -> Iterator[ProgressReport]:
    """Shows ``what`` is being done, and how far it is, as it is told in a ``unit``."""
    shown = _bar if progress_console().is_terminal else _lines
    with shown(what, unit) as report:
        yield report


@contextmanager
def _bar(what: str, unit: str) -> Iterator[ProgressReport]:
    from rich.progress import (
        BarColumn,
        Progress,
        TextColumn,
        TimeElapsedColumn,
        TimeRemainingColumn,
    )

    far = TextColumn("{task.fields[far]}", markup=False)
    name = TextColumn("{task.description}", markup=False)
    columns = (name, BarColumn(), far, TimeElapsedColumn(), TimeRemainingColumn())
    with Progress(*columns, console=progress_console(), transient=True) as bar:
        task = bar.add_task(what, total=None, far="")

        def report(done: float = 0.0, total: float = 0.0, remark: str = "") -> None:
            text = ProgressState(done, total, remark).text(unit)
            bar.update(task, completed=done, total=total or None, far=text)

        yield report


@contextmanager
def _lines(what: str, unit: str) -> Iterator[ProgressReport]:
    lines = ProgressLines(what, unit)
    ended = Event()
    teller = Thread(target=lines.tell, args=(ended.wait, print_status), daemon=True)
    teller.start()
    try:
        yield lines.report
    finally:
        ended.set()
        teller.join()


class ProgressLines:
    """What is said of the progress of some work, at growing intervals."""

    def __init__(self, what: str, unit: str = "") -> None:
        self._what = what
        self._unit = unit
        self._far = ProgressState()
        self._begun = perf_counter()

    def report(self, done: float = 0.0, total: float = 0.0, remark: str = "") -> None:
        """Take how far the work is."""
        self._far = ProgressState(done, total, remark)

    def tell(self, ended: Callable[[float], bool], say: Callable[[str], None]) -> None:
        """Say how far the work is, until it has ``ended`` within a time [s] that is waited for."""
        for pause in pauses():
            if ended(pause):
                return
            try:
                say(self.line(perf_counter() - self._begun))
            except (OSError, ValueError):  # nobody reads any more
                return

    def line(self, elapsed: float) -> str:
        """ "simulating: 35 %, 35 of 100 s, 250 steps/s (6 s so far)"."""
        far = self._far
        parts = [part for part in (far.share, far.text(self._unit)) if part]
        said = f"{self._what}: {', '.join(parts)}" if parts else self._what
        return f"{said} ({elapsed:.0f} s so far)"


def pauses() -> Iterator[float]:
    """The times [s] from one line to the next: they double, up to `MAX_PAUSE_S`."""
    pause = FIRST_LINE_S
    while True:
        yield pause
        pause = min(2.0 * pause, MAX_PAUSE_S)
