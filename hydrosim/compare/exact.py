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


def differences(one: xr.Dataset, other: xr.Dataset, ignored: Collection[str] = ()) -> list[str]:
    """All differences between two results, one per line; empty if they are identical.

    `OF_MAKING` and the names in ``ignored`` are skipped, variables and attributes alike.
    """
    left_out = {*OF_MAKING, *ignored}
    return [*_attributes("", one.attrs, other.attrs, left_out), *_variables(one, other, left_out)]


def read_result(path: Path) -> xr.Dataset:
    """All variables of a netCDF file, in memory. Raises InputError if it cannot be read."""
    if reason := no_file(path):
        raise InputError(f"{path}: {reason}; expected netCDF.")
    try:
        return xr.load_dataset(path, engine="netcdf4", decode_times=False)
    except (OSError, ValueError, RuntimeError) as error:
        raise InputError(f"{path}: cannot be read as netCDF ({error}); is it complete?") from None


def _variables(one: xr.Dataset, other: xr.Dataset, left_out: Collection[str]) -> Iterator[str]:
    for name in sorted({*map(str, one.variables), *map(str, other.variables)} - {*left_out}):
        if name in one.variables and name in other.variables:
            here = one.variables[name]
            there = other.variables[name]
            yield from _values(name, here, there)
            yield from _attributes(f"{name}: ", here.attrs, there.attrs, left_out)
        else:
            yield f"{name}: {_only_in(name in one.variables)}"


def _values(name: str, one: xr.Variable, other: xr.Variable) -> Iterator[str]:
    if dict(one.sizes) != dict(other.sizes) or one.dims != other.dims:
        yield f"{name}: {_sizes(one)} and {_sizes(other)}"
        return
    a = _as_comparable(one.values)
    b = _as_comparable(other.values)
    if a.dtype != b.dtype:
        yield f"{name}: types {a.dtype} and {b.dtype}"
    elif (unequal := _unequal_values(a, b)).any():
        k = int(np.argmax(unequal))
        count = f"{np.count_nonzero(unequal)} of {unequal.size} values differ"
        at = np.unravel_index(k, one.shape)
        place = ", ".join(f"{dim} {i}" for dim, i in zip(one.dims, at, strict=True))
        first = f"first {a.ravel()[k]} and {b.ravel()[k]}" + (f" at {place}" if place else "")
        yield f"{name}: {count}, {first}"


def _attributes(
    of: str, one: Mapping[Any, Any], other: Mapping[Any, Any], left_out: Collection[str]
) -> Iterator[str]:
    for name in sorted({*one, *other} - {*left_out}):
        if (name in one) != (name in other):
            yield f"{of}attribute {name}: {_only_in(name in one)}"
            continue
        a, b = (_as_comparable(np.ravel(side[name])) for side in (one, other))
        if a.dtype != b.dtype or a.shape != b.shape or _unequal_values(a, b).any():
            yield f"{of}attribute {name}: {_shorten(one[name])} and {_shorten(other[name])}"


def _as_comparable(values: Any) -> np.ndarray:
    """Array in which texts of any length have one type."""
    array = np.asarray(values)
    return array.astype(object) if array.dtype.kind in "US" else array


def _unequal_values(one: np.ndarray, other: np.ndarray) -> np.ndarray:
    """Unequal values of two arrays of one type and shape, flattened."""
    if one.dtype.kind == "O":
        return np.asarray(one.ravel() != other.ravel(), dtype=bool)
    bits = f"V{one.dtype.itemsize}"
    a, b = (np.ascontiguousarray(array).ravel() for array in (one, other))
    differ = np.asarray(a.view(bits) != b.view(bits))
    return differ & ~(np.isnan(a) & np.isnan(b)) if one.dtype.kind == "f" else differ


def _only_in(in_first: bool) -> str:
    return f"only in the {'first' if in_first else 'second'}"


def _sizes(variable: xr.Variable) -> str:
    return ", ".join(f"{dim} {n}" for dim, n in variable.sizes.items()) or "one value"


def _shorten(value: object) -> str:
    text = " ".join(str(value).split())
    return text if len(text) <= 60 else f"{text[:57]}..."
