"""A run that its caller steps is the run that `simulate` makes."""

from __future__ import annotations

from dataclasses import replace
from math import nan
from pathlib import Path

import numpy as np
import pytest
from dry_scenes import block, moving, scene
from moored_barge import in_contact, scene_of, with_body

import hydrosim as hs
from hydrosim.compare.exact import differences
from hydrosim.forces import LinearMooring
from hydrosim.scene import ConvolutionRadiation, LinearScenes, Method, Scene, Solver

SPRING = LinearMooring("block", np.diag([1e4, 0.0, 0.0, 0.0, 0.0, 0.0]))
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
    torn = scene(
        block(1e3, ("surge",), velocity=moving(surge=1.0)),
        {"spring": LinearMooring("block", np.diag([1e9, 0.0, 0.0, 0.0, 0.0, 0.0]))},
        5.0,
        0.05,
    )
    with pytest.raises(hs.SimulationError) as told:
        hs.simulate(torn)
    sim = hs.Simulation(torn)
    with pytest.raises(hs.SimulationError, match="blows up") as found:
        sim.run()
    assert str(found.value) == str(told.value)
    assert found.value.dataset.attrs["status"] == "failed"
    with pytest.raises(hs.SimulationError):
        sim.step()
