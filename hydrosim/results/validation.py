"""Checks of a result that was read: attributes that are JSON, units, and numbers that can be.

Results are files that people pass on and change. What no run writes is refused with its name,
before a picture, a page or a table of it fails.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator, Mapping
from itertools import chain
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from hydrosim.case.criteria import CRITERIA, TITLE_BLOCK
from hydrosim.dofs import DOFS
from hydrosim.errors import InputError
from hydrosim.files.display_units import BASE_UNITS, UNITS_ATTRIBUTE, Units

if TYPE_CHECKING:
    import xarray as xr

MAX_NUMBER = 1e100
"""Size of a number whose square is still finite."""
CHANGED_FILE_HINT = "The file was changed after it was written: make the result again."
DESIGN = "design"
"""Attribute of a file of runs: the plans of its study, and what is asked of its runs, as JSON."""
FUNCTION_STATES = "external_states"
"""Attribute: time and states of functions, as JSON."""
MOVING = ("position", "velocity")
"""Variables of a run that are known at every recorded time."""


def check_attributes(path: Path, attributes: Mapping[Any, Any]) -> None:
    """Raises InputError for an attribute that holds no JSON of its kind."""
    for name, (expected, is_right) in JSON_ATTRIBUTES.items():
        if name not in attributes:
            continue
        text = str(attributes[name])
        try:
            right = is_right(json.loads(text))
        except (ValueError, RecursionError):
            right = False
        if not right:
            raise InputError(
                f"{path}: attribute {name}: found {text[:60]!r}; expected {expected}."
                f" {CHANGED_FILE_HINT}"
            )


def check_run(path: Path, run: xr.Dataset) -> None:
    """Raises InputError for attributes, units or numbers that no run has."""
    check_result(path, run)
    for problem in chain(_wrong_units(run), _wrong_time(run), _wrong_numbers(run)):
        raise InputError(f"{path}: {problem}. {CHANGED_FILE_HINT}")


def check_result(path: Path, result: xr.Dataset) -> None:
    """Raises InputError for attributes or names that no result has."""
    check_attributes(path, result.attrs)
    for problem in _wrong_names(result):
        raise InputError(f"{path}: {problem}. {CHANGED_FILE_HINT}")


def _wrong_units(run: xr.Dataset) -> Iterator[str]:
    """Units of degrees of freedom that are not one for each."""
    for name, variable in run.variables.items():
        units = str(variable.attrs.get("dof_units", "")).split(", ")
        if "dof_units" in variable.attrs and "dof" in run.dims and len(units) != run.sizes["dof"]:
            found_text = f"found {len(units)} units; expected {run.sizes['dof']}"
            yield f"attribute dof_units of {name}: {found_text}, one for each degree of freedom"


def _wrong_names(run: xr.Dataset) -> Iterator[str]:
    """Names along a dimension that are there twice, or that are no degrees of freedom."""
    for name, index in run.indexes.items():
        if not index.is_unique and name != "time":
            yield f"{name}: found {index[index.duplicated()][0]!r} twice; expected each once"
    if "dof" in run.indexes and not {*run.indexes["dof"]} <= {*DOFS}:
        yield f"dof: found {', '.join(map(str, run.dof.values))}; expected degrees of freedom"


def _wrong_time(run: xr.Dataset) -> Iterator[str]:
    if "time" not in run.variables:
        return
    time = run["time"].values
    if time.dtype.kind not in "fiu":
        yield f"time: found {time.dtype}; expected seconds"
    elif not np.isfinite(time).all() or np.abs(time).max(initial=0.0) > MAX_NUMBER:
        yield "time: found values that are no times; expected seconds"
    elif np.any(np.diff(time) <= 0.0):
        k = int(np.argmax(np.diff(time) <= 0.0))
        yield f"time: found {time[k + 1]:g} s after {time[k]:g} s; expected times that rise"


def _wrong_numbers(run: xr.Dataset) -> Iterator[str]:
    """Motions that are not known at every time, or not finite when they are squared; and numbers
    of anything that are infinite."""
    for name in filter(run.variables.__contains__, MOVING):
        values = run[name].values
        finite = np.isfinite(values)
        if not finite.all():
            yield f"{name}: found {np.count_nonzero(~finite)} values that are no numbers"
        elif np.abs(values).max(initial=0.0) > MAX_NUMBER:
            yield f"{name}: found a value above {MAX_NUMBER:g}; expected one that can be squared"
    for key, variable in run.variables.items():
        if variable.dtype.kind == "f" and np.isinf(variable.values).any():
            yield f"{key}: found an infinite value; expected finite ones"


def _is_texts(value: Any) -> bool:
    return isinstance(value, dict) and all(isinstance(text, str) for text in value.values())


def _is_units(value: Any) -> bool:
    """Whether all units are known."""
    if not _is_texts(value) or not {*value} <= {*BASE_UNITS}:
        return False
    try:
        units = Units(value)
        return all(np.isfinite(units.display_unit(base).factor) for base in BASE_UNITS)
    except (ValueError, LookupError, ArithmeticError):
        return False


def _is_mapping(value: Any, *keys: str) -> bool:
    return isinstance(value, dict) and {*keys} <= {*value}


def _is_design(value: Any) -> bool:
    if not _is_mapping(value, "figures", "plans") or not isinstance(value["figures"], list):
        return False
    plans = value["plans"]
    keys = ("design", "parameters", "samples")
    return _is_mapping(plans) and all(_is_mapping(plan, *keys) for plan in plans.values())


def _is_criteria(value: Any) -> bool:
    return isinstance(value, list) and all(
        _is_mapping(criterion, "name", "limit") for criterion in value
    )


JSON_ATTRIBUTES: Mapping[str, tuple[str, Callable[[Any], bool]]] = {
    UNITS_ATTRIBUTE: ("units by their SI unit, as JSON", _is_units),
    TITLE_BLOCK: ("texts by their names, as JSON", _is_texts),
    CRITERIA: ("a list of criteria, as JSON", _is_criteria),
    FUNCTION_STATES: ("states of functions, as JSON", _is_mapping),
    DESIGN: ("the plans of a study, as JSON", _is_design),
}
