"""What a document is made of.

There are six kinds of node: `Heading`, `Sentence`, `Table`, `List`, `Verdict` and figures. Numbers
stay numbers until they are rendered: a `Value` holds SI.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from enum import Enum
from typing import ClassVar

import numpy as np

from hydrosim.files.display_units import DEFAULT, Units

# What a document can draw. The terminal leaves figures out; commands write pictures beside it.


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


@dataclass(frozen=True)
class Value:
    """A ``number`` in the SI ``unit``, read to so many significant ``digits``. A number that is not
    finite is read as a dash."""

    number: float
    unit: str = ""
    digits: int = 4


@dataclass(frozen=True)
class Between:
    """An interval from ``low`` to ``high`` in the SI ``unit``, read to so many ``digits``."""

    low: float
    high: float
    unit: str = ""
    digits: int = 4


Part = Value | Between | str
"""What fills a place in a sentence."""


@dataclass(frozen=True)
class Sentence:
    """A text whose places ``{}`` are filled with ``parts``: values, or texts as they are. A text
    without parts is shown as it is. ``detail`` is for readers who ask for more."""

    kind: ClassVar[str] = "sentence"
    text: str
    parts: Sequence[Part] = ()
    detail: bool = False


Cell = Part | Sentence
"""What stands in a table."""


@dataclass(frozen=True)
class Heading:
    """The title of what follows, up to the next heading; ``name`` is its place in links."""

    kind: ClassVar[str] = "heading"
    text: str
    name: str = ""
    detail: bool = False


@dataclass(frozen=True)
class Table:
    """Rows under a ``head``. The first cell of a row says what the row is of."""

    kind: ClassVar[str] = "table"
    head: Sequence[str]
    rows: Sequence[Sequence[Cell]]
    title: str = ""
    detail: bool = False


@dataclass(frozen=True)
class List:
    """Remarks, one after the other."""

    kind: ClassVar[str] = "list"
    items: Sequence[str | Sentence]
    title: str = ""
    detail: bool = False


class Outcome(Enum):
    """How good what a verdict says is."""

    GOOD = "good"
    WARNING = "warning"
    BAD = "bad"


@dataclass(frozen=True)
class Verdict:
    """One line that says how a question came out, such as whether a criterion is met."""

    kind: ClassVar[str] = "verdict"
    outcome: Outcome
    text: str
    parts: Sequence[Part] = ()
    detail: bool = False

    @property
    def sentence(self) -> Sentence:
        """What the verdict says."""
        return Sentence(self.text, self.parts)


Node = Heading | Sentence | Table | List | Verdict | Figure


@dataclass(frozen=True)
class Section:
    """A heading and the nodes below it."""

    heading: Heading
    nodes: Sequence[Node]


@dataclass(frozen=True)
class DocumentContents:
    """A ``title``, what it is of in short, and the nodes. ``time`` (nt,) [s] is that of charts."""

    title: str
    nodes: Sequence[Node]
    subtitle: str = ""
    units: Units = DEFAULT
    time: np.ndarray = field(default_factory=lambda: np.zeros(0))

    @property
    def sections(self) -> list[Section]:
        """The nodes below each heading. What stands before the first has a heading without text."""
        return list(_split_sections(self.nodes))


def warnings(lines: Sequence[str]) -> list[Verdict]:
    """A verdict for each line of warning."""
    return [Verdict(Outcome.WARNING, line) for line in lines]


def _split_sections(nodes: Sequence[Node]) -> Iterator[Section]:
    heading = Heading("")
    below: list[Node] = []
    for node in nodes:
        if not isinstance(node, Heading):
            below.append(node)
            continue
        if below or heading.text:
            yield Section(heading, below)
        heading = node
        below = []
    if below or heading.text:
        yield Section(heading, below)
