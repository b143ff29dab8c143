"""Signals that come while machine code runs: they wait for it, or the torn step is thrown away.

A run that is stopped and goes on comes to the result of one that was never stopped, to the bit.
"""

import os
import signal
import sys
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from types import CodeType, FrameType
from typing import Any

import numpy as np
import pytest
import xarray as xr
from markers import few
from scenes import in_contact

import hydrosim as hs
from hydrosim.__main__ import main
from hydrosim.compare.dataset import differences
from hydrosim.files.interrupts import ENDING_SIGNALS, install_signal_handlers
from hydrosim.files.outputs import Output
from hydrosim.jit import linking, outside
from hydrosim.run.checkpoint import Checkpoint

SCENE = in_contact(20.0)
PUSHED = replace(
    SCENE, forces={**SCENE.forces, "push": hs.UserForce("barge", lambda t, _: [1e5, 0, 0, 0, 0, 0])}
)
DOORS = 31  # roots of a run with a contact, about
MOMENTS = 12
LATEST = 0.4  # s


@pytest.fixture(autouse=True)
def heeded() -> Iterator[None]:
    """Signals as the command takes them, from their defaults on."""
    before = {number: signal.getsignal(number) for number in ENDING_SIGNALS}
    try:
        for number in ENDING_SIGNALS:
            default = number == signal.SIGINT
            signal.signal(number, signal.default_int_handler if default else signal.SIG_DFL)
        install_signal_handlers()
        yield
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)
        install_signal_handlers()  # what came is forgotten
        for number, handler in before.items():
            signal.signal(number, handler)


def shut_doors() -> None:
    """Let machine code look for all others anew, as in a new process."""
    for door in linking._doors.values():
        door.code.value = None


def run_from(folder: Path, scene: hs.Scene) -> xr.Dataset | None:
    """The run from a checkpoint, or its start; None if it was interrupted before it began."""
    output = Output(folder / "x.nc.checkpoint", "checkpoint", folder / "x.yaml")
    try:
        return hs.simulate(scene, None, Checkpoint(output, 0.0, True, [].append))
    except KeyboardInterrupt:
        return None


@contextmanager
def at_entry(code: CodeType, number: int, act: Callable[[], None]) -> Iterator[list[int]]:
    """Call ``act`` where a function with this code is entered for the ``number``-th time. Yields
    a list whose length is the count of entries."""
    entries: list[int] = []

    def trace(frame: FrameType, event: str, _: Any) -> None:
        if frame.f_code is code and event == "call":
            entries.append(1)
            if len(entries) == number:
                act()

    before = sys.gettrace()
    sys.settrace(trace)
    try:
        yield entries
    finally:
        sys.settrace(before)


def terminate() -> None:
    """A signal that Python serves at once."""
    signal.raise_signal(signal.SIGTERM)


def stopped_at(
    code: CodeType, number: int, folder: Path, scene: hs.Scene, act: Callable[[], None] = terminate
) -> tuple[xr.Dataset | None, int]:
    """The run that is signalled at this entry, and the number of entries."""
    shut_doors()
    with at_entry(code, number, act) as entries:
        run = run_from(folder, scene)
    return run, len(entries)


@pytest.fixture(scope="module")
def whole() -> xr.Dataset:
    """The run that is never stopped."""
    return hs.simulate(SCENE)


def test_the_run_has_the_doors_that_are_tried(whole: xr.Dataset, tmp_path: Path) -> None:
    run, count = stopped_at(linking._open.__code__, 0, tmp_path, SCENE)
    assert run is not None
    assert differences(run, whole) == []
    assert 20 <= count <= DOORS + 20


@pytest.mark.parametrize("number", few(range(1, DOORS + 20), 6))
def test_a_signal_at_a_door_waits(number: int, whole: xr.Dataset, tmp_path: Path) -> None:
    """It is served once the machine code has returned; nothing is torn."""
    run, count = stopped_at(linking._open.__code__, number, tmp_path, SCENE)
    if count < number:
        pytest.skip(f"the run opens {count} doors")
    assert run is None or run.attrs["status"] == "interrupted"
    install_signal_handlers()
    again = run_from(tmp_path, SCENE)
    assert again is not None
    assert differences(again, whole) == []


@pytest.mark.filterwarnings("ignore::pytest.PytestUnraisableExceptionWarning")
@pytest.mark.parametrize("number", few(range(1, DOORS + 20), 6))
def test_an_exception_that_is_lost_at_a_door_tears_the_step(
    number: int, whole: xr.Dataset, tmp_path: Path
) -> None:
    """As of a handler of Python's own, in a notebook: machine code finds the door empty."""
    signal.signal(signal.SIGINT, signal.default_int_handler)
    run, count = stopped_at(
        linking._open.__code__, number, tmp_path, SCENE, lambda: signal.raise_signal(signal.SIGINT)
    )
    if count < number:
        pytest.skip(f"the run opens {count} doors")
    assert run is None or run.attrs["status"] == "interrupted"
    again = run_from(tmp_path, SCENE)
    assert again is not None
    assert differences(again, whole) == []


@pytest.mark.parametrize("number", few([1, 7, 50, 200], 2))
def test_a_signal_where_a_function_is_called_waits(number: int, tmp_path: Path) -> None:
    """A function of Python that is called at stages, and before the run."""
    run, count = stopped_at(outside._call_registered.__code__, number, tmp_path, PUSHED)
    assert count >= number
    assert run is None or run.attrs["status"] == "interrupted"
    install_signal_handlers()
    again = run_from(tmp_path, PUSHED)
    assert again is not None
    expected = hs.simulate(PUSHED)
    for name in ("position", "velocity", "force_push"):
        np.testing.assert_array_equal(again[name].values, expected[name].values)


@pytest.mark.parametrize("number", few(range(MOMENTS), 4))
def test_a_signal_at_any_moment(number: int, whole: xr.Dataset, tmp_path: Path) -> None:
    rng = np.random.default_rng(number)
    stops = 0
    for _ in range(3):
        shut_doors()
        install_signal_handlers()
        ended = threading.Event()

        def kill(after: float, ended: threading.Event) -> None:
            if not ended.wait(after):
                os.kill(os.getpid(), int(rng.choice(ENDING_SIGNALS)))

        killer = threading.Thread(target=kill, args=(LATEST * float(rng.random()), ended))
        killer.start()
        run = None
        try:
            run = run_from(tmp_path, SCENE)
            ended.set()
            killer.join()
            time.sleep(0.0)  # a signal that came last is served here
        except KeyboardInterrupt:  # it came as the run returned
            ended.set()
            killer.join()
        stops += run is None or run.attrs["status"] == "interrupted"
        if run is not None and run.attrs["status"] == "complete":
            assert differences(run, whole) == []
    install_signal_handlers()
    again = run_from(tmp_path, SCENE)
    assert again is not None
    assert differences(again, whole) == []


def test_a_signal_of_which_a_library_makes_another_error(monkeypatch: pytest.MonkeyPatch) -> None:
    """As pydantic does while it writes settings: the command is interrupted, and has not failed."""

    def serialise(**_: str) -> None:
        try:
            terminate()
        except KeyboardInterrupt as error:
            raise ValueError("Error calling function") from error

    monkeypatch.setattr("hydrosim.__main__.app", serialise)
    with pytest.raises(SystemExit) as caught:
        main()
    assert caught.value.code == 130
