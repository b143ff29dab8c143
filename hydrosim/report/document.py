"""`report_of`: the document of a result, whatever kind of result it is."""

from __future__ import annotations

from pathlib import Path

import xarray as xr

from hydrosim.report.blocks import Document
from hydrosim.report.limits import is_limits, limits_document
from hydrosim.report.replay import replay_document
from hydrosim.report.run import run_document
from hydrosim.report.study import study_document
from hydrosim.results.output import read
from hydrosim.results.runs_file import open_runs


def report_of(path: Path) -> Document:
    """What there is to show of the result in a file, of a run, of many or of limits of operation;
    InputError where it is none."""
    if (runs := open_runs(path)) is not None:
        with runs:
            return study_document(runs)
    limits = _limits(path)
    return run_document(read(path)) if limits is None else limits_document(limits)


def replay_of(path: Path) -> Document:
    """The replay of the run in a file; InputError where it is none."""
    return replay_document(read(path))


def _limits(path: Path) -> xr.Dataset | None:
    """Limits of operation; None where the file is anything else."""
    if not path.is_file():
        return None
    try:
        with xr.open_dataset(path, engine="netcdf4") as found:
            return found.load() if is_limits(found) else None
    except (OSError, ValueError, RuntimeError):
        return None
