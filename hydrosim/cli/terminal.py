"""What commands share: printing, options and their checks, progress, runs with earlier stages."""

from __future__ import annotations

import io
import json
import os
import re
import sys
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from enum import StrEnum
from functools import wraps
from math import inf, isfinite
from pathlib import Path
from threading import Event, Thread
from time import perf_counter
from typing import TYPE_CHECKING, Annotated, Any, NamedTuple, Protocol, TypeVar

import typer
from rich.console import Console, RenderableType

from hydrosim.errors import InputError

if TYPE_CHECKING:
    import xarray as xr

    from hydrosim.case import Case
    from hydrosim.files.document import Document
    from hydrosim.files.outputs import Output
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


def incomplete_run_warnings(attributes: Mapping[str, object]) -> list[str]:
    """Warning about the end of a run, from its attributes; empty if the run is complete."""
    status = attributes.get("status", "complete")
    text = f"warning   the run is {status}: {attributes.get('status_message', '')}"
    return [] if status == "complete" else [text]


def progress_console() -> Console:
    """Console for progress bars, which are drawn on terminals only. Notebooks and others may force
    colours upon streams that keep every state of a bar."""
    is_terminal = sys.stderr is not None and sys.stderr.isatty()
    return Console(stderr=True, force_terminal=is_terminal)


# Arguments and options that several commands share, and their validation.

Choice = TypeVar("Choice", bound=StrEnum)
CaseFile = Annotated[Path, typer.Argument(metavar="CASE.yaml", help="Case file to read.")]
Settings = Annotated[
    list[str],
    typer.Option(
        "--set",
        metavar="KEY=VALUE",
        help="Change a value of the input file: solver.step=0.05. May be repeated.",
    ),
]
StudyFile = Annotated[Path, typer.Argument(metavar="STUDY.yaml", help="Study file to read.")]
Workers = Annotated[
    int | None,
    typer.Option(min=1, help="Number of simultaneous runs; default: the number of cores."),
]
From = Annotated[
    str,
    typer.Option(
        "--from",
        metavar="TIME",
        help='Ignore everything before this time: "10 min", or a number in seconds.',
    ),
]
To = Annotated[
    str,
    typer.Option(
        "--to",
        metavar="TIME",
        help='Ignore everything after this time: "1 hour", or a number in seconds.',
    ),
]
Verbose = Annotated[bool, typer.Option("--verbose", "-v", help="Also print the details.")]
Overwrite = Annotated[
    bool,
    typer.Option("--overwrite", help="Replace existing files of any kind; keep no earlier result."),
]


def require_file(path: Path, expected: str) -> None:
    """Raises InputError if there is nothing at ``path``. It comes before messages about results,
    which have their names from the input."""
    if not os.path.exists(path):
        raise InputError(f"{path}: there is no such file; expected {expected}.")


def output_for(
    given: Path | None,
    default: str,
    what: str,
    origin: Path,
    *,
    inputs: Iterable[Path] = (),
    overwrite: bool = False,
    suffix: str | None = ".nc",
    settings: str = "",
) -> Output:
    """Output for a result ``what`` ("run") that is made of the file ``origin``. Its path is
    ``given``, or else ``default`` in the current folder, or a free name if the program reads that
    file. Raises InputError before any computation if the path cannot be written. ``settings`` are
    the settings of the result."""
    from hydrosim.files.outputs import Output

    path = given or Path(f"{default}{suffix}")
    made = Output(path, what, origin, (origin, *inputs), overwrite, settings=settings)
    if given is None and made.is_own_input():
        made = made.output_at(path.with_stem(f"{path.stem}_{what}"))
        text = f"{path} is an input here; the result goes to {made.path}"
        Console(stderr=True).print(text, markup=False, highlight=False, soft_wrap=True)
    if os.path.isdir(path):  # Path.is_dir raises where a name is too long
        example = path / f"{what}{suffix or '.txt'}"
        raise InputError(f"--output: {path} is a directory; expected a file, such as {example}.")
    if path.suffix in (".yaml", ".yml"):
        raise InputError(
            f"--output: {path} has the name of a case file; expected the name of a result."
        )
    if suffix and path.suffix != suffix:
        raise InputError(f"--output: found {path}; expected a name that ends in {suffix}.")
    return made.checked_output()


def numbers(text: str, option: str, positive: bool = True) -> list[float]:
    """Numbers of an option, separated by commas. Raises InputError that names the option."""
    try:
        values = [float(part) for part in text.split(",")]
    except ValueError:
        values = [float("nan")]
    if not all(isfinite(x) and (x > 0.0 or not positive) for x in values):
        kind = "positive numbers" if positive else "numbers"
        raise InputError(f"{option}: found {text!r}; expected {kind}, such as 0.1,0.05.")
    return values


def quantity(option: str, text: str | None, what: str, unit: str, example: str) -> float:
    """Value in SI of a number with a unit, written as in a case file."""
    from pydantic_core import PydanticCustomError

    from hydrosim.files.units import Quantity

    try:
        return Quantity(what, unit, example).read(text)
    except PydanticCustomError as error:
        raise InputError(f"{option}: {error.message()}.") from None


def seconds(option: str, text: str, otherwise: float) -> float:
    """Time [s] of a number with a unit, or of a plain number in s; ``otherwise`` without a text."""
    return quantity(option, text, "time", "s", "10 min") if text else otherwise


def refuse_options(context: typer.Context, used: Iterable[str], why: str) -> None:
    """Raises InputError if an option of the command is given that is not in ``used`` (names of
    parameters). ``why`` ends the message."""
    given = [
        max(option.opts, key=len)
        for option in context.command.params
        if option.param_type_name == "option"
        and option.name not in used
        and getattr(context.get_parameter_source(str(option.name)), "name", "") == "COMMANDLINE"
    ]
    if given:
        these = "this option" if len(given) == 1 else "these options"
        raise InputError(f"{', '.join(given)}: not possible with {why}. Leave {these} out.")


def names_in(text: str) -> list[str]:
    """Names or patterns, separated by commas."""
    return [name.strip() for name in text.split(",") if name.strip()]


def window_of(start: str, end: str) -> tuple[float, float]:
    """Times [s] of `From` and `To`, each of which may be left out. Raises InputError if the end is
    not after the start."""
    begin = seconds("--from", start, -inf)
    close = seconds("--to", end, inf)
    if begin > close:
        raise InputError(
            f"--to: found {close:g} s; expected a time after --from, which is {begin:g} s."
        )
    return begin, close


def one_of(kind: type[Choice], name: str, option: str) -> Choice:
    """Member of the enumeration ``kind`` with this ``name``. Raises InputError that names the
    option."""
    if name.strip() in set(kind):
        return kind(name.strip())
    raise InputError(f"{option}: found {name!r}; expected one of {', '.join(kind)}.")


# `--given KEY=VALUE`: data that a database's file lacks, and changes of the database.

GivenSettings = Annotated[
    list[str],
    typer.Option(
        "--given",
        metavar="KEY=VALUE",
        help="Data that the file lacks, or a change of the database; KEY as under"
        ' `hydrodynamics` in a case: density="1.025 tonne/m^3", depth="30 m",'
        " symmetrise=true.",
    ),
]


def given_database(file: Path, given: Sequence[str]) -> ChangedDatabase:
    """Database in a ``file``, with the ``given`` texts KEY=VALUE, whose keys are those under
    `hydrodynamics` in a case. Raises InputError that names the option."""
    from hydrosim.case.hydrodynamics import DatabaseFile
    from hydrosim.files.layers import apply_setting
    from hydrosim.files.messages import validate_document
    from hydrosim.files.yaml_nodes import COMMAND_LINE_PREFIX, compose_nodes

    document = compose_nodes(json.dumps({"file": str(file)}), COMMAND_LINE_PREFIX)
    assert document is not None
    for setting in given:
        if setting.partition("=")[0].strip() == "file":
            raise InputError(
                f"{COMMAND_LINE_PREFIX}{setting}: found file; expected another key. The file is"
                " the argument."
            )
        document = apply_setting(document, setting, COMMAND_LINE_PREFIX)
    return validate_document(document, DatabaseFile).build(lambda _: file)


# Results that a command shows: people may have changed such files.

MISSING_VARIABLE = re.compile(
    r"No variable named '(\w+)'|'Dataset' object has no attribute '(\w+)'"
)
"""What xarray says of a variable that a dataset lacks."""


def tells_absent_variables(command: Callable[..., Any]) -> Callable[..., Any]:
    """A ``command`` that shows a result, and refuses one that lacks a variable it needs."""

    @wraps(command)
    def show(**given: Any) -> Any:
        try:
            return command(**given)
        except (KeyError, AttributeError) as error:
            absent = MISSING_VARIABLE.search(str(error))
            if absent is None:
                raise
            path = next(value for value in given.values() if isinstance(value, Path))
            from hydrosim.results.validation import CHANGED_FILE_HINT  # loads the models of cases

            problem_text = f"found no variable {absent[1] or absent[2]}, which this page needs"
            raise InputError(f"{path}: {problem_text}. {CHANGED_FILE_HINT}") from error

    return show


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
