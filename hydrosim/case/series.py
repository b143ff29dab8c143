"""Recorded series over time: columns of a text file, or variables of a run's netCDF.

A text file has one line per time, its numbers separated by commas, semicolons, tabs or blanks;
lines before the first that begins with a number are a heading, and the last of them may name the
columns; lines that begin with #, % or ! are remarks (or that heading). The times [s] are the column
named time or t, else the first. A column is called by its name or its number, from 1 on.

In a run, a column is the name of a variable and what is selected of its other dimensions, in any
order: ``force_wave_first_order.barge.surge``, ``fender_compression.interface 1``,
``wave_elevation``. A dimension of one entry needs no selection.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, NoReturn

import numpy as np

from hydrosim.case.nodes import joined, suggestion
from hydrosim.case.units import shown
from hydrosim.errors import InputError
from hydrosim.scene import DOFS

if TYPE_CHECKING:
    import xarray as xr

REMARKS = ("#", "%", "!")
SEPARATORS = (",", ";", "\t", None)
NETCDF = (b"\x89HDF", b"CDF\x01", b"CDF\x02", b"CDF\x05")
TIME = re.compile(r"(?:time|t)\s*(?:[\[(](?P<unit>.*)[\])])?", re.IGNORECASE)
ENOUGH = 4  # values, for a cubic
Column = str | int


@dataclass(frozen=True)
class Series:
    """The sum of some columns, ``value`` (n,) at the rising ``time`` (n,) [s], and its ``unit`` if
    the file says it."""

    time: np.ndarray
    value: np.ndarray
    unit: str | None = None


@dataclass(frozen=True)
class Source:
    """A data ``file``, and ``wanted``, the place in the case file that wants it."""

    file: Path
    wanted: str

    def wrong(self, text: str, line: int | None = None) -> NoReturn:
        """Raises InputError: who wants the file, the file, the line, and what is wrong with it."""
        place = f"{self.file}:{line}" if line else f"{self.file}"
        raise InputError(f"{self.wanted}: {place}: {text}")

    def unknown(self, what: str, name: str, known: Sequence[str]) -> NoReturn:
        """Raises InputError: ``name`` is not among the ``known``."""
        text = f"found no {what} {shown(name)}; expected one of: {', '.join(known) or 'none'}"
        self.wrong(joined(text, suggestion(name, known)))


def read_series(source: Source, columns: Sequence[Column]) -> Series:
    """The sum of ``columns`` over time; InputError says what in the file is wrong, and where."""
    try:
        start = source.file.open("rb").read(4)
    except OSError as error:
        source.wrong(f"cannot be read: {error.strerror}; expected a recorded series")
    read = _read_run if start.startswith(NETCDF) else _read_text
    return read(source, columns)


@dataclass(frozen=True)
class _Text:
    """A text file: ``names`` of the columns, if it has them, and ``rows`` (n, columns) with the
    number of the line of each."""

    names: list[str]
    rows: np.ndarray
    lines: list[int]


def _read_text(source: Source, columns: Sequence[Column]) -> Series:
    text = _parse(source)
    time = text.rows[:, _time_column(source, text)]
    picked = [_pick(source, text, column) for column in columns]
    _check(source, time, text.rows[:, picked], text.lines)
    return Series(time.copy(), text.rows[:, picked].sum(axis=1))


def _parse(source: Source) -> _Text:
    try:
        content = source.file.read_bytes().decode("utf-8-sig")
    except UnicodeDecodeError:
        source.wrong("found bytes that are no text; expected text (UTF-8) or the netCDF of a run")
    heading, rows, lines = "", list[list[float]](), list[int]()
    separator: str | None = None
    for number, line in enumerate(content.splitlines(), 1):
        stripped = line.strip()
        remark = stripped.startswith(REMARKS)
        if not rows and (remark or not _begins(stripped)):
            heading = stripped.lstrip("".join(REMARKS)).strip() or heading
        elif stripped and not remark:
            separator = separator if rows else _separator(stripped)
            rows.append(_numbers(source, number, _split(stripped, separator)))
            lines.append(number)
            if len(rows[-1]) != len(rows[0]):
                found = f"found {len(rows[-1])} values; expected {len(rows[0])}"
                source.wrong(f"{found}, as in line {lines[0]}", number)
    if not rows:
        source.wrong("found no numbers; expected lines of numbers, the first of them the time [s]")
    names = _split(heading, separator)
    return _Text(names if len(names) == len(rows[0]) else [], np.array(rows), lines)


def _begins(line: str) -> bool:
    """True if a line begins with a number."""
    try:
        float(re.split(r"[,;\s]", line)[0])
    except ValueError:
        return False
    return True


def _separator(line: str) -> str | None:
    return next(mark for mark in SEPARATORS if mark is None or mark in line)


def _split(line: str, separator: str | None) -> list[str]:
    return [part.strip().strip("\"'") for part in line.split(separator)]


def _numbers(source: Source, line: int, fields: Sequence[str]) -> list[float]:
    numbers = []
    for field in fields:
        try:
            numbers.append(float(field))
        except ValueError:
            remedy = "a decimal point, not a comma, and # before a remark"
            source.wrong(f"found {shown(field)}; expected a number; {remedy}", line)
    return numbers


def _time_column(source: Source, text: _Text) -> int:
    for i, name in enumerate(text.names):
        if found := TIME.fullmatch(name):
            if found["unit"] not in (None, "", "s", "sec", "seconds"):
                source.wrong(f"found {shown(name)}; expected the time in s; convert it")
            return i
    return 0


def _pick(source: Source, text: _Text, column: Column) -> int:
    if isinstance(column, str) and text.names.count(column) == 1:
        return text.names.index(column)
    if isinstance(column, int):
        if not 1 <= column <= text.rows.shape[1]:
            count = text.rows.shape[1]
            source.wrong(f"found no column {column}; expected a number from 1 to {count}")
        return column - 1
    if not text.names:
        remedy = f"call it by its number, from 1 to {text.rows.shape[1]}"
        source.wrong(f"found no names of columns, and so no {shown(column)}; {remedy}")
    if column in text.names:
        source.wrong(f"found more than one column {shown(column)}; call it by its number")
    source.unknown("column", column, text.names)


def _read_run(source: Source, columns: Sequence[Column]) -> Series:
    import xarray as xr

    try:
        with xr.open_dataset(source.file, engine="netcdf4", decode_times=False) as run:
            picked = [_select(source, run, str(column)) for column in columns]
            time = np.array(run["time"].values, dtype=float)
    except (OSError, ValueError) as error:
        source.wrong(f"cannot be read as netCDF ({error}); expected the result of `hydrosim run`")
    values, units = zip(*picked, strict=True)
    if len(set(units)) > 1:
        source.wrong(f"found columns in {' and '.join(units)}; expected one unit for all")
    rows = np.stack(values, axis=1)
    _check(source, time, rows)
    return Series(time, rows.sum(axis=1), units[0])


def _select(source: Source, run: xr.Dataset, column: str) -> tuple[np.ndarray, str]:
    """Values (n,) and unit of ``VARIABLE.SELECTION.SELECTION``."""
    name, *labels = column.split(".")
    over_time = [str(n) for n, variable in run.data_vars.items() if "time" in variable.dims]
    if name not in over_time:
        source.unknown("variable over time", name, over_time)
    values = run[name]
    for label in labels:
        choices = {str(x): str(dim) for dim in _others(values) for x in run[dim].values}
        if label not in choices:
            source.unknown(f"selection from {name}", label, list(choices))
        values = values.sel({choices[label]: label})
    values = values.squeeze([dim for dim in _others(values) if values.sizes[dim] == 1])
    if left := list(_others(values)):
        example = ".".join([column, *(str(run[dim].values[0]) for dim in left)])
        source.wrong(
            f'found {shown(column)} for every {" and ".join(left)}; expected one, as in "{example}"'
        )
    # "m or rad": of translations or rotations
    units = str(values.attrs.get("units", "")).split(" or ")
    return values.values.astype(float), units[-1 if set(labels) & {*DOFS[3:]} else 0]


def _others(values: xr.DataArray) -> Iterator[str]:
    return (str(dim) for dim in values.dims if dim != "time")


def _check(
    source: Source, time: np.ndarray, values: np.ndarray, lines: Sequence[int] | None = None
) -> None:
    """Refuses times that do not rise, numbers that are not finite, and too few of them."""

    def at(i: int) -> int | None:
        return lines[i] if lines else None

    for numbers in (time, *values.T):
        bad = np.flatnonzero(~np.isfinite(numbers))
        if bad.size:
            where = "" if lines else f" in record {bad[0] + 1}"
            text = (
                f"found {numbers[bad[0]]:g}{where}; expected finite numbers; mend or leave it out"
            )
            source.wrong(text, at(int(bad[0])))
    falls = np.flatnonzero(np.diff(time) <= 0.0)
    if falls.size:
        k = int(falls[0]) + 1
        source.wrong(
            f"found time {time[k]:g} s after {time[k - 1]:g} s; expected it to rise", at(k)
        )
    if time.size < ENOUGH:
        source.wrong(f"found {time.size} times; expected {ENOUGH} or more, for a smooth curve")
