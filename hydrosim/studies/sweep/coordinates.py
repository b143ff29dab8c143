"""Values of a case by their dotted keys, as numbers in SI with their units."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping, Sequence
from typing import Any, NamedTuple, get_args

from pydantic import BaseModel

from hydrosim.documents.units import Cyclic, Quantity


class CaseValue(NamedTuple):
    """A ``value`` in a case, and its SI ``unit`` if the schema knows one; whether that is
    ``cyclic``, of a frequency of waves or a density over it."""

    value: Any
    unit: str | None = None
    cyclic: bool = False

    @property
    def number(self) -> float | None:
        """The value, if it is a number."""
        plain = isinstance(self.value, int | float) and not isinstance(self.value, bool)
        return self.value if plain else None


def value_at_key(data: BaseModel, key: str) -> CaseValue:
    """What a validated case has at a dotted ``key``; a list of one may be passed over."""
    node: Any = data
    about: tuple[Any, ...] = ()
    for part in key.split("."):
        if isinstance(node, Sequence) and not part.isdigit() and len(node) == 1:
            node, about = node[0], _item_annotations(about, 0)
        if isinstance(node, BaseModel):
            field = next((f for n, f in type(node).model_fields.items() if n == part), None)
            about = (field.annotation, *field.metadata) if field else ()
            node = getattr(node, part, None)
        elif isinstance(node, Mapping):
            node, about = node.get(part), tuple(a for each in about for a in get_args(each))
        elif isinstance(node, Sequence) and part.isdigit() and int(part) < len(node):
            node, about = node[int(part)], _item_annotations(about, int(part))
        else:
            return CaseValue(None)
    quantities = [quantity for each in about for quantity in _quantities(each)]
    units = {quantity.unit for quantity in quantities}
    if len(units) != 1:
        return CaseValue(node)
    return CaseValue(node, units.pop(), any(isinstance(each, Cyclic) for each in quantities))


def label_values(values: Sequence[Any]) -> list[Any]:
    """Numbers as they are if all are; else texts."""
    if all(CaseValue(value).number is not None for value in values):
        return list(values)
    return [value if isinstance(value, str) else json.dumps(value, default=str) for value in values]


def _item_annotations(about: tuple[Any, ...], index: int) -> tuple[Any, ...]:
    """Annotations of an item of a tuple; of any where they are not told apart."""
    annotations: list[Any] = []
    for each in about:
        arguments = get_args(each)
        fixed = getattr(each, "__origin__", None) is tuple and Ellipsis not in arguments
        annotations += [arguments[index]] if fixed and index < len(arguments) else arguments
    return tuple(annotations)


def _quantities(annotation: Any) -> Iterator[Quantity]:
    if isinstance(annotation, Quantity):
        yield annotation
    for each in get_args(annotation):
        yield from _quantities(each)
