"""Exact comparison of two results. They are identical if every variable, coordinate and attribute
is equal to the bit, except those that tell when and where a result was made. This holds on one type
of processor and one set of versions. NaN equals itself."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

from hydrosim.errors import InputError
from hydrosim.files.file_checks import no_file

OF_MAKING = frozenset({"wall_time", "history", "settings", "date_created", "host"})
"""Variables and attributes that differ between two makings of one result."""


def differences(first: xr.Dataset, second: xr.Dataset, ignored: Collection[str] = ()) -> list[str]:
    """All differences between two results, one per line; empty if they are identical.

    `OF_MAKING` and the names in ``ignored`` are skipped, variables and attributes alike.
    """
    left_out = {*OF_MAKING, *ignored}
    return [
        *_attributes("", first.attrs, second.attrs, left_out),
        *_variables(first, second, left_out),
    ]


def read_result(path: Path) -> xr.Dataset:
    """All variables of a netCDF file, in memory. Raises InputError if it cannot be read."""
    if reason := no_file(path):
        raise InputError(f"{path}: {reason}; expected netCDF.")
    try:
        return xr.load_dataset(path, engine="netcdf4", decode_times=False)
    except (OSError, ValueError, RuntimeError) as error:
        raise InputError(f"{path}: cannot be read as netCDF ({error}); is it complete?") from None


def _variables(first: xr.Dataset, second: xr.Dataset, left_out: Collection[str]) -> Iterator[str]:
    for name in sorted({*map(str, first.variables), *map(str, second.variables)} - {*left_out}):
        if name in first.variables and name in second.variables:
            here = first.variables[name]
            there = second.variables[name]
            yield from _values(name, here, there)
            yield from _attributes(f"{name}: ", here.attrs, there.attrs, left_out)
        else:
            yield f"{name}: {_only_in(name in first.variables)}"


def _values(name: str, first: xr.Variable, second: xr.Variable) -> Iterator[str]:
    if dict(first.sizes) != dict(second.sizes) or first.dims != second.dims:
        yield f"{name}: {_sizes(first)} and {_sizes(second)}"
        return
    a = _as_comparable(first.values)
    b = _as_comparable(second.values)
    if a.dtype != b.dtype:
        yield f"{name}: types {a.dtype} and {b.dtype}"
    elif (unequal := _unequal_values(a, b)).any():
        k = int(np.argmax(unequal))
        count = f"{np.count_nonzero(unequal)} of {unequal.size} values differ"
        at = np.unravel_index(k, first.shape)
        place = ", ".join(f"{dim} {i}" for dim, i in zip(first.dims, at, strict=True))
        place_text = f"first {a.ravel()[k]} and {b.ravel()[k]}" + (f" at {place}" if place else "")
        yield f"{name}: {count}, {place_text}"


def _attributes(
    of: str, first: Mapping[Any, Any], second: Mapping[Any, Any], left_out: Collection[str]
) -> Iterator[str]:
    for name in sorted({*first, *second} - {*left_out}):
        if (name in first) != (name in second):
            yield f"{of}attribute {name}: {_only_in(name in first)}"
            continue
        a, b = (_as_comparable(np.ravel(side[name])) for side in (first, second))
        if a.dtype != b.dtype or a.shape != b.shape or _unequal_values(a, b).any():
            yield f"{of}attribute {name}: {_shorten(first[name])} and {_shorten(second[name])}"


def _as_comparable(values: Any) -> np.ndarray:
    """Array in which texts of any length have one type."""
    array = np.asarray(values)
    return array.astype(object) if array.dtype.kind in "US" else array


def _unequal_values(first: np.ndarray, second: np.ndarray) -> np.ndarray:
    """Unequal values of two arrays of one type and shape, flattened."""
    if first.dtype.kind == "O":
        return np.asarray(first.ravel() != second.ravel(), dtype=bool)
    bits = f"V{first.dtype.itemsize}"
    a, b = (np.ascontiguousarray(array).ravel() for array in (first, second))
    differ = np.asarray(a.view(bits) != b.view(bits))
    return differ & ~(np.isnan(a) & np.isnan(b)) if first.dtype.kind == "f" else differ


def _only_in(in_first: bool) -> str:
    return f"only in the {'first' if in_first else 'second'}"


def _sizes(variable: xr.Variable) -> str:
    return ", ".join(f"{dim} {n}" for dim, n in variable.sizes.items()) or "one value"


def _shorten(value: object) -> str:
    text = " ".join(str(value).split())
    return text if len(text) <= 60 else f"{text[:57]}..."
