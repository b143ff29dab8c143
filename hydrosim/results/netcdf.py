"""The netCDF file of a run: written whole, and read only where it is one."""

from __future__ import annotations

from typing import TYPE_CHECKING

from hydrosim.documents.files import no_file
from hydrosim.errors import InputError
from hydrosim.outputs import as_output, content

if TYPE_CHECKING:
    from pathlib import Path

    import xarray as xr

    from hydrosim.outputs import Output

NEEDED = ("position", "wave_elevation", "energy_kinetic", "energy_residual")
FORMAT, LATEST = "hydrosim run", 2
"""Files of runs say "hydrosim run 2"; those of the first format say nothing."""
REMEDY = "expected the result of `hydrosim run`, such as run.nc"
SHOWN = ("limits of ", "comparison of ")  # what is no run, and has a report


def write(dataset: xr.Dataset, target: Path | Output) -> None:
    """Write netCDF; the file appears under its name only when it is complete. Raises as `Output`
    does where it may not be written."""
    output = as_output(target, "result")
    with output.written() as path:
        marked = dataset.assign_attrs(output.attributes)
        marked.to_netcdf(path, engine="netcdf4", format="NETCDF4")


def read(path: Path, expected: str = REMEDY) -> xr.Dataset:
    """The dataset of a run in the netCDF file ``path``, in memory; raises InputError if the file
    is missing, is not netCDF or is not the result of a run; it says what is ``expected``."""
    if reason := no_file(path):
        raise InputError(f"{path}: {reason}; {expected}.")
    import xarray as xr  # slow to load, and few cases start from a run

    try:
        run = xr.load_dataset(path, engine="netcdf4")
    except (OSError, ValueError, RuntimeError) as error:
        raise InputError(f"{path}: cannot be read as netCDF ({error}); {expected}.") from None
    missing = [name for name in NEEDED if name not in run]
    if missing:
        found = f"is netCDF without {', '.join(missing)}"
        if (made := content(path) or "").startswith(SHOWN):
            found = f"holds the {made}, which `hydrosim report` shows"
        elif "run" in run.dims:
            found = f"holds {run.sizes['run']} runs without status, which those of a study have"
        raise InputError(f"{path}: {found}; {expected}.")
    _require_known(path, str(run.attrs.get("format", "")))
    return run


def _require_known(path: Path, found: str) -> None:
    """Refuses files of later versions."""
    number = found.removeprefix(FORMAT).strip()
    if number.isdecimal() and int(number) > LATEST:
        expected = f"expected {FORMAT} {LATEST} or older; read it with a later version of hydrosim"
        raise InputError(f"{path}: has the format {found}; {expected}.")


def status_of(path: Path) -> str | None:
    """How the run in a file has ended; None if there is none."""
    import xarray as xr  # slow to load

    try:
        with xr.open_dataset(path, engine="netcdf4") as run:
            return str(run.attrs.get("status"))
    except (OSError, ValueError, RuntimeError):
        return None
