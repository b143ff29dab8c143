"""A run and a recording at the same times, in the same units, for the same point.

Both are compared where they overlap, at the times of the series with the larger steps. The other
series is interpolated by a cubic spline. Normal forces of fenders use a monotone spline, which does
not ring where contact begins. No spline bridges a gap: a gap is an error.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import scipy
import xarray as xr

from hydrosim.compare.mapping import ChannelPlace, TimeColumn
from hydrosim.documents.series import select
from hydrosim.documents.text import Source, require_finite, require_rising
from hydrosim.documents.units import factor, value_text
from hydrosim.dofs import DOFS
from hydrosim.errors import InputError
from hydrosim.recordings import Recording

MIN_COMMON_TIMES = 10  # common times
MAX_GAP_STEPS = 10.0  # usual steps
EQUAL_TIMES_STEPS = 1e-6  # of a step: times that differ by less are equal
MONOTONE_CHANNEL = "fender_normal_force"
POINT_QUANTITIES = ("position", "velocity")  # quantities of a point
MIN_COUNTABLE_SIZE = 1e-250  # of a size: smaller values have no countable digits
EXACT_DIGITS = 16  # digits: more digits look like rounding
Interpolate = Callable[[np.ndarray, np.ndarray], Any]


class ChannelPair(NamedTuple):
    """A channel of a run and its recording: ``ours`` and ``recorded`` (n,) in ``unit``. ``said`` is
    the unit in the recording; it is "" if there is none, and ours is assumed. ``precision`` is half
    a unit of the last recorded digit."""

    channel: str
    column: str
    unit: str
    said: str
    ours: np.ndarray
    recorded: np.ndarray
    precision: float


@dataclass(frozen=True)
class Overlap:
    """Common ``time`` (n,) of a run and a recording, the parts of both near that time, and the
    interpolation ``method``."""

    time: np.ndarray
    ours: slice
    recorded: slice
    method: str


def align(
    run: xr.Dataset,
    recording: Recording,
    places: Mapping[str, ChannelPlace],
    time: TimeColumn,
    between: tuple[float, float],
    shift: float = 0.0,
) -> tuple[Overlap, list[ChannelPair]]:
    """Pairs of all channels in ``places`` at their common times, ``between`` two times of the run
    [s]. ``shift`` [s] is added to the recorded times. Raises InputError with the file and line of
    the fault."""
    stamps = recorded_time(recording, time) + shift
    overlap = _overlap(run.time.values, stamps, between, recording.source, recording.lines)
    pairs = []
    for channel, place in places.items():
        interpolate = (
            scipy.interpolate.PchipInterpolator
            if channel.startswith(MONOTONE_CHANNEL)
            else scipy.interpolate.CubicSpline
        )
        with _naming(place):
            ours, unit = _channel_of_run(run, channel, place)
            values, said, precision = _recorded_channel(
                recording, channel, place, unit, overlap.recorded
            )
            column = recording.column(place.column).name
        pair = ChannelPair(
            channel,
            column,
            unit,
            said,
            _resample(overlap.time, run.time.values[overlap.ours], ours[overlap.ours], interpolate),
            _resample(
                overlap.time, stamps[overlap.recorded], values[overlap.recorded], interpolate
            ),
            precision,
        )
        pairs.append(pair)
    return overlap, pairs


@contextmanager
def _naming(place: ChannelPlace) -> Iterator[None]:
    """Put the line of a mapping before the message of an InputError about its channel."""
    try:
        yield
    except InputError as error:
        raise InputError(f"{place.written}: {error}" if place.written else str(error)) from error


def recorded_time(recording: Recording, time: TimeColumn) -> np.ndarray:
    """Recorded times [s]. Raises InputError with the place at which they do not increase."""
    named = recording.time_column() if time.column is None else recording.column(time.column)
    unit = time.unit or named.unit or "s"
    try:
        stamps = named.value * factor(unit, "s") + time.offset
    except ValueError as error:
        remedy = "give it in a mapping, time: {unit: s}"
        recording.source.wrong(f"found {error}, in {value_text(named.name)}; expected s; {remedy}")
    require_finite(recording.source, stamps, recording.lines, f" in {value_text(named.name)}")
    require_rising(recording.source, stamps, recording.lines)
    return stamps


def _overlap(
    ours: np.ndarray,
    stamps: np.ndarray,
    between: tuple[float, float],
    source: Source,
    lines: Sequence[int] | None,
) -> Overlap:
    start = max(ours[0], stamps[0], between[0])
    end = min(ours[-1], stamps[-1], between[1])
    run, record = _indices_between(ours, start, end), _indices_between(stamps, start, end)
    if min(run.stop - run.start, record.stop - record.start) < MIN_COMMON_TIMES:
        meet = min(ours[-1], stamps[-1]) > max(ours[0], stamps[0])
        remedy = (
            "choose others with --from and --to"
            if meet and _requested_text(between)
            else "give the offset of recorded times in a mapping, time: {offset: 100 s}"
        )
        raise InputError(
            f"{source.file}: found recorded times from {stamps[0]:g} s to {stamps[-1]:g} s,"
            f" and a run from {ours[0]:g} s to {ours[-1]:g} s{_requested_text(between)}; expected"
            f" an overlap with at least {MIN_COMMON_TIMES} times of each; {remedy}"
        )
    _refuse_gaps(source, stamps, record, lines)
    a, b = ours[run], stamps[record]
    if a.size == b.size and np.allclose(a, b, rtol=0.0, atol=EQUAL_TIMES_STEPS * _step(b)):
        return Overlap(a, run, record, "at the same times")
    if _step(b) >= _step(a):
        method = "at the recorded times, the run by cubic splines"
        return Overlap(b, _widen_by_one(run, ours.size), record, method)
    method = "at the times of the run, the recording by cubic splines"
    return Overlap(a, run, _widen_by_one(record, stamps.size), method)


def _indices_between(time: np.ndarray, start: float, end: float) -> slice:
    """Indices of the times between two times, except for rounding."""
    slack = EQUAL_TIMES_STEPS * _step(time)
    return slice(
        int(np.searchsorted(time, start - slack)), int(np.searchsorted(time, end + slack, "right"))
    )


def _widen_by_one(part: slice, size: int) -> slice:
    return slice(max(part.start - 1, 0), min(part.stop + 1, size))


def _step(time: np.ndarray) -> float:
    """Median time step."""
    return float(np.median(np.diff(time)))


def _requested_text(between: tuple[float, float]) -> str:
    start, end = between
    return f" (requested: {start:g} s to {end:g} s)" if np.isfinite(between).any() else ""


def _refuse_gaps(
    source: Source, time: np.ndarray, part: slice, lines: Sequence[int] | None
) -> None:
    steps = np.diff(time[part])
    usual, k = _step(time[part]), int(np.argmax(steps))
    if steps[k] > MAX_GAP_STEPS * usual:
        at = part.start + k + 1
        where = "" if lines else f" before record {at + 1}"
        source.wrong(
            f"found no recorded times between {time[at - 1]:g} s and {time[at]:g} s{where};"
            f" expected times about {usual:g} s apart; fill the gap, or compare one side of it"
            " (--from, --to)",
            lines[at] if lines else None,
        )


def _resample(
    at: np.ndarray, time: np.ndarray, values: np.ndarray, interpolate: Interpolate
) -> np.ndarray:
    same = at.size == time.size and np.allclose(
        at, time, rtol=0.0, atol=EQUAL_TIMES_STEPS * _step(time)
    )
    # the ends may differ by rounding; there no interpolation would extrapolate
    return values if same else interpolate(time, values)(np.clip(at, time[0], time[-1]))


def _recorded_channel(
    recording: Recording, channel: str, place: ChannelPlace, unit: str, part: slice
) -> tuple[np.ndarray, str, float]:
    """The whole recorded channel in our unit, its unit in the recording, and its precision over the
    compared part."""
    column = recording.column(place.column)
    said = column.unit if place.unit is None else place.unit
    try:
        scale = place.sign * (1.0 if said is None else factor(said, unit))
        if place.offset.unit is not None:
            factor(place.offset.unit, unit)  # units of different kinds: ValueError
    except ValueError as error:
        remedy = f"give the column's unit in a mapping, such as {{unit: {unit}}}"
        recording.source.wrong(
            f"{error}; expected a unit of the kind of {unit}, for {channel} from the column"
            f" {value_text(column.name)}; {remedy}"
        )
    compared = np.zeros(column.value.size)  # missing values outside the compared part do no harm
    compared[part] = column.value[part]
    require_finite(recording.source, compared, recording.lines, f" in {value_text(column.name)}")
    precision = abs(scale) * precision_of(column.value[part])
    return scale * column.value + place.offset.value, said or "", precision


def precision_of(values: np.ndarray) -> float:
    """Half a unit of the last digit that the values were printed with. If they were not printed, or
    are too few to tell, their rounding error."""
    largest, eps = float(np.abs(values).max()), float(np.finfo(float).eps)
    if np.unique(values).size < MIN_COMMON_TIMES:
        return largest * eps / 2.0
    sizes = np.maximum(np.where(values == 0.0, 1.0, np.abs(values)), MIN_COUNTABLE_SIZE)
    exponent = np.floor(np.log10(sizes))
    for digits in range(1, EXACT_DIGITS):
        unit = 10.0 ** (exponent - digits + 1)
        if np.allclose(np.round(values / unit) * unit, values, rtol=4e-16, atol=0.0):
            return float(0.5 * unit.max())
    single = np.array_equal(values.astype(np.float32), values)
    return largest * (float(np.finfo(np.float32).eps) if single else eps) / 2.0


def _channel_of_run(run: xr.Dataset, channel: str, place: ChannelPlace) -> tuple[np.ndarray, str]:
    """The channel of a run over all its time, at the recorded point, and its unit."""
    source = Source(Path(run.encoding.get("source", "run")), f"channels.{channel}")
    values, unit = select(source, run, channel)
    if not unit:
        source.wrong("found no unit; expected an attribute units or dof_units, as runs have")
    if place.point is not None:
        variable, *labels = channel.split(".")
        if variable not in POINT_QUANTITIES:
            expected = " or ".join(POINT_QUANTITIES)
            source.wrong(f"found a point for {variable}; expected one for {expected} only")
        (dof,) = (label for label in labels if label in DOFS)  # or there would be no values
        body = next((label for label in labels if label != dof), str(run.body.values[0]))
        moved = _motion_of_point(run.sel(body=body), np.array(place.point), variable)
        values = values + moved[:, DOFS.index(dof)]
    require_finite(source, values)
    return values, unit


def _motion_of_point(body: xr.Dataset, point: np.ndarray, variable: str) -> np.ndarray:
    """Motion of a point of a body (nt, 6) minus that of its centre of gravity: (R - 1) r for the
    position, omega x R r for the velocity."""
    angles = body.position.values[:, 3:]
    arm = scipy.spatial.transform.Rotation.from_euler("ZYX", angles[:, ::-1]).apply(point)
    more = np.zeros((len(arm), 6))
    turning = body.velocity.values[:, 3:]
    more[:, :3] = arm - point if variable == "position" else np.cross(turning, arm)
    return more
