"""How far a recorded channel is from ours, in figures. Differences are ours minus recorded."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from hydrosim.compare.align import Pair
from hydrosim.compare.signals import correlation, rms, split_bands

BANDS = ("slow", "waves", "fast")
EDGES = (0.1, 2.5)  # rad/s, between them
ENDS = 0.1  # of the time: what is averaged at its start and end for the drift
CONSTANT = 1e-12  # of the largest value: what varies less does not
CONTACT = ("fender_normal_force", "fender_compression")
TOUCH = 1e-3  # of the largest value: what is more is contact


class Figures(NamedTuple):
    """Of a channel, in its unit, of the difference: ``rms``, the same over the ``std`` of what was
    recorded (NaN if that is constant), the largest and its time, the mean; the difference of what
    each drifts from the first tenth of the time to the last; the rms in each band, and the std of
    ours and of the recording in each."""

    rms: float
    relative: float
    std: float
    peak: float
    peak_time: float
    mean: float
    drift: float
    correlation: float
    band_rms: tuple[float, ...]
    band_ours: tuple[float, ...]
    band_recorded: tuple[float, ...]


class Contact(NamedTuple):
    """First contact [s] (NaN if there is none) and share of the time in contact, of each."""

    first_ours: float
    first_recorded: float
    share_ours: float
    share_recorded: float


def figures(time: np.ndarray, pair: Pair, edges: tuple[float, float]) -> Figures:
    """The figures of a pair over ``time`` (n,) [s]; ``edges`` [rad/s] are between the bands."""
    difference = pair.ours - pair.recorded
    size, worst = rms(difference), int(np.argmax(np.abs(difference)))
    std = varies(pair.recorded)
    series = (difference - difference.mean(), pair.ours, pair.recorded)
    bands = [
        tuple(float(np.std(part)) for part in split_bands(time, values, edges)) for values in series
    ]
    return Figures(
        size,
        size / std if std > 0.0 else float("nan"),
        std,
        float(np.abs(difference[worst])),
        float(time[worst]),
        float(difference.mean()),
        _drift(pair.ours) - _drift(pair.recorded),
        correlation(pair.ours, pair.recorded),
        *bands,
    )


def varies(values: np.ndarray) -> float:
    """Standard deviation; 0 where it is but rounding."""
    std = float(np.std(values))
    return std if std > CONSTANT * float(np.abs(values).max()) else 0.0


def contact(time: np.ndarray, pair: Pair) -> Contact | None:
    """When and how long a fender touches; None for other channels."""
    if not pair.channel.startswith(CONTACT):
        return None
    touching = [x > TOUCH * float(np.abs(x).max()) for x in (pair.ours, pair.recorded)]
    first = [float(time[np.argmax(t)]) if t.any() else float("nan") for t in touching]
    return Contact(*first, *(float(np.mean(t)) for t in touching))


def _drift(values: np.ndarray) -> float:
    """Mean over the last tenth minus mean over the first."""
    count = max(1, int(ENDS * values.size))
    return float(values[-count:].mean() - values[:count].mean())
