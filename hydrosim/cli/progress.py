"""How far a command is: a bar on a terminal, elsewhere a line now and then."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from threading import Event, Thread
from time import perf_counter
from typing import TYPE_CHECKING, NamedTuple, Protocol

import typer
from rich.console import Console

from hydrosim.cli.terminal import print_status, progress_console

if TYPE_CHECKING:
    import xarray as xr

    from hydrosim.case import Case
    from hydrosim.files.outputs import Output

# Message that kernels are being compiled, which makes a first run longer.


@contextmanager
def announce_compiling(err: Console) -> Iterator[None]:
    """Print a message when the first kernel is compiled within this context."""
    from hydrosim.files.cache import cache_folder
    from hydrosim.jit.kernels import kernel_folder  # loads numba
    from hydrosim.jit.waiting import at_first_compile

    def say() -> None:
        folder = cache_folder(kernel_folder())
        what = "compiling kernels, once for this version (up to half a minute)"
        err.print(f"{what}; they are stored in {folder}", highlight=False, soft_wrap=True)

    with at_first_compile(say):
        yield


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
        text = f"{self._what}: {', '.join(parts)}" if parts else self._what
        return f"{text} ({elapsed:.0f} s so far)"


def pauses() -> Iterator[float]:
    """The times [s] from one line to the next: they double, up to `MAX_PAUSE_S`."""
    pause = FIRST_LINE_S
    while True:
        yield pause
        pause = min(2.0 * pause, MAX_PAUSE_S)


# Functions of all commands that run a case: earlier stages and progress.

err = progress_console()


@contextmanager
def print_resume_hint(by: str) -> Iterator[None]:
    """After an interrupt, print that the command continues with the option ``by``."""
    try:
        yield
    except KeyboardInterrupt:
        print_status(f"interrupted: completed work is kept; {by} continues")
        raise typer.Exit(130) from None


def case_summary_line(case: Case) -> str:
    """What is about to be simulated, in one line."""
    data = case.data
    counted = [_count_text(len(data.bodies), "body", "bodies")]
    counted.append(_count_text(len(data.forces), "force element", "force elements"))
    seas = "waves" if data.water.waves else "no waves"
    lasts = f"{data.duration:g} s by {data.solver.method}"
    return f"case      {data.title}: {', '.join([*counted, seas, lasts])}"


def _count_text(number: int, singular: str, plural: str) -> str:
    return f"{number} {singular if number == 1 else plural}"


def run_earlier_stages(case: Case, run: Callable[[Case, Output], xr.Dataset]) -> None:
    """Run the other cases that the case needs, and print their names."""
    from hydrosim.simulation import complete_stages as made

    made(case, run, lambda text: print_status(f"first stage: {text}"))


def simulate_with_progress(
    case: Case, result: Output, resume: bool = False, every: float = 60.0
) -> xr.Dataset:
    """Simulate a case with a progress bar. Its state is saved to disk ``every`` so often [s]."""
    from hydrosim.compile.restart import open_start, start_time
    from hydrosim.run.checkpoint import Checkpoint, checkpoint_of
    from hydrosim.simulation import simulate

    checkpoint = Checkpoint(checkpoint_of(result), every, resume, print_status)
    scene = open_start(case.scene())
    start = start_time(scene)
    begun = perf_counter()
    reached = start
    with announce_compiling(err), progress("simulating", "s") as report:

        def tell(time: float, steps: int) -> None:
            nonlocal reached
            speed = f"{steps / max(perf_counter() - begun, 1e-3):,.0f} steps/s"
            done = "measuring its error" if time == reached else speed
            report(time - start, scene.duration, done)
            reached = time

        return simulate(scene, tell, checkpoint)
