"""`RunData` reads as the `xarray.Dataset` of the same content, and writes the same file."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import netCDF4
import numpy as np
import pytest
import xarray as xr

from hydrosim.results.run_data import RunData, RunVariable, as_xarray, new_run_data

UNITS = ["N", "N m"]
FORCE = np.array(
    [[[1.0, -2.0], [np.nan, 4.0]], [[5.0, 6.0], [-7.0, 0.0]], [[9.0, 8.0], [1.0, 2.0]]]
)


def new_run() -> Any:
    """A run of three records, with coordinates of all kinds."""
    data = {
        "force": (("time", "body", "dof"), FORCE),
        "mode": (("time", "body"), np.array([[0, 1], [2, 0], [1, 1]], np.int8)),
    }
    coords = {
        "time": ("time", np.array([0.0, 0.5, 1.0]), {"units": "s"}),
        "body": ("body", ["barge", "topside"], {"long_name": "body"}),
        "dof": ("dof", ["surge", "yaw"]),
        "unit": ("dof", UNITS),
        "begin": ((), 2.5),
        "place": ("probe", [1.0, 2.0]),
    }
    run: Any = new_run_data(data, coords)
    run.attrs["title"] = "three records"
    run["force"].attrs["units"] = "N"
    run["error"] = (("body", "dof"), FORCE[0])
    return run.assign_coords(stage=["open"]).assign({"reached": (("stage",), np.array([1.0]))})


QUESTIONS: list[Callable[[Any], Any]] = [
    lambda run: run.force,
    lambda run: run.force.sel(body="barge", dof="yaw"),
    lambda run: run.force.sel(body=["topside", "barge"]),
    lambda run: run.force.sel(body=run.body == "topside"),
    lambda run: run.force.sel(body=["topside"]).sel(body="topside"),
    lambda run: run.force.sel(time=slice(0.5, 1.0)),
    lambda run: run.force.isel(time=-1),
    lambda run: run.force.isel(time=slice(1, None), dof=[1]),
    lambda run: run.force.isel(body=np.array([True, False])),
    lambda run: run.force[1, :, 0],
    lambda run: run.force["unit"],
    lambda run: run.force.isel(dof=[1])["unit"],
    lambda run: run.force.transpose("dof", ..., "time"),
    lambda run: run.force.min(),
    lambda run: run.force.max("time"),
    lambda run: run.force.any("body"),
    lambda run: run.force.mean("time"),
    lambda run: run.force.clip(max=0.0),
    lambda run: run.force.copy(data=2.0 * FORCE),
    lambda run: run.force > 1.0,
    lambda run: np.abs(run.force) - run.force,
    lambda run: run.force - run.error,
    lambda run: run.force.isel(body=[1]) + run.force,
    lambda run: run.force.max("time") - run.force.min("time"),
    lambda run: run.mode == 1,
    lambda run: run.sel(body="topside").force,
    lambda run: run.isel(time=[0, 2]).mode,
    lambda run: run[["mode"]].body,
    lambda run: run.assign_attrs(title="other").force,
    lambda run: run.force.groupby("unit").sum(),
]


@pytest.mark.parametrize("ask", QUESTIONS)
def test_it_answers_as_xarray_does(ask: Callable[[Any], Any]) -> None:
    answer, expected = ask(new_run()), ask(as_xarray(new_run()))
    assert answer.dims == expected.dims
    np.testing.assert_array_equal(answer.values, expected.values)
    if isinstance(answer, RunVariable):
        xr.testing.assert_equal(answer._to_xarray(), expected)


def test_names_sizes_and_order_are_those_of_xarray() -> None:
    run = new_run()
    dataset = as_xarray(run)
    assert isinstance(run, RunData)
    assert as_xarray(dataset) is dataset
    assert [*run.variables] == [*dataset.variables]
    assert [*run.data_vars] == [*dataset.data_vars]
    assert {*run.coords} == {*dataset.coords}
    assert {*run[["error"]].variables} == {*dataset[["error"]].variables}
    assert run.sizes == dataset.sizes
    assert "force" in run
    assert "unknown" not in run
    with pytest.raises(AttributeError, match="unknown"):
        _ = run.unknown
    with pytest.raises(KeyError):
        run.force.sel(body="unknown")


def test_the_file_is_that_of_xarray(tmp_path: Path) -> None:
    run = new_run()
    run.to_netcdf(tmp_path / "own.nc")
    as_xarray(run).to_netcdf(tmp_path / "xarray.nc", engine="netcdf4", format="NETCDF4")
    assert contents(tmp_path / "own.nc") == contents(tmp_path / "xarray.nc")


def test_truth_is_stored_by_xarray(tmp_path: Path) -> None:
    run = new_run().assign({"open": (("time",), np.array([True, False, True]))})
    run.to_netcdf(tmp_path / "run.nc")
    with xr.open_dataset(tmp_path / "run.nc") as dataset:
        assert dataset.open.dtype == bool


def contents(path: Path) -> list[object]:
    """All that a file holds, in its order."""
    with netCDF4.Dataset(path) as file:
        file.set_auto_maskandscale(False)
        sizes = [(name, len(dim)) for name, dim in file.dimensions.items()]
        variables = [
            (name, x.dimensions, str(x.dtype), x.chunking(), repr(x.__dict__), x[...].tobytes())
            if x.dtype is not str
            else (name, x.dimensions, repr(x.__dict__), x[...].tolist())
            for name, x in file.variables.items()
        ]
        return [repr(file.__dict__), sizes, variables]
