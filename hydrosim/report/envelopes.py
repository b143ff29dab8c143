"""Series for a page: as they are, or the smallest and the largest value of each stretch of time."""

from __future__ import annotations

from base64 import b64encode
from collections.abc import Sequence
from typing import Any

import numpy as np

from hydrosim.presentation.figures import Chart
from hydrosim.presentation.units import Units
from hydrosim.results.envelopes import envelope

ROOM = 4_000_000  # bytes of all series of a page together, as numbers of four bytes
MOST = 5000  # stretches
MODES = (1, 2)  # stick and slip: their shares of a stretch; what is left is open
STRETCHES = 800  # of modes


def stretch(count: int, lines: int) -> int:
    """How many records are put together where there are so many ``lines`` of ``count`` records."""
    if 4 * count * lines <= ROOM and count <= MOST:
        return 1
    stretches = min(MOST, max(ROOM // (8 * max(lines, 1)), 50))
    return -(-count // stretches)


def packed(chart: Chart, size: int, units: Units) -> dict[str, Any]:
    """What the page draws of a chart, of stretches of ``size`` records."""
    rows = [shares(x) if chart.modes else envelope(x, size) for x in chart.series.values()]
    unit, scale = units.shown(chart.unit)
    return {
        "title": chart.title,
        "unit": unit,
        "scale": scale,
        "modes": chart.modes,
        "names": list(chart.series),
        "values": [base64_of(row) for row in rows],
    }


def shares(modes: np.ndarray) -> np.ndarray:
    """Shares (2, n) of the time in `MODES` in each of `STRETCHES` of equal length."""
    starts = np.unique(np.linspace(0, modes.size, STRETCHES + 1)[:-1].astype(int))
    length = np.diff(np.append(starts, modes.size))
    return np.array([np.add.reduceat((modes == k).astype(float), starts) / length for k in MODES])


def base64_of(values: np.ndarray | Sequence[float]) -> str:
    """Numbers of four bytes, the lowest first; what is beyond them is not a number."""
    with np.errstate(over="ignore", invalid="ignore"):
        small = np.asarray(values, dtype="<f4")
    return b64encode(np.where(np.isfinite(small), small, np.float32(np.nan)).tobytes()).decode()
