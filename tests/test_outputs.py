"""Which files may be replaced, and that they come whole or not at all."""

import errno
import os
import re
import signal
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path

import pytest
import xarray as xr
from matplotlib.figure import Figure

import hydrosim as hs
from hydrosim.errors import WritingError, unwritable
from hydrosim.files.interrupts import ENDING_SIGNALS, install_signal_handlers, raise_if_interrupted
from hydrosim.files.outputs import Output, content, save_picture
from hydrosim.results.dataset import write_run

ROOT = Path(__file__).parents[1]

CASE = "sub/a case (\u00fc).yaml"


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    Path("sub").mkdir()
    Path(CASE).write_text("title: x\n")
    return tmp_path


def output(path: str, **changes: object) -> Output:
    known: dict = {"path": Path(path), "what": "run", "origin": Path(CASE), **changes}
    return Output(**known)


def write_text(made: Output, text: str = "") -> None:
    with made.write_complete() as path:
        path.write_text(f"# {made.mark}\n{text}")


def drawn(made: Output) -> None:
    figure = Figure()
    figure.subplots().plot([1, 2])
    save_picture(figure, made)


WRITERS: dict[str, Callable[[Output], object]] = {
    "x.nc": lambda made: write_run(xr.Dataset({"a": 1.0}), made),
    "x.png": drawn,
    "x.svg": drawn,
    "x.pdf": drawn,
    "x.txt": write_text,
}


@pytest.mark.parametrize("name", WRITERS)
def test_what_is_made_again_is_replaced(folder: Path, name: str) -> None:
    """Known by what it says of itself, wherever the program is called from; nobody else's."""
    made = output(name)
    assert made.checked_output() is made
    WRITERS[name](made)
    assert content(made.path) == "run of [sub/a%20case%20%28%C3%BC%29.yaml]"
    os.chdir("sub")
    again = Output(Path("..") / name, "run", Path(Path(CASE).name))
    WRITERS[name](again.checked_output())
    os.chdir("..")
    other = {"origin": Path("other.yaml")}, {"what": "sweep"}
    for change in other:
        with pytest.raises(hs.InputError, match=r"exists and is the run of .*--overwrite"):
            output(name, **change).checked_output()
        assert output(name, overwrite=True, **change).checked_output()
    assert not [path for path in folder.iterdir() if path.name.startswith(".")]


def made_by_hand(kind: str) -> None:
    match kind:
        case "file":
            Path("x.nc").write_bytes(b"\x89HDF\r\n\x1a\n and noise")
        case "link":
            Path("x.nc").symlink_to("kept.nc")
            Path("kept.nc").write_text("kept")
        case "pipe":
            os.mkfifo("x.nc")
        case "directory":
            Path("x.nc").mkdir()
        case "input":
            Path("x.nc").write_text("kept")


@pytest.mark.parametrize("kind", ["link", "pipe", "directory", "input"])
def test_what_is_never_replaced(folder: Path, kind: str) -> None:
    made_by_hand(kind)
    before = os.lstat("x.nc")
    for overwrite in (False, True):
        with pytest.raises(hs.InputError, match=r"x\.nc is"):
            output("x.nc", inputs=(Path("x.nc"),), overwrite=overwrite).checked_output()
    with pytest.raises(hs.InputError):
        write_text(output("x.nc", inputs=(Path("x.nc"),), overwrite=True))
    assert os.lstat("x.nc") == before
    with pytest.raises(hs.InputError, match="/dev/null is a device"):
        Output(Path("/dev/null"), "run", Path(CASE), overwrite=True).checked_output()


def test_what_others_made_is_replaced_if_asked(folder: Path) -> None:
    made_by_hand("file")
    with pytest.raises(hs.InputError, match="is not a result of this program"):
        output("x.nc").checked_output()
    write_text(output("x.nc", overwrite=True))
    assert content(Path("x.nc"))


def test_a_run_that_failed_stands_aside(folder: Path) -> None:
    Path("x.failed.nc").write_text("somebody's")
    aside = output("x.nc").fallback_path()
    assert aside.path == Path("x.failed2.nc")
    write_text(aside)
    assert output("x.nc").fallback_path().path == Path("x.failed2.nc")
    Path("x.nc").write_text("came meanwhile")
    assert output("x.nc").resolve_path().path == Path("x.failed2.nc")


def test_a_writer_that_fails_leaves_what_was_there(folder: Path) -> None:
    write_text(output("x.txt"), "before")
    before = Path("x.txt").read_text()

    def fill(path: Path) -> None:
        path.write_text("half")
        raise OSError("no room")

    said = r"x\.txt: cannot be written \(no room; .* MB are free"
    with pytest.raises(WritingError, match=said), output("x.txt").write_complete() as path:
        fill(path)
    assert Path("x.txt").read_text() == before
    assert sorted(os.listdir()) == ["sub", "x.txt"]


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM, signal.SIGHUP])
def test_signals_wait_until_a_file_is_written(folder: Path, number: int) -> None:
    def interrupt(*_: object) -> None:
        raise KeyboardInterrupt

    def hit(path: Path) -> None:
        signal.raise_signal(number)
        path.write_text("whole")

    before = signal.signal(number, interrupt)
    try:
        with pytest.raises(KeyboardInterrupt), output("x.txt").write_complete() as path:
            hit(path)
    finally:
        signal.signal(number, before)
    assert Path("x.txt").read_text() == "whole"


def test_an_interrupt_that_was_lost_is_remembered() -> None:
    """Libraries swallow exceptions: the next part of the work is not begun all the same."""
    before = {number: signal.getsignal(number) for number in ENDING_SIGNALS}
    try:
        signal.signal(signal.SIGINT, signal.default_int_handler)  # it may be ignored
        install_signal_handlers()
        raise_if_interrupted()
        with suppress(KeyboardInterrupt):
            signal.raise_signal(signal.SIGINT)
        with pytest.raises(KeyboardInterrupt):
            raise_if_interrupted()
        install_signal_handlers()
        raise_if_interrupted()
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)


def test_what_a_killed_process_left_is_removed_by_the_next(folder: Path) -> None:
    """But not what another one is writing."""
    read, write = os.pipe()
    pid = os.fork()
    if pid == 0:
        with output("x.txt").write_complete() as path:
            path.write_text("half")
            os.write(write, b"!")
            signal.pause()
    os.read(read, 1)
    write_text(output("x.txt"), "whole")
    (left,) = folder.glob(".hydrosim-x.txt-*")
    assert (left / "x.txt").read_text() == "half"
    os.kill(pid, signal.SIGKILL)
    os.waitpid(pid, 0)
    write_text(output("x.txt"), "again")
    assert {path.name for path in folder.iterdir()} == {"sub", "x.txt"}
    assert "again" in Path("x.txt").read_text()


def test_a_lock_on_a_full_disk_is_told_and_does_not_stay(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def full(*_: object) -> int:
        raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr(os, "write", full)
    said = r"a\.nc: cannot be written \(No space left on device; .* MB are free there\)\. Free some"
    with (
        pytest.raises(WritingError, match=said),
        Output(tmp_path / "a.nc", "run", tmp_path).hold_lock(),
    ):
        pass
    assert list(tmp_path.iterdir()) == []


def test_a_permission_that_is_there_is_not_blamed(tmp_path: Path) -> None:
    """netCDF says "Permission denied" of a file that it cannot make on a full disk."""
    denied = PermissionError(errno.EACCES, "Permission denied")
    said = str(unwritable(tmp_path / "a.nc", denied))
    assert "Permission denied" not in said
    assert "Free some space, or write to another place" in said


def test_names_of_a_thousand_characters_are_cut() -> None:
    said = str(hs.InputError(f"case.yaml: found no file {'x' * 5000}; expected one"))
    assert said == f"case.yaml: found no file {'x' * 300}...; expected one"


def test_shipped_pictures_name_no_folder_of_their_maker() -> None:
    """A picture names its origin; at most from the folder above."""
    pictures = [
        path for folder in ("cases", "hydro_db", "docs") for path in (ROOT / folder).rglob("*.png")
    ]
    assert len(pictures) > 10
    texts = {path: path.read_bytes() for path in pictures}
    assert [
        path.name for path, text in texts.items() if re.search(rb"of \[(\.\./\.\.|/)", text)
    ] == []
