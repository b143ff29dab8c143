"""Text files of other programs: lines, numbers, tables, and messages with the line number."""

from __future__ import annotations

import math
import re
from array import array
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from hydrosim.database.database import Real
from hydrosim.errors import InputError

# Tables of numbers: rows with their line numbers, placed in arrays.

Index = NDArray[np.intp]

_LARGEST_FILE = 2**30  # bytes
_LONGEST_LINE = 10_000  # characters
_LARGEST_NUMBER = 1e60  # products of a few such numbers stay finite
_SPARSEST = 64  # array size per row; symmetries leave out up to 9 of 10 rows
_COMMENT_MARKS = "!#\x1a"  # the last is the end of files of DOS
_COMMENT = re.compile(f"[{_COMMENT_MARKS}].*", re.DOTALL)
_BYTE_ORDER_MARK = "\xef\xbb\xbf"  # of UTF-8, read as 8-bit characters
# numbers of Fortran that Python does not read: 1.0D+00, and 1.0-101 for three-digit exponents
_FORTRAN = re.compile(r"([+-]?\d*\.\d*)[DdEe]?([+-]\d+)")


@dataclass(frozen=True)
class NumberTable:
    """``values`` (rows, columns), NaN in missing columns, and the ``line`` (rows,) of each row."""

    path: Path
    values: Real
    line: Index

    def problem(self, row: int, text: str, expected: str) -> InputError:
        """Error to raise about a row."""
        return InputError(f"{self.path}, line {self.line[row]}: found {text}, expected {expected}.")

    def whole_numbers(self, column: int, lowest: int, highest: int) -> Index:
        """A column of whole numbers between two limits."""
        values = self.values[:, column]
        wrong = (values != np.rint(values)) | (values < lowest) | (values > highest)
        if wrong.any():
            row = int(np.argmax(wrong))
            expected = f"a whole number from {lowest} to {highest} in column {column + 1}"
            raise self.problem(row, f"{values[row]:g}", expected)
        return values.astype(np.intp)

    def select_rows(self, rows: NDArray[np.bool_]) -> NumberTable:
        """The table with some of its rows."""
        return NumberTable(self.path, self.values[rows], self.line[rows])

    def fill_array(
        self, index: tuple[Index, ...], shape: tuple[int, ...], value: NDArray
    ) -> NDArray:
        """Array with each row's value in its place and NaN elsewhere. Raises `InputError` if a
        place is taken twice, or if the array is too large for the number of rows."""
        if math.prod(shape) > _SPARSEST * (len(self.line) + 1000):
            raise InputError(
                f"{self.path}: {len(self.line)} rows for {' x '.join(map(str, shape))} numbers;"
                " expected a row for most of them. Look for a frequency, heading or index that"
                " occurs in only one row."
            )
        place = np.ravel_multi_index(index, shape)
        first = np.unique(place, return_index=True)[1]
        if first.size < place.size:
            row = int(np.setdiff1d(np.arange(place.size), first)[0])
            before = self.line[int(np.argmax(place == place[row]))]
            raise self.problem(row, f"the same indices as in line {before}", "each of them once")
        spread = np.full(shape, np.nan, dtype=value.dtype)
        spread.ravel()[place] = value
        return spread


def read_table(path: Path, columns: tuple[int, ...]) -> NumberTable:
    """Rows of a file whose lines have one of these numbers of columns. Earlier lines that are not
    mostly numbers are a heading. Comments after ! or # are left out. Raises `InputError` for
    other lines."""
    width = max(columns)
    values, numbers = array("d"), array("q")
    for number, line in enumerate(_read_lines(path), 1):
        tokens = _split_tokens(line)
        if not tokens or (not numbers and _is_header_line(tokens)):
            continue
        row = _read_row(path, number, tokens, columns)
        values.extend(row + [math.nan] * (width - len(row)))
        numbers.append(number)
    if not numbers:
        raise InputError(
            f"{path}: found no rows of numbers, expected rows of {' or '.join(map(str, columns))}"
            " numbers. Is it empty or of another kind?"
        )
    return NumberTable(path, np.array(values).reshape(-1, width), np.array(numbers))


def read_lines(path: Path) -> list[str]:
    """Lines of a text file in any 8-bit coding. Raises `InputError` if it cannot be read."""
    return list(_read_lines(path))


def _read_lines(path: Path) -> Iterator[str]:
    """Lines one by one; a very long line, as in binary files, comes in pieces."""
    try:
        if path.stat().st_size > _LARGEST_FILE:
            raise InputError(f"{path}: is larger than 1 GiB; expected a table of coefficients.")
        with path.open(encoding="latin-1") as file:
            yield file.readline(_LONGEST_LINE).removeprefix(_BYTE_ORDER_MARK)
            yield from iter(lambda: file.readline(_LONGEST_LINE), "")
    except OSError as error:
        raise InputError(f"{path}: cannot be read ({error.strerror}).") from error


def number_in(token: str) -> float:
    """Number of a token, NaN if it is none."""
    try:
        return float(token)
    except ValueError:
        match = _FORTRAN.fullmatch(token)
    return float(f"{match[1]}e{match[2]}") if match and match[1].strip("+-.") else math.nan


def _split_tokens(line: str) -> list[str]:
    """Words of a line without its comment; a comma counts between numbers."""
    if any(mark in line for mark in _COMMENT_MARKS):
        line = _COMMENT.sub("", line)
    return line.replace(", ", " ").split()


def _is_header_line(tokens: list[str]) -> bool:
    return 2 * sum(math.isnan(number_in(token)) for token in tokens) > len(tokens)


def _read_row(path: Path, number: int, tokens: list[str], columns: tuple[int, ...]) -> list[float]:
    if len(tokens) not in columns:
        raise InputError(
            f"{path}, line {number}: found {len(tokens)} columns, expected"
            f" {' or '.join(map(str, columns))}. Is the file cut off or another kind of file?"
        )
    try:
        row = list(map(float, tokens))
    except ValueError:
        row = list(map(number_in, tokens))
    if sum(map(abs, row)) < _LARGEST_NUMBER:  # of most rows, and quicker than each number
        return row
    for token, value in zip(tokens, row, strict=True):
        if not abs(value) < _LARGEST_NUMBER:
            raise InputError(f"{path}, line {number}: found {token[:40]!r}, expected a number.")
    return row


_MAX_MAGNITUDE = 1e30  # above any quantity in any unit: a larger number is of a damaged file
_DAMAGED_FILE_ADVICE = "The file is damaged or of another version; export it again."


@dataclass(frozen=True)
class Text:
    """Lines of a file, counted from zero here and from one in messages."""

    path: Path
    lines: Sequence[str]

    def line(self, index: int, expected: str) -> str:
        """One line. Raises `InputError` if the file ends before it."""
        if index >= len(self.lines):
            raise self.wrong(len(self.lines) - 1, "the end of the file", expected)
        return self.lines[index]

    def numbers(self, index: int, words: Sequence[str], count: int | None = None) -> list[float]:
        """Words of a line as finite numbers. Raises `InputError` if there are not ``count``."""
        if count is not None and len(words) != count:
            raise self.wrong(index, f"{len(words)} numbers", f"{count}")
        return [self.number(index, word) for word in words]

    def number(self, index: int, word: str) -> float:
        """One finite number, in Fortran's notation, too."""
        value = parse_number(word)
        if value is None:
            raise self.wrong(index, repr(word.strip()[:40]), "a finite number")
        return value

    def count(self, index: int, word: str) -> int:
        """One whole number, not negative."""
        value = self.number(index, word)
        if value < 0 or value != int(value):
            raise self.wrong(index, repr(word.strip()[:40]), "a count")
        return int(value)

    def wrong(
        self, index: int, text: str, expected: str, advice: str = _DAMAGED_FILE_ADVICE
    ) -> InputError:
        """Error to raise about a line."""
        return InputError(
            f"{self.path}: line {index + 1}: found {text}, expected {expected}. {advice}"
        )


def read_text(path: Path) -> Text:
    """Lines of a file in UTF-8 (with or without a mark) or an 8-bit coding, with any line ends."""
    try:
        content = path.read_bytes().decode("utf-8-sig", errors="replace")
    except OSError as error:
        raise InputError(f"{path}: cannot be read ({error.strerror}).") from error
    content = content.rstrip("\x1a")  # the mark of the end of files of DOS
    return Text(path, content.replace("\r\n", "\n").replace("\r", "\n").split("\n"))


def parse_number(word: str) -> float | None:
    """Number of a word; None for other words, NaN, infinity and implausible sizes."""
    value = number_in(word)
    if "_" in word or not abs(value) <= _MAX_MAGNITUDE:  # also false for NaN
        return None
    return value
