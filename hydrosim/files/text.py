"""Files of other programs: tables of numbers in texts, checks of numbers, damaged HDF5, directions.

A text file has one line per time, with numbers separated by commas, semicolons, tabs or blanks.
Lines before the first that begins with a number are a heading. Lines that begin with #, % or ! are
remarks (or that heading).

The last line of the heading may give the names of the columns, or their units below a line of
names. A line of dashes does not count. Names that contain blanks are separated by a tab or two
blanks.
"""

from __future__ import annotations

import os
import re
import stat
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from datetime import UTC, datetime
from functools import lru_cache
from pathlib import Path
from time import time_ns
from typing import TYPE_CHECKING, Any, NoReturn

import numpy as np

from hydrosim.errors import InputError
from hydrosim.files.messages import suggestion
from hydrosim.files.units import LARGEST_OF, MAX_QUANTITY, factor, value_text
from hydrosim.files.yaml_nodes import with_hint

if TYPE_CHECKING:
    import h5py
    import xarray as xr

# Files to read: plain ones alone, as a pipe or a device would wait without end.


def unreadable_reason(path: Path) -> str:
    """Reason why a path cannot be read, in words; empty if it is a plain file."""
    try:
        mode = path.stat().st_mode
    except FileNotFoundError:
        return "there is no such file"
    except (OSError, ValueError) as error:  # a name that is too long, or no valid name
        return f"cannot be read ({getattr(error, 'strerror', None) or error})"
    if stat.S_ISDIR(mode):
        return "is a directory"
    if not stat.S_ISREG(mode):
        return "is a pipe or a device, not a file"
    return "" if os.access(path, os.R_OK) else "may not be read"


# Damage of HDF5 files and links out of them, found by h5py: netCDF's library may crash on them.

MAGIC = b"\x89HDF"
# ns: the times of a file that has just changed may not show the next change
SETTLED = 10_000_000_000


def fault(path: Path) -> str | None:
    """Fault in the structure of a file, None if it has none. Sizes and attributes of everything in
    the file are read, data are not. The result is cached until the file changes."""
    try:
        status = path.stat()
    except OSError as error:
        return str(error)
    changes = status.st_mtime_ns, status.st_ctime_ns
    if time_ns() - max(changes) < SETTLED:
        return _fault_of_file(path)
    return _stored_fault(path.absolute(), status.st_ino, status.st_size, *changes)


@lru_cache(maxsize=64)
def _stored_fault(path: Path, *state: int) -> str | None:
    """Fault of the file in this state."""
    return _fault_of_file(path)


def _fault_of_file(path: Path) -> str | None:
    import h5py  # slow to load, and dry scenes have no databases

    try:
        with h5py.File(path) as file:
            _touch("/", file)
            file.visititems(_touch)
    except (OSError, RuntimeError, KeyError, TypeError, ValueError, OverflowError) as error:
        return str(error)
    return None


def _touch(name: str, item: h5py.Group | h5py.Dataset) -> None:
    import h5py

    dict(item.attrs)
    if isinstance(item, h5py.Dataset):
        _ = item.shape, item.dtype
        outside = bool(item.external) or item.is_virtual
    else:
        links = (item.get(key, getlink=True) for key in item)
        outside = any(isinstance(link, h5py.ExternalLink) for link in links)
    if outside:
        raise ValueError(f"{name} points to another file; links to files are not followed")


REMARKS = ("#", "%", "!")
SEPARATORS = (";", ",", "\t", None)
RULE = re.compile(r"[-=_+|\s]*")
IN_BRACKETS = re.compile(r"(?P<name>.*?)\s*(?:\[(?P<unit>[^\]]*)\]|\((?P<round>[^)]*)\))\s*")
TIME_COLUMN = re.compile(r"(?:time|t)", re.IGNORECASE)
DATE = re.compile(r"\d{4}-\d\d-\d\d")
DATED = ", or a date such as 2020-01-31T12:00"
EPOCH = np.datetime64("1970-01-01", "ms")
PLAIN = {"": "", "-": "", "1": ""}  # units of plain numbers
SPELLINGS = {  # spellings that programs write
    **{f"{prefix}Nm": f"{prefix}N*m" for prefix in ("", "k", "M", "G")},
    **{f"{prefix}N-m": f"{prefix}N*m" for prefix in ("", "k", "M", "G")},
    **dict.fromkeys(("sec", "second", "seconds"), "s"),
    **dict.fromkeys(("degree", "degrees", "deg."), "deg"),
    **dict.fromkeys(("metre", "metres", "meter", "meters"), "m"),
    "m/s2": "m/s^2",
    "radians": "rad",
}


@dataclass(frozen=True)
class Source:
    """A data ``file``, and ``wanted``, the place in a case file that refers to it, if there is
    one."""

    file: Path
    wanted: str = ""

    def wrong(self, text: str, line: int | None = None) -> NoReturn:
        """Raises InputError with the place that refers to the file, the file, the line, and the
        mistake."""
        place = f"{self.file}:{line}" if line else f"{self.file}"
        raise InputError(": ".join(part for part in (self.wanted, place, text) if part))

    def head(self, size: int) -> bytes:
        """The beginning of the file; raises InputError if the file cannot be read."""
        if reason := unreadable_reason(self.file):
            self.wrong(f"{reason}; expected a recorded series")
        try:
            with self.file.open("rb") as opened:
                return opened.read(size)
        except OSError as error:
            self.wrong(f"cannot be read ({error.strerror}); expected a recorded series")

    def unknown(
        self, what: str, name: str, names: Sequence[str], line: int | None = None
    ) -> NoReturn:
        """Raises InputError: ``name`` is not among the ``names``."""
        text = f"found no {what} {value_text(name)}; expected one of: {', '.join(names) or 'none'}"
        self.wrong(with_hint(text, suggestion(name, names)), line)


@dataclass(frozen=True)
class TextTable:
    """A text file: ``names`` and ``units`` of the columns (empty if it has none), and ``rows``
    (n, columns) with the number of the line of each; ``dated`` if it has dates."""

    names: list[str]
    units: list[str]
    rows: np.ndarray
    lines: list[int]
    dated: bool = False


def escape_unprintable(text: str) -> str:
    """The text in one line, with characters that print nothing as their numbers: names in results
    of others may hold anything."""
    if text.isprintable():
        return text
    return "".join(c if c.isprintable() else f"\\u{ord(c):04x}" for c in text)


def parse(source: Source, dates: bool = False, first: str = "the time [s]") -> TextTable:
    """The table in a text file. Lines have the kind of quantity ``first`` in their first column. If
    ``dates`` is true, dates (2020-01-31T12:00, UTC unless they give another zone) count as seconds
    since `EPOCH`. Raises InputError with the line of a mistake."""
    try:
        content = source.file.read_bytes().decode("utf-8-sig")
    except UnicodeDecodeError as error:
        source.wrong(
            "found bytes that are no text; expected text (UTF-8) or the netCDF of a run",
            error.object[: error.start].count(b"\n") + 1,
        )
    heading = list[str]()
    rows = list[list[float]]()
    lines = list[int]()
    separator: str | None = None
    dated = list[bool]()
    for number, line in enumerate(content.splitlines(), 1):
        stripped = line.strip()
        remark = stripped.startswith(REMARKS)
        if not rows and (remark or not _begins_with_number(stripped, dates)):
            heading.append(stripped.lstrip("".join(REMARKS)).strip())
        elif stripped and not remark:
            if not rows:
                separator = _find_separator(stripped)
                dated = _date_fields(stripped, separator)
            rows.append(_parse_numbers(source, number, stripped, separator, dates))
            lines.append(number)
            if dates and _date_fields(stripped, separator) != dated:
                source.wrong(
                    "found a date in some lines, none in others; expected one kind", number
                )
            if len(rows[-1]) != len(rows[0]):
                found_text = f"found {len(rows[-1])} values; expected {len(rows[0])}"
                source.wrong(f"{found_text}, as in line {lines[0]}", number)
    if not rows:
        or_date = DATED if dates else ""
        source.wrong(
            f"found no numbers; expected lines of numbers, the first of them {first}{or_date}"
        )
    columns = _read_header(heading, separator, len(rows[0]))
    return TextTable(*columns, np.array(rows), lines, dates and any(dated))


def name_and_unit(text: str) -> tuple[str, str | None]:
    """Name and unit of "Heave (m)" or "Fx [kN]"; the whole text and None if it has no known
    unit."""
    match = IN_BRACKETS.fullmatch(text.strip())
    unit = match and readable_unit(match["unit"] if match["round"] is None else match["round"])
    return (text.strip(), None) if not match or unit is None else (match["name"], unit)


def unit_of_column(table: TextTable, k: int) -> str | None:
    """The unit that a file gives for a column, in its name or below it."""
    if table.units:
        return table.units[k].strip("[]()")
    return name_and_unit(table.names[k])[1]


def readable_unit(text: str) -> str | None:
    """A unit as `factor` reads it, None if it is unknown: "kNm" is "kN*m", "-" is ""."""
    unit = text.strip().strip("[]()").strip()
    unit = PLAIN.get(unit, SPELLINGS.get(unit, unit))
    try:
        return unit if not unit or factor(unit, unit) else None
    except ValueError:
        return None


def require_finite(
    source: Source, numbers: np.ndarray, lines: Sequence[int] | None = None, what: str = ""
) -> None:
    """Refuses numbers (n,) that are not finite; ``lines`` are their lines in a text."""
    bad = np.flatnonzero(~np.isfinite(numbers))
    if bad.size:
        where = "" if lines else f" in record {bad[0] + 1}"
        text = f"found {numbers[bad[0]]:g}{what}{where}; expected finite numbers"
        source.wrong(f"{text}; mend or leave it out", lines[bad[0]] if lines else None)


def require_usual(
    source: Source, numbers: np.ndarray, unit: str = "", lines: Sequence[int] | None = None
) -> None:
    """Refuses numbers (n,) in the SI ``unit`` that exceed the largest value allowed in a case."""
    largest = LARGEST_OF.get(unit, MAX_QUANTITY)
    bad = np.flatnonzero(np.abs(numbers) > largest)
    if bad.size:
        where = "" if lines else f" in record {bad[0] + 1}"
        found_text = f"found {numbers[bad[0]]:g}{f' {unit}' if unit else ''}{where}"
        text = f"{found_text}; expected {largest:g} or less; mend the number, or its factor"
        source.wrong(text, lines[bad[0]] if lines else None)


def require_rising(source: Source, time: np.ndarray, lines: Sequence[int] | None = None) -> None:
    """Refuses times (n,) [s] that do not rise."""
    falls = np.flatnonzero(np.diff(time) <= 0.0)
    if falls.size:
        k = int(falls[0]) + 1
        where = "" if lines else f" in record {k + 1}"
        text = f"found time {time[k]:g} s after {time[k - 1]:g} s{where}; expected it to rise"
        source.wrong(text, lines[k] if lines else None)


def _begins_with_number(line: str, dates: bool) -> bool:
    """True if a line begins with a number, or with a date."""
    first = re.split(r"[,;\s]", line)[0]
    if dates and DATE.match(first):
        return True
    try:
        float(first)
    except ValueError:
        return False
    return True


def _date_fields(line: str, separator: str | None) -> list[bool]:
    """Flags of the fields of a line that are dates."""
    return [bool(DATE.match(field)) for field in _split_line(line, separator)]


def _parse_number(field: str, dates: bool) -> float:
    if not dates or not DATE.match(field):
        return float(field)
    date = datetime.fromisoformat(field)
    return (date if date.tzinfo else date.replace(tzinfo=UTC)).timestamp()


def _find_separator(line: str) -> str | None:
    return next(mark for mark in SEPARATORS if mark is None or mark in line)


def _split_line(line: str, separator: str | None) -> list[str]:
    return [part.strip().strip("\"'") for part in line.split(separator)]


def _parse_numbers(
    source: Source, line: int, text: str, separator: str | None, dates: bool
) -> list[float]:
    numbers = []
    for field in _split_line(text, separator):
        try:
            numbers.append(_parse_number(field, dates))
        except ValueError:
            remedy = "a decimal point, not a comma, and # before a remark"
            if separator == ";" and "," in field:
                remedy = f'";" separates columns here; write {value_text(field.replace(",", "."))}'
            expected = f"a number{DATED if dates else ''}; {remedy}"
            source.wrong(f"found {value_text(field)}; expected {expected}", line)
    return numbers


def _read_header(
    heading: Sequence[str], separator: str | None, count: int
) -> tuple[list[str], list[str]]:
    """Names and units of ``count`` columns; empty if the heading does not give them."""
    written = [line for line in heading if not RULE.fullmatch(line)]
    rows = [_split_fields(line, separator, count) for line in written[-2:]]
    if len(rows) == 2 and all(rows) and all(readable_unit(field) is not None for field in rows[1]):
        return rows[0], rows[1]
    return (rows[-1] if rows else []), []


def _split_fields(line: str, separator: str | None, count: int) -> list[str]:
    """The ``count`` fields of a line; empty if their number differs."""
    apart = [part.strip() for part in re.split(r"\t|\s{2,}", line)] if separator is None else []
    fields = apart if len(apart) == count else _split_line(line, separator)
    return fields if len(fields) == count else []


# Directional spectra in files of other programs.

GOING_WORDS = re.compile("to direction|going to|go to|towards?|to which|propagation|oceanographic")
COMING_WORDS = re.compile("from direction|coming from|come from|from which|meteorological|nautical")
DIRECTION_ATTRIBUTES = ("standard_name", "long_name", "convention")
"""Attributes that tell, the first that does so first."""
SPECTRAL_UNITS = {"freq": ("Hz", "1/s", "s-1", "s^-1"), "dir": ("deg",)}
SAME_DIRECTION_DEG = 1e-6
SAME_DENSITY_RTOL = 1e-6


def is_heading(source: Source, name: str, attributes: Mapping[Any, Any]) -> bool:
    """Whether the directions ``name`` are headings, which waves go to, by their ``attributes``,
    such as the standard name sea_surface_wave_to_direction of CF. Without a word they are those
    that waves come from. Raises InputError if one attribute says both."""
    for key in DIRECTION_ATTRIBUTES:
        text = str(attributes.get(key, "")).lower().replace("_", " ")
        going, coming = GOING_WORDS.search(text), COMING_WORDS.search(text)
        if going and coming:
            source.wrong(
                f'found {name} with {key} "{attributes[key]}"; expected either from or to: the'
                " standard names are sea_surface_wave_from_direction and"
                " sea_surface_wave_to_direction"
            )
        if going or coming:
            return going is not None
    return False


def check_spectral_units(source: Source, efth: xr.DataArray) -> None:
    """Raises InputError unless freq is in Hz and dir in degrees, where the file says so."""
    for name, units in SPECTRAL_UNITS.items():
        text = str(efth[name].attrs.get("units", units[0]))
        if not text.lower().startswith(tuple(unit.lower() for unit in units)):
            source.wrong(f"found {name} in {text}; expected {units[0]}, as wavespectra has it")


def without_repeats(source: Source, efth: xr.DataArray) -> xr.DataArray:
    """Spectra ``efth`` over dir [deg], each direction once: a circle that is closed has its first
    direction again, a turn on. Raises InputError if the densities there differ."""
    bearing = np.asarray(efth["dir"].values, dtype=float)
    keep: list[int] = []
    for k, angle in enumerate(bearing):
        apart = np.abs(np.mod(bearing[keep] - angle + 180.0, 360.0) - 180.0)
        same = [keep[i] for i in np.flatnonzero(apart <= SAME_DIRECTION_DEG)]
        if not same:
            keep.append(k)
            continue
        first, again = (efth.isel(dir=i).values.astype(float) for i in (same[0], k))
        if not np.allclose(first, again, rtol=SAME_DENSITY_RTOL, atol=0.0, equal_nan=True):
            source.wrong(
                f"found {bearing[same[0]]:g} and {angle:g} deg, one direction, with different"
                " densities; expected each direction once"
            )
    return efth if len(keep) == bearing.size else efth.isel(dir=keep)
