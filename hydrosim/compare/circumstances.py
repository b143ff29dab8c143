"""What two sets of runs differ in that is no number to test: their durations, and codes such as
what extremes are by."""

from __future__ import annotations

import re

import numpy as np
import xarray as xr

from hydrosim.results.runs_file import RUN

CASE = "case_resolved"
DURATION = re.compile(r"^duration: (\S+)$", re.MULTILINE)


def is_code(variable: xr.DataArray) -> bool:
    """Whether values stand for words (CF conventions 1.11, section 3.5), so have no mean."""
    return "flag_values" in variable.attrs or str(variable.name).endswith("_basis")


def codes_apart(ours: xr.Dataset, theirs: xr.Dataset, paired: bool) -> tuple[str, ...]:
    """The codes that differ in a pair of runs; where runs are no ``paired`` ones, those of which
    other values occur."""
    both = [name for name in map(str, ours.data_vars) if name in theirs and is_code(ours[name])]
    return tuple(n for n in both if _apart(ours[n].values, theirs[n].values, paired))


def durations_apart(ours: xr.Dataset, theirs: xr.Dataset, paired: bool) -> tuple[str, ...]:
    """How long ours and theirs last, in words, where that differs and both files say it."""
    one, other = _durations(ours), _durations(theirs)
    if not one.size or not other.size or not _apart(one, other, paired):
        return ()
    return _said(one), _said(other)


def _apart(ours: np.ndarray, theirs: np.ndarray, paired: bool) -> bool:
    if not paired:
        ours, theirs = np.unique(ours), np.unique(theirs)
    return not np.array_equal(ours, theirs, equal_nan=True)


def _durations(runs: xr.Dataset) -> np.ndarray:
    """The duration of each run [s] (n,), as its case says it; empty if one does not."""
    cases = runs[CASE].values.tolist() if CASE in runs and runs[CASE].dims == (RUN,) else []
    found = [DURATION.search(case) for case in cases]
    return np.array([float(one[1]) for one in found if one] if all(found) else [])


def _said(durations: np.ndarray) -> str:
    low, high = durations.min(), durations.max()
    return f"{low:g} s" if low == high else f"{low:g} to {high:g} s"
