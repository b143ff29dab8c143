"""Waiting time in a hindcast for a window of workable sea.

A sea state lasts until the next one. A window is an interval that is workable for the required
length. An operation may begin at any time in it, until the remaining time is too short. The waiting
time from any moment lasts until the operation may begin.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np


@dataclass(frozen=True)
class Hindcast:
    """Sea states that begin at increasing ``time`` (n,) [s]: ``height`` (n,) [m], ``period`` (n,)
    [s], ``coming`` (n,) [rad] (the bearing that waves come from, clockwise from north), and
    ``date`` (the date of time 0). Unknown ones are None. The last state lasts as long as the one
    before it."""

    time: np.ndarray
    date: np.datetime64 | None
    height: np.ndarray
    period: np.ndarray
    coming: np.ndarray | None = None

    @property
    def ends(self) -> np.ndarray:
        """End of each state [s]."""
        return np.append(self.time[1:], 2.0 * self.time[-1] - self.time[-2])

    def months(self) -> Iterator[tuple[int, np.ndarray]]:
        """Months in the record, from 1 on, with begin and end (k, 2) [s] in each of its years. None
        without a date."""
        if self.date is None:
            return
        first, last = float(self.time[0]), float(self.ends[-1])
        days = (self.date + np.array([first, last]).astype("timedelta64[s]")).astype("M8[M]")
        edges = np.arange(days[0], days[1] + np.timedelta64(2, "M"))
        seconds = (edges.astype("M8[ms]") - self.date) / np.timedelta64(1, "s")
        spans = np.clip(np.stack([seconds[:-1], seconds[1:]], axis=1), first, last)
        of = edges[:-1].astype(int) % 12 + 1
        for month in range(1, 13):
            found = spans[(of == month) & (spans[:, 1] > spans[:, 0])]
            if found.size:
                yield month, found


class WaitingTimes(NamedTuple):
    """Waiting times from all moments of a record until a window begins: median and 90 % quantile
    [s]; the fraction of moments after which no window follows; the fraction of time in which the
    sea is workable, and in which a window may begin."""

    median: float
    p90: float
    none: float
    workable: float
    startable: float


def windows(hindcast: Hindcast, held: np.ndarray, length: float) -> np.ndarray:
    """Begin and end (k, 2) [s] of each workable interval of at least ``length`` [s]; ``held`` (n,)
    says which states are workable."""
    edges = np.flatnonzero(np.diff(np.concatenate([[False], held, [False]]).astype(int)))
    first, after = edges.reshape(-1, 2).T
    found = np.stack([hindcast.time[first], hindcast.ends[after - 1]], axis=1)
    return found[found[:, 1] - found[:, 0] >= length]


def waiting(
    hindcast: Hindcast, held: np.ndarray, length: float, moments: np.ndarray | None = None
) -> WaitingTimes:
    """Waiting times for ``length`` [s] of workable states, ``held`` (n,), from any moment in the
    intervals ``moments`` (k, 2) [s]; None is the whole record."""
    ends = hindcast.ends
    first, last = float(hindcast.time[0]), float(ends[-1])
    spans = np.array([[first, last]]) if moments is None else moments
    whole = float(np.ptp(spans, axis=1).sum())
    begins = windows(hindcast, held, length) - np.array([0.0, length])
    gaps = np.stack([np.append(first, begins[:, 1]), np.append(begins[:, 0], last)], axis=1)
    of, parts = _intersections(gaps, spans)
    until = gaps[of, 1:] - parts[:, ::-1]  # shortest and longest wait in a part of a gap
    never = of == len(begins)
    at_once = float(np.ptp(_intersections(begins, spans)[1], axis=1).sum())
    calm = np.stack([hindcast.time, ends], axis=1)[held]
    return WaitingTimes(
        _quantile(at_once, until[~never], 0.5 * whole),
        _quantile(at_once, until[~never], 0.9 * whole),
        float(np.ptp(parts[never], axis=1).sum()) / whole,
        float(np.ptp(_intersections(calm, spans)[1], axis=1).sum()) / whole,
        at_once / whole,
    )


def _intersections(stretches: np.ndarray, spans: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Intersections of intervals (n, 2) with spans (k, 2), both increasing: index of the interval,
    and begin and end (m, 2)."""
    of, low, high = [], [], []
    for a, b in spans:
        near = np.arange(np.searchsorted(stretches[:, 1], a), np.searchsorted(stretches[:, 0], b))
        of.append(near)
        low.append(np.maximum(stretches[near, 0], a))
        high.append(np.minimum(stretches[near, 1], b))
    return np.concatenate(of), np.stack([np.concatenate(low), np.concatenate(high)], axis=1)


def _quantile(at_once: float, waits: np.ndarray, wanted: float) -> float:
    """Time w for which a fraction ``wanted`` of the moments waits at most w. The fraction
    ``at_once`` does not wait; ``waits`` (n, 2) are uniform from first to last. Infinite if too few
    wait so briefly."""
    if wanted <= at_once:
        return 0.0
    if wanted > at_once + float(np.ptp(waits, axis=1).sum()):
        return float("inf")
    times = np.concatenate([waits[:, 0], waits[:, 1]])
    order = np.argsort(times)
    times = times[order]
    rate = np.cumsum(np.repeat([1, -1], len(waits))[order])
    below = at_once + np.append(0.0, np.cumsum(rate[:-1] * np.diff(times)))
    return float(np.interp(wanted, below, times))
