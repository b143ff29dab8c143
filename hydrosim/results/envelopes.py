"""Smallest and largest values of intervals of a series, for pictures of long series."""

from __future__ import annotations

import numpy as np


def interval_envelope(x: np.ndarray, size: int) -> np.ndarray:
    """Smallest and largest values (2, n) of intervals of ``size`` records; x (1, nt) itself if that
    is 1."""
    if size == 1:
        return x[None]
    starts = np.arange(0, x.size, size)
    return np.array([np.fmin.reduceat(x, starts), np.fmax.reduceat(x, starts)])


def interval_means(x: np.ndarray, size: int) -> np.ndarray:
    """Mean (n,) of the finite values in each interval of ``size`` records."""
    starts, known = np.arange(0, x.size, size), np.isfinite(x)
    count = np.add.reduceat(known.astype(float), starts)
    total = np.add.reduceat(np.where(known, x, 0.0), starts)
    return np.where(count > 0.0, total / np.maximum(count, 1.0), np.nan)
