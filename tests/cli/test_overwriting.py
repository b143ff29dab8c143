"""What commands may write over: earlier results of the same, and nothing else unasked."""

import os
import signal
from collections.abc import Callable
from pathlib import Path

import pytest
import xarray as xr
from command_line import Command, command, files, refusal, succeeds
from scenes import SWINGING_BLOCK

from hydrosim.files.outputs import Output, content

BLOCK = SWINGING_BLOCK
STAGED = BLOCK.replace(
    "forces:\n",
    "forces:\n  push: {type: applied_force, body: block, force: {surge:"
    " {file: FILE, case: first.yaml, column: force_spring.surge}}}\n",
)
TURNING = """\
title: Turning over
duration: 20 s
bodies:
  block:
    mass: 2 kg
    radii_of_gyration: [1, 1, 1]
    dofs: [pitch]
    initial: {velocity: [0, 0, 0, 0, SPEED, 0]}
"""


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    here = tmp_path / "above" / "here"
    here.mkdir(parents=True)
    monkeypatch.chdir(here)
    Path("block.yaml").write_text(BLOCK)
    return tmp_path


@pytest.fixture
def hydrosim(
    folder: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> Command:
    return command(monkeypatch, capsys)


@pytest.mark.slow
def test_a_command_again_and_again(hydrosim: Command, folder: Path) -> None:
    names = None
    for _ in range(2):
        for arguments in (
            ("run", "block.yaml", "--plot"),
            ("linear", "block.yaml", "--periods", "5,6", "--headings", "0"),
            ("statistics", "block.nc"),
            ("export", "block.nc", "--recording", "-o", "block.txt"),
            ("compare", "block.nc", "block.txt"),
        ):
            succeeds(hydrosim, *arguments)
        assert names in (None, {*files(folder)})
        names = {*files(folder)}


@pytest.mark.parametrize("name", ["first.nc", "../../x.nc", "../other.nc", "there.nc"])
def test_a_case_file_makes_no_file_elsewhere(hydrosim: Command, folder: Path, name: str) -> None:
    """Not of another folder than its own stage's, not of another's, and never over another."""
    Path("first.yaml").write_text(BLOCK)
    Path("second.yaml").write_text(STAGED.replace("FILE", name))
    for other in ("../../x.nc", "there.nc"):
        Path(other).write_text("a letter")
    if name == "first.nc":
        assert hydrosim("run", "second.yaml").code == 0
        assert content(Path("first.nc")) == "run of [first.yaml]"
        return
    said = refusal(hydrosim, folder, "run", "second.yaml")
    assert f"file: {Path(name).name} (a run of first.yaml)" in said


def test_a_result_is_not_put_on_its_database(hydrosim: Command, folder: Path) -> None:
    """Without --output the result has another name where the case reads that of its own."""
    hydrosim("run", "block.yaml", "-o", "again.nc")
    Path("again.yaml").write_text(BLOCK + "initial: {run: again.nc}\n")
    result = hydrosim("run", "again.yaml")
    assert result.code == 0
    assert "again.nc is an input here; the result goes to again_run.nc" in result.err
    assert content(Path("again.nc")) == "run of [block.yaml]"
    for more in ((), ("--overwrite",)):
        said = refusal(hydrosim, folder, "run", "again.yaml", "-o", "again.nc", *more)
        assert "again.nc is an input and would be overwritten" in said


def link() -> None:
    Path("y.nc").write_text("a letter")
    Path("x.nc").symlink_to("y.nc")


def another_run(hydrosim: Command) -> None:
    Path("other.yaml").write_text(BLOCK)
    hydrosim("run", "other.yaml", "-o", "x.nc")


@pytest.mark.parametrize(
    ("make", "words", "overwritten"),
    [
        (lambda: Path("x.nc").write_text("a letter"), "is not a result of this program", True),
        (link, "x.nc is a link, which is never replaced", False),
        (lambda: os.mkfifo("x.nc"), "x.nc is a pipe", False),
    ],
)
@pytest.mark.parametrize("name", ["run", "converge"])
def test_what_is_there_stays(
    hydrosim: Command, folder: Path, name: str, make: Callable, words: str, overwritten: bool
) -> None:
    make()
    assert words in refusal(hydrosim, folder, name, "block.yaml", "-o", "x.nc")
    if not overwritten:
        refusal(hydrosim, folder, name, "block.yaml", "-o", "x.nc", "--overwrite")
    elif name != "converge":
        assert hydrosim(name, "block.yaml", "-o", "x.nc", "--overwrite").code == 0


def test_the_run_of_another_case_stays(hydrosim: Command, folder: Path) -> None:
    another_run(hydrosim)
    said = refusal(hydrosim, folder, "run", "block.yaml", "-o", "x.nc")
    assert "x.nc exists and is the run of [other.yaml]; expected a new name" in said
    assert "--overwrite" in said
    Path("block.png").write_text("a picture")
    assert "block.png exists" in refusal(hydrosim, folder, "run", "block.yaml", "--plot")
    for device in ("/dev/null", "/dev/full"):
        assert "ends in .nc" in refusal(hydrosim, folder, "run", "block.yaml", "-o", device)
        export = ("export", "x.nc", "--recording", "-o", device, "--overwrite")
        assert "is a device" in refusal(hydrosim, folder, *export)


def test_a_failed_run_leaves_a_complete_one(hydrosim: Command, folder: Path) -> None:
    case = Path("turning.yaml")
    case.write_text(TURNING.replace("SPEED", "0"))
    assert hydrosim("run", case).code == 0
    whole = Path("turning.nc").read_bytes()
    case.write_text(TURNING.replace("SPEED", "1"))
    for _ in range(2):
        result = hydrosim("run", case)
        assert result.code == 3
        assert "turning.failed.nc" in result.out
        assert Path("turning.nc").read_bytes() == whole
    assert xr.load_dataset("turning.failed.nc").attrs["status"] == "failed"
    assert len(files(folder)) == 4


FIRST_WORD = "case Swinging block: 1 body, 1 force element, no waves, 20 s by rk4"
STUDY = """\
case: block.yaml
parameters: {bodies.block.mass: [2 kg, 3 kg]}
figures: {end: {channel: position.block.surge, statistic: end}}
"""
LONG = "x" * 400


def duration(path: str) -> float:
    with xr.open_dataset(path) as run:
        return float(run.time[-1])


def test_a_result_of_other_settings_is_kept(hydrosim: Command, folder: Path) -> None:
    """The same case again replaces its result, in other words too; --overwrite replaces all."""
    assert hydrosim("run", "block.yaml", "-o", "r.nc").err == FIRST_WORD
    Path("block.yaml").write_text(f"# a remark\n{BLOCK.replace('2 kg', '2000 g')}")
    assert hydrosim("run", "block.yaml", "-o", "r.nc").err == FIRST_WORD
    assert {path.name for path in Path.cwd().iterdir()} == {"block.yaml", "r.nc"}
    shorter = ("run", "block.yaml", "-o", "r.nc", "--set", "duration=5 s")
    result = hydrosim(*shorter)
    said = "r.nc was made with other settings (duration 20, now 5; in SI and radians). It is kept"
    assert (result.code, said in result.err) == (0, True)
    assert "as r.1.nc; --overwrite replaces it" in result.err
    assert hydrosim(*shorter).err == FIRST_WORD.replace("20 s", "5 s")
    assert (duration("r.nc"), duration("r.1.nc")) == (5.0, 20.0)
    assert hydrosim("run", "block.yaml", "-o", "r.nc", "--overwrite").err == FIRST_WORD
    assert duration("r.nc") == 20.0
    assert {path.name for path in Path.cwd().iterdir()} == {"block.yaml", "r.nc", "r.1.nc"}


@pytest.mark.parametrize(
    ("arguments", "name"),
    [
        (("sweep", "study.yaml"), "study"),
        (("linear", "block.yaml"), "block_linear"),
        (("converge", "block.yaml", "--methods", "rk4"), "block_converge"),
    ],
)
def test_so_are_other_results(
    hydrosim: Command, folder: Path, arguments: tuple[str, ...], name: str
) -> None:
    Path("study.yaml").write_text(STUDY)
    for _ in range(2):
        assert hydrosim(*arguments).code == 0
    assert not Path(f"{name}.1.nc").exists()
    Path("block.yaml").write_text(BLOCK.replace("5 N/m", "6 N/m"))
    result = hydrosim(*arguments)
    assert "forces.spring.stiffness.surge 5, now 6" in result.err
    assert f"is kept as {name}.1.nc" in result.err
    assert Path(f"{name}.1.nc").exists()


def test_what_is_made_by_another_process_is_refused(hydrosim: Command, folder: Path) -> None:
    """At once, and the process is named; one that was killed is in nobody's way."""
    read, write = os.pipe()
    pid = os.fork()
    if pid == 0:
        with Output(Path("r.nc"), "run", Path("block.yaml")).hold_lock():
            os.write(write, b"!")
            signal.pause()
    os.read(read, 1)
    said = refusal(hydrosim, folder, "run", "block.yaml", "-o", "r.nc")
    assert f"r.nc: is being written by another process, {pid}@" in said
    os.kill(pid, signal.SIGKILL)
    os.waitpid(pid, 0)
    assert hydrosim("run", "block.yaml", "-o", "r.nc").code == 0
    assert {path.name for path in Path.cwd().iterdir()} == {"block.yaml", "r.nc"}


def test_what_stands_where_a_checkpoint_goes_stays(hydrosim: Command, folder: Path) -> None:
    Path("r.nc.checkpoint").write_text("a letter")
    for more in ((), ("--overwrite",), ("--resume",)):
        said = refusal(hydrosim, folder, "run", "block.yaml", "-o", "r.nc", *more)
        assert "r.nc.checkpoint: is not a checkpoint of this program" in said


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (("run", "long.yaml"), "long.yaml:1: extends: found no file"),
        (("run", "block.yaml", "-o", f"{LONG}.nc"), "has a name of 403 bytes; expected 200"),
        (("run", "block.yaml", "-o", f"{LONG}/r.nc"), "there is no folder"),
        (("run", "staged.yaml"), "forces.push.force.surge.file: found no folder"),
        (("statistics", f"{LONG}.nc"), "there is no such file"),
        (("plot", f"{LONG}.nc"), "cannot be read (File name too long)"),
        (("export", f"{LONG}.nc", "-o", "a.csv"), "cannot be read (File name too long)"),
        (("plot", "x.nc", "-o", LONG), "the folder cannot be made"),
        (("example", "sphere", "-o", LONG), "the folder cannot be made"),
    ],
)
def test_a_name_that_is_too_long(
    hydrosim: Command, folder: Path, arguments: tuple[str, ...], words: str
) -> None:
    another_run(hydrosim)
    Path("first.yaml").write_text(BLOCK)
    Path("staged.yaml").write_text(STAGED.replace("FILE", f"{LONG}/first.nc"))
    Path("long.yaml").write_text(f"extends: {LONG}.yaml\n")
    assert words in refusal(hydrosim, folder, *arguments)


COUNTED = """\
case: block.yaml
parameters: {forces.spring.stiffness.surge: [1, 2]}
figures: {far: {channel: position.block.surge, statistic: largest}}
"""


def test_the_table_of_a_sweep_lies_beside_its_result(hydrosim: Command, folder: Path) -> None:
    Path("study.yaml").write_text(COUNTED)
    Path("results").mkdir()
    said = succeeds(hydrosim, "sweep", "study.yaml", "-o", "results/a.nc")
    assert "table results/a.csv" in said
    assert {path.name for path in Path("results").iterdir()} == {"a.nc", "a.csv"}
    assert not Path("a.csv").exists()
    assert content(Path("results/a.csv")) == "table of [a.nc]"


@pytest.mark.parametrize("more", ["", "seeds: 1-2\nuntil: {figure: far, wide: 1 m, most: 4}\n"])
def test_a_table_that_is_in_the_way_is_told_before_the_first_run(
    hydrosim: Command, folder: Path, more: str
) -> None:
    waves = "environment: {waves: {spectrum: regular, amplitude: 1 m, period: 8 s, heading: 0}}\n"
    Path("block.yaml").write_text(BLOCK + waves)
    Path("study.yaml").write_text(COUNTED + more)
    Path("results").mkdir()
    Path("results/a.csv").write_text("a letter")
    said = refusal(hydrosim, folder, "sweep", "study.yaml", "-o", "results/a.nc")
    assert "results/a.csv exists and is not a result of this program" in said
    assert hydrosim("sweep", "study.yaml", "-o", "results/b.nc").code == 0
