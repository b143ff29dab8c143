"""Runs `hydrosim` in this process, as the installed script does, and programs in processes of their
own."""

import os
import signal
import subprocess
import sys
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any, NamedTuple

import pytest
import typer

from hydrosim.__main__ import app, main
from hydrosim.cli import terminal

NEVER = 1e6
"""Time [s] after which no test runs any more."""


class Result(NamedTuple):
    """Exit code of a command, and what it wrote on the terminal, blanks and line ends as one."""

    code: int
    out: str
    err: str


@cache
def built_commands() -> Any:
    """All commands. To build them takes a twentieth of a second, each time that one is run."""
    return typer.main.get_command(app)


Command = Callable[..., Result]


def command(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], *first: str
) -> Command:
    """Runs the command with these first arguments and those it is called with. It says nothing of
    its progress, as that depends on the machine."""

    monkeypatch.setattr(terminal, "FIRST_LINE_S", NEVER)
    monkeypatch.setattr("hydrosim.__main__.app", built_commands())

    def run(*arguments: object) -> Result:
        monkeypatch.setattr(sys, "argv", ["hydrosim", *first, *map(str, arguments)])
        with pytest.raises(SystemExit) as caught:
            main()
        out, err = (" ".join(text.split()) for text in capsys.readouterr())
        return Result(int(caught.value.code or 0), out, err)

    return run


def succeeds(command: Command, *arguments: object) -> str:
    """What a command prints that does what it should."""
    result = command(*arguments)
    assert result.code == 0, result.err
    return result.out


def refusal(command: Command, folder: Path, *arguments: object) -> str:
    """The error of a command that prints nothing else and changes nothing on the disk."""
    before = files(folder)
    result = command(*arguments)
    assert (result.code, result.out) == (2, "")
    assert "Traceback" not in result.err
    assert files(folder) == before
    return result.err


def printed(program: str, *arguments: str, folder: Path | None = None, **environment: str) -> str:
    """What a program of Python prints in a new process, which must not fail."""
    done = subprocess.run(
        [sys.executable, "-c", program, *arguments],
        cwd=folder,
        env={**os.environ, **environment},
        capture_output=True,
        text=True,
    )
    assert done.returncode == 0, done.stderr
    return done.stdout


def without_progress(text: str) -> str:
    """What a command said, but for how far it was."""
    lines = text.splitlines(keepends=True)
    return "".join(line for line in lines if not line.endswith(" s so far)\n"))


def heed_signals() -> None:
    """In a process that begins: what a shell has its jobs in the background ignore is heeded."""
    for number in (signal.SIGINT, signal.SIGHUP):
        signal.signal(number, signal.SIG_DFL)


def files(folder: Path) -> dict[str, bytes]:
    """All files in a folder and below, with what is in them."""
    return {str(p.relative_to(folder)): p.read_bytes() for p in folder.rglob("*") if p.is_file()}
