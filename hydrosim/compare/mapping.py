"""Mapping between columns of a recording and channels of a run, in a small YAML file.

    time: {column: 1, unit: s, offset: 0 s, shift: false}
    channels:
      position.barge.heave: Heave (m)              # the column's name, or its number from 1 on
      position.barge.pitch: {column: 6, unit: deg, sign: -1}
      position.barge.surge: {column: Xbow, unit: m, offset: 2 m, point: [80, 0, 7.5]}

All keys except ``column`` are optional. A recorded value becomes sign * value [unit] + offset; the
offset is in SI or has a unit. ``point`` is in the body frame: the recorded motion or velocity
belongs to that point, and the run is evaluated there. The offset of the time is added to the
recorded times. With ``shift``, a further time shift is estimated.
"""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

from pydantic import (
    AfterValidator,
    BeforeValidator,
    PrivateAttr,
    StrictBool,
    StrictInt,
    StrictStr,
)

from hydrosim.documents import quantities as of
from hydrosim.documents.layers import read_case
from hydrosim.documents.nodes import locate_value, place_text
from hydrosim.documents.quantities import SchemaModel
from hydrosim.documents.text import readable_unit
from hydrosim.documents.units import AnyQuantity, Scale, problem, value_text
from hydrosim.documents.validate import validate_document


def _unit(text: str) -> str:
    unit = readable_unit(text)
    if unit is None:
        raise problem(value_text(text), "a known unit, such as m, deg, kN or kN*m")
    return unit


def _sign(value: int) -> int:
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
    sign: Annotated[StrictInt, AfterValidator(_sign)] = 1
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


def read_mapping(path: Path | str) -> MappingFile:
    """Read the mapping in the YAML file ``path``. Raises InputError with a line for each problem:
    file and line, key, value found, value expected."""
    _, document = read_case(Path(path))
    mapping = validate_document(document, MappingFile)
    for name, place in mapping.channels.items():
        key, mark = locate_value(document, ("channels", name))
        place._written = f"{place_text(mark)}: {key}"
    return mapping
