"""`open_run`: the dataset of a run from its file."""

from __future__ import annotations

from pathlib import Path

import xarray as xr

from hydrosim.errors import InputError

REMEDY = "expected the result of `hydrosim run`, such as run.nc"
NEEDED = ("position", "wave_elevation", "energy_kinetic", "energy_residual")


def open_run(path: Path) -> xr.Dataset:
    """The dataset of a run in the netCDF file ``path``, in memory; raises InputError if the file
    is missing, is not netCDF or is not the result of a run with at least two records."""
    if path.is_dir():
        raise InputError(f"{path}: is a directory; {REMEDY}.")
    if not path.exists():
        raise InputError(f"{path}: there is no such file; {REMEDY}.")
    try:
        run = xr.load_dataset(path, engine="netcdf4")
    except (OSError, ValueError) as error:
        raise InputError(f"{path}: cannot be read as netCDF ({error}); {REMEDY}.") from None
    missing = [name for name in NEEDED if name not in run]
    if missing:
        raise InputError(f"{path}: is netCDF without {', '.join(missing)}; {REMEDY}.")
    if run.sizes["time"] < 2:
        raise InputError(f"{path}: has fewer than two records, nothing to draw; {REMEDY}.")
    return run
