"""Runs on their way are read from their folder: whole ones, whatever else is there."""

import json
from functools import partial
from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from command_line import Command
from damaged import message

from hydrosim.errors import InputError
from hydrosim.results.runs_file import (
    COMPLETE,
    FIRST_RUN_FILE,
    KNOWN,
    RUN,
    RUNS,
    Journal,
    RunOutcome,
    RunsWriter,
    read_unfinished,
    runs_at,
)

COUNT = 6
PLAN = {"design": "grid", "samples": None, "parameters": {"height": ["height"]}}
DESIGN = json.dumps({"plans": {"": PLAN}, "figures": ["crawl"]})


def run(k: int) -> RunOutcome:
    found = xr.Dataset(
        {"crawl": ((), 10.0 + k, {"units": "m"}), "order": np.int64(k), "x": ("time", [k, 0.5])},
        {"time": [0.0, 1.0]},
    )
    return RunOutcome(COMPLETE, "", "", found, {"title": "one", "own": k})


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """Six runs, of two heights with three seeds: two are complete, the last of the first height
    has failed, the first is missing."""
    made = tmp_path / "runs.nc.partial"
    made.mkdir()
    along = {
        "seed": xr.Variable(RUN, np.array([1, 2, 3] * 2)),
        "height": xr.Variable(RUN, np.repeat([1.0, 2.0], 3), {"units": "m"}),
    }
    RunsWriter(made / KNOWN, COUNT, along, list(along), {"design": DESIGN}).close()
    book = Journal(made, {"the program": "x"})
    book.add(1, run(1))
    book.add(2, RunOutcome("failed", "it turned over"))
    book.add(3, run(3))
    book.close()
    return made


@pytest.fixture
def statistics(hydrosim: Command) -> Command:
    return partial(hydrosim, "statistics")


def test_what_is_in_is_what_was_put_there(folder: Path) -> None:
    runs = read_unfinished(folder)
    nan = np.nan
    np.testing.assert_array_equal(runs.crawl, [nan, 11.0, nan, 13.0, nan, nan])
    np.testing.assert_array_equal(runs.order, [nan, 1.0, nan, 3.0, nan, nan])
    np.testing.assert_array_equal(runs.x[3], [3.0, 0.5])
    status = ["not run", "complete", "failed", "complete", "not run", "not run"]
    assert runs.status.values.tolist() == status
    assert runs.status_message.values[2] == "it turned over"
    assert runs.attrs["gathered"] == "2 of 6 runs are complete, 1 failed"
    assert runs.attrs["title"] == "one"
    assert "own" not in runs.attrs  # the runs have it otherwise
    assert runs.crawl.attrs["units"] == runs.height.attrs["units"] == "m"


def test_tables_of_the_runs_that_are_in(folder: Path, statistics: Command, tmp_path: Path) -> None:
    """Nothing in the folder is changed by that."""
    before = {path.name: path.read_bytes() for path in folder.iterdir()}
    result = statistics(folder)
    assert result.code == 0, result.err
    assert "So far 2 of 6 runs are complete, 1 failed" in result.out
    table = (tmp_path / "runs.partial.csv").read_text().splitlines()
    assert [line.split(",")[1:6] for line in table[2:]] == [
        ["1", "crawl", "m", "1", "11"],
        ["2", "crawl", "m", "1", "13"],
    ]
    assert {path.name: path.read_bytes() for path in folder.iterdir()} == before


@pytest.mark.parametrize("cut", [1, 20, 100])
def test_a_run_that_was_cut_in_half_is_not_in(folder: Path, cut: int) -> None:
    """As while it is being written."""
    file = folder / RUNS
    file.write_bytes(file.read_bytes()[:-cut])
    assert read_unfinished(folder).attrs["gathered"] == "1 of 6 runs are complete, 1 failed"


def test_a_run_of_which_a_bit_has_changed_is_not_in(folder: Path) -> None:
    file = folder / RUNS
    data = bytearray(file.read_bytes())
    data[-3] ^= 1
    file.write_bytes(data)
    assert read_unfinished(folder).attrs["gathered"] == "1 of 6 runs are complete, 1 failed"


@pytest.mark.parametrize("name", [RUNS, FIRST_RUN_FILE, KNOWN])
def test_no_byte_changes_a_number_in_silence(folder: Path, name: str) -> None:
    """A run is what it was, or is not in, or it is said that a file is damaged."""
    whole, content = read_unfinished(folder), (folder / name).read_bytes()
    step = 23 if name == RUNS else 211
    for at in range(0, len(content), step):
        flipped = content[at] ^ (1 << at % 8)
        (folder / name).write_bytes(content[:at] + bytes([flipped]) + content[at + 1 :])
        found = list[xr.Dataset]()
        said = message(lambda _: found.append(read_unfinished(folder)), folder)  # noqa: B023
        assert (said is None) == (len(found) == 1)
        assert said or name == RUNS
        for runs in found:
            inside = {RUN: runs.status.values == "complete"}
            assert runs[inside].drop_attrs().identical(whole[inside].drop_attrs()), at
        (folder / name).write_bytes(content)


def test_what_cannot_be_told_anything_of(folder: Path, statistics: Command) -> None:
    """Folders of something else, of no run yet, of an earlier version; what is there no more."""
    parent, lone = folder.parent, folder.parent / "empty"
    lone.mkdir()
    assert "has no runs of a sweep" in statistics(lone).err
    assert "such as runs.nc.partial" in statistics(".").err
    assert f"{folder} is an unfinished sweep" in statistics(parent / "runs.nc").err
    (parent / "a.nc").write_bytes(b"")
    assert "the result of the sweep" in statistics(parent / "a.nc.partial").err
    (folder / FIRST_RUN_FILE).unlink()
    book = Journal(folder, {})
    book.close()
    result = statistics(folder)
    assert "Wait for the first" in result.err
    assert "it turned over" in result.err
    (folder / KNOWN).write_bytes(b"CDF nothing")
    assert "cannot be read" in statistics(folder).err
    (folder / KNOWN).unlink()
    result = statistics(folder)
    assert "lacks known.nc" in result.err
    assert result.code == 2


def test_a_folder_that_goes_while_it_is_read(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def gone(_: Path) -> None:
        (folder / RUNS).unlink()

    monkeypatch.setattr("hydrosim.results.runs_file.first_of", gone)
    with pytest.raises(InputError, match="no longer exists, because its sweep has ended"):
        runs_at(folder)


def test_rounds_of_a_study_are_pointed_to(tmp_path: Path) -> None:
    rounds = tmp_path / "runs.nc.rounds"
    rounds.mkdir()
    (rounds / "0-abc.nc").touch()
    (rounds / "1-def.nc.partial").mkdir()
    for name in ("runs.nc", "runs.nc.partial"):
        with pytest.raises(InputError, match=r"its last round in .*1-def.nc.partial"):
            runs_at(tmp_path / name)


def test_statistics_of_a_study_that_was_interrupted(tmp_path: Path, statistics: Command) -> None:
    """What came of its runs is said before figures of those that are complete."""
    height = xr.Variable(RUN, [1.0, 1.0, 2.0, 2.0], {"units": "m"})
    known = {"seed": xr.Variable(RUN, [1, 2, 1, 2]), "height": height}
    file = RunsWriter(tmp_path / "runs.nc", 4, known, list(known), {"design": DESIGN})
    file.add(0, run(0)._replace(attributes={}))
    file.add(1, RunOutcome("failed", "it turned over"))
    file.close()
    result = statistics("runs.nc")
    assert "1 of 4 runs are complete. Figures are of these." in result.out
    assert "failed: it turned over (run 1) not run (2 runs: 2, 3)" in result.out
    with xr.open_dataset(tmp_path / "runs.nc") as whole:
        whole.drop_vars("status").to_netcdf(tmp_path / "less.nc")
    assert "less.nc: holds 4 runs without their status" in statistics("less.nc").err
