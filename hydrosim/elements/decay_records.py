"""Recordings of decaying roll: the column, its unit, the part that is a decay."""

from __future__ import annotations

from dataclasses import dataclass
from math import inf, pi
from pathlib import Path
from typing import NoReturn

import numpy as np

from hydrosim.errors import InputError
from hydrosim.files.recordings import RecordedColumn, Recording, is_time, read_recording
from hydrosim.files.text import require_finite, require_rising
from hydrosim.files.units import factor

ROLL_NAMES = ("roll", "rx", "phi")
MAX_STEP_DEVIATION = 0.2  # of a step, of times from equal steps
MIN_VALUES = 40
MIN_PERIODS = 2.0
MIN_VALUES_PER_PERIOD = 8.0
MAX_VALUES_PER_PERIOD = 200.0  # their means lack 0.004 % of the roll
MAX_PERIODS = 200.0
MAX_ROLL_RAD = pi
MIN_ROLL_RAD = 1e-6
LEAD = 0.2  # of a period: the fit begins so long before the first crossing of the mean
SMOOTHED = 0.1  # of a period: a moving mean, so that noise makes no crossings
TAIL = 0.25  # of a record: the mean of its whole periods is about that of the motion
LARGE_ROLL_FRACTION = 0.98  # of the largest roll
PADDING_RATIO = 8  # lengths of a record in its periodogram
MAX_REGROWTH_RATIO = 1.5  # ratio of swings that no decay has
MIN_REGROWN_FRACTION = 0.25  # of the largest swing: swings that are no noise
SMALL_SWING_FRACTION = 0.05  # of the largest swing: swings that waves in the basin hide
SMALL_TEXT = f"the roll is below {100.0 * SMALL_SWING_FRACTION:g} % of the largest"


@dataclass(frozen=True, eq=False)
class DecayRecord:
    """Roll ``angle`` (n,) [rad] at equal steps of ``time`` (n,) [s] of a decay that is ``called``
    so, with its largest deviation ``size`` [rad] from its mean and a first guess of its natural
    ``frequency`` [rad/s]. ``notes`` say what of the record was left out."""

    called: str
    time: np.ndarray
    angle: np.ndarray
    size: float
    frequency: float
    notes: tuple[str, ...] = ()


def read_decay(
    path: Path,
    column: str = "roll",
    unit: str | None = None,
    start: float | None = None,
    end: float | None = None,
    wanted: str = "",
) -> DecayRecord:
    """Read a decay from ``start`` to ``end`` [s]. Messages begin with ``wanted``, the place that
    refers to the file. Raises InputError if it is no decay."""
    try:
        recording = read_recording(path)
        angle = _find_column(recording, column)
        stamp = recording.time_column()
        source = recording.source
        require_finite(source, stamp.value, recording.lines, " s")
        require_finite(source, angle.value, recording.lines, f" in {angle.name}")
        require_rising(source, stamp.value, recording.lines)
        _require_seconds(stamp)
        values = _unit_scale(angle, unit) * angle.value
        return decay_of(stamp.value, values, str(path), start, end)
    except InputError as error:
        text = str(error)
        place = "" if text.startswith(str(path)) else str(path)
        raise InputError(": ".join(part for part in (wanted, place, text) if part)) from None


def decay_of(
    time: np.ndarray,
    angle: np.ndarray,
    called: str = "",
    start: float | None = None,
    end: float | None = None,
) -> DecayRecord:
    """The decay in a series: ``angle`` (n,) [rad] over ``time`` (n,) [s], from ``start`` to ``end``
    [s]. Without a start, it begins a fifth of a period before roll first crosses its mean. Raises
    InputError if the series is no decay."""
    inside = (time >= (-inf if start is None else start)) & (time <= (inf if end is None else end))
    time = time[inside]
    angle = angle[inside]
    _require_series(time, angle)
    step = (time[-1] - time[0]) / (time.size - 1)
    frequency = _roll_frequency(angle, step)
    period = 2.0 * np.pi / frequency
    if period < MIN_VALUES_PER_PERIOD * step:
        text = f"{period / step:.2g} values in a period"
        _refuse_record(text, f"at least {MIN_VALUES_PER_PERIOD:g}", "record it in smaller steps")
    notes = []
    count = int(period / step / MAX_VALUES_PER_PERIOD)
    if count > 1:
        notes.append(f"{time.size:,} values are thinned to means of {count} neighbours")
        time = block_means(time, count)
        angle = block_means(angle, count)
        step *= count
    values = period / step
    first = _find_release(angle, values) if start is None else 0
    last, reason = _find_end(_moving_mean(angle, int(SMOOTHED * values))[first:], values)
    last += first
    if reason:
        notes.append(f"the fit ends at {time[last]:.4g} s, where {reason}")
    duration = (last - 1 - first) * step
    if duration < MIN_PERIODS * period or last - first < MIN_VALUES:
        text = f"{duration:.4g} s, {duration / period:.2g} periods, from {time[first]:.4g} s on"
        _refuse_record(
            text, f"at least {MIN_PERIODS:g} periods", "take a longer part of the record"
        )
    time = time[first:last]
    angle = angle[first:last]
    size = float(np.abs(_detrend(angle)).max())
    return DecayRecord(called, time, angle, size, frequency, tuple(notes))


def _require_series(time: np.ndarray, angle: np.ndarray) -> None:
    if time.size < MIN_VALUES:
        remedy = "take a longer part of the record"
        _refuse_record(f"{time.size} values", f"at least {MIN_VALUES}", remedy)
    step = (time[-1] - time[0]) / (time.size - 1)
    if np.abs(time - time[0] - step * np.arange(time.size)).max() > MAX_STEP_DEVIATION * step:
        expected = "equal steps of time, without gaps"
        worst = np.abs(np.diff(time) - step).argmax()
        text = f"times with gaps or unequal steps, at {time[worst + 1]:g} s"
        _refuse_record(text, expected, "resample the record")
    largest = np.abs(angle).argmax()
    if abs(angle[largest]) > MAX_ROLL_RAD:
        text = f"a roll of {np.degrees(angle[largest]):.3g} deg at {time[largest]:g} s"
        _refuse_record(text, "angles within 180 deg", "check the column and its unit")
    if np.abs(angle - angle[0]).max() < MIN_ROLL_RAD:
        _refuse_record("a roll that does not move", "a roll that oscillates", "check the column")


def _refuse_record(text: str, expected: str, remedy: str) -> NoReturn:
    raise InputError(f"found {text}; expected {expected}; {remedy}.")


def block_means(values: np.ndarray, count: int) -> np.ndarray:
    """Means (n / count, ...) of ``count`` neighbours of ``values`` (n, ...)."""
    whole = len(values) // count
    return values[: whole * count].reshape(whole, count, *values.shape[1:]).mean(axis=1)


def _detrend(x: np.ndarray) -> np.ndarray:
    """``x`` (n,) less the parabola of its smallest squares."""
    columns = np.polynomial.legendre.legvander(np.linspace(-1.0, 1.0, x.size), 2)
    return np.asarray(x - columns @ np.linalg.lstsq(columns, x, rcond=None)[0])


def _first_large(x: np.ndarray) -> int:
    """First index at which ``x`` is about as large as anywhere."""
    size = np.abs(x)
    return int(np.argmax(size >= LARGE_ROLL_FRACTION * size.max()))


def _roll_frequency(angle: np.ndarray, step: float) -> float:
    """Frequency [rad/s] of the peak of the periodogram from the largest roll on, of at least one
    and a half cycles."""
    x = angle[min(_first_large(angle - angle.mean()), angle.size // 2) :]
    size = PADDING_RATIO * x.size
    power = np.abs(np.fft.rfft(x - x.mean(), size))
    first = int(1.5 * PADDING_RATIO)
    return float(2.0 * np.pi * (first + np.argmax(power[first:])) / (size * step))


def _moving_mean(x: np.ndarray, count: int) -> np.ndarray:
    """Moving mean of ``count`` values."""
    return np.convolve(x, np.ones(count) / count, "same") if count > 1 else x


def _find_release(angle: np.ndarray, period: float) -> int:
    """Index a fifth of a ``period`` [values] before the roll first crosses its mean after its
    largest value."""
    whole = int(max(TAIL * angle.size // period, 1.0) * period)
    swing = _moving_mean(angle - angle[-whole:].mean(), int(SMOOTHED * period))
    largest = _first_large(swing)
    crossings = np.flatnonzero(swing[largest:-1] * swing[largest + 1 :] < 0.0)
    if not crossings.size:
        text = "no crossing of the mean after the largest roll"
        _refuse_record(
            text, "a roll that oscillates", "give another part of the record or its column"
        )
    return max(largest + int(crossings[0]) - int(LEAD * period), 0)


def _find_end(swing: np.ndarray, period: float) -> tuple[int, str]:
    """Index at which a decay ends, and why: the number of values and no reason, or the half period
    after which the swings grow as no decay does, or are small."""
    edges = np.arange(0.0, max(swing.size - period, 1.0), 0.5 * period).astype(int)
    sizes = np.array([np.ptp(swing[k : k + int(period)]) for k in edges])
    shares = sizes / sizes.max()
    grown = (sizes > MAX_REGROWTH_RATIO * np.minimum.accumulate(sizes)) & (
        shares > MIN_REGROWN_FRACTION
    )
    ends = [
        (edges[np.argmax(grown)] if grown.any() else swing.size, "the roll grows again"),
        (
            edges[np.argmax(shares < SMALL_SWING_FRACTION)]
            if shares.min() < SMALL_SWING_FRACTION
            else swing.size,
            SMALL_TEXT,
        ),
        (int(MAX_PERIODS * period), f"{MAX_PERIODS:g} periods are over"),
    ]
    last, reason = min(ends)
    return (int(last), reason) if last < swing.size else (swing.size, "")


def _find_column(recording: Recording, name: str) -> RecordedColumn:
    """The column of roll: of that name or number, the only one that ends so, or the only position
    among these."""
    if name.isdigit():
        return recording.column(int(name))
    wanted = ROLL_NAMES if name == "roll" else (name.lower(),)
    alike = [
        column
        for column in recording.columns
        if _last_word(column.name) in wanted and not is_time(column.name)
    ]
    alike = [column for column in alike if column.name.startswith("position.")] or alike
    if len(alike) > 1 and name not in [column.name for column in recording.columns]:
        recording.source.unknown("single column", name, [column.name for column in alike])
    return alike[0] if len(alike) == 1 else recording.column(name)


def _last_word(name: str) -> str:
    """Last part of a name such as "run1.Roll (deg)", in small letters and without its unit."""
    bare = name.split("(")[0].split("[")[0].strip()
    return bare.replace(" ", ".").replace("_", ".").split(".")[-1].lower()


def _require_seconds(stamp: RecordedColumn) -> None:
    if stamp.unit not in (None, "", "s"):
        _refuse_record(f"times in {stamp.unit}", "the time in s", "convert it")


def _unit_scale(angle: RecordedColumn, unit: str | None) -> float:
    """Factor of the column to rad."""
    unit_text = unit or angle.unit
    if not unit_text:
        text = f"the column {angle.name} without a unit"
        _refuse_record(
            text, "roll in deg or rad", 'write it in the heading, "roll [deg]", or give unit'
        )
    try:
        return factor(unit_text, "rad")
    except ValueError:
        _refuse_record(
            f"the column {angle.name} in {unit_text}", "an angle in deg or rad", "name its column"
        )
