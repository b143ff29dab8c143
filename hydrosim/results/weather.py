"""What limits mean in the weather there is: workability, waiting times, alpha factors.

Limits are a curve of significant height over peak period; between its periods they are on straight
lines, and outside of them nothing is workable. A state of the sea lasts until the next one.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from hydrosim.errors import InputError


@dataclass(frozen=True)
class Curve:
    """Limiting ``height`` (n,) [m] over rising ``period`` (n,) [s]."""

    period: np.ndarray
    height: np.ndarray

    def at(self, period: np.ndarray) -> np.ndarray:
        """Limits [m] at any periods [s], NaN outside of those there are."""
        return np.interp(period, self.period, self.height, left=np.nan, right=np.nan)


@dataclass(frozen=True)
class Scatter:
    """How often there are seas of each ``height`` (n,) [m] and ``period`` (m,) [s]: ``count``."""

    height: np.ndarray
    period: np.ndarray
    count: np.ndarray


@dataclass(frozen=True)
class Hindcast:
    """States of the sea that begin at rising ``time`` (n,) [s]: ``height`` (n,) [m], ``period``
    (n,) [s]. The last one lasts as long as the one before it."""

    time: np.ndarray
    height: np.ndarray
    period: np.ndarray

    @property
    def ends(self) -> np.ndarray:
        """When each state ends [s]."""
        return np.append(self.time[1:], 2.0 * self.time[-1] - self.time[-2])


@dataclass(frozen=True)
class Alpha:
    """A table of alpha factors, ``factors`` (n, m) for operations ``planned`` (n,) [s] to take so
    long, limited to ``heights`` (m,) [m]; ``source`` says which table."""

    source: str
    planned: np.ndarray
    heights: np.ndarray
    factors: np.ndarray

    def factor(self, planned: float, limit: np.ndarray) -> np.ndarray:
        """Of the row for the planned time [s], the next longer one; straight lines between the
        heights, the last factor beyond them, NaN below: the table has none. InputError where the
        operation takes longer than the table goes."""
        row = int(np.searchsorted(self.planned, planned))
        if row == self.planned.size:
            raise InputError(
                f"operability.operation.planned: found {planned / 3600:g} h; expected at most"
                f" {self.planned[-1] / 3600:g} h, as far as the table {self.source} goes. Divide"
                " the operation."
            )
        return np.interp(limit, self.heights, self.factors[row], left=np.nan)


class Waiting(NamedTuple):
    """Waiting times from all moments of a record until a window begins: median and 90 % quantile
    [s]; the share of moments after which there is no window any more; the share of the time in
    which the sea is workable, and in which a window may be begun."""

    median: float
    p90: float
    none: float
    workable: float
    startable: float


def workability(scatter: Scatter, curve: Curve) -> tuple[float, float]:
    """The share of a scatter diagram that is workable, and the share at other peak periods than the
    curve has, which is not."""
    limit = curve.at(scatter.period)
    count = scatter.count / scatter.count.sum()
    workable = float(count[scatter.height[:, None] <= limit].sum())
    return workable, float(count[:, np.isnan(limit)].sum())


def windows(hindcast: Hindcast, curve: Curve, length: float) -> list[tuple[float, float]]:
    """Begin and end [s] of each stretch that is workable for the ``length`` [s] or longer."""
    held = hindcast.height <= curve.at(hindcast.period)
    ends, found = hindcast.ends, []
    edges = np.flatnonzero(np.diff(np.concatenate([[False], held, [False]]).astype(int)))
    for first, after in edges.reshape(-1, 2):
        begin, end = float(hindcast.time[first]), float(ends[after - 1])
        if end - begin >= length:
            found.append((begin, end))
    return found


def waiting(hindcast: Hindcast, curve: Curve, length: float) -> Waiting:
    """How long to wait for ``length`` [s] of workable sea, from any moment of the record on."""
    ends = hindcast.ends
    first, last = float(hindcast.time[0]), float(ends[-1])
    held = hindcast.height <= curve.at(hindcast.period)
    spans = ends - hindcast.time
    starts = [(begin, end - length) for begin, end in windows(hindcast, curve, length)]
    at_once = sum(end - begin for begin, end in starts)
    gaps, before = [], first
    for begin, end in starts:
        gaps.append(begin - before)
        before = end
    whole = last - first
    return Waiting(
        _quantile(at_once, gaps, whole, 0.5),
        _quantile(at_once, gaps, whole, 0.9),
        (last - before) / whole,
        float(spans[held].sum() / spans.sum()),
        at_once / whole,
    )


def _quantile(at_once: float, gaps: list[float], whole: float, share: float) -> float:
    """The time w for which so much of the ``whole`` waits no longer: at_once + sum min(gap, w);
    infinite where nothing comes for the rest."""
    wanted, w = share * whole - at_once, 0.0
    if wanted <= 0.0:
        return 0.0
    rising = sorted(gaps)
    for k, gap in enumerate(rising):
        more = (gap - w) * (len(rising) - k)
        if wanted <= more:
            return w + wanted / (len(rising) - k)
        wanted, w = wanted - more, gap
    return float("inf")
