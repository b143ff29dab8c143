"""A run that its caller steps is the run that `simulate` makes."""

import pickle
import threading
from collections.abc import Callable
from copy import copy, deepcopy
from dataclasses import replace
from math import nan
from pathlib import Path

import numpy as np
import pytest
from scenes import block, in_contact, mooring, moving, scene, scene_of, with_body

import hydrosim as hs
from hydrosim.compare.dataset import differences
from hydrosim.elements.external import BodyState
from hydrosim.scene import ConvolutionRadiation, LinearScenes, Method, Scene, Solver

SPRING = mooring(surge=1e4)
CONTACT = in_contact(20.0)
SCENES = {
    "base": replace(scene_of("base"), duration=30.0),
    "convolution": with_body(CONTACT, radiation=ConvolutionRadiation(length=10.0)),
    "adaptive": replace(CONTACT, solver=Solver(method=Method.DOPRI5, step=0.05)),
}


def on_spring(duration: float = 2.0, **solver: object) -> Scene:
    """A block on a spring: linear, and so propagated unless steps are asked for."""
    body = block(1e3, ("surge",), velocity=moving(surge=1.0))
    return scene(body, {"spring": SPRING}, duration, 0.05, **solver)


@pytest.mark.parametrize("name", SCENES)
def test_steps_on_the_grid_are_those_of_simulate(name: str) -> None:
    """To the bit, in strides of one and of several steps, and whatever is asked in between."""
    whole = SCENES[name]
    grid = whole.output_step if whole.solver.method.adapts else whole.solver.step
    sim = hs.Simulation(whole)
    stride = 0
    while not sim.ended:
        stride += 1
        ahead = (stride % 4) * grid
        sim.step(min(sim.time + ahead, sim.end) if ahead else None)
        if whole.solver.method.adapts and not sim.ended:  # back on the grid
            sim.step(np.ceil(sim.time / grid + 1e-9) * grid)
        if stride % 3 == 0:
            assert np.isfinite(sim.forces["interface"]["barge"]).all()
        if stride == 10:
            assert sim.result().attrs["status"] == "interrupted"
    assert differences(sim.result(), hs.simulate(whole)) == []


def test_a_time_between_two_steps_is_met_by_a_cut_step() -> None:
    sim = hs.Simulation(CONTACT)
    assert sim.step(3.33) == sim.time == 3.33
    assert sim.step() == pytest.approx(3.4, abs=1e-12)
    apart = np.abs(sim.run().position - hs.simulate(CONTACT).position).max()
    assert 0.0 < apart < 1e-5  # m, the error of the method


@pytest.mark.parametrize("until", [0.5, 1.0, 1e9, nan])
def test_a_time_that_cannot_be_is_refused(until: float) -> None:
    sim = hs.Simulation(on_spring())
    sim.step(1.0)
    with pytest.raises(hs.InputError, match="expected a time after 1 s"):
        sim.step(until)


def test_at_its_end_there_is_nothing_left() -> None:
    sim = hs.Simulation(on_spring())
    sim.run()
    assert sim.ended
    with pytest.raises(hs.InputError, match="at its end, 2 s"):
        sim.step()


def test_state_and_forces_are_those_of_the_record() -> None:
    sim = hs.Simulation(CONTACT)
    sim.step(5.0)
    last = sim.result().isel(time=-1)
    assert float(last.time) == 5.0
    barge = sim.state["barge"]
    np.testing.assert_array_equal(barge.position, last.position.values[0])
    np.testing.assert_array_equal(barge.velocity, last.velocity.values[0])
    for name, wrench in sim.forces.items():
        np.testing.assert_array_equal(wrench["barge"], last[f"force_{name}"].values[0])
    np.testing.assert_array_equal(barge.place(), barge.reference + barge.position[:3])


def test_a_linear_scene_is_stepped() -> None:
    exact = on_spring(linear=LinearScenes.EXACT)
    assert hs.simulate(exact).solver_steps == 0
    assert differences(hs.Simulation(exact).run(), hs.simulate(on_spring())) == []


@pytest.mark.parametrize("name", ["convolution", "adaptive"])
def test_a_checkpoint_goes_on_to_the_bit(name: str, tmp_path: Path) -> None:
    """Also from between two points of the grid."""
    scene = replace(SCENES[name], duration=10.0)
    sim = hs.Simulation(scene)
    sim.step(5.013)
    path = sim.save(tmp_path / "half")
    again = hs.Simulation(scene, checkpoint=path)
    assert again.time == 5.013
    assert differences(again.run(), sim.run()) == []
    with pytest.raises(hs.InputError, match="the case"):
        hs.Simulation(replace(scene, duration=11.0), checkpoint=path)
    with pytest.raises(hs.InputError, match="there is no file"):
        hs.Simulation(scene, checkpoint=tmp_path / "other")


def test_a_run_that_fails_says_what_simulate_says() -> None:
    fast = block(1e3, ("surge",), velocity=moving(surge=1.0))
    torn = scene(fast, {"spring": mooring(surge=1e9)}, 5.0, 0.05)
    with pytest.raises(hs.SimulationError) as told:
        hs.simulate(torn)
    sim = hs.Simulation(torn)
    with pytest.raises(hs.SimulationError, match="blows up") as found:
        sim.run()
    assert str(found.value) == str(told.value)
    assert found.value.dataset.attrs["status"] == "failed"
    with pytest.raises(hs.SimulationError):
        sim.step()


def test_a_thread_besides_is_refused() -> None:
    """It would step the same state at the same time; the run goes on as without it."""
    is_called = threading.Event()
    may_return = threading.Event()
    may_return.set()

    def wait(t: float, state: object) -> list[float]:
        is_called.set()
        may_return.wait(60.0)
        return [0.0] * 6

    sim = hs.Simulation(on_spring(), forces={"it": hs.UserForce("block", wait, "held")})
    may_return.clear()
    thread = threading.Thread(target=sim.run)
    is_called.clear()
    thread.start()
    assert is_called.wait(60.0)
    for use in (sim.step, sim.result, lambda: sim.state, lambda: sim.forces, lambda: sim.save("x")):
        with pytest.raises(hs.InputError, match="in use, by another thread"):
            use()
    may_return.set()
    thread.join(60.0)
    expected = hs.simulate(on_spring(linear=LinearScenes.STEP))
    np.testing.assert_array_equal(sim.result().position, expected.position)


def test_a_simulation_that_its_own_function_steps_is_refused() -> None:
    owner: list[hs.Simulation] = []

    def steps(t: float, state: object) -> list[float]:
        if t > 0.5:
            owner[0].step(t + 0.5)
        return [0.0] * 6

    owner.append(hs.Simulation(on_spring(), forces={"it": hs.UserForce("block", steps)}))
    with pytest.raises(hs.SimulationError, match="the simulation is in use"):
        owner[0].run()


@pytest.mark.parametrize("copied", [copy, deepcopy, pickle.dumps])
def test_a_simulation_cannot_be_copied(copied: Callable[[object], object]) -> None:
    with pytest.raises(hs.InputError, match="Write a checkpoint with save"):
        copied(hs.Simulation(on_spring()))


def test_an_error_is_that_of_its_run_alone() -> None:
    """Two runs share an `UserForce`: one fails, the other goes on, and a third begins."""
    failing = False

    def fails(t: float, state: object) -> list[float]:
        if failing:
            raise ZeroDivisionError("of one run")
        return [0.0] * 6

    for coupling in ("stage", "held"):
        force = {"it": hs.UserForce("block", fails, coupling, repeatable=True)}
        one = hs.Simulation(on_spring(), forces=force)
        other = hs.Simulation(on_spring(), forces=force)
        one.step(1.0)
        failing = True
        with pytest.raises(hs.SimulationError, match="of one run"):
            one.step()
        failing = False
        assert other.run().attrs["status"] == "complete"
        assert hs.simulate(on_spring(), forces=force).attrs["status"] == "complete"
        with pytest.raises(hs.SimulationError, match="of one run"):
            one.step()


def test_a_function_that_may_remember_serves_one_run_at_a_time() -> None:
    """One run after the other may have it, and several forces of one run."""

    def push(t: float, state: object) -> list[float]:
        return [1.0, 0.0, 0.0, 0.0, 0.0, 0.0]

    shared = {name: hs.UserForce("block", push, "held") for name in ("one", "other")}
    assert hs.simulate(on_spring(), forces=shared).attrs["status"] == "complete"
    first = hs.Simulation(on_spring(), forces=shared)
    second = hs.Simulation(on_spring(), forces=shared)
    second.step()
    with pytest.raises(hs.SimulationError, match="another run has called the same function"):
        first.step()
    assert second.run().attrs["status"] == "complete"
    repeatable = {"it": hs.UserForce("block", push, "held", repeatable=True)}
    first = hs.Simulation(on_spring(), forces=repeatable)
    second = hs.Simulation(on_spring(), forces=repeatable)
    second.step()
    first.step()
    np.testing.assert_array_equal(first.run().position, second.run().position)


def test_the_reference_of_a_body_cannot_be_changed() -> None:
    def moves(t: float, state: dict[str, BodyState]) -> list[float]:
        state["block"].reference[0] += 1.0
        return [0.0] * 6

    with pytest.raises(hs.InputError, match="read-only"):
        hs.simulate(on_spring(), forces={"it": hs.UserForce("block", moves)})
    sim = hs.Simulation(on_spring())
    with pytest.raises(ValueError, match="read-only"):
        sim.state["block"].reference[0] = 1.0
