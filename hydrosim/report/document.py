"""`report_of`: document of a result of any kind."""

from __future__ import annotations

import os
from collections.abc import Callable
from pathlib import Path

import xarray as xr

from hydrosim.errors import InputError
from hydrosim.presentation.document import Document
from hydrosim.report.replay import replay_document
from hydrosim.report.run import run_document
from hydrosim.results.netcdf import read_run
from hydrosim.results.runs_file import RUN, is_of_runs, open_runs
from hydrosim.results.validation import check_result
from hydrosim.wording.compared_studies import is_of_studies, studies_document
from hydrosim.wording.comparison import comparison_document, is_comparison
from hydrosim.wording.limits import is_limits, limits_document
from hydrosim.wording.study import study_document

RESULT_KINDS: tuple[tuple[Callable[[xr.Dataset], bool], Callable[[xr.Dataset], Document]], ...] = (
    (is_of_runs, study_document),
    (is_limits, limits_document),
    (is_comparison, comparison_document),
    (is_of_studies, studies_document),
)
"""Kinds of results besides runs."""
EXPECTED_RESULTS = "expected the result of `hydrosim run`, `sweep`, `operability` or `compare`"


def report_of(path: Path) -> Document:
    """Document that presents the result in the netCDF file ``path``. The result is a run, many
    runs, limits of operation or a comparison. Raises InputError if the file holds none of
    these."""
    other = _result_document(path)
    return run_document(read_run(path, EXPECTED_RESULTS)) if other is None else other


def replay_of(path: Path) -> Document:
    """Replay of the run in a file. Raises InputError if the file has no run."""
    if (runs := open_runs(path)) is not None:
        raise InputError(
            f"{path}: holds {runs.sizes[RUN]} runs, without their motions over time; expected the"
            " result of `hydrosim run`. `hydrosim report` shows studies."
        )
    return replay_document(read_run(path))


def _result_document(path: Path) -> Document | None:
    """Document of a result that is not a run; None if the file is of another kind."""
    if not os.path.isfile(path):
        return None
    try:
        found = xr.open_dataset(path, engine="netcdf4", decode_times=False)
    except (OSError, ValueError, RuntimeError):
        return None
    with found:
        for is_one, made in RESULT_KINDS:
            if is_one(found):
                check_result(path, found)
                return made(found)
    return None
