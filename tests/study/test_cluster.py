"""Sweeps by dask.distributed: a scheduler and workers over TCP come to the same file as threads
here, also where a worker dies; who does not answer, or has another program, is refused."""

import json
import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import partial
from pathlib import Path
from threading import Thread
from typing import Any, cast

import pytest
from command_line import Command, refusal
from scenes import CASES, SEA, in_contact, in_waves

from hydrosim.compare.dataset import differences
from hydrosim.errors import InputError
from hydrosim.results.runs_file import RunOutcome
from hydrosim.scene import WaveTrain
from hydrosim.study.cluster import Cluster, make_run
from hydrosim.study.scene_cache import RunTask

pytest.importorskip("distributed")
import xarray as xr

pytestmark = pytest.mark.slow

ROOT = CASES.parents[1]


def started(module: str, *arguments: object, **environment: str) -> subprocess.Popen[bytes]:
    """A scheduler or a worker in a process of its own."""
    path = os.pathsep.join([str(ROOT), os.environ.get("PYTHONPATH", "")])
    return subprocess.Popen(
        [sys.executable, "-m", f"distributed.cli.{module}", *map(str, arguments), "--no-dashboard"],
        env={**os.environ, "PYTHONPATH": path, **environment},
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
    )


@pytest.fixture(scope="module")
def cluster(tmp_path_factory: pytest.TempPathFactory) -> Iterator[tuple[str, list[int]]]:
    with running(tmp_path_factory.mktemp("cluster"), 2) as found:
        yield found


@contextmanager
def running(folder: Path, count: int) -> Iterator[tuple[str, list[int]]]:
    """The address of a scheduler and the processes of its workers."""
    file = folder / "scheduler.json"
    where = "--host", "127.0.0.1", "--port", 0, "--scheduler-file", file
    processes = [started("dask_scheduler", *where)]
    try:
        for _ in range(300):
            if file.exists() and file.stat().st_size:
                break
            time.sleep(0.1)
        address = json.loads(file.read_text())["address"]
        alone = "--nthreads", 1, "--no-nanny", "--host", "127.0.0.1"
        processes += [started("dask_worker", address, *alone) for _ in range(count)]
        import distributed

        with distributed.Client(address, set_as_default=False) as client:
            client.wait_for_workers(count, timeout=60)
        yield address, [process.pid for process in processes[1:]]
    finally:
        for process in processes:
            process.kill()
            process.wait()


def kill_when(kept: Path, size: int, process: int) -> None:
    """Kill a process once so many bytes of runs are kept, but not all."""
    for _ in range(3000):
        if kept.exists() and kept.stat().st_size > size:
            os.kill(process, signal.SIGKILL)
            return
        time.sleep(0.02)


@pytest.fixture
def sweep(hydrosim: Command) -> Command:
    text = f"case: {CASES}/base.yaml\nduration: 20 s\nseeds: 1-24\noutput: {{step: 1 s}}\n"
    figures = "figures: {end: {channel: position.barge.surge, statistic: end}}\n"
    Path("study.yaml").write_text(text + figures)
    return partial(hydrosim, "sweep")


def test_workers_over_tcp_make_the_same_file(
    cluster: tuple[str, list[int]], sweep: Command
) -> None:
    """Then one of them is killed in the middle of a study, and the other makes its runs again."""
    address, workers = cluster
    assert sweep("study.yaml", "-o", "here.nc").code == 0
    result = sweep("study.yaml", "-o", "there.nc", "--scheduler", address)
    assert result.code == 0, result.err
    assert "2 workers at tcp://127.0.0.1" in result.err
    assert "run whatever is sent to them" in result.err
    killer = Thread(target=kill_when, args=(Path("again.nc.partial") / "runs", 5000, workers[0]))
    killer.start()
    again = sweep("study.yaml", "-o", "again.nc", "--scheduler", address)
    killer.join()
    assert again.code == 0, again.err
    with xr.open_dataset("here.nc") as here:
        for name in ("there.nc", "again.nc"):
            with xr.open_dataset(name) as there:
                assert list(differences(here, there)) == []


def test_nobody_answers(sweep: Command) -> None:
    begun = time.monotonic()
    said = refusal(sweep, Path(), "study.yaml", "--scheduler", "tcp://127.0.0.1:9")
    assert "found tcp://127.0.0.1:9, which does not answer" in said
    assert time.monotonic() - begun < 30.0  # the runs would not begin to be made in that time


def test_a_scheduler_with_tls_needs_a_certificate(sweep: Command) -> None:
    said = refusal(sweep, Path(), "study.yaml", "--scheduler", "tls://127.0.0.1:9")
    assert "dask is told of no certificate; expected one for tls://" in said


def test_another_program_is_refused(
    cluster: tuple[str, list[int]], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("hydrosim.study.cluster.program_identity", lambda: "hydrosim 0.0.9")
    with pytest.raises(InputError, match=r"with another program \(hydrosim .*expected hydrosim 0"):
        Cluster(cluster[0])
    with pytest.raises(InputError, match=r"a worker with hydrosim 0.0.9; expected another"):
        make_run("another", None, None, None)  # type: ignore[arg-type]


def test_a_client_that_was_killed_goes_on(cluster: tuple[str, list[int]], sweep: Command) -> None:
    """With the runs that came back before."""
    address, _ = cluster
    long = Path("study.yaml").read_text().replace("20 s", "600 s")
    Path("study.yaml").write_text(long)
    path = os.pathsep.join([str(ROOT), os.environ.get("PYTHONPATH", "")])
    arguments = "-m", "hydrosim", "sweep", "study.yaml", "-o", "runs.nc", "--scheduler", address
    client = subprocess.Popen(
        [sys.executable, *arguments],
        env={**os.environ, "PYTHONPATH": path},
        stderr=subprocess.DEVNULL,
        stdout=subprocess.DEVNULL,
    )
    kept = Path("runs.nc.partial") / "runs"
    kill_when(kept, 5000, client.pid)
    client.wait()
    assert kept.stat().st_size > 5000
    assert sweep("study.yaml", "-o", "runs.nc", "--scheduler", address, "--resume").code == 0
    assert sweep("study.yaml", "-o", "here.nc").code == 0
    with xr.open_dataset("here.nc") as here, xr.open_dataset("runs.nc") as there:
        assert list(differences(here, there)) == []


def test_nobody_is_waited_for_where_no_worker_is_left(
    sweep: Command, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The only one dies: what it has made is kept, and the rest is made here."""
    monkeypatch.setattr("hydrosim.study.cluster.NO_WORKER_TIMEOUT_S", 10.0)
    monkeypatch.setattr("hydrosim.study.cluster.POLL_INTERVAL_S", 0.2)
    kept = Path("runs.nc.partial") / "runs"
    with running(tmp_path, 1) as (address, workers):
        killer = Thread(target=kill_when, args=(kept, 5000, workers[0]))
        killer.start()
        result = sweep("study.yaml", "-o", "runs.nc", "--scheduler", address)
        killer.join()
    assert result.code == 2
    assert "no worker has been there for 10 s" in result.err
    assert kept.stat().st_size > 5000
    assert sweep("study.yaml", "-o", "runs.nc", "--resume").code == 0


class KilledWorker(Exception):
    """What dask says of a task whose workers died, by the same name."""


class Task:
    """A run on its way, whose end the test says."""

    def __init__(self) -> None:
        self.status = "pending"
        self.calls: list[Callable[[Task], None]] = []

    def add_done_callback(self, call: Callable[["Task"], None]) -> None:
        self.calls.append(call)

    def end(self, status: str) -> None:
        self.status = status
        for call in self.calls:
            call(self)

    def result(self) -> RunOutcome:
        return RunOutcome("complete")

    def exception(self) -> Exception:
        return KilledWorker()


class Client:
    """In place of dask: what was sent."""

    def __init__(self) -> None:
        self.sent: list[Task] = []

    def submit(self, *_: object, pure: bool) -> Task:
        self.sent.append(Task())
        return self.sent[-1]


@pytest.fixture
def client(monkeypatch: pytest.MonkeyPatch) -> Client:
    client = Client()
    monkeypatch.setattr(Cluster, "_connect", lambda *_: client)
    monkeypatch.setattr(Cluster, "_count_workers", lambda _: 1)
    return client


def tasks(count: int) -> list[RunTask]:
    scenes = [in_waves(in_contact(20.0), WaveTrain(SEA, seed=k)) for k in range(count)]
    calm = cast(Any, object())
    return [RunTask(scene, calm) for scene in scenes]


def test_a_run_that_kills_its_workers_alone_has_failed(client: Client) -> None:
    """Six runs are given up, as dask blames what waits beside the one that kills: each is made once
    more, with nothing beside it; the one that kills then, too, has failed."""
    pool = Cluster("tcp://nobody")
    found = [pool.submit(task, cast(Any, None)) for task in tasks(7)]
    *given_up, last = client.sent[1:]  # the first is what is compiled, once for all
    assert len(given_up) == 6
    for task in given_up:
        task.end("error")
    assert client.sent[-1] is last  # nothing is tried while something else is on its way
    last.end("finished")
    for k in range(6):
        assert len(client.sent) == 9 + k
        client.sent[-1].end("error" if k == 2 else "finished")
    assert len(client.sent) == 14
    status = [future.result(timeout=0).status for future in found]
    assert status == ["failed" if k == 2 else "complete" for k in range(7)]
    assert "the workers that made this run died" in found[2].result().message


def test_runs_that_are_cancelled_are_not_run(client: Client) -> None:
    """On their way, or given up; what comes later is not looked at."""
    pool = Cluster("tcp://nobody")
    found = [pool.submit(task, cast(Any, None)) for task in tasks(3)]
    first, other, last = client.sent[1:]
    first.end("finished")
    other.end("error")
    pool.shutdown(cancel_futures=True)
    last.end("finished")
    assert [future.result(timeout=0).status for future in found] == ["complete", *["not run"] * 2]
