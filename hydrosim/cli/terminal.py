"""What commands share: printing, options and their checks, progress, runs with earlier stages."""

from __future__ import annotations

import io
import json
import os
import re
import sys
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from threading import Event, Thread
from time import perf_counter
from typing import TYPE_CHECKING, Any, NamedTuple, Protocol

import typer
from rich.console import Console, RenderableType
from typer.core import TyperCommand

from hydrosim.errors import InputError, WritingError

if TYPE_CHECKING:
    import xarray as xr

    from hydrosim.case import Case
    from hydrosim.files.document import Document
    from hydrosim.files.outputs import Output
    from hydrosim.interface.printed import PrintedResult
    from hydrosim.scene import ChangedDatabase

# Standard streams that are closed, or that nobody reads, do not end a command.

LOST_WRITE_ERRORS: dict[str, type[OSError]] = {"stdout": BrokenPipeError, "stderr": OSError}
"""Errors of a stream, besides a closed terminal. A full disk below the standard output is reported.
Messages and progress may be lost in silence."""


class _Lasting(io.FileIO):
    """File descriptor that accepts all writes, also after a write failed with ``lost`` or, on a
    terminal, with any error."""

    def __init__(self, descriptor: int, lost: type[OSError]) -> None:
        super().__init__(descriptor, "w", closefd=False)
        self._lost = OSError if os.isatty(descriptor) else lost

    def write(self, data: Any, /) -> int:
        try:
            return super().write(data)
        except self._lost:
            return memoryview(data).nbytes


def make_streams_last() -> None:
    """Make standard output and error writable until the process ends. Characters outside their
    encoding are printed as numbers."""
    _open_closed_descriptors()
    for number, name in enumerate(("stdout", "stderr"), 1):
        stream = getattr(sys, name)
        if stream is getattr(sys, f"__{name}__"):  # None if closed; other objects are left alone
            setattr(sys, name, _lasting(number, name, stream))


def _open_closed_descriptors() -> None:
    """Open the null device for closed standard streams. Otherwise the next file opened, such as a
    result, would take their number and receive the printed text."""
    for descriptor in (0, 1, 2):
        try:
            os.fstat(descriptor)
        except OSError:
            os.open(os.devnull, os.O_RDWR)  # open takes the lowest free number


def _lasting(descriptor: int, name: str, stream: io.TextIOWrapper | None) -> io.TextIOWrapper:
    return io.TextIOWrapper(
        io.BufferedWriter(_Lasting(descriptor, LOST_WRITE_ERRORS[name])),
        encoding=stream.encoding if stream else "utf-8",
        errors="backslashreplace",
        line_buffering=stream is not None and stream.line_buffering,
    )


def print_lines(*parts: RenderableType) -> None:
    """Print tables and plain lines: no markup, no colours, no line breaks."""
    from hydrosim.files.document import print_parts  # loads numpy

    print_parts(Console(), *parts)


def show_document(document: Document, verbose: bool = False) -> None:
    """Print a document, with its details if ``verbose``."""
    from hydrosim.files.document import print_document

    print_document(document, Console(), verbose)


def print_status(text: str) -> None:
    """Print a plain line of text to the standard error."""
    from hydrosim.files.document import print_parts  # loads numpy

    print_parts(Console(stderr=True), text)


def progress_console() -> Console:
    """Console for progress bars, which are drawn on terminals only. Notebooks and others may force
    colours upon streams that keep every state of a bar."""
    is_terminal = sys.stderr is not None and sys.stderr.isatty()
    return Console(stderr=True, force_terminal=is_terminal)


# Options of a command, as its function of Python takes them.


def given_options(context: typer.Context, *but: str) -> dict[str, Any]:
    """Arguments and options of a command that are given, by name, ``but`` for some."""
    options = {name: value for name, value in context.params.items() if name not in but}
    return {name: value for name, value in options.items() if not is_absent(value)}


def is_absent(value: Any) -> bool:
    """Whether the value of an option says that the option is not given."""
    return value is None or value is False or value in ("", [])


def show_result(result: PrintedResult, verbose: bool = False) -> None:
    """Print a result: its text, its files, and what else there is to say."""
    if result.document.nodes or result.document.title:
        show_document(result.document, verbose)
    tables = [path for path in result.files if path.suffix == ".csv"]
    others = [path for path in result.files if path.suffix != ".csv"]
    print_lines(*(f"table     {path}" for path in tables))
    if others:
        label = FILE_LABELS.get(others[0].suffix, "picture")
        print_lines(f"{label:10s}{', '.join(map(str, others))}")
    print_lines(*result.lines)


FILE_LABELS = {".nc": "result", ".yaml": "keys", ".yml": "keys"}


# `--given KEY=VALUE`: data that a database's file lacks, and changes of the database.


def given_database(file: Path, given: Sequence[str]) -> ChangedDatabase:
    """Database in a ``file``, with the ``given`` texts KEY=VALUE, whose keys are those under
    `hydrodynamics` in a case. Raises InputError that names the option."""
    from hydrosim.files.layers import apply_setting
    from hydrosim.files.messages import validate_document
    from hydrosim.files.yaml_nodes import COMMAND_LINE_PREFIX, compose_nodes
    from hydrosim.scene import ChangedDatabase

    document = compose_nodes(json.dumps({"file": str(file)}), COMMAND_LINE_PREFIX)
    assert document is not None
    for setting in given:
        if setting.partition("=")[0].strip() == "file":
            raise InputError(
                f"{COMMAND_LINE_PREFIX}{setting}: found file; expected another key. The file is"
                " the argument."
            )
        document = apply_setting(document, setting, COMMAND_LINE_PREFIX)
    return validate_document(document, ChangedDatabase)


# Results that a command shows: people may have changed such files.

MISSING_VARIABLE = re.compile(
    r"No variable named '(\w+)'|'Dataset' object has no attribute '(\w+)'"
)
"""What xarray says of a variable that a dataset lacks."""


def reflow_help(function: Callable[..., Any]) -> str:
    """Docstring of a command, each paragraph in one line."""
    paragraphs = (function.__doc__ or "").split("\n\n")
    return "\n\n".join(" ".join(paragraph.split()) for paragraph in paragraphs)


class Command(TyperCommand):
    """A command that names its options in the messages of the functions which it calls, and refuses
    a result that lacks a variable it needs."""

    def invoke(self, context: Any) -> Any:
        paths = [value for value in context.params.values() if isinstance(value, Path)]
        try:
            with tell_absent_variables(paths):
                return super().invoke(context)
        except InputError as error:
            raise InputError(with_options(str(error), self.option_names())) from error

    def option_names(self) -> dict[str, str]:
        """Longest spelling of each option by the name of its parameter."""
        options = [param for param in self.params if param.param_type_name == "option"]
        return {str(option.name): max(option.opts, key=len) for option in options}


def with_options(message: str, options: Mapping[str, str]) -> str:
    """A message whose first words, and words in backticks, name options as they are typed."""
    first = NAMES_AT_START.match(message)
    if first and all(name in options for name in first[1].split(", ")):
        names = ", ".join(options[name] for name in first[1].split(", "))
        message = f"{names}{message[first.end(1) :]}"
    return NAME_IN_BACKTICKS.sub(lambda name: options.get(name[1], name[0]), message)


NAMES_AT_START = re.compile(r"(\w+(?:, \w+)*): ")
NAME_IN_BACKTICKS = re.compile(r"`(\w+)`")


@contextmanager
def tell_absent_variables(paths: Sequence[Path]) -> Iterator[None]:
    """Raises InputError if the result at the first of the paths lacks a variable."""
    try:
        yield
    except (KeyError, AttributeError) as error:
        absent = MISSING_VARIABLE.search(str(error))
        if absent is None or not paths:
            raise
        cause = error
    else:
        return
    from hydrosim.results.validation import CHANGED_FILE_HINT  # loads the models of cases

    problem_text = f"found no variable {absent[1] or absent[2]}, which this page needs"
    raise InputError(f"{paths[0]}: {problem_text}. {CHANGED_FILE_HINT}") from cause


# Progress of a command: a bar on a terminal, elsewhere a line now and then.


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
    shown = _progress_bar if progress_console().is_terminal else _progress_lines
    with shown(what, unit) as report:
        yield report


@contextmanager
def computing(what: str, unit: str = "") -> Iterator[ProgressReport]:
    """`progress` of what may compile kernels."""
    with announce_compiling(err), progress(what, unit) as report:
        yield report


@contextmanager
def _progress_bar(what: str, unit: str) -> Iterator[ProgressReport]:
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
def _progress_lines(what: str, unit: str) -> Iterator[ProgressReport]:
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


# Runs of a case by a command: earlier stages and progress.

err = progress_console()


@contextmanager
def print_resume_hint(by: str) -> Iterator[None]:
    """After an interrupt or a full disk, print that the command continues with the option
    ``by``."""
    try:
        yield
    except WritingError:
        print_status(f"completed work is kept; {by} continues")
        raise
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
    from hydrosim.simulation import simulate_data

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

        return simulate_data(scene, tell, checkpoint)
