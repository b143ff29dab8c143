"""Commands that are ended from outside, by real signals, and go on."""

import os
import pty
import resource
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path

import pytest
import xarray as xr
from command_line import heed_signals
from scenes import SWINGING_BLOCK

import hydrosim as hs
from hydrosim.compare.dataset import differences
from hydrosim.files.interrupts import ENDING_SIGNALS
from hydrosim.study.many_runs import run_study
from hydrosim.study.sweep import load_study

pytestmark = pytest.mark.slow

SLOW = SWINGING_BLOCK.replace("step: 0.02 s", "step: 4e-6 s")
LONGEST = 120.0  # s that a signal or a file is waited for, on a busy machine


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    Path("slow.yaml").write_text(SLOW)
    return tmp_path


def started(*arguments: str, before: Callable[[], None] = heed_signals) -> subprocess.Popen[str]:
    command = [sys.executable, "-m", "hydrosim", *arguments]
    return subprocess.Popen(
        command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, preexec_fn=before
    )


def wait_for(path: Path, changed_from: int, process: subprocess.Popen[str]) -> None:
    begun = time.monotonic()
    while not path.exists() or path.stat().st_mtime_ns == changed_from:
        assert process.poll() is None, process.communicate()
        assert time.monotonic() - begun < LONGEST
        time.sleep(0.02)


def test_a_run_ended_by_every_signal(folder: Path) -> None:
    """Stopped, hung up and killed one after the other, each time once it has come further."""
    path = Path("slow.nc.checkpoint")
    for number in (signal.SIGTERM, signal.SIGHUP, signal.SIGKILL):
        more = ["--resume"] if path.exists() else []
        before = path.stat().st_mtime_ns if path.exists() else 0
        run = started("run", "slow.yaml", "--checkpoint", "0.1", *more)
        wait_for(path, before, run)
        run.send_signal(number)
        _, told = run.communicate(timeout=LONGEST)
        assert "Traceback" not in told
        if number == signal.SIGKILL:
            assert run.returncode == -signal.SIGKILL
        else:
            assert run.returncode == 130
            assert xr.load_dataset("slow.nc").attrs["status"] == "interrupted"
    run = started("run", "slow.yaml", "--resume")
    _, told = run.communicate(timeout=LONGEST)
    assert run.returncode == 0
    assert "the run continues from slow.nc.checkpoint" in told
    assert not path.exists()
    assert differences(hs.open_run("slow.nc"), hs.simulate(hs.load_case("slow.yaml"))) == []
    assert sorted(os.listdir()) == ["slow.nc", "slow.yaml"]


def test_an_interrupt_while_modules_are_loaded(folder: Path) -> None:
    """No traceback: the module is one of the first that the command loads."""
    Path("typer.py").write_text("import signal; signal.raise_signal(signal.SIGINT)")
    ended = started("run", "slow.yaml")
    _, told = ended.communicate(timeout=LONGEST)
    assert ended.returncode == -signal.SIGINT
    assert told == ""


@pytest.mark.parametrize("number", ENDING_SIGNALS)
def test_a_signal_after_the_end_of_a_command(number: int) -> None:
    """The exit code is known, and stays."""
    program = f"""
import atexit, signal, sys
from hydrosim.__main__ import main

atexit.register(signal.raise_signal, {number})
sys.argv = ["hydrosim", "--version"]
main()
"""
    command = [sys.executable, "-c", program]
    ended = subprocess.run(command, capture_output=True, text=True, preexec_fn=heed_signals)
    assert (ended.returncode, ended.stderr) == (0, "")


STUDY = """\
case: short.yaml
parameters:
  forces.spring.stiffness.surge: [1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12]
"""
SHORT = SLOW.replace("4e-6 s", "1e-4 s")


@pytest.fixture
def study(folder: Path) -> Path:
    Path("short.yaml").write_text(SHORT)
    Path("study.yaml").write_text(STUDY)
    return folder


def whole(study: str) -> xr.Dataset:
    """The study as one that is not stopped; what says where it came from is as in a command's."""
    return run_study(load_study(study), Path("whole.nc")).load()


def test_a_sweep_that_is_killed(study: Path) -> None:
    sweep = started("sweep", "study.yaml", "--workers", "1")
    wait_for(Path("study.nc.partial") / "first.nc", 0, sweep)
    sweep.kill()
    sweep.communicate(timeout=LONGEST)
    assert not Path("study.nc").exists()
    again = started("sweep", "study.yaml", "--resume")
    assert again.wait(LONGEST) == 0
    assert not Path("study.nc.partial").exists()
    assert differences(xr.load_dataset("study.nc"), whole("study.yaml")) == []


def on_a_full_disk(size: int) -> Callable[[], None]:
    """Files of the process can have so many bytes."""
    return lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (size, size))


def test_a_full_disk(study: Path) -> None:
    """One message, and what was there stays; what is done goes on where there is room."""
    assert started("run", "short.yaml").wait(LONGEST) == 0
    before = Path("short.nc").read_bytes()
    for arguments in (("run", "short.yaml"), ("sweep", "study.yaml")):
        full = started(*arguments, before=on_a_full_disk(30_000))
        printed, told = full.communicate(timeout=LONGEST)
        assert full.returncode == 3, told
        assert printed == ""
        (line,) = (line for line in told.splitlines() if line.startswith("error "))
        assert "cannot be written" in line
        assert ("--resume continues" in told) == (arguments[0] == "sweep")
        assert "Traceback" not in told
    assert Path("short.nc").read_bytes() == before
    assert not Path("study.nc").exists()
    assert started("sweep", "study.yaml", "--resume").wait(LONGEST) == 0
    assert differences(xr.load_dataset("study.nc"), whole("study.yaml")) == []
    names = {path.name for path in study.iterdir()}
    assert names == {"short.nc", "short.yaml", "slow.yaml", "study.nc", "study.yaml", "whole.nc"}


def test_a_terminal_that_is_closed(folder: Path) -> None:
    """There is nowhere to write messages to; what was computed is written all the same."""
    process, here = pty.fork()
    if process == 0:
        heed_signals()
        command = [sys.executable, "-m", "hydrosim", "run", "slow.yaml", "--checkpoint", "0.1"]
        os.execv(sys.executable, command)
    os.set_blocking(here, False)
    while not Path("slow.nc.checkpoint").exists():
        time.sleep(0.02)
        with suppress(BlockingIOError):
            os.read(here, 100_000)
    os.close(here)  # the system sends SIGHUP to the session
    assert os.waitstatus_to_exitcode(os.waitpid(process, 0)[1]) == 130
    assert xr.load_dataset("slow.nc").attrs["status"] == "interrupted"
