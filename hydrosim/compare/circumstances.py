"""Differences between two sets of runs that are not numbers to test: durations, and codes such as
the basis of extremes."""

from __future__ import annotations

import re

import numpy as np
import xarray as xr

from hydrosim.results.runs_file import RUN

CASE = "case_resolved"
DURATION = re.compile(r"^duration: (\S+)$", re.MULTILINE)


def is_code(variable: xr.DataArray) -> bool:
    """Whether values are codes for words (CF conventions 1.11, section 3.5), which have no mean."""
    return "flag_values" in variable.attrs or str(variable.name).endswith("_basis")


def codes_apart(ours: xr.Dataset, theirs: xr.Dataset, paired: bool) -> tuple[str, ...]:
    """Codes that differ in a pair of runs. If runs are not ``paired``, codes whose sets of values
    differ."""
    both = [name for name in map(str, ours.data_vars) if name in theirs and is_code(ours[name])]
    return tuple(n for n in both if _differ(ours[n].values, theirs[n].values, paired))


def durations_apart(ours: xr.Dataset, theirs: xr.Dataset, paired: bool) -> tuple[str, ...]:
    """Durations of ours and theirs as text, if they differ and both files state them."""
    one, other = _durations(ours), _durations(theirs)
    if not one.size or not other.size or not _differ(one, other, paired):
        return ()
    return _range_text(one), _range_text(other)


def _differ(ours: np.ndarray, theirs: np.ndarray, paired: bool) -> bool:
    if not paired:
        ours, theirs = np.unique(ours), np.unique(theirs)
    return not np.array_equal(ours, theirs, equal_nan=True)


def _durations(runs: xr.Dataset) -> np.ndarray:
    """Duration of each run [s] (n,) from its case; empty if a case does not state it."""
    cases = runs[CASE].values.tolist() if CASE in runs and runs[CASE].dims == (RUN,) else []
    found = [DURATION.search(case) for case in cases]
    return np.array([float(one[1]) for one in found if one] if all(found) else [])


def _range_text(durations: np.ndarray) -> str:
    low, high = durations.min(), durations.max()
    return f"{low:g} s" if low == high else f"{low:g} to {high:g} s"
