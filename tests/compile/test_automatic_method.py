"""`solver: {method: automatic, tolerance: E}`: what is chosen, kept, and how exact it is."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from markers import few
from scenes import in_contact, in_waves, scene_of

import hydrosim as hs
from hydrosim.compile.compile import compile_scene
from hydrosim.errors import InputError
from hydrosim.scene import Kinematics, LinearScenes, Method

CASES = Path(hs.__file__).parents[1] / "cases"
SPECTRUM = hs.Jonswap(significant_height=1.5, peak_period=8.0, peak_enhancement=3.3)
SEA = hs.WaveTrain(SPECTRUM, heading=0.6)


def automatic(scene: hs.Scene, accuracy: float) -> hs.Scene:
    solver = replace(scene.solver, method=Method.AUTOMATIC, accuracy=accuracy)
    return replace(scene, solver=solver)


def stiff(scene: hs.Scene, times: float) -> hs.Scene:
    """The scene with nodes of its interface so many times as stiff."""
    fender = scene.forces["interface"]
    assert isinstance(fender, hs.Fender)
    assert isinstance(fender.friction, hs.StickSlip)
    law = replace(fender.friction, stiffness=times * fender.friction.stiffness)
    return replace(scene, forces={**scene.forces, "interface": replace(fender, friction=law)})


def by_dopri5(scene: hs.Scene, relative: float) -> hs.Scene:
    tolerance = hs.Tolerance(relative, relative, relative / 100)
    return replace(scene, solver=replace(scene.solver, method=Method.DOPRI5, tolerance=tolerance))


def shipped(case: str, duration: float) -> hs.Scene:
    """The beginning of a shipped case, stepped."""
    scene = hs.load_case(CASES / case).scene()
    solver = replace(scene.solver, linear=LinearScenes.STEP)
    return replace(scene, duration=duration, solver=solver).with_output(step=0.5)


def chosen(scene: hs.Scene) -> tuple[Method, float]:
    solver = compile_scene(scene, in_plane=True).scene.solver
    return solver.method, solver.tolerance.relative


def apart(run: xr.Dataset, other: xr.Dataset) -> float:
    """Largest distance over the range of places, and of angles, of any body."""
    places = (each.position.values for each in (run, other))
    ours, theirs = (place.reshape(*place.shape[:2], 2, 3) for place in places)
    ranges = np.maximum(np.ptp(theirs, axis=0).max(axis=2), 1e-6)
    return float((np.abs(ours - theirs).max(axis=(0, 3)) / ranges).max())


@pytest.mark.parametrize("accuracy", [1e-4, 1e-6, 1e-8])
def test_errors_are_within_the_accuracy(accuracy: float, figure) -> None:
    """The moored barge in an oblique sea, against exact propagation, which takes no steps."""
    free = scene_of("base")
    forces = {"mooring": free.forces["mooring"]}
    barge = in_waves(replace(free, forces=forces, duration=300.0), SEA)
    barge = replace(barge, solver=hs.Solver(kinematics=Kinematics.LINEAR)).with_output(step=0.5)
    exact = hs.simulate(barge)
    assert exact.attrs["solver_linear"].startswith("propagated")
    solver = replace(barge.solver, linear=LinearScenes.STEP)
    run = hs.simulate(automatic(replace(barge, solver=solver), accuracy))
    assert run.attrs["solver_steps"] > 0
    error = apart(run, exact)
    figure(f"error of automatic over its tolerance, {accuracy:g}", error / accuracy)
    assert error < accuracy


def test_contacts_within_the_accuracy(figure) -> None:
    """The barge that knocks and sticks, against rk4 at a hundredth of its step."""
    scene = in_contact(30.0)
    fine = hs.simulate(replace(scene, solver=hs.Solver(step=1e-3)))
    run = hs.simulate(automatic(scene, 1e-5))
    assert run.attrs["solver_events"] > 20
    error = apart(run, fine)
    figure("error of automatic through contacts, tolerance 1e-5", error)
    assert error < 1e-5


@pytest.mark.parametrize("accuracy", [1e-6, 1e-8])
def test_slow_paths_and_first_steps_are_within_the_accuracy(accuracy, figure):
    """The mating: its waves follow the slow path of the barge, in rows that are interpolated, and
    the topside begins to turn in steps as long as those of the records."""
    mating = shipped("mating/mating.yaml", 300.0)
    run = hs.simulate(automatic(mating, accuracy))
    error = apart(run, hs.simulate(by_dopri5(mating, accuracy / 100)))
    figure(f"error of automatic in the mating over its tolerance, {accuracy:g}", error / accuracy)
    assert error < accuracy


@pytest.mark.parametrize("accuracy", few((1e-4, 1e-7), 1))
def test_errors_that_nothing_restores_are_within_the_accuracy(accuracy, figure):
    """The sphere turns by more than a round in an hour, free in yaw and without damping there."""
    sphere = shipped("sphere/irregular.yaml", 3600.0).with_output(step=2.0)
    run = hs.simulate(automatic(sphere, accuracy))
    error = apart(run, hs.simulate(by_dopri5(sphere, min(accuracy / 1000, 1e-9))))
    figure(f"error of automatic in an hour over its tolerance, {accuracy:g}", error / accuracy)
    assert error < accuracy
    assert "warnings" not in run.attrs
    assert error < 10.0 * run.attrs["error_relative"]
    assert run.attrs["error_relative"] < accuracy


def test_duration_counts_where_nothing_restores_a_motion() -> None:
    """The barge is free in yaw, not in its plane; the method is the same."""
    scene = automatic(in_contact(10.0), 1e-6)
    hour = replace(scene, duration=3600.0)
    cases = ((scene, False), (hour, False), (hour, True))
    short, long, plane = (compile_scene(case, in_plane) for case, in_plane in cases)
    assert len(plane.scene.bodies[0].dofs) < len(long.scene.bodies[0].dofs)
    tolerances = [each.scene.solver.tolerance.relative for each in (short, long, plane)]
    assert tolerances == pytest.approx([1e-6, 1e-6 / 6.0**1.5, 1e-6])


def test_stiff_nodes_are_implicit() -> None:
    """Nodes 100 times as stiff make explicit steps short; a tight tolerance does in any case."""
    scene = in_contact(10.0)
    assert chosen(automatic(scene, 1e-6)) == (Method.DOPRI5, pytest.approx(1e-6))
    assert chosen(automatic(stiff(scene, 100.0), 1e-6)) == (Method.ESDIRK4, pytest.approx(1e-7))
    assert chosen(automatic(stiff(scene, 100.0), 1e-10))[0] == Method.DOPRI5


def test_the_sea_does_not_count() -> None:
    """All runs of a study have the same method and tolerance, and it is said which."""
    scene = automatic(stiff(in_contact(5.0), 100.0), 1e-4)
    (train,) = scene.environment.waves
    seas = [replace(train, seed=seed, heading=seed / 3) for seed in (1, 2)]
    runs = hs.simulate_many([in_waves(scene, sea) for sea in seas], start=0.0)
    assert runs.attrs["solver_method"] == "esdirk4"
    assert runs.attrs["solver_accuracy"] == 1e-4
    assert runs.attrs["solver_chosen"].startswith("esdirk4 for an error of 0.0001")


def test_a_restart_keeps_the_method() -> None:
    """Its contacts may be others by then; with another accuracy it is chosen anew."""
    first = hs.simulate(automatic(stiff(in_contact(5.0), 100.0), 1e-4))
    assert first.attrs["solver_method"] == "esdirk4"
    later = replace(automatic(in_contact(5.0), 1e-4), initial=hs.Start(first, None))
    kept = hs.simulate(later)
    assert kept.attrs["solver_method"] == "esdirk4"
    assert "as in the run that it starts from" in kept.attrs["solver_chosen"]
    assert chosen(automatic(later, 1e-3))[0] == Method.DOPRI5


def test_it_aims_at_what_is_usual_if_nothing_is_said() -> None:
    scene = in_contact(5.0)
    solver = replace(scene.solver, method=Method.AUTOMATIC)
    assert compile_scene(replace(scene, solver=solver)).scene.solver.accuracy == 1e-4


@pytest.mark.parametrize("accuracy", [-1.0, 0.0, float("nan"), 1e-11, 0.2])
def test_what_is_no_accuracy_is_refused(accuracy: float) -> None:
    """As a case file is: less than roundings leave, or as much as a motion itself."""
    with pytest.raises(InputError, match=r"solver\.accuracy: must be from 1e-10 to 0\.1"):
        compile_scene(automatic(in_contact(1.0), accuracy))


def test_records_may_be_closer_than_the_first_step() -> None:
    """An adaptive method ends its steps at output times, whatever step it begins with."""
    scene = automatic(shipped("sphere/decay.yaml", 4.0), 1e-4).with_output(step=0.04)
    assert scene.output_step < scene.solver.step
    fine = hs.simulate(scene)
    coarse = hs.simulate(scene.with_output(step=0.4))
    assert fine.sizes["time"] == 101
    every, there = fine.position.values[::10], coarse.position.values
    np.testing.assert_allclose(every, there, rtol=0, atol=1e-4)
