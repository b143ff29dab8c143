"""What a document is made of.

There are six kinds of node: `Heading`, `Sentence`, `Table`, `List`, `Verdict` and figures. Numbers
stay numbers until they are rendered: a `Value` holds SI.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from enum import Enum
from typing import Any, ClassVar, NamedTuple

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


def _no_values() -> np.ndarray:
    return np.zeros(0)


@dataclass(frozen=True)
class ChartLine:
    """A line through ``y`` (n,), or a band over several lines ``y`` (m, n), over ``x`` (n,) in SI;
    default: the time of the document. It may have intervals from ``low`` to ``high`` (n,), and
    ``remarks`` (n,) that points say when they are pointed at. Where ``y`` is unknown and beyond a
    bound, ``bounds`` (n,) have it: a point there is open and not joined. If y is a mean, pictures
    also draw the interval ``wide`` (2, n) of single values, and the ``values`` themselves."""

    y: np.ndarray
    x: np.ndarray = field(default_factory=_no_values)
    low: np.ndarray = field(default_factory=_no_values)
    high: np.ndarray = field(default_factory=_no_values)
    bounds: np.ndarray = field(default_factory=_no_values)
    remarks: Sequence[str] = ()
    wide: np.ndarray = field(default_factory=_no_values)
    values: Sequence[np.ndarray] = ()

    @property
    def peak(self) -> float:
        """Largest magnitude."""
        return float(np.abs(np.nan_to_num(self.y)).max(initial=0.0))


@dataclass(frozen=True)
class Chart:
    """Lines by their names, of a ``quantity`` in the SI ``unit``, as pages and pictures draw them.

    The ``title`` stands above it on a page, the quantity beside its axis. A line without a name is
    the quantity itself. ``subject`` is the body, contact or axis that all lines are of. ``order``
    has the names of all possible lines, for colours that stay. Many lines are drawn in pictures as
    bands of their ``groups``, by the names of lines. A chart of ``modes`` has modes in place of
    values. The reader of a page opens ``folded`` ones."""

    kind: ClassVar[str] = "chart"
    title: str
    quantity: str
    unit: str
    lines: Mapping[str, ChartLine]
    subject: str = ""
    order: Sequence[str] = ()
    groups: Mapping[str, str] = field(default_factory=dict)
    modes: bool = False
    folded: bool = False
    x_label: str = "time"
    x_unit: str = "s"

    @property
    def names(self) -> list[str]:
        """The names of the lines; that of a line without one is the quantity."""
        return [name or self.quantity for name in self.lines]

    @property
    def styles(self) -> list[int]:
        """The place of each line in the order, which its colour follows."""
        order = list(self.order)
        return [order.index(n) if n in order else k for k, n in enumerate(self.lines)]

    @property
    def is_over_time(self) -> bool:
        """Whether the lines are over the time of the document."""
        return all(line.x.size == 0 for line in self.lines.values())

    @property
    def peak(self) -> float:
        """Largest magnitude in the lines."""
        return max((line.peak for line in self.lines.values()), default=0.0)


class ShadedPhase(NamedTuple):
    """An interval of time [s] with a name. Charts over time have every other one shaded."""

    name: str
    start: float
    end: float


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


Figure = Code | Chart | Replay | Drawing


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


def value_cells(numbers: Iterable[Any], unit: str = "", digits: int = 4) -> list[Value]:
    """Numbers of one unit."""
    return [Value(float(number), unit, digits) for number in numbers]


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
Row = list[Cell]
"""A row of a table."""


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
Nodes = Iterator[Node]
"""Nodes one after the other."""


@dataclass(frozen=True)
class Section:
    """A heading and the nodes below it."""

    heading: Heading
    nodes: Sequence[Node]


@dataclass(frozen=True)
class DocumentContents:
    """A ``title``, what it is of in short, and the nodes. ``time`` (nt,) [s] is that of charts,
    which have the ``phases`` shaded."""

    title: str
    nodes: Sequence[Node]
    subtitle: str = ""
    units: Units = DEFAULT
    time: np.ndarray = field(default_factory=_no_values)
    phases: Sequence[ShadedPhase] = ()

    @property
    def sections(self) -> list[Section]:
        """The nodes below each heading. What stands before the first has a heading without text."""
        return list(_split_sections(self.nodes))


def warning(text: str, parts: Sequence[Part] = ()) -> Verdict:
    """A verdict that is a warning."""
    return Verdict(Outcome.WARNING, text, parts)


def warnings(lines: Sequence[str]) -> list[Verdict]:
    """A verdict for each line of warning."""
    return [warning(line) for line in lines]


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
