"""What a document can draw. The terminal leaves figures out; commands write pictures beside it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import ClassVar

import numpy as np


@dataclass(frozen=True)
class Code:
    """A text of several lines, such as a case file, folded away under its title."""

    kind: ClassVar[str] = "code"
    title: str
    text: str
    shown: bool = False


@dataclass(frozen=True)
class Chart:
    """Lines (nt,) over time by name, in the SI ``unit``. A chart of ``modes`` has modes in place of
    values. ``folded`` ones are opened by the reader."""

    kind: ClassVar[str] = "chart"
    title: str
    unit: str
    series: dict[str, np.ndarray]
    modes: bool = False
    folded: bool = False


@dataclass(frozen=True)
class PlottedCurve:
    """A line through ``y`` (n,) over ``x`` (n,), from ``low`` to ``high``; ``remarks`` (n,) are
    what points say when they are pointed at."""

    x: np.ndarray
    y: np.ndarray
    low: np.ndarray
    high: np.ndarray
    remarks: Sequence[str] = ()


@dataclass(frozen=True)
class Curves:
    """Curves by their names, over something other than time. ``x_unit`` and ``y_unit`` are SI; the
    labels do without them."""

    kind: ClassVar[str] = "curves"
    title: str
    x_label: str
    x_unit: str
    y_label: str
    y_unit: str
    curves: dict[str, PlottedCurve]


@dataclass(frozen=True)
class Replay:
    """A scene in three dimensions, as `hydrosim.report.replay` describes it."""

    kind: ClassVar[str] = "replay"
    data: dict[str, object]
    notes: Sequence[str]
    title: str = "Replay"


@dataclass(frozen=True)
class Drawing:
    """A picture as SVG, drawn by the program itself; ``text`` says in words what it shows."""

    kind: ClassVar[str] = "drawing"
    title: str
    svg: str
    text: str


Figure = Code | Chart | Curves | Replay | Drawing
FIGURE_NODES = (Code, Chart, Curves, Replay, Drawing)
