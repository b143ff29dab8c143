"""Given components of a sea from a text file, a line for each."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
from pydantic import ValidationError

from hydrosim.case.waves import Component
from hydrosim.documents.messages import validation_problems
from hydrosim.documents.text import Source, TextTable, name_and_unit, parse, unit_of_column

COLUMN_UNITS = {
    "frequency": "rad/s",
    "period": "s",
    "amplitude": "m",
    "phase": "rad",
    "heading": "rad",
}
"""Of the columns, where the file says none."""
ANGLES = ("phase", "heading")
EXPECTED = "frequency [rad/s] or period [s], amplitude [m], and if wanted phase and heading [rad]"


def read_components(source: Source) -> tuple[Component, ...]:
    """The components in a text file with the columns frequency or period, amplitude, phase and
    heading, in the units that their names say: "frequency [Hz]". InputError says what is wrong."""
    source.head(1)
    table = parse(source, first="a component")
    columns = dict(_columns(source, table))
    return tuple(
        _wave_component(source, dict(zip(columns, map(float, row), strict=True)), line)
        for line, row in zip(table.lines, np.transpose([*columns.values()]), strict=True)
    )


def _columns(source: Source, table: TextTable) -> Iterator[tuple[str, np.ndarray]]:
    """Each column by its name, in SI; those of other names are refused, not passed over."""
    names = [name_and_unit(name)[0].strip().lower() for name in table.names]
    unknown = [name for name in names if name not in COLUMN_UNITS]
    if unknown or len({*names}) < len(names) or not names:
        found = ", ".join(table.names) or "no names of columns"
        source.wrong(f"found {found}; expected the columns {EXPECTED}, each once")
    for k, name in enumerate(names):
        unit = unit_of_column(table, k)
        values = table.rows[:, k]
        if name in ANGLES and unit is None and np.abs(values).max() > 2.0 * np.pi:
            source.wrong(
                f"found a {name} of {np.abs(values).max():g} and no unit: degrees or radians? Name"
                f" the column {name} [deg] or {name} [rad]"
            )
        yield name, values * _scale(source, name, unit or COLUMN_UNITS[name])


def _scale(source: Source, name: str, unit: str) -> float:
    """What a number in a unit is multiplied with to be in SI."""
    others = {"amplitude": 1.0} | ({} if name == "frequency" else {"period": 1.0})
    one = _wave_component(source, {**others, name: f"1 {unit}"})
    return float(getattr(one, name))


def _wave_component(source: Source, values: dict[str, Any], line: int | None = None) -> Component:
    """A component with these values, which are checked as those in a case file are."""
    readers: dict[int, Any] = {}
    try:
        return Component.model_validate(values, context=readers)
    except ValidationError as error:
        problem = next(validation_problems(error, values, readers))
        source.wrong(": ".join([*map(str, problem.keys), problem.text]), line)
