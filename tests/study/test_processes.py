"""Sweeps by processes of this machine: nobody can reach them, and they come to the file of threads.
A process that dies takes no other run with it."""

import os
import signal
import time
from collections.abc import Iterator
from functools import partial
from pathlib import Path
from threading import Thread
from unittest.mock import Mock

import psutil
import pytest
import xarray as xr
from command_line import Command
from scenes import CASES, SEA, in_contact, in_waves

from hydrosim.compare.dataset import differences
from hydrosim.errors import InputError
from hydrosim.scene import WaveTrain
from hydrosim.study.executors import Processes, _serve_process
from hydrosim.study.scene_cache import RunTask, SceneCache

FATAL, REFUSED = 3, 5  # seeds


@pytest.fixture
def sweep(hydrosim: Command) -> Command:
    text = f"case: {CASES}/base.yaml\nduration: 20 s\nseeds: 1-24\noutput: {{step: 1 s}}\n"
    Path("study.yaml").write_text(text)
    return partial(hydrosim, "sweep", "study.yaml", "--workers", "2")


def look_and_kill(kept: Path, listening: list[object]) -> None:
    """Once runs come in, see what the processes listen on, and kill one of them."""
    for _ in range(3000):
        if kept.exists() and kept.stat().st_size > 5000:
            break
        time.sleep(0.02)
    own = psutil.Process()
    children = [each for each in own.children() if "spawn_main" in " ".join(each.cmdline())]
    for process in (own, *children):
        sockets = process.net_connections("all")
        listening += [each for each in sockets if each.status == psutil.CONN_LISTEN]
    children[0].kill()


@pytest.mark.slow
def test_nobody_can_reach_the_processes_of_a_sweep(sweep: Command) -> None:
    """One of them is killed: its run is made again, and the file is that of threads."""
    listening: list[object] = []
    other = Thread(target=look_and_kill, args=(Path("there.nc.partial") / "runs", listening))
    other.start()
    result = sweep("-o", "there.nc", "--scheduler", "local")
    other.join()
    assert result.code == 0, result.err
    assert listening == []
    assert sweep("-o", "here.nc").code == 0
    with xr.open_dataset("here.nc") as here, xr.open_dataset("there.nc") as there:
        assert list(differences(here, there)) == []


@pytest.fixture
def pool() -> Iterator[Processes]:
    processes = Processes(2)
    yield processes
    processes.shutdown()


def fatal_digest(run: xr.Dataset) -> xr.Dataset:
    """Kills its process, or raises, for one seed each."""
    if run.attrs["seeds"] == [FATAL]:
        os.kill(os.getpid(), signal.SIGKILL)
    if run.attrs["seeds"] == [REFUSED]:
        raise InputError("variables: found nothing")
    return run[["position"]]


@pytest.mark.parametrize("error", [EOFError, ConnectionResetError])
def test_a_process_whose_parent_has_gone_ends_without_a_word(error: type[Exception]) -> None:
    """The pipe is closed where the parent has ended, and reset where it was killed."""
    pipe = Mock(recv=Mock(side_effect=error))
    _serve_process(pipe, Mock())
    pipe.send.assert_not_called()


@pytest.mark.slow
def test_a_run_that_kills_its_processes_has_failed_and_no_other(pool: Processes) -> None:
    """Runs end where they are cancelled."""
    cache = SceneCache()
    scenes = [in_waves(in_contact(20.0), WaveTrain(SEA, seed=k)) for k in range(7)]
    tasks = [task for scene in scenes if isinstance(task := cache.compile_task(scene), RunTask)]
    assert len(tasks) == 7
    found = [pool.submit(task, fatal_digest) for task in tasks]
    ends = [future.exception() or future.result().status for future in found]
    assert ends[FATAL] == "failed"
    assert "its process ended without an answer, 2 times" in found[FATAL].result().message
    assert isinstance(ends[REFUSED], InputError)
    assert [ends[k] for k in range(7) if k not in (FATAL, REFUSED)] == ["complete"] * 5
    last = [pool.submit(tasks[0], fatal_digest) for _ in range(50)]
    pool.shutdown(cancel_futures=True)
    assert all(future.done() for future in last)
    assert last[-1].result().status == "not run"
