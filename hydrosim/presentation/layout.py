"""Values as texts, and tables laid out: units where they are read best, decimals that line up."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from math import floor, isfinite, isinf, log10
from typing import NamedTuple, TypeGuard

from hydrosim.documents.digits import digits_of
from hydrosim.presentation.document import Between, Cell, Sentence, Table, Value
from hydrosim.presentation.units import Units

NOTHING = "–"
MOST_DECIMALS = 6
LITTLE = 1e-3
FEWEST = 2
"""Significant digits of the smallest numbers in a column."""
LARGEST = 1e9
"""Numbers from here on are written with a power of ten."""


class Shown(NamedTuple):
    """A cell as it is read; the ``number`` in SI, where it is one; whether it is ``numeric``."""

    text: str
    number: float | None = None
    numeric: bool = False


class Laid(NamedTuple):
    """A table as it is read: texts of its ``head``, cells of its ``rows``."""

    head: list[str]
    rows: list[list[Shown]]


def text_of(part: Cell, units: Units) -> str:
    """A value with its unit, a sentence with its values, or a text as it is."""
    match part:
        case Value():
            return _with_unit(_plain(part, units), part, units)
        case Between():
            low, high = (_plain(Value(end, part.unit, part.digits), units) for end in _ends(part))
            return _with_unit(_interval(part, low, high), part, units)
        case Sentence():
            filled = (text_of(each, units) for each in part.parts)
            return part.text.format(*filled) if part.parts else part.text
    return part


def laid_out(table: Table, units: Units) -> Laid:
    """A table with its units in the head, where a column has one for all rows. Where rows have
    units of their own in the other columns, they stand beside the name of the row."""
    width = len(table.head)
    columns = [[row[k] for row in table.rows if k < len(row)] for k in range(width)]
    settled = [k for k in range(width) if _is_of_one_unit(columns[k])]
    others = [k for k in range(1, width) if k not in settled]
    rows = [[_alone(cell, units) for cell in row] for row in table.rows]
    for k in settled:
        for i, cell in enumerate(_lined(columns[k], units)):
            rows[i][k] = cell
    for row, shown in zip(table.rows, rows, strict=True):
        _lay_row(row, shown, others, units)
    head = [_named(table.head[k], _unit_of(columns[k], units)) for k in range(width)]
    return Laid(head, rows)


def decimals_of(numbers: Iterable[float], digits: int) -> int:
    """Decimals with which the largest number has so many significant ``digits``, and numbers that
    are not `LITTLE` beside it have `FEWEST`; none for whole numbers."""
    known = [abs(x) for x in numbers if isfinite(x) and x != 0.0]
    if not known or all(x == round(x) and x < LARGEST for x in known):
        return 0
    largest = max(known)
    smallest = min(x for x in known if x >= LITTLE * largest)
    needed = max(_decimals(largest, digits), _decimals(smallest, min(digits, FEWEST)))
    return min(max(needed, 0), MOST_DECIMALS)


def _decimals(number: float, digits: int) -> int:
    return digits - 1 - floor(log10(number))


def _lay_row(row: Sequence[Cell], shown: list[Shown], others: list[int], units: Units) -> None:
    """Line up the cells of ``others`` in a row that has one unit in them, and name the unit."""
    here = [k for k in others if k < len(row)]
    cells = [row[k] for k in here]
    if not here or not _is_of_one_unit(cells):
        return
    for k, cell in zip(here, _lined(cells, units), strict=True):
        shown[k] = cell
    shown[0] = Shown(_named(shown[0].text, _unit_of(cells, units)))


def _has_unit(cell: Cell) -> TypeGuard[Value | Between]:
    return isinstance(cell, Value | Between)


def _is_of_one_unit(cells: Sequence[Cell]) -> bool:
    return len({cell.unit for cell in cells if _has_unit(cell)}) <= 1


def _unit_of(cells: Sequence[Cell], units: Units) -> str:
    """The unit that all cells with a unit are read in; nothing where they have several."""
    found = {cell.unit for cell in cells if _has_unit(cell)}
    return units.shown(found.pop()).unit if len(found) == 1 else ""


def _named(name: str, unit: str) -> str:
    return f"{name} [{unit}]" if unit else name


def _lined(cells: Sequence[Cell], units: Units) -> list[Shown]:
    """Cells of one unit with the same decimals. The unit itself is said elsewhere."""
    own = [cell for cell in cells if _has_unit(cell)]
    factor = units.shown(own[0].unit).factor if own else 1.0
    digits = max((cell.digits for cell in own), default=4)
    decimals = decimals_of((factor * end for cell in own for end in _ends(cell)), digits)
    return [
        _fixed(cell, factor, decimals) if _has_unit(cell) else _alone(cell, units) for cell in cells
    ]


def _ends(cell: Value | Between) -> tuple[float, ...]:
    return (cell.number,) if isinstance(cell, Value) else (cell.low, cell.high)


def _fixed(cell: Value | Between, factor: float, decimals: int) -> Shown:
    """A cell with so many decimals, without its unit."""
    ends = [_decimal(factor * end, decimals) for end in _ends(cell)]
    if isinstance(cell, Value):
        return Shown(ends[0], cell.number, True)
    return Shown(_interval(cell, *ends), None, True)


def _interval(cell: Between, low: str, high: str) -> str:
    """An interval in words. An end that is infinite is not known."""
    if isinf(cell.low) and isinf(cell.high):
        return NOTHING
    if isinf(cell.high):
        return f"{low} or more"
    if isinf(cell.low):
        return f"{high} or less"
    return NOTHING if low == high == NOTHING else f"{low} to {high}"


def _decimal(number: float, decimals: int) -> str:
    if not isfinite(number):
        return NOTHING
    if number == 0.0:
        return "0"
    if abs(number) < 0.5 * 10.0**-decimals or abs(number) >= LARGEST:
        return f"{number:.1e}"
    return f"{number:,.{decimals}f}"


def _alone(cell: Cell, units: Units) -> Shown:
    """A cell with its own unit."""
    number = cell.number if isinstance(cell, Value) else None
    return Shown(text_of(cell, units), number, _has_unit(cell))


def _plain(value: Value, units: Units) -> str:
    if not isfinite(value.number):
        return NOTHING
    return digits_of(units.shown(value.unit).factor * value.number, value.digits)


def _with_unit(text: str, cell: Value | Between, units: Units) -> str:
    unit = units.shown(cell.unit).unit
    return text if text == NOTHING else f"{text} {unit}".strip()
