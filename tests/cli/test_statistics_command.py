"""`hydrosim statistics` on the terminal."""

from functools import partial
from pathlib import Path

import pytest
import xarray as xr
from command_line import Command, refusal, succeeds
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
    printed = succeeds(statistics, run)
    assert "channel mean std significant period [s] smallest largest" in printed
    assert "Extremes in 600.2 s, with 90 % intervals" in printed
    assert "barge heave [m] " in printed
    assert "force of interface 1 [kN] " in printed
    assert "nan" not in printed
    with xr.open_dataset(run.with_stem("made_statistics")) as found:
        assert found.motion_extreme.dims == ("body", "dof", "side", "extreme")
        assert found.motion_extreme.attrs["interval_probability"] == 0.9
        meanings = found.motion_basis.attrs["flag_meanings"].split()
        assert len(meanings) == found.motion_basis.attrs["flag_values"].size


def test_times_have_units(statistics: Command, run: Path) -> None:
    """A time that is of no use is refused."""
    in_minutes = succeeds(statistics, run, "--from", "1 min", "--duration", "2 min")
    assert in_minutes == succeeds(statistics, run, "--from", 60, "--duration", 120)
    for text in ("nan", "inf", "10 kg", "soon"):
        for option in ("--from", "--duration"):
            assert f"{option}: found" in refusal(statistics, run.parent, run, option, text)
    for duration in (5.0, -1.0):
        said = refusal(statistics, run.parent, run, "--duration", duration)
        assert "--duration: found" in said
        assert "expected at least a tenth of the record, 60 s" in said


def test_a_missing_run_is_named_before_a_result_of_it(statistics: Command, tmp_path: Path) -> None:
    """The statistics of another file have the name that those of this one would have."""
    (tmp_path / "base_statistics.nc").write_text("of another program")
    said = refusal(statistics, tmp_path, "base.yaml")
    assert "base.yaml: there is no such file; expected the result of a run" in said
    assert "base_statistics.nc" not in said


def test_a_run_that_failed_is_said_to_have_failed(statistics: Command, tmp_path: Path) -> None:
    path = tmp_path / "failed.nc"
    ended = {"status": "failed", "status_message": "at t = 13 s it blows up"}
    write_run(made_run().assign_attrs(ended), path)
    assert "warning the run is failed: at t = 13 s it blows up" in succeeds(statistics, path)


@pytest.mark.parametrize("what", ["limits", "comparison"])
def test_another_result_is_told_what_it_is(statistics: Command, tmp_path: Path, what: str) -> None:
    """It is told which command reads it."""
    path = tmp_path / "other.nc"
    write_run(xr.Dataset({"limit": 1.0}), Output(path, what, tmp_path / "study.yaml"))
    said = f"other.nc: holds the {what} of [study.yaml], which `hydrosim report` shows; expected"
    assert said in refusal(statistics, tmp_path, path)
