"""Studies that are shipped with the cases: each can be read, and the question that the program was
made for is asked in one file."""

import re
from pathlib import Path

import pytest
import xarray as xr
import yaml
from command_line import command
from scenes import CASES

from hydrosim.study.operability import load_limits
from hydrosim.study.sweep import load_study

STUDIES = sorted((CASES.parent).glob("*/studies/*.yaml"))
WHY = CASES / "studies" / "why.yaml"


@pytest.mark.parametrize("path", STUDIES, ids=lambda path: f"{path.parents[1].name}-{path.stem}")
def test_studies_can_be_read(path: Path, tmp_path: Path) -> None:
    """A design of hundreds of samples, with eight."""
    text = path.read_text()
    if "samples:" in text:
        path = tmp_path / path.name
        text = text.replace("case: ../base.yaml", f"case: {CASES / 'base.yaml'}")
        path.write_text(re.sub("^samples: .*", "samples: 8", text, flags=re.M))
    found = load_limits(path) if "operability:" in text else load_study(path)
    assert found.seeds or "sobol" in text


def reduced(folder: Path) -> Path:
    """The study, of one seed up to the first contacts."""
    data = yaml.safe_load(WHY.read_text())
    data |= {"case": str(CASES / "base.yaml"), "seeds": [1], "duration": "620 s"}
    path = folder / "why.yaml"
    path.write_text(yaml.safe_dump(data))
    return path


@pytest.mark.slow
def test_friction_fenders_and_deballasting_are_explained_in_one_study(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """No run fails; the explanation of each value has its own friction, fenders and forces."""
    monkeypatch.chdir(tmp_path)
    result = command(monkeypatch, capsys, "sweep")(reduced(tmp_path), "-o", "why.nc")
    assert result.code == 0, result.err
    assert "All 12 runs are complete." in result.out
    with xr.open_dataset("why.nc") as runs:
        four = runs.fender_in_run.sum("fender").values
        assert four[runs.number.values == "two"].tolist() == [2]
        assert four[runs.number.values == "six"].tolist() == [6]
        kinetic = runs.fender_kinetic.max("fender").values
        assert kinetic.tolist() == runs.forces_interface_friction_kinetic.values.tolist()
        force = runs.mean_force.sel(span="in contact", force="interface", dof="surge")
        assert force.squeeze("body").values.tolist() == runs.fenders_push.values.tolist()
        assert runs.friction_part.sel(fender="interface 6").notnull().sum() > 0
    told = command(monkeypatch, capsys, "explain")("why.nc")
    assert told.code == 0, told.err
    for value in ("number two", "number six", "kinetic 0.15", "rate 50 000 t/h"):
        assert value in told.out
