"""Times at which joints close, read from the places that they hold, against closed forms."""

from __future__ import annotations

from math import log

import numpy as np
import pytest

import hydrosim as hs
from hydrosim import simulate
from hydrosim.scene import JointResistance, JointType, LinearScenes, Method
from hydrosim.scene.joint import Window

MASS, DAMPING, SPEED = 3.0, 1.2, 2.0


def held_at(pin: hs.Joint, step: float, method: Method) -> float:
    """Where a sliding body that damping slows down is held by a ``pin`` to the earth [m]."""
    damped = JointResistance(damping=DAMPING, velocity=SPEED)
    rail = hs.Joint(JointType.SLIDER, "body", axis=(1.0, 0.0, 0.0), resistances=(damped,))
    scene = hs.Scene(
        "closing",
        4.0,
        (hs.Body("body", MASS, np.eye(3)),),
        joints={"rail": rail, "pin": pin},
        solver=hs.Solver(step=step, method=method, linear=LinearScenes.STEP),
        output_step=0.5,
    )
    run = simulate(scene)
    assert (run.joint_velocity.values[-1] == 0.0).all()
    return float(run.joint_position.values[-1, 0])


def time_of(place: float) -> float:
    """Time at which the body comes by [s]."""
    rate = DAMPING / MASS
    return -log(1.0 - place * rate / SPEED) / rate


@pytest.mark.parametrize("method", [Method.RK4, Method.DOPRI5])
def test_a_window_closes_at_its_speed(method: Method) -> None:
    pin = hs.Joint(JointType.FIXED, "body", window=Window(gap=100.0, speed=0.9))
    found = time_of(held_at(pin, 0.01, method))
    assert found == pytest.approx(MASS / DAMPING * log(SPEED / 0.9), abs=1e-9)


@pytest.mark.parametrize("method", [Method.RK4, Method.DOPRI5])
def test_a_channel_closes_at_its_value(method: Method) -> None:
    active = hs.Active(hs.When(channel="position.body.surge", above=1.7))
    pin = hs.Joint(JointType.FIXED, "body", active=active)
    assert time_of(held_at(pin, 0.01, method)) == pytest.approx(time_of(1.7), abs=1e-9)


def test_a_time_closes_at_that_time() -> None:
    pin = hs.Joint(JointType.FIXED, "body", active=hs.Active(hs.When(1.234567)))
    found = time_of(held_at(pin, 0.01, Method.RK4))
    assert found == pytest.approx(1.234567, abs=1e-9)
