"""Rules on which keys of a mapping go together: classes of files declare them as ``key_rules``.

    class Spring(...):
        key_rules = (exactly_one("stiffness", "curve", nothing="no curve"),)

They are checked once the values are valid, those of base classes first, before other checks of the
class.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

from hydrosim.files.units import problem

Rule = Callable[[Any], None]
"""Raises a problem if a mapping breaks it."""
Rules = tuple[Rule, ...]


def check_key_rules(mapping: Any) -> None:
    """Raises a problem if a mapping breaks a rule of its class."""
    for base in reversed(type(mapping).__mro__):
        for rule in vars(base).get("key_rules", ()):
            rule(mapping)


def exactly_one(*choices: str | Sequence[str], nothing: str = "none", expected: str = "") -> Rule:
    """One of several keys has a value, or one group of keys has values."""
    groups = [[choice] if isinstance(choice, str) else [*choice] for choice in choices]
    keys = [key for group in groups for key in group]
    texts = [" and ".join(group) for group in groups]
    if len(keys) > len(groups):
        default = ", or ".join(texts)
    else:
        default = f"either {' or '.join(texts)}" if len(keys) == 2 else f"one of {', '.join(texts)}"

    def check(mapping: Any) -> None:
        given = mapping.keys_with_value(*keys)
        if given not in groups:
            raise problem(" and ".join(given) or nothing, expected or default)

    return check


def at_least_one(*keys: str, nothing: str, expected: str = "") -> Rule:
    """One or more of the keys have a value."""

    def check(mapping: Any) -> None:
        if not mapping.keys_with_value(*keys):
            raise problem(nothing, expected or f"{', '.join(keys)}, or both")

    return check


def at_most_one(*keys: str, expected: str, remedy: str = "") -> Rule:
    """Not more than one of the keys has a value."""

    def check(mapping: Any) -> None:
        given = mapping.keys_with_value(*keys)
        if len(given) > 1:
            raise problem(" and ".join(given), expected, remedy)

    return check


def same_length(at: str, *keys: str, each: str = "", found: str = "", expected: str = "") -> Rule:
    """The lists of the ``keys`` that have a value are as long as that of the key ``at``; ``each``
    is what each value of it is called."""
    first, second = ("{count} values in {at}", "{size} values in {key}")
    order = f"{second} and {{count}} in {{at}}" if each else f"{first} and {{size}} in {{key}}"
    default = f"a value for each {each}" if each else "a {key} for each {at}"

    def check(mapping: Any) -> None:
        if not mapping.keys_with_value(at):
            return
        count = len(getattr(mapping, at))
        for key in mapping.keys_with_value(*keys):
            if (size := len(getattr(mapping, key))) != count:
                words = {"count": count, "at": at, "size": size, "key": key}
                texts = (found or order, expected or default)
                raise problem(*(text.format(**words) for text in texts))

    return check


def value_for_each_time(key: str) -> Rule:
    """The list of a key has a value for each ``time``."""
    article = "an" if key[0] in "ao" else "a"
    found_text = "{count} times and {size} {key}s"
    return same_length("time", key, found=found_text, expected=f"{article} {key} for each time")
