"""Runs by processes of this machine, one run at a time each.

They talk to this process through pipes, which nobody else can open. A run whose process dies is
made again by a new process. If that one dies too, the run has failed, and the others go on.
"""

from __future__ import annotations

import signal
from concurrent.futures import Future, ThreadPoolExecutor
from multiprocessing import get_context
from multiprocessing.connection import Connection
from queue import SimpleQueue
from threading import Event
from typing import TYPE_CHECKING, Any, NamedTuple

from hydrosim.errors import InputError
from hydrosim.interrupts import ENDING_SIGNALS
from hydrosim.studies.many.outcome import RunOutcome
from hydrosim.studies.many.pools import QUEUE_FACTOR, Digest, outcome_of
from hydrosim.studies.many.work import RunTask, pack, unpack

if TYPE_CHECKING:
    from hydrosim.compiling.compiled import Compiled

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
        self._pipe.send((changed, pack(work), digest))
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
            answer = outcome_of(unpack(packed, calm), digest, _Stop(stop))
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
