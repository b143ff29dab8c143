"""Where the runs of a set are made: by threads of this process, as time loops do without Python's
lock; or elsewhere, see `hydrosim.studies.many.cluster`."""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import Future, ThreadPoolExecutor
from threading import Event
from typing import TYPE_CHECKING, Protocol

import xarray as xr

from hydrosim.compiling.without_waves import add_waves
from hydrosim.documents.yaml_nodes import source_context
from hydrosim.errors import HydrosimError, InputError
from hydrosim.results.runs_file import COMPLETE, NOT_RUN
from hydrosim.studies.many.outcome import PER_RUN_ATTRIBUTES, RunOutcome
from hydrosim.studies.run.simulation import run_compiled

if TYPE_CHECKING:
    from hydrosim.studies.many.work import RunTask

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

    def watch(*_: float) -> None:
        if stop.is_set():
            raise KeyboardInterrupt

    if isinstance(work, Exception):
        return RunOutcome("failed", _error_message(work))
    if stop.is_set():
        return RunOutcome(NOT_RUN)
    try:
        with source_context(work.scene.places):
            compiled = add_waves(work.calm, work.scene, work.sea)
        run = run_compiled(compiled, watch, estimates=work.estimates, repeats=False)
    except KeyboardInterrupt:
        return RunOutcome("interrupted")
    except Exception as error:
        return RunOutcome("failed", _error_message(error))
    status = str(run.attrs["status"])
    if status != COMPLETE:
        return RunOutcome(status)
    common = {name: value for name, value in run.attrs.items() if name not in PER_RUN_ATTRIBUTES}
    try:
        found = digest(run)
    except InputError:
        raise
    except Exception as error:
        return RunOutcome("failed", _error_message(error))
    return RunOutcome(status, "", str(run.attrs.get("warnings", "")), found, common)


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
