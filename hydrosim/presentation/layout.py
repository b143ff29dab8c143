"""Values as texts, and tables laid out: units where they are read best, decimals that line up."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from math import floor, isfinite, isinf, log10
from typing import NamedTuple

from hydrosim.documents.digits import digits_of
from hydrosim.presentation.nodes import Between, Cell, Sentence, Table, Value
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


class Scale(NamedTuple):
    """What numbers of one unit are multiplied by, and the decimals that they are read with."""

    factor: float
    decimals: int


class Laid(NamedTuple):
    """A table as it is read: texts of its ``head``, cells of its ``rows``."""

    head: list[str]
    rows: list[list[Shown]]


def text_of(part: Cell, units: Units) -> str:
    """The text to print for a part: a value gets its unit, a sentence its values, and a text stays
    as it is."""
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
    """A table with units in the head, where all rows of a column have the same. Where a row has one
    of its own in the other columns, it stands beside the name of the row."""
    width = len(table.head)
    cells = [[*row, *[""] * (width - len(row))] for row in table.rows]
    columns = [[row[k] for row in cells] for k in range(width)]
    settled = [k for k in range(width) if _are_alike(columns[k])]
    others = [k for k in range(1, width) if k not in settled]
    rows = [[_alone(cell, units) for cell in row] for row in cells]
    for k in settled:
        for shown, cell in zip(rows, _lined(columns[k], units), strict=True):
            shown[k] = cell
    for row, shown in zip(cells, rows, strict=True):
        _lay_row(row, shown, others, units)
    head = [_named(table.head[k], _unit_of(columns[k], units)) for k in range(width)]
    return Laid(head, rows)


def decimals_of(numbers: Iterable[float], digits: int) -> int:
    """Decimals with which the largest number has so many significant ``digits``, and numbers that
    are not `LITTLE` beside it have `FEWEST`. Zeros at the end of all numbers are left out."""
    known = [abs(x) for x in numbers if isfinite(x) and x != 0.0]
    if not known:
        return 0
    largest = max(known)
    smallest = min(x for x in known if x >= LITTLE * largest)
    needed = max(_decimals(largest, digits), _decimals(smallest, min(digits, FEWEST)))
    most = min(max(needed, 0), MOST_DECIMALS)
    return next((n for n in range(most) if _are_exact(known, n, most)), most)


def _are_exact(numbers: Sequence[float], decimals: int, most: int) -> bool:
    """Whether numbers lose nothing by fewer ``decimals`` than the ``most``."""
    return all(abs(x - round(x, decimals)) < 0.5 * 10.0**-most for x in numbers)


def _decimals(number: float, digits: int) -> int:
    return digits - 1 - floor(log10(number))


def _lay_row(row: Sequence[Cell], shown: list[Shown], others: list[int], units: Units) -> None:
    """Line up the cells of ``others`` in a row that has the same unit in them, and name it."""
    cells = [row[k] for k in others]
    if not others or not _are_alike(cells):
        return
    for k, cell in zip(others, _lined(cells, units), strict=True):
        shown[k] = cell
    shown[0] = Shown(_named(shown[0].text, _unit_of(cells, units)))


def _measured(cell: Cell) -> Sequence[Value | Between]:
    """The values of a cell that holds nothing else; none of one that holds words."""
    match cell:
        case Value() | Between():
            return (cell,)
        case Sentence() if not any(map(str.isalpha, cell.text)):
            values = [part for part in cell.parts if isinstance(part, Value | Between)]
            return values if len(values) == len(cell.parts) else ()
    return ()


def _units_in(cell: Cell) -> tuple[str, ...]:
    """The SI units of the values of a cell, each once."""
    return tuple(dict.fromkeys(value.unit for value in _measured(cell)))


def _are_alike(cells: Sequence[Cell]) -> bool:
    """Whether all cells that have units have the same."""
    return len({_units_in(cell) for cell in cells if _measured(cell)}) <= 1


def _unit_of(cells: Sequence[Cell], units: Units) -> str:
    """The units that all cells with units are read in; nothing where they have others."""
    found = {_units_in(cell) for cell in cells if _measured(cell)}
    each = found.pop() if len(found) == 1 else ()
    return ", ".join(filter(None, (units.shown(unit).unit for unit in each)))


def _named(name: str, unit: str) -> str:
    return f"{name} [{unit}]".strip() if unit else name


def _lined(cells: Sequence[Cell], units: Units) -> list[Shown]:
    """Cells of the same units with the same decimals. The units themselves are said elsewhere."""
    values: dict[str, list[Value | Between]] = {}
    for value in (value for cell in cells for value in _measured(cell)):
        values.setdefault(value.unit, []).append(value)
    scales = {unit: _scale(own, units.shown(unit).factor) for unit, own in values.items()}
    return [_fixed(cell, scales) if _measured(cell) else _alone(cell, units) for cell in cells]


def _scale(values: Sequence[Value | Between], factor: float) -> Scale:
    digits = max(value.digits for value in values)
    return Scale(factor, decimals_of((factor * end for v in values for end in _ends(v)), digits))


def _ends(value: Value | Between) -> tuple[float, ...]:
    return (value.number,) if isinstance(value, Value) else (value.low, value.high)


def _fixed(cell: Cell, scales: Mapping[str, Scale]) -> Shown:
    """A cell with the decimals of its column or row, without its units."""
    texts = [_scaled(value, scales[value.unit]) for value in _measured(cell)]
    if isinstance(cell, Sentence):
        return Shown(cell.text.format(*texts), None, True)
    return Shown(texts[0], cell.number if isinstance(cell, Value) else None, True)


def _scaled(value: Value | Between, scale: Scale) -> str:
    ends = [_decimal(scale.factor * end, scale.decimals) for end in _ends(value)]
    return ends[0] if isinstance(value, Value) else _interval(value, *ends)


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
    readable = 10.0 ** (FEWEST - 1) if decimals == MOST_DECIMALS else 0.5
    if not readable * 10.0**-decimals <= abs(number) < LARGEST:
        return f"{number:.1e}"
    return f"{number:,.{decimals}f}"


def _alone(cell: Cell, units: Units) -> Shown:
    """A cell with its own unit."""
    number = cell.number if isinstance(cell, Value) else None
    return Shown(text_of(cell, units), number, bool(_measured(cell)))


def _plain(value: Value, units: Units) -> str:
    if not isfinite(value.number):
        return NOTHING
    return digits_of(units.shown(value.unit).factor * value.number, value.digits)


def _with_unit(text: str, cell: Value | Between, units: Units) -> str:
    unit = units.shown(cell.unit).unit
    return text if text == NOTHING else f"{text} {unit}".strip()
