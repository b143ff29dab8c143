"""Corners of tables, and conditions of time, that are equal to ends of steps but for rounding."""

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from scenes import block, central_force, moving, observed_orders, scene, steady
from scipy.integrate import solve_ivp

import hydrosim as hs
from hydrosim.compile.clock import compile_clock
from hydrosim.compile.compile import compile_scene
from hydrosim.elements import LinearMooring, Spring, Table
from hydrosim.integrate.state import align_corners, merge_breakpoints
from hydrosim.scene import Active, Method, Scene, When

MASS = 1e3
STIFFNESS = 2e3
DAMPING = 5e3
LENGTH = 4.0
ANCHOR = 6.0
STEADY = -3e3  # N
ROUND_TIMES = [(0.07, 10.5), (0.00875, 3.5), (0.1, 1.7), (0.1, 3.5), (0.06, 3.24), (0.03, 1.35)]
"""Steps and corners [s]. The point of the grid is behind the corner by rounding, thrice, at it, and
before it, twice."""


def pushed(step: float, corner: float, duration: float, **solver: object) -> Scene:
    """A block on a damped line, pushed by two tables, moored from the ``corner`` for 0.5 s."""
    times = np.array([0.0, corner, corner + 0.31])
    force = np.array([-3e3, -3e3, -4e3])
    push = central_force(surge=Table(times, force))
    again = replace(push, force={"surge": Table(np.nextafter(times, np.inf), force)})
    line = paid_line(corner)
    until = Active(When(time=corner), When(time=corner + 0.5))
    moored = LinearMooring("block", np.diag([1e3, *[0.0] * 5]), active=until)
    forces = {"push": push, "again": again, "line": line, "moored": moored}
    return scene(block(MASS, ("surge",)), forces, duration, step, **solver)


def paid_line(corner: float) -> Spring:
    """A taut line, heaved in at 0.2 m/s until the ``corner``, then paid out at 0.3 m/s."""
    times = np.array([corner - 1.0, corner, corner + 10.0])
    length = Table(np.maximum(times, 0.0), LENGTH + np.array([0.2, 0.0, 3.0]))
    curve = np.array([0.0, 99.0]), np.array([0.0, 99.0 * STIFFNESS])
    return Spring(
        "block",
        (0.0, 0.0, 0.0),
        (ANCHOR, 0.0, 0.0),
        length,
        curve=hs.TensionCurve(*curve),
        damping=DAMPING,
    )


@pytest.mark.parametrize("method", [Method.RK4, Method.DOPRI5, Method.ESDIRK4])
@pytest.mark.parametrize(("step", "corner"), ROUND_TIMES)
def test_no_step_is_as_short_as_rounding(method: Method, step: float, corner: float) -> None:
    times: list[float] = []

    def watch(t: float, state: object) -> np.ndarray:
        times.append(t)
        return np.zeros(6)

    whole = pushed(step, corner, step * round((corner + 0.7) / step), method=method)
    run = hs.simulate(whole, forces={"watch": hs.UserForce("block", watch, "held")})
    assert run.solver_events == 2
    assert min(b - a for a, b in pairwise(times)) > 1e-6 * step
    assert np.abs(np.array(times) - corner).min() < 1e-9 * step
    assert np.abs(np.array(times) - corner - 0.31).min() < 1e-9 * step


@pytest.mark.parametrize(("step", "corner"), ROUND_TIMES)
def test_corners_are_points_of_the_grid(step: float, corner: float) -> None:
    compiled = compile_scene(pushed(step, corner, step * round((corner + 11.0) / step)))
    clock = compile_clock(compiled)
    raw = clock.breakpoints
    clock = clock._replace(breakpoints=merge_breakpoints(clock))
    point = round(corner / step) * step
    assert point in clock.breakpoints
    assert np.diff(clock.breakpoints).min() > 0.1
    elements = align_corners(compiled.model, clock).elements
    for pieces in (elements.applied_forces.pieces, elements.link_table.pieces):
        assert np.isin(pieces["start"], [0.0, *clock.breakpoints]).all()
    assert align_corners(compiled.model, clock._replace(breakpoints=raw[:0])) is compiled.model


def paid_out(corner: float, end: float) -> np.ndarray:
    """Position and velocity at the ``end`` of the block on the line, by DOP853 piece by piece."""

    def motion(t: float, y: np.ndarray, speed: float) -> list[float]:
        stretch = ANCHOR - y[0] - LENGTH - speed * (t - corner) - (0.2 if speed == 0.0 else 0.0)
        pull = STIFFNESS * stretch - DAMPING * (y[1] + speed)
        return [y[1], (pull + STEADY) / MASS]

    y = np.zeros(2)
    heaved = corner - 1.0
    for begin, stop, speed in ((0.0, heaved, 0.0), (heaved, corner, -0.2), (corner, end, 0.3)):
        span = (begin, stop)
        y = solve_ivp(motion, span, y, "DOP853", args=(speed,), rtol=1e-12, atol=1e-13).y[:, -1]
    return y


@pytest.mark.parametrize(("step", "corner", "side"), [(0.07, 10.5, 1.0), (0.06, 3.24, -1.0)])
def test_a_rate_that_jumps_at_the_end_of_a_step_keeps_the_order(step, corner, side, figure):
    """Damping sees the line's speed jump; grid points are behind or before it by rounding."""
    steps = [step, step / 2.0]
    assert [np.sign(round(corner / step) * step - corner) for step in steps] == [side, side]
    end = step * round((corner + 0.7) / step)
    forces = {"line": paid_line(corner), "pull": steady(surge=STEADY)}
    found = []
    for step in steps:
        run = hs.simulate(scene(block(MASS, ("surge",)), forces, end, step))
        motion = [run.position.values[-1, 0, 0], run.velocity.values[-1, 0, 0]]
        assert run.solver_events == 0
        found.append(np.abs(motion - paid_out(corner, end)).max())
    order = float(observed_orders(steps, np.array(found))[0])
    figure(f"order, {corner}", order)
    assert order == pytest.approx(4.0, abs=0.3)
    assert found[0] < 1e-5


def test_a_run_by_steps_ends_at_corners_that_are_named() -> None:
    """A time that differs from a corner off the grid by rounding is that corner."""
    corner = 1.234
    sim = hs.Simulation(pushed(0.1, corner, 2.0))
    assert sim.step(np.nextafter(corner, 0.0)) == corner
    body = block(MASS, ("surge",), velocity=moving(surge=1.0))
    free = hs.Simulation(scene(body, {}, 2.0, 0.1))
    assert free.step(np.nextafter(corner, 0.0)) < corner
