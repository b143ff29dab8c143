"""`hydrosim statistics` on the terminal."""

from __future__ import annotations

from functools import partial
from pathlib import Path

import pytest
import xarray as xr
from command_line import Command
from recorded_runs import made_run

from hydrosim.files.outputs import Output
from hydrosim.results.dataset import write_run


@pytest.fixture
def statistics(hydrosim: Command) -> Command:
    """`hydrosim statistics` in an empty folder."""
    return partial(hydrosim, "statistics")


@pytest.fixture
def run(tmp_path: Path) -> Path:
    """Ten minutes of a made-up barge, as a file of a run that knows no groups of contacts."""
    path = tmp_path / "made.nc"
    write_run(made_run(), path)
    return path


def test_every_channel_has_its_lines(statistics: Command, run: Path) -> None:
    result = statistics(run)
    assert result.code == 0
    assert "channel mean std significant period [s] smallest largest" in result.out
    assert "Extremes in 600.2 s, with 90 % intervals" in result.out
    assert "barge heave [m] " in result.out
    assert "force of interface 1 [kN] " in result.out
    assert "nan" not in result.out
    with xr.open_dataset(run.with_stem("made_statistics")) as found:
        assert found.motion_extreme.dims == ("body", "dof", "side", "extreme")
        assert found.motion_extreme.attrs["interval_probability"] == 0.9
        meanings = found.motion_basis.attrs["flag_meanings"].split()
        assert len(meanings) == found.motion_basis.attrs["flag_values"].size


def test_times_have_units(statistics: Command, run: Path) -> None:
    said = [
        statistics(run, "--from", a, "--duration", b) for a, b in (("1 min", "2 min"), (60, 120))
    ]
    assert said[0].out == said[1].out
    assert said[0].code == 0
    for text in ("nan", "inf", "10 kg", "soon"):
        for option in ("--from", "--duration"):
            refused = statistics(run, option, text)
            assert (refused.code, refused.out) == (2, "")
            assert f"{option}: found" in refused.err


@pytest.mark.parametrize("duration", [5.0, -1.0])
def test_a_duration_that_is_no_use_is_refused(
    statistics: Command, run: Path, duration: float
) -> None:
    result = statistics(run, "--duration", duration)
    assert result.code == 2
    assert "--duration: found" in result.err
    assert "expected at least a tenth of the record, 60 s" in result.err


def test_a_missing_run_is_named_before_a_result_of_that_name(
    statistics: Command, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The statistics of another file have the name that those of this one would have."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "base_statistics.nc").write_text("of another program")
    result = statistics("base.yaml")
    assert (result.code, result.out) == (2, "")
    assert "base.yaml: there is no such file; expected the result of a run" in result.err
    assert "base_statistics.nc" not in result.err


def test_a_run_that_failed_is_said_to_have_failed(statistics: Command, tmp_path: Path) -> None:
    path = tmp_path / "failed.nc"
    ended = {"status": "failed", "status_message": "at t = 13 s it blows up"}
    write_run(made_run().assign_attrs(ended), path)
    result = statistics(path)
    assert result.code == 0
    assert "warning the run is failed: at t = 13 s it blows up" in result.out


@pytest.mark.parametrize("what", ["limits", "comparison"])
def test_another_result_is_said_to_be_what_it_is(
    statistics: Command, tmp_path: Path, what: str
) -> None:
    """It is told which command reads it."""
    path = tmp_path / "other.nc"
    write_run(xr.Dataset({"limit": 1.0}), Output(path, what, tmp_path / "study.yaml"))
    result = statistics(path)
    assert (result.code, result.out) == (2, "")
    said = f"other.nc: holds the {what} of [study.yaml], which `hydrosim report` shows; expected"
    assert said in result.err
