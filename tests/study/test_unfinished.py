"""Sets of runs that were ended on their way and go on: the same file in the end."""

import os
import re
import signal
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from damaged import message
from scenes import SEA, in_contact, in_waves, with_body

import hydrosim as hs
from hydrosim.compare.dataset import differences
from hydrosim.database.database import HydroDatabase
from hydrosim.errors import WritingError
from hydrosim.files.outputs import Output
from hydrosim.results import runs_file
from hydrosim.results.runs_file import (
    COMPLETE,
    Journal,
    RunOutcome,
    RunsWriter,
    folder_of,
    locked_journal,
)
from hydrosim.scene import AtDraught, Family, Scene, WaveTrain
from hydrosim.study import executors, scene_cache


def seeds(count: int, duration: float = 20.0) -> list[Scene]:
    return [in_waves(in_contact(duration), WaveTrain(SEA, seed=k)) for k in range(count)]


class Killed(BaseException):
    """Nothing is done any more."""


def killed_after(count: int) -> Callable[[int, int], None]:
    def progress(done: int, _: int) -> None:
        if done >= count:
            raise Killed

    return progress


def result(path: Path) -> xr.Dataset:
    return xr.load_dataset(path, engine="netcdf4")


def test_a_set_goes_on_to_the_same_result(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Killed, interrupted, and cut short on the disk; no run that is there is made again."""
    scenes, path = seeds(8), tmp_path / "runs.nc"
    hs.simulate_many(scenes, tmp_path / "whole.nc").close()
    with pytest.raises(Killed):
        hs.simulate_many(scenes, path, workers=1, progress=killed_after(2))
    assert not path.exists()
    runs = tmp_path / "runs.nc.partial" / "runs"
    runs.write_bytes(runs.read_bytes()[:-5])  # the last one was being written
    with pytest.raises(hs.InputError, match=r"holds runs of a set .*--resume .*--overwrite"):
        hs.simulate_many(scenes, path)

    def interrupted(done: int, _: int) -> None:
        if done == 4:
            raise KeyboardInterrupt

    part = hs.simulate_many(scenes, path, workers=1, progress=interrupted, resume=True)
    assert part.status.values.tolist()[:4] == ["complete"] * 4
    assert part.status.values.tolist()[-1] == "not run"
    part.close()
    made = []
    once = executors.run_compiled
    monkeypatch.setattr(
        executors, "run_compiled", lambda *a, **of: made.append(1) or once(*a, **of)
    )
    hs.simulate_many(scenes, path, workers=2, resume=True).close()
    assert len(made) <= 4
    assert differences(result(path), result(tmp_path / "whole.nc")) == []
    assert {p.name for p in tmp_path.iterdir()} == {"runs.nc", "whole.nc"}


def test_another_set_is_refused(tmp_path: Path) -> None:
    scenes, path = seeds(3), tmp_path / "runs.nc"
    with pytest.raises(Killed):
        hs.simulate_many(scenes, path, workers=1, progress=killed_after(1))
    database = scenes[0].bodies[0].hydrodynamics
    mass = database.added_mass.copy()
    mass[3, 0, 0] *= 1.0 + 1e-15
    longer = [replace(s, duration=s.duration + 1.0) for s in scenes]
    other = [with_body(s, hydrodynamics=replace(database, added_mass=mass)) for s in scenes]
    for changed, options, words in (
        (other, {}, "were made: a database"),
        (seeds(4), {}, "were made: the seeds or parameters; the cases"),
        (longer, {}, "were made: the cases"),
        (scenes, {"variables": ["velocity"]}, "were made: what is kept of the runs"),
    ):
        with pytest.raises(hs.InputError, match=words):
            hs.simulate_many(changed, path, resume=True, **options)


def test_a_set_of_a_hull_at_draughts_knows_their_databases() -> None:
    """Another database at one draught is another set; where a file is from is not."""
    (scene,) = seeds(1)
    (body,) = scene.bodies
    database = body.hydrodynamics
    more = replace(database, added_mass=1.01 * database.added_mass)

    def identity_with(*databases: HydroDatabase) -> dict[str, str]:
        members = [AtDraught(7.0 + k, source) for k, source in enumerate(databases)]
        family = with_body(scene, hydrodynamics=Family(tuple(members)))
        return scene_cache.identity([replace(family, title="x")], lambda s: s, {}, {})

    known = identity_with(database, database)
    assert identity_with(database, database) == known
    changed = identity_with(database, more)
    assert {name for name in known if known[name] != changed[name]} == {
        "a database, or the run to start from"
    }


def test_one_run_that_fails_ends_nothing(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Whatever it raises, where it runs and where it is made."""
    once, prepared = executors.run_compiled, scene_cache.check_scene

    def run(compiled: object, watch: object, **of: object) -> xr.Dataset:
        if compiled.scene.environment.waves[0].seed == 1:
            raise ZeroDivisionError("of nothing")
        return once(compiled, watch, **of)

    def check(scene: Scene) -> None:
        if scene.environment.waves[0].seed == 2:
            raise MemoryError
        prepared(scene)

    monkeypatch.setattr(executors, "run_compiled", run)
    monkeypatch.setattr(scene_cache, "check_scene", check)
    runs = hs.simulate_many(seeds(4), tmp_path / "runs.nc")
    assert runs.status.values.tolist() == ["complete", "failed", "failed", "complete"]
    messages = runs.status_message.values.tolist()
    assert messages == ["", "ZeroDivisionError: of nothing", "MemoryError: ", ""]
    assert np.isfinite(runs.position[3]).all()


def test_a_set_that_cannot_be_written_goes_on_elsewhere(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    scenes, path, once = seeds(4), tmp_path / "runs.nc", RunsWriter.add

    def full(self: RunsWriter, run: int, outcome: RunOutcome) -> RunOutcome:
        if run == 2:
            raise RuntimeError("NetCDF: HDF error")
        return once(self, run, outcome)

    with monkeypatch.context() as patch:
        patch.setattr(RunsWriter, "add", full)
        with pytest.raises(WritingError, match=r"runs\.nc: cannot be written \(NetCDF: HDF error"):
            hs.simulate_many(scenes, path)
    assert not path.exists()
    runs = hs.simulate_many(scenes, path, resume=True)
    assert runs.status.values.tolist() == ["complete"] * 4


def test_what_is_kept_of_a_run_is_what_it_was(tmp_path: Path) -> None:
    """Types of attributes as well: those that all runs have are told by them."""
    found = xr.Dataset(
        {"a": ("x", np.array([1.0, np.nan, -0.0])), "n": np.int64(7)}, {"x": [3.0, 4.0, 5.0]}
    )
    found.a.attrs["flag_values"] = np.arange(3, dtype=np.int8)
    attributes = {"f": np.float64(0.1), "g": 0.1, "i": np.int64(3), "t": "x", "l": [1.5, 2.5]}
    attributes["array"] = np.array([[1, 2]], dtype=np.int16)
    book = Journal(tmp_path, {"the program": "x"})
    book.add(5, RunOutcome(COMPLETE, "", "careful", found, attributes))
    book.add(6, RunOutcome(COMPLETE, dataset=found.isel(x=[0])))  # of another form: run again
    book.close()
    again = Journal(tmp_path, {"the program": "x"})
    assert (5 in again, 6 in again, len(again)) == (True, False, 1)
    kept = again.read(5)
    assert kept.dataset is not None
    assert differences(found, kept.dataset) == []
    assert kept.warnings == "careful"
    assert {k: type(v) for k, v in kept.attributes.items()} == {
        k: type(v) for k, v in attributes.items()
    }
    assert kept.attributes["array"].dtype == np.int16
    again.remove()


def test_two_processes_do_not_write_one_set(tmp_path: Path) -> None:
    """The second is told who writes; what a killed one has left is in nobody's way."""
    read, write = os.pipe()
    path, pid = tmp_path / "runs.nc", os.fork()
    if pid == 0:
        with locked_journal(Output(path, "sweep", tmp_path / "x.yaml"), False, IDENTITY):
            os.write(write, b"!")
            signal.pause()
    os.read(read, 1)
    for _ in range(2):
        with pytest.raises(hs.InputError, match=rf"another process, {pid}@.*\. Wait"):
            hs.simulate_many(seeds(1), path)
    os.kill(pid, signal.SIGKILL)
    os.waitpid(pid, 0)
    assert (tmp_path / ".hydrosim-runs.nc.lock").exists()
    hs.simulate_many(seeds(1), path).close()
    assert [p.name for p in tmp_path.iterdir()] == ["runs.nc"]


def kept_in(result: Output) -> None:
    """Three runs of a set that did not come to its end, one of which has failed."""
    with locked_journal(result, False, IDENTITY) as book:
        for k in (1, 2):
            found = xr.Dataset({"a": ("x", [k + 0.5, 2.0])}, {"x": [3.0, 4.0]})
            attributes = {"k": k, "g": np.float64(k)}
            book.add(k, RunOutcome(COMPLETE, dataset=found, attributes=attributes))
        book.add(3, RunOutcome("failed", "it turned over"))


def read_again(result: Output) -> dict[int, RunOutcome]:
    """The runs that a set which goes on takes over."""
    with locked_journal(result, True, IDENTITY) as book:
        return {run: book.read(run) for run in range(100) if run in book}


IDENTITY = {"the program": "one", "the cases": "two"}


@pytest.mark.parametrize("name", [runs_file.RUNS, runs_file.FIRST_RUN_FILE])
def test_no_byte_of_a_journal_changes_a_number_in_silence(tmp_path: Path, name: str) -> None:
    """A run is what it was, or is made again, or the file is named with what to do."""
    result = Output(tmp_path / "runs.nc", "sweep", tmp_path / "x.yaml")
    kept_in(result)
    whole = {f.name: f.read_bytes() for f in folder_of(result).iterdir()}
    before, told, lost = read_again(result), 0, 0
    assert [*before] == [1, 2]
    content = whole[name]
    step = 3 if name == runs_file.RUNS else 97
    for at in range(0, len(content), step):
        folder_of(result).mkdir(exist_ok=True)  # it goes where no run is left
        for file, data in whole.items():
            (folder_of(result) / file).write_bytes(data)
        flipped = content[at] ^ (1 << at % 8)
        (folder_of(result) / name).write_bytes(content[:at] + bytes([flipped]) + content[at + 1 :])
        again = dict[int, RunOutcome]()
        said = message(lambda _: again.update(read_again(result)), tmp_path)  # noqa: B023
        if said is not None:
            assert re.search(rf"{name}: is .*(--overwrite|Move it away)", said), at
            told += 1
            continue
        lost += len(before) - len(again)
        for run, kept in again.items():
            assert kept.dataset is not None
            assert kept.dataset.identical(before[run].dataset), at
            assert kept.attributes == before[run].attributes, at
            assert kept.warnings == before[run].warnings, at
    if name == runs_file.FIRST_RUN_FILE:
        assert (lost, told) == (0, len(range(0, len(content), step)))
    else:
        assert told == len(range(0, content.index(b"\n") + 1, step))
        assert lost > 0


def test_a_number_of_a_run_that_was_changed_is_not_believed(tmp_path: Path) -> None:
    result = Output(tmp_path / "runs.nc", "sweep", tmp_path / "x.yaml")
    kept_in(result)
    runs = folder_of(result) / runs_file.RUNS
    assert runs.read_bytes().count(b'"run": 2') == 1
    runs.write_bytes(runs.read_bytes().replace(b'"run": 2', b'"run": 22'))
    assert [*read_again(result)] == [1]


def test_a_journal_of_an_earlier_version_is_refused_in_words(tmp_path: Path) -> None:
    result = Output(tmp_path / "runs.nc", "sweep", tmp_path / "x.yaml")
    folder_of(result).mkdir()
    line = b'{"the program": "one", "the cases": "two"}\n'
    (folder_of(result) / runs_file.RUNS).write_bytes(line)
    with pytest.raises(hs.InputError, match=r"--resume: .*earlier version.*--overwrite"):
        read_again(result)
    with locked_journal(replace(result, overwrite=True), False, IDENTITY):
        pass
    assert read_again(result) == {}


def put(path: Path, content: str | Path) -> Path:
    """A file or a link of others."""
    path.parent.mkdir(exist_ok=True)
    if isinstance(content, Path):
        path.symlink_to(content)
    else:
        path.write_text(content)
    return path


@pytest.mark.parametrize("name", ["runs", "first.nc", "known.nc.partial", "result.nc", "notes.txt"])
@pytest.mark.parametrize("overwrite", [False, True])
def test_what_others_keep_among_the_runs_stays(tmp_path: Path, name: str, overwrite: bool) -> None:
    """Texts and links, with whatever name; so does a folder that a link leads to."""
    folder, elsewhere = tmp_path / "runs.nc.partial", put(tmp_path / "there" / "runs", "a letter")
    result = Output(tmp_path / "runs.nc", "sweep", tmp_path / "x.yaml", overwrite=overwrite)
    for content in ("a letter\n", elsewhere):
        path = put(folder / name, content)
        said = rf"runs\.nc\.partial/{name}: is .*Move it away, or give the result another name"
        with pytest.raises(hs.InputError, match=said):
            hs.simulate_many(seeds(1), result, resume=not overwrite)
        assert path.read_text() in ("a letter", "a letter\n")
        path.unlink()
    folder.rmdir()
    folder.symlink_to(elsewhere.parent)
    with pytest.raises(hs.InputError, match=r"runs\.nc\.partial: is a link"):
        hs.simulate_many(seeds(1), result, resume=not overwrite)
    folder.unlink()
    lock = put(tmp_path / ".hydrosim-runs.nc.lock", elsewhere)
    with pytest.raises(hs.InputError, match=r"\.lock: expected no file, or a lock file"):
        hs.simulate_many(seeds(1), result)
    lock.unlink()
    put(lock, "a letter")
    with pytest.raises(hs.InputError, match=r"\.lock: expected no file.*it is no lock file"):
        hs.simulate_many(seeds(1), result)
    assert lock.read_text() == elsewhere.read_text() == "a letter"
