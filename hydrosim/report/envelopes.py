"""Series for a page: complete, or the smallest and largest value of each interval."""

from __future__ import annotations

from base64 import b64encode
from collections.abc import Sequence
from typing import Any

import numpy as np

from hydrosim.presentation.figures import Chart
from hydrosim.presentation.units import Units
from hydrosim.results.envelopes import interval_envelope

MAX_SERIES_BYTES = 4_000_000  # bytes of all series of a page together, as 32-bit numbers
MAX_STRETCHES = 5000  # stretches
CLOSED_MODES = (1, 2)  # stick and slip: their fractions of an interval; the rest is open
MODE_INTERVALS = 800  # of modes


def stretch(count: int, lines: int) -> int:
    """Number of records per interval, for so many ``lines`` of ``count`` records."""
    if 4 * count * lines <= MAX_SERIES_BYTES and count <= MAX_STRETCHES:
        return 1
    stretches = min(MAX_STRETCHES, max(MAX_SERIES_BYTES // (8 * max(lines, 1)), 50))
    return -(-count // stretches)


def chart_data(chart: Chart, size: int, units: Units) -> dict[str, Any]:
    """Data of a chart for the page, with intervals of ``size`` records."""
    rows = [shares(x) if chart.modes else interval_envelope(x, size) for x in chart.series.values()]
    unit, scale = units.display_unit(chart.unit)
    return {
        "title": chart.title,
        "unit": unit,
        "scale": scale,
        "modes": chart.modes,
        "names": list(chart.series),
        "values": [base64_of(row) for row in rows],
    }


def shares(modes: np.ndarray) -> np.ndarray:
    """Fractions (2, n) of the time in `CLOSED_MODES`, in `MODE_INTERVALS` equal intervals."""
    starts = np.unique(np.linspace(0, modes.size, MODE_INTERVALS + 1)[:-1].astype(int))
    length = np.diff(np.append(starts, modes.size))
    return np.array(
        [np.add.reduceat((modes == k).astype(float), starts) / length for k in CLOSED_MODES]
    )


def base64_of(values: np.ndarray | Sequence[float]) -> str:
    """32-bit numbers, little-endian; values outside their range become NaN."""
    with np.errstate(over="ignore", invalid="ignore"):
        small = np.asarray(values, dtype="<f4")
    return b64encode(np.where(np.isfinite(small), small, np.float32(np.nan)).tobytes()).decode()
