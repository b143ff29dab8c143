"""Messages that a person can act on, from pydantic's errors: "found X; expected Y; remedy".

One mistake gives one message. An unknown key is matched with the missing key beside it. A mapping
with many unknown keys gives one message.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from typing import Any, NamedTuple

from pydantic import BaseModel, ValidationError
from pydantic.fields import FieldInfo

from hydrosim.documents.nodes import with_hint
from hydrosim.documents.suggestions import closest_word, suggestion
from hydrosim.documents.units import Quantity, value_text

Keys = tuple[str | int, ...]
Readers = Mapping[int, type[BaseModel]]
Details = Mapping[str, Any]

MANY_UNKNOWN = 4  # keys of one mapping that one message reports
MANY_KNOWN = 12  # keys are not all listed where one of them is suggested
MAX_LIST_LETTERS = 60  # characters of a list


class Problem(NamedTuple):
    """A mistake: the keys to its place, and a text "found X; expected Y; remedy"."""

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


def validation_problems(error: ValidationError, data: Any, readers: Readers) -> Iterator[Problem]:
    """Each mistake in ``data`` with its place; ``readers`` are the models by the ``id`` of the
    mapping that they read."""
    every: list[Details] = list(error.errors(include_url=False))
    renamed = {*_renamed_keys(every, data, readers)}
    for details in every:
        if details["loc"] not in renamed:
            yield _problem(details, data, readers, every)


def _problem(details: Details, data: Any, readers: Readers, every: Sequence[Details]) -> Problem:
    keys, value, context = details["loc"], details["input"], details.get("ctx", {})
    match details["type"]:
        case "hydrosim":
            return Problem(keys, context["text"])
        case "extra_forbidden":
            return _unknown(
                keys, readers.get(id(_value_at(data, keys[:-1]))), _similar_errors(details, every)
            )
        case "missing" if isinstance(keys[-1], int):
            return Problem(keys[:-1], _too_few(value, _similar_errors(details, every)))
        case "missing":
            return Problem(keys, _missing(keys, readers[id(value)]))
        case "union_tag_invalid":
            key = context["discriminator"].strip("'")
            return Problem((*keys, key), _choice(context["tag"], context["expected_tags"]))
        case "union_tag_not_found":
            key = context["discriminator"].strip("'")
            text = f'found no key "{key}"; expected it to say which kind this is'
            return Problem(keys, with_hint(text, _other_name(key, value)))
        case "literal_error" | "enum":
            return Problem(keys, _choice(value, context["expected"]))
        case "too_long":
            return Problem(
                keys, f"found {value_text(value)}; expected {context['max_length']} values"
            )
        case "too_short":
            least = context["min_length"]
            return Problem(
                keys, f"found {value_text(value)}; expected {_count_text(least)} or more"
            )
        case "tuple_type" if len(_similar_errors(details, every)) > 1:
            return Problem(keys[:-1], _flat(_value_at(data, keys[:-1])))
        case "tuple_type" if isinstance(value, str):
            return Problem(
                keys, f"found {value_text(value)}; expected a list, in brackets: [{value}]"
            )
        case "model_type":
            return Problem(keys, f"found {value_text(value)}; expected {_mapping(context)}")
        case kind:
            expected = EXPECTED.get(kind, details["msg"].removeprefix("Input should be "))
            return Problem(keys, f"found {value_text(value)}; expected {expected}")


def _similar_errors(details: Details, every: Sequence[Details]) -> list[Details]:
    """The errors of the same kind in the same mapping or list."""
    kind, above = details["type"], details["loc"][:-1]
    return [each for each in every if each["type"] == kind and each["loc"][:-1] == above]


def _renamed_keys(every: Sequence[Details], data: Any, readers: Readers) -> Iterator[Keys]:
    """The missing keys that exist under another name."""
    missing = {each["loc"] for each in every if each["type"] == "missing"}
    for each in every:
        keys = each["loc"]
        reader = readers.get(id(_value_at(data, keys[:-1])))
        if each["type"] == "extra_forbidden" and reader:
            found = (*keys[:-1], closest_word(str(keys[-1]), _fields(reader)))
            yield from {found} & missing


def _count_text(count: int) -> str:
    return "one" if count == 1 else f"{count}"


def _unknown(keys: Keys, reader: type[BaseModel] | None, alike: Sequence[Details]) -> Problem:
    known = _fields(reader) if reader else {}
    if len(alike) >= MANY_UNKNOWN:
        names = ", ".join(str(each["loc"][-1]) for each in alike)
        text = f"found {len(alike)} unknown keys, {names}; expected some of: {', '.join(known)}"
        return Problem(keys[:-1], text)
    key = str(keys[-1])
    if comma := _of_comma(key):
        return Problem(keys, f"found a key that begins with a digit; {comma}")
    remedy = _of_colon(key, known) or suggestion(key, known)
    expected = "" if remedy and len(known) > MANY_KNOWN else f"expected one of: {', '.join(known)}"
    text = "; ".join(part for part in ("found an unknown key", expected, remedy) if part)
    return Problem(keys, text)


def _of_comma(key: str) -> str:
    """The remedy for the part after a decimal comma, which begins a new entry in braces."""
    if re.fullmatch(r"\d+( .*)?", key):
        return f'is it the end of a number with a decimal comma? Write a point, as in "2.{key}"'
    return ""


def _of_colon(key: str, known: Mapping[str, Any]) -> str:
    """The remedy if a colon, or the blank after it, is missing after a known key."""
    first = re.split(r"[\s:]", key)[0]
    return f'write "{first}: value", with a colon and a blank' if first in {*known} - {key} else ""


def _other_name(key: str, value: Any) -> str:
    """The key of a mapping that probably stands for ``key``."""
    names = [str(name) for name in value] if isinstance(value, dict) else []
    given = next((name for name in names if _of_colon(name, {key: None})), "")
    if given:
        return f'write "{key}: value", with a colon and a blank, not "{given}"'
    found = next((name for name in names if closest_word(name, [key])), "")
    return f'is "{found}" meant as "{key}"?' if found else ""


def _too_few(value: Any, alike: Sequence[Details]) -> str:
    count = 1 + max(each["loc"][-1] for each in alike)
    return f"found {value_text(value)}; expected {count} values"


def _flat(value: Sequence[Any]) -> str:
    inside = ", ".join(map(str, value))
    example = f", [[{inside}]]" if len(inside) < MAX_LIST_LETTERS else ""
    return f"found a list of values; expected a list of lists; put it in brackets{example}"


def _mapping(context: Mapping[str, Any]) -> str:
    """Description of the mapping that the model of that name reads."""
    models = [each for each in _models(BaseModel) if each.__name__ == context.get("class_name")]
    if not models:
        return EXPECTED["model_type"]
    fields = _fields(models[0])
    needed = [name for name, field in fields.items() if field.is_required()]
    if not needed:
        return f"a mapping with some of {', '.join(fields)}"
    return f"a mapping with the key{'s' * (len(needed) > 1)} {', '.join(needed)}"


def _models(base: type[BaseModel]) -> Iterator[type[BaseModel]]:
    for each in base.__subclasses__():
        yield each
        yield from _models(each)


def _missing(keys: Keys, reader: type[BaseModel]) -> str:
    about = _fields(reader)[str(keys[-1])].metadata
    expected = next((item.expected_text for item in about if isinstance(item, Quantity)), "one")
    return f'found no key "{keys[-1]}"; expected {expected}'


def _fields(reader: type[BaseModel]) -> dict[str, FieldInfo]:
    """The fields of a model, by the keys of a file."""
    return {field.alias or name: field for name, field in reader.model_fields.items()}


def _choice(value: Any, expected: str) -> str:
    choices = re.findall(r"'([^']*)'", expected)
    text = f"found {value_text(value)}; expected one of: {', '.join(choices)}"
    return with_hint(text, suggestion(str(value), choices))


def _value_at(data: Any, keys: Keys) -> Any:
    """The value at ``keys``; keys that do not exist are skipped, as in `locate_value`."""
    for key in keys:
        if isinstance(data, dict):
            data = data.get(key, data)
        elif isinstance(data, list) and isinstance(key, int) and key < len(data):
            data = data[key]
    return data
