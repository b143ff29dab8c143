"""Guides: pins in cylinders and cones."""

from dataclasses import replace

import numpy as np
import pytest
from scenes import block, mooring, moving, observed_orders, scene, steady, straight_curve, with_step
from scipy.integrate import solve_ivp

import hydrosim as hs
from hydrosim.elements.contact.landing import AWAY, FREE, INACTIVE, PIN_BESIDE, PIN_PRESSED
from hydrosim.report.evidence import Feature, Kind

MASS, K, G = 1e3, 2e5, 9.81
GAP = 0.1
TABLE = np.array([0.0, 1.0]), np.array([0.0, K])
SEAT = straight_curve(4e5)


def wall_of(slope: float = 0.0, depth: float | None = None) -> hs.Wall:
    """A wall of a stiffness K."""
    return hs.Wall(GAP, compression=TABLE[0], force=TABLE[1], angle=np.arctan(slope), depth=depth)


def pin(wall: hs.Wall, position: dict[str, float], velocity: dict[str, float]) -> hs.Scene:
    """A pin that falls into a guide."""
    dofs = ("surge", "sway", "heave")
    body = block(MASS, dofs, position=moving(**position), velocity=moving(**velocity))
    seats = hs.Seats(np.zeros((1, 3)))
    leg = hs.Landing("block", np.zeros((1, 3)), seats, SEAT, hs.Frictionless(), wall=wall)
    forces = {"leg": leg, "weight": steady(heave=-MASS * G)}
    return scene(body, forces, 2.0, 0.05, step=0.005)


def exact(times: np.ndarray, z: list[float], slope: float) -> np.ndarray:
    """Places (nt, 3) of the same pin, whose events DOP853 finds by ever smaller steps."""

    def rates(t: float, z: np.ndarray) -> np.ndarray:
        r, delta = np.hypot(z[0], z[1]), -z[2]
        f = K * max(r - GAP + slope * delta, 0.0)
        across = f / r if r > 0.0 else 0.0
        up = slope * f + 4e5 * max(delta, 0.0) - MASS * G
        return np.array([*z[3:], -across * z[0] / MASS, -across * z[1] / MASS, up / MASS])

    tight = {"rtol": 1e-12, "atol": 1e-14, "max_step": 1e-3}
    found = solve_ivp(rates, (0.0, times[-1]), z, "DOP853", times, **tight)
    return found.y[:3].T


@pytest.mark.parametrize("slope", [0.0, 0.4])
def test_a_pin_in_a_cylinder_and_in_a_cone_is_that_of_dop853(slope, validated):
    start = {"surge": 0.02, "heave": 0.3}, {"surge": 0.9, "sway": 0.5}
    wall = wall_of(slope)
    steps = np.array([0.01, 0.005, 0.0025])
    runs = [hs.simulate(with_step(pin(wall, *start), step)) for step in steps]
    expected = exact(runs[0].time.values, [0.02, 0.0, 0.3, 0.9, 0.5, 0.0], slope)
    errors = [np.abs(run.position.values[:, 0, :3] - expected).max() for run in runs]
    assert np.all(observed_orders(steps, np.array(errors)) > 3.5)
    claim = "pin in a cylinder and in a cone [m]"
    validated(Kind.INDEPENDENT, claim, "DOP853", errors[-1], 1e-6, Feature.GUIDES)
    assert runs[-1].attrs["energy_residual_relative"] < 1e-6
    assert {FREE, PIN_PRESSED} <= {*np.unique(runs[-1].guide_mode.values)}
    assert runs[-1].guide_clearance.values.min() < -1e-3


def test_a_pin_at_rest_in_a_cone_is_carried_by_its_seat_and_its_wall():
    """Pushed aside: f = P / 1 across, s f along the axis, the seat has the rest."""
    s, P = 0.5, 2e3
    wall = wall_of(s)
    base = pin(wall, {"surge": 0.1, "heave": -0.02}, {})
    forces = {**base.forces, "push": steady(surge=P)}
    run = hs.simulate(replace(base, forces=forces, at_rest=True))
    assert run.guide_force.values == pytest.approx(P, rel=1e-9)
    assert run.fender_normal_force.values == pytest.approx(MASS * G - s * P, rel=1e-9)


def test_a_pin_that_is_pulled_out_pressed_loses_what_the_wall_stored():
    wall = wall_of(0.0, 0.2)
    start = {"surge": 0.05, "heave": 0.1}, {"surge": 2.0, "heave": 2.5}
    run = hs.simulate(with_step(replace(pin(wall, *start), duration=0.4), 5e-4))
    mode = run.guide_mode.values[:, 0]
    assert mode[0] == FREE
    assert mode[-1] == AWAY
    at = (2.5 - np.sqrt(2.5**2 - 2 * G * 0.1)) / G  # it passes the mouth
    w, touch = np.sqrt(K / MASS), 0.05 / 2.0
    stored = 0.5 * MASS * 2.0**2 * np.sin(w * (at - touch)) ** 2
    assert run.energy_dissipated_leg.values[-1] == pytest.approx(stored, rel=1e-6)
    assert run.attrs["energy_residual_relative"] < 1e-6


def test_a_pin_that_comes_down_beside_the_mouth_is_not_taken_in():
    wall = wall_of(0.0, 0.2)
    beside = pin(wall, {"surge": 0.3, "heave": 0.4}, {})
    run = hs.simulate(replace(beside, duration=0.5))
    assert run.guide_mode.values[-1, 0] == PIN_BESIDE
    assert not run.guide_force.values.any()


def test_a_restart_while_a_pin_is_pressed_is_the_run_to_the_bit():
    start = {"surge": 0.02, "heave": 0.3}, {"surge": 0.9, "sway": 0.5}
    whole = pin(wall_of(0.4), *start).with_output(states=True)
    run = hs.simulate(whole)
    times = run.time.values[np.flatnonzero(run.guide_mode.values[:, 0] == PIN_PRESSED)]
    for time in times[[0, len(times) // 2]]:
        rest = replace(whole, initial=hs.Start(run, float(time)), duration=2.0 - float(time))
        again = hs.simulate(rest)
        assert np.array_equal(again.position.values[-1], run.position.values[-1])
        assert again.guide_force.values[-1] == run.guide_force.values[-1]


SWING = 400.0  # N/m: a period of 9.9 s, an amplitude of 1.58 m


def lock(begin: float, until: float | None = None, duration: float = 4.0) -> hs.Scene:
    """A pin that swings on a spring through the middle of a cylinder, whose wall comes and goes."""
    end = None if until is None else hs.When(until)
    leg = hs.Landing(
        "block",
        np.zeros((1, 3)),
        hs.Seats(np.array([[0.0, 0.0, -0.05]])),  # above its seat all the time
        SEAT,
        hs.Frictionless(),
        wall=wall_of(),
        active=hs.Active(hs.When(begin), end),
    )
    swing = mooring(surge=SWING)
    body = block(MASS, ("surge",), velocity=moving(surge=1.0))
    return scene(body, {"leg": leg, "swing": swing}, duration, 0.05, step=0.0025)


def test_a_wall_that_comes_while_the_pin_is_inside_locks_it() -> None:
    begin = 0.05  # the pin is 5 cm from the axis, 5 cm from the wall
    run = hs.simulate(lock(begin))

    def rates(t: float, z: np.ndarray) -> list[float]:
        pressed = max(abs(z[0]) - GAP, 0.0) if t >= begin else 0.0
        return [z[1], (-SWING * z[0] - K * pressed * np.sign(z[0])) / MASS]

    tight = {"rtol": 1e-12, "atol": 1e-14, "max_step": 1e-3}
    found = solve_ivp(rates, (0.0, 4.0), [0.0, 1.0], "DOP853", run.time, **tight)
    assert np.abs(run.position.values[:, 0, 0] - found.y[0]).max() < 1e-6
    assert np.abs(run.position.values[:, 0, 0]).max() < 2.0 * GAP
    assert run.guide_mode.values[0, 0] == INACTIVE
    assert run.attrs["energy_residual_relative"] < 1e-6


def test_a_wall_that_comes_while_the_pin_is_outside_catches_it_as_it_comes_in() -> None:
    run = hs.simulate(lock(1.0, duration=8.0))
    period = 2.0 * np.pi / np.sqrt(SWING / MASS)
    time, x, mode = run.time.values, run.position.values[:, 0, 0], run.guide_mode.values[:, 0]
    outside = (time > 1.0) & (time < 0.45 * period)
    assert np.all(mode[time < 1.0] == INACTIVE)
    assert np.all(mode[outside] == PIN_BESIDE)
    assert not run.guide_force.values[outside].any()
    assert x[outside].min() > GAP
    assert np.abs(x[time > 0.5 * period]).max() < 2.0 * GAP
    assert run.attrs["energy_residual_relative"] < 1e-6


def test_what_a_wall_has_stored_as_it_goes_is_lost() -> None:
    """x = v sin(w t) / w up to the wall, e = v1 sin(w1 t) / w1 - c (1 - cos(w1 t)) on it."""
    until = 0.15
    run = hs.simulate(lock(0.0, until, 0.4))
    w, w1 = np.sqrt(SWING / MASS), np.sqrt((K + SWING) / MASS)
    touch = np.arcsin(GAP * w) / w
    on = w1 * (until - touch)
    e = np.cos(w * touch) * np.sin(on) / w1 - GAP * SWING / (K + SWING) * (1.0 - np.cos(on))
    lost = run.energy_dissipated_leg.values
    assert lost[0] == 0.0
    assert lost[-1] == pytest.approx(0.5 * K * e**2, rel=1e-6)
    assert run.guide_mode.values[-1, 0] == INACTIVE
    assert run.attrs["energy_residual_relative"] < 1e-6


def test_a_restart_before_and_after_a_wall_has_come_is_the_run_to_the_bit() -> None:
    whole = lock(0.05).with_output(states=True)
    run = hs.simulate(whole)
    for time in (0.0, 0.5, 1.0):
        again = hs.simulate(replace(whole, initial=hs.Start(run, time), duration=4.0 - time))
        assert np.array_equal(again.position.values[-1], run.position.values[-1])
