"""Whether two scenes are equal."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import Field, fields, is_dataclass
from numbers import Number
from pathlib import Path
from typing import Any

import numpy as np

PLAIN_TYPES = (str, Number, Path, type(None))


def _compared_fields(part: Any) -> list[Field[Any]]:
    """The fields that make a difference."""
    return [field for field in fields(part) if field.compare]


def scenes_equal(one: object, other: object) -> bool:
    """Whether two parts of scenes are equal: dataclasses, mappings, lists and arrays entry by
    entry, numbers and texts; anything else only if it is the same object."""
    if one is other:
        return True
    if type(one) is not type(other):
        return False
    if isinstance(one, np.ndarray):
        return np.array_equal(one, np.asarray(other))
    if isinstance(one, Mapping) and isinstance(other, Mapping):
        return list(one) == list(other) and all(scenes_equal(one[key], other[key]) for key in one)
    if isinstance(one, tuple | list) and isinstance(other, tuple | list):
        return len(one) == len(other) and all(map(scenes_equal, one, other))
    if is_dataclass(one):
        return all(
            scenes_equal(getattr(one, f.name), getattr(other, f.name))
            for f in _compared_fields(one)
        )
    return isinstance(one, PLAIN_TYPES) and one == other
