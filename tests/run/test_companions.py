"""Each run measures its error against a companion, and says what it found."""

import re
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr
from numpy.typing import ArrayLike
from scenes import block, moving, on_floor, scene, steady, table
from scipy.spatial.transform import Rotation

import hydrosim as hs
from hydrosim.elements import AppliedForce, Frictionless, LinearMooring, StickSlip
from hydrosim.multibody.vectors import rotation_vectors
from hydrosim.results.ledger import REPORTED
from hydrosim.scene import Kinematics, LinearScenes, Method, Scene, Solver, Tolerance

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
    """The error that is said is that of the run, as far as the two have not parted; the bodies come
    down on one leg or the other."""
    scene = bouncing(LEGS, roll=0.1, pitch=0.07)
    run = hs.simulate(scene)
    (said,) = warnings(run)
    found = re.search(r"by more than \S+ from ([\d.]+) s on; rk4 at 0.00125 s gives", said)
    assert found is not None
    wrong = apart(run, hs.simulate(finer(scene, 5.0)))
    assert run.attrs["error_relative"] == pytest.approx(wrong.max(), rel=0.7)
    assert float(found[1]) == pytest.approx(run.time.values[wrong > REPORTED][0], abs=0.26)


def test_errors_of_a_method_of_order_2_are_known() -> None:
    """A ball on a spring and damper: its errors add up, nothing parts."""
    ball = bouncing((0.0, 0.0, 0.0), damping=30.0)
    ball = replace(ball, solver=replace(ball.solver, method=Method.RK2))
    run, near = hs.simulate(ball), hs.simulate(finer(ball, 16.0))
    assert warnings(run)
    assert 0.7 < run.attrs["error_relative"] / apart(run, near).max() < 2.5


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
    assert gap > 10.0 * REPORTED * np.ptp(angles, axis=0).max()
    (said,) = warnings(run)
    assert "the motion of late may be wrong" in said


def test_a_companion_costs_four_fifths_of_its_run() -> None:
    """It makes four steps where the run makes five."""
    run = hs.simulate(hs.load_case(CASES / "reverse_float_over" / "base.yaml"))
    assert not warnings(run)
    ratio = run.attrs["error_evaluations"] / run.attrs["solver_evaluations"]
    assert 0.75 < ratio < 0.85


def test_an_adaptive_companion_costs_less() -> None:
    """Its tolerance is 16 times as large."""
    scene = hs.load_case(CASES / "mating" / "mating.yaml").scene()
    solver = Solver(Method.DOPRI5, tolerance=Tolerance(1e-6, 1e-6, 1e-8))
    run = hs.simulate(replace(scene, duration=100.0, solver=solver))
    ratio = run.attrs["error_evaluations"] / run.attrs["solver_evaluations"]
    assert 0.35 < ratio < 0.75


def swinging(step: float, every: int, duration: float = 20.0, **solver: Any) -> Scene:
    """A body on a spring, without damping, that turns too."""
    body = block(100.0, ("surge", "yaw"), position=moving(surge=1.0, yaw=0.5))
    stiffness = np.diag([400.0, 0.0, 0.0, 0.0, 0.0, 900.0])
    spring = LinearMooring("block", stiffness=stiffness, damping=np.zeros((6, 6)))
    settings = {"step": step, "linear": LinearScenes.STEP, **solver}
    drawn = scene(body, {"spring": spring}, duration=duration, output_step=every * step)
    return replace(drawn, solver=Solver(**settings))


@pytest.mark.parametrize("every", [1, 2, 3, 5, 7, 20])
@pytest.mark.parametrize("method", [Method.RK4, Method.RK2, Method.HEUN])
def test_the_error_of_a_vibration_is_known(method: Method, every: int) -> None:
    """Against a cosine, whatever the output; the last interval is shorter than the others."""
    step = 0.1 if method is Method.RK4 else 0.02
    run = hs.simulate(swinging(step, every, 20.0 + 0.6 * step, method=method))
    error = np.abs(run.position.sel(dof="surge")[:, 0] - np.cos(2.0 * run.time)).max()
    said = run.position_error.sel(body="block", dof="surge")
    assert float(said) == pytest.approx(float(error), rel=0.15)
    assert run.attrs["error_relative"] >= 0.99 * float(said) / 2.0


@pytest.mark.parametrize("method", [Method.DOPRI5, Method.ESDIRK4])
@pytest.mark.parametrize("output", [0.01, 0.05, 0.5, 2.0])
def test_output_times_that_limit_the_steps_hide_no_error(method: Method, output: float) -> None:
    """An adaptive method cannot take longer steps than from one output time to the next, whatever
    its tolerance."""
    tolerance = Tolerance(1e-4, 1e-4, 1e-4)
    run = hs.simulate(swinging(output, 1, method=method, tolerance=tolerance))
    error = float(np.abs(run.position.sel(dof="surge")[:, 0] - np.cos(2.0 * run.time)).max())
    said = float(run.position_error.sel(body="block", dof="surge"))
    assert 0.3 * error < said < 10.0 * error


def test_errors_of_attitudes_are_rotations() -> None:
    """Against matrices, at large angles and across half a turn."""
    rng = np.random.default_rng(1)
    theirs = rng.uniform(-3.0, 3.0, (50, 3))
    turn = Rotation.from_rotvec(rng.normal(0.0, 0.1, (50, 3)))
    attitude = Rotation.from_euler("ZYX", theirs[:, ::-1])
    ours = (turn * attitude).as_euler("ZYX")[:, ::-1]
    about_yaw = Rotation.from_euler("Z", -theirs[:, 2:])
    expected = about_yaw.apply(turn.as_rotvec())
    assert rotation_vectors(ours, theirs) == pytest.approx(expected, abs=1e-12)


def test_what_is_propagated_exactly_measures_nothing() -> None:
    run = hs.simulate(replace(swinging(0.1, 5), solver=Solver(kinematics=Kinematics.LINEAR)))
    assert not [name for name in run.attrs if name.startswith("error_")]
    assert "position_error" not in run


def test_a_run_that_misses_its_accuracy_is_made_again() -> None:
    """The first run of a body that swings for long is not within 1e-7."""
    solver = {"method": Method.AUTOMATIC, "accuracy": 1e-7}
    run = hs.simulate(swinging(0.1, 5, 500.0, **solver))
    error = float(np.abs(run.position.sel(dof="surge")[:, 0] - np.cos(2.0 * run.time)).max())
    assert error / 2.0 < 1e-7
    assert run.attrs["error_relative"] < 1e-7
    # a companion alone takes less; the run before and its companion are in it
    assert run.attrs["error_evaluations"] > 0.8 * run.attrs["solver_evaluations"]
    assert "warnings" not in run.attrs


def test_an_accuracy_that_costs_too_much_is_told(monkeypatch: pytest.MonkeyPatch) -> None:
    """A block that rattles on its legs is another with each tolerance."""
    monkeypatch.setattr("hydrosim.run.error_estimate.FREE_EVALUATIONS", 0)
    scene = bouncing(LEGS, roll=0.1, pitch=0.07)
    solver = replace(scene.solver, method=Method.AUTOMATIC, accuracy=1e-7)
    run = hs.simulate(replace(scene, solver=solver))
    assert "by more than 1e-07 from" in run.attrs["warnings"]
    assert run.attrs["error_evaluations"] < 5.0 * run.attrs["solver_evaluations"]


def test_a_companion_that_fails_gives_way_to_a_finer_one(monkeypatch: pytest.MonkeyPatch) -> None:
    """Coarser steps of a stiff ball are unstable; the limit is not known here."""
    ball = bouncing((0.0, 0.0, 0.0), damping=30.0)
    failing = property(lambda companion: companion.stride.ratio > 1.0)
    monkeypatch.setattr("hydrosim.run.error_estimate.Companion.has_failed", failing)
    run = hs.simulate(ball)
    assert "at 0.0008" in run.attrs["error_companion"] or "at 0.000833" in str(run.attrs)
