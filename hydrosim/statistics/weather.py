"""Operational limits in weather: workability, alpha factors.

Limits are significant wave heights over peak periods, or over headings and peak periods. They are
interpolated linearly; nothing is workable outside their range. An open limit is one at the largest
height that was tried: it is only known to be that or more. Between an open limit and another the
other one counts, because a larger largest height must not make a sea workable.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from hydrosim.errors import InputError

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
        known = np.zeros(self.height.shape, bool) if self.is_open is None else self.is_open
        return _over_periods(self.period, self.height, known, np.asarray(period))[0]


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
        known = np.zeros(self.height.shape, bool) if self.is_open is None else self.is_open
        each = [
            _over_periods(self.period, *row, np.asarray(period))
            for row in zip(self.height, known, strict=True)
        ]
        rows, are_open = (np.array(part) for part in zip(*each, strict=True))
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
    found = _interpolate_limits(height[before], height[before + 1], *ends, part)
    outside = (period < nodes[0]) | (period > nodes[-1])
    open_there = np.where(part == 0.0, ends[0], np.where(part == 1.0, ends[1], ends[0] & ends[1]))
    return np.where(outside, np.nan, found), open_there & ~outside


def _interpolate_limits(
    low: np.ndarray, high: np.ndarray, low_open: np.ndarray, high_open: np.ndarray, part: np.ndarray
) -> np.ndarray:
    """Linear between two limits; of one that is open and one that is not, the one that is not."""
    line = (1.0 - part) * low + part * high
    known = np.where(low_open, high, low)
    one_open = (low_open != high_open) & (part > 0.0) & (part < 1.0)
    return np.where(one_open & ~np.isnan(low + high), known, line)


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
