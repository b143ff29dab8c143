"""A run made again from the case that it holds is identical, but for the text of the case."""

import shutil
from pathlib import Path
from typing import Any

import pytest
import xarray as xr
from command_line import command
from markers import few

import hydrosim as hs
from hydrosim.compare.dataset import differences
from hydrosim.run.provenance import case_of
from hydrosim.study.many_runs import run_study
from hydrosim.study.sweep import load_study

CASES = Path(__file__).parents[2] / "cases"
TEXTS = {"case", "case_file", "case_resolved", "units_read"}
"""What is of the text: the repeated case is in SI, and writes no units to read results in."""
SHORT: dict[str, Any] = {"duration": "20 s", "solver.unstable": "warn"}
SHIPPED = sorted(str(path.relative_to(CASES).with_suffix("")) for path in CASES.glob("*/*.yaml"))
OTHERS: dict[str, dict[str, Any]] = {
    "with probes and states": {
        "output": {"states": True, "wave_probes": {"bow": [70, 0]}},
        "environment.waves": [
            {"spectrum": "none", "heading": "3 deg"},
            {"spectrum": "jonswap", "significant_height": 2, "peak_period": "14 s", "seed": 3},
        ],
    },
    "adaptive, with constant radiation": {
        "solver": {"method": "dopri5", "kinematics": "linear"},
        "bodies.barge.radiation": {"model": "constant", "period": "12 s"},
        "bodies.barge.initial": {"position": [0.1, 0, 0, "1 deg", 0, 0]},
    },
    "a convolution": {"bodies.barge.radiation": "convolution", "accept": ["lift", "steepness"]},
}


def again(run: xr.Dataset, folder: Path) -> xr.Dataset:
    """The run of the case that a run holds."""
    path = folder / "again.yaml"
    path.write_text(case_of(run))
    return hs.simulate(hs.load_case(path))


@pytest.mark.parametrize("name", few(SHIPPED, 5))
def test_a_shipped_case_is_repeated(name: str, tmp_path: Path) -> None:
    """In a copy: one of them makes the run of another."""
    shutil.copytree(CASES, tmp_path / "cases", ignore=shutil.ignore_patterns("*.nc"))
    (tmp_path / "hydro_db").symlink_to(CASES.parent / "hydro_db")
    run = hs.simulate(hs.load_case(tmp_path / "cases" / f"{name}.yaml", SHORT))
    assert differences(run, again(run, tmp_path), TEXTS) == []


@pytest.mark.parametrize("what", OTHERS)
def test_what_is_not_the_default_is_repeated(what: str, tmp_path: Path) -> None:
    case = CASES / "reverse_float_over" / "base.yaml"
    run = hs.simulate(hs.load_case(case, {**SHORT, **OTHERS[what]}))
    assert differences(run, again(run, tmp_path), TEXTS) == []


def test_what_goes_on_is_repeated(tmp_path: Path) -> None:
    """A run that starts from another; where waves meet the body is as it was there."""
    case = CASES / "sphere" / "irregular.yaml"
    hs.simulate(hs.load_case(case, SHORT)).to_netcdf(tmp_path / "before.nc")
    run = hs.simulate(hs.load_case(case, {**SHORT, "initial.run": tmp_path / "before.nc"}))
    assert differences(run, again(run, tmp_path), TEXTS) == []


def test_one_run_of_many_is_repeated(tmp_path: Path) -> None:
    study = tmp_path / "study.yaml"
    study.write_text(
        f"case: {CASES}/sphere/irregular.yaml\nduration: 20 s\nseeds: [3, 7]\n"
        "parameters: {environment.waves.significant_height: [1 m, 2 m]}\n"
    )
    runs = run_study(load_study(study), tmp_path / "runs.nc").load()
    (tmp_path / "again.yaml").write_text(case_of(runs, 3))
    single = hs.simulate(hs.load_case(tmp_path / "again.yaml"))
    assert single.position.values.tobytes() == runs.position[3].values.tobytes()


@pytest.fixture(scope="module")
def sphere() -> xr.Dataset:
    return hs.simulate(hs.load_case(CASES / "sphere" / "irregular.yaml", SHORT))


def test_every_default_and_choice_is_said(sphere: xr.Dataset) -> None:
    text = case_of(sphere)
    for said in (
        "with all defaults, in SI and radians",
        ", numba ",
        "# radiation of sphere: automatic: 6 states for surge",
        "output:\n  step: 0.5\n",
        "tolerance: 0.0003",
        f'database_checksum: "{sphere.attrs["database_checksum_sphere"]}"',
    ):
        assert said in text
    assert "position: automatic" not in text
    assert "headings: automatic" not in text


def test_another_database_is_refused(sphere: xr.Dataset, tmp_path: Path) -> None:
    path = tmp_path / "again.yaml"
    path.write_text(case_of(sphere).replace(sphere.attrs["database_checksum_sphere"], "0" * 64))
    with pytest.raises(hs.InputError, match="has changed: found 4fe9"):
        hs.simulate(hs.load_case(path))


def test_the_command(
    sphere: xr.Dataset,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.chdir(tmp_path)
    sphere.to_netcdf("run.nc")
    sphere.assign_attrs(case_resolved="").to_netcdf("scene.nc")
    hydrosim = command(monkeypatch, capsys)
    result = hydrosim("case", "run.nc")
    assert result.code == 0
    assert result.out == " ".join(case_of(sphere).split())
    result = hydrosim("case", "scene.nc")
    assert result.code == 2
    assert "scene.nc: found no resolved case; expected the result of a case file." in result.err
    single = hydrosim("case", "run.nc", "--run", 3)
    assert "--run: found 3, but the file holds one run" in single.err
