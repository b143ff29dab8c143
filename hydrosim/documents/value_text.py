"""Values of a study in words, and letters for those that are long."""

from __future__ import annotations

import json
from string import ascii_uppercase


def value_text(value: object) -> str:
    """A value in words: a list or a table, which a study holds as JSON, without its brackets."""
    if isinstance(value, float):
        return f"{value:.4g}"
    text = str(value)
    if not text.startswith(("[", "{")):
        return text
    try:
        return _words(json.loads(text), "; ")
    except ValueError:
        return text


def _words(value: object, between: str = ", ") -> str:
    """A value in words; items of a list of lists are told apart from their own items."""
    if isinstance(value, dict):
        return ", ".join(f"{key} {_words(of, '; ')}" for key, of in value.items())
    if isinstance(value, list):
        return between.join(map(_words, value)) or "none"
    return f"{value:.4g}" if isinstance(value, float) else str(value)


def letter_of(index: int) -> str:
    """A, B, ..., Z, AA, AB, ..."""
    before, own = divmod(index, len(ascii_uppercase))
    return (letter_of(before - 1) if before else "") + ascii_uppercase[own]
