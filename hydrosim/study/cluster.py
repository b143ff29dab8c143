"""Runs by the workers of a scheduler of dask.distributed (extra ``cluster``).

Scenes go with what the client has compiled of them: databases are read and radiation is fitted
once. Workers give back what is kept of each run, which this process puts on the disk as it comes,
so that a study that was killed goes on here or on a cluster. A run whose worker dies is made by
another one. Dask blames all that waits at a worker that dies: the runs that it gives up are made
once more, each with nothing beside it, and one that kills its workers then, too, is marked as
failed. Where no worker is left for a while, nothing is waited for.

Scheduler and workers run whatever is sent to them. With tcp:// that is whatever anybody sends who
reaches their ports; with tls:// only what comes with a certificate.
"""

from __future__ import annotations

import logging
import pickle
from collections import deque
from concurrent.futures import Future
from contextlib import suppress
from functools import partial
from threading import Event, RLock, Thread
from time import monotonic
from typing import TYPE_CHECKING, Any, NamedTuple

from hydrosim.errors import InputError
from hydrosim.results.runs_file import NOT_RUN, RunOutcome
from hydrosim.run.checkpoint import program_identity
from hydrosim.study.executors import Digest, outcome_of
from hydrosim.study.scene_cache import RunTask

if TYPE_CHECKING:
    from hydrosim.compile.compiled import Compiled

CONNECT_TIMEOUT_S = 4  # s, to be answered by a scheduler, and again by a worker
# s without a worker, after which none is waited for; between looks
NO_WORKER_TIMEOUT_S = 60.0
POLL_INTERVAL_S = 2.0
MIN_POLLS = 5  # without a worker, at least: one that a busy scheduler answers late proves nothing
RUNS_PER_WORKER = 20  # runs for each worker that may be done or wait while an earlier one is made
MAX_LOG_MESSAGES = 10  # that dask keeps: many are much to look through for garbage
OPEN_PORT_WARNING = "run whatever is sent to them: let nobody else reach these ports"


class SentRun(NamedTuple):
    """A run that workers make: who waits for it, its ``compiled`` scene on the cluster, its task
    without that, and what is kept of it."""

    future: Future[RunOutcome]
    compiled: Any
    task: RunTask
    digest: Digest


class Cluster:
    """A pool of the workers of the scheduler at an ``address`` ("tcp://HOST:8786").

    Raises InputError where dask is missing, nobody answers, or a worker has another program.
    """

    def __init__(self, address: str) -> None:
        try:
            import dask
            import distributed
        except ImportError:
            raise InputError(
                "--scheduler: needs dask.distributed; pip install 'hydrosim[cluster]'"
            ) from None
        logging.getLogger("distributed").setLevel(logging.CRITICAL)
        dask.config.set({"distributed.admin.low-level-log-length": MAX_LOG_MESSAGES})
        self._closed = Event()
        self._client = self._connect(distributed, address)
        try:
            self._count = self._count_workers()
        except BaseException:
            self.shutdown()
            raise
        self.ahead = RUNS_PER_WORKER * self._count
        self._calm: Compiled | None = None
        self._compiled: Any = None
        self._sent: dict[Any, Future[RunOutcome]] = {}
        self._suspects: deque[SentRun] = deque()
        self._lock = RLock()
        Thread(target=self._watch, daemon=True).start()

    def _connect(self, distributed: Any, address: str) -> Any:
        try:
            return distributed.Client(address, timeout=CONNECT_TIMEOUT_S, set_as_default=False)
        except TypeError:  # dask says so of tls:// without certificates
            raise InputError(
                f"--scheduler: found {address}, but dask is told of no certificate; expected one"
                " for tls://. Set DASK_DISTRIBUTED__COMM__TLS__CA_FILE, ..__TLS__CLIENT__CERT and"
                " ..__TLS__CLIENT__KEY to the files that the scheduler was started with."
            ) from None
        except (OSError, ValueError, ImportError) as error:
            raise InputError(
                f"--scheduler: found {address}, which does not answer within {CONNECT_TIMEOUT_S} s"
                f" ({type(error).__name__}); expected the address of a scheduler, such as"
                " tcp://127.0.0.1:8786, or local. Is it running (dask scheduler), and may this"
                " machine reach it?"
            ) from None

    def _count_workers(self) -> int:
        """How many workers there are, all with this program."""
        with suppress(TimeoutError):
            self._client.wait_for_workers(1, timeout=CONNECT_TIMEOUT_S)
        own_program = program_identity()
        for worker, worker_program in self._client.run(_program_digest, on_error="return").items():
            if isinstance(worker_program, OSError):  # it has died just now: others make its runs
                continue
            if worker_program != own_program:
                missing = "cannot import hydrosim.study.cluster"
                description = worker_program if isinstance(worker_program, str) else missing
                raise InputError(
                    f"--scheduler: found the worker {worker} with another program ({description});"
                    f" expected {own_program}. Install the same versions there."
                )
        count = len(self._client.scheduler_info(n_workers=-1)["workers"])
        if not count:
            raise InputError("--scheduler: it has no workers; start some (dask worker ADDRESS).")
        return count

    @property
    def title(self) -> str:
        """Who works, and whether anybody may send them code."""
        scheduler = self._client.scheduler.address
        warning = (
            "" if scheduler.startswith("tls://") else f"; scheduler and workers {OPEN_PORT_WARNING}"
        )
        return f"{self._count} workers at {scheduler}{warning}"

    def submit(self, task: RunTask, digest: Digest) -> Future[RunOutcome]:
        """A run by the next worker that is free. What is compiled goes as bytes in a task: it is
        made again where its worker died."""
        if task.calm is not self._calm:
            self._calm = task.calm
            self._compiled = self._client.submit(pickle.loads, pickle.dumps(task.calm), pure=False)
        run = SentRun(Future(), self._compiled, task._replace(calm=None), digest)
        self._send(run)
        return run.future

    def _send(self, run: SentRun, alone: bool = False) -> None:
        with self._lock:
            sent = self._client.submit(make_run, program_identity(), *run[1:], pure=False)
            self._sent[sent] = run.future
        sent.add_done_callback(partial(self._finish_run, run, alone))

    def _finish_run(self, run: SentRun, alone: bool, sent: Any) -> None:
        """Hand on what a run came to, or suspect it; once all is done, try one that is
        suspected."""
        with self._lock:
            self._sent.pop(sent, None)
            if sent.status == "error" and not alone and _is_death(sent.exception()):
                self._suspects.append(run)
            elif not run.future.done():
                _hand_on(sent, run.future)
            if self._suspects and not self._sent:
                self._send(self._suspects.popleft(), alone=True)

    def _watch(self) -> None:
        """See that there are workers, or say that there are none; a scheduler that is gone has
        none."""
        last_seen = monotonic()
        polls = 0
        while not self._closed.wait(POLL_INTERVAL_S):
            polls += 1
            with suppress(Exception):
                if self._client.scheduler_info(n_workers=-1)["workers"]:
                    last_seen = monotonic()
                    polls = 0
            if polls >= MIN_POLLS and monotonic() - last_seen > NO_WORKER_TIMEOUT_S:
                self._end_all(
                    InputError(
                        f"--scheduler: no worker has been there for {NO_WORKER_TIMEOUT_S:g} s. What"
                        " is complete is kept: start workers, and give --resume."
                    )
                )
                return

    def _end_all(self, error: InputError | None = None) -> None:
        """End all that is waited for: it is not run, or has an error. What comes later is not
        looked at."""
        with self._lock:
            sent = list(self._sent)
            waiting = [*self._sent.values(), *(run.future for run in self._suspects)]
            self._sent = {}
            self._suspects = deque()
            for future in waiting:
                if error is not None:
                    future.set_exception(error)
                else:
                    future.set_result(RunOutcome(NOT_RUN))
        with suppress(Exception):
            self._client.cancel(sent, force=True)

    def shutdown(self, *, cancel_futures: bool = False) -> None:
        """Leave the scheduler. With ``cancel_futures`` runs that are not done are not run."""
        if cancel_futures:
            self._end_all()
        self._closed.set()
        with suppress(Exception):
            self._client.close(timeout=CONNECT_TIMEOUT_S)


def make_run(expected: str, calm: Compiled, task: RunTask, digest: Digest) -> RunOutcome:
    """A run on a worker; InputError if this is another program."""
    if program_identity() != expected:
        raise InputError(
            f"--scheduler: found a worker with {program_identity()}; expected {expected}, as"
            " here. Install the same version there, and start the worker again."
        )
    return outcome_of(task._replace(calm=calm), digest, Event())


def _hand_on(sent: Any, future: Future[RunOutcome]) -> None:
    """Give the outcome of a task to who waits for it."""
    if sent.status == "finished":
        future.set_result(sent.result())
        return
    if sent.status == "cancelled":
        future.set_result(RunOutcome(NOT_RUN))
        return
    error = sent.exception()
    if isinstance(error, InputError):
        future.set_exception(error)
        return
    death = "the workers that made this run died, each time; look at their memory"
    message = death if _is_death(error) else f"{type(error).__name__}: {error}"
    future.set_result(RunOutcome("failed", message))


def _program_digest() -> str:
    return program_identity()


def _is_death(error: BaseException | None) -> bool:
    return type(error).__name__ == "KilledWorker"
