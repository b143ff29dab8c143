"""Steep friction slopes and stiff steel with the implicit method at large steps."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from dry_scenes import FLOOR, block, heave, moving, on_floor, scene, steady, surge
from scipy.integrate import solve_ivp

import hydrosim as hs
from hydrosim.forces import (
    AppliedForce,
    Fender,
    Frictionless,
    FrictionSlope,
    Harmonic,
    LinearMooring,
    PrescribedNormal,
    constant,
)
from hydrosim.scene import Method, Scene

Figure = Callable[[str, float], None]
MASS, GRIP, PUSH, PERIOD = 1.945e8, 2e5, 4e5, 100.0


def sliding(slope: float, step: float, method: Method = Method.ESDIRK4) -> Scene:
    """A block of the barge's mass, pushed to and fro on a friction slope."""
    normal = PrescribedNormal(constant(GRIP / 0.2))
    forces = {
        "push": AppliedForce("block", (0, 0, 0), {"surge": Harmonic(PUSH, PERIOD)}),
        "floor": Fender("block", np.zeros((1, 3)), FLOOR, normal, FrictionSlope(0.2, slope)),
    }
    return scene(block(MASS, ("surge",)), forces, 200.0, 1.0, step=step, method=method)


def exact(slope: float, times: np.ndarray) -> np.ndarray:
    """x, x' (nt, 2) by scipy's Radau, which walks over the corners in small steps."""

    def rates(t: float, y: np.ndarray) -> list[float]:
        push = PUSH * np.sin(2 * np.pi * t / PERIOD)
        return [y[1], (push - np.clip(slope * y[1], -GRIP, GRIP)) / MASS]

    tight = {"rtol": 1e-9, "atol": 1e-13, "max_step": 0.5}
    return solve_ivp(rates, (0.0, times[-1]), [0.0, 0.0], "Radau", t_eval=times, **tight).y.T


@pytest.mark.parametrize("slope", [1e8, 1e10, 1e12])
def test_steep_slopes_at_a_tenth_of_a_second(slope: float, figure: Figure) -> None:
    """h b / m reaches 500: no oscillation, and the creep v = F / b of stick is there."""
    run = hs.simulate(sliding(slope, 0.1))
    wanted = exact(slope, run.time.values)
    error = np.abs(surge(run) - wanted[:, 0]).max() / np.ptp(wanted[:, 0])
    figure(f"error over the range at {slope:g}", error)
    assert error < 1e-4  # order 4 at slack slopes; stages of order 2 where h b / m is about 5
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
def test_stiff_steel_settles(stiffness: float, figure: Figure) -> None:
    """A damped contact whose period is far below the step: it rests where weight meets spring."""
    body = block(1e6, ("heave",), position=moving(heave=-2e7 / stiffness))
    forces = {
        "weight": steady(heave=-1e7),
        "floor": on_floor(stiffness, Frictionless()),
        "damper": LinearMooring("block", np.zeros((6, 6)), np.diag([0, 0, 2e8, 0, 0, 0])),
    }
    run = hs.simulate(scene(body, forces, 5.0, 0.1, step=0.1, method=Method.ESDIRK4))
    rest = np.abs(heave(run)[-10:] * stiffness / 1e7 + 1.0).max()
    figure(f"off its rest at {stiffness:g}", rest)
    assert rest < 1e-6
