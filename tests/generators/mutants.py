"""Mutants of the shipped cases: every key, in every way that a hand may slip, or mean harm.

A case is taken with what it extends and with all its defaults, so that every key that it could have
is there; one of them is changed. `Mutant` numbers are the same for a seed and a set of cases.
"""

import random
import re
import warnings
from collections.abc import Callable, Iterator
from copy import deepcopy
from functools import cache
from pathlib import Path
from typing import Any, NamedTuple

import yaml

from hydrosim.case import load_case
from hydrosim.case.build import resolved_case_text
from hydrosim.files.layers import read_case
from hydrosim.files.yaml_nodes import plain_values

CASES = Path(__file__).parents[2] / "cases"
NUMBER = re.compile(r"^[-+]?\d+\.?\d*(?:[eE][-+]?\d+)?")
SHORT = 10.0  # s: the duration of what is run
GONE = object()

Keys = tuple[str | int, ...]
Change = Callable[[Any], Any]


class Mutant(NamedTuple):
    """The shipped case ``case`` with what is at ``keys`` changed by the mutation ``how``."""

    case: str
    keys: Keys
    how: str


def itself(value: Any) -> Any:
    """A list in itself, by an alias."""
    around: list[Any] = [value]
    around.append(around)
    return around


def bomb(value: Any) -> Any:
    """Nine levels of nine aliases."""
    for _ in range(9):
        value = [value] * 9
        value = [value[0]] * 9
    return value


def deep(value: Any) -> Any:
    """Lists in lists."""
    for _ in range(200):
        value = [value]
    return value


def scaled(factor: float) -> Change:
    """The number times a factor, in the unit that it has."""

    def change(value: Any) -> Any:
        if isinstance(value, bool) or not isinstance(value, int | float | str):
            return [scaled(factor)(item) for item in value] if isinstance(value, list) else value
        if not isinstance(value, str):
            return value * factor
        return NUMBER.sub(lambda found: repr(float(found.group()) * factor), value)

    return change


def of_list(change: Change) -> Change:
    """What is done to lists; anything else is put in one."""
    return lambda value: change(value if isinstance(value, list) else [value])


CHANGES: dict[str, Change] = {
    "deleted": lambda value: GONE,
    "nothing": lambda value: None,
    "text": lambda value: "abc",
    "empty text": lambda value: "",
    "blank": lambda value: " ",
    "true": lambda value: True,
    "one": lambda value: 1,
    "zero": lambda value: 0,
    "sign": scaled(-1.0),
    "thousand times": scaled(1e3),
    "a thousandth": scaled(1e-3),
    "a million times": scaled(1e6),
    "a millionth": scaled(1e-6),
    "a large number": lambda value: 1e15,
    "a huge number": lambda value: 1e300,
    "a huge negative number": lambda value: -1e300,
    "a whole number that is too large": lambda value: 10**40,
    "a tiny number": lambda value: 1e-300,
    "1e12": lambda value: 1e12,
    "nan": lambda value: float("nan"),
    "nan in words": lambda value: "nan",
    "infinity": lambda value: float("inf"),
    "infinite": lambda value: "infinite",
    "no unit that there is": lambda value: "3 parsecs",
    "another kind of unit": lambda value: "3 degC",
    "a weight": lambda value: "3 kg",
    "a comma": lambda value: "1,5",
    "octal": lambda value: "0o17",
    "a date": lambda value: "2020-01-01",
    "an expression": lambda value: "__import__('os').getcwd()",
    "a list": lambda value: [value],
    "a mapping": lambda value: {"a": value},
    "an empty list": lambda value: [],
    "an empty mapping": lambda value: {},
    "a longer list": of_list(lambda value: [*value, *value[-1:]]),
    "a shorter list": of_list(lambda value: value[:-1]),
    "a list of many": of_list(lambda value: value * 3000),
    "a list that begins anew": of_list(lambda value: [*value[::-1], *value]),
    "a list of nothing": of_list(lambda value: [None] * len(value)),
    "a list with a word": of_list(lambda value: [*value[:-1], "abc"]),
    "other alphabets": lambda value: "Größe 漢字 🙂 \u202e",
    "a line": lambda value: "a\nb: c",
    "what steers a terminal": lambda value: "\x1b[2J",
    "half a character": lambda value: "\ud800",
    "a zero byte": lambda value: "a\0b",
    "a long text": lambda value: "x" * 5000,
    "a folder": lambda value: ".",
    "a device": lambda value: "/dev/zero",
    "another file": lambda value: "../../README.md",
    "in itself": itself,
    "aliases": bomb,
    "deep": deep,
    "several": lambda value: [value, value],
}
VALUES = (
    *("deleted", "one", "zero", "sign", "thousand times", "a thousandth", "a million times"),
    *("a millionth", "a large number", "1e12"),
)
"""Changes of numbers that may be numbers of the same kind still."""
RENAMES: dict[str, Callable[[str], str]] = {
    "unknown key": lambda key: f"{key}s",
    "long key": lambda key: key * 1000,
    "odd key": lambda key: f"{key}\u202e🙂",
    "steering key": lambda key: f"{key}\x1b[2J",
    "empty key": lambda key: "",
    "number for a key": lambda key: "1",
}


def shipped() -> list[str]:
    """Names of all shipped cases."""
    return sorted(str(path.relative_to(CASES).with_suffix("")) for path in CASES.glob("*/*.yaml"))


@cache
def whole(name: str) -> dict[str, Any]:
    """A case with all that it could say, in its own units where it says it."""
    path = CASES / f"{name}.yaml"
    everything = yaml.safe_load(resolved_case_text(load_case(path).data, path.parent))
    return dict(_over(everything, plain_values(read_case(path)[1])))


def mutants(count: int, seed: int, of_values: bool = False) -> list[Mutant]:
    """So many mutants; ``of_values`` those of numbers alone that are numbers still, or nothing."""
    every = [
        Mutant(name, keys, how)
        for name in shipped()
        for keys in places(whole(name))
        for how in (VALUES if of_values else (*CHANGES, *RENAMES))
        if (how not in RENAMES or isinstance(keys[-1], str))
        and (not of_values or _is_number(_at(whole(name), keys)))
    ]
    return random.Random(seed).sample(every, count)


def _at(case: Any, keys: Keys) -> Any:
    for key in keys:
        case = case[key]
    return case


def _is_number(value: Any) -> bool:
    number = isinstance(value, int | float) and not isinstance(value, bool)
    return number or (isinstance(value, str) and NUMBER.match(value) is not None)


def text_of(mutant: Mutant, duration: float | None = None) -> str:
    """The case file of a mutant, of another ``duration`` if that is not what is changed."""
    case = deepcopy(whole(mutant.case))
    if duration is not None:
        case["duration"] = duration
    change(case, mutant.keys, mutant.how)
    return written(case)


def change(document: Any, keys: Keys, how: str) -> None:
    """Change what is at ``keys`` of a document by the mutation ``how``."""
    *above, last = keys
    home = _at(document, tuple(above))
    if how in RENAMES:
        home[RENAMES[how](str(last))] = home.pop(last)
    else:
        home[last] = CHANGES[how](home[last])
        if home[last] is GONE:
            del home[last]


def written(document: Any) -> str:
    """A document as YAML."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        return str(yaml.dump(document, Dumper=yaml.SafeDumper, sort_keys=False))


def _over(under: Any, over: Any) -> Any:
    """What is said, over what is taken for it."""
    if isinstance(under, list) and isinstance(over, dict):
        return [_over(under[0], over)]
    if isinstance(under, dict) and isinstance(over, dict):
        return under | {key: _over(under.get(key), value) for key, value in over.items()}
    return over


def places(value: Any, above: Keys = ()) -> Iterator[Keys]:
    """The keys to everything in a case."""
    items: Any = ()
    if isinstance(value, dict):
        items = value.items()
    elif isinstance(value, list):
        items = enumerate(value[:2])  # one is as the next
    for key, item in items:
        yield (*above, key)
        yield from places(item, (*above, key))
