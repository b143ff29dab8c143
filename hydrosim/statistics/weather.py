"""What limits mean in the weather there is: workability, alpha factors.

Limits are significant heights over peak periods, or over headings and peak periods; between these
they are on straight lines, and outside of them nothing is workable.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from hydrosim.errors import InputError

WIDEST = np.radians(45.0)  # between headings that have a straight line between them
ROUNDING = 1e-9  # rad


@dataclass(frozen=True)
class Curve:
    """Limiting ``height`` (n,) [m] over rising ``period`` (n,) [s]."""

    period: np.ndarray
    height: np.ndarray

    def at(self, period: np.ndarray) -> np.ndarray:
        """Limits [m] at any periods [s], NaN outside of those there are."""
        return np.interp(period, self.period, self.height, left=np.nan, right=np.nan)


@dataclass(frozen=True)
class Surface:
    """Limiting ``height`` (m, n) [m] over rising ``heading`` (m,) [rad], in one turn, and rising
    ``period`` (n,) [s]."""

    heading: np.ndarray
    period: np.ndarray
    height: np.ndarray

    def at(self, heading: np.ndarray, period: np.ndarray) -> np.ndarray:
        """Limits (k,) [m] of seas of any ``heading`` (k,) and ``period`` (k,): NaN at periods
        outside of those there are, and between headings more than `WIDEST` apart."""
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
    """How often there are seas of each ``height`` (n,) [m] and ``period`` (m,) [s]: ``count``."""

    height: np.ndarray
    period: np.ndarray
    count: np.ndarray


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


def workability(scatter: Scatter, curve: Curve) -> tuple[float, float]:
    """The share of a scatter diagram that is workable, and the share at other peak periods than the
    curve has, which is not."""
    limit = curve.at(scatter.period)
    count = scatter.count / scatter.count.sum()
    workable = float(count[scatter.height[:, None] <= limit].sum())
    return workable, float(count[:, np.isnan(limit)].sum())
