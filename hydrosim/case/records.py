"""Recorded series of a case, in the unit that is wanted."""

from __future__ import annotations

import os
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from hydrosim.case.signals import Form, Harmonic, Recorded, Table
from hydrosim.documents.series import Series, read_series
from hydrosim.documents.text import Source, require_usual
from hydrosim.documents.units import factor, same_dimension

if TYPE_CHECKING:
    from hydrosim.forces.signal import Signal

MOTION_UNITS = ("m", "rad")
"""Units of motions. A column without a unit may be of any quantity that a factor makes a force of,
but a motion is made of numbers alone."""


def read_record(form: Recorded, key: str, path: Path, unit: str) -> Series:
    """The series in ``unit`` that is at ``key`` of the case file ``path``.

    Raises InputError where the file cannot be read or its unit does not fit.
    """
    source = Source(path.parent / form.file, f"{path}: {key}")
    if form.case is not None and not os.path.isfile(source.file):
        source.wrong(f"found no such file; expected the run of {form.case}; simulate it first")
    series = read_series(source, form.column)
    value = _factor(form, series, source, unit) * series.value
    require_usual(source, value, unit)
    return Series(series.time, value, unit)


def signal_of(form: Form, key: str, path: Path, unit: str) -> Signal:
    """The signal in ``unit`` that is at ``key`` of the case file ``path``; raises as `read_record`
    does."""
    from hydrosim.forces import signal  # loads numba

    match form:
        case Table():
            return signal.Table(np.array(form.time), np.array(form.force))
        case Harmonic():
            return signal.Harmonic(form.amplitude, form.period, form.mean or 0.0, form.phase)
    series = read_record(form, key, path, unit)
    return signal.Recorded(series.time, series.value)


def _factor(form: Recorded, series: Series, source: Source, unit: str) -> float:
    """What the series is multiplied with to be in ``unit``; InputError if it cannot be."""
    scale = form.factor
    said = series.unit or series.label
    found_text = f"found a column {f'in {said}' if said else 'without a unit'}"
    if scale is None:
        try:
            return 1.0 if said is None else factor(said, unit)
        except ValueError:
            source.wrong(f'{found_text}; expected {unit}; give a factor, such as "98100 kN/m"')
    known = series.unit or ("" if unit in MOTION_UNITS else None)
    if known is not None and scale.unit and not same_dimension(known, scale.unit, unit):
        source.wrong(f"{found_text} and a factor in {scale.unit}; expected {unit} of both together")
    return scale.value
