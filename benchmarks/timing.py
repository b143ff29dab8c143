"""CPU times: of hydrosim's time loop, and medians of interleaved runs."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import partial
from statistics import median
from time import process_time
from typing import Any, NamedTuple, TypeVar

from benchmarks.scenes import Several
from hydrosim.simulation import run_compiled

Key = TypeVar("Key")


class Timed(NamedTuple):
    """A ``result``, and the CPU time [s] that it took."""

    result: Any
    seconds: float


def timed(function: Callable[[], Any]) -> Timed:
    """Call the function."""
    begin = process_time()
    result = function()
    return Timed(result, process_time() - begin)


def time_all(run: Several) -> Timed:
    """Simulate to a dataset; the time of that, all told but compiling the scene."""
    return timed(partial(run_compiled, run.compiled))


class _Marks:
    """CPU time at the first and the last report of progress, and the steps taken by then."""

    def __init__(self) -> None:
        self.first: tuple[float, int] | None = None
        self.last = (0.0, 0)

    def __call__(self, _: float, steps: int) -> None:
        self.last = (process_time(), steps)
        self.first = self.first or self.last

    def seconds(self) -> float:
        """Of all steps, the few before the first report by the pace of the others."""
        assert self.first is not None
        (begin, few), (end, all_) = self.first, self.last
        return (end - begin) * all_ / max(all_ - few, 1)


def time_loop(run: Several) -> Timed:
    """Simulate to a dataset by steps; the time is that of their loop alone, records included."""
    marks = _Marks()
    result = run_compiled(run.compiled, marks)
    return Timed(result, marks.seconds())


def interleaved(runs: Mapping[Key, Callable[[], Timed]], repeats: int) -> dict[Key, Timed]:
    """All runs in turn, ``repeats`` times after a first one that compiles: the last result of each,
    and the median of its times."""
    for run in runs.values():
        run()
    rounds = [{name: run() for name, run in runs.items()} for _ in range(repeats)]
    return {
        name: Timed(rounds[-1][name].result, median(each[name].seconds for each in rounds))
        for name in runs
    }
