"""Operational limits in weather: workability, alpha factors.

Limits are significant wave heights over peak periods, or over headings and peak periods. They are
interpolated linearly; nothing is workable outside their range.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from hydrosim.errors import InputError

WIDEST = np.radians(45.0)  # largest distance of headings that are interpolated
ROUNDING = 1e-9  # rad


@dataclass(frozen=True)
class Curve:
    """Limiting ``height`` (n,) [m] over increasing ``period`` (n,) [s]."""

    period: np.ndarray
    height: np.ndarray

    def at(self, period: np.ndarray) -> np.ndarray:
        """Limits [m] at any periods [s]; NaN outside the range."""
        return np.interp(period, self.period, self.height, left=np.nan, right=np.nan)


@dataclass(frozen=True)
class Surface:
    """Limiting ``height`` (m, n) [m] over increasing ``heading`` (m,) [rad], within one turn, and
    increasing ``period`` (n,) [s]."""

    heading: np.ndarray
    period: np.ndarray
    height: np.ndarray

    def at(self, heading: np.ndarray, period: np.ndarray) -> np.ndarray:
        """Limits (k,) [m] of seas of any ``heading`` (k,) and ``period`` (k,). NaN at periods
        outside the range, and between headings more than `WIDEST` apart."""
        first, turn = self.heading[0], 2.0 * np.pi
        on = first + np.mod(np.asarray(heading) - first + ROUNDING, turn) - ROUNDING
        nodes = np.append(self.heading, first + turn)
        before = np.clip(np.searchsorted(nodes, on + ROUNDING, "right") - 1, 0, nodes.size - 2)
        rows = np.array(
            [np.interp(period, self.period, row, np.nan, np.nan) for row in self.height]
        )
        states = np.arange(on.size)
        low, high = rows[before, states], rows[(before + 1) % len(rows), states]
        gap = nodes[before + 1] - nodes[before]
        part = (on - nodes[before]) / gap
        between = np.where(gap > WIDEST + ROUNDING, np.nan, (1.0 - part) * low + part * high)
        return np.where(part * gap < 2.0 * ROUNDING, low, between)


@dataclass(frozen=True)
class Scatter:
    """Scatter diagram: ``count`` of sea states of each ``height`` (n,) [m] and ``period`` (m,)
    [s]."""

    height: np.ndarray
    period: np.ndarray
    count: np.ndarray


@dataclass(frozen=True)
class Alpha:
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


def workability(scatter: Scatter, curve: Curve) -> tuple[float, float]:
    """Workable fraction of a scatter diagram, and the fraction at peak periods outside the curve,
    which is not workable."""
    limit = curve.at(scatter.period)
    count = scatter.count / scatter.count.sum()
    workable = float(count[scatter.height[:, None] <= limit].sum())
    return workable, float(count[:, np.isnan(limit)].sum())
