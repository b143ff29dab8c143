"""`group_by_size`: series that can share an axis."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

MIN_SHARE_OF_AXIS = 0.1
"""Size, relative to the largest series on an axis, below which a series has an axis of its own."""


def group_by_size(series: Mapping[str, np.ndarray]) -> list[dict[str, np.ndarray]]:
    """Series of similar size together, the largest first, each group in the order of ``series``.
    Series that are zero throughout go with the smallest others."""
    sizes = {name: float(np.abs(np.nan_to_num(x)).max(initial=0.0)) for name, x in series.items()}
    groups: list[list[str]] = []
    top = 0.0
    for name in sorted(series, key=lambda name: -sizes[name]):
        if not groups or 0.0 < sizes[name] < MIN_SHARE_OF_AXIS * top:
            groups.append([])
            top = sizes[name]
        groups[-1].append(name)
    return [{name: series[name] for name in series if name in group} for group in groups]
