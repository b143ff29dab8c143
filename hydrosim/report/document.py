"""`report_of`: the document of a result, whatever kind of result it is."""

from __future__ import annotations

import os
from collections.abc import Callable
from pathlib import Path

import xarray as xr

from hydrosim.errors import InputError
from hydrosim.presentation.document import Document
from hydrosim.report.replay import replay_document
from hydrosim.report.run import run_document
from hydrosim.results.netcdf import read
from hydrosim.results.runs_file import RUN, is_of_runs, open_runs
from hydrosim.wording.compared_studies import is_of_studies, studies_document
from hydrosim.wording.comparison import comparison_document, is_comparison
from hydrosim.wording.limits import is_limits, limits_document
from hydrosim.wording.study import study_document

KINDS: tuple[tuple[Callable[[xr.Dataset], bool], Callable[[xr.Dataset], Document]], ...] = (
    (is_of_runs, study_document),
    (is_limits, limits_document),
    (is_comparison, comparison_document),
    (is_of_studies, studies_document),
)
"""What results there are besides those of a run."""
EXPECTED = "expected the result of `hydrosim run`, `sweep`, `operability` or `compare`"


def report_of(path: Path) -> Document:
    """What there is to show of the result in a file, of a run, of many, of limits of operation or
    of a comparison; InputError where it is none."""
    other = _other(path)
    return run_document(read(path, EXPECTED)) if other is None else other


def replay_of(path: Path) -> Document:
    """The replay of the run in a file; InputError where it is none."""
    if (runs := open_runs(path)) is not None:
        raise InputError(
            f"{path}: holds {runs.sizes[RUN]} runs, without their motions over time; expected the"
            " result of `hydrosim run`. hydrosim report shows a study."
        )
    return replay_document(read(path))


def _other(path: Path) -> Document | None:
    """The document of a result that is none of a run; None where the file is anything else."""
    if not os.path.isfile(path):
        return None
    try:
        found = xr.open_dataset(path, engine="netcdf4", decode_times=False)
    except (OSError, ValueError, RuntimeError):
        return None
    with found:
        return next((made(found) for is_one, made in KINDS if is_one(found)), None)
