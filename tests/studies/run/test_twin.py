"""Runs that finer steps would change are told, with by how much."""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from dry_scenes import block, moving, on_floor, scene, steady, table
from numpy.typing import ArrayLike

import hydrosim as hs
from hydrosim.forces import AppliedForce, Frictionless, StickSlip
from hydrosim.scene import Method, Scene, Tolerance
from hydrosim.studies.run import paths
from hydrosim.studies.run.twin import FIRST, SHARE, WRONG

CASES = Path(hs.__file__).parents[1] / "cases"
LEGS = [(x, y, -0.5) for x in (-1.0, 1.0) for y in (-0.7, 0.7)]
WARNED = "of its range by"


def bouncing(points: ArrayLike, damping: float = 0.0, **start: float) -> Scene:
    """A block of 100 kg that falls on stiff legs, without friction."""
    floor = on_floor(2e5, Frictionless(), points=np.atleast_2d(points).tolist())
    curve = replace(floor.normal, damping=damping)
    body = block(100.0, position=moving(heave=1.0, **start))
    forces = {"floor": replace(floor, normal=curve), "weight": steady(heave=-981.0)}
    return scene(body, forces, duration=20.0, output_step=0.05, step=0.001)


def warnings(run: xr.Dataset) -> list[str]:
    return [x for x in str(run.attrs.get("warnings", "")).splitlines() if WARNED in x]


def finer(scene: Scene, times: float) -> Scene:
    return replace(scene, solver=replace(scene.solver, step=scene.solver.step / times))


def apart(one: xr.Dataset, other: xr.Dataset) -> np.ndarray:
    """Distances (nt,) over the range of places, and of angles."""
    both = [run.position.values[:, 0].reshape(-1, 2, 3) for run in (one, other)]
    ranges = np.maximum(np.ptp(both[0], axis=0).max(axis=1), 1e-6)
    return (np.abs(both[1] - both[0]).max(axis=2) / ranges).max(axis=1)


def test_a_block_that_rattles_on_its_legs() -> None:
    """It is said how far it is from the run with the step that is named, and from when on; the
    bodies come down on one leg or the other."""
    scene = bouncing(LEGS, roll=0.1, pitch=0.07)
    run = hs.simulate(scene)
    (said,) = warnings(run)
    found = re.search(
        r"by (\S+) of its range by ([\d.]+) s, .* from ([\d.]+) s .*step: ([\d.]+) s gives", said
    )
    assert found is not None
    step = scene.output_step / round(scene.output_step / float(found[4]))
    times = scene.solver.step / step
    wrong = apart(run, hs.simulate(finer(scene, times))) / (1.0 - times**-4)
    until = run.time.values <= float(found[2]) + 1e-9
    assert float(found[1]) == pytest.approx(min(wrong[until].max(), 1.0), rel=0.5)  # one digit
    assert float(found[3]) == pytest.approx(run.time.values[wrong > WRONG][0], abs=0.051)


def test_errors_of_a_method_of_order_2_are_known() -> None:
    """A ball on a spring and damper: its errors add up, nothing parts."""
    ball = bouncing((0.0, 0.0, 0.0), damping=30.0)
    ball = replace(ball, solver=replace(ball.solver, method=Method.RK2))
    run, near = hs.simulate(ball), hs.simulate(finer(ball, 16.0))
    (said,) = warnings(run)
    found = re.search(r"by (\S+) of its range", said)
    assert found is not None
    assert float(found[1]) == pytest.approx(apart(run, near).max(), rel=0.5)  # one digit, order 2


def test_a_ball_that_bounces_is_known() -> None:
    """Errors of an elastic ball grow by as much in every bounce: not for ever more."""
    run = hs.simulate(bouncing((0.0, 0.0, 0.0)))
    assert run.attrs["solver_events"] > 20
    assert not warnings(run)


def test_a_block_that_comes_to_rest_is_known() -> None:
    start = {"roll": 0.1, "pitch": 0.07}
    run = hs.simulate(bouncing(LEGS, damping=3e3, **start))
    assert run.attrs["solver_events"] > 20
    assert not warnings(run)


def test_other_steps_are_no_parting() -> None:
    """With an adaptive method the twin has a tighter tolerance; what comes to rest is the same."""
    calm = bouncing(LEGS, damping=3e3, roll=0.1, pitch=0.07)
    loose = Tolerance(relative=1e-4, position=1e-4)
    solver = replace(calm.solver, method=Method.DOPRI5, tolerance=loose)
    assert not warnings(hs.simulate(replace(calm, solver=solver)))


def test_what_slides_and_sticks_is_known() -> None:
    law = StickSlip(0.3, 0.2, 1e5, 300.0)
    held = on_floor(1e5, law, points=LEGS)
    body = block(100.0, position=moving(heave=0.5 - 981.0 / 4e5))
    forces = {"floor": held, "weight": steady(heave=-981.0), "push": steady(surge=300.0)}
    run = hs.simulate(scene(body, forces, duration=10.0, output_step=0.05, step=0.001))
    assert not warnings(run)


def with_a_late_fall() -> Scene:
    """A ball that bounces all the time, and a block that hangs until it falls on its legs."""
    ball = bouncing((0.0, 0.0, 0.0))
    duration = 3.0 * ball.duration
    legs = replace(bouncing(LEGS, roll=0.1, pitch=0.07).forces["floor"], body="late")
    weight = np.zeros((4, 6))
    weight[2:, 2] = -981.0
    fall = 0.5 * duration
    times = [0.0, fall, fall + 0.01, 2.0 * duration]
    carried = AppliedForce("late", (0.0, 0.0, 0.0), table(times, weight))
    start = moving(heave=1.0, roll=0.1, pitch=0.07)
    bodies = (*ball.bodies, block(100.0, name="late", position=start))
    forces = {**ball.forces, "legs": legs, "late weight": carried}
    return replace(ball, bodies=bodies, forces=forces, duration=duration)


def test_what_rattles_late_is_told() -> None:
    """The beginning is that of a ball whose errors hardly grow; a run with finer steps shows that
    the block is wrong."""
    scene = with_a_late_fall()
    run = hs.simulate(scene)
    other = hs.simulate(finer(scene, 4.0))
    angles = run.position.values[:, 1, 3:]
    gap = np.abs(angles - other.position.values[:, 1, 3:]).max()
    assert gap > 10.0 * WRONG * np.ptp(angles, axis=0).max()
    (said,) = warnings(run)
    assert "the motion of late may be wrong" in said


def test_a_nearby_path_that_fails_at_once_says_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    """Before the first record after its own."""
    gaps = paths.Path.gaps
    monkeypatch.setattr(paths.Path, "gaps", lambda path: gaps(path)[:1])
    monkeypatch.setattr("hydrosim.studies.run.twin.FIRST", 20_000)
    run = hs.simulate(with_a_late_fall())
    assert run.attrs["status"] == "complete"


def test_a_look_at_late_changes_costs_its_share() -> None:
    """Damped contacts part nothing: the estimate takes what is granted, and no more."""
    run = hs.simulate(hs.load_case(CASES / "reverse_float_over" / "base.yaml"))
    assert not warnings(run)
    granted = max(FIRST, SHARE * run.attrs["solver_evaluations"])
    assert 0.9 * granted < run.attrs["twin_evaluations"] < 1.05 * granted


def test_what_would_cost_little_is_followed_to_the_end() -> None:
    run = hs.simulate(replace(bouncing((0.0, 0.0, 0.0)), duration=10.0))
    ratio = run.attrs["twin_evaluations"] / run.attrs["solver_evaluations"]
    assert 1.2 < ratio < 1.5


def test_an_error_beyond_the_accuracy_is_said() -> None:
    """A block that rattles on its legs is another with each tolerance."""
    scene = bouncing(LEGS, roll=0.1, pitch=0.07)
    solver = replace(scene.solver, method=Method.AUTOMATIC, accuracy=1e-7)
    run = hs.simulate(replace(scene, solver=solver))
    assert "by more than 1e-07 from" in run.attrs["warnings"]
    assert "solver.tolerance: 2.5e-08" in run.attrs["warnings"]
