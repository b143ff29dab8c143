"""Values as texts, and tables laid out: units where they are read best, decimals that line up."""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping, Sequence
from math import floor, isfinite, isinf, log10
from string import ascii_uppercase
from typing import NamedTuple

from hydrosim.files.display_units import Units
from hydrosim.files.document_nodes import Between, Cell, Sentence, Table, Value


def digits_of(value: float, digits: int = 4) -> str:
    """A number with this many significant digits, without powers of ten where it is readable
    without."""
    if 10.0**digits <= abs(value) < 1e9:
        return f"{float(f'{value:.{digits - 1}e}'):,.0f}"
    return f"{value:.{digits}g}"


# Values of a study in words; long ones get letters.


def value_text(value: object) -> str:
    """A value in words: a list or a table, which a study holds as JSON, without its brackets."""
    if isinstance(value, float):
        return f"{value:.4g}"
    text = str(value)
    if not text.startswith(("[", "{")):
        return text
    try:
        return _value_words(json.loads(text), "; ")
    except ValueError:
        return text


def _value_words(value: object, between: str = ", ") -> str:
    """A value in words; items of a list of lists are told apart from their own items."""
    if isinstance(value, dict):
        return ", ".join(f"{key} {_value_words(of, '; ')}" for key, of in value.items())
    if isinstance(value, list):
        return between.join(map(_value_words, value)) or "none"
    return f"{value:.4g}" if isinstance(value, float) else str(value)


def letter_of(index: int) -> str:
    """A, B, ..., Z, AA, AB, ..."""
    before, letter = divmod(index, len(ascii_uppercase))
    return (letter_of(before - 1) if before else "") + ascii_uppercase[letter]


NO_VALUE = "–"
MOST_DECIMALS = 6
NEGLIGIBLE_FRACTION = 1e-3
MIN_DIGITS = 2
"""Significant digits of the smallest numbers in a column."""
MAX_PLAIN_NUMBER = 1e9
"""Numbers from here on are written with a power of ten."""


class RenderedCell(NamedTuple):
    """A cell as it is read; the ``number`` in SI, where it is one; whether it is ``numeric``."""

    text: str
    number: float | None = None
    numeric: bool = False


class DecimalScale(NamedTuple):
    """What numbers of one unit are multiplied by, and the decimals that they are read with."""

    factor: float
    decimals: int


class RenderedTable(NamedTuple):
    """A table as it is read: texts of its ``head``, cells of its ``rows``."""

    head: list[str]
    rows: list[list[RenderedCell]]


def text_of(part: Cell, units: Units) -> str:
    """The text to print for a part: a value gets its unit, a sentence its values, and a text stays
    as it is."""
    match part:
        case Value():
            return _text_with_unit(_number_text(part, units), part, units)
        case Between():
            low, high = (
                _number_text(Value(end, part.unit, part.digits), units)
                for end in _interval_ends(part)
            )
            return _text_with_unit(_interval_text(part, low, high), part, units)
        case Sentence():
            filled = (text_of(piece, units) for piece in part.parts)
            return part.text.format(*filled) if part.parts else part.text
    return part


def render_table(table: Table, units: Units) -> RenderedTable:
    """A table with units in the head, where all rows of a column have the same. Where a row has one
    of its own in the other columns, it stands beside the name of the row."""
    width = len(table.head)
    cells = [[*row, *[""] * (width - len(row))] for row in table.rows]
    columns = [[row[k] for row in cells] for k in range(width)]
    settled = [k for k in range(width) if _are_alike(columns[k])]
    others = [k for k in range(1, width) if k not in settled]
    rows = [[_render_with_unit(cell, units) for cell in row] for row in cells]
    for k in settled:
        for shown, cell in zip(rows, _align_cells(columns[k], units), strict=True):
            shown[k] = cell
    for row, shown in zip(cells, rows, strict=True):
        _lay_row(row, shown, others, units)
    head = [name_with_unit(table.head[k], _unit_of(columns[k], units)) for k in range(width)]
    return RenderedTable(head, rows)


def decimals_of(numbers: Iterable[float], digits: int) -> int:
    """Decimals with which the largest number has so many significant ``digits``, and numbers that
    are not `NEGLIGIBLE_FRACTION` beside it have `MIN_DIGITS`. Zeros at the end of all numbers are
    left out."""
    magnitudes = [abs(x) for x in numbers if isfinite(x) and x != 0.0]
    if not magnitudes:
        return 0
    largest = max(magnitudes)
    smallest = min(x for x in magnitudes if x >= NEGLIGIBLE_FRACTION * largest)
    needed = max(_decimals_of(largest, digits), _decimals_of(smallest, min(digits, MIN_DIGITS)))
    most = min(max(needed, 0), MOST_DECIMALS)
    return next((n for n in range(most) if _are_exact(magnitudes, n, most)), most)


def _are_exact(numbers: Sequence[float], decimals: int, most: int) -> bool:
    """Whether numbers lose nothing by fewer ``decimals`` than the ``most``."""
    return all(abs(x - round(x, decimals)) < 0.5 * 10.0**-most for x in numbers)


def _decimals_of(number: float, digits: int) -> int:
    return digits - 1 - floor(log10(number))


def _lay_row(
    row: Sequence[Cell], shown: list[RenderedCell], others: list[int], units: Units
) -> None:
    """Line up the cells of ``others`` in a row that has the same unit in them, and name it."""
    cells = [row[k] for k in others]
    if not others or not _are_alike(cells):
        return
    for k, cell in zip(others, _align_cells(cells, units), strict=True):
        shown[k] = cell
    shown[0] = RenderedCell(name_with_unit(shown[0].text, _unit_of(cells, units)))


def _values_of_cell(cell: Cell) -> Sequence[Value | Between]:
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
    return tuple(dict.fromkeys(value.unit for value in _values_of_cell(cell)))


def _are_alike(cells: Sequence[Cell]) -> bool:
    """Whether all cells that have units have the same."""
    return len({_units_in(cell) for cell in cells if _values_of_cell(cell)}) <= 1


def _unit_of(cells: Sequence[Cell], units: Units) -> str:
    """The units that all cells with units are read in; nothing where they have others."""
    unit_sets = {_units_in(cell) for cell in cells if _values_of_cell(cell)}
    common_units = unit_sets.pop() if len(unit_sets) == 1 else ()
    return ", ".join(filter(None, (units.display_unit(unit).unit for unit in common_units)))


def name_with_unit(name: str, unit: str) -> str:
    """A name, and the unit in brackets where there is one."""
    return f"{name} [{unit}]".strip() if unit else name


def _align_cells(cells: Sequence[Cell], units: Units) -> list[RenderedCell]:
    """Cells of the same units with the same decimals. The units themselves are said elsewhere."""
    values: dict[str, list[Value | Between]] = {}
    for value in (value for cell in cells for value in _values_of_cell(cell)):
        values.setdefault(value.unit, []).append(value)
    scales = {
        unit: _common_scale(cells_of_unit, units.display_unit(unit).factor)
        for unit, cells_of_unit in values.items()
    }
    return [
        _render_aligned(cell, scales) if _values_of_cell(cell) else _render_with_unit(cell, units)
        for cell in cells
    ]


def _common_scale(values: Sequence[Value | Between], factor: float) -> DecimalScale:
    digits = max(value.digits for value in values)
    return DecimalScale(
        factor, decimals_of((factor * end for v in values for end in _interval_ends(v)), digits)
    )


def _interval_ends(value: Value | Between) -> tuple[float, ...]:
    return (value.number,) if isinstance(value, Value) else (value.low, value.high)


def _render_aligned(cell: Cell, scales: Mapping[str, DecimalScale]) -> RenderedCell:
    """A cell with the decimals of its column or row, without its units."""
    texts = [_scaled_text(value, scales[value.unit]) for value in _values_of_cell(cell)]
    if isinstance(cell, Sentence):
        return RenderedCell(cell.text.format(*texts), None, True)
    return RenderedCell(texts[0], cell.number if isinstance(cell, Value) else None, True)


def _scaled_text(value: Value | Between, scale: DecimalScale) -> str:
    ends = [_decimal_text(scale.factor * end, scale.decimals) for end in _interval_ends(value)]
    return ends[0] if isinstance(value, Value) else _interval_text(value, *ends)


def _interval_text(cell: Between, low: str, high: str) -> str:
    """An interval in words. An end that is infinite is not known."""
    if isinf(cell.low) and isinf(cell.high):
        return NO_VALUE
    if isinf(cell.high):
        return f"{low} or more"
    if isinf(cell.low):
        return f"{high} or less"
    return NO_VALUE if low == high == NO_VALUE else f"{low} to {high}"


def _decimal_text(number: float, decimals: int) -> str:
    if not isfinite(number):
        return NO_VALUE
    if number == 0.0:
        return "0"
    readable = 10.0 ** (MIN_DIGITS - 1) if decimals == MOST_DECIMALS else 0.5
    if not readable * 10.0**-decimals <= abs(number) < MAX_PLAIN_NUMBER:
        return f"{number:.1e}"
    return f"{number:,.{decimals}f}"


def _render_with_unit(cell: Cell, units: Units) -> RenderedCell:
    """A cell with its own unit."""
    number = cell.number if isinstance(cell, Value) else None
    return RenderedCell(text_of(cell, units), number, bool(_values_of_cell(cell)))


def _number_text(value: Value, units: Units) -> str:
    if not isfinite(value.number):
        return NO_VALUE
    return digits_of(units.display_unit(value.unit).factor * value.number, value.digits)


def _text_with_unit(text: str, cell: Value | Between, units: Units) -> str:
    unit = units.display_unit(cell.unit).unit
    return text if text == NO_VALUE else f"{text} {unit}".strip()
