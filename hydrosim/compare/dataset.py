"""Comparisons as datasets. For two runs: both series, their difference, and figures. For two sets
of runs: the figures of each channel, and its values in all runs."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping
from math import nan
from pathlib import Path
from types import MappingProxyType
from typing import Any

import numpy as np
import xarray as xr

from hydrosim.compare.comparison import BANDS, ChannelResult, Comparison, ContactComparison
from hydrosim.compare.studies import SIGNIFICANCE_LEVEL
from hydrosim.compare.studies import StudyComparison as Studies
from hydrosim.errors import InputError
from hydrosim.files.text import no_file
from hydrosim.statistics.gumbel import INTERVAL_PROBABILITY

OVER_TIME = {
    "ours": "the run",
    "recorded": "recording, in units and at the point of the run",
    "residual": "ours minus recorded",
}
PER_CHANNEL = {
    "rms": "rms of the residual",
    "relative": "rms of the residual over the std recorded",
    "std": "standard deviation recorded",
    "peak": "largest residual",
    "peak_time": "time of the largest residual [s]",
    "mean": "mean of the residual",
    "drift": "difference of drifts, from the first tenth of the time to the last",
    "correlation": "correlation",
}
OF_FIT = {
    "gain": "in recorded(t) = gain ours(t - lag) + offset",
    "lag": "in the same fit [s]",
    "offset": "of it",
}
PER_BAND = {
    "band_rms": "rms of the residual, without its mean",
    "band_ours": "standard deviation of the run",
    "band_recorded": "standard deviation of the recording",
}
OF_STUDIES = {
    "ours_mean": ("ours", "mean over our runs"),
    "theirs_mean": ("theirs", "mean over their runs"),
    "difference": ("difference", "mean difference, ours minus theirs"),
    "low": ("low", "lower end of its 90 % interval"),
    "high": ("high", "upper end of its 90 % interval"),
    "chance": ("chance", "probability of such a difference by chance"),
    "differs": ("differs", "1 if it counts as different"),
}
NO_TOLERANCES = MappingProxyType[str, float]({})
CONTACT = dict(
    zip(
        ContactComparison._fields,
        ("first contact [s]",) * 2 + ("fraction of time in contact",) * 2,
        strict=True,
    )
)


def to_dataset(
    found: Comparison,
    attributes: Mapping[str, object],
    tolerances: Mapping[str, float] = NO_TOLERANCES,
) -> xr.Dataset:
    """Dataset with dimensions time, channel, band. Units of channels are in the coordinate
    ``units``; ``tolerances`` are by channel."""
    results = list(found.results.values())
    pairs = [result.pair for result in results]
    ours, recorded = (
        np.stack(x, axis=1) for x in zip(*((p.ours, p.recorded) for p in pairs), strict=True)
    )
    data = dict(zip(OVER_TIME, (ours, recorded, ours - recorded), strict=True))
    dataset = xr.Dataset(
        {name: (("time", "channel"), values) for name, values in data.items()}
        | {name: ("channel", [getattr(r.figures, name) for r in results]) for name in PER_CHANNEL}
        | {name: ("channel", [getattr(r.fit, name) for r in results]) for name in OF_FIT}
        | {
            name: (("channel", "band"), [getattr(r.figures, name) for r in results])
            for name in PER_BAND
        }
        | {name: ("channel", [_of_contact(r, name) for r in results]) for name in CONTACT}
        | {
            "verdict": ("channel", [result.verdict for result in results]),
            "tolerance": ("channel", [tolerances.get(name, nan) for name in found.results]),
        },
        coords={
            "time": ("time", found.overlap.time, {"units": "s", "long_name": "time of the run"}),
            "channel": ("channel", list(found.results)),
            "units": ("channel", [pair.unit for pair in pairs]),
            "column": ("channel", [pair.column for pair in pairs]),
            "recorded_in": ("channel", [pair.said for pair in pairs]),
            "band": ("band", list(BANDS)),
        },
    )
    for name, text in (OVER_TIME | PER_CHANNEL | OF_FIT | PER_BAND | CONTACT).items():
        dataset[name].attrs["long_name"] = text
    dataset.tolerance.attrs["long_name"] = "largest permitted rms over std, or rms of a constant"
    dataset.attrs.update(attributes, compared=found.overlap.method, band_edges=found.edges)
    dataset.attrs.update(guessed=int(found.guessed), unused="\n".join(found.unused))
    dataset.attrs["zero_in_both"] = "\n".join(found.zero)
    if found.shift is not None:
        dataset.attrs["shift"] = found.shift
    return dataset


def studies_dataset(found: Studies, attributes: Mapping[str, object]) -> xr.Dataset:
    """Dataset with dimensions channel, run (of ours) and other_run (of theirs). Paired runs have
    the same index."""
    each = found.channels
    values = {
        name: (("channel", dim), np.stack([one.values[k] for one in each]), {"long_name": said})
        for k, (name, dim, said) in enumerate(
            (("ours", "run", "in each of our runs"), ("theirs", "other_run", "in each of theirs"))
        )
    }
    figures = {
        name: ("channel", [_number(getattr(one, field)) for one in each], {"long_name": said})
        for name, (field, said) in OF_STUDIES.items()
    }
    coords = {
        "channel": ("channel", [one.channel for one in each]),
        "units": ("channel", [one.unit for one in each]),
    }
    said = {"compared": found.kind, "paired": int(found.paired)}
    said |= {"codes_apart": " ".join(found.codes), "durations": "\n".join(found.durations)}
    said |= {"interval_probability": INTERVAL_PROBABILITY, "level": SIGNIFICANCE_LEVEL}
    return xr.Dataset(values | figures, coords, {**attributes, **said})


def _number(value: float | bool) -> float | int:
    return int(value) if isinstance(value, bool) else value


def _of_contact(result: ChannelResult, name: str) -> float:
    return float("nan") if result.contact is None else float(getattr(result.contact, name))


# Exact comparison of two results. They are identical if every variable, coordinate and attribute is
# equal to the bit, except those that tell when and where a result was made. This holds on one type
# of processor and one set of versions. NaN equals itself.

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
