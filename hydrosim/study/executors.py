"""Who collects garbage while many runs are made."""

from __future__ import annotations

import gc
import signal
from collections.abc import Callable, Iterator
from concurrent.futures import Future, ThreadPoolExecutor
from contextlib import contextmanager
from multiprocessing import get_context
from multiprocessing.connection import Connection
from queue import SimpleQueue
from threading import Event
from typing import TYPE_CHECKING, Any, NamedTuple, Protocol

import xarray as xr

from hydrosim.compile.compile import add_waves
from hydrosim.errors import HydrosimError, InputError
from hydrosim.files.interrupts import ENDING_SIGNALS
from hydrosim.files.yaml_nodes import source_context
from hydrosim.results.runs_file import COMPLETE, NOT_RUN
from hydrosim.simulation import run_compiled
from hydrosim.study.outcome import PER_RUN_ATTRIBUTES, RunOutcome
from hydrosim.study.shared import RunTask, pack_task, unpack_task

if TYPE_CHECKING:
    from hydrosim.compile.compiled import Compiled


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


# Where the runs of a set are made: by threads of this process, as time loops do without Python's
# lock; or elsewhere, see `hydrosim.study.cluster`.

QUEUE_FACTOR = (
    2  # runs for each worker that may be done or wait while an earlier one is not finished
)
Digest = Callable[[xr.Dataset], xr.Dataset]
"""What is kept of a run."""


class Stop(Protocol):
    """Tells runs on their way to end, as `threading.Event` does."""

    def is_set(self) -> bool:
        """Whether they are to end now."""


def outcome_of(work: RunTask | Exception, digest: Digest, stop: Stop) -> RunOutcome:
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


# Runs by processes of this machine, one run at a time each.
#
# They talk to this process through pipes, which nobody else can open. A run whose process dies is
# made again by a new process. If that one dies too, the run has failed, and the others go on.

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
        self._process = SPAWN.Process(target=_serve, args=(theirs, stop), daemon=True)
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


def _serve(pipe: Connection, stop: Connection) -> None:
    """Make the runs that come through a pipe, until its other end is closed."""
    calm: Any = None
    while True:
        try:
            changed, packed, digest = pipe.recv()
        except EOFError:
            return
        calm = calm if changed is None else changed
        answer: RunOutcome | InputError
        try:
            answer = outcome_of(unpack_task(packed, calm), digest, _Stop(stop))
        except InputError as error:
            answer = error
        try:
            pipe.send(answer)
        except BrokenPipeError:  # whoever asked has died
            return


def _block_interrupts() -> None:
    """Keep Ctrl-C and hang-ups from the processes that this thread starts: `Processes.stop` ends
    their runs."""
    if hasattr(signal, "pthread_sigmask"):
        signal.pthread_sigmask(signal.SIG_BLOCK, {*ENDING_SIGNALS} - {signal.SIGTERM})
