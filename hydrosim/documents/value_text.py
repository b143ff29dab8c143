"""`value_text`: a value of a study in words."""

from __future__ import annotations

import json


def value_text(value: object) -> str:
    """A value in words: a list or a table, which a study holds as JSON, without its brackets."""
    if isinstance(value, float):
        return f"{value:.4g}"
    text = str(value)
    if not text.startswith(("[", "{")):
        return text
    try:
        return _words(json.loads(text))
    except ValueError:
        return text


def _words(value: object) -> str:
    if isinstance(value, dict):
        return ", ".join(f"{key} {_words(of)}" for key, of in value.items())
    if isinstance(value, list):
        return "; ".join(map(_words, value)) or "none"
    return f"{value:.4g}" if isinstance(value, float) else str(value)
