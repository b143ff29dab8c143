"""Where the runs of a set are made: by threads of this process, as time loops do without Python's
lock; or elsewhere, see `hydrosim.studies.many.cluster`."""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import Future, ThreadPoolExecutor
from threading import Event
from typing import TYPE_CHECKING, Protocol

import xarray as xr

from hydrosim.studies.many.outcome import Outcome, outcome_of

if TYPE_CHECKING:
    from hydrosim.studies.many.work import Work

AHEAD = 2  # runs for each worker that may be done or wait while an earlier one is not finished
Digest = Callable[[xr.Dataset], xr.Dataset]
"""What is kept of a run."""


class Pool(Protocol):
    """Makes runs. Of ``ahead`` runs the first may still be on its way while others wait."""

    ahead: int

    def begin(self, count: int) -> None:
        """So many runs will come."""

    def submit(self, work: Work | Exception, digest: Digest) -> Future[Outcome]:
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
        self.ahead = (1 + AHEAD) * workers
        self._pool, self._stop = ThreadPoolExecutor(workers), Event()

    def begin(self, count: int) -> None:
        """Nothing to prepare."""

    def submit(self, work: Work | Exception, digest: Digest) -> Future[Outcome]:
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
