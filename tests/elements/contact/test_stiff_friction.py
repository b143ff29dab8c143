"""Steep friction slopes and stiff steel with the implicit method at large steps."""

from dataclasses import replace

import numpy as np
import pytest
import scenes
from scipy.integrate import solve_ivp

import hydrosim as hs
from hydrosim.elements import Harmonic, constant
from hydrosim.report.evidence import Feature, Kind
from hydrosim.scene import Method, Scene, Tolerance

MASS, GRIP, PUSH, PERIOD = 1.945e8, 2e5, 4e5, 100.0


def sliding(slope: float, step: float, method: Method = Method.ESDIRK4) -> Scene:
    """A block of the barge's mass, pushed to and fro on a friction slope."""
    normal = hs.PrescribedNormal(constant(GRIP / 0.2))
    floor = scenes.foot(normal, hs.FrictionSlope(0.2, slope))
    forces = {"push": scenes.central_force(surge=Harmonic(PUSH, PERIOD)), "floor": floor}
    return scenes.scene(
        scenes.block(MASS, ("surge",)), forces, 200.0, 1.0, step=step, method=method
    )


def exact(slope: float, times: np.ndarray) -> np.ndarray:
    """x, x' (nt, 2) by scipy's Radau, which walks over the corners in small steps."""

    def rates(t: float, y: np.ndarray) -> list[float]:
        push = PUSH * np.sin(2 * np.pi * t / PERIOD)
        return [y[1], (push - np.clip(slope * y[1], -GRIP, GRIP)) / MASS]

    tight = {"rtol": 1e-9, "atol": 1e-13, "max_step": 0.5}
    return solve_ivp(rates, (0.0, times[-1]), [0.0, 0.0], "Radau", t_eval=times, **tight).y.T


@pytest.mark.parametrize("slope", [1e8, 1e10, 1e12])
def test_steep_slopes_at_a_tenth_of_a_second(slope, figure, validated):
    """h b / m reaches 500: no oscillation, and the creep v = F / b of stick is there."""
    run = hs.simulate(sliding(slope, 0.1))
    wanted = exact(slope, run.time.values)
    error = np.abs(scenes.surge(run) - wanted[:, 0]).max() / np.ptp(wanted[:, 0])
    claim = "block under friction slopes up to 1e12 N s/m at 0.1 s, of its range"
    features = (Feature.SLOPE, Feature.IMPLICIT)
    # order 4 at slack slopes; stages of order 2 where h b / m is about 5
    validated(Kind.INDEPENDENT, claim, "scipy's Radau", error, 1e-4, *features)
    creeping = np.abs(wanted[:, 1]) < 0.99 * GRIP / slope
    assert creeping.sum() >= 8  # the push is below the grip for a twelfth of the first period
    speed = run.velocity.values[creeping, 0, 0]
    figure(f"creep error at {slope:g}", np.abs(speed - wanted[creeping, 1]).max() * slope / GRIP)
    assert np.abs(speed - wanted[creeping, 1]).max() < 2e-3 * GRIP / slope


def test_an_explicit_method_oscillates_there() -> None:
    """What the implicit one is for: rk2 beyond its limit, b h / m > 2, alternates in stick."""
    run = hs.simulate(sliding(5e9, 0.1, Method.RK2))
    wanted = exact(5e9, run.time.values)
    creeping = np.abs(wanted[:, 1]) < 0.99 * GRIP / 5e9
    speed = run.velocity.values[creeping, 0, 0]
    assert np.abs(speed - wanted[creeping, 1]).max() > 0.1 * GRIP / 5e9


@pytest.mark.parametrize("stiffness", [1e10, 1e12])
def test_stiff_steel_settles(stiffness: float, figure) -> None:
    """A damped contact whose period is far below the step: it rests where weight meets spring."""
    body = scenes.block(1e6, ("heave",), position=scenes.moving(heave=-2e7 / stiffness))
    forces = {
        "weight": scenes.steady(heave=-1e7),
        "floor": scenes.on_floor(stiffness, hs.Frictionless()),
        "damper": hs.LinearMooring("block", np.zeros((6, 6)), np.diag([0, 0, 2e8, 0, 0, 0])),
    }
    run = hs.simulate(scenes.scene(body, forces, 5.0, 0.1, step=0.1, method=Method.ESDIRK4))
    rest = np.abs(scenes.heave(run)[-10:] * stiffness / 1e7 + 1.0).max()
    figure(f"off its rest at {stiffness:g}", rest)
    assert rest < 1e-6


LEGS = np.array([[x, y, -5.0] for x in (20.0, -20.0) for y in (15.0, -15.0)])


def dropped(stiffness: float, damping: float, **solver: object) -> Scene:
    """A topside of 20,000 t that falls 0.3 m on its four legs, one after the other."""
    curve = scenes.straight_curve(stiffness, damping)
    place = scenes.moving(heave=5.3, pitch=0.002, roll=0.001)
    legs = hs.Fender("block", LEGS, scenes.FLOOR, curve, hs.Frictionless())
    forces = {"weight": scenes.steady(heave=-9.81 * 2e7), "legs": legs}
    body = scenes.block(2e7, ("heave", "pitch", "roll"), position=place)
    return scenes.scene(body, forces, 5.0, 0.1, **solver)


@pytest.mark.parametrize("method", [Method.DOPRI5, Method.ESDIRK4])
def test_a_drop_on_stiff_steel_at_the_default_tolerance(method: Method, figure) -> None:
    """Legs of 1e11 N/m ring with 140 rad/s; neither method is told. Against dopri5 at 1e-11."""
    tight = Tolerance(1e-11, 1e-11, 1e-13)
    exact = hs.simulate(dropped(1e11, 1e8, method=Method.DOPRI5, tolerance=tight))
    for step in (0.1, 0.01):
        run = hs.simulate(dropped(1e11, 1e8, method=method, step=step))
        apart = np.abs(run.position - exact.position).max("time")
        span = exact.position.max("time") - exact.position.min("time")
        error = float((apart / span.where(span > 0.0)).max())
        figure(f"error over the range, first step {step:g} s", error)
        assert error < 1e-3
        assert run.solver_events == exact.solver_events


@pytest.mark.slow
def test_a_node_hundreds_of_times_as_stiff(figure) -> None:
    """K2 is 300 times that of the base case: the node breaks away at a stretch of 1e-5 m, and is
    tolerated by the friction that its error makes, not in metres. Both methods see the same."""
    stiff = {"forces.interface.friction.stiffness": 1.7e11, "duration": 560}
    base = hs.load_case("cases/reverse_float_over/base.yaml", stiff).scene()
    runs = []
    for method, tolerance in (
        (Method.DOPRI5, Tolerance()),
        (Method.ESDIRK4, Tolerance()),
        (Method.ESDIRK4, Tolerance(1e-8, 1e-8, 1e-10)),
    ):
        solver = replace(base.solver, method=method, tolerance=tolerance)
        runs.append(hs.simulate(replace(base, solver=solver)))
    fine = runs.pop()
    for run in runs:
        error = np.abs(scenes.surge(run) - scenes.surge(fine)).max() / np.ptp(scenes.surge(fine))
        figure(f"error over the range of {run.solver_method}", error)
        assert run.solver_events == fine.solver_events
        assert error < 1e-4
    assert fine.solver_events == 6


def test_without_events_a_slope_saturates_at_every_evaluation() -> None:
    """By rk2 with long steps: as a plain loop that takes the smaller of both forces."""
    mass, grip, slope, push, h = 1e6, 2e5, 1e6, 4e5, 0.5
    normal = hs.PrescribedNormal(constant(grip / 0.2))
    floor = scenes.foot(normal, hs.FrictionSlope(0.2, slope))
    forces = {"push": scenes.central_force(surge=Harmonic(push, 10.0)), "floor": floor}
    made = scenes.scene(
        scenes.block(mass, ("surge",)), forces, 60.0, h, step=h, method=Method.RK2, events=False
    )
    run = hs.simulate(made)

    def rates(t: float, y: np.ndarray) -> np.ndarray:
        friction = np.clip(slope * y[1], -grip, grip)
        return np.array([y[1], (push * np.sin(0.2 * np.pi * t) - friction) / mass])

    plain = [np.zeros(2)]
    for t in run.time.values[:-1]:
        middle = plain[-1] + 0.5 * h * rates(t, plain[-1])
        plain.append(plain[-1] + h * rates(t + 0.5 * h, middle))
    motion = np.array(plain)
    np.testing.assert_allclose(scenes.surge(run), motion[:, 0], atol=1e-12 * np.ptp(motion[:, 0]))
    assert np.abs(run.force_floor.values[:, 0, 0]).max() <= grip * (1.0 + 1e-12)
    fast = np.abs(motion[:, 1]) > 1.1 * grip / slope
    assert 10 < fast.sum() < fast.size - 10
