"""An interrupt is served within what takes long, and what there is is kept."""

import signal
import subprocess
import sys

import numpy as np
import pytest
from command_line import heed_signals
from scenes import FLOOR, ROOT, block, moving, on_floor, scene, steady

import hydrosim as hs
from hydrosim.compile.clock import compile_clock
from hydrosim.compile.compile import compile_scene
from hydrosim.compile.compiled import Compiled
from hydrosim.elements import Harmonic, constant
from hydrosim.integrate.loop import advance, count_evaluations
from hydrosim.integrate.record import new_record
from hydrosim.integrate.state import (
    EVALUATIONS,
    EVENTS,
    GRID_POINT,
    GUARD_EVALUATIONS,
    Run,
    new_run,
)
from hydrosim.scene import Method, Scene

SLOW = """
import hydrosim as hs
case = hs.load_case("cases/friction_block/held.yaml", {
    "forces.floor.friction": {"law": "friction_slope", "coefficient": 0.2, "slope": "1e14 N*s/m"},
    "solver": {"method": "dopri5", "step": "1e-5 s"}, "duration": "1e6 s", "output.step": "1000 s"})
run = hs.simulate(case, lambda time, steps: print("at", time, flush=True))
print(run.status, run.time.size, run.solver_steps > 0)
"""


@pytest.mark.slow
def test_steps_far_shorter_than_those_of_the_records() -> None:
    """A thousand seconds in steps of microseconds are one record: ten minutes and more."""
    command = [sys.executable, "-c", SLOW]
    run = subprocess.Popen(
        command, cwd=ROOT, stdout=subprocess.PIPE, text=True, preexec_fn=heed_signals
    )
    assert run.stdout is not None
    while float(run.stdout.readline().split()[1]) == 0.0:  # until it takes steps
        pass
    told = _interrupted(run)
    assert told.splitlines()[-1] == "interrupted 1 True"
    assert run.returncode == 0


def _interrupted(run: subprocess.Popen[str]) -> str:
    """What is printed until the end. One signal in many was seen to get lost, so one is sent every
    ten seconds; the run by itself takes longer than all of them."""
    for _ in range(12):
        run.send_signal(signal.SIGINT)
        try:
            return run.communicate(timeout=10)[0]
        except subprocess.TimeoutExpired:
            continue
    run.kill()
    return run.communicate()[0]


def creeping(damping: float, law: hs.FrictionSlope, method: Method) -> Scene:
    """A block that a damper holds back, or a floor with friction."""
    normal = hs.PrescribedNormal(constant(1e6))
    forces = {
        "push": steady(surge=1e5),
        "damper": hs.LinearMooring("block", np.zeros((6, 6)), np.diag([damping, 0, 0, 0, 0, 0])),
        "floor": hs.Fender("block", np.zeros((1, 3)), FLOOR, normal, law),
    }
    return scene(block(1e8, ("surge",)), forces, 100.0, 1.0, method=method)


@pytest.mark.parametrize(
    ("damping", "slope", "found"),
    [
        (1e15, 1e6, "no step is small enough"),
        (0.0, 1e15, "fender floor 1 changes its mode endlessly"),
    ],
)
def test_steps_that_would_never_end(damping: float, slope: float, found: str) -> None:
    """Explicit steps could be 3e-7 s at most; that is said in seconds, with what can do it."""
    law = hs.FrictionSlope(0.2, slope)
    with pytest.raises(hs.SimulationError, match=rf"{found}.*solver\.method: esdirk4") as caught:
        hs.simulate(creeping(damping, law, Method.DOPRI5))
    assert caught.value.dataset.attrs["status"] == "failed"
    run = hs.simulate(creeping(damping, law, Method.ESDIRK4))
    assert run.attrs["status"] == "complete"
    assert float(run.velocity[-1, 0, 0]) == pytest.approx(1e5 / (damping + slope), rel=1e-5)


@pytest.mark.parametrize("method", Method)
def test_kernels_return_after_a_piece(method: Method) -> None:
    """However a run is cut into calls of the kernels, its numbers are the same; and a call goes on
    for one step and its search for an event, no more."""
    law, length = hs.StickSlip(0.3, 0.2, 1e6, 1e5), Harmonic(1e5, 0.9, 0.0)
    push = hs.AppliedForce("block", (0.0, 0.0, 0.0), {"surge": length})
    forces = {"push": push, "weight": steady(heave=-2e5), "floor": on_floor(1e7, law)}
    body = block(2e4, ("surge", "heave"), position=moving(heave=0.05))
    compiled = compile_scene(scene(body, forces, 3.0, 0.2, method=method, step=0.02))
    whole, cut = (_new(compiled) for _ in range(2))
    advance(10**9, whole)
    advance(0, cut)
    while cut.counters[GRID_POINT] < cut.clock.points:
        before = int(count_evaluations(cut.counters))
        advance(1, cut)
        assert count_evaluations(cut.counters) - before < 20_000
    assert whole.counters[EVENTS] > 5
    assert np.array_equal(whole.record.channels, cut.record.channels)
    assert np.array_equal(whole.counters, cut.counters)


def test_searches_for_events_are_part_of_what_a_call_may_cost() -> None:
    """A call goes on until its evaluations and its looks at margins are as many as it may have. The
    looks of one event can be more than the evaluations of many steps."""
    foot = hs.Fender(
        "block", np.zeros((1, 3)), FLOOR, hs.PrescribedNormal(constant(1e4)), hs.Coulomb(0.3, 0.3)
    )
    push = hs.AppliedForce("block", (0.0, 0.0, 0.0), {"surge": Harmonic(3.2e3, 1.0, 0.0)})
    body = block(1e3, ("surge", "sway"))
    compiled = compile_scene(
        scene(body, {"foot": foot, "push": push}, 9.0, 0.1, method=Method.DOPRI5)
    )
    may = 50
    steps = np.array(_calls(compiled, 1))
    assert steps[:, GUARD_EVALUATIONS].max() > may  # of one step
    calls = np.array(_calls(compiled, may))
    assert calls[:, EVENTS].sum() > 5
    ends = [0]
    count_evaluations = steps[:, EVALUATIONS] + steps[:, GUARD_EVALUATIONS]
    while ends[-1] < len(count_evaluations):
        enough = np.cumsum(count_evaluations[ends[-1] :]) >= may
        ends.append(ends[-1] + (int(enough.argmax()) + 1 if enough.any() else enough.size))
    expected = np.add.reduceat(count_evaluations, ends[:-1])
    np.testing.assert_array_equal(calls[:, EVALUATIONS] + calls[:, GUARD_EVALUATIONS], expected)


def _calls(compiled: Compiled, may: int) -> list[np.ndarray]:
    """What each call counts that may cost so much."""
    run = _new(compiled)
    advance(0, run)
    each = []
    while run.counters[GRID_POINT] < run.clock.points:
        before = run.counters.copy()
        advance(may, run)
        each.append(run.counters - before)
    return each


def _new(compiled: Compiled) -> Run:
    clock, method = compile_clock(compiled), compiled.method
    record = new_record(compiled.model, clock)
    return new_run(clock, compiled.model, method, compiled.first_state(), record)
