"""Recorded series over time: columns of a text file, or variables of a run's netCDF.

`hydrosim.files.text` reads text files. Times [s] are in the column named time or t, or else in
the first column. A column has a name or a number, from 1 on.

In a run, a column is the name of a variable followed by the selection in its other dimensions, in
any order: ``force_wave_first_order.barge.surge``, ``fender_compression.interface 1``,
``wave_elevation``. A dimension of one entry needs no selection.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import product
from typing import TYPE_CHECKING

import numpy as np

from hydrosim.dofs import DOFS
from hydrosim.files import text as texts
from hydrosim.files.units import value_text

if TYPE_CHECKING:
    import xarray as xr

ANGLE_SUFFIXES = ("angle", "first_angle", "second_angle", "rotation_x", "rotation_y", "rotation_z")
"""Last words of the names of motions of joints that are angles."""
NETCDF = (b"\x89HDF", b"CDF\x01", b"CDF\x02", b"CDF\x05")
MIN_CUBIC_VALUES = 4  # values needed for a cubic
Column = str | int
# the attribute of statistics whose unit differs from that of their channel
STATISTIC_UNITS = "statistic_units"


@dataclass(frozen=True)
class Series:
    """The sum of some columns, ``value`` (n,) at the rising ``time`` (n,) [s], and its ``unit`` if
    the file gives it. ``label`` is the unit that a text file writes beside the names
    of the columns: it counts where nobody gives a factor."""

    time: np.ndarray
    value: np.ndarray
    unit: str | None = None
    label: str | None = None


def read_series(source: texts.Source, columns: Sequence[Column]) -> Series:
    """The sum of ``columns`` over time. Raises InputError with the mistake in the file and its
    place."""
    read = _read_run if source.head(4).startswith(NETCDF) else _read_text
    return read(source, columns)


def _read_text(source: texts.Source, columns: Sequence[Column]) -> Series:
    text = texts.parse(source)
    time = text.rows[:, _time_column(source, text)]
    picked = [_pick_column(source, text, column) for column in columns]
    _check_series(source, time, text.rows[:, picked], text.lines)
    labels = [_label_of_column(text, k) for k in picked]
    _require_one_unit(source, labels)
    return Series(time.copy(), text.rows[:, picked].sum(axis=1), label=labels[0])


def _label_of_column(text: texts.TextTable, k: int) -> str | None:
    """The unit of a column of a text file; None where the file says none that is known."""
    unit = texts.unit_of_column(text, k) if text.names else None
    return (texts.readable_unit(unit) or None) if unit else None


def _require_one_unit(source: texts.Source, units: Sequence[str | None]) -> None:
    if len(set(units)) > 1:
        units_text = " and ".join(unit or "no unit" for unit in units)
        source.wrong(f"found columns in {units_text}; expected one unit for all")


def _time_column(source: texts.Source, text: texts.TextTable) -> int:
    for i, name in enumerate(text.names):
        bare, unit = texts.name_and_unit(name)
        if texts.TIME_COLUMN.fullmatch(bare):
            unit_text = text.units[i].strip("[]()") if text.units else unit
            if unit_text not in (None, "", "s", "sec", "seconds"):
                column_text = value_text(name if unit else f"{name} {text.units[i]}")
                source.wrong(f"found {column_text}; expected the time in s; convert it")
            return i
    return 0


def _pick_column(source: texts.Source, text: texts.TextTable, column: Column) -> int:
    if isinstance(column, str) and text.names.count(column) == 1:
        return text.names.index(column)
    if isinstance(column, int):
        if not 1 <= column <= text.rows.shape[1]:
            count = text.rows.shape[1]
            source.wrong(f"found no column {column}; expected a number from 1 to {count}")
        return column - 1
    if not text.names:
        remedy = f"call it by its number, from 1 to {text.rows.shape[1]}"
        source.wrong(f"found no names of columns, and so no {value_text(column)}; {remedy}")
    if column in text.names:
        source.wrong(f"found more than one column {value_text(column)}; call it by its number")
    source.unknown("column", column, text.names)


def _read_run(source: texts.Source, columns: Sequence[Column]) -> Series:
    import xarray as xr

    try:
        with xr.open_dataset(source.file, engine="netcdf4", decode_times=False) as run:
            picked = [select(source, run, str(column)) for column in columns]
            time = np.array(run["time"].values, dtype=float)
    except (OSError, ValueError, RuntimeError) as error:
        source.wrong(f"cannot be read as netCDF ({error}); expected the result of `hydrosim run`")
    values, units = zip(*picked, strict=True)
    _require_one_unit(source, units)
    rows = np.stack(values, axis=1)
    _check_series(source, time, rows)
    return Series(time, rows.sum(axis=1), units[0])


def columns_of(run: xr.Dataset, modes: bool = False) -> Iterator[str]:
    """The names of all columns over time: measured quantities, or ``modes`` (flags) instead."""
    units_by_name: dict[str, list[str]] = {}
    for name in run.data_vars:
        variable = run.variables[name]
        if "time" in variable.dims and ("flag_values" in variable.attrs) == modes:
            dims = [*_other_dims(variable)]
            units_by_name |= {
                dim: [*map(str, _labels_along(run, dim))]
                for dim in dims
                if dim not in units_by_name
            }
            labels = [units_by_name[dim] for dim in dims]
            yield from (".".join([str(name), *chosen]) for chosen in product(*labels))


def select(source: texts.Source, run: xr.Dataset, column: str) -> tuple[np.ndarray, str]:
    """Values (n,) and unit of ``VARIABLE.SELECTION.SELECTION``."""
    name, _, rest = column.partition(".")
    labels = list[str]()
    chosen: dict[str, int] = {}
    over_time = [str(n) for n in run.data_vars if "time" in run.variables[n].dims]
    if name not in over_time:
        source.unknown("variable over time", name, over_time)
    values = run.variables[name]
    while rest:
        places = {
            str(label): (dim, at)
            for dim in _other_dims(values)
            for at, label in enumerate(_labels_along(run, dim))
        }
        # a name may contain points itself
        fitting = [x for x in places if f"{rest}.".startswith(f"{x}.")]
        if not fitting:
            source.unknown(f"selection from {name}", rest.partition(".")[0], list(places))
        label = max(fitting, key=len)
        dim, at = places[label]
        values = values.isel({dim: at})
        chosen[dim] = at
        labels.append(label)
        rest = rest[len(label) + 1 :]
    values = values.squeeze([dim for dim in _other_dims(values) if values.sizes[dim] == 1])
    if left := list(_other_dims(values)):
        example = ".".join([column, *(str(_labels_along(run, dim)[0]) for dim in left)])
        every = " and ".join(left)
        source.wrong(
            f'found {value_text(column)} for every {every}; expected one, as in "{example}"'
        )
    units = run.variables.get(f"{name}_unit")
    if units is not None and len(units.dims) == 1:
        return values.values.astype(float), str(units.values[chosen.get(str(units.dims[0]), 0)])
    return values.values.astype(float), unit_of(values.attrs, labels)


def units_along(run: xr.Dataset, name: str) -> dict[str, str]:
    """The units of a variable by the labels of its last dimension."""
    dim = str(run[name].dims[-1])
    labels = [*map(str, _labels_along(run, dim))]
    units = run.variables.get(f"{name}_unit")
    if units is not None and units.dims == (dim,):
        return dict(zip(labels, map(str, units.values), strict=True))
    return {label: unit_of(run[name].attrs, [label]) for label in labels}


def unit_of(attributes: Mapping[str, object], labels: Sequence[str]) -> str:
    """The unit of the selection by ``labels``, from the attributes of a variable. It is the unit of
    the statistic if the last label has its own, else of the degree of freedom, else of the
    variable. Motions of joints and drives are angles or offsets. Older files have "m or rad", or
    "m, rad or s", for translations and rotations."""
    apart = dict(
        pair.split(": ") for pair in str(attributes.get(STATISTIC_UNITS, "")).split(", ") if pair
    )
    if labels and labels[-1] in apart:
        return apart[labels[-1]]
    row = next((DOFS.index(label) for label in labels if label in DOFS), 0)
    if any(_is_turn(label) for label in labels):
        row = 3
    if "dof_units" in attributes:
        return str(attributes["dof_units"]).split(", ")[row]
    alternatives = re.split(", | or ", str(attributes.get("units", "")))
    return alternatives[min(row // 3, len(alternatives) - 1)]


def _is_turn(label: str) -> bool:
    """True for a motion of a joint, or of a drive, that is an angle."""
    unit, _, motion = label.rpartition(" ")
    return motion in ANGLE_SUFFIXES or (unit != "" and motion in DOFS[3:])


def _labels_along(run: xr.Dataset, dim: str) -> np.ndarray:
    """The labels along a dimension; numbers if it has no labels."""
    return run.variables[dim].values if dim in run.variables else np.arange(run.sizes[dim])


def _other_dims(values: xr.Variable) -> Iterator[str]:
    return (str(dim) for dim in values.dims if dim != "time")


def _check_series(
    source: texts.Source, time: np.ndarray, values: np.ndarray, lines: Sequence[int] | None = None
) -> None:
    """Refuses times that do not rise, numbers outside the usual range, and too few numbers."""
    for numbers in (time, *values.T):
        texts.require_finite(source, numbers, lines)
        texts.require_usual(source, numbers, lines=lines)
    texts.require_rising(source, time, lines)
    if time.size < MIN_CUBIC_VALUES:
        source.wrong(
            f"found {time.size} times; expected {MIN_CUBIC_VALUES} or more, for a smooth curve"
        )
