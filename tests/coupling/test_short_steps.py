"""Corners of tables at the ends of steps, but for rounding, beside forces that are extrapolated."""

from dataclasses import replace
from itertools import cycle
from math import cos

import numpy as np
import pytest
from scenes import block, central_force, scene, table

import hydrosim as hs
from hydrosim.elements import LinearMooring, Table
from hydrosim.scene import Active, Method, Scene, Solver, When

PUSH, END = 100.0, 12.0


class SmoothedForce:
    """A force of one newton at most that follows a cosine by a tenth at each call."""

    def __init__(self) -> None:
        self.value = 0.0

    def __call__(self, t: float, state: object) -> list[float]:
        self.value += 0.1 * (cos(3.0 * t) - self.value)
        return [self.value, 0.0, 0.0, 0.0, 0.0, 0.0]


def pushed(step: float, corner: float, method: Method = Method.RK4) -> Scene:
    """A body that is pushed by a force with a corner at this time [s]; it ends at 12 s."""
    force = np.zeros((3, 6))
    force[:2, 0] = PUSH
    push = central_force(**table([0.0, corner, END], force))
    drawn = scene(block(1000.0, ("surge",)), {"push": push}, 2000 * 0.01, step)
    duration = step * round(20.0 / step)
    return replace(drawn, duration=duration, solver=Solver(method=method, step=step))


@pytest.mark.parametrize("method", [Method.RK4, Method.DOPRI5])
@pytest.mark.parametrize("coupling", ["extrapolated", "held"])
@pytest.mark.parametrize(
    ("step", "corner"),
    [(0.00875, 10.5), (0.0125, 10.5), (0.07, 10.5), (0.07, 10.51), (0.1, 10.3), (0.05, 10.5)],
)
def test_a_corner_at_the_end_of_a_step_makes_no_short_step(step, corner, coupling, method):
    """The speed is the push's impulse over the mass; the smoothed force has a thousandth."""
    force = hs.UserForce("block", SmoothedForce(), coupling=coupling)
    run = hs.simulate(pushed(step, corner, method), forces={"smoothed": force})
    speed = PUSH * (corner + 0.5 * (END - corner)) / 1000.0
    assert float(run.velocity[-1, 0, 0]) == pytest.approx(speed, rel=1e-3)
    assert "was continued to" not in run.attrs.get("warnings", "")


@pytest.mark.parametrize("corner", [10.5, 10.3])
@pytest.mark.parametrize("step", [0.1, 0.07, 0.05, 0.0125])
def test_the_times_of_records_are_those_of_the_grid(step: float, corner: float) -> None:
    run = hs.simulate(pushed(step, corner))
    assert run.time.values == pytest.approx(step * np.arange(run.time.size), rel=1e-12)
    assert run.attrs["solver_steps"] <= round(20.0 / step) + 1


def test_a_force_that_is_continued_too_far_is_told() -> None:
    """0 to 1 N at a corner 0.4 s into 2 s: on by 1.6 s at a slope over 0.5 s: 4.2 N."""
    force = hs.UserForce("block", lambda t, _: [float(t > 10.2), 0, 0, 0, 0, 0], "extrapolated")
    run = hs.simulate(pushed(2.0, 10.4), forces={"jumping": force})
    assert "the force of jumping was continued to 4.2 times" in run.attrs["warnings"]
    assert "coupling held" in run.attrs["warnings"]


def test_alternating_forces_are_told_and_held_ones_are_not() -> None:
    """Between 1 and -1 N each quarter of a step: to 7 N. A moment of 1e-10 N m is rounding."""
    corners = 0.0125 + 0.05 * np.arange(20)
    push = central_force(surge=Table(corners, 0.0 * corners))
    cut = scene(block(1000.0, ("surge",)), {"push": push}, 1.0, 0.05)
    for coupling, told in (("held", False), ("extrapolated", True)):
        signs = cycle([1.0, -1.0])

        def alternate(t: float, _: object) -> list[float]:
            sign = next(signs)  # noqa: B023 - called in this turn of the loop
            return [sign, 0.0, 0.0, 1e-10 * (sign > 0.0) * t**9, 0.0, 0.0]

        run = hs.simulate(cut, forces={"it": hs.UserForce("block", alternate, coupling)})
        assert ("it was continued to 7 times" in run.attrs.get("warnings", "")) == told


@pytest.mark.parametrize("before", [1e-7, 1e-13])
def test_an_event_just_before_the_end_of_a_step_is_no_line(before: float) -> None:
    """Where a mooring without stiffness begins to act, motions may jump, and the line begins anew:
    with the value there and that at the end of the step, 1e-7 s later. It is too short."""
    active = Active(When(time=10.5 - before))
    nothing = LinearMooring("block", np.diag([1e-9, *[0.0] * 5]), active=active)
    whole = pushed(0.07, 10.5)
    whole = replace(whole, forces={**whole.forces, "nothing": nothing})
    run = hs.simulate(whole, forces={"it": hs.UserForce("block", SmoothedForce(), "extrapolated")})
    assert run.attrs["solver_events"] == 1
    assert float(run.velocity[-1, 0, 0]) == pytest.approx(1.125, rel=1e-3)
    assert "warnings" not in run.attrs
