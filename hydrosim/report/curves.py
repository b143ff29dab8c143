"""Positions of the points, bars and ticks of curves in a picture."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from math import ceil, floor, log10
from typing import NamedTuple

import numpy as np

from hydrosim.documents.digits import digits_of
from hydrosim.presentation.figures import Curves, PlottedCurve
from hydrosim.presentation.units import Units

CHART_WIDTH, CHART_HEIGHT, LEFT_EDGE, RIGHT_EDGE, TOP_EDGE, BOTTOM_EDGE = 720, 320, 70, 700, 24, 270
RANGE_MARGIN_FRACTION = 0.05  # of a range, on both sides
TICK_STEPS = (1.0, 2.0, 5.0, 10.0)  # between ticks, times a power of ten


class PlottedPoint(NamedTuple):
    """A point with its bar, and a remark."""

    x: float
    y: float
    low: float
    high: float
    said: str


class PlottedCurves(NamedTuple):
    """A picture of curves."""

    x_label: str
    y_label: str
    lines: list[list[PlottedPoint]]
    x_ticks: list[tuple[float, str]]
    y_ticks: list[tuple[float, str]]
    width: int = CHART_WIDTH
    height: int = CHART_HEIGHT
    left: int = LEFT_EDGE
    right: int = RIGHT_EDGE
    top: int = TOP_EDGE
    bottom: int = BOTTOM_EDGE


def plot_curves(of: Curves, units: Units) -> PlottedCurves:
    """Picture of curves, in display units, without points that are not finite."""
    x_unit, x_scale = units.display_unit(of.x_unit)
    y_unit, y_scale = units.display_unit(of.y_unit)
    curves = {name: _scale_curve(curve, x_scale, y_scale) for name, curve in of.curves.items()}
    each = list(curves.values())
    x = _range(np.concatenate([c.x for c in each]))
    y = _range(np.concatenate([part for c in each for part in (c.y, c.low, c.high)]))
    across, up = _scale(x, LEFT_EDGE, RIGHT_EDGE), _scale(y, BOTTOM_EDGE, TOP_EDGE)
    lines = [list(_points(name, c, across, up)) for name, c in curves.items()]
    x_ticks = [(across(t), digits_of(t)) for t in ticks(*x)]
    y_ticks = [(up(t), digits_of(t)) for t in ticks(*y)]
    labels = _label(of.x_label, x_unit), _label(of.y_label, y_unit)
    return PlottedCurves(*labels, lines, x_ticks, y_ticks)


def ticks(low: float, high: float, count: int = 6) -> list[float]:
    """Round numbers from ``low`` to ``high``, about so many."""
    power = 10.0 ** floor(log10((high - low) / count))
    step = next(s * power for s in TICK_STEPS if s * power >= (high - low) / count)
    return [k * step for k in range(ceil(low / step), floor(high / step) + 1)]


def _scale_curve(curve: PlottedCurve, across: float, up: float) -> PlottedCurve:
    ends = (up * curve.y, up * curve.low, up * curve.high)
    return PlottedCurve(across * curve.x, *ends, curve.remarks)


def _label(label: str, unit: str) -> str:
    return f"{label} [{unit}]" if unit else label


def _points(
    name: str, curve: PlottedCurve, across: Callable[[float], float], up: Callable[[float], float]
) -> Iterator[PlottedPoint]:
    remarks = curve.remarks or [""] * curve.x.size
    for x, y, low, high, remark in zip(
        *(curve.x, curve.y, curve.low, curve.high, remarks), strict=True
    ):
        if np.isfinite([x, y]).all():
            known = np.isfinite([low, high]).any()
            low, high = (value if np.isfinite(value) else y for value in (low, high))
            between = f" ({digits_of(low)} to {digits_of(high)})" if known else ""
            said = f"{name}: {digits_of(y)}{between} {remark}"
            yield PlottedPoint(across(x), up(y), up(low), up(high), said.strip())


def _range(values: np.ndarray) -> tuple[float, float]:
    known = values[np.isfinite(values)]
    if known.size == 0:
        return 0.0, 1.0
    low, high = float(known.min()), float(known.max())
    pad = RANGE_MARGIN_FRACTION * (high - low) or RANGE_MARGIN_FRACTION * abs(high) or 1.0
    return low - pad, high + pad


def _scale(of: tuple[float, float], begin: float, end: float) -> Callable[[float], float]:
    return lambda value: round(begin + (value - of[0]) / (of[1] - of[0]) * (end - begin), 2)
