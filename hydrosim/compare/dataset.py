"""Comparisons as datasets, and the exact comparison of two results.

For two runs: both series, their difference, and figures. For two sets of runs: the figures of each
channel, and its values in all runs. Results are identical if every variable, coordinate and
attribute is equal to the bit, except those that tell when and where a result was made. This holds
on one type of processor and one set of versions. NaN equals itself."""

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
from hydrosim.files.text import unreadable_reason
from hydrosim.results.dataset import KIND, ResultKind, load_result
from hydrosim.results.variables import OF_CHANNEL, describe_coordinates, describe_values
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
    "peak_time": "time of the largest residual",
    "mean": "mean of the residual",
    "drift": "difference of drifts, from the first tenth of the time to the last",
    "correlation": "correlation",
}
OF_FIT = {
    "gain": "gain in recorded(t) = gain ours(t - lag) + offset",
    "lag": "lag in the same fit",
    "offset": "offset in the same fit",
}
PER_BAND = {
    "band_rms": "rms of the residual, without its mean",
    "band_ours": "standard deviation of the run",
    "band_recorded": "standard deviation of the recording",
}
OF_STUDIES = {
    "ours_mean": "mean over our runs",
    "theirs_mean": "mean over their runs",
    "difference": "mean difference, ours minus theirs",
    "low": "lower end of its 90 % interval",
    "high": "upper end of its 90 % interval",
    "chance": "probability of such a difference by chance",
    "differs": "1 if it counts as different",
}
CONTACT = dict(
    zip(
        ContactComparison._fields,
        ("first contact",) * 2 + ("fraction of time in contact",) * 2,
        strict=True,
    )
)
OTHER_UNITS = {
    **dict.fromkeys(("relative", "correlation", "gain", "chance", "differs"), "1"),
    **dict.fromkeys(("peak_time", "lag"), "s"),
    **dict(zip(CONTACT, ("s", "s", "1", "1"), strict=True)),
}
"""Units of figures that have not that of their channel."""
NO_TOLERANCES = MappingProxyType[str, float]({})
TOLERANCE_TEXT = "largest permitted rms over std, or rms of a constant"


def to_dataset(
    comparison: Comparison,
    attributes: Mapping[str, object],
    tolerances: Mapping[str, float] = NO_TOLERANCES,
) -> xr.Dataset:
    """Dataset with dimensions time, channel, band. Units of channels are in the coordinate
    ``units``; ``tolerances`` are by channel."""
    results = list(comparison.results.values())
    pairs = [result.pair for result in results]
    ours, recorded = (
        np.stack(x, axis=1) for x in zip(*((p.ours, p.recorded) for p in pairs), strict=True)
    )
    series = zip(OVER_TIME, (ours, recorded, ours - recorded), strict=True)
    data = {name: _describe(name, ("time", "channel"), x, OVER_TIME[name]) for name, x in series}
    figures, fits = ([getattr(r, part) for r in results] for part in ("figures", "fit"))
    tables = (
        ("channel", PER_CHANNEL, figures),
        ("channel", OF_FIT, fits),
        (("channel", "band"), PER_BAND, figures),
    )
    for dims, texts, owners in tables:
        for name, text in texts.items():
            data[name] = _describe(name, dims, [getattr(of, name) for of in owners], text)
    for name, text in CONTACT.items():
        data[name] = _describe(name, "channel", [_contact_figure(r, name) for r in results], text)
    permitted = [tolerances.get(name, nan) for name in comparison.results]
    data["verdict"] = describe_values("channel", [r.verdict for r in results], "verdict")
    data["tolerance"] = describe_values("channel", permitted, TOLERANCE_TEXT, OF_CHANNEL)
    dataset = xr.Dataset(
        data,
        coords={
            "time": describe_values("time", comparison.overlap.time, "time of the run", "s"),
            "channel": ("channel", list(comparison.results)),
            "units": ("channel", [pair.unit for pair in pairs]),
            "column": ("channel", [pair.column for pair in pairs]),
            "recorded_in": ("channel", [pair.said for pair in pairs]),
            "band": ("band", list(BANDS)),
        },
    )
    dataset.attrs.update(
        attributes,
        kind=ResultKind.COMPARISON.value,
        compared=comparison.overlap.method,
        band_edges=comparison.edges,
    )
    dataset.attrs.update(guessed=int(comparison.guessed), unused="\n".join(comparison.unused))
    dataset.attrs["zero_in_both"] = "\n".join(comparison.zero)
    if comparison.shift is not None:
        dataset.attrs["shift"] = comparison.shift
    return describe_coordinates(dataset)


def studies_dataset(comparison: Studies, attributes: Mapping[str, object]) -> xr.Dataset:
    """Dataset with dimensions channel, run (of ours) and other_run (of theirs). Paired runs have
    the same index."""
    channels = comparison.channels
    values = {
        name: describe_values(
            ("channel", dim),
            np.stack([channel.values[k] for channel in channels]),
            meaning,
            OF_CHANNEL,
        )
        for k, (name, dim, meaning) in enumerate(
            (("ours", "run", "in each of our runs"), ("theirs", "other_run", "in each of theirs"))
        )
    }
    figures = {  # + gives numbers for truth values
        name: _describe(
            name,
            "channel",
            [+getattr(channel, name.removesuffix("_mean")) for channel in channels],
            meaning,
        )
        for name, meaning in OF_STUDIES.items()
    }
    coords = {
        "channel": ("channel", [channel.channel for channel in channels]),
        "units": ("channel", [channel.unit for channel in channels]),
    }
    counts = {"compared": comparison.kind, "paired": int(comparison.paired)}
    counts |= {
        "codes_apart": " ".join(comparison.codes),
        "durations": "\n".join(comparison.durations),
    }
    counts |= {"interval_probability": INTERVAL_PROBABILITY, "level": SIGNIFICANCE_LEVEL}
    kind = {KIND: ResultKind.SET_COMPARISON.value}
    dataset = xr.Dataset(values | figures, coords, {**kind, **attributes, **counts})
    return describe_coordinates(dataset)


def _describe(name: str, dims: str | tuple[str, ...], values: Any, text: str) -> Any:
    return describe_values(dims, values, text, OTHER_UNITS.get(name, OF_CHANNEL))


def _contact_figure(result: ChannelResult, name: str) -> float:
    return float("nan") if result.contact is None else float(getattr(result.contact, name))


# Exact comparison of two results.

OF_MAKING = frozenset({"wall_time", "history", "settings", "date_created", "host"})
"""Variables and attributes that differ between two makings of one result."""


def differences(first: xr.Dataset, second: xr.Dataset, ignored: Collection[str] = ()) -> list[str]:
    """All differences between two results, one per line; empty if they are identical.

    `OF_MAKING` and the names in ``ignored`` are skipped, variables and attributes alike.
    """
    left_out = {*OF_MAKING, *ignored}
    return [
        *_attribute_differences("", first.attrs, second.attrs, left_out),
        *_variable_differences(first, second, left_out),
    ]


def read_result(path: Path) -> xr.Dataset:
    """All variables of a netCDF file, in memory. Raises InputError if it cannot be read."""
    if reason := unreadable_reason(path):
        raise InputError(f"{path}: {reason}; expected netCDF.")
    try:
        return load_result(path, decode_times=False)
    except (OSError, ValueError, RuntimeError) as error:
        raise InputError(f"{path}: cannot be read as netCDF ({error}); is it complete?") from None


def _variable_differences(
    first: xr.Dataset, second: xr.Dataset, left_out: Collection[str]
) -> Iterator[str]:
    for name in sorted({*map(str, first.variables), *map(str, second.variables)} - {*left_out}):
        if name in first.variables and name in second.variables:
            here = first.variables[name]
            there = second.variables[name]
            yield from _value_differences(name, here, there)
            yield from _attribute_differences(f"{name}: ", here.attrs, there.attrs, left_out)
        else:
            yield f"{name}: {_only_in(name in first.variables)}"


def _value_differences(name: str, first: xr.Variable, second: xr.Variable) -> Iterator[str]:
    if dict(first.sizes) != dict(second.sizes) or first.dims != second.dims:
        yield f"{name}: {_sizes_text(first)} and {_sizes_text(second)}"
        return
    a = _comparable_values(first.values)
    b = _comparable_values(second.values)
    if a.dtype != b.dtype:
        yield f"{name}: types {a.dtype} and {b.dtype}"
    elif (unequal := _unequal_values(a, b)).any():
        k = int(np.argmax(unequal))
        count = f"{np.count_nonzero(unequal)} of {unequal.size} values differ"
        at = np.unravel_index(k, first.shape)
        place = ", ".join(f"{dim} {i}" for dim, i in zip(first.dims, at, strict=True))
        place_text = f"first {a.ravel()[k]} and {b.ravel()[k]}" + (f" at {place}" if place else "")
        yield f"{name}: {count}, {place_text}"


def _attribute_differences(
    of: str, first: Mapping[Any, Any], second: Mapping[Any, Any], left_out: Collection[str]
) -> Iterator[str]:
    for name in sorted({*first, *second} - {*left_out}):
        if (name in first) != (name in second):
            yield f"{of}attribute {name}: {_only_in(name in first)}"
            continue
        a, b = (_comparable_values(np.ravel(side[name])) for side in (first, second))
        if a.dtype != b.dtype or a.shape != b.shape or _unequal_values(a, b).any():
            yield f"{of}attribute {name}: {_shorten(first[name])} and {_shorten(second[name])}"


def _comparable_values(values: Any) -> np.ndarray:
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


def _sizes_text(variable: xr.Variable) -> str:
    return ", ".join(f"{dim} {n}" for dim, n in variable.sizes.items()) or "one value"


def _shorten(value: object) -> str:
    text = " ".join(str(value).split())
    return text if len(text) <= 60 else f"{text[:57]}..."
