"""From pydantic's errors to what a person can act on: "found X; expected Y; remedy"."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from typing import Any, NamedTuple

from pydantic import BaseModel, ValidationError
from pydantic.fields import FieldInfo

from hydrosim.documents.nodes import joined, suggestion
from hydrosim.documents.units import Quantity, shown

Keys = tuple[str | int, ...]
Readers = Mapping[int, type[BaseModel]]


class Problem(NamedTuple):
    """Keys to where it is, and what: "found X; expected Y; remedy"."""

    keys: Keys
    text: str


EXPECTED = {
    "model_type": "a mapping of keys and values",
    "model_attributes_type": "a mapping of keys and values",
    "dict_type": "a mapping of names and values",
    "tuple_type": "a list",
    "string_type": "text; put it in quotes if it looks like something else",
    "bool_type": "true or false",
    "int_type": "a whole number",
    "greater_than_equal": "a number that is not negative",
}


def explain(error: ValidationError, data: Any, readers: Readers) -> Iterator[Problem]:
    """Each error in ``data`` with its place; ``readers`` are the models by ``id`` of the mapping
    that they read."""
    for details in error.errors(include_url=False):
        keys, value, context = details["loc"], details["input"], details.get("ctx", {})
        match details["type"]:
            case "hydrosim":
                yield Problem(keys, context["text"])
            case "extra_forbidden":
                yield Problem(keys, _unknown(keys, readers.get(id(_at(data, keys[:-1])))))
            case "missing":
                yield Problem(keys, _missing(keys, value, readers.get(id(value))))
            case "union_tag_invalid":
                key = context["discriminator"].strip("'")
                yield Problem((*keys, key), _choice(context["tag"], context["expected_tags"]))
            case "union_tag_not_found":
                key = context["discriminator"].strip("'")
                yield Problem(keys, f'found no key "{key}"; expected it to say which kind this is')
            case "literal_error" | "enum":
                yield Problem(keys, _choice(value, context["expected"]))
            case "too_long":
                yield Problem(
                    keys, f"found {shown(value)}; expected {context['max_length']} values"
                )
            case "too_short":
                least = context["min_length"]
                yield Problem(keys, f"found {shown(value)}; expected {_some(least)} or more")
            case kind:
                expected = EXPECTED.get(kind, details["msg"].removeprefix("Input should be "))
                yield Problem(keys, f"found {shown(value)}; expected {expected}")


def _some(count: int) -> str:
    return "one" if count == 1 else f"{count}"


def _unknown(keys: Keys, reader: type[BaseModel] | None) -> str:
    known = _fields(reader) if reader else {}
    text = f"found an unknown key; expected one of: {', '.join(known)}"
    return joined(text, suggestion(str(keys[-1]), known))


def _missing(keys: Keys, value: Any, reader: type[BaseModel] | None) -> str:
    if reader is None:
        return f"found {shown(value)}; expected more values"
    about = _fields(reader)[str(keys[-1])].metadata
    expected = next((item.expected for item in about if isinstance(item, Quantity)), "one")
    return f'found no key "{keys[-1]}"; expected {expected}'


def _fields(reader: type[BaseModel]) -> dict[str, FieldInfo]:
    """What a model has, by the keys of a file."""
    return {field.alias or name: field for name, field in reader.model_fields.items()}


def _choice(value: Any, expected: str) -> str:
    choices = re.findall(r"'([^']*)'", expected)
    text = f"found {shown(value)}; expected one of: {', '.join(choices)}"
    return joined(text, suggestion(str(value), choices))


def _at(data: Any, keys: Keys) -> Any:
    """The value at ``keys``; those that are not there are passed over, as in `locate`."""
    for key in keys:
        if isinstance(data, dict):
            data = data.get(key, data)
        elif isinstance(data, list) and isinstance(key, int) and key < len(data):
            data = data[key]
    return data
