"""Recorded series of a case, in the unit that is wanted."""

from __future__ import annotations

from pathlib import Path

from hydrosim.case.signals import Recorded
from hydrosim.documents.series import Series, read_series
from hydrosim.documents.text import Source
from hydrosim.documents.units import same_dimension


def read_record(form: Recorded, key: str, path: Path, unit: str) -> Series:
    """The series in ``unit`` that is at ``key`` of the case file ``path``.

    Raises InputError where the file cannot be read or its unit does not fit.
    """
    source = Source(path.parent / form.file, f"{path}: {key}")
    if form.case is not None and not source.file.is_file():
        source.wrong(f"found no such file; expected the run of {form.case}; simulate it first")
    series = read_series(source, form.column)
    return Series(series.time, _factor(form, series, source, unit) * series.value, unit)


def _factor(form: Recorded, series: Series, source: Source, unit: str) -> float:
    """What the series is multiplied with to be in ``unit``; InputError if it cannot be."""
    scale, found = form.factor, f"found a column in {series.unit}"
    if scale is None:
        if series.unit not in (unit, None):
            source.wrong(f'{found}; expected {unit}; give a factor, such as "98100 kN/m"')
        return 1.0
    if series.unit and scale.unit and not same_dimension(series.unit, scale.unit, unit):
        source.wrong(f"{found} and a factor in {scale.unit}; expected {unit} of both together")
    return scale.value
