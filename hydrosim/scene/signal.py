"""Signals over time: a table, a record, a path or a sine, and their forms in a file.

`hydrosim.elements.signal` evaluates them.
"""

from __future__ import annotations

import os
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Annotated, Any, Generic

import numpy as np
import pydantic

from hydrosim.errors import InputError
from hydrosim.files import quantities as of
from hydrosim.files.key_rules import value_for_each_time
from hydrosim.files.quantities import SchemaModel, T
from hydrosim.files.schema_class import EqualByValue, SchemaClass, schema_class
from hydrosim.files.series import Series, read_series
from hydrosim.files.text import Source, require_usual
from hydrosim.files.units import AnyQuantity, Scale, factor, is_same_dimension, problem, value_text


@dataclass(frozen=True, eq=False)
class Samples(EqualByValue):
    """``value`` (n,) at the rising ``time`` (n,) [s]; lists become arrays. Raises InputError where
    their sizes differ, times do not rise, or a number is not finite."""

    time: np.ndarray
    value: np.ndarray

    def __post_init__(self) -> None:
        for name in ("time", "value"):
            object.__setattr__(self, name, np.atleast_1d(np.asarray(getattr(self, name), float)))
        if self.time.shape != self.value.shape or self.time.ndim != 1:
            shapes_text = f"found times {self.time.shape} and values {self.value.shape}"
            raise InputError(
                f"{type(self).__name__}: {shapes_text}; expected a value for each time."
            )
        finite = np.isfinite(self.time).all() and np.isfinite(self.value).all()
        if not finite or (np.diff(self.time) <= 0.0).any():
            found_text = "times that do not rise" if finite else "what is no number"
            raise InputError(
                f"{type(self).__name__}: found {found_text}; expected times that rise, and numbers."
            )


class Table(Samples):
    """Straight lines through the values."""


class Recorded(Samples):
    """A smooth curve through the values, four or more."""

    def largest_miss(self) -> float:
        """Largest error, at the omitted values, of the spline through every other value. For a
        smooth record the spline through all values has a sixteenth of this error."""
        time, value = self.time, self.value
        if time.size < 9:
            return float(np.ptp(value))
        return float(np.abs(spline_through(time[::2], value[::2])(time[1:-1]) - value[1:-1]).max())


def spline_through(time: np.ndarray, value: np.ndarray) -> Any:
    """The cubic spline through the values, with two continuous derivatives."""
    from scipy.interpolate import CubicSpline  # slow to load, and few scenes have a record

    return CubicSpline(time, value)


class SmoothTable(Samples):
    """A curve with continuous rate and without overshoot through the values, two or more."""


@dataclass(frozen=True)
class Harmonic:
    """mean + amplitude sin(2 pi t / period + phase); ``period`` [s], ``phase`` [rad]."""

    amplitude: float
    period: float
    mean: float = 0.0
    phase: float = 0.0


Signal = Table | Recorded | SmoothTable | Harmonic


def constant(value: float) -> Table:
    """The constant signal ``value``."""
    return Table(np.zeros(1), np.array([value]))


def largest_corner(table: Table) -> float:
    """Largest jump of the rate of a table [1/s times its unit]; it is constant outside."""
    slopes = np.diff(table.value) / np.diff(table.time)
    return float(np.abs(np.diff(slopes, prepend=0.0, append=0.0)).max())


def scale_signal(signal: Signal, factor: float) -> Signal:
    """The signal times ``factor``."""
    if isinstance(signal, Harmonic):
        amplitude, mean = factor * signal.amplitude, factor * signal.mean
        return replace(signal, amplitude=amplitude, mean=mean)
    return replace(signal, value=factor * signal.value)


def smallest_value(signal: Signal) -> float:
    """Smallest value among the points of a signal."""
    if isinstance(signal, Harmonic):
        return signal.mean - abs(signal.amplitude)
    return float(np.min(signal.value))


def require_length(length: Any) -> None:
    """Refuses a signal of a length that is not always above 0 [m]."""
    if isinstance(length, Signal) and not (shortest := smallest_value(length)) > 0.0:
        raise problem(f"a length that falls to {shortest:g} m", "one that is always above 0")


# Forms of signals in a file.


class TableOverTime(SchemaModel, Generic[T]):
    """Straight lines between the forces at some times, constant outside."""

    key_rules = (value_for_each_time("force"),)

    time: of.Times
    """Times that rise."""
    force: Annotated[tuple[T, ...], pydantic.AfterValidator(of.require_entries)]
    """Force at each time, with straight lines between."""


@schema_class
class RecordedColumns(SchemaClass):
    """Columns of a file, added together and multiplied by a factor; the file is the run of ``case``
    if that is given."""

    file: pydantic.StrictStr
    """Text file or result file with the series, relative to the case file. Example:
    lift.csv."""
    case: pydantic.StrictStr | None = None
    """Case file whose run is the file. Commands run it first. Example: lift.yaml."""
    column: Annotated[
        tuple[pydantic.StrictStr | pydantic.StrictInt, ...],
        of.one_or_more(pydantic.StrictStr | pydantic.StrictInt),
        pydantic.AfterValidator(of.require_entries),
    ] = field(kw_only=True)
    """Column or list of columns to add up: names or numbers. Example: My."""
    factor: Annotated[Scale, AnyQuantity("factor", "98100 kN/m")] | None = None
    """Factor with a unit that the series is multiplied by."""


class HarmonicEntry(SchemaModel, Generic[T]):
    """mean + amplitude sin(2 pi t / period + phase)."""

    amplitude: T
    """Amplitude of the sine."""
    period: of.Period
    """Period of the sine."""
    mean: T | None = None
    """Mean that the sine is added to."""
    phase: of.Angle = 0.0
    """Phase of the sine at time 0."""


def _form_tag(value: object) -> str:
    """Which of the forms a value in a case file has."""
    if not isinstance(value, dict):
        return "recorded" if isinstance(value, RecordedColumns) else "values"
    if {"file", "column"} & value.keys():
        return "recorded"
    return "table" if {"time", "force"} & value.keys() else "harmonic"


def only_forms(key: str, unit: str, *forms: type) -> pydantic.BeforeValidator:
    """Annotation: the value is a mapping, or one of ``forms`` already."""

    def check(value: object) -> object:
        if not isinstance(value, (dict, *forms)):
            raise problem(
                value_text(value),
                f"a sine {{amplitude: 1 {unit}, period: 8 s}}, a table"
                f" {{time: [0 s, 9 s], {key}: [0 {unit}, 1 {unit}]}}, or a record"
                " {file: path.csv, column: x}",
            )
        return value

    return pydantic.BeforeValidator(check)


ForceOverTime = Annotated[
    Annotated[tuple[of.Force, ...], of.one_or_more(of.Force), pydantic.Tag("values")]
    | Annotated[TableOverTime[of.Force], pydantic.Tag("table")]
    | Annotated[RecordedColumns, pydantic.Tag("recorded")]
    | Annotated[HarmonicEntry[of.Force], pydantic.Tag("harmonic")],
    pydantic.Discriminator(_form_tag),
]
MomentOverTime = Annotated[
    Annotated[tuple[of.Moment, ...], of.one_or_more(of.Moment), pydantic.Tag("values")]
    | Annotated[TableOverTime[of.Moment], pydantic.Tag("table")]
    | Annotated[RecordedColumns, pydantic.Tag("recorded")]
    | Annotated[HarmonicEntry[of.Moment], pydantic.Tag("harmonic")],
    pydantic.Discriminator(_form_tag),
]
NormalOverTime = Annotated[
    Annotated[of.Force, pydantic.Tag("values")]
    | Annotated[TableOverTime[of.Force], pydantic.Tag("table")]
    | Annotated[RecordedColumns, pydantic.Tag("recorded")]
    | Annotated[HarmonicEntry[of.Force], pydantic.Tag("harmonic")],
    pydantic.Discriminator(_form_tag),
]
Form = float | TableOverTime[float] | RecordedColumns | HarmonicEntry[float]
Forces = of.PerDof[ForceOverTime, MomentOverTime]
"""Of an applied force: per DOF a number, a list over the element's own times, or any of these."""


# Recorded series, in the unit that is wanted.

MOTION_UNITS = ("m", "rad")
"""Units of motions. A column without a unit may be of any quantity that a factor makes a force of,
but a motion is made of numbers alone."""


def read_record(form: RecordedColumns, key: str, path: Path, unit: str) -> Series:
    """The series in ``unit`` that is at ``key`` of the case file ``path``.

    Raises InputError where the file cannot be read or its unit does not fit.
    """
    source = Source(path.parent / form.file, f"{path}: {key}")
    if form.case is not None and not os.path.isfile(source.file):
        source.wrong(f"found no such file; expected the run of {form.case}; simulate it first")
    series = read_series(source, form.column)
    value = _unit_factor(form, series, source, unit) * series.value
    require_usual(source, value, unit)
    return Series(series.time, value, unit)


def signal_of(form: Form, key: str, path: Path, unit: str) -> Signal:
    """The signal in ``unit`` that is at ``key`` of the case file ``path``; raises as `read_record`
    does."""
    match form:
        case float() | int():
            return constant(form)
        case TableOverTime():
            return Table(np.array(form.time), np.array(form.force))
        case HarmonicEntry():
            return Harmonic(form.amplitude, form.period, form.mean or 0.0, form.phase)
    series = read_record(form, key, path, unit)
    return Recorded(series.time, series.value)


def _unit_factor(form: RecordedColumns, series: Series, source: Source, unit: str) -> float:
    """What the series is multiplied with to be in ``unit``; InputError if it cannot be."""
    scale = form.factor
    unit_text = series.unit or series.label
    found_text = f"found a column {f'in {unit_text}' if unit_text else 'without a unit'}"
    if scale is None:
        try:
            return 1.0 if unit_text is None else factor(unit_text, unit)
        except ValueError:
            source.wrong(f'{found_text}; expected {unit}; give a factor, such as "98100 kN/m"')
    column_unit = series.unit or ("" if unit in MOTION_UNITS else None)
    if (
        column_unit is not None
        and scale.unit
        and not is_same_dimension(column_unit, scale.unit, unit)
    ):
        source.wrong(f"{found_text} and a factor in {scale.unit}; expected {unit} of both together")
    return scale.value


# Lengths over time: a table, a recorded series, or a sine.


class LengthTable(SchemaModel):
    """Straight lines between the lengths at some times, constant outside."""

    key_rules = (value_for_each_time("length"),)

    time: of.Times
    """Times that rise."""
    length: Annotated[tuple[of.LineLength, ...], pydantic.AfterValidator(of.require_entries)]
    """Length at each time, with straight lines between."""


def _length_form(value: object) -> str:
    """Which of the forms a length has."""
    if isinstance(value, LengthTable) or (isinstance(value, dict) and "time" in value):
        return "table"
    if isinstance(value, RecordedColumns) or (isinstance(value, dict) and "file" in value):
        return "recorded"
    return "harmonic" if isinstance(value, dict | HarmonicEntry) else "length"


LengthOverTime = Annotated[
    Annotated[of.LineLength, pydantic.Tag("length")]
    | Annotated[LengthTable, pydantic.Tag("table")]
    | Annotated[RecordedColumns, pydantic.Tag("recorded")]
    | Annotated[HarmonicEntry[of.Length], pydantic.Tag("harmonic")],
    pydantic.Discriminator(_length_form),
]


def length_signal(
    form: LengthTable | RecordedColumns | HarmonicEntry[float], key: str, path: Path
) -> Signal:
    """The signal of a length [m]. Raises as `signals.signal_of` does, and
    a problem for a length that is not always above 0."""
    same: TableOverTime[float] | RecordedColumns | HarmonicEntry[float]
    if isinstance(form, LengthTable):
        same = TableOverTime[float].model_construct(time=form.time, force=form.length)
    else:
        same = form
    signal = signal_of(same, key, path, "m")
    shortest = smallest_value(signal)
    if not shortest > 0.0:
        raise InputError(
            f"{path}: {key}: found a length that falls to {shortest:g} m; expected one that is"
            " always above 0."
        )
    return signal
