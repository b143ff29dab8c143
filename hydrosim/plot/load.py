"""`open_run`: reads the dataset of a run from its file."""

from __future__ import annotations

from pathlib import Path

import xarray as xr

from hydrosim.errors import InputError
from hydrosim.results.netcdf import RUN_FILE_HINT, read_run


def open_run(path: str | Path) -> xr.Dataset:
    """Dataset of the run in the netCDF file ``path``, in memory. Raises InputError if the file is
    missing, is not netCDF, is not the result of a run, or has fewer than two records."""
    run = read_run(Path(path))
    if run.sizes["time"] < 2:
        raise InputError(
            f"{path}: has fewer than two recorded times, so there is nothing to draw;"
            f" {RUN_FILE_HINT}."
        )
    return run
