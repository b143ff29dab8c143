"""Commands that are ended from outside, by real signals, and go on."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest
import xarray as xr

import hydrosim as hs
from hydrosim.compare.exact import differences

SLOW = """\
title: Swinging block, in steps of a few microseconds
duration: 20 s
bodies:
  block: {mass: 2 kg, dofs: [surge], initial: {position: [0.3 m, 0, 0, 0, 0, 0]}}
forces:
  spring: {type: linear_mooring, body: block, stiffness: {surge: 5 N/m}}
solver: {step: 4e-6 s, linear: step}
output: {step: 0.1 s}
"""
LONGEST = 120.0  # s that a signal or a file is waited for, on a busy machine


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    Path("slow.yaml").write_text(SLOW)
    return tmp_path


def started(*arguments: str) -> subprocess.Popen[str]:
    command = [sys.executable, "-m", "hydrosim", *arguments]
    return subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)


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
    assert "the run goes on from slow.nc.checkpoint" in told
    assert not path.exists()
    assert differences(xr.load_dataset("slow.nc"), hs.simulate(hs.load_case("slow.yaml"))) == []
    assert sorted(os.listdir()) == ["slow.nc", "slow.yaml"]
