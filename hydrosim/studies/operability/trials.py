"""Runs of which figures are all that is wanted, on all cores."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from concurrent.futures import Future, ThreadPoolExecutor
from threading import Event
from typing import TYPE_CHECKING

import numpy as np
import xarray as xr

from hydrosim.interrupts import delay_interrupts, raise_if_interrupted
from hydrosim.results.journal import Journal, StoredRun
from hydrosim.results.runs_file import COMPLETE
from hydrosim.statistics.figures import RequestedStatistic
from hydrosim.statistics.results import RunResults
from hydrosim.studies.many.garbage import collected_here
from hydrosim.studies.many.outcome import RunOutcome
from hydrosim.studies.many.pools import outcome_of
from hydrosim.studies.many.shared import SceneCache

if TYPE_CHECKING:
    from hydrosim.scene import Scene


class Trials:
    """Runs scenes by so many ``workers`` for their ``figures``; counts them and those that failed,
    of which ``message`` is the first. Runs are numbered in the order in which they are asked for:
    those that a ``journal`` keeps are taken from there, others are added to it."""

    def __init__(
        self,
        figures: Sequence[RequestedStatistic],
        workers: int,
        progress: Callable[[int], None] = lambda _: None,
        journal: Journal | None = None,
    ) -> None:
        self.figures, self.workers, self.progress = tuple(figures), workers, progress
        self.count, self.failed, self.message = 0, 0, ""
        self._shared = SceneCache()
        self._journal = journal

    def values(self, scenes: Sequence[Scene]) -> tuple[np.ndarray, np.ndarray]:
        """The figures (n, nf) of each scene, and whether its run came to its end (n,)."""
        raise_if_interrupted()
        runs = range(self.count, self.count + len(scenes))
        stop = Event()
        with collected_here(), ThreadPoolExecutor(self.workers) as pool:
            try:
                futures = [
                    self._start_run(run, scene, pool, stop)
                    for run, scene in zip(runs, scenes, strict=True)
                ]
                outcomes = [
                    self._record_outcome(run, future.result())
                    for run, future in zip(runs, futures, strict=True)
                ]
            finally:
                stop.set()
        if any(outcome.status == "interrupted" for outcome in outcomes):
            raise KeyboardInterrupt
        self.count += len(scenes)
        figures = np.full((len(scenes), len(self.figures)), np.nan)
        for row, outcome in zip(figures, outcomes, strict=True):
            if outcome.found is not None:
                row[:] = [float(outcome.found[figure.name]) for figure in self.figures]
            else:
                self.failed += 1
                self.message = self.message or outcome.message
        self.progress(self.count)
        return figures, np.array([outcome.found is not None for outcome in outcomes])

    def _start_run(
        self, run: int, scene: Scene, pool: ThreadPoolExecutor, stop: Event
    ) -> Future[RunOutcome]:
        """A run that is in the journal, or is being made."""
        if self._journal is None or run not in self._journal:
            return pool.submit(outcome_of, self._shared.compile_task(scene), self._figures, stop)
        future: Future[RunOutcome] = Future()
        future.set_result(RunOutcome(COMPLETE, found=self._journal.read(run).found))
        return future

    def _record_outcome(self, run: int, outcome: RunOutcome) -> RunOutcome:
        """The outcome of a run, which is in the journal if it is complete."""
        journal = self._journal
        if journal is not None and run not in journal and outcome.found is not None:
            with delay_interrupts():
                journal.add(run, StoredRun(outcome.found, {}, ""))
        return outcome

    def _figures(self, run: xr.Dataset) -> xr.Dataset:
        results = RunResults(run)
        return xr.Dataset({figure.name: figure.evaluate(results) for figure in self.figures})
