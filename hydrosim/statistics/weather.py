"""Operational limits in weather: workability, alpha factors, waiting time, mirrored headings.

Limits are significant wave heights over peak periods, or over headings and peak periods. They are
interpolated linearly; nothing is workable outside their range. An open limit is one at the largest
height that was tried: it is only known to be that or more. Between an open limit and another the
other one counts, because a larger largest height must not make a sea workable.

Waiting time in a hindcast for a window of workable sea.

A sea state lasts until the next one. A window is an interval that is workable for the required
length. An operation may begin at any time in it, until the remaining time is too short. The waiting
time from any moment lasts until the operation may begin.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from hydrosim.errors import InputError

if TYPE_CHECKING:
    import xarray as xr

MAX_HEADING_GAP = np.radians(45.0)  # largest distance of headings that are interpolated
ROUNDING_RAD = 1e-9  # rad


@dataclass(frozen=True)
class LimitCurve:
    """Limiting ``height`` (n,) [m] over increasing ``period`` (n,) [s]; ``is_open`` (n,) marks the
    open limits."""

    period: np.ndarray
    height: np.ndarray
    is_open: np.ndarray | None = None

    def limit_at(self, period: np.ndarray) -> np.ndarray:
        """Limits [m] at any periods [s]; NaN outside the range."""
        is_limited = np.zeros(self.height.shape, bool) if self.is_open is None else self.is_open
        return _over_periods(self.period, self.height, is_limited, np.asarray(period))[0]


@dataclass(frozen=True)
class LimitSurface:
    """Limiting ``height`` (m, n) [m] over increasing ``heading`` (m,) [rad], within one turn, and
    increasing ``period`` (n,) [s]; ``is_open`` (m, n) marks the open limits."""

    heading: np.ndarray
    period: np.ndarray
    height: np.ndarray
    is_open: np.ndarray | None = None

    def limit_at(self, heading: np.ndarray, period: np.ndarray) -> np.ndarray:
        """Limits (k,) [m] of seas of any ``heading`` (k,) and ``period`` (k,). NaN at periods
        outside the range, and between headings more than `MAX_HEADING_GAP` apart."""
        first, turn = self.heading[0], 2.0 * np.pi
        on = first + np.mod(np.asarray(heading) - first + ROUNDING_RAD, turn) - ROUNDING_RAD
        nodes = np.append(self.heading, first + turn)
        before = np.clip(np.searchsorted(nodes, on + ROUNDING_RAD, "right") - 1, 0, nodes.size - 2)
        after = (before + 1) % self.heading.size
        is_limited = np.zeros(self.height.shape, bool) if self.is_open is None else self.is_open
        limits = [
            _over_periods(self.period, *row, np.asarray(period))
            for row in zip(self.height, is_limited, strict=True)
        ]
        rows, are_open = (np.array(part) for part in zip(*limits, strict=True))
        states = np.arange(on.size)
        low, high = rows[before, states], rows[after, states]
        gap = nodes[before + 1] - nodes[before]
        part = (on - nodes[before]) / gap
        ends = are_open[before, states], are_open[after, states]
        between = _interpolate_limits(low, high, *ends, part)
        between = np.where(gap > MAX_HEADING_GAP + ROUNDING_RAD, np.nan, between)
        return np.where(part * gap < 2.0 * ROUNDING_RAD, low, between)


def _over_periods(
    nodes: np.ndarray, height: np.ndarray, is_open: np.ndarray, period: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Limits at ``period`` (k,), NaN outside the ``nodes`` (n,), and whether they are open."""
    if nodes.size == 1:
        inside = period == nodes[0]
        return np.where(inside, height[0], np.nan), inside & is_open[0]
    before = np.clip(np.searchsorted(nodes, period, "right") - 1, 0, nodes.size - 2)
    part = (period - nodes[before]) / (nodes[before + 1] - nodes[before])
    ends = is_open[before], is_open[before + 1]
    limits = _interpolate_limits(height[before], height[before + 1], *ends, part)
    outside = (period < nodes[0]) | (period > nodes[-1])
    open_there = np.where(part == 0.0, ends[0], np.where(part == 1.0, ends[1], ends[0] & ends[1]))
    return np.where(outside, np.nan, limits), open_there & ~outside


def _interpolate_limits(
    low: np.ndarray, high: np.ndarray, low_open: np.ndarray, high_open: np.ndarray, part: np.ndarray
) -> np.ndarray:
    """Linear between two limits; of one that is open and one that is not, the one that is not."""
    line = (1.0 - part) * low + part * high
    lower_limit = np.where(low_open, high, low)
    one_open = (low_open != high_open) & (part > 0.0) & (part < 1.0)
    return np.where(one_open & ~np.isnan(low + high), lower_limit, line)


@dataclass(frozen=True)
class ScatterDiagram:
    """Scatter diagram: ``count`` of sea states of each ``height`` (n,) [m] and ``period`` (m,)
    [s]."""

    height: np.ndarray
    period: np.ndarray
    count: np.ndarray


@dataclass(frozen=True)
class AlphaFactors:
    """Table of alpha factors, ``factors`` (n, m), for operations ``planned`` (n,) [s] to take so
    long, with limiting ``heights`` (m,) [m]. ``source`` names the table."""

    source: str
    planned: np.ndarray
    heights: np.ndarray
    factors: np.ndarray

    def factor(self, planned: float, limit: np.ndarray) -> np.ndarray:
        """Alpha factors from the row of the next longer planned time [s], interpolated linearly
        over heights. Above the last height its factor is used; below the first there is none (NaN).
        Raises InputError if the operation takes longer than the table covers."""
        row = int(np.searchsorted(self.planned, planned))
        if row == self.planned.size:
            raise InputError(
                f"operability.operation.planned: found {planned / 3600:g} h; expected at most"
                f" {self.planned[-1] / 3600:g} h, the longest time in the table {self.source}."
                " Divide the operation."
            )
        return np.interp(limit, self.heights, self.factors[row], left=np.nan)


def workability(scatter: ScatterDiagram, curve: LimitCurve) -> tuple[float, float]:
    """Workable fraction of a scatter diagram, and the fraction at peak periods outside the curve,
    which is not workable."""
    limit = curve.limit_at(scatter.period)
    count = scatter.count / scatter.count.sum()
    workable = float(count[scatter.height[:, None] <= limit].sum())
    return workable, float(count[:, np.isnan(limit)].sum())


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
            month_spans = spans[(of == month) & (spans[:, 1] > spans[:, 0])]
            if month_spans.size:
                yield month, month_spans


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
    open_spans = np.stack([hindcast.time[first], hindcast.ends[after - 1]], axis=1)
    return open_spans[open_spans[:, 1] - open_spans[:, 0] >= length]


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
    of, parts = _intersect_spans(gaps, spans)
    until = gaps[of, 1:] - parts[:, ::-1]  # shortest and longest wait in a part of a gap
    never = of == len(begins)
    at_once = float(np.ptp(_intersect_spans(begins, spans)[1], axis=1).sum())
    calm = np.stack([hindcast.time, ends], axis=1)[held]
    return WaitingTimes(
        _waiting_quantile(at_once, until[~never], 0.5 * whole),
        _waiting_quantile(at_once, until[~never], 0.9 * whole),
        float(np.ptp(parts[never], axis=1).sum()) / whole,
        float(np.ptp(_intersect_spans(calm, spans)[1], axis=1).sum()) / whole,
        at_once / whole,
    )


def _intersect_spans(stretches: np.ndarray, spans: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Intersections of intervals (n, 2) with spans (k, 2), both increasing: index of the interval,
    and begin and end (m, 2)."""
    of, low, high = [], [], []
    for a, b in spans:
        near = np.arange(np.searchsorted(stretches[:, 1], a), np.searchsorted(stretches[:, 0], b))
        of.append(near)
        low.append(np.maximum(stretches[near, 0], a))
        high.append(np.minimum(stretches[near, 1], b))
    return np.concatenate(of), np.stack([np.concatenate(low), np.concatenate(high)], axis=1)


def _waiting_quantile(at_once: float, waits: np.ndarray, wanted: float) -> float:
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


# Headings of limits, and their mirror images.

MIRRORED_ATTRIBUTE = "mirrored"
"""Attribute: the headings [rad] whose limits are those to the other side."""
MIRROR_REASON = "mirror"  # attribute: why limits are mirrored, or why not, in words
FULL_TURN = 2.0 * np.pi
SAME_HEADING_RAD = 1e-6  # rad


def without_images(limits: xr.Dataset) -> xr.Dataset:
    """The limits without those to the other side."""
    images = np.atleast_1d(limits.attrs.get(MIRRORED_ATTRIBUTE, []))
    kept_rows = [k for k, at in enumerate(limits.heading.values) if not np.any(images == at)]
    return limits.isel(heading=kept_rows)


def image_of(heading: float, limits: xr.Dataset) -> float | None:
    """The heading [rad] to the other side whose limits are those of this one."""
    for at in np.atleast_1d(limits.attrs.get(MIRRORED_ATTRIBUTE, [])):
        if _heading_difference(float(at), -heading) < SAME_HEADING_RAD:
            return float(at)
    return None


def images_of(headings: np.ndarray) -> list[tuple[float, float]]:
    """Headings, and those to their other sides that are not among them, within one turn."""
    first = float(headings[0])
    images = []
    for heading in headings.tolist():
        if all(
            _heading_difference(-heading, other) > SAME_HEADING_RAD for other in headings.tolist()
        ):
            images.append((heading, first + (-heading - first) % FULL_TURN))
    return images


def _heading_difference(first: float, second: float) -> float:
    """How far two directions are apart [rad]."""
    return abs((first - second + np.pi) % FULL_TURN - np.pi)
