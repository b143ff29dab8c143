"""The engine "hydrosim" of xarray: `xr.open_dataset(FILE, engine="hydrosim")`.

xarray loads this module, as an entry point of the package, before it opens its first file. So
`run.hydrosim` is there whatever engine reads the file.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import xarray as xr
from xarray.backends import BackendEntrypoint

from hydrosim.interface import accessor  # noqa: F401  it registers `run.hydrosim`


class ResultBackend(BackendEntrypoint):
    """Opens the netCDF of any command."""

    description = "Results of hydrosim: runs, studies, limits of operation, comparisons, analyses"
    open_dataset_parameters = ("filename_or_obj", "drop_variables")

    def open_dataset(
        self,
        filename_or_obj: Any,
        *,
        drop_variables: str | Iterable[str] | None = None,
        **_: Any,
    ) -> xr.Dataset:
        """Dataset that reads from the file when asked; times are in seconds. Runs of a set are
        selected by ``sel(seed=7)``."""
        from hydrosim.results.runs_file import index_by_seed  # slow to load with every xarray

        result = xr.open_dataset(
            filename_or_obj, engine="netcdf4", decode_times=False, drop_variables=drop_variables
        )
        return index_by_seed(result)
