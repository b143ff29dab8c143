"""The largest height at which enough seeds hold their criteria, by bisection on common seeds.

Of N seeds, k fail at a height h with the probability of a binomial law of the true share q(h). The
limit is the largest height of a grid at which no more fail than are allowed, k <= N (1 - p). The
true limit, q(h) = 1 - p, is by 90 % where k is between the 5 % and 95 % quantiles of the law of
N and 1 - p, which the same search finds.

A seed that fails at a height is taken to fail at all greater ones, and one that holds to hold at
all smaller ones, so that few have to be run. What is found is then run: at the limit there is no
seed that was not.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import dataclass, field
from threading import Event
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
import scipy
import xarray as xr

from hydrosim.errors import InputError
from hydrosim.interrupts import delay_interrupts, raise_if_interrupted
from hydrosim.results.journal import Journal, StoredRun
from hydrosim.results.runs_file import COMPLETE
from hydrosim.statistics.figures import RequestedStatistic
from hydrosim.statistics.results import RunResults
from hydrosim.studies.many.executors import collected_here, outcome_of
from hydrosim.studies.many.outcome import RunOutcome
from hydrosim.studies.many.shared import SceneCache

if TYPE_CHECKING:
    from hydrosim.scene import Scene

CONFIDENCE = 0.9
RUNS_PER_CHUNK = 8  # runs at a time, after which there may be enough

Outcomes = Callable[[Sequence[tuple[int, int]]], np.ndarray]
"""Whether runs (height, seed) hold each criterion: (n, criteria) of truth values."""


class HeightLimit(NamedTuple):
    """The limit between two heights by their numbers, -1 if the smallest fails: the last at which
    no more fail than allowed, and the interval; how many seeds were ``inferred`` there before they
    were run, and how many of these were ``otherwise``."""

    limit: int
    low: int
    high: int
    inferred: int
    otherwise: int


def fewest_seeds(probability: float) -> int:
    """How many seeds bound a limit from below with this confidence."""
    n = 1
    while scipy.stats.binom.ppf(0.5 * (1.0 - CONFIDENCE), n, 1.0 - probability) < 1:
        n += 1
    return n


def allowed_failures(count: int, probability: float) -> tuple[int, int, int]:
    """How many of so many seeds may fail: at the limit, and at the ends of its interval."""
    tail = 0.5 * (1.0 - CONFIDENCE)
    low, high = scipy.stats.binom.ppf([tail, 1.0 - tail], count, 1.0 - probability)
    if low < 1:
        raise InputError(
            f"seeds: found {count}; expected {fewest_seeds(probability)} or more. With fewer"
            " seeds, even zero failures do not exclude a failure rate of"
            f" {1.0 - probability:.3g}."
        )
    return int(np.floor(count * (1.0 - probability) + 1e-9)), int(low) - 1, int(high)


@dataclass
class LimitSearch:
    """Runs of a sea of any of the ``heights`` (how many) and seeds, and what is known of them."""

    heights: int
    seeds: int
    outcomes: Outcomes
    known: dict[tuple[int, int], np.ndarray] = field(default_factory=dict)

    def find_limit(self, criteria: Sequence[int], probability: float) -> HeightLimit:
        """The limit of some of the ``criteria``, all of which must hold."""
        criterion_numbers = list(criteria)
        most, least, largest = allowed_failures(self.seeds, probability)
        top = self.heights
        inferred, otherwise = 0, 0
        while True:
            limit = self._last_allowed_height(criterion_numbers, most, top)
            if limit < 0:
                break
            unknown_seeds = [s for s in range(self.seeds) if (limit, s) not in self.known]
            guesses = [(s, self._infer_outcome(criterion_numbers, limit, s)) for s in unknown_seeds]
            self._run([(limit, s) for s in unknown_seeds])
            informed_guesses = [(s, guess) for s, guess in guesses if guess is not None]
            wrong = [
                guess != self._holds(criterion_numbers, (limit, s)) for s, guess in informed_guesses
            ]
            inferred, otherwise = inferred + len(wrong), otherwise + sum(wrong)
            if self._failing(criterion_numbers, limit) <= most:
                break
            top = limit
        low = self._last_allowed_height(criterion_numbers, least, max(limit, 0) + 1)
        high = self._last_allowed_height(criterion_numbers, largest, self.heights, limit) + 1
        return HeightLimit(limit, min(low, limit), max(high, limit + 1), inferred, otherwise)

    def failures(self, criteria: Sequence[int], height: int) -> np.ndarray:
        """How many seeds fail each criterion at a height, of those that were run there."""
        outcomes = [self.known[height, s] for s in range(self.seeds) if (height, s) in self.known]
        return np.sum(~np.array(outcomes)[:, list(criteria)], axis=0) if outcomes else np.zeros(0)

    def _last_allowed_height(self, of: list[int], most: int, above: int, below: int = -1) -> int:
        """The last height below ``above`` at which no more than ``most`` seeds fail."""
        while above - below > 1:
            middle = (below + above) // 2
            if self._is_allowed(of, most, middle):
                below = middle
            else:
                above = middle
        return below

    def _is_allowed(self, of: list[int], most: int, height: int) -> bool:
        """Whether no more than so many seeds fail, with as few runs as decide it."""
        while True:
            state = [self._infer_outcome(of, height, s) for s in range(self.seeds)]
            failing, unknown = state.count(False), [s for s, x in enumerate(state) if x is None]
            if failing > most:
                return False
            if failing + len(unknown) <= most:
                return True
            self._run([(height, s) for s in unknown[:RUNS_PER_CHUNK]])

    def _infer_outcome(self, of: list[int], height: int, seed: int) -> bool | None:
        """Whether a seed holds at a height, by its run there, or by those at others."""
        if (height, seed) in self.known:
            return self._holds(of, (height, seed))
        for other in range(height - 1, -1, -1):
            if (other, seed) in self.known and not self._holds(of, (other, seed)):
                return False
        for other in range(height + 1, self.heights):
            if (other, seed) in self.known and self._holds(of, (other, seed)):
                return True
        return None

    def _failing(self, of: list[int], height: int) -> int:
        return sum(not self._holds(of, (height, s)) for s in range(self.seeds))

    def _holds(self, of: list[int], run: tuple[int, int]) -> bool:
        return bool(self.known[run][of].all())

    def _run(self, runs: list[tuple[int, int]]) -> None:
        if runs:
            self.known |= dict(zip(runs, self.outcomes(runs), strict=True))


# Runs of which figures are all that is wanted, on all cores.


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
