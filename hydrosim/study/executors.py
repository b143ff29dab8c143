"""Executors of many runs: outcome of one run, and pools of threads or of processes.

Processes talk to this one through pipes, which nobody else can open. A run whose process dies is
made again by a new process. If that one dies too, the run has failed, and the others go on. Runs
elsewhere are in `hydrosim.study.cluster`."""

from __future__ import annotations

import fnmatch
import gc
import signal
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from concurrent.futures import Future, ThreadPoolExecutor
from contextlib import contextmanager
from multiprocessing import get_context
from multiprocessing.connection import Connection
from queue import SimpleQueue
from threading import Event
from typing import TYPE_CHECKING, Any, NamedTuple, Protocol
from zlib import crc32

import numpy as np
import xarray as xr

from hydrosim.compile.waves import add_waves
from hydrosim.errors import HydrosimError, InputError
from hydrosim.files.interrupts import ENDING_SIGNALS
from hydrosim.files.yaml_nodes import source_context, with_hint
from hydrosim.results.channels import channel_names, match_channels
from hydrosim.results.dataset import KIND, new_dataset
from hydrosim.results.ledger import COMPANION, CONTACT_FORCE, EVALUATIONS, PARTED, RELATIVE
from hydrosim.results.memory import MEMORY_PREFIX
from hydrosim.results.runs_file import COMPLETE, NOT_RUN
from hydrosim.results.variables import describe_coordinates, quantity_attributes
from hydrosim.simulation import run_compiled
from hydrosim.statistics.figures import RequestedStatistic
from hydrosim.statistics.results import RunResults
from hydrosim.statistics.statistics import RECORDED_SUFFIX, columns, unit_statistics
from hydrosim.study.shared import RunTask, pack_task, unpack_task

if TYPE_CHECKING:
    from hydrosim.compile.compiled import Compiled
    from hydrosim.study.run_layout import RunLayout

# Outcome of one run of many: its end, and the data that are kept.

COUNT_ATTRIBUTES = {
    "solver_steps": "steps of the solver",
    "solver_events": "events of the solver",
    "energy_residual_relative": "largest residual of the energy balance, of the energy exchanged",
}
"""Attributes of a run that are variables of a set, and what they are."""
PER_RUN_ATTRIBUTES = {
    *(*COUNT_ATTRIBUTES, "solver_rejected", "solver_evaluations", "wall_time", "seeds", "warnings"),
    *(RELATIVE, CONTACT_FORCE, PARTED, COMPANION, EVALUATIONS),
    *("status", "status_message", "format", "date_created", KIND),
}
"""Attributes of a run that are no attributes of the set."""


class RunOutcome(NamedTuple):
    """How a run ended, why, what it was warned of; what is kept of it, and its attributes that are
    those of all."""

    status: str
    message: str = ""
    warnings: str = ""
    found: xr.Dataset | None = None
    attributes: Mapping[str, object] = {}


def reduce_run(
    run: xr.Dataset,
    variables: list[str],
    start: float,
    figures: Sequence[RequestedStatistic] = (),
    channels: Sequence[str] = (),
    lenient: bool = False,
) -> xr.Dataset:
    """What is kept of a run. Raises InputError where it has not all variables, figures and
    ``channels`` (patterns) that are asked for; a ``lenient`` one leaves out what it has not."""
    unknown = [name for name in variables if name not in run]
    variables = [name for name in variables if name in run] if lenient else variables
    if unknown and not lenient:
        series_names = ", ".join(
            str(name) for name, variable in run.items() if "time" in variable.dims
        )
        meant = next((name.partition(".")[0] for name in unknown if "." in name), "")
        text = f"variables: found {', '.join(unknown)}; expected some of: {series_names}"
        raise InputError(with_hint(text, f'did you mean "{meant}"?' if meant in run else ""))
    statistics, coords, attributes = columns(
        run, start, None, _chosen_channels(run, channels, lenient)
    )
    statistics = {name: of for name, of in statistics.items() if not name.endswith(RECORDED_SUFFIX)}
    variables_of_run: dict[str, Any] = {
        **statistics,
        **unit_statistics(run),
        "end_position": _end_position(run),
    }
    if "fender" in run.dims:
        variables_of_run |= {
            "first_contact": _first_contact_times(run),
            "contact_sequence": _contact_sequence(run),
        }
    variables_of_run |= {
        name: xr.Variable((), run.attrs[name], quantity_attributes(what, "1"))
        for name, what in COUNT_ATTRIBUTES.items()
    }
    variables_of_run[RELATIVE] = _relative_error(run)
    results = RunResults(run)
    why = results.explanation if "impulse" in run else xr.Dataset()
    check_figure_names(figures, {*variables_of_run, *coords, *run.variables, *why})
    for figure in figures:
        try:
            variables_of_run[figure.name] = figure.evaluate(results).variable
        except InputError:
            if not lenient:
                raise
    reduced = new_dataset(variables_of_run, coords, attributes)
    if why:
        reduced = xr.merge([reduced, why], join="exact", compat="equals")
    if variables:
        reduced = xr.merge([run[variables], reduced], join="outer", compat="equals")
    # adaptive runs end their last steps at different times
    return describe_coordinates(reduced).drop_vars(
        [name for name in reduced.coords if str(name).startswith(MEMORY_PREFIX)]
    )


def check_figure_names(figures: Sequence[RequestedStatistic], taken: Collection[object]) -> None:
    """Raises InputError where a figure has the name of a variable of the runs."""
    for figure in figures:
        if figure.name in taken:
            raise InputError(
                f"figures, criteria: found the name {figure.name}, which is that of a variable"
                f" of the runs; expected another one, such as {figure.name}_of_run."
            )


def _chosen_channels(run: xr.Dataset, patterns: Sequence[str], lenient: bool) -> list[str]:
    """The channels of a run that patterns fit."""
    if not patterns:
        return []
    channels = channel_names(run)
    if lenient:
        patterns = [pattern for pattern in patterns if fnmatch.filter(channels, pattern)]
    return match_channels(channels, patterns, "output.channels")


def pad_to_layout(
    run: xr.Dataset, form: RunLayout, keep: Callable[[xr.Dataset], xr.Dataset]
) -> xr.Dataset:
    """What is kept of a run, in the ``form`` of its set."""
    return form.pad_run(keep(run))


def _end_position(run: xr.Dataset) -> xr.Variable:
    end = run.variables["position"].isel(time=-1)
    end.attrs["long_name"] = "displacement and angles at the end of the run"
    return end


def _relative_error(run: xr.Dataset) -> xr.Variable:
    """The measured error of motions, NaN where a run did not measure it."""
    attributes = quantity_attributes("largest error of a motion, relative to its range", "1")
    return xr.Variable((), float(run.attrs.get(RELATIVE, np.nan)), attributes)


def _contact_sequence(run: xr.Dataset) -> xr.Variable:
    """A number for the order in which contacts open, stick and slip, as recorded. Runs with
    other orders have other numbers."""
    modes = run.fender_mode.transpose("time", "fender").values
    changed = np.any(modes[1:] != modes[:-1], axis=1)
    order = modes[np.append(True, changed)].astype(np.int8)
    attributes = {"units": "1", "long_name": "checksum of the order of contact modes"}
    return xr.Variable((), np.int64(crc32(np.ascontiguousarray(order).tobytes())), attributes)


def _first_contact_times(run: xr.Dataset) -> xr.Variable:
    """When each group of contacts touches first, NaN if it does not."""
    phase = run.contact_phase.transpose("contact_group", "time").values
    first = [run.time.values[np.argmax(of > 0)] if of.any() else np.nan for of in phase]
    attributes = {"units": "s", "long_name": "time of the first contact of a fender of the group"}
    return xr.Variable("contact_group", first, attributes)


@contextmanager
def collected_here() -> Iterator[None]:
    """Leaves the collection of garbage to this thread: netCDF knows no threads, and a worker might
    come upon a file that somebody left open, and close it, while this thread writes. What is there
    before stays: to look through it again and again would take longer than short runs."""
    gc.collect()
    enabled = gc.isenabled()
    gc.disable()
    gc.freeze()
    try:
        yield
    finally:
        gc.unfreeze()
        if enabled:
            gc.enable()


# Pools: threads of this process suffice, as time loops do without Python's lock.

QUEUE_FACTOR = (
    2  # runs for each worker that may be done or wait while an earlier one is not finished
)
Digest = Callable[[xr.Dataset], xr.Dataset]
"""What is kept of a run."""


class StopSignal(Protocol):
    """Tells runs on their way to end, as `threading.Event` does."""

    def is_set(self) -> bool:
        """Whether they are to end now."""


def outcome_of(work: RunTask | Exception, digest: Digest, stop: StopSignal) -> RunOutcome:
    """One run, in a thread of its own; it ends early once ``stop`` is set. Whatever goes wrong in
    it is its own failure, but for what is asked of all runs."""

    def interrupt_if_stopped(*_: float) -> None:
        if stop.is_set():
            raise KeyboardInterrupt

    if isinstance(work, Exception):
        return RunOutcome("failed", _error_message(work))
    if stop.is_set():
        return RunOutcome(NOT_RUN)
    try:
        with source_context(work.scene.places):
            compiled = add_waves(work.calm, work.scene, work.sea)
        run = run_compiled(compiled, interrupt_if_stopped, estimates=work.estimates, repeats=False)
    except KeyboardInterrupt:
        return RunOutcome("interrupted")
    except Exception as error:
        return RunOutcome("failed", _error_message(error))
    status = str(run.attrs["status"])
    if status != COMPLETE:
        return RunOutcome(status)
    common = {name: value for name, value in run.attrs.items() if name not in PER_RUN_ATTRIBUTES}
    try:
        digested = digest(run)
    except InputError:
        raise
    except Exception as error:
        return RunOutcome("failed", _error_message(error))
    return RunOutcome(status, "", str(run.attrs.get("warnings", "")), digested, common)


def _error_message(error: Exception) -> str:
    """A message; of an error that nobody has thought of also what it is."""
    return str(error) if isinstance(error, HydrosimError) else f"{type(error).__name__}: {error}"


class Pool(Protocol):
    """Makes runs. Of ``ahead`` runs the first may still be on its way while others wait."""

    ahead: int

    def begin(self, count: int) -> None:
        """So many runs will come."""

    def submit(self, work: RunTask | Exception, digest: Digest) -> Future[RunOutcome]:
        """A run that is begun now, or once there are others with it."""

    def flush(self) -> None:
        """Begin all that wait."""

    def stop(self) -> None:
        """End what is on its way: it is then interrupted or not run."""

    def close(self) -> None:
        """Nothing more will come."""


class Threads:
    """So many threads of this process."""

    def __init__(self, workers: int) -> None:
        self.ahead = (1 + QUEUE_FACTOR) * workers
        self._pool = ThreadPoolExecutor(workers)
        self._stop = Event()

    def begin(self, count: int) -> None:
        """Nothing to prepare."""

    def submit(self, work: RunTask | Exception, digest: Digest) -> Future[RunOutcome]:
        """A run by the next thread that is free."""
        return self._pool.submit(outcome_of, work, digest, self._stop)

    def flush(self) -> None:
        """All are begun."""

    def stop(self) -> None:
        """Runs end at their next look."""
        self._stop.set()

    def close(self) -> None:
        """Wait for all threads."""
        self._stop.set()
        self._pool.shutdown()


# Processes of this machine, one run at a time each.

SPAWN = get_context("spawn")  # a forked process would keep locks that other threads hold
MAX_PROCESSES_PER_RUN = 2  # processes that a run may bring down


class Processes:
    """A pool of so many processes. Each has a thread here that waits for its answers."""

    def __init__(self, workers: int) -> None:
        self.ahead = (1 + QUEUE_FACTOR) * workers
        self._threads = ThreadPoolExecutor(workers, initializer=_block_interrupts)
        self._stop, self._going = SPAWN.Pipe(duplex=False)
        self._idle: SimpleQueue[_Process | None] = SimpleQueue()
        for _ in range(workers):
            self._idle.put(None)

    def begin(self, count: int) -> None:
        """Nothing to prepare."""

    def submit(self, work: RunTask | Exception, digest: Digest) -> Future[RunOutcome]:
        """A run by the next process that is free."""
        return self._threads.submit(self._make, work, digest)

    def _make(self, work: RunTask | Exception, digest: Digest) -> RunOutcome:
        if isinstance(work, Exception):
            return outcome_of(work, digest, Event())
        process = self._idle.get()
        try:
            for _ in range(MAX_PROCESSES_PER_RUN):
                try:
                    process = process or _Process(self._stop)
                    return process.make(work, digest)
                except (EOFError, OSError) as error:
                    process = None
                    reason = type(error).__name__
        finally:
            self._idle.put(process)
        return RunOutcome(
            "failed",
            f"its process ended without an answer, {MAX_PROCESSES_PER_RUN} times ({reason});"
            " look at its memory",
        )

    def flush(self) -> None:
        """All are begun."""

    def stop(self) -> None:
        """Runs end at their next look."""
        self._going.close()

    def close(self) -> None:
        """Wait for all processes."""
        self.stop()
        self._threads.shutdown()
        while not self._idle.empty():
            process = self._idle.get()
            if process is not None:
                process.close()


class _Process:
    """A process at the other end of a pipe. It keeps the compiled model that it was sent last."""

    def __init__(self, stop: Connection) -> None:
        self._pipe, theirs = SPAWN.Pipe()
        self._process = SPAWN.Process(target=_serve_process, args=(theirs, stop), daemon=True)
        self._process.start()
        theirs.close()
        self._calm: Compiled | None = None

    def make(self, work: RunTask, digest: Digest) -> RunOutcome:
        """One run. Raises EOFError or OSError if the process died."""
        changed = None if work.calm is self._calm else work.calm
        self._pipe.send((changed, pack_task(work), digest))
        self._calm = work.calm
        answer = self._pipe.recv()
        if isinstance(answer, InputError):
            raise answer
        return answer

    def close(self) -> None:
        """End the process: nobody is left to ask it."""
        self._pipe.close()
        self._process.join()


class _Stop(NamedTuple):
    """Whether runs are to end: the other end of the pipe is closed, also where its process died."""

    pipe: Connection

    def is_set(self) -> bool:
        return self.pipe.poll()


def _serve_process(pipe: Connection, stop: Connection) -> None:
    """Make the runs that come through a pipe, until its other end is closed."""
    calm: Any = None
    while True:
        try:
            changed, packed, digest = pipe.recv()
        except (EOFError, ConnectionError):  # closed, or whoever asked was killed
            return
        calm = calm if changed is None else changed
        answer: RunOutcome | InputError
        try:
            answer = outcome_of(unpack_task(packed, calm), digest, _Stop(stop))
        except InputError as error:
            answer = error
        try:
            pipe.send(answer)
        except ConnectionError:
            return


def _block_interrupts() -> None:
    """Keep Ctrl-C and hang-ups from the processes that this thread starts: `Processes.stop` ends
    their runs."""
    if hasattr(signal, "pthread_sigmask"):
        signal.pthread_sigmask(signal.SIG_BLOCK, {*ENDING_SIGNALS} - {signal.SIGTERM})
