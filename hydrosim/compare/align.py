"""A run and a recording at the same times, in one unit, for one point; channels of its columns.

Both are compared where they overlap, at the times of the series with the larger steps. The other
series is interpolated by a cubic spline. Normal forces of fenders use a monotone spline, which does
not ring where contact begins. No spline bridges a gap: a gap is an error.

Mapping between columns of a recording and channels of a run, in a small YAML file.

    time: {column: 1, unit: s, offset: 0 s, shift: false}
    channels:
      position.barge.heave: Heave (m)              # the column's name, or its number from 1 on
      position.barge.pitch: {column: 6, unit: deg, sign: -1}
      position.barge.surge: {column: Xbow, unit: m, offset: 2 m, point: [80, 0, 7.5]}

All keys except ``column`` are optional. A recorded value becomes sign * value [unit] + offset; the
offset is in SI or has a unit. ``point`` is in the body frame: the recorded motion or velocity
belongs to that point, and the run is evaluated there. The offset of the time is added to the
recorded times. With ``shift``, a further time shift is estimated.

Guesses of the channel that a column of a recording holds, from names and units.

A column with the name of a channel is that channel. Other columns match a channel under three
conditions. All words of the name belong to the channel ("barge heave velocity", "Z [m]",
"run1.ROLL_deg", "fender 2"). The words that distinguish the channel (its degree of freedom, its
number) are among them. The unit fits. If two channels or two columns remain, nothing is guessed.
"""

from __future__ import annotations

import json
import re
from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, NamedTuple

import numpy as np
import scipy
from pydantic import AfterValidator, BeforeValidator, PrivateAttr, StrictBool, StrictInt, StrictStr

from hydrosim.dofs import DOFS
from hydrosim.errors import InputError
from hydrosim.files import quantities as of
from hydrosim.files.layers import read_case
from hydrosim.files.messages import validate_document
from hydrosim.files.quantities import SchemaModel
from hydrosim.files.recordings import RecordedColumn, Recording, is_time
from hydrosim.files.series import select
from hydrosim.files.text import Source, name_and_unit, readable_unit, require_finite, require_rising
from hydrosim.files.units import AnyQuantity, Scale, factor, problem, value_text
from hydrosim.files.yaml_nodes import compose_nodes, locate_value, place_text
from hydrosim.results.channels import Channel

if TYPE_CHECKING:
    import xarray as xr


def _unit(text: str) -> str:
    unit = readable_unit(text)
    if unit is None:
        raise problem(value_text(text), "a known unit, such as m, deg, kN or kN*m")
    return unit


def _parse_sign(value: int) -> int:
    if value not in (1, -1):
        raise problem(value_text(value), "1 or -1")
    return value


def _expand_short_form(value: Any) -> Any:
    return {"column": value} if isinstance(value, str | int) else value


Unit = Annotated[StrictStr, AfterValidator(_unit)]
Column = StrictStr | StrictInt


class TimeColumn(SchemaModel):
    """Column of the time, and its conversion to the time of the run."""

    column: Column | None = None
    unit: Unit | None = None
    offset: of.Instant = 0.0
    shift: StrictBool = False


class ChannelPlace(SchemaModel):
    """Column of a channel in a recording, and its conversion to our unit, sign and point."""

    column: Column
    unit: Unit | None = None
    sign: Annotated[StrictInt, AfterValidator(_parse_sign)] = 1
    offset: Annotated[Scale, AnyQuantity("offset", "5 cm")] = Scale(0.0)
    point: of.Point | None = None
    _written: str = PrivateAttr("")

    @property
    def written(self) -> str:
        """File, line and key that gives the column; empty without a file."""
        return self._written


class MappingFile(SchemaModel):
    """Content of a mapping file."""

    time: TimeColumn = TimeColumn()
    channels: Annotated[
        dict[StrictStr, Annotated[ChannelPlace, BeforeValidator(_expand_short_form)]],
        AfterValidator(of.require_entries),
    ]


def read_mapping(mapping: Path | str | Mapping[str, Any]) -> MappingFile:
    """Read a mapping: a YAML file, or its keys. Raises InputError with a line for each problem:
    file and line, key, value found, value expected."""
    if isinstance(mapping, Mapping):
        document = compose_nodes(json.dumps(mapping), "mapping")
        assert document is not None
    else:
        _, document = read_case(Path(mapping))
    read = validate_document(document, MappingFile)
    for name, place in read.channels.items():
        key, mark = locate_value(document, ("channels", name))
        place._written = f"{place_text(mark)}: {key}"
    return read


OUR_WORDS = {  # words of other programs, and our word for each
    "x": "surge",
    "y": "sway",
    "z": "heave",
    "rx": "roll",
    "ry": "pitch",
    "rz": "yaw",
    **dict.fromkeys(("motion", "motions", "displacement", "disp", "pos"), "position"),
    **dict.fromkeys(("eta", "zeta", "surface"), "elevation"),
    **dict.fromkeys(("vel", "speed"), "velocity"),
    "waves": "wave",
    "contact": "fender",
}
# If several variables match, the first of these is chosen: "heave" is a position.
USUAL_VARIABLES = (
    "position",
    "wave_elevation",
    "fender_normal_force",
    "spring_tension",
    "velocity",
)


def guess(recording: Recording, channels: Sequence[Channel]) -> dict[str, ChannelPlace]:
    """Column of each recognised channel; other channels are left out."""
    names, time = {channel.name for channel in channels}, recording.time_column()
    numbered = [
        (number, column)
        for number, column in enumerate(recording.columns, 1)
        if column is not time and not is_time(column.name)
    ]
    same = [(c.name, number) for number, c in numbered if c.name in names]
    free = [channel for channel in channels if channel.name not in dict(same)]
    others = [(number, c) for number, c in numbered if c.name not in names] if free else []
    guesses = [(name, ChannelPlace(column=number)) for name, number in same]
    for number, column in others:
        for name, unit in _readings_of_column(column):
            if channel := _matching_channel(name, unit, free):
                guesses.append((channel, ChannelPlace(column=number, unit=unit)))
                break
    claims = Counter(name for name, _ in guesses)
    return {name: place for name, place in guesses if claims[name] == 1}


def _readings_of_column(column: RecordedColumn) -> Iterator[tuple[str, str | None]]:
    """Possible names and units of a column, the plainest first: as it is, with a unit at its end
    ("ROLL_deg"), and each without the names of its groups ("run1.ROLL_deg")."""
    groups = name_and_unit(column.name)[0].split(".")
    for k in range(len(groups)):
        name = ".".join(groups[k:])
        yield name, column.unit
        stem, _, end = name.rpartition("_")
        if stem and column.unit is None and end and (unit := readable_unit(end)):
            yield stem, unit


def _matching_channel(name: str, unit: str | None, channels: Sequence[Channel]) -> str | None:
    """The single channel that matches a column of this name; None if none or several do."""
    words = _words_of_name(name)
    fits = [
        c.name
        for c in channels
        if _matches_channel(words, c.name) and _is_convertible(unit, c.unit)
    ]
    by_variable = [
        [name for name in fits if name.split(".")[0] == usual] for usual in USUAL_VARIABLES
    ]
    meant = next((named for named in by_variable if named), fits)
    return meant[0] if len(meant) == 1 else None


def _matches_channel(words: frozenset[str], channel: str) -> bool:
    channel_words = _words_of_name(channel)
    tells = {word for word in channel_words if word in DOFS or word.isdigit()}
    spoken = any(not word.isdigit() for word in words)
    return spoken and tells <= words <= channel_words


def _words_of_name(name: str) -> frozenset[str]:
    """Words in a name, in our terms; letters and digits are separated."""
    return frozenset(OUR_WORDS.get(word, word) for word in re.findall(r"[a-z]+|\d+", name.lower()))


def _is_convertible(unit: str | None, ours: str) -> bool:
    try:
        return unit is None or factor(unit, ours) > 0.0
    except ValueError:
        return False


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
    overlap = _find_overlap(run.time.values, stamps, between, recording.source, recording.lines)
    pairs = []
    for channel, place in places.items():
        interpolate = (
            scipy.interpolate.PchipInterpolator
            if channel.startswith(MONOTONE_CHANNEL)
            else scipy.interpolate.CubicSpline
        )
        with _errors_naming_channel(place):
            ours, unit = _channel_of_run(run, channel, place)
            values, recorded_unit, precision = _recorded_channel(
                recording, channel, place, unit, overlap.recorded
            )
            column = recording.column(place.column).name
        pair = ChannelPair(
            channel,
            column,
            unit,
            recorded_unit,
            _resample(overlap.time, run.time.values[overlap.ours], ours[overlap.ours], interpolate),
            _resample(
                overlap.time, stamps[overlap.recorded], values[overlap.recorded], interpolate
            ),
            precision,
        )
        pairs.append(pair)
    return overlap, pairs


@contextmanager
def _errors_naming_channel(place: ChannelPlace) -> Iterator[None]:
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


def _find_overlap(
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
    if a.size == b.size and np.allclose(a, b, rtol=0.0, atol=EQUAL_TIMES_STEPS * _time_step(b)):
        return Overlap(a, run, record, "at the same times")
    if _time_step(b) >= _time_step(a):
        method = "at the recorded times, the run by cubic splines"
        return Overlap(b, _widen_by_one(run, ours.size), record, method)
    method = "at the times of the run, the recording by cubic splines"
    return Overlap(a, run, _widen_by_one(record, stamps.size), method)


def _indices_between(time: np.ndarray, start: float, end: float) -> slice:
    """Indices of the times between two times, except for rounding."""
    slack = EQUAL_TIMES_STEPS * _time_step(time)
    return slice(
        int(np.searchsorted(time, start - slack)), int(np.searchsorted(time, end + slack, "right"))
    )


def _widen_by_one(part: slice, size: int) -> slice:
    return slice(max(part.start - 1, 0), min(part.stop + 1, size))


def _time_step(time: np.ndarray) -> float:
    """Median time step."""
    return float(np.median(np.diff(time)))


def _requested_text(between: tuple[float, float]) -> str:
    start, end = between
    return f" (requested: {start:g} s to {end:g} s)" if np.isfinite(between).any() else ""


def _refuse_gaps(
    source: Source, time: np.ndarray, part: slice, lines: Sequence[int] | None
) -> None:
    steps = np.diff(time[part])
    usual, k = _time_step(time[part]), int(np.argmax(steps))
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
        at, time, rtol=0.0, atol=EQUAL_TIMES_STEPS * _time_step(time)
    )
    # the ends may differ by rounding; there no interpolation would extrapolate
    return values if same else interpolate(time, values)(np.clip(at, time[0], time[-1]))


def _recorded_channel(
    recording: Recording, channel: str, place: ChannelPlace, unit: str, part: slice
) -> tuple[np.ndarray, str, float]:
    """The whole recorded channel in our unit, its unit in the recording, and its precision over the
    compared part."""
    column = recording.column(place.column)
    recorded_unit = column.unit if place.unit is None else place.unit
    try:
        scale = place.sign * (1.0 if recorded_unit is None else factor(recorded_unit, unit))
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
    return scale * column.value + place.offset.value, recorded_unit or "", precision


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
