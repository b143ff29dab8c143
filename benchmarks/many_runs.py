"""How many runs of the base case go through in a minute, on one core and on two, in what memory?

Seeds of the base case over 3 h, motions every second and statistics, into a netCDF file. What
workers wait for each other (for Python's lock, for the thread that writes) is told apart from what
they wait for a core that somebody else has: it is what a second core must lose on any machine.
"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from statistics import median
from tempfile import TemporaryDirectory
from threading import enumerate as threads
from time import perf_counter, process_time
from typing import NamedTuple

import psutil

from benchmarks.report import Answer, Row
from benchmarks.scenes import base_case
from hydrosim import simulate, simulate_many
from hydrosim.scene import Scene

HOURS, RUNS, REPEATS = 3.0, 16, 3
WORKERS = (1, 2)
LONG, SAMPLED = 1000, (10, 100, 300, 1000)
MEGABYTE = 1e6


class Trial(NamedTuple):
    """Wall time and CPU time of a run [s], on average; the share of the time that workers wait for
    each other; the memory [MB] after each run."""

    wall: float
    cpu: float
    waiting: float
    memory: list[float]


def answer() -> Answer:
    """Speed by the number of workers, and memory by the number of runs."""
    simulate(_seed(1))  # compiles, the first time
    trials: dict[int, list[Trial]] = {workers: [] for workers in WORKERS}
    busy, alone = [], []
    for _ in range(REPEATS):
        busy.append(psutil.cpu_percent(interval=1.0))
        alone.append(_alone())
        for workers in WORKERS:
            trials[workers].append(_trial(RUNS, workers))
    one = median(trial.wall for trial in trials[1])
    speeds = [_speed(workers, found, one) for workers, found in trials.items()]
    long = _trial(LONG, WORKERS[-1])
    memory: list[Row] = [{"runs": n, "memory [MB]": round(long.memory[n - 1])} for n in SAMPLED]
    title = f"{RUNS} seeds of {HOURS:g} h; medians of {REPEATS} interleaved repeats"
    return Answer(
        {title: speeds, f"Memory of the process, {WORKERS[-1]} workers": memory},
        [
            f"{LONG} runs took {LONG * long.wall / 60.0:.2f} min on {WORKERS[-1]} workers.",
            f"simulate by itself takes {median(alone):.2f} s of CPU a run.",
            f"Others kept the cores busy by {median(busy):.0f} % between the repeats.",
        ],
    )


def _alone() -> float:
    """CPU time of `simulate` [s]."""
    cpu = process_time()
    simulate(_seed(1))
    return process_time() - cpu


def _seed(seed: int) -> Scene:
    base = replace(base_case(), duration=3600.0 * HOURS).with_output(step=1.0)
    (train,) = base.environment.waves
    waves = (replace(train, seed=seed),)
    return replace(base, environment=replace(base.environment, waves=waves))


def _trial(runs: int, workers: int) -> Trial:
    process, memory = psutil.Process(), []
    busy: list[tuple[float, dict[str, float]]] = []
    scenes = [_seed(seed) for seed in range(1, runs + 1)]

    def note(*_: int) -> None:
        memory.append(process.memory_info().rss / MEGABYTE)
        busy.append((perf_counter(), _scheduled()))

    with TemporaryDirectory() as folder:
        wall, cpu = perf_counter(), process_time()
        path = Path(folder, "runs.nc")
        simulate_many(scenes, path, workers=workers, progress=note).close()
        times = (perf_counter() - wall) / runs, (process_time() - cpu) / runs
    return Trial(*times, _waiting(busy[0], busy[runs // 2]), memory)


def _scheduled() -> dict[str, float]:
    """What each worker has been on a core, or in the queue for one, until now [s]; on Linux."""
    stats = {t.name: Path(f"/proc/self/task/{t.native_id}/schedstat") for t in threads()}
    return {
        name: sum(map(int, path.read_text().split()[:2])) / 1e9
        for name, path in stats.items()
        if "PoolExecutor" in name and path.exists()
    }


def _waiting(first: tuple[float, dict[str, float]], last: tuple[float, dict[str, float]]) -> float:
    """The share of the time between two looks, while all workers have something to do, that they
    neither were on a core nor in the queue for one."""
    span = last[0] - first[0]
    shares = [1.0 - (last[1][name] - first[1][name]) / span for name in first[1]]
    return sum(shares) / len(shares) if shares else float("nan")


def _speed(workers: int, trials: list[Trial], one: float) -> Row:
    wall, cpu, waiting = (
        median(getattr(trial, name) for trial in trials) for name in ("wall", "cpu", "waiting")
    )
    return {
        "workers": workers,
        "runs/min": 60.0 / wall,
        "of one": one / wall,
        "CPU a run [s]": cpu,
        "waiting for each other": f"{waiting:.1%}",
    }
