"""Text files of other programs: lines and numbers, and messages with the line number."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from hydrosim.database.readers.tables import number_in
from hydrosim.errors import InputError

_MAX_MAGNITUDE = 1e30  # above any quantity in any unit: a larger number is of a damaged file
_DAMAGED = "The file is damaged or of another version; export it again."


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

    def wrong(self, index: int, found: str, expected: str, advice: str = _DAMAGED) -> InputError:
        """Error to raise about a line."""
        return InputError(
            f"{self.path}: line {index + 1}: found {found}, expected {expected}. {advice}"
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
