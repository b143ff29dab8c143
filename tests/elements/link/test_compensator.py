"""Compensators: gas springs against an independent integration, heave against closed forms."""

from dataclasses import replace
from math import pi

import numpy as np
import pytest
from modes_apart import Event, integrate
from scenes import block, central_force, moving, observed_orders, scene, steady

import hydrosim as hs
from hydrosim.elements import Compensator, Harmonic, Winch
from hydrosim.elements.line.drum import EMPTY, FAST_IN, FAST_OUT, FULL, PRESCRIBED, delay_factors
from hydrosim.elements.link.gas import IN_STROKE, LOWER, SLACK_PIECE, UPPER
from hydrosim.report.evidence import Feature, Kind

ORIGIN = (0.0, 0.0, 0.0)
MASS = 1e5
WEIGHT = 9.81 * MASS
T0, STROKE, GAS_LENGTH, N, STOP = WEIGHT, 2.0, 1.6, 1.3, 4e6
SWING = 2.0 * pi / 8.0  # rad/s


def on_gas(step: float, start: float = 0.3, speed: float = 0.0, damping: float = 0.0) -> hs.Scene:
    """A weight that hangs on a passive compensator, and starts off its middle."""
    shape = ("block", ORIGIN, (0.0, 0.0, 20.0), 20.0, T0, STROKE, GAS_LENGTH)
    gas = Compensator(*shape, exponent=N, stiffness=STOP, damping=damping)
    body = block(MASS, ("heave",), position=moving(heave=start), velocity=moving(heave=speed))
    forces = {"gas": gas, "weight": steady(heave=-WEIGHT)}
    return scene(body, forces, 8.0, 0.1, step=step)


def gas_force(x: float) -> float:
    """T0 (V0 / V)^n over the extension."""
    return T0 * (GAS_LENGTH / (GAS_LENGTH - x)) ** N


def force(y: np.ndarray, mode: str) -> float:
    x = -y[0]
    if mode == "gas":
        return gas_force(x)
    if mode == "upper":
        return gas_force(1.0) + STOP * (x - 1.0)
    return gas_force(-1.0) + STOP * (x + 1.0) if mode == "lower" else 0.0


LIMITS = {"slack": (-9.0, -1.0 - gas_force(-1.0) / STOP), "gas": (-1.0, 1.0), "upper": (1.0, 9.0)}
LIMITS["lower"] = (LIMITS["slack"][1], -1.0)
ORDER = ["slack", "lower", "gas", "upper"]


def ends_of(mode: str) -> list[Event]:
    low, high = LIMITS[mode]
    k = ORDER.index(mode)
    return [
        (lambda t, y, m: -y[0] - low, lambda t, y: ORDER[k - 1]),
        (lambda t, y, m: high + y[0], lambda t, y: ORDER[k + 1]),
    ]


def rates(t: float, y: np.ndarray, mode: str) -> list[float]:
    return [y[1], force(y, mode) / MASS - 9.81]


@pytest.mark.parametrize(
    ("speed", "seen"), [(0.0, {IN_STROKE}), (-6.0, {SLACK_PIECE, LOWER, IN_STROKE, UPPER})]
)
def test_a_gas_spring_is_that_of_an_independent_integration(speed, seen, figure, validated):
    """Within its stroke, and through stops and slack: to 1e-9 and 1e-8 of the stroke, order 4."""
    steps = (0.01, 0.005, 0.0025)
    runs = [hs.simulate(on_gas(h, speed=speed)) for h in steps]
    exact, modes, _ = integrate(rates, ends_of, "gas", [0.3, speed], runs[0].time.values)
    errors = [np.abs(r.position.values[:, 0, 2] - exact[:, 0]).max() / STROKE for r in runs]
    claim = "weight on a gas spring with stops, of its stroke"
    validated(Kind.INDEPENDENT, claim, "DOP853 by events", errors[-1], 1e-8, Feature.WINCHES)
    figure("order", observed_orders(steps, np.array(errors))[-1])
    assert errors[-1] <= (1e-9 if len(seen) == 1 else 1e-8)
    assert observed_orders(steps, np.array(errors))[-1] >= 3.7
    assert runs[-1].solver_events == len(modes) - 1
    assert {ORDER.index(mode) for mode in modes} == seen
    assert runs[-1].energy_residual_relative <= 1e-8


def test_the_gas_keeps_p_v_to_the_n_and_its_energy() -> None:
    """At 0.4 m: tension and energy of the closed form; slow motion has n = 1, T0 h ln(V0 / V)."""
    run = hs.simulate(on_gas(0.01, start=-0.4)).isel(time=0)
    assert float(run.compensator_tension[0]) == pytest.approx(gas_force(0.4), rel=1e-13)
    ratio = GAS_LENGTH / (GAS_LENGTH - 0.4)
    stored = T0 * GAS_LENGTH / 0.3 * (ratio**0.3 - 1.0)
    assert float(run.energy_stored_gas) == pytest.approx(stored, rel=1e-12)
    slow = on_gas(0.01, start=-0.4)
    gas = replace(slow.forces["gas"], exponent=1.0)  # type: ignore[call-arg]
    run = hs.simulate(replace(slow, forces={**slow.forces, "gas": gas})).isel(time=0)
    assert float(run.energy_stored_gas) == pytest.approx(T0 * GAS_LENGTH * np.log(ratio))


EA, DAMPING, SPAN = 5e8, 0.05, 50.0
SLACK_LENGTH = SPAN / (1.0 + WEIGHT / EA)
STRAIN = WEIGHT / EA


def on_a_vessel(
    amplitude: float,
    control: hs.Compensation,
    duration: float = 40.0,
) -> hs.Scene:
    """A load on a winch under the tip of a heavy vessel, which heaves as its force makes it."""
    shape = ("block", ORIGIN, ORIGIN, EA, SLACK_LENGTH)
    winch = Winch(*shape, compensation=control, damping=DAMPING, anchor_body="vessel")
    heavy = 1e12
    at = {"centre_of_gravity": (0.0, 0.0, 60.0), "points": {"tip": ORIGIN}}
    vessel = block(heavy, ("heave",), "vessel", velocity=moving(heave=amplitude * SWING), **at)
    load = block(MASS, ("heave",), centre_of_gravity=(0.0, 0.0, 60.0 - SPAN))
    drive = Harmonic(-heavy * amplitude * SWING**2, 8.0, WEIGHT)
    heave = central_force("vessel", heave=drive)
    forces = {"winch": winch, "drive": heave, "weight": steady(heave=-WEIGHT)}
    return scene((load, vessel), forces, duration, 0.1, step=0.02)


def test_full_compensation_lets_the_load_stand() -> None:
    """With the whole rise paid out, also for the strain of the wire, the load stands still while
    the vessel heaves by 2 m. With a gain of 1 it moves by the strain of the wire that is paid out,
    0.2 % of the heave."""
    run = hs.simulate(on_a_vessel(2.0, hs.Compensation("tip of vessel", 1.0 / (1.0 + STRAIN))))
    assert np.abs(run.position.values[:, 1, 2]).max() == pytest.approx(2.0, rel=1e-3)
    assert np.abs(run.position.values[:, 0, 2]).max() <= 1e-7
    run = hs.simulate(on_a_vessel(2.0, hs.Compensation("tip of vessel")))
    most = np.abs(run.position.values[:, 0, 2]).max()
    assert most == pytest.approx(2.0 * STRAIN, rel=0.02)


def test_the_delay_turns_phases_alone() -> None:
    """Its transfer function is 1 in size and exp(-i w tau) in phase, to the stated errors."""
    for turn, near in ((1.0, 1e-12), (2.0, 1.5e-9), (pi, 4.3e-7)):
        s = 1j * turn / 0.7
        H = np.prod([(s**2 - a * s + b) / (s**2 + a * s + b) for a, b in delay_factors(0.7)])
        assert abs(abs(H) - 1.0) <= 1e-13
        assert abs(np.angle(H * np.exp(1j * turn))) <= near


@pytest.mark.parametrize(("gain", "delay"), [(0.8, 0.0), (1.0, 0.5), (0.9, 1.2)])
def test_gain_and_delay_against_the_closed_form(gain, delay, validated):
    """1 - gain exp(-i w tau), seen through the wire k = EA / l0, its damping and the load."""
    control = hs.Compensation("tip of vessel", gain / (1.0 + STRAIN), delay)
    run = hs.simulate(on_a_vessel(0.01, control, duration=48.0))
    t = run.time.values
    late = t >= 24.0
    basis = np.stack([np.cos(SWING * t), np.sin(SWING * t), np.ones_like(t)], axis=1)
    fit = np.linalg.lstsq(basis[late], run.position.values[late, :, 2], rcond=None)[0]
    amplitude = fit[0] - 1j * fit[1]
    k = EA / SLACK_LENGTH * (1.0 + 1j * SWING * DAMPING)
    through = k / (k - MASS * SWING**2)
    expected = through * (1.0 - gain * np.exp(-1j * SWING * delay))
    error = abs(amplitude[0] / amplitude[1] - expected)
    claim = "heave of a load under active compensation over that of the vessel"
    against = "1 - gain exp(-i w tau) through the wire"
    validated(Kind.CLOSED_FORM, claim, against, error, 1e-8, Feature.WINCHES)


def test_limits_of_speed_and_stroke_are_kept_as_events() -> None:
    """A heave of 2 m needs 1.6 m/s: at 1 m/s the drum lags and catches up; with a stroke of 2.4 m
    it stands at its ends. A restart from there goes on to the bit, delay included."""
    control = hs.Compensation("tip of vessel", 1.0, 0.4, 1.0, stroke=2.4)
    whole = on_a_vessel(2.0, control, duration=16.0).with_output(states=True)
    run = hs.simulate(whole)
    mode = run.winch_mode.values[:, 0]
    assert {*np.unique(mode)} == {PRESCRIBED, FAST_OUT, FAST_IN, EMPTY, FULL}
    assert np.abs(run.winch_speed.values).max() <= 1.0 + 1e-9
    assert np.abs(run.winch_length.values - SLACK_LENGTH).max() <= 1.2 + 1e-9
    assert run.energy_residual_relative <= 1e-5
    for time in (3.0, 7.3):
        after = hs.simulate(replace(whole, duration=16.0 - time, initial=hs.Start(run, time)))
        np.testing.assert_array_equal(after.state_value[-1], run.state_value[-1])
