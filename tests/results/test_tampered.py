"""Results that were changed after they were written are refused with the name of what is wrong."""

import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any

import netCDF4
import numpy as np
import pytest
import xarray as xr
from scenes import block, scene

import hydrosim as hs
from hydrosim.cli.terminal import tell_absent_variables
from hydrosim.errors import InputError
from hydrosim.report.document import replay_of, report_of
from hydrosim.results import dataset
from hydrosim.results.runs_file import open_runs
from hydrosim.simulation import open_run

Change = Callable[[netCDF4.Dataset], None]


@pytest.fixture(scope="module")
def written(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A run with all attributes that are JSON."""
    path = tmp_path_factory.mktemp("runs") / "run.nc"
    run = hs.simulate(scene(block(2.0), {}, 2.0, 0.1))
    attributes = {"units_read": '{"N": "kN"}', "title_block": '{"author": "me"}'}
    dataset.write_run(run.assign_attrs(attributes, criteria_asked="[]"), path)
    return path


def attribute(name: str, text: str) -> Change:
    return lambda file: file.setncattr(name, text)


def values(name: str, value: float) -> Change:
    def change(file: netCDF4.Dataset) -> None:
        file[name][...] = value

    return change


def one_unit(file: netCDF4.Dataset) -> None:
    for variable in file.variables.values():
        if "dof_units" in variable.ncattrs():
            variable.setncattr("dof_units", "m")


def last_time(file: netCDF4.Dataset) -> None:
    file["time"][-1] = np.nan


def same_names(file: netCDF4.Dataset) -> None:
    file["dof"][:] = np.full(6, "heave", object)


def other_names(file: netCDF4.Dataset) -> None:
    file["dof"][0] = "lift"


TAMPERED: dict[str, tuple[Change, str]] = {
    "no JSON": (attribute("units_read", '{"N": "kN"}x'), "attribute units_read: found "),
    "no unit": (attribute("units_read", '{"N": "furlong"}'), "expected units by their SI unit"),
    "no base": (attribute("units_read", '{"q": "kN"}'), "expected units by their SI unit"),
    "a list": (attribute("title_block", "[1]"), "attribute title_block: found '[1]'; expected te"),
    "numbers": (attribute("title_block", '{"author": 3}'), "expected texts by their names, as JS"),
    "nested": (attribute("criteria_asked", "[" * 10**5), "expected a list of criteria, as JSON"),
    "criteria": (attribute("criteria_asked", '[{"name": "x"}]'), "expected a list of criteria"),
    "one unit": (one_unit, "found 1 units; expected 6, one for each degree of freedom"),
    "same names": (same_names, "dof: found 'heave' twice; expected each once"),
    "other names": (other_names, "dof: found lift, sway, heave, roll, pitch, yaw; expected deg"),
    "infinite": (values("energy_residual", np.inf), "energy_residual: found an infinite value"),
    "NaN": (values("position", np.nan), "position: found 126 values that are no numbers"),
    "huge": (values("position", 1e308), "position: found a value above 1e+100; expected one that"),
    "constant": (values("time", 0.0), "time: found 0 s after 0 s; expected times that rise"),
    "last time": (last_time, "time: found values that are no times; expected seconds"),
}


@pytest.mark.parametrize("name", TAMPERED)
@pytest.mark.parametrize("read", [dataset.read_run, open_run, report_of, replay_of])
def test_tampered_runs_are_refused(
    written: Path, tmp_path: Path, name: str, read: Callable[[Path], Any]
) -> None:
    change, said = TAMPERED[name]
    path = tmp_path / "run.nc"
    shutil.copy(written, path)
    read(path)
    with netCDF4.Dataset(path, "a") as file:
        change(file)
    with pytest.raises(InputError) as caught:
        read(path)
    text = str(caught.value)
    assert text.startswith(f"{path}: ")
    assert said in text
    assert text.endswith("The file was changed after it was written: make the result again.")


@pytest.mark.parametrize("design", ["{}x", "[]", '{"figures": [], "plans": {"": {}}}'])
def test_tampered_sets_of_runs_are_refused(tmp_path: Path, design: str) -> None:
    path = tmp_path / "runs.nc"
    hs.simulate_many([scene(block(2.0), {}, 2.0, 0.1)] * 2, workers=1, output=path).close()
    found = open_runs(path)
    assert found is not None
    found.close()
    with netCDF4.Dataset(path, "a") as file:
        file.setncattr("design", design)
    with pytest.raises(InputError, match=r"attribute design: found .*; expected the plans of a"):
        open_runs(path)


def test_sets_of_runs_with_the_same_names_are_refused(tmp_path: Path) -> None:
    path = tmp_path / "runs.nc"
    hs.simulate_many([scene(block(2.0), {}, 2.0, 0.1)] * 2, workers=1, output=path).close()
    with netCDF4.Dataset(path, "a") as file:
        file["dof"][...] = np.full(file["dof"].shape, "heave", object)
    with pytest.raises(InputError, match=r"dof: found 'heave' twice; expected each once"):
        open_runs(path)


@pytest.mark.parametrize("look", [lambda run: run.slip, lambda run: run["slip"]])
def test_a_variable_that_a_command_lacks_is_told(
    written: Path, look: Callable[[xr.Dataset], object]
) -> None:
    run = dataset.read_run(written)
    with (
        pytest.raises(InputError, match=r"run\.nc: found no variable slip, which .*was changed"),
        tell_absent_variables([written]),
    ):
        look(run)


def test_other_errors_of_a_command_stay() -> None:
    nothing: dict[str, int] = {}
    with pytest.raises(KeyError, match="slip"), tell_absent_variables([Path("run.nc")]):
        nothing["slip"]
