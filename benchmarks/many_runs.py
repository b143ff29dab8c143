"""How many runs of the base case go through in a minute, on one core and on two, in what memory?

Seeds of the base case over 3 h, motions every second and statistics, into a netCDF file.
"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from statistics import median
from tempfile import TemporaryDirectory
from time import perf_counter, process_time
from typing import NamedTuple

import psutil

from benchmarks.base_case import base_case
from benchmarks.report import Answer, Row
from hydrosim import simulate, simulate_many
from hydrosim.scene import Scene

HOURS, RUNS, REPEATS = 3.0, 16, 3
WORKERS = (1, 2)
LONG, SAMPLED = 64, (4, 8, 16, 32, 64)
MEGABYTE = 1e6


class Trial(NamedTuple):
    """Wall time and CPU time of a run [s], on average, and the memory [MB] after each run."""

    wall: float
    cpu: float
    memory: list[float]


def answer() -> Answer:
    """Speed by the number of workers, and memory by the number of runs."""
    loop = simulate(_seed(1)).attrs["wall_time"]  # compiles, the first time
    loop = min(loop, simulate(_seed(1)).attrs["wall_time"])
    trials: dict[int, list[Trial]] = {workers: [] for workers in WORKERS}
    busy = []
    for _ in range(REPEATS):
        busy.append(psutil.cpu_percent(interval=1.0))
        for workers in WORKERS:
            trials[workers].append(_trial(RUNS, workers))
    one = median(trial.wall for trial in trials[1])
    speeds = [_speed(workers, found, one, loop) for workers, found in trials.items()]
    grown = _trial(LONG, WORKERS[-1]).memory
    memory: list[Row] = [{"runs": n, "memory [MB]": round(grown[n - 1])} for n in SAMPLED]
    title = f"{RUNS} seeds of {HOURS:g} h; medians of {REPEATS} interleaved repeats"
    return Answer(
        {title: speeds, f"Memory of the process, {WORKERS[-1]} workers": memory},
        [f"Others kept the cores busy by {median(busy):.0f} % between the repeats."],
    )


def _seed(seed: int) -> Scene:
    base = replace(base_case(), duration=3600.0 * HOURS, output_step=1.0)
    (train,) = base.environment.waves
    waves = (replace(train, seed=seed),)
    return replace(base, environment=replace(base.environment, waves=waves))


def _trial(runs: int, workers: int) -> Trial:
    process, memory = psutil.Process(), []
    scenes = [_seed(seed) for seed in range(1, runs + 1)]

    def note(*_: int) -> None:
        memory.append(process.memory_info().rss / MEGABYTE)

    with TemporaryDirectory() as folder:
        wall, cpu = perf_counter(), process_time()
        path = Path(folder, "runs.nc")
        simulate_many(scenes, path, workers=workers, progress=note).close()
        return Trial((perf_counter() - wall) / runs, (process_time() - cpu) / runs, memory)


def _speed(workers: int, trials: list[Trial], one: float, loop: float) -> Row:
    wall, cpu = (median(trial[k] for trial in trials) for k in range(2))
    return {
        "workers": workers,
        "runs/min": 60.0 / wall,
        "of one": one / wall,
        "CPU a run [s]": cpu,
        "outside the loop [s]": cpu - loop,
        "1000 runs [min]": 1000.0 * wall / 60.0,
    }
