"""Of parameters that show the same: a few in every run of the tests, the others where all run."""

from collections.abc import Iterable
from typing import Any

import pytest


def few(values: Iterable[Any], count: int) -> list[Any]:
    """The values, from which all after the first ``count`` are marked as slow."""
    values = list(values)
    return [*values[:count], *(pytest.param(x, marks=pytest.mark.slow) for x in values[count:])]
