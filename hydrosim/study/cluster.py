"""Runs by the workers of a scheduler of dask.distributed (extra ``cluster``).

Scenes go in batches, with what the client has compiled of them: databases are read and radiation is
fitted once. Workers give back what is kept of each run, which this process puts on the disk as it
comes, so that a study that was killed goes on here or on a cluster. A batch whose worker dies is
made by another one. Dask blames all that waits at a worker that dies: the runs of batches that it
gives up are made once more, each with nothing beside it, and one that kills its workers then, too,
is marked as failed. Where no worker is left for a while, nothing is waited for.

Scheduler and workers run whatever is sent to them. With tcp:// that is whatever anybody sends who
reaches their ports; with tls:// only what comes with a certificate.
"""

from __future__ import annotations

import logging
import pickle
from collections import deque
from collections.abc import Sequence
from concurrent.futures import Future
from contextlib import suppress
from functools import partial
from math import ceil
from threading import Event, RLock, Thread
from time import monotonic
from typing import TYPE_CHECKING, Any

from hydrosim.errors import InputError
from hydrosim.results.runs_file import NOT_RUN
from hydrosim.run.checkpoint import program_identity
from hydrosim.study.executors import Digest, RunOutcome, outcome_of
from hydrosim.study.shared import PackedTask, RunTask, pack_task, unpack_task

if TYPE_CHECKING:
    from hydrosim.compile.compiled import Compiled

CONNECT_TIMEOUT_S = 4  # s, to be answered by a scheduler, and again by a worker
# s without a worker, after which none is waited for; between looks
NO_WORKER_TIMEOUT_S = 60.0
POLL_INTERVAL_S = 2.0
MIN_POLLS = 5  # without a worker, at least: one that a busy scheduler answers late proves nothing
# runs in a batch; batches for each worker, at least
MAX_BATCH_RUNS = 50
MIN_BATCHES_PER_WORKER = 4
MAX_LOG_MESSAGES = (
    10  # that dask keeps, each a batch: 1000 of them are much to look through for garbage
)
Run = tuple[Future[RunOutcome], PackedTask]
OPEN_PORT_WARNING = "run whatever is sent to them: let nobody else reach these ports"


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
            self.close()
            raise
        self.size, self.ahead = MAX_BATCH_RUNS, MAX_BATCH_RUNS * self._count
        self._waiting: list[Run] = []
        self._calm: Compiled | None = None
        self._digest: Digest | None = None
        self._made: Any = None
        self._tasks: dict[Any, list[Future[RunOutcome]]] = {}
        self._suspects: deque[tuple[Run, Any, Any]] = deque()
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

    def begin(self, count: int) -> None:
        """Choose batches of which each worker has several."""
        self.size = min(MAX_BATCH_RUNS, ceil(count / (MIN_BATCHES_PER_WORKER * self._count)))
        self.ahead = (MIN_BATCHES_PER_WORKER - 1) * self.size * self._count

    def submit(self, work: RunTask | Exception, digest: Digest) -> Future[RunOutcome]:
        """A run that goes with the next batch."""
        future: Future[RunOutcome] = Future()
        if isinstance(work, Exception):
            future.set_result(outcome_of(work, digest, Event()))
            return future
        if work.calm is not self._calm:
            self.flush()
            self._calm = work.calm
            self._made = None
            self._digest = digest
        self._waiting.append((future, pack_task(work)))
        if len(self._waiting) >= self.size:
            self.flush()
        return future

    def flush(self) -> None:
        """Send the batch that waits."""
        if self._waiting:
            batch = self._waiting
            self._waiting = []
            self._send(batch, self._send_compiled(), self._digest)

    def _send_compiled(self) -> Any:
        """What is compiled, as bytes in a task: it is made again where its worker died."""
        if self._made is None:
            compiled = pickle.dumps(self._calm)
            self._made = self._client.submit(pickle.loads, compiled, pure=False)
        return self._made

    def _send(self, batch: Sequence[Run], made: Any, digest: Any, alone: bool = False) -> None:
        packed = [task for _, task in batch]
        with self._lock:
            task = self._client.submit(
                run_batch, program_identity(), made, packed, digest, pure=False
            )
            self._tasks[task] = [future for future, _ in batch]
        task.add_done_callback(partial(self._finish_batch, batch, made, digest, alone))

    def _finish_batch(
        self, batch: Sequence[Run], made: Any, digest: Any, alone: bool, task: Any
    ) -> None:
        """Hand on what a batch came to, or suspect its runs; once all is done, try one of these."""
        with self._lock:
            self._tasks.pop(task, None)
            if task.status == "error" and not alone and _is_death(task.exception()):
                self._suspects += [(run, made, digest) for run in batch]
            else:
                self._hand_on(batch, task)
            if self._suspects and not self._tasks:
                run, made, digest = self._suspects.popleft()
                self._send([run], made, digest, alone=True)

    def _hand_on(self, batch: Sequence[Run], task: Any) -> None:
        if task.status == "finished":
            outcomes = task.result()
        elif task.status == "cancelled":
            outcomes = [RunOutcome(NOT_RUN)] * len(batch)
        else:
            error = task.exception()
            if isinstance(error, InputError):
                for future, _ in batch:
                    future.set_exception(error)
                return
            outcomes = [RunOutcome("failed", _worker_error_message(error))] * len(batch)
        for (future, _), outcome in zip(batch, outcomes, strict=True):
            if not future.done():
                future.set_result(outcome)

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
                self._give_up()
                return

    def _give_up(self) -> None:
        """End all that is waited for with a message; what comes later is not looked at."""
        with self._lock:
            waiting = [future for futures in self._tasks.values() for future in futures]
            waiting += [future for future, _ in self._take_unsent()]
            tasks = list(self._tasks)
            self._tasks = {}
        for future in waiting:
            if not future.done():
                future.set_exception(
                    InputError(
                        f"--scheduler: no worker has been there for {NO_WORKER_TIMEOUT_S:g} s. What"
                        " is complete is kept: start workers, and give --resume."
                    )
                )
        with suppress(Exception):
            self._client.cancel(tasks, force=True)

    def _take_unsent(self) -> list[Run]:
        """Runs that have not been sent; there are none afterwards."""
        unsent = [*self._waiting, *(run for run, *_ in self._suspects)]
        self._waiting = []
        self._suspects = deque()
        return unsent

    def stop(self) -> None:
        """Runs that are not done are not run."""
        with self._lock:
            tasks = list(self._tasks)
            unsent = self._take_unsent()
        for future, _ in unsent:
            future.set_result(RunOutcome(NOT_RUN))
        self._client.cancel(tasks, force=True)

    def close(self) -> None:
        """Leave the scheduler."""
        self._closed.set()
        with suppress(Exception):
            self._client.close(timeout=CONNECT_TIMEOUT_S)


def run_batch(
    expected: str, calm: Compiled, works: Sequence[PackedTask], digest: Digest
) -> list[RunOutcome]:
    """Runs that differ in their waves alone, on a worker; InputError if this is another program."""
    if program_identity() != expected:
        raise InputError(
            f"--scheduler: found a worker with {program_identity()}; expected {expected}, as"
            " here. Install the same version there, and start the worker again."
        )
    return [outcome_of(unpack_task(packed, calm), digest, Event()) for packed in works]


def _program_digest() -> str:
    return program_identity()


def _is_death(error: BaseException | None) -> bool:
    return type(error).__name__ == "KilledWorker"


def _worker_error_message(error: BaseException | None) -> str:
    if _is_death(error):
        return "the workers that made this run died, each time; look at their memory"
    return f"{type(error).__name__}: {error}"
