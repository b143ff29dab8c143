"""`validate_document` reads a YAML file as a pydantic model, or raises an error about every mistake
in it."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from typing import Any, TypeVar

from pydantic import BaseModel, ValidationError
from yaml.nodes import Node

from hydrosim.documents.messages import Problem, validation_problems
from hydrosim.documents.nodes import empty_keys, locate_value, place_text, plain_values
from hydrosim.errors import InputError

M = TypeVar("M", bound=BaseModel)
Further = Callable[[M], Iterable[Problem]]

MOST_TOLD = 15  # problems in one error: nobody reads more, and a list may have thousands


def validate_document(document: Node, model: type[M], further: Further[M] = lambda _: ()) -> M:
    """The nodes of a YAML file as a ``model``; ``further`` finds problems in what it holds.

    Raises InputError with a line for each problem, and with the number of those after the
    first `MOST_TOLD`.
    """
    raw = plain_values(document)
    readers: dict[int, Any] = {}
    try:
        data = model.model_validate(raw, context=readers)
    except ValidationError as error:
        empty = [each for each in _empty_value_problems(document) if ":" not in str(each.keys[-1])]
        _report([*validation_problems(error, raw, readers), *empty], document)
        raise
    _report([*_empty_value_problems(document), *further(data)], document)
    return data


def _empty_value_problems(document: Node) -> Iterator[Problem]:
    for keys in empty_keys(document):
        yield Problem(keys, "found nothing; expected a value; give one or remove the key")


def _report(problems: Sequence[Problem], document: Node) -> None:
    """Raises one InputError with the first problem of each key; passes if there is none."""
    lines: dict[str, str] = {}
    for problem in problems:
        key, mark = locate_value(document, problem.keys)
        lines.setdefault(
            key, ": ".join(part for part in (place_text(mark), key, problem.text) if part)
        )
    if lines:
        raise InputError("\n".join(_first_lines([*lines.values()])))


def _first_lines(lines: list[str]) -> list[str]:
    more = len(lines) - MOST_TOLD
    if more <= 0:
        return lines
    return [*lines[:MOST_TOLD], f"{more} more problems are not shown. Correct these first."]
