"""Do the intervals of extremes hold what they promise for what contacts do in simulated runs?

Seeds of a sphere at the fender of a quay and of one that crawls under a plate (`simulated/`), one
hour and three of each after ten minutes. The true most probable maximum is the quantile exp(-1) of
the largest values of all runs. Columns as in `benchmarks.extremes`.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from benchmarks.extremes import Holding
from benchmarks.report import ROOT, Answer, Row
from hydrosim import load_case, simulate
from hydrosim.results.channels import series
from hydrosim.scene import Scene
from hydrosim.statistics.extremes import extremes
from hydrosim.statistics.series import lowest_frequency
from tests.random_records import MOST_PROBABLE

RUNS = 400
HOURS = (1, 3)
BEGINNING = 600.0  # s
CHANNELS = {
    "quay": ("fender_normal_force.quay 1", "position.sphere.surge", "position.sphere.heave"),
    "crawl": ("position.sphere.surge", "velocity.sphere.surge"),
}


def answer() -> Answer:
    """A table for each scene."""
    tables = {}
    for name, channels in CHANNELS.items():
        scene = load_case(ROOT / "benchmarks" / "simulated" / f"{name}.yaml").scene()
        records, step = _records(scene, channels)
        tables[f"{name}: {RUNS} runs, shares that hold"] = [
            _row(channel, hours, records[:, k], records[:, -1], step)
            for k, channel in enumerate(channels)
            for hours in HOURS
        ]
    return Answer(tables)


def _records(scene: Scene, channels: tuple[str, ...]) -> tuple[np.ndarray, float]:
    """Channels and the wave (runs, channels + 1, nt) after the beginning, and their step [s]."""
    runs = []
    for seeded in _seeds(scene):
        run = simulate(seeded)
        late = run.time.values >= BEGINNING
        runs.append([series(run, name)[0][late] for name in (*channels, "wave_elevation")])
    return np.array(runs), float(np.diff(run.time.values[:2])[0])


def _seeds(scene: Scene) -> Iterator[Scene]:
    (train,) = scene.environment.waves
    for seed in range(1, RUNS + 1):
        waves = (replace(train, seed=seed),)
        yield replace(scene, environment=replace(scene.environment, waves=waves))


def _row(channel: str, hours: int, records: np.ndarray, waves: np.ndarray, step: float) -> Row:
    """Shares of the largest values of a channel (runs, nt)."""
    count = round(3600.0 * hours / step)
    records = records[:, :count]
    waves = waves[:, :count]
    pairs = zip(records, waves, strict=True)
    found = [extremes(x, step, None, lowest_frequency(wave, step))[1] for x, wave in pairs]
    largest = records.max(axis=1)
    true = float(np.quantile(largest, MOST_PROBABLE))
    hold = Holding(found, largest, true)
    return {
        "channel": channel,
        "hours": hours,
        "intervals": hold.given.mean(),
        "confidence": hold.confidence(),
        "prediction": hold.prediction(),
        "mostly": hold.mostly(),
    }
