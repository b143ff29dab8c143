"""What a page is made of: sections of blocks. All texts in them are shown as they are."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from math import isfinite
from typing import ClassVar

import numpy as np

from hydrosim.documents.digits import digits_of


@dataclass(frozen=True)
class Number:
    """A number as it is shown, and as it is."""

    value: float
    text: str


@dataclass(frozen=True)
class Text:
    """A paragraph."""

    kind: ClassVar[str] = "text"
    text: str


@dataclass(frozen=True)
class Points:
    """A list of remarks; ``grave`` ones stand out."""

    kind: ClassVar[str] = "points"
    items: Sequence[str]
    grave: bool = False


@dataclass(frozen=True)
class Table:
    """Rows under a ``head``; the first cell of a row says what it is of."""

    kind: ClassVar[str] = "table"
    head: Sequence[str]
    rows: Sequence[Sequence[str | Number]]


@dataclass(frozen=True)
class Code:
    """A text of several lines, such as a case file, folded away under its title."""

    kind: ClassVar[str] = "code"
    title: str
    text: str
    shown: bool = False


@dataclass(frozen=True)
class Chart:
    """Lines (nt,) over time by name, in SI; shown times ``scale`` in ``unit``. A chart of ``modes``
    has modes in place of values. ``folded`` ones are opened by the reader."""

    kind: ClassVar[str] = "chart"
    title: str
    unit: str
    series: dict[str, np.ndarray]
    scale: float = 1.0
    modes: bool = False
    folded: bool = False


@dataclass(frozen=True)
class Curve:
    """A line through ``y`` (n,) over ``x`` (n,), from ``low`` to ``high``; ``remarks`` (n,) are
    what points say when they are pointed at."""

    x: np.ndarray
    y: np.ndarray
    low: np.ndarray
    high: np.ndarray
    remarks: Sequence[str] = ()


@dataclass(frozen=True)
class Curves:
    """Curves by their names, over something other than time."""

    kind: ClassVar[str] = "curves"
    title: str
    x_label: str
    y_label: str
    curves: dict[str, Curve]


@dataclass(frozen=True)
class Replay:
    """A scene in three dimensions, as `hydrosim.report.replay` describes it."""

    kind: ClassVar[str] = "replay"
    data: dict[str, object]
    notes: Sequence[str]


Block = Text | Points | Table | Code | Chart | Curves | Replay


@dataclass(frozen=True)
class Section:
    """A part of the page with a heading, and its ``name`` in links."""

    name: str
    title: str
    blocks: Sequence[Block]


@dataclass(frozen=True)
class Document:
    """A page: its ``title``, what it is of in short, the ``time`` (nt,) [s] of its charts."""

    title: str
    subtitle: str
    sections: Sequence[Section]
    time: np.ndarray = field(default_factory=lambda: np.zeros(0))


def number(value: float, unit: str = "", digits: int = 4) -> Number:
    """A number with its unit; a dash where there is none."""
    value = float(value)
    return Number(value, f"{digits_of(value, digits)} {unit}".strip() if isfinite(value) else "–")
