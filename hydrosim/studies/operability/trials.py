"""Runs of which figures are all that is wanted, on all cores."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from threading import Event
from typing import TYPE_CHECKING

import numpy as np
import xarray as xr

from hydrosim.statistics.figures import Figure, figure_of
from hydrosim.studies.many.garbage import collected_here
from hydrosim.studies.many.pools import outcome_of
from hydrosim.studies.many.shared import Shared

if TYPE_CHECKING:
    from hydrosim.scene import Scene


class Trials:
    """Runs scenes by so many ``workers`` for their ``figures``; counts them and those that failed,
    of which ``message`` is the first."""

    def __init__(
        self,
        figures: Sequence[Figure],
        workers: int,
        progress: Callable[[int], None] = lambda _: None,
    ) -> None:
        self.figures, self.workers, self.progress = tuple(figures), workers, progress
        self.count, self.failed, self.message = 0, 0, ""
        self._shared = Shared()

    def values(self, scenes: Sequence[Scene]) -> tuple[np.ndarray, np.ndarray]:
        """The figures (n, nf) of each scene, and whether its run came to its end (n,)."""
        stop = Event()
        with collected_here(), ThreadPoolExecutor(self.workers) as pool:
            try:
                futures = [
                    pool.submit(outcome_of, self._shared.prepared(scene), self._figures, stop)
                    for scene in scenes
                ]
                outcomes = [future.result() for future in futures]
            finally:
                stop.set()
        if any(outcome.status == "interrupted" for outcome in outcomes):
            raise KeyboardInterrupt
        self.count += len(scenes)
        found = np.full((len(scenes), len(self.figures)), np.nan)
        for row, outcome in zip(found, outcomes, strict=True):
            if outcome.found is not None:
                row[:] = [float(outcome.found[figure.name]) for figure in self.figures]
            else:
                self.failed += 1
                self.message = self.message or outcome.message
        self.progress(self.count)
        return found, np.array([outcome.found is not None for outcome in outcomes])

    def _figures(self, run: xr.Dataset) -> xr.Dataset:
        return xr.Dataset({figure.name: figure_of(run, figure) for figure in self.figures})
