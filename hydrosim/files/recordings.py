"""Recordings of other programs and tests: `read_recording` reads all, `write_recording` a text.

`write_recording`: channels of a run as a text table for other programs.

Layout: comment lines with #, a line of names, a line of units in brackets, and a line for each
time. Columns are right-aligned, of fixed width, and at least two blanks apart (names may contain
single blanks). So the file can be read by position or by blanks. The first column is the time.
Numbers have 17 significant digits by default, which restore each number to the bit.
"""

from __future__ import annotations

import zlib
from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import zip_longest
from pathlib import Path
from typing import TYPE_CHECKING, Any

import h5py
import numpy as np
import scipy
import xarray as xr

from hydrosim.files import text as texts
from hydrosim.files.outputs import Output, as_output
from hydrosim.files.series import columns_of, select
from hydrosim.files.units import value_text

if TYPE_CHECKING:
    import pandas as pd

# `Recording`: columns of a file, by name or number, with their units if the file has them.


@dataclass(frozen=True)
class RecordedColumn:
    """Values (n,) of a column ``name``, in ``unit`` ("" for a plain number, None if unknown)."""

    name: str
    unit: str | None
    value: np.ndarray


@dataclass(frozen=True)
class Recording:
    """All columns of a file, including the time, of one length. ``form`` is the format of the file,
    ``lines`` are the line numbers of a text, and ``left_out`` names data that are not over time."""

    source: texts.Source
    form: str
    columns: Sequence[RecordedColumn]
    lines: Sequence[int] | None = None
    left_out: Sequence[str] = ()

    def column(self, key: str | int) -> RecordedColumn:
        """Column of that name, with or without its unit, or of that number, from 1 on. Raises
        InputError that lists the columns."""
        if isinstance(key, int):
            if not 1 <= key <= len(self.columns):
                text = f"found no column {key}; expected a number from 1 to {len(self.columns)}"
                self.source.wrong(text)
            return self.columns[key - 1]
        named = [column for column in self.columns if column.name == key]
        named = named or [c for c in self.columns if texts.name_and_unit(c.name)[0] == key]
        if len(named) > 1:
            self.source.wrong(f"found more than one column {value_text(key)}; use its number")
        if not named:
            self.source.unknown("column", key, [column.name for column in self.columns])
        return named[0]

    def time_column(self) -> RecordedColumn:
        """Column named time or t, else the first."""
        return next((column for column in self.columns if is_time(column.name)), self.columns[0])


def is_time(name: str) -> bool:
    """Whether a name is "time", "Time (s)", "test3.t" or similar."""
    return texts.TIME_COLUMN.fullmatch(texts.name_and_unit(name)[0].rsplit(".")[-1]) is not None


def of_arrays(
    source: texts.Source,
    form: str,
    arrays: Mapping[str, np.ndarray],
    units: Mapping[str, str | None],
) -> Recording:
    """Recording from the arrays of a file. It keeps arrays that are as long as the array of the
    time, or else of the most frequent length. An array (n, m) or (m, n) gives m columns, with their
    number in the name."""
    numbers = {name: a for name, a in arrays.items() if a.dtype.kind in "iuf" and a.size > 1}
    lengths = [max(a.shape) for name, a in numbers.items() if is_time(name)]
    lengths = lengths or [
        n for n, _ in Counter(max(a.shape) for a in numbers.values()).most_common()
    ]
    columns, left_out = list[RecordedColumn](), list[str]()
    for name, array in numbers.items():
        rows = _columns_over_time(np.asarray(array, dtype=float), lengths[0])
        left_out += [] if rows else [name]
        for i, row in enumerate(rows, 1):
            columns.append(
                RecordedColumn(f"{name} {i}" if len(rows) > 1 else name, units.get(name), row)
            )
    if not columns:
        source.wrong(
            "found no numbers over time; expected arrays of one length, one of which is the time"
        )
    return Recording(source, form, columns, left_out=left_out)


def _columns_over_time(array: np.ndarray, count: int) -> list[np.ndarray]:
    """Columns of an array that is over time along either dimension; empty if it is not."""
    flat = np.squeeze(array)
    if flat.ndim == 1 and flat.size == count:
        return [flat]
    if flat.ndim == 2 and count in flat.shape:
        return list(flat.T if flat.shape[0] == count else flat)
    return []


# Recordings in text: csv, columns separated by blanks or tabs, and tables of aNySIM.


def read_text(source: texts.Source) -> Recording:
    """Columns of a text file; columns without names are called "column 2" and so on."""
    table = texts.parse(source)
    names = table.names or [f"column {i}" for i in range(1, table.rows.shape[1] + 1)]
    columns = [
        RecordedColumn(
            name, texts.name_and_unit(name)[1] if unit is None else texts.readable_unit(unit), value
        )
        for name, unit, value in zip_longest(names, table.units, table.rows.T)
    ]
    return Recording(source, "text", columns, table.lines)


# Recordings in MATLAB files up to version 7 (7.3 is HDF5).

# Exceptions of scipy about damaged files
_DAMAGE = (
    ArithmeticError,
    EOFError,
    LookupError,
    MemoryError,
    OSError,
    RuntimeError,
    TypeError,
    ValueError,
    zlib.error,
)


def read_matlab5(source: texts.Source) -> Recording:
    """Arrays over time in a MATLAB file; arrays in a struct are named "struct.field"."""
    from scipy.io import loadmat
    from scipy.io.matlab import MatReadError

    try:
        content = loadmat(source.file, squeeze_me=True, struct_as_record=False)
    except (MatReadError, *_DAMAGE) as error:
        source.wrong(f"cannot be read as MATLAB file ({error}); save it again")
    named = ((name, value) for name, value in content.items() if not name.startswith("__"))
    arrays = {name: array for variable in named for name, array in _arrays_of_item(*variable)}
    return of_arrays(
        source, "MATLAB", arrays, {name: texts.name_and_unit(name)[1] for name in arrays}
    )


def _arrays_of_item(name: str, value: Any) -> Iterator[tuple[str, np.ndarray]]:
    for field in getattr(value, "_fieldnames", ()):
        yield from _arrays_of_item(f"{name}.{field}", getattr(value, field))
    if isinstance(value, np.ndarray):
        yield name, value


# Recordings in netCDF. Columns of a run have the names of `hydrosim.files.series`.


def read_netcdf(source: texts.Source) -> Recording:
    """Variables over time, ``VARIABLE.SELECTION``. Entries of a dimension without names are
    numbered from 1 on."""
    try:
        with xr.open_dataset(source.file, engine="netcdf4", decode_times=False) as opened:
            dataset = opened.load()
    except (OSError, ValueError, RuntimeError) as error:
        source.wrong(f"cannot be read as netCDF ({error}); is it complete?")
    time = next((dim for dim in map(str, dataset.dims) if is_time(dim)), None)
    if time is None:
        names = ", ".join(map(str, dataset.dims))
        source.wrong(f"found the dimensions {names or 'none'}; expected time, or t, among them")
    if time not in dataset.coords:
        source.wrong(f"found a dimension {time} without values; expected the times [s]")
    stamp = dataset[time]
    first = RecordedColumn(
        time, _unit_of_attribute(stamp.attrs.get("units")), stamp.values.astype(float)
    )
    over_time = _label_dimensions(dataset, time)
    columns = [first]
    for name in columns_of(over_time):
        values, unit = select(source, over_time, name)
        columns.append(RecordedColumn(name, _unit_of_attribute(unit or None), values))
    return Recording(source, "netCDF", columns)


def _label_dimensions(dataset: xr.Dataset, time: str) -> xr.Dataset:
    """Numeric variables over a dimension called time, with names for the entries of other
    dimensions."""
    renamed = dataset.rename({time: "time"}) if time != "time" else dataset
    numbers = renamed[[name for name, array in renamed.items() if array.dtype.kind in "iuf"]]
    labels = {
        dim: [str(x) for x in (numbers[dim].values if dim in numbers.coords else range(1, n + 1))]
        for dim, n in numbers.sizes.items()
        if dim != "time"
    }
    return numbers.assign_coords(labels)


def _unit_of_attribute(text: str | None) -> str | None:
    """Unit from an attribute, such as "s" from "seconds since 2020-01-01"."""
    return None if text is None else texts.readable_unit(text.split(" since ")[0])


# Recordings in HDF5: plain, as MATLAB 7.3 writes them, and netCDF.

UNIT_ATTRIBUTES = ("units", "unit", "Units", "Unit")  # attributes that may give the unit
OF_NETCDF = "_NCProperties"


def read_hdf5(source: texts.Source) -> Recording:
    """Datasets over time in an HDF5 file, named by their paths, "group.dataset"."""
    if reason := texts.fault(source.file):
        source.wrong(f"cannot be read as HDF5 ({reason}); is it complete?")
    with h5py.File(source.file) as file:
        if OF_NETCDF not in file.attrs:
            return _read_format(source, "HDF5", file)
    return read_netcdf(source)


def read_matlab(source: texts.Source) -> Recording:
    """Arrays over time in a MATLAB 7.3 file, with structs as groups."""
    if reason := texts.fault(source.file):
        source.wrong(f"cannot be read as MATLAB 7.3 file ({reason}); is it complete?")
    with h5py.File(source.file) as file:
        return _read_format(source, "MATLAB 7.3", file)


def _read_format(source: texts.Source, form: str, file: h5py.File) -> Recording:
    arrays, units = dict[str, np.ndarray](), dict[str, str | None]()

    def take(path: str, item: h5py.Group | h5py.Dataset) -> None:
        # the cells of MATLAB point to "#refs#"
        if isinstance(item, h5py.Dataset) and item.dtype.kind in "iuf" and path[0] != "#":
            name = path.replace("/", ".")
            arrays[name] = item[()]
            unit_text = next(
                (item.attrs[key] for key in UNIT_ATTRIBUTES if key in item.attrs), None
            )
            text = unit_text.decode() if isinstance(unit_text, bytes) else unit_text
            units[name] = None if text is None else texts.readable_unit(str(text))

    file.visititems(take)
    return of_arrays(source, form, arrays, units)


# `read_recording`: recognises the kind of file from its beginning, and reads it.

Reader = Callable[[texts.Source], Recording]
READERS: Mapping[bytes, Reader] = {  # by the first bytes of a file; all other files are text
    b"MATLAB 5.0 MAT-file": read_matlab5,
    b"MATLAB 7.3 MAT-file": read_matlab,
    b"\x89HDF": read_hdf5,
    b"CDF": read_netcdf,
}


def read_recording(path: Path | str) -> Recording:
    """Read all columns of a recorded series: text, MATLAB (v5, v7.3), HDF5, or netCDF, such as a
    run.

    Raises InputError with the file, the line of a text, the value found and the value expected.
    """
    source = texts.Source(Path(path))
    head = source.head(max(map(len, READERS)))
    return next((read for mark, read in READERS.items() if head.startswith(mark)), read_text)(
        source
    )


def recording_of_frame(frame: pd.DataFrame) -> Recording:
    """Recording from a frame of pandas, whose columns may name units: "Heave [mm]". Where no column
    is the time, it is the index [s]."""
    has_time = any(is_time(str(name)) for name in frame)
    table = frame if has_time else frame.rename_axis("time").reset_index()
    columns = [
        RecordedColumn(str(name), texts.name_and_unit(str(name))[1], table[name].to_numpy(float))
        for name in table
    ]
    return Recording(texts.Source(Path("frame")), "a frame of pandas", columns)


EXACT = 17  # significant digits that distinguish any two float64
GAP = 2  # blanks between columns, at least


def write_recording(
    run: xr.Dataset,
    target: Path | Output,
    channels: Sequence[str],
    step: float | None = None,
    digits: int = EXACT,
    shown: Callable[[str], tuple[str, float]] | None = None,
) -> None:
    """Write ``channels`` ("position.barge.heave") of a run to a text file, at the run's
    times or at every ``step`` [s] from its start on, there by cubic splines. ``shown`` gives for an
    SI unit the unit to write, and what numbers in SI are multiplied by; without it all is in SI.

    The file appears under its name when it is complete. Raises InputError for unknown channels.
    """
    output = as_output(target, "recording")
    columns = [select(texts.Source(output.path), run, channel) for channel in channels]
    time, rows = run.time.values, np.stack([values for values, _ in columns], axis=1)
    if step is not None:
        at = time[0] + step * np.arange(int((time[-1] - time[0]) / step * (1.0 + 1e-12)) + 1)
        time, rows = at, scipy.interpolate.CubicSpline(time, rows)(at)
    names = ["time", *map(texts.escape_unprintable, channels)]
    column_units = [unit for _, unit in columns]
    if shown is not None:
        rows = rows * np.array([shown(unit)[1] for unit in column_units])
        column_units = [shown(unit)[0] for unit in column_units]
    units = [f"[{texts.escape_unprintable(unit)}]" for unit in ("s", *column_units)]
    text = "SI and radians" if shown is None else "units of the case"
    number = digits + 7  # sign, point and exponent are 7 at most
    widths = [
        GAP + max(number, len(name), len(unit)) for name, unit in zip(names, units, strict=True)
    ]
    heading = [
        f"# {texts.escape_unprintable(str(run.attrs.get('title', '')))}".rstrip(),
        f"# {output.mark}; {text}; {digits} significant digits",
        *("".join(map(str.rjust, row, widths)) for row in (names, units)),
    ]
    with output.write_complete() as path:
        np.savetxt(
            path,
            np.column_stack([time, rows]),
            fmt=[f"%{width}.{digits - 1}e" for width in widths],
            delimiter="",
            header="\n".join(heading),
            comments="",
            encoding="utf-8",
        )
