"""Commands that show results, which are files that people pass on and change."""

from __future__ import annotations

import re
from collections.abc import Callable
from functools import wraps
from pathlib import Path
from typing import Any

from hydrosim.errors import InputError

MISSING_VARIABLE = re.compile(
    r"No variable named '(\w+)'|'Dataset' object has no attribute '(\w+)'"
)
"""What xarray says of a variable that a dataset lacks."""


def tells_absent_variables(command: Callable[..., Any]) -> Callable[..., Any]:
    """A ``command`` that shows a result, and refuses one that lacks a variable it needs."""

    @wraps(command)
    def show(**given: Any) -> Any:
        try:
            return command(**given)
        except (KeyError, AttributeError) as error:
            absent = MISSING_VARIABLE.search(str(error))
            if absent is None:
                raise
            path = next(value for value in given.values() if isinstance(value, Path))
            from hydrosim.results.validation import CHANGED_FILE_HINT  # loads the models of cases

            found = f"found no variable {absent[1] or absent[2]}, which this page needs"
            raise InputError(f"{path}: {found}. {CHANGED_FILE_HINT}") from error

    return show
