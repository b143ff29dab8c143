"""Do the intervals of extremes hold what they promise for what contacts do in simulated runs?

Seeds of a sphere at the fender of a quay, of one that crawls under a plate, and of one that carries
a block which touches its seat again and again (`simulated/`), one hour and three of each after ten
minutes, of the largest and of the smallest values. No law was chosen by these seeds: the test of
crests and the lower end of what leans come from seeds 1 to 100. The true most probable value is a
quantile of those of all runs. Columns as in `benchmarks.extremes`.
"""

from __future__ import annotations

import os
from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from benchmarks.extremes import Holding
from benchmarks.report import ROOT, Answer, Row
from hydrosim import load_case
from hydrosim.results.channels import channel_series
from hydrosim.scene import Scene
from hydrosim.statistics.extremes import RecordExtremes, extremes
from hydrosim.statistics.series import lowest_frequency
from hydrosim.studies.run.simulation import compiled_to_run, run_compiled
from tests.random_records import MOST_PROBABLE

RUNS = int(os.environ.get("RUNS", "400"))
FIRST = 1001  # seed
HOURS = (1, 3)
BEGINNING = 600.0  # s
CHANNELS = {
    "quay": ("fender_normal_force.quay 1", "position.sphere.surge", "position.sphere.heave"),
    "crawl": ("position.sphere.surge", "velocity.sphere.surge"),
    "mating": ("fender_normal_force.seat 1", "fender_normal_force.interface 1"),
}


def answer() -> Answer:
    """A table for each scene."""
    tables = {}
    for name, channels in CHANNELS.items():
        scene = load_case(ROOT / "benchmarks" / "simulated" / f"{name}.yaml").scene()
        records, step = _records(scene, channels)
        tables[f"{name}: {RUNS} runs, shares that hold"] = [
            row
            for k, channel in enumerate(channels)
            for hours in HOURS
            for row in _rows(channel, hours, records[:, k], records[:, -1], step)
        ]
    return Answer(tables)


def _records(scene: Scene, channels: tuple[str, ...]) -> tuple[np.ndarray, float]:
    """Channels and the wave (runs, channels + 1, nt) after the beginning, and their step [s]."""
    runs = []
    for seeded in _seeds(scene):
        run = run_compiled(compiled_to_run(seeded), estimates=False)
        late = run.time.values >= BEGINNING
        runs.append([channel_series(run, name)[0][late] for name in (*channels, "wave_elevation")])
    return np.array(runs), float(np.diff(run.time.values[:2])[0])


def _seeds(scene: Scene) -> Iterator[Scene]:
    (train,) = scene.environment.waves
    for seed in range(FIRST, FIRST + RUNS):
        waves = (replace(train, seed=seed),)
        yield replace(scene, environment=replace(scene.environment, waves=waves))


def _rows(
    channel: str, hours: int, records: np.ndarray, waves: np.ndarray, step: float
) -> Iterator[Row]:
    """Shares of the largest and of the smallest values of a channel (runs, nt)."""
    count = round(3600.0 * hours / step)
    records = records[:, :count]
    waves = waves[:, :count]
    pairs = zip(records, waves, strict=True)
    found = [extremes(x, step, None, lowest_frequency(wave, step), True) for x, wave in pairs]
    largest = [each[1] for each in found]
    smallest = [each[0].rescale(-1.0) for each in found]
    yield _row(channel, hours, "largest", largest, records.max(axis=1))
    yield _row(channel, hours, "smallest", smallest, -records.min(axis=1))


def _row(
    channel: str, hours: int, side: str, found: list[RecordExtremes], largest: np.ndarray
) -> Row:
    true = float(np.quantile(largest, MOST_PROBABLE))
    hold = Holding(found, largest, true)
    return {
        "channel": channel,
        "hours": hours,
        "side": side,
        "intervals": hold.given.mean(),
        "confidence": hold.confidence(),
        "prediction": hold.prediction(),
        "mostly": hold.mostly(),
    }
