"""Recordings of decaying roll: the column, its unit, the part that is a decay."""

from __future__ import annotations

from dataclasses import dataclass
from math import inf
from pathlib import Path
from typing import NoReturn

import numpy as np

from hydrosim.documents.text import require_finite, require_rising
from hydrosim.documents.units import factor
from hydrosim.errors import InputError
from hydrosim.recordings.load import read_recording
from hydrosim.recordings.recording import Column, Recording, is_time

ROLL = ("roll", "rx", "phi")
UNEVEN = 0.2  # of a step: largest deviation of times from equal steps
FEWEST = 40  # values
SHORTEST = 2.0  # periods
AFTER = 0.2  # of a period: the fit begins so long before the first crossing of the mean
TAIL = 0.25  # of a record, whose mean over whole periods is that of the motion
SMOOTHED = 0.1  # of a period: a moving mean, so that noise makes no crossings
PADDED = 8  # lengths of a record in its periodogram
COARSEST = 8.0  # samples in a period
MAX_ROLL_RAD = np.pi  # a body that has turned over does not decay
MAX_VALUES = 100_000
"""Values of a decay; the fit of so many takes some seconds."""


@dataclass(frozen=True, eq=False)
class Decay:
    """Roll ``angle`` (n,) [rad] at equal steps of ``time`` (n,) [s] of a decay that is ``called``
    so, with a first guess of its natural ``frequency`` [rad/s] and of its ``mean`` [rad]."""

    called: str
    time: np.ndarray
    angle: np.ndarray
    frequency: float
    mean: float

    @property
    def size(self) -> float:
        """Largest angle from the mean [rad]."""
        return float(np.abs(self.angle - self.mean).max())


def read_decay(
    path: Path,
    column: str = "roll",
    unit: str | None = None,
    start: float | None = None,
    end: float | None = None,
    wanted: str = "",
) -> Decay:
    """Read a decay from ``start`` to ``end`` [s]. Messages begin with ``wanted``, the place that
    refers to the file. Raises InputError if it is no decay."""
    try:
        recording = read_recording(path)
        angle = _column(recording, column)
        stamp = recording.time_column()
        source = recording.source
        require_finite(source, stamp.value, recording.lines, " s")
        require_finite(source, angle.value, recording.lines, f" in {angle.name}")
        require_rising(source, stamp.value, recording.lines)
        _require_seconds(stamp)
        values = _scale(angle, unit) * angle.value
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
) -> Decay:
    """The decay in a series: ``angle`` (n,) [rad] over ``time`` (n,) [s], from ``start`` to ``end``
    [s]. Without a start, it begins a fifth of a period before roll first crosses its mean. Raises
    InputError if the series is no decay."""
    inside = (time >= (-inf if start is None else start)) & (time <= (inf if end is None else end))
    time = time[inside]
    angle = angle[inside]
    if time.size > MAX_VALUES:
        found = f"{time.size:,} values"
        remedy = "take a part of the record, or every tenth of its values"
        _refuse(found, f"at most {MAX_VALUES:,}", remedy)
    if angle.size and (largest := float(np.abs(angle).max())) > MAX_ROLL_RAD:
        found = f"a roll of {np.degrees(largest):.4g} deg"
        _refuse(found, f"at most {np.degrees(MAX_ROLL_RAD):g} deg", "give its unit, deg or rad")
    if time.size < FEWEST:
        _refuse(f"{time.size} values", f"at least {FEWEST}", "take a longer part of the record")
    step = (time[-1] - time[0]) / (time.size - 1)
    if np.abs(time - time[0] - step * np.arange(time.size)).max() > UNEVEN * step:
        expected = "equal steps of time, without gaps"
        _refuse("times with gaps or unequal steps", expected, "resample the record")
    frequency = _frequency(angle, step)
    period = 2.0 * np.pi / frequency
    per_period = max(round(period / step), 1)
    whole = max(int(TAIL * angle.size) // per_period, 1) * per_period
    mean = float(angle[-whole:].mean())
    crossing = _first_crossing(time, _smoothed(angle - mean, int(SMOOTHED * per_period)))
    if crossing is None:
        found = "no crossing of the mean after the largest roll"
        _refuse(found, "a roll that oscillates", "give another part of the record or its column")
    if start is None:
        kept = time >= crossing - AFTER * period
        time = time[kept]
        angle = angle[kept]
    if time[-1] - time[0] < SHORTEST * period or time.size < FEWEST:
        found = f"{time[-1] - time[0]:.4g} s, {(time[-1] - time[0]) / period:.2g} periods"
        _refuse(found, f"at least {SHORTEST:g} periods", "take a longer part of the record")
    if period < COARSEST * step:
        found = f"{period / step:.2g} values in a period"
        _refuse(found, f"at least {COARSEST:g}", "record it in smaller steps")
    return Decay(called, time, angle, frequency, mean)


def _refuse(found: str, expected: str, remedy: str) -> NoReturn:
    raise InputError(f"found {found}; expected {expected}; {remedy}.")


def _frequency(angle: np.ndarray, step: float) -> float:
    """Frequency [rad/s] of the peak of the periodogram from the largest roll on, of at least one
    and a half cycles."""
    x = angle - angle.mean()
    x = x[min(int(np.argmax(np.abs(x))), x.size // 2) :]
    size = PADDED * x.size
    power = np.abs(np.fft.rfft(x - x.mean(), size))
    first = int(1.5 * PADDED)
    return float(2.0 * np.pi * (first + np.argmax(power[first:])) / (size * step))


def _smoothed(x: np.ndarray, count: int) -> np.ndarray:
    """Moving mean of ``count`` values."""
    return np.convolve(x, np.ones(count) / count, "same") if count > 1 else x


def _first_crossing(time: np.ndarray, x: np.ndarray) -> float | None:
    """Time at which ``x`` first changes its sign after its largest value; None if it does not."""
    first = int(np.argmax(np.abs(x)))
    at = first + np.flatnonzero(x[first:-1] * x[first + 1 :] < 0.0)
    return float(time[at[0]]) if at.size else None


def _column(recording: Recording, name: str) -> Column:
    """The column of roll: of that name or number, or the only one that ends so."""
    if name.isdigit():
        return recording.column(int(name))
    wanted = ROLL if name == "roll" else (name.lower(),)
    alike = [
        column
        for column in recording.columns
        if _last(column.name) in wanted and not is_time(column.name)
    ]
    return alike[0] if len(alike) == 1 else recording.column(name)


def _last(name: str) -> str:
    """Last part of a name such as "run1.Roll (deg)", in small letters and without its unit."""
    bare = name.split("(")[0].split("[")[0].strip()
    return bare.replace(" ", ".").replace("_", ".").split(".")[-1].lower()


def _require_seconds(stamp: Column) -> None:
    if stamp.unit not in (None, "", "s"):
        _refuse(f"times in {stamp.unit}", "the time in s", "convert it")


def _scale(angle: Column, unit: str | None) -> float:
    """Factor of the column to rad."""
    said = unit or angle.unit
    if not said:
        found = f"the column {angle.name} without a unit"
        _refuse(found, "roll in deg or rad", 'write it in the heading, "roll [deg]", or give unit')
    try:
        return factor(said, "rad")
    except ValueError:
        _refuse(f"the column {angle.name} in {said}", "an angle in deg or rad", "name its column")
