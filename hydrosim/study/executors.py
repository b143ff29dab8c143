"""Executors of many runs: outcome of one run, runs in order, pools of threads or of processes.

Processes talk to this one through pipes, which nobody else can open. A run whose process dies is
made again by a new process. If that one dies too, the run has failed, and the others go on. Runs
elsewhere are in `hydrosim.study.cluster`."""

from __future__ import annotations

import gc
import signal
from collections.abc import Callable, Iterator
from concurrent.futures import FIRST_COMPLETED, Future, ThreadPoolExecutor, wait
from contextlib import contextmanager
from dataclasses import replace
from multiprocessing import get_context
from multiprocessing.connection import Connection
from queue import SimpleQueue
from threading import Event
from time import perf_counter
from typing import TYPE_CHECKING, Any, NamedTuple, Protocol

import xarray as xr

from hydrosim.compile.waves import add_waves
from hydrosim.errors import HydrosimError, InputError
from hydrosim.files.interrupts import ENDING_SIGNALS, delay_interrupts, raise_if_interrupted
from hydrosim.files.yaml_nodes import source_context
from hydrosim.results.dataset import KIND
from hydrosim.results.ledger import COMPANION, CONTACT_FORCE, EVALUATIONS, PARTED, RELATIVE
from hydrosim.results.runs_file import (
    COMPLETE,
    COUNT_ATTRIBUTES,
    INTERRUPTED,
    NOT_RUN,
    Journal,
    RunOutcome,
)
from hydrosim.simulation import run_compiled
from hydrosim.study.scene_cache import RunTask
from hydrosim.water.components import sea

if TYPE_CHECKING:
    from hydrosim.compile.compiled import Compiled

GC_TIME_FRACTION = 0.05  # of the time, at most, is spent on collecting garbage
PER_RUN_ATTRIBUTES = {
    *(*COUNT_ATTRIBUTES, "solver_rejected", "solver_evaluations", "wall_time", "seeds", "warnings"),
    *(RELATIVE, CONTACT_FORCE, PARTED, COMPANION, EVALUATIONS),
    *("status", "status_message", "format", "date_created", KIND),
}
"""Attributes of a run that are no attributes of the set."""

Digest = Callable[[xr.Dataset], xr.Dataset]
"""What is kept of a run."""


class StopSignal(Protocol):
    """Tells runs on their way to end, as `threading.Event` does."""

    def is_set(self) -> bool:
        """Whether they are to end now."""


def outcome_of(task: RunTask, digest: Digest, stop: StopSignal) -> RunOutcome:
    """One run, in a thread of its own; it ends early once ``stop`` is set. Whatever goes wrong in
    it is its own failure, but for what is asked of all runs."""

    def interrupt_if_stopped(*_: float) -> None:
        if stop.is_set():
            raise KeyboardInterrupt

    if stop.is_set():
        return RunOutcome(NOT_RUN)
    calm = task.calm
    assert calm is not None
    scene = replace(task.scene, bodies=calm.scene.bodies, initial=calm.scene.initial)
    try:
        with source_context(scene.places):
            compiled = add_waves(calm, scene, sea(scene.environment))
        run = run_compiled(compiled, interrupt_if_stopped, estimates=task.estimates, repeats=False)
    except KeyboardInterrupt:
        return RunOutcome(INTERRUPTED)
    except Exception as error:
        return _failure(error)
    status = str(run.attrs["status"])
    if status != COMPLETE:
        return RunOutcome(status)
    common = {name: value for name, value in run.attrs.items() if name not in PER_RUN_ATTRIBUTES}
    try:
        reduced = digest(run)
    except InputError:
        raise
    except Exception as error:
        return _failure(error)
    return RunOutcome(status, "", str(run.attrs.get("warnings", "")), reduced, common)


def _failure(error: Exception) -> RunOutcome:
    """A failed run; of an error that nobody has thought of also what it is."""
    is_foreseen = isinstance(error, HydrosimError)
    return RunOutcome("failed", str(error) if is_foreseen else f"{type(error).__name__}: {error}")


class Pool(Protocol):
    """An executor of runs. Of ``ahead`` runs the first may still be on its way while others
    wait."""

    ahead: int

    def submit(self, task: RunTask, digest: Digest) -> Future[RunOutcome]:
        """A run by the next worker that is free."""

    def shutdown(self, *, cancel_futures: bool = False) -> None:
        """Wait for all runs. With ``cancel_futures`` these end now: they are interrupted or not
        run."""


def make_runs(
    runs: range,
    compile_task: Callable[[int], RunTask | Exception],
    digest: Digest,
    pool: Pool,
    take: Callable[[int, RunOutcome], None],
    journal: Journal | None = None,
    progress: Callable[[int, int], None] | None = None,
) -> None:
    """Make ``runs`` by a pool, which is closed in the end; ``take`` receives each in order.

    Complete runs go into the ``journal`` as they come; those that it has are not made. An interrupt
    from the keyboard ends all runs, which `take` receives as well. ``progress`` receives how many
    runs are done, of how many. Raises InputError where a run has not what is asked of all."""
    pending: dict[int, Future[RunOutcome]] = {}
    done = 0
    due = 0.0

    def start_run(run: int) -> Future[RunOutcome]:
        future: Future[RunOutcome] = Future()
        if journal is not None and run in journal:
            future.set_result(journal.read(run))
            return future
        task = compile_task(run)
        if not isinstance(task, Exception):
            return pool.submit(task, digest)
        future.set_result(_failure(task))
        return future

    def store_complete() -> None:
        for run, future in pending.items():
            if journal is None or run in journal or not future.done() or future.exception():
                continue
            if (outcome := future.result()).dataset is not None:
                with delay_interrupts():
                    journal.add(run, outcome)

    def take_first() -> None:
        nonlocal done, due
        run, future = next(iter(pending.items()))
        while not future.done():
            wait([f for f in pending.values() if not f.done()], return_when=FIRST_COMPLETED)
            store_complete()
        with delay_interrupts():
            if journal is not None and run not in journal:
                store_complete()
            take(run, future.result())
            del pending[run]
            done += 1
        if perf_counter() > due:
            due = _collect_garbage()
        if progress is not None:
            progress(done, len(runs))

    with _collect_here():
        try:
            for run in runs:
                raise_if_interrupted()
                pending[run] = start_run(run)
                while len(pending) > pool.ahead:
                    take_first()
            while pending:
                raise_if_interrupted()
                take_first()
        except KeyboardInterrupt:
            pool.shutdown(cancel_futures=True)
            progress = None
            while pending:
                take_first()
        finally:
            pool.shutdown(cancel_futures=True)


@contextmanager
def _collect_here() -> Iterator[None]:
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


def _collect_garbage() -> float:
    """Collect garbage; when to do so again."""
    started = perf_counter()
    gc.collect()
    ended = perf_counter()
    return ended + (ended - started) / GC_TIME_FRACTION


QUEUE_FACTOR = 2
"""Runs for each worker that may be done or wait while an earlier one is not finished."""


class Threads:
    """So many threads of this process, which suffice, as time loops do without Python's lock."""

    def __init__(self, workers: int) -> None:
        self.ahead = (1 + QUEUE_FACTOR) * workers
        self._threads = ThreadPoolExecutor(workers, initializer=_block_interrupts)
        self._stop = Event()

    def submit(self, task: RunTask, digest: Digest) -> Future[RunOutcome]:
        """A run by the next thread that is free."""
        return self._threads.submit(self._make_run, task, digest)

    def _make_run(self, task: RunTask, digest: Digest) -> RunOutcome:
        return outcome_of(task, digest, self._stop)

    def shutdown(self, *, cancel_futures: bool = False) -> None:
        """Wait for all threads; runs that are to end do so at their next look."""
        if cancel_futures:
            self._stop.set()
        self._threads.shutdown()


# Processes of this machine, one run at a time each.

SPAWN = get_context("spawn")  # a forked process would keep locks that other threads hold
MAX_PROCESSES_PER_RUN = 2  # processes that a run may bring down


class Processes(Threads):
    """A pool of so many processes. Each has a thread here that waits for its answers."""

    def __init__(self, workers: int) -> None:
        super().__init__(workers)
        self._listening, self._going = SPAWN.Pipe(duplex=False)
        self._idle: SimpleQueue[_Process | None] = SimpleQueue()
        for _ in range(workers):
            self._idle.put(None)

    def _make_run(self, task: RunTask, digest: Digest) -> RunOutcome:
        process = self._idle.get()
        try:
            for _ in range(MAX_PROCESSES_PER_RUN):
                try:
                    process = process or _Process(self._listening)
                    return process.make_run(task, digest)
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

    def shutdown(self, *, cancel_futures: bool = False) -> None:
        """Wait for all processes; runs that are to end do so at their next look."""
        if cancel_futures:
            self._going.close()
        super().shutdown()
        while not self._idle.empty():
            process = self._idle.get()
            if process is not None:
                process.close()


class _Process:
    """A process at the other end of a pipe. It keeps the compiled model that it was sent last."""

    def __init__(self, listening: Connection) -> None:
        self._pipe, theirs = SPAWN.Pipe()
        self._process = SPAWN.Process(target=_serve_process, args=(theirs, listening), daemon=True)
        self._process.start()
        theirs.close()
        self._calm: Compiled | None = None

    def make_run(self, task: RunTask, digest: Digest) -> RunOutcome:
        """One run. Raises EOFError or OSError if the process died."""
        changed = None if task.calm is self._calm else task.calm
        self._pipe.send((changed, task._replace(calm=None), digest))
        self._calm = task.calm
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


def _serve_process(pipe: Connection, listening: Connection) -> None:
    """Make the runs that come through a pipe, until its other end is closed."""
    calm: Any = None
    while True:
        try:
            changed, task, digest = pipe.recv()
        except (EOFError, ConnectionError):  # closed, or whoever asked was killed
            return
        calm = calm if changed is None else changed
        answer: RunOutcome | InputError
        try:
            answer = outcome_of(task._replace(calm=calm), digest, _Stop(listening))
        except InputError as error:
            answer = error
        try:
            pipe.send(answer)
        except ConnectionError:
            return


def _block_interrupts() -> None:
    """Keep Ctrl-C and hang-ups from the threads of a pool, and from the processes that these start:
    the pool ends their runs."""
    if hasattr(signal, "pthread_sigmask"):
        signal.pthread_sigmask(signal.SIG_BLOCK, {*ENDING_SIGNALS} - {signal.SIGTERM})
