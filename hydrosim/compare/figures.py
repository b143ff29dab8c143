"""Figures of the difference between a recorded channel and ours, which is ours minus recorded."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from hydrosim.compare.align import ChannelPair
from hydrosim.compare.signals import correlation, rms, split_bands

BANDS = ("slow", "waves", "fast")
BAND_EDGES_RAD_S = (0.1, 2.5)  # rad/s, between them
DRIFT_END_FRACTION = 0.1  # of the time: intervals at its start and end whose means give the drift
CONSTANT_FRACTION = 1e-12  # of the largest value: smaller variation counts as constant
CONTACT_VARIABLES = ("fender_normal_force", "fender_compression")
CONTACT_FRACTION = 1e-3  # of the largest value: larger values are contact


class Figures(NamedTuple):
    """Figures of a channel, in its unit. Of the difference: ``rms``; ``relative``, which is rms
    over the ``std`` of the recording (NaN if that is constant); the largest value and its time; the
    mean. drift is the difference of both drifts from the first tenth of the time to the last. The
    last fields are the rms of the difference in each band, and the std of ours and of the recording
    there."""

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


class ContactComparison(NamedTuple):
    """First contact [s] (NaN if there is none) and fraction of the time in contact, for both."""

    first_ours: float
    first_recorded: float
    share_ours: float
    share_recorded: float


def figures(time: np.ndarray, pair: ChannelPair, edges: tuple[float, float]) -> Figures:
    """Figures of a pair over ``time`` (n,) [s]; ``edges`` [rad/s] separate the bands."""
    difference = pair.ours - pair.recorded
    size, worst = rms(difference), int(np.argmax(np.abs(difference)))
    std = std_above_rounding(pair.recorded)
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


def std_above_rounding(values: np.ndarray) -> float:
    """Standard deviation; 0 if it is only rounding."""
    std = float(np.std(values))
    return std if std > CONSTANT_FRACTION * float(np.abs(values).max()) else 0.0


def contact(time: np.ndarray, pair: ChannelPair) -> ContactComparison | None:
    """First contact and fraction of contact of a fender; None for other channels."""
    if not pair.channel.startswith(CONTACT_VARIABLES):
        return None
    touching = [x > CONTACT_FRACTION * float(np.abs(x).max()) for x in (pair.ours, pair.recorded)]
    first = [float(time[np.argmax(t)]) if t.any() else float("nan") for t in touching]
    return ContactComparison(*first, *(float(np.mean(t)) for t in touching))


def _drift(values: np.ndarray) -> float:
    """Mean over the last tenth minus mean over the first tenth."""
    count = max(1, int(DRIFT_END_FRACTION * values.size))
    return float(values[-count:].mean() - values[:count].mean())
