"""Two results are identical to the bit, or each difference that is planted is named."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from command_line import command, files
from recorded_runs import made_run

from hydrosim.compare.dataset import differences, read_result
from hydrosim.errors import InputError

RUN = made_run()


def with_value(name: str, value: float) -> xr.Dataset:
    """The run with one value of a variable changed, the last."""
    run = RUN.copy(deep=True)
    run[name].values[-1] = value
    return run


def with_attribute(run: xr.Dataset, name: str, value: object) -> xr.Dataset:
    return run.assign_attrs({name: value})


PLANTED: dict[str, tuple[xr.Dataset, str]] = {
    "a value by one bit": (
        with_value("wave_elevation", np.nextafter(RUN.wave_elevation.values[-1], 9.0)),
        "wave_elevation: 1 of 3001 values differ, first ",
    ),
    "not a number": (with_value("energy_kinetic", np.nan), "energy_kinetic: 1 of 3001 values"),
    "a negative zero": (with_value("energy_residual", -0.0), "first 0.0 and -0.0 at time 3000"),
    "a whole number": (with_value("fender_mode", 2), "fender_mode: "),
    "a coordinate": (RUN.assign_coords(dof=list("abcdef")), "dof: 6 of 6 values differ"),
    "single precision": (
        RUN.assign(wave_elevation=RUN.wave_elevation.astype(np.float32)),
        "wave_elevation: types float64 and float32",
    ),
    "a shorter run": (RUN.isel(time=slice(3000)), "time: time 3001 and time 3000"),
    "another order": (RUN.transpose("dof", ...), "position: time 3001, body 1, dof 6 and "),
    "one variable less": (RUN.drop_vars("force_lift"), "force_lift: only in the first"),
    "an attribute": (with_attribute(RUN, "status", "failed"), "status: complete and failed"),
    "an attribute more": (with_attribute(RUN, "seeds", [1]), "seeds: only in the second"),
    "a unit": (
        RUN.assign(wave_elevation=RUN.wave_elevation.assign_attrs(units="mm")),
        "wave_elevation: attribute units: m and mm",
    ),
}


@pytest.mark.parametrize("what", PLANTED)
def test_a_planted_difference_is_named(what: str) -> None:
    changed, told = PLANTED[what]
    assert any(told in line for line in differences(RUN, changed)), differences(RUN, changed)


def test_a_result_is_identical_to_itself_in_memory_and_in_a_file(tmp_path: Path) -> None:
    """Also where something is not a number, and where both were made at other times."""
    run = with_attribute(with_value("energy_kinetic", np.nan), "seeds", [1])
    run.assign_attrs(wall_time=1.0, host="here", history="now").to_netcdf(tmp_path / "run.nc")
    other = run.assign_attrs(wall_time=2.0, date_created="today")
    assert differences(read_result(tmp_path / "run.nc"), other) == []
    changed = with_attribute(other, "case", "another text")
    assert differences(other, changed) == ["attribute case: only in the second"]
    assert differences(other, changed, ignored=["case"]) == []


def test_a_file_that_is_no_result(tmp_path: Path) -> None:
    (tmp_path / "run.nc").write_text("no")
    with pytest.raises(InputError, match=r"run\.nc: cannot be read as netCDF"):
        read_result(tmp_path / "run.nc")
    with pytest.raises(InputError, match="there is no such file"):
        read_result(tmp_path / "other.nc")


@pytest.fixture
def compared(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> Callable[..., tuple[int, str]]:
    """Exit code and text of the command on two files; it writes nothing."""
    monkeypatch.chdir(tmp_path)
    RUN.to_netcdf("one.nc")
    RUN.assign_attrs(wall_time=2.0).to_netcdf("same.nc")
    made_run(seed=2).to_netcdf("other.nc")
    hydrosim = command(monkeypatch, capsys, "compare", "--exact")

    def run(*arguments: str) -> tuple[int, str]:
        before = files(tmp_path)
        result = hydrosim(*arguments)
        assert files(tmp_path) == before
        return result.code, result.out

    return run


def test_the_command(compared: Callable[..., tuple[int, str]]) -> None:
    code, text = compared("one.nc", "same.nc")
    assert code == 0
    assert "identical: 16 variables and 3 attributes, apart from date_created, h" in text
    code, text = compared("one.nc", "other.nc")
    assert code == 1
    assert "position: 18006 of 18006 values differ" in text
    assert compared("one.nc", "other.nc", "--ignore", "position")[0] == 1
