"""Every variable of a result says what it is and in which unit, for readers with xarray alone."""

import inspect
import json
import re
from pathlib import Path

import numpy as np
import pytest
import xarray as xr

import hydrosim as hs
from hydrosim.dofs import DOFS
from hydrosim.elements import ELEMENT_KINDS
from hydrosim.interface.backend import ResultBackend
from hydrosim.results.dataset import KIND, PURPOSE, REQUIRED_NAMES, ResultKind, kind_of
from hydrosim.results.output import fixed_coordinates
from hydrosim.results.runs_file import open_runs
from hydrosim.results.variables import describe_coordinates
from hydrosim.run.provenance import case_of
from hydrosim.statistics import effects
from hydrosim.statistics.explain import explain_run
from hydrosim.statistics.statistics import statistics
from hydrosim.study.many_runs import run_study
from hydrosim.study.sweep import load_study

ROOT = Path(__file__).parents[2]
CASES = sorted(
    path
    for path in ROOT.glob("cases/*/*.yaml")
    if "bodies:" in path.read_text() and "file: ../" not in path.read_text()
)
"""Cases that need no run of another."""
UNITS = ("units", "dof_units", "comment", "flag_values")
"""Attributes that say in which unit numbers are, or what codes mean."""
CASE = """
title: A block on a line
duration: 20 s
bodies: {block: {mass: 2 tonne, radii_of_gyration: [1 m, 1 m, 1 m], dofs: [surge, sway, yaw]}}
environment:
  water_depth: infinite
  waves:
    - {spectrum: jonswap, significant_height: 1 m, peak_period: 5 s, seed: 3, repeat_period: 200 s}
    - {spectrum: jonswap, significant_height: 1 m, peak_period: 9 s, seed: 4, repeat_period: 200 s}
forces:
  push: {type: applied_force, body: block, frame: earth, point: [0, 0, 0],
         time: [0 s, 5 s, 30 s], force: {surge: [0 kN, 2 kN, 1 kN]}}
  rope: {type: spring, body: block, point: [0 m, 0 m, 0 m], anchor: [-20 m, 0 m, 0 m],
         length: 19.9 m, stiffness: 10 kN/m, capacity: 5 kN}
solver: {method: rk4, step: 0.05 s}
output: {step: 0.5 s, impulses: true}
"""
STUDY = """
case: case.yaml
seeds: [7, 8]
parameters:
  forces.rope.stiffness: [10 kN/m, 20 kN/m]
  forces.rope.anchor: [[-20 m, 0 m, 0 m], [-20 m, 1 m, 0 m]]
  K2:
    keys:
      forces.rope.capacity: [5 kN, 6 kN]
      bodies.block.mass: [2 tonne, 3 tonne]
output: {channels: [speed.block]}
figures: {reach: {channel: position.block.surge, statistic: largest}}
"""


def undescribed(of: xr.Dataset) -> list[str]:
    """Variables without a long_name, and numbers that do not say their unit."""
    found = []
    for name, variable in of.variables.items():
        is_text = variable.dtype.kind in "OUS"
        if not variable.attrs.get("long_name"):
            found.append(f"{name} has no long_name")
        if not is_text and not any(key in variable.attrs for key in UNITS):
            found.append(f"{name} has no unit")
    return found


@pytest.fixture(scope="module")
def case(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("described") / "case.yaml"
    path.write_text(CASE)
    return path


@pytest.fixture(scope="module")
def study(case: Path) -> xr.Dataset:
    path = case.with_name("study.yaml")
    path.write_text(STUDY)
    run_study(load_study(path), case.with_name("study.nc"))
    return xr.load_dataset(case.with_name("study.nc"))


def test_every_variable_of_a_run_and_of_its_statistics_is_described(
    base_run: xr.Dataset, case: Path
) -> None:
    pulled = hs.simulate(hs.load_case(case))
    for run in (base_run, pulled):
        assert undescribed(run) == []
        assert undescribed(statistics(run, channels=["wave_elevation"])) == []
    assert undescribed(explain_run(pulled)) == []


LIMITS = """
case: heave.yaml
duration: 30 min
seeds: 1-20
criteria: {{heave: {{channel: position.sphere.heave, statistic: largest_absolute, limit: 1 m}}}}
operability: {{peak_periods: [6 s], heights: {{from: 0.5 m, to: 5 m, apart: 0.5 m}}}}
"""
HEAVE = f"extends: {ROOT}/cases/sphere/irregular.yaml\nbodies: {{sphere: {{dofs: [heave]}}}}\n"


@pytest.fixture(scope="module")
def results(case: Path, study: xr.Dataset) -> dict[str, xr.Dataset]:
    """Results of all kinds but runs, by kind, each read from its file."""
    folder = case.parent
    (folder / "heave.yaml").write_text(HEAVE)
    (folder / "limits.yaml").write_text(LIMITS.format())
    hs.simulate(case, output=folder / "run.nc")
    hs.export(folder / "run.nc", folder / "run.csv")
    hs.simulate_many([case] * 2, folder / "set.nc")
    run = hs.open_run(folder / "run.nc")
    run.hydrosim.extremes(output=folder / "statistics.nc")
    run.hydrosim.explain(output=folder / "explanation.nc")
    run.hydrosim.compare(folder / "run.csv", output=folder / "comparison.nc")
    hs.compare(folder / "study.nc", folder / "study.nc", output=folder / "comparison of sets.nc")
    hs.study(folder / "limits.yaml", output=folder / "operability.nc")
    hs.analyse(folder / "heave.yaml", output=folder / "analysis.nc")
    steps = {"methods": "rk4", "steps": "0.1,0.05", "tolerances": "1e-5"}
    hs.analyse(case, converge=True, output=folder / "convergence.nc", **steps)
    seeds = xr.concat([study] * 4, "run", data_vars="all", combine_attrs="override")
    seeds = seeds.isel(run=seeds.forces_rope_anchor.values == "A")
    seeds.hydrosim.extremes_over_seeds().to_netcdf(folder / "extremes over seeds.nc")
    kinds = [kind for kind in ResultKind if kind != ResultKind.RUN]
    return {kind: xr.load_dataset(folder / f"{kind}.nc", engine=ResultBackend) for kind in kinds}


def test_every_result_says_its_kind_and_describes_its_variables(
    results: dict[str, xr.Dataset],
) -> None:
    for kind, result in results.items():
        assert (kind, result.attrs["kind"]) == (kind, kind_of(result))
        assert (kind, undescribed(result)) == (kind, [])
        assert not any("." in str(name) for name in result.variables)


def test_results_without_a_kind_are_recognised_by_their_variables(
    results: dict[str, xr.Dataset],
) -> None:
    for kind in REQUIRED_NAMES.keys() - {ResultKind.RUN, ResultKind.STUDY}:
        earlier = results[kind].copy()
        del earlier.attrs[KIND]
        assert (kind, kind_of(earlier)) == (kind, kind)
        assert str(earlier.hydrosim.summary())
    assert kind_of(results[ResultKind.STUDY].isel(run=0)) == ""


@pytest.mark.parametrize("path", CASES, ids=lambda path: f"{path.parent.name}/{path.stem}")
def test_every_coordinate_of_a_case_is_described(path: Path) -> None:
    coords = xr.Dataset(coords=fixed_coordinates(hs.load_case(path).scene()))
    describe_coordinates(coords)
    assert undescribed(coords) == []


def test_every_variable_of_every_kind_is_described() -> None:
    for kind in ELEMENT_KINDS:
        for variable in kind.variables.values():
            assert variable.long_name
            assert variable.units or variable.flags


def test_units_stand_beside_the_degrees_of_freedom(base_run: xr.Dataset) -> None:
    surge = base_run.position.sel(body="barge", dof="surge")
    assert (surge.position_unit, surge.velocity_unit, surge.force_unit) == ("m", "m/s", "N")
    assert base_run.position_unit.sel(dof="roll") == "rad"
    names = {"position": "position", "velocity": "velocity", "force_mooring": "force"}
    for name, quantity in names.items():
        said = base_run[name].attrs["dof_units"].split(", ")
        assert base_run[name][f"{quantity}_unit"].values.tolist() == said
    assert list(base_run.position_unit.dof.values) == list(DOFS)


def test_statistics_say_the_unit_of_each(base_run: xr.Dataset) -> None:
    found = statistics(base_run)
    units = dict(zip(found.statistic.values, found.statistic_unit.values, strict=True))
    assert (units["period"], units["kurtosis"]) == ("s", "1")
    assert units["largest"] == "that of the channel"


def test_restart_data_are_told_from_results(base_run: xr.Dataset) -> None:
    results = base_run.filter_by_attrs(**{PURPOSE: lambda value: value != "restart"})
    restart = base_run.filter_by_attrs(**{PURPOSE: "restart"})
    assert {"state_value", "state_input", "fender_segment"} <= {*restart.data_vars}
    assert {"position", "fender_mode"} <= {*results.data_vars}
    assert not {*results.data_vars} & {*restart.data_vars}
    assert not any("state" in str(dim) for each in results.values() for dim in each.dims)


def test_a_study_is_selected_by_seed(study: xr.Dataset, case: Path) -> None:
    """There are two wave trains, and a seed of the study is that of both."""
    assert study.seed.dims == ("run",)
    own = study.set_xindex("seed").sel(seed=7)
    assert own.sizes["run"] == 8
    scenes = [hs.load_case(case).scene()] * 2
    runs = hs.simulate_many(scenes)
    assert (runs.seed.values.tolist(), runs.seed_2.values.tolist()) == ([3, 3], [4, 4])
    assert runs.sel(seed=3).sizes["run"] == 2
    document = case_of(runs, 1)
    assert re.findall(r"seed: (\d)", document) == ["3", "4"]


def test_parameters_keep_their_names_without_dots(study: xr.Dataset) -> None:
    assert study.forces_rope_stiffness.attrs == {
        "long_name": "forces.rope.stiffness",
        "key": "forces.rope.stiffness",
        "units": "N/m",
    }
    assert sorted({*study.K2.values}) == [5000.0, 6000.0]
    assert study.K2.attrs["units"] == "N"
    assert not any("." in str(name) for name in study.variables)
    assert sorted({*study.forces_rope_anchor.values}) == ["A", "B"]
    meaning = json.loads(study.forces_rope_anchor.attrs["letters"])
    assert "-20 m" in meaning["A"]
    assert "1 m" in meaning["B"]


def test_a_file_of_an_earlier_version_reads_alike(study: xr.Dataset, tmp_path: Path) -> None:
    """Its parameters were called by their keys, and lists were texts."""
    (new,) = effects.plans(study)
    earlier = study.drop_vars(["K2"])
    meaning = json.loads(earlier.forces_rope_anchor.attrs["letters"])
    texts = [meaning[letter] for letter in earlier.forces_rope_anchor.values.tolist()]
    earlier["forces_rope_anchor"] = ("run", np.array(texts, dtype=object))
    keys = {name: of.attrs["key"] for name, of in study.coords.items() if "key" in of.attrs}
    earlier = earlier.rename(keys)
    for name in keys.values():
        earlier[name].attrs = {k: v for k, v in earlier[name].attrs.items() if k == "units"}
    path = tmp_path / "earlier.nc"
    earlier.set_coords(list(keys.values())).to_netcdf(path)
    (old,) = effects.plans(open_runs(path))
    assert new.parameters == old.parameters
    for one, other in zip(effects.rows(new), effects.rows(old), strict=True):
        assert [*one.values.values()] == [*other.values.values()]
        assert one.spread == pytest.approx(other.spread, nan_ok=True)


def test_types_of_simulate_many_are_public() -> None:
    known = {*hs.__all__, "Iterable", "Mapping", "Sequence", "Callable", "PathLike", "Path"}
    known |= {"str", "int", "float", "bool", "object", "None", "xr", "Dataset", "Variable"}
    known |= {"pd", "DataFrame"}
    signature = inspect.signature(hs.simulate_many)
    texts = [str(p.annotation) for p in signature.parameters.values()]
    words = {word for text in texts for word in re.findall(r"\w+", text)}
    assert words <= known
