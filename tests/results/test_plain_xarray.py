"""Results as an xarray user meets them: seeds, parameters by name, plots with units, CF, and files
of earlier versions."""

from dataclasses import replace
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
import pytest
import xarray as xr

import hydrosim as hs
from hydrosim.compare.dataset import differences
from hydrosim.results.dataset import KIND, RESTART

CASE = """
title: A block on a line
duration: 10 s
bodies: {block: {mass: 2 tonne, radii_of_gyration: [1 m, 1 m, 1 m], dofs: [surge, yaw]}}
environment:
  water_depth: infinite
  waves:
    - {spectrum: jonswap, significant_height: 1 m, peak_period: 5 s, seed: 3, repeat_period: 200 s}
    - {spectrum: jonswap, significant_height: 1 m, peak_period: 9 s, seed: 4, repeat_period: 200 s}
forces:
  push: {type: applied_force, body: block, frame: earth, point: [0, 1, 0], force: {surge: 1 kN}}
  rope: {type: spring, body: block, point: [0 m, 0 m, 0 m], anchor: [-20 m, 0 m, 0 m],
         length: 19.9 m, stiffness: 10 kN/m}
solver: {method: rk4, step: 0.05 s}
output: {step: 0.5 s}
"""
STUDY = """
case: case.yaml
seeds: 1-3
parameters:
  rope:
    keys: {forces.rope.stiffness: [10 kN/m, 20 kN/m]}
    called: [soft, stiff]
  bodies.block.mass: [2 tonne, 3 tonne]
figures: {reach: {channel: position.block.surge, statistic: largest}}
"""
LATER = "extends: case.yaml\nduration: 15 s\ninitial: {run: run.nc}\n"
ELAPSED_TIME_REMARK = "Coordinate variable 'time' should have standard_name='time', found: 'None'"
"""All that the checker finds: times of a run have no date, which `hydrosim export` gives them."""


@pytest.fixture(autouse=True)
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    (tmp_path / "case.yaml").write_text(CASE)
    (tmp_path / "study.yaml").write_text(STUDY)
    (tmp_path / "later.yaml").write_text(LATER)
    monkeypatch.chdir(tmp_path)
    return tmp_path


def test_a_loop_over_seeds() -> None:
    scene = hs.load_case("case.yaml").scene()
    seas = [scene.environment.with_seed(seed) for seed in (5, 6, 7)]
    cases = [replace(scene, environment=sea) for sea in seas]
    waves = hs.simulate_many(cases, variables=["wave_elevation"]).wave_elevation
    largest = {seed: float(waves.sel(seed=seed).max()) for seed in (5, 6, 7)}
    assert len({*largest.values()}) == 3


def test_a_study_of_parameters_for_pandas() -> None:
    runs = hs.study("study.yaml", output="study.nc").dataset
    table = runs[["reach"]].to_dataframe()
    means = table.groupby(["rope", "bodies_block_mass"]).reach.mean().unstack()
    assert (list(means.index), list(means.columns)) == (["soft", "stiff"], [2000.0, 3000.0])
    assert runs.bodies_block_mass.attrs["units"] == "kg"
    assert runs.sel(seed=2).sizes["run"] == 4


def test_plots_have_units() -> None:
    run = hs.simulate("case.yaml")
    (line,) = run.force_rope.sel(body="block", dof="surge").plot()
    assert line.axes.get_ylabel().replace("\n", " ").endswith("[N or N m]")
    assert line.axes.get_title().startswith("body = block, dof = surge, position_unit = m")
    (line,) = run.spring_tension.sel(spring="rope").plot(ax=plt.figure().subplots())
    assert (line.axes.get_xlabel(), line.axes.get_ylabel()) == (
        "time since the start [s]",
        "tension [N]",
    )


def test_a_file_with_all_in_one_group_is_shown_and_continued(folder: Path) -> None:
    """As earlier versions wrote it, which stated no kind."""
    run = hs.simulate("case.yaml", output="run.nc")
    later = hs.simulate("later.yaml")
    (folder / "run.nc").unlink()
    del run.attrs[KIND]
    run.to_netcdf("run.nc")
    assert "state" in xr.open_dataset("run.nc").dims
    read = hs.open_run("run.nc")
    assert differences(read, run) == []
    assert repr(read.hydrosim) == "<run: A block on a line, complete>"
    assert read.hydrosim.report("page.html").exists()
    assert differences(hs.simulate("later.yaml"), later) == []


def test_a_file_has_restart_data_apart() -> None:
    run = hs.simulate("case.yaml", output="run.nc")
    with xr.open_dataset("run.nc") as results, xr.open_dataset("run.nc", group=RESTART) as restart:
        assert {"state_value", "state_kind", "state_input"} <= {*restart.variables}
        assert not any(str(dim).startswith("state") for dim in results.dims)
        assert {*results.variables} | {*restart.variables} == {*run.variables}
        with pytest.raises(hs.InputError, match="read its file with hs"):
            hs.simulate(replace(hs.load_case("case.yaml").scene(), initial=hs.Start(results)))
    tree = xr.open_datatree("run.nc")
    np.testing.assert_array_equal(tree["restart/state_value"].values, run.state_value.values)


@pytest.mark.extras
def test_a_run_and_a_set_pass_the_checker() -> None:
    runner = pytest.importorskip("compliance_checker.runner")
    hs.simulate("case.yaml", output="run.nc")
    hs.study("study.yaml", output="study.nc")
    runner.CheckSuite.load_all_available_checkers()
    for name in ("run.nc", "study.nc"):
        suite = runner.CheckSuite()
        scores = suite.run_all(suite.load_dataset(name), ["cf:1.11"])
        groups, errors = scores["cf:1.11"]
        # the checker subtracts labels, which are texts
        assert {*errors} <= {"check_coordinate_variables_strict_monotonicity"}
        whole = {True: (1, 1), False: (0, 1)}
        points = [(group, whole.get(group.value, group.value)) for group in groups]
        remarks = {text for group, (got, most) in points if got < most for text in group.msgs}
        assert (name, remarks) == (name, {ELAPSED_TIME_REMARK})
