"""What is printed can be printed, wherever that is, and steers no terminal."""

import ast
import os
import pty
import re
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
import xarray as xr
from command_line import without_progress
from rich.table import Table
from scenes import SWINGING_BLOCK
from typer.main import get_command

from hydrosim.__main__ import app
from hydrosim.cli.earlier import OTHER_OPTIONS
from hydrosim.cli.terminal import print_lines
from hydrosim.files.document import printable

ROOT = Path(__file__).parents[2]
CASE = ROOT / "cases" / "sphere" / "decay.yaml"
BLOCK = SWINGING_BLOCK.replace("20 s", "2 s")


@pytest.mark.parametrize(
    ("text", "shown"),
    [
        ("heave [m], 20°\n\tand on", "heave [m], 20°\n\tand on"),
        ("\x1b[2Jgone", "\\u001b[2Jgone"),
        ("a\u202eb", "a\\u202eb"),
        ("\udcff.nc", "\\udcff.nc"),
        ("a b", "a b"),
    ],
)
def test_what_steers_is_shown_as_its_number(text: str, shown: str) -> None:
    assert printable(text) == shown


def test_what_steers_is_shown_in_tables_too(capsys: pytest.CaptureFixture[str]) -> None:
    table = Table("\x1b[2Jname", title="a\u202eb")
    table.add_row("\x9b31m")
    print_lines(table)
    shown = capsys.readouterr().out
    for text in ("\\u001b[2Jname", "a\\u202eb", "\\u009b31m"):
        assert text in shown
    assert printable(shown) == shown


def said(*arguments: str, **environment: str) -> subprocess.CompletedProcess[str]:
    command = [sys.executable, "-m", "hydrosim", *arguments]
    known = {"PYTHONPATH": str(ROOT), **os.environ}
    return subprocess.run(
        command, env={**known, **environment}, capture_output=True, text=True, check=False
    )


@pytest.mark.slow
def test_a_terminal_of_few_characters() -> None:
    done = said("check", str(CASE), PYTHONIOENCODING="ascii")
    assert (done.returncode, without_progress(done.stderr)) == (0, "")
    assert done.stdout.isascii()


@pytest.mark.skipif(not os.path.exists("/dev/full"), reason="there is no full device")
def test_a_full_disk_behind_the_terminal() -> None:
    with open("/dev/full", "w") as full:
        command = [sys.executable, "-m", "hydrosim", "check", str(CASE)]
        done = subprocess.run(command, stdout=full, stderr=subprocess.PIPE, text=True, check=False)
    assert done.returncode == 3
    said = without_progress(done.stderr)
    assert said == "error [Errno 28] No space left on device\n"


def run_completely(folder: Path, **streams: Any) -> None:
    """A run in a process with these streams writes its whole result."""
    (folder / "case.yaml").write_text(BLOCK)
    command = [sys.executable, "-m", "hydrosim", "run", "case.yaml", "-o", "run.nc"]
    known = {"PYTHONPATH": str(ROOT), **os.environ}
    subprocess.run(command, cwd=folder, env=known, check=True, **streams)
    assert xr.load_dataset(folder / "run.nc").attrs["status"] == "complete"


@pytest.mark.parametrize("closed", [(1,), (2,), (0, 1, 2)])
@pytest.mark.slow
def test_closed_streams_lose_nothing(tmp_path: Path, closed: tuple[int, ...]) -> None:
    """The next file that is opened, a result perhaps, must not take their place, either."""
    run_completely(tmp_path, preexec_fn=lambda: [os.close(descriptor) for descriptor in closed])


@pytest.mark.slow
def test_who_has_seen_enough_ends_no_run(tmp_path: Path) -> None:
    read, write = os.pipe()
    os.close(read)
    run_completely(tmp_path, stdout=write, stderr=write)
    os.close(write)


def test_a_warning_is_a_line_of_its_own_kind(tmp_path: Path) -> None:
    """As of a cache that is not safe, which the units of a case ask for."""
    (tmp_path / "cache").mkdir()
    (tmp_path / "cache").chmod(0o777)
    (tmp_path / "x.yaml").write_text("title: x\nduration: 20 lightyear\n")
    done = said("check", str(tmp_path / "x.yaml"), HYDROSIM_CACHE_DIR=str(tmp_path / "cache"))
    first, *_ = done.stderr.splitlines()
    assert first.startswith(f"warning   the cache folder {tmp_path / 'cache'} is not used: others")
    assert "Warning" not in done.stderr
    assert done.returncode == 2


@pytest.mark.parametrize(
    ("typed", "offered"), [("rep", {"replay", "report"}), ("plot --fo", {"--format"})]
)
def test_shells_complete_commands_and_options(typed: str, offered: set[str]) -> None:
    words = f"hydrosim {typed}"
    asked = {
        "_HYDROSIM_COMPLETE": "complete_bash",
        "COMP_WORDS": words,
        "COMP_CWORD": str(words.count(" ")),
    }
    command = [sys.executable, "-m", "hydrosim"]
    done = subprocess.run(command, env={**os.environ, **asked}, capture_output=True, text=True)
    assert set(done.stdout.split()) == offered


def helps(command: Any, name: str) -> Iterator[tuple[str, str]]:
    """All texts of help of a command and of those below it."""
    yield name, command.help or ""
    for option in command.params:
        yield f"{name} {option.name}", getattr(option, "help", None) or ""
    for own, one in getattr(command, "commands", {}).items():
        yield from helps(one, f"{name} {own}")


def test_no_help_has_brackets_which_rich_would_take_for_markup() -> None:
    """[s] would begin a style, and vanish."""
    each = dict(helps(get_command(app), "hydrosim"))
    assert len(each) > 100
    assert [name for name, text in each.items() if "[" in text] == []
    assert [name for name, text in each.items() if text and not text.rstrip().endswith(".")] == []


def test_each_text_of_help_is_that_of_one_option() -> None:
    """A text that was copied to another option is wrong there."""
    names: dict[str, set[str]] = {}
    for place, text in helps(get_command(app), "hydrosim"):
        names.setdefault(text, set()).add(place.split(" ")[-1])
    assert names['Ignore everything after this time: "1 hour", or a number in seconds.'] == {"end"}
    assert {text: own for text, own in names.items() if text and len(own) > 1} == {}


def test_names_that_are_no_text_are_refused(tmp_path: Path) -> None:
    name = os.fsencode(tmp_path) + b"/b\xff.yaml"
    Path(os.fsdecode(name)).write_text(BLOCK)
    (tmp_path / "b.yaml").write_text(BLOCK)
    good = os.fsencode(tmp_path / "b.yaml")
    for arguments in ([b"run", name], [b"run", good, b"-o", name], [b"plot", name]):
        done = subprocess.run([sys.executable, "-m", "hydrosim", *arguments], capture_output=True)
        assert done.returncode == 2
        assert b"b\\xff.yaml: found a name whose bytes are no UTF-8; expected" in done.stderr


def options(command: Any) -> Iterator[str]:
    """The long names of the options of a command and of those below it."""
    for parameter in command.params:
        names = (*parameter.opts, *parameter.secondary_opts)
        yield from (name for name in names if name.startswith("--"))
    for below in getattr(command, "commands", {}).values():
        yield from options(below)


def test_options_that_messages_name_exist() -> None:
    """Those in all texts of the package; --keep is of the benchmarks, others of other programs."""
    known = {*options(get_command(app)), "--help", "--keep", *OTHER_OPTIONS}
    named = {
        (path.name, option)
        for path in sorted((ROOT / "hydrosim").rglob("*.py"))
        for node in ast.walk(ast.parse(path.read_text("utf-8")))
        if isinstance(node, ast.Constant) and isinstance(node.value, str)
        for option in re.findall(r"(?<![\w-])--[a-z][a-z-]+", node.value)
    }
    assert len(named) > 30
    assert {(file, option) for file, option in named if option not in known} == set()


def test_a_terminal_may_be_closed_before_all_is_printed() -> None:
    """A process that outlives its terminal goes on printing to nobody."""
    script = (
        "import signal, sys, time; gone = [];"
        "signal.signal(signal.SIGHUP, lambda *_: gone.append(1));"
        "from hydrosim.cli.terminal import make_streams_last; make_streams_last();"
        "print('ready', flush=True);"
        "[time.sleep(0.01) for _ in range(1000) if not gone];"
        "print('lost', flush=True); sys.exit(7)"
    )
    process, here = pty.fork()
    if process == 0:
        os.execve(
            sys.executable, [sys.executable, "-c", script], {**os.environ, "PYTHONPATH": str(ROOT)}
        )
    assert os.read(here, 100).startswith(b"ready")
    os.close(here)
    assert os.waitstatus_to_exitcode(os.waitpid(process, 0)[1]) == 7
